"""Results of two methods on pairs of bars, made by hand, and a study of them with votes, for tests of the researcher's side."""

from annotation.design.designing import Design, create_design
from annotation.records import Practice, Proposal, Run
from annotation.results.proposals import shape_item
from annotation.storage.blobs import keep_shapes
from annotation.study import record_vote
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from gui.main_window import MainWindow


def sides(shape):
    """What a study says of a shape as an input."""
    return {"file": f"{shape.mesh.name}.off", "sha256": mesh_id(shape.mesh), "segments": shape.segmentation.count,
            "faces": len(shape.mesh.faces)}  # fmt: skip


def run_of(first, second, method, matches, set_name="bars"):
    """A run that proposes the pairs (segment, segment) of two shapes."""
    hashes = [segment_ids(shape.mesh, shape.segmentation) for shape in (first, second)]
    proposals = []
    for rank, (a, b) in enumerate(matches):
        ids = [node_id([hashes[k][segment]]) for k, segment in enumerate((a, b))]
        parts = [{"file": f"{s.mesh.name}.off", "sha256": mesh_id(s.mesh), "segments": [k]} for s, k in ((first, a), (second, b))]
        proposals.append(Proposal(shape_item(match_id(*ids), *parts), 1 - rank / 100, 1, 1, 1))
    return Run("shape", method, method, {"K": 1}, set_name, sides(first), sides(second), {"all": 1.0}, tuple(proposals))


def runs_of_bars(make_bar, pairs=2):
    """Two methods on each pair; they agree on the first two matches. Returns runs and shapes."""
    runs, shapes = [], []
    for k in range(pairs):
        first, second = make_bar(3 + k, f"one{k}"), make_bar(4 + k, f"two{k}")
        shapes += [first, second]
        runs.append(run_of(first, second, "careful", [(0, 0), (1, 1)]))
        runs.append(run_of(first, second, "daring", [(0, 0), (1, 1), (2, 0)]))
    return runs, shapes


def judged_study(path, make_bar, cast=None, **design):
    """A study of these in a file, with the given votes {code: {item row: answer}}; items in the order of the runs."""
    runs, shapes = runs_of_bars(make_bar)
    with create_design(path, runs, Design(name="Bars", **design), shapes=shapes) as handle:
        items = items_of(runs)
        for code, answers in (cast or {}).items():
            for row, answer in answers.items():
                record_vote(handle, items[row], code, answer, active_ms=4000)
    return items


def items_of(runs):
    """The distinct matches, as they come."""
    return list(dict.fromkeys(p.item.id for run in runs for p in run.proposals))


def known(items, answers):
    """Known answers by the rows of items."""
    return {items[row]: Practice(answer, "") for row, answer in answers.items()}


__all__ = ["items_of", "judged_study", "keep_shapes", "known", "run_of", "runs_of_bars"]


def made_window(qtbot, tmp_path, monkeypatch):
    """A furnished window with data and a cache of its own, closed at the end; for fixtures."""
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path / "cache"))
    made = MainWindow(dark=False)
    made.furnish()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitUntil(lambda: made.judging.handle is not None)
    yield made
    made.close()


def settle(window, qtbot):
    """Wait until nothing is under way."""
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)
