"""What a new study may be made of: what the window shows, files of results, and other studies. No widget here."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from annotation.design.designing import Plan
from annotation.design.knownanswers import known_by_picture, known_by_truth, merged
from annotation.records import Practice, Run
from annotation.results.matchesfile import run_of_json
from annotation.results.puzzlejoins import solution_run
from annotation.results.resultfiles import ResultFile, find_results, find_shapes, read_all
from annotation.results.studyruns import runs_of_study, shapes_of_study
from annotation.storage.blobs import shape_key
from annotation.study import about, open_study
from engine.errors import BadInput
from engine.progress import Progress, share
from engine.shapes.identity import mesh_id

if TYPE_CHECKING:
    from engine.shapes.result import MatchResult
    from engine.shapes.segmentation import SegmentedShape

    from ...session import State
    from ..collection.state import CollectionState
    from ..puzzle.state import PuzzleState
    from .calculator import Expected


class Source(NamedTuple):
    """Results that may be judged: their name, their runs, the shapes that their items show, and in sentences those not found.

    `truth` finds, in a thread, the answers that came along with them.
    """

    title: str
    runs: tuple[Run, ...]
    shapes: tuple[Any, ...] = ()
    missing: tuple[str, ...] = ()
    truth: Callable[[Progress], dict[str, Practice]] | None = None

    @property
    def detail(self) -> str:
        """'12 matches', or '21 pairs, 410 matches'."""
        return counts_text([self])


class Counted(NamedTuple):
    """How much there is to judge: distinct matches, methods, and pairs of shapes or puzzles."""

    matches: int
    methods: int
    pairs: int


def counted(sources: Iterable[Source]) -> Counted:
    """What the sources hold together; a match that several methods propose counts once."""
    runs = [run for source in sources for run in source.runs]
    items = {p.item.id for run in runs for p in run.proposals}
    inputs = {tuple(sorted((str(r.source.get("sha256", "")), str(r.target.get("sha256", ""))))) for r in runs}
    return Counted(len(items), len({(r.method, r.preset) for r in runs}), len(inputs))


def counts_text(sources: Sequence[Source]) -> str:
    """'240 matches of 3 methods on 12 pairs'."""
    found = counted(sources)
    kinds = {run.kind for source in sources for run in source.runs}
    one, many = ("pair", "pairs") if kinds == {"shape"} else ("puzzle", "puzzles") if kinds == {"puzzle"} else ("", "pairs and puzzles")
    return f"{plural(found.matches, 'match', 'matches')} of {plural(found.methods, 'method')} on {plural(found.pairs, one, many)}"


def plural(count: int, one: str, many: str = "") -> str:
    """'1 match', '2 matches'."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def shown_sources(state: "State", collection: "CollectionState | None", puzzle: "PuzzleState | None") -> list[Source]:
    """What the pages of the window show: a pair, a collection, a solved puzzle."""
    found = []
    if state.result is not None and len(state.result.ids):
        names = f"{state.source.mesh.name} – {state.target.mesh.name}"
        found.append(shape_source(f"The pair {names}", (_run(state.result, state.set_name),), (state.source, state.target)))
    if collection is not None and collection.found is not None:
        results = [result for result in collection.found.results if len(result.ids)]
        if results:
            folder = Path(collection.found.shapes[0].file).resolve().parent.name
            runs = tuple(_run(result, folder) for result in results)
            found.append(shape_source("The collection that is open", runs, tuple(collection.found.shapes)))
    if puzzle is not None and puzzle.solution is not None and len(puzzle.solution.joins):
        run = solution_run(puzzle.puzzle, puzzle.solution, puzzle.puzzle.name, guided=bool(puzzle.wishes))
        of, truth, joins = puzzle.puzzle, puzzle.truth, puzzle.solution.joins
        tell = None if truth is None else lambda _: known_by_picture(of, truth, joins)
        found.append(Source(f"The puzzle {of.name}", (run,), truth=tell))
    return found


def shape_source(title: str, runs: tuple[Run, ...], shapes: tuple["SegmentedShape", ...]) -> Source:
    """Results of shapes that are at hand."""

    def tell(progress: Progress) -> dict[str, Practice]:
        by_mesh = {mesh_id(shape.mesh): shape for shape in shapes if shape.file}
        sides = [side for run in runs for side in (run.source, run.target)]
        by_key = {shape_key(side): by_mesh[side["sha256"]] for side in sides if side["sha256"] in by_mesh}
        files = [ResultFile(Path(run.set_name or title), run.set_name) for run in runs]
        return known_by_truth(files, runs, by_key, progress=progress)

    return Source(title, runs, shapes, truth=tell)


def truth_of(sources: Sequence[Source], progress: Progress) -> dict[str, Practice]:
    """The answers that came along with all of these results; where two differ, the first."""
    told = [source.truth(share(progress, k / len(sources), (k + 1) / len(sources))) for k, source in enumerate(sources) if source.truth]
    return merged(*told)


def truth_text(known: Mapping[str, Practice]) -> str:
    """'40 matches are known: 31 correct, 9 wrong.'"""
    answers = Counter(one.answer for one in known.values())
    if not known:
        return "No truth came along with these results: no .sem file lies beside their meshes, and no puzzle was cut from a picture."
    return f"{plural(len(known), 'match is', 'matches are')} known: {answers['correct']} correct, {answers['wrong']} wrong."


def _run(result: "MatchResult", set_name: str) -> Run:
    from engine.matchfile import result_to_json

    return run_of_json(result_to_json(result), set_name)


def read_source(path: Path, progress: Progress) -> Source:
    """The results in a file or a folder, as one source, with the shapes that can be found again."""
    files = find_results([str(path)])
    runs = read_all(files, progress=share(progress, 0.0, 0.5))
    if not any(run.proposals for run in runs):
        raise BadInput(f"{path} holds results without a single match; choose others.")
    found = find_shapes(files, runs, progress=share(progress, 0.5, 1.0))
    name = path.name if path.is_dir() else f"{path.parent.name}/{path.name}"
    return Source(name, runs, tuple(found.shapes.values()), found.missing,
                  lambda step: known_by_truth(files, runs, found.shapes, progress=step))  # fmt: skip


def study_source(path: Path, progress: Progress) -> Source:
    """The results of another study, to be judged again; that study is not changed."""
    with open_study(path, backup=False, writable=False) as handle:
        progress(0.1, f"Reading {path.name}")
        runs = tuple(run for run in runs_of_study(handle) if run.proposals)
        if not runs:
            raise BadInput(f"{path} has no results; choose another study.")
        progress(0.5, f"Reading {path.name}")
        return Source(about(handle).name, runs, tuple(shapes_of_study(handle, runs).values()))


def plan_text(sources: Sequence[Source], plan: Plan, expected: "Expected") -> str:
    """'240 matches of 3 methods on 12 pairs: 200 are asked …', for the last step."""
    roles = Counter(row.role for row in plan.asked)
    lines = [counts_text(sources) + "."]
    asked = [plural(roles["judged"], "match", "matches") + " to be judged"]
    asked += [f"{roles[role]} {role}" for role in ("gold", "practice") if roles[role]]
    lines.append(", ".join(asked) + "; " + expected_text(expected) + ".")
    missing = [sentence for source in sources for sentence in source.missing]
    if missing:
        lines.append(f"{plural(len(missing), 'mesh', 'meshes')} not found ({missing[0]}); matches of it can be judged only "
                     "where it lies.")  # fmt: skip
    return "\n".join([*lines, *plan.notes])


def expected_text(expected: "Expected") -> str:
    """'about 560 votes, about 4 h for 3 volunteers'."""
    return (f"about {plural(round(expected.votes), 'vote')}, about {hours_text(expected.hours)} "
            f"for {'each of ' if expected.volunteers > 1 else ''}{plural(expected.volunteers, 'volunteer')}")  # fmt: skip


def hours_text(hours: float) -> str:
    """'4 h', '35 min'."""
    return f"{hours:.1f} h".replace(".0 h", " h") if hours >= 1.5 else f"{max(1, round(60 * hours))} min"
