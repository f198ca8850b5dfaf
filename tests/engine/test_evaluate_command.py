"""`evaluate` and `tables 3.1` from end to end on a small collection, beside the independent judge where it stands near."""

import csv
import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from cyclopts import App
from test_evaluation_summary import judged
from world import LAMP, boxes

from engine import evaluate_commands
from engine.__main__ import main
from engine.cli import run
from engine.evaluate_report import extremes
from engine.runs import judging
from engine.shapes.families.collection import off_text
from engine.shapes.matching import rematch

JUDGE = Path(__file__).resolve().parents[3] / "shared" / "tools" / "judge_matches.py"
TRUTH = np.repeat([0, 1, 1, 2, 3], 12)
CUTS = {"1": [0, 1, 2, 3, 4], "2": [0, 1, 1, 2, 3], "3": [0, 1, 2, 2, 3]}


def lines(values) -> str:
    return "\n".join(map(str, values)) + "\n"


@pytest.fixture
def lamps(tmp_path) -> Path:
    """A collection of one family: three lamps of boxes, cut differently."""
    folder = tmp_path / "collection" / "lamps"
    folder.mkdir(parents=True)
    for name, cut in CUTS.items():
        (folder / f"{name}.off").write_text(off_text(boxes(LAMP, name).mesh))
        (folder / f"{name}.seg").write_text(lines(np.repeat(cut, 12)))
        (folder / f"{name}.sem").write_text(lines(TRUTH))
    return folder.parent


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as handle:
        return list(csv.DictReader(handle))


def evaluate(*words) -> int:
    return main(["evaluate", *map(str, words)])


def test_all_tables_are_written_and_a_second_run_runs_nothing(lamps, tmp_path, capsys):
    out = tmp_path / "out"
    words = (lamps, "--methods", "top-down", "thesis", "--out", out, "--jobs", "1")
    assert evaluate(*words) == 0
    assert "2 pairs of 1 family of collection, matched by top-down, thesis." in capsys.readouterr().out
    tables = [f"{stem}.{end}" for stem in ("tables", "pairs") for end in ("md", "tex")]
    figures = [f"{stem}.csv" for stem in ("pairs", "sets", "sizes", "tests")]
    assert {p.name for p in out.iterdir()} == {"runs", "report.html", "parameters.json", *tables, *figures}
    pairs, sets = rows(out / "pairs.csv"), rows(out / "sets.csv")
    assert [(r["method"], r["pair"]) for r in pairs] == [("top-down", "1 2"), ("top-down", "2 3"), ("thesis", "1 2"), ("thesis", "2 3")]
    assert [r["pairs"] for r in sets] == ["2", "2"]
    assert json.loads((out / "parameters.json").read_text())["thesis"]["method"] == "thesis"
    mean = np.mean([float(r["transfer_recall"]) for r in pairs if r["method"] == "top-down"])
    assert float(sets[0]["transfer_recall_macro"]) == pytest.approx(mean, rel=1e-5)
    before = {p: p.stat().st_mtime_ns for p in (out / "runs").iterdir()}
    tables = (out / "tables.md").read_text()
    assert len(before) == 4
    assert evaluate(*words) == 0
    assert {p: p.stat().st_mtime_ns for p in (out / "runs").iterdir()} == before
    assert (out / "tables.md").read_text() == tables
    assert evaluate(*words, "--set", "K=3") == 0
    assert len(list((out / "runs").iterdir())) == 8


def test_methods_that_share_descriptors_give_what_each_gives_alone(lamps, tmp_path):
    for name, methods in (("both", ("top-down", "thesis-rigid")), ("one", ("top-down",)), ("other", ("thesis-rigid",))):
        assert evaluate(lamps, "--methods", *methods, "--out", tmp_path / name, "--jobs", "1") == 0
    alone = [r for name in ("one", "other") for r in rows(tmp_path / name / "pairs.csv")]
    together = rows(tmp_path / "both" / "pairs.csv")
    assert [{**r, "seconds": ""} for r in together] == [{**r, "seconds": ""} for r in alone]


def test_processes_give_the_same_figures(lamps, tmp_path):
    for jobs in ("1", "2"):
        assert evaluate(lamps, "--pairs", "all", "--out", tmp_path / jobs, "--jobs", jobs) == 0
    one, two = ([{**r, "seconds": ""} for r in rows(tmp_path / jobs / "pairs.csv")] for jobs in "12")
    assert one == two
    assert len(one) == 3


def test_a_method_that_breaks_on_one_pair_is_noted_and_the_others_go_on(lamps, tmp_path, monkeypatch, capsys):
    def breaks(proposals, parameters, **options):
        if parameters.method == "thesis" and proposals.source.shape.mesh.name == "2":
            raise ValueError("operands do not fit")
        return rematch(proposals, parameters, **options)

    words = (lamps, "--methods", "top-down", "thesis", "--out", tmp_path / "out", "--jobs", "1")
    with monkeypatch.context() as patched:
        patched.setattr(judging, "rematch", breaks)
        assert evaluate(*words) == 0
    assert "Failed: thesis on lamps 2 3: An error that was not foreseen (ValueError: operands do not fit)" in capsys.readouterr().out
    assert [bool(r["failure"]) for r in rows(tmp_path / "out" / "pairs.csv")] == [False, False, False, True]
    assert evaluate(*words) == 0
    assert not any(r["failure"] for r in rows(tmp_path / "out" / "pairs.csv"))


def judge():
    spec = importlib.util.spec_from_file_location("judge_matches", JUDGE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def judged_by(module, matches, meshes, segments, truths):
    """What the independent judge says of a matches.json and files on disk."""
    seg, sem = [np.loadtxt(p, dtype=int) for p in segments], [np.loadtxt(p, dtype=int) for p in truths]
    classes = np.unique(np.concatenate(sem))
    tables = [module.table(module.read_off(m), s, t, classes) for m, s, t in zip(meshes, seg, sem, strict=True)]
    found = json.loads(matches.read_text())["matches"]
    return module.judge(*tables, [(m["source"], m["target"]) for m in found])


def agree(row, theirs) -> None:
    assert int(row["matches"]) == theirs["judged"] > 0
    for name in ("lenient", "strict", "chance lenient", "chance strict", "transfer precision", "transfer recall"):
        assert float(row[name.replace(" ", "_")]) == pytest.approx(theirs[name], rel=2e-5, abs=1e-9), name


@pytest.mark.skipif(not JUDGE.exists(), reason=f"the independent judge {JUDGE} is not beside this checkout")
def test_the_files_are_judged_alike_by_the_independent_judge(lamps, tmp_path):
    module, out, made = judge(), tmp_path / "out", tmp_path / "made"
    assert evaluate(lamps, "--out", out, "--methods", "top-down", "thesis", "--keep-matches", "--jobs", "1") == 0
    for row in rows(out / "pairs.csv"):
        ends = [[lamps / "lamps" / f"{k}{end}" for k in row["pair"].split()] for end in (".off", ".seg", ".sem")]
        agree(row, judged_by(module, out / "matches" / "lamps" / row["pair"].replace(" ", "-") / f"{row['method']}.json", *ends))
    assert evaluate("generated", "--families", "lamps", "vases", "--seed", "70", "--segments", "6-8", "--out", made,
                    "--methods", "top-down", "--keep-matches", "--jobs", "1") == 0  # fmt: skip
    for row in rows(made / "pairs.csv"):
        place = made / "matches" / row["set"] / row["pair"].replace(" ", "-")
        ends = [[place / f"{side}{end}" for side in ("source", "target")] for end in (".off", ".seg", ".sem")]
        agree(row, judged_by(module, place / "top-down.json", *ends))


def test_kept_matches_name_the_meshes_and_are_those_of_match(lamps, tmp_path):
    out = tmp_path / "out"
    assert evaluate("generated", "--families", "vases", "--segments", "5", "--out", out, "--methods", "top-down", "--keep-matches",
                    "--jobs", "1") == 0  # fmt: skip
    kept = json.loads((out / "matches" / "vases" / "0-touching" / "top-down.json").read_text())
    meshes = [kept[side]["file"] for side in ("source", "target")]
    assert [Path(mesh).name for mesh in meshes] == ["source.off", "target.off"]
    assert main(["match", *meshes, "--preset", "top-down", "--out", str(tmp_path / "match")]) == 0
    again = json.loads((tmp_path / "match" / "matches.json").read_text())
    assert again["matches"] == kept["matches"]
    assert again["source"] == kept["source"]


def test_what_cannot_be_matched_is_named_not_dropped(lamps, tmp_path, capsys):
    out = tmp_path / "out"
    words = ("generated", "--families", "lamps", "--segments", "12", "--set", "most_segments=10", "--out", out, "--jobs", "1")
    assert evaluate(*words, "--methods", "top-down", "thesis", "--keep-matches") == 0
    text = capsys.readouterr().out
    assert "Failed: top-down, thesis on lamps 0 touching: lamps 0 has 12 segments, more than most_segments = 10" in text
    row = rows(out / "pairs.csv")[0]
    assert (row["matches"], row["lenient"]) == ("", "")
    assert "12 segments" in row["failure"]
    assert rows(out / "sets.csv")[0]["failed"] == "1"
    assert not list((out / "matches").rglob("*.json"))


def test_the_best_and_the_worst_pairs_are_drawn_with_their_verdicts(lamps, tmp_path, capsys):
    drawn = []

    def draw(source, target, result, states=None):
        drawn.append((source.mesh.name, target.mesh.name, set(states) <= set(result.ids), set(states.values())))
        return [("a picture", b"png")]

    app = App()
    evaluate_commands.mount(app, draw)
    out = tmp_path / "out"
    assert run(app, ["evaluate", str(lamps), "--out", str(out), "--pictures", "1", "--jobs", "1", "--methods", "top-down", "bottom"]) == 0
    assert sorted(d[:2] for d in drawn) == [("1", "2"), ("1", "2"), ("2", "3"), ("2", "3")]
    assert all(complete and states <= {"correct", "wrong"} for _, _, complete, states in drawn)
    page = (out / "report.html").read_text()
    assert page.count("<img") == 4
    assert "Best and worst pairs of bottom" in page


def test_no_pair_is_both_best_and_worst():
    pairs = [judged(str(k), 4, lenient) for k, lenient in enumerate((1, 4, 0, 3, 2))]
    for count, best, worst in ((1, "1", "2"), (2, "13", "20"), (4, "134", "20"), (0, "", "")):
        assert ["".join(row.pair for row in side) for side in extremes(pairs, count)] == [best, worst]
    assert extremes([judged("1", failure="no")], 2) == ([], [])


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("nowhere",), "The collection nowhere is not there"),
        (("generated", "--families", "boats"), "no shape family named 'boats'"),
        (("generated", "--case", "coarse-fine"), "bring their own labels"),
        (("generated", "--methods", "magic"), "no method or preset named 'magic'; there are: "),
        (("generated", "--set", "K=99"), "'K' cannot be '99'"),
        (("generated", "--pairs", "x"), "--pairs cannot be x"),
        (("generated", "--segments", "1"), "range of segments"),
        (("generated", "--jobs", "-1"), "--jobs cannot be -1"),
        (("generated", "--seed", "-1"), "--seed cannot be -1"),
        (("generated", "--pictures", "99"), "--pictures cannot be 99"),
        (("LAMPS", "--case", "coarse"), "--case cannot be 'coarse'"),
        (("LAMPS", "--case", "a-b", "--segments", "5"), "--case and --segments contradict"),
        (("LAMPS", "--target-labels", ".seg"), "needs --source-labels"),
        (("LAMPS", "--truth", "../x"), "--truth cannot be '../x'"),
        (("LAMPS", "--truth", "class"), r"have no truth labels (beside the meshes there are .seg, .sem)"),
        (("LAMPS", "--case", "coarse-fine"), "has no segment labels; add 1.coarse.seg"),
    ],
)
def test_wrong_input_gets_one_sentence_and_leaves_no_folder(words, sentence, lamps, tmp_path, capsys):
    out = tmp_path / "out"
    assert evaluate(*(lamps if word == "LAMPS" else word for word in words), "--out", out) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert not out.exists()


def test_a_folder_that_cannot_be_written_to_is_refused_before_any_work(lamps, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert evaluate(lamps, "--out", tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err


def test_table_3_1_has_a_column_a_method_and_the_layers_of_each_set(lamps, tmp_path, capsys):
    out = tmp_path / "out"
    words = ["tables", "3.1", str(lamps), "--layers", "lamps=4", "--jobs", "1", "--out"]
    assert main([*words, str(out)]) == 0
    text = (out / "table-3.1.md").read_text()
    assert "| set | thesis-rigid | shed | pairs | layers |" in text
    assert "| 2 | 4 |" in text
    assert "## All matches pooled, in %" in text
    assert {p.name for p in out.iterdir()} == {"runs", *(f"table-3.1.{end}" for end in ("md", "csv", "tex", "html"))}
    for row in rows(out / "table-3.1.csv"):
        judged = [json.loads(p.read_text()) for p in (out / "runs").iterdir()]
        mine = [j["figures"] for j in judged if j["matches"]["preset"] == row["method"]]
        share = sum(f["lenient_correct"] for f in mine) / sum(f["judged"] for f in mine)
        assert (float(row["precision"]), row["layers"]) == (pytest.approx(share, rel=1e-5), "4")
    capsys.readouterr()
    assert main([*words[:3], "--layers", "vases=4", "--out", str(out)]) == 2
    assert "--layers names 'vases'" in capsys.readouterr().err
    assert main(["tables", "3.2", str(lamps), "--layers", "lamps=x", "--out", str(out)]) == 2
    assert main(["tables", "3.2", str(out / "table-3.1.md"), "--out", str(out)]) == 2
    assert "is a file" in capsys.readouterr().err
