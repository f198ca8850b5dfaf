"""The commands of puzzles: what they write, every bad input in one sentence, and the benchmark that goes on."""

import csv
import json
import os

import numpy as np
import pytest
from PIL import Image
from puzzle_world import solved
from test_puzzle_imagefile import huge_png

from assets import example_picture
from engine.__main__ import main, parameter_text
from engine.errors import BadInput
from engine.puzzles import benching, solving, thesis_tables
from engine.puzzles.benching import Plan, by_image, checked_plan, overview, run_plan, to_markdown
from engine.puzzles.gathering import Cutting
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.scenery import landscape
from engine.puzzles.solution import no_joins
from engine.puzzles.solutionfile import read_solution

FAST = ["--measure", "mgc", "--method", "mst"]
OUTPUTS = {"solution.json", "joins.csv", "assembled.png", "report.html"}


@pytest.fixture(scope="module")
def scene():
    return landscape(192, 144, seed=5)


@pytest.fixture
def here(tmp_path, scene, monkeypatch):
    """A folder that is the current one, with a picture in it."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(scene).save("scene.png")
    return tmp_path


def names(folder):
    return {path.name for path in folder.iterdir()}


def pixels(path):
    return np.asarray(Image.open(path).convert("RGB"))


# --- what works


def test_a_picture_is_cut_and_put_together(here, scene, capsys):
    assert main(["solve", "scene.png", "--piece-size", "24", "--out", "out", *FAST]) == 0
    assert names(here / "out") == OUTPUTS
    content = json.loads((here / "out" / "solution.json").read_text())
    assert content["pieces"] == 48
    assert content["scores"]["direct"] == 1.0
    assert content["source"]["piece_size"] == 24
    assert content["source"]["files"][0]["name"] == "scene.png"
    assert np.array_equal(pixels(here / "out" / "assembled.png"), scene)
    assert read_solution(here / "out" / "solution.json").placed.all()
    rows = list(csv.DictReader((here / "out" / "joins.csv").open()))
    assert len(rows) == len(content["joins"]) == 8 * 5 + 7 * 6
    assert {row["right"] for row in rows} == {"yes"}
    assert "48 of 48 pieces" in capsys.readouterr().out


@pytest.mark.parametrize("how", [[], ["--rotate"]])
def test_a_folder_of_pieces_has_no_truth(here, how, capsys):
    assert main(["cut", "scene.png", "--piece-size", "24", "--out", "pieces", "--seed", "3", *how]) == 0
    assert len(names(here / "pieces")) == 48
    assert main(["solve", "pieces", "--out", "out", *FAST, *how]) == 0
    content = json.loads((here / "out" / "solution.json").read_text())
    assert content["scores"] is None
    assert len(content["placed"]) == 48
    assert content["names"][0] == "piece-01.png"
    assert "right" not in (here / "out" / "joins.csv").read_text().splitlines()[0]
    assert "direct" not in capsys.readouterr().out


def test_two_pictures_are_told_apart(here):
    with Image.open(example_picture()) as portrait:
        portrait.convert("RGB").resize((192, 216)).save("other.png")
    assert main(["solve", "scene.png", "other.png", "--piece-size", "24", "--out", "out"]) == 0
    assert names(here / "out") == OUTPUTS | {"assembled-2.png"}
    assert json.loads((here / "out" / "solution.json").read_text())["scores"]["neighbour"] > 0.9


def test_lost_pieces_are_counted(here):
    assert main(["solve", "scene.png", "--piece-size", "24", "--missing", "0.25", "--frame", "unknown", "--out", "out", *FAST]) == 0
    content = json.loads((here / "out" / "solution.json").read_text())
    assert content["pieces"] == 36
    assert content["parameters"]["missing"] is True
    assert content["parameters"]["frame"] == "unknown"


def test_wishes_are_honoured(here):
    """A join that is locked against the truth is there, and the person's name stands beside it."""
    run = ["solve", "scene.png", "--piece-size", "24", "--out", "out", *FAST]
    assert main(run) == 0
    before = {(j["a"], j["side_a"], j["b"], j["side_b"]) for j in json.loads((here / "out/solution.json").read_text())["joins"]}
    wanted = next((0, 1, b, 3) for b in range(1, 48) if (0, 1, b, 3) not in before)
    forbidden = next(j for j in before if 0 not in (j[0], j[2]) and wanted[2] not in (j[0], j[2]))
    rows = [dict(zip(("a", "side_a", "b", "side_b"), j, strict=True)) for j in (wanted, forbidden)]
    wishes = {"schema": "concord.wishes/1", "locked": rows[:1], "forbidden": rows[1:]}
    (here / "wishes.json").write_text(json.dumps(wishes))
    assert main([*run, "--lock", "wishes.json"]) == 0
    after = json.loads((here / "out/solution.json").read_text())
    joins = {(j["a"], j["side_a"], j["b"], j["side_b"]): j["confirmed_by"] for j in after["joins"]}
    assert joins[wanted] == "person"
    assert forbidden not in joins


@pytest.mark.parametrize("name", ["grey", "deep", "clear", "palette"])
def test_pictures_of_every_kind_are_solved(here, scene, name):
    image = Image.fromarray(scene)
    if name == "grey":
        image = image.convert("L")
    elif name == "deep":
        image = Image.fromarray(np.asarray(image.convert("L")).astype(np.uint16) * 257)
    elif name == "clear":
        image.putalpha(Image.fromarray((scene[..., 0] > 40).astype(np.uint8) * 255))
    else:
        image = image.convert("P", palette=Image.Palette.ADAPTIVE)
    image.save("kind.png")
    assert main(["solve", "kind.png", "--piece-size", "24", "--out", "out", "--method", "mst", "--measure", "ssd"]) == 0
    assert json.loads((here / "out" / "solution.json").read_text())["scores"]["neighbour_tie_aware"] > 0.7


def test_identical_pieces_still_give_a_picture(here):
    Image.new("RGB", (96, 72), (10, 80, 90)).save("flat.png")
    assert main(["solve", "flat.png", "--piece-size", "24", "--out", "out"]) == 0
    content = json.loads((here / "out" / "solution.json").read_text())
    assert len(content["placed"]) == 12
    assert content["scores"]["direct_tie_aware"] == 1.0
    assert (pixels(here / "out" / "assembled.png") == (10, 80, 90)).all()


def test_a_run_again_writes_the_same(here):
    for folder in ("one", "two"):
        assert main(["solve", "scene.png", "--piece-size", "24", "--out", folder, *FAST]) == 0
    assert (here / "one/joins.csv").read_bytes() == (here / "two/joins.csv").read_bytes()
    assert (here / "one/assembled.png").read_bytes() == (here / "two/assembled.png").read_bytes()


def test_the_parameters_of_a_solution_serve_the_next_run(here):
    assert main(["solve", "scene.png", "--piece-size", "24", "--out", "one", *FAST, "--set", "listed=9"]) == 0
    assert main(["solve", "scene.png", "--piece-size", "24", "--out", "two", "--parameters", "one/solution.json"]) == 0
    one, two = (json.loads((here / name / "solution.json").read_text()) for name in ("one", "two"))
    assert two["parameters"] == one["parameters"]
    assert two["parameters"]["listed"] == 9


def test_the_parameters_of_puzzles_are_listed():
    text = parameter_text()
    for name in PuzzleParameters.model_fields:
        assert f"\n  {name} " in text, name


# --- bad input


def bad_folder(here, scene):
    (here / "folder").mkdir()
    for k in range(3):
        Image.fromarray(scene[: 24 + k, :24]).save(here / "folder" / f"{k}.png")
    (here / "folder" / "1.png").write_bytes((here / "folder" / "1.png").read_bytes()[:200])


BAD = [
    (["words.png"], "words.png is not an image"), (["one.png"], "1 × 1"), (["huge.png"], "more than 100 million pixels"),
    (["scene.png", "--pieces", "100000"], "too small for 100000 pieces"), (["scene.png", "--pieces", "1"], "at least 2"),
    (["scene.png", "--pieces", "0"], "at least 2"), (["scene.png", "--piece-size", "0"], "no size"),
    (["scene.png", "--piece-size", "-4"], "no size"), (["scene.png", "--piece-size", "900"], "at least 2"),
    (["scene.png", "--pieces", "9", "--piece-size", "9"], "not both"), (["folder"], "1.png is damaged"),
    (["empty"], "holds no images"), (["nothing.png"], "no file nothing.png"), ([], "Name an image"),
    (["empty", "scene.png"], "stands alone"), (["folder", "--pieces", "9"], "cut already"),
    (["scene.png", "--missing", "1"], "--missing cannot be 1"), (["scene.png", "--missing", "0.99"], "leaves no puzzle"),
    (["scene.png", "--seed", "-1"], "--seed cannot be -1"), (["scene.png", "--method", "magic"], "'method' cannot be 'magic'"),
    (["scene.png", "--measure", "magic"], "'measure' cannot be 'magic'"), (["scene.png", "--set", "magic=1"], "no parameter named 'magic'"),
    (["scene.png", "--cut", "circles"], "circles"), (["scene.png", "--lock", "none.json"], "cannot be read"),
    (["scene.png", "--lock", "scene.png"], "not JSON"), (["scene.png", "--lock", "both.json"], "locked and forbidden"),
    (["scene.png", "--lock", "two.json"], "piece 1 and to piece 2"), (["cut.png"], "damaged or cut off"),
]  # fmt: skip


@pytest.fixture
def strange(here, scene):
    """Files that cannot be used."""
    (here / "words.png").write_text("hello")
    Image.new("RGB", (1, 1)).save("one.png")
    (here / "huge.png").write_bytes(huge_png(30_000, 30_000, rows=100))
    (here / "cut.png").write_bytes((here / "scene.png").read_bytes()[:3000])
    (here / "empty").mkdir()
    bad_folder(here, scene)
    one, other = ({"a": 0, "side_a": 1, "b": b, "side_b": 3} for b in (1, 2))
    for name, wishes in (("both", {"locked": [one], "forbidden": [one]}), ("two", {"locked": [one, other]})):
        (here / f"{name}.json").write_text(json.dumps({"schema": "concord.wishes/1", **wishes}))
    return here


@pytest.mark.parametrize(("arguments", "words"), BAD, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_bad_input_is_one_sentence_and_writes_nothing(strange, capsys, arguments, words):
    assert main(["solve", *arguments, "--out", "out"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert words in said.err
    assert said.err.startswith("concord: ")
    assert said.err.count("\n") == 1
    assert len(said.err) < 500
    assert not (strange / "out").exists()


LATE = [
    ["solve", "scene.png", "--piece-size", "24"], ["bench", "puzzles", ".", "--piece-size", "24"],
    ["tables", "4.1", ".", "--grids", "3"], ["tables", "5.2", ".", "--pieces", "24"],
]  # fmt: skip


@pytest.mark.parametrize("arguments", LATE, ids=lambda arguments: " ".join(arguments[:2]))
@pytest.mark.parametrize("error", [BadInput, KeyboardInterrupt])
def test_what_goes_wrong_late_leaves_no_empty_folder(here, monkeypatch, capsys, arguments, error):
    """The folder was proven writable before; what stood in one that was there already stays."""

    def fail(*_, **__):
        assert (here / "new").exists() or (here / "old").exists()
        raise error("This cannot be done.")

    for module, name in ((solving, "solve"), (benching, "run_plan"), (thesis_tables, "table_4_1"), (thesis_tables, "table_5_2")):
        monkeypatch.setattr(module, name, fail)
    assert main([*arguments, "--out", "new/deep"]) == (2 if error is BadInput else 130)
    assert capsys.readouterr().err == f"concord: {'This cannot be done.' if error is BadInput else 'stopped.'}\n"
    assert not (here / "new").exists()
    (here / "old").mkdir()
    assert main([*arguments, "--out", "old"]) != 0
    assert names(here / "old") == set()
    (here / "old/kept.txt").write_text("")
    assert main([*arguments, "--out", "old"]) != 0
    assert names(here / "old") == {"kept.txt"}


def test_a_picture_too_small_for_a_table_leaves_no_folder(here, capsys):
    Image.new("RGB", (20, 20)).save("small.png")
    assert main(["tables", "5.2", ".", "--pieces", "192", "--out", "out"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (here / "out").exists()


@pytest.mark.parametrize("command", ["solve", "cut"])
def test_a_folder_that_cannot_be_written_to_is_said(here, capsys, command):
    (here / "file").write_text("")
    assert main([command, "scene.png", "--piece-size", "24", "--out", "file/out"]) == 2
    assert "cannot be written to" in capsys.readouterr().err
    if os.geteuid():
        (here / "shut").mkdir(mode=0o500)
        assert main([command, "scene.png", "--piece-size", "24", "--out", "shut"]) == 2


def test_results_are_not_mixed_with_pieces(here, capsys):
    assert main(["cut", "scene.png", "--piece-size", "24", "--out", "pieces"]) == 0
    before = names(here / "pieces")
    assert main(["solve", "pieces", "--out", "pieces/../pieces"]) == 2
    assert "holds the pieces" in capsys.readouterr().err
    assert names(here / "pieces") == before


@pytest.mark.skipif(os.name != "posix", reason="names of files are bytes on POSIX systems only")
def test_names_that_are_no_text_are_taken(here, scene):
    odd = os.fsdecode(b"pieces \xff")
    os.mkdir(odd)
    for k in range(4):
        Image.fromarray(scene[:24, 24 * k : 24 * k + 24]).save(os.path.join(odd, os.fsdecode(b"\xfe %d.png" % k)))
    assert main(["solve", odd, "--out", "out", *FAST]) == 0
    assert json.loads((here / "out/solution.json").read_text())["names"][3] == "? 3.png"
    assert main(["solve", "x" * 300 + ".png", "--out", "out2"]) == 2


def test_pieces_are_not_mixed_with_other_images(here, capsys):
    assert main(["cut", "scene.png", "--piece-size", "24", "--out", "."]) == 2
    assert "holds images already" in capsys.readouterr().err
    assert names(here) == {"scene.png"}


# --- the benchmark


def bench(*more):
    return main(["bench", "puzzles", "pictures", "--piece-size", "24", "--out", "bench", "--methods", "mst", "greedy",
                 "--measures", "mgc", "ssd", *more])  # fmt: skip


def test_the_benchmark_makes_tables_and_goes_on(here, scene, monkeypatch, capsys):
    (here / "pictures").mkdir()
    for k in range(2):
        Image.fromarray(scene[:, 24 * k :]).save(here / "pictures" / f"{k}.png")
    assert bench() == 0
    rows = list(csv.DictReader((here / "bench/runs.csv").open()))
    assert len(rows) == 2 * 2 * 2
    assert {(row["measure"], row["method"]) for row in rows} == {(m, w) for m in ("mgc", "ssd") for w in ("mst", "greedy")}
    assert {row["pieces"] for row in rows} == {"48", "42"}
    first = (here / "bench/tables.md").read_text()
    assert first.count("| mean |") == 4
    calls = []
    prepare = benching.prepare
    monkeypatch.setattr(benching, "prepare", lambda *a, **k: calls.append(1) or prepare(*a, **k))
    assert bench() == 0
    assert calls == []
    assert (here / "bench/tables.md").read_text() == first
    next((here / "bench/runs").iterdir()).write_text("{")
    assert bench() == 0
    assert calls == [1]
    assert bench("--wear", "none", "noise 3") == 0
    assert len(list(csv.DictReader((here / "bench/runs.csv").open()))) == 2 * 8
    assert "noise 3" in (here / "bench/report.html").read_text()
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["small"], "small/1.png: A picture of 20"), (["nowhere"], "not a folder"), ([".", "--wear", "mud"], "no wear 'mud'"),
     ([".", "--wear", "none", "eroded 3", "--piece-size", "6"], "scene.png: The wear 'eroded 3' takes 6 of the 6 pixels"),
     ([".", "--wear", "eroded 2", "--piece-size", "7"], "leave at least 4"),
     (["empty"], "holds no images"), ([".", "--methods", "magic"], "'method' cannot"),
     ([".", "--seeds", "-1"], "--seed cannot"), ([".", "--cut", "merged", "--wear", "jpeg 90"], "is for squares")],
)  # fmt: skip
def test_a_benchmark_that_cannot_be_run_is_said(here, capsys, arguments, words):
    (here / "empty").mkdir()
    (here / "small").mkdir()
    for name, side in (("0", 90), ("1", 20)):
        Image.new("RGB", (side, side)).save(here / "small" / f"{name}.png")
    assert main(["bench", "puzzles", *arguments, "--out", "bench"]) == 2
    assert words in capsys.readouterr().err
    assert not (here / "bench").exists()


@pytest.fixture
def plan(here):
    """Two ways on the one picture of the folder."""
    (here / "runs").mkdir()
    how = Cutting("squares", None, 24, False, 0, 0.0)
    return Plan(here, how, (0,), ("none",), ("mgc",), ("mst", "greedy"), PuzzleParameters())


def test_what_is_named_twice_is_run_once(here, plan):
    twice = checked_plan(plan._replace(seeds=(0, 0), wear=("none",) * 2, measures=("mgc",) * 2, methods=("mst", "greedy", "mst")))
    assert twice == plan
    assert main(["bench", "puzzles", ".", "--piece-size", "24", "--out", "out", "--methods", "mst", "mst", "--measures", "ssd"]) == 0
    assert len(list(csv.DictReader((here / "out/runs.csv").open()))) == 1


def test_pieces_may_be_worn_down_to_the_smallest_size(plan):
    assert checked_plan(plan._replace(how=plan.how._replace(piece_size=8), wear=("eroded 2",)))


@pytest.mark.parametrize("frame", ["known", "unknown"])
def test_an_unknown_frame_is_hidden_from_solver_and_scores_of_the_benchmark(here, plan, monkeypatch, frame):
    """A picture put together one column off is right where no frame is known, and all wrong where one is."""
    seen = []

    def assembled_aside(prepared, parameters, **_):
        puzzle, truth = benching.cut_images([here / "scene.png"], plan.how)
        seen.append(prepared.puzzle.frame)
        return solved(puzzle, truth, no_joins(), position=truth.position + np.array([24, 0]))

    monkeypatch.setattr(benching, "assemble", assembled_aside)
    results = run_plan(plan._replace(parameters=PuzzleParameters(frame=frame)), here / "runs")
    assert seen == [(192, 144) if frame == "known" else None] * 2
    assert [r["direct"] for r in results] == [0.0 if frame == "known" else 1.0] * 2


def test_runs_are_made_anew_where_the_fitted_numbers_have_changed(here, plan, monkeypatch):
    copies = [here / file.name for file in benching.FITTED]
    assert {file.name for file in copies} == {"learned.json", "polygonmodels.json"}
    for copy, file in zip(copies, benching.FITTED, strict=True):
        copy.write_bytes(file.read_bytes())
    monkeypatch.setattr(benching, "FITTED", tuple(copies))
    for made, copy in enumerate([None, None, *copies]):
        if copy is not None:
            copy.write_bytes(copy.read_bytes() + b"\n")
        run_plan(plan, here / "runs")
        assert len(list((here / "runs").iterdir())) == 2 * max(made, 1)


@pytest.mark.parametrize("kept", [0, 1])
def test_the_progress_of_the_benchmark_never_runs_backwards(here, plan, kept):
    """Two measures with three methods each, nothing or the first of them done before."""
    plan = plan._replace(measures=("mgc", "ssd"), methods=("mst", "greedy", "loops"))
    if kept:
        run_plan(plan._replace(methods=("mst",)), here / "runs")
    shares = []
    run_plan(plan, here / "runs", progress=lambda share, words: shares.append(share))
    assert len(shares) > 8
    assert min(np.diff(shares)) >= -1e-12
    assert min(shares) >= 0
    assert shares[-1] == 1.0


def run(image, perfect, direct):
    return {"image": image, "seed": 0, "wear": "none", "measure": "mgc", "method": "mst", "pieces": 4, "direct": direct,
            "neighbour": 0.5, "perfect": perfect, "direct_tie_aware": 1.0, "neighbour_tie_aware": 0.75, "perfect_tie_aware": True,
            "largest_component": 0.5, "seconds": 2.0}  # fmt: skip


def test_means_by_hand():
    results = [run("a|b.png", True, 1.0), run("c.png", False, 0.5)]
    assert overview(results).rows == [("none", "mgc", "mst", "75.0", "50.0", "100.0", "75.0", "1 of 2", "2 of 2", "2.00")]
    (table,) = by_image(results)
    assert [row[0] for row in table.rows] == ["a|b.png", "c.png", "mean"]
    assert table.rows[1] == ("c.png", "4", "50.0", "50.0", "100.0", "75.0", "no", "2.00")
    assert table.rows[2][2] == "75.0"
    assert "a\\|b.png" in to_markdown([table], "lead")


# --- the tables of the thesis


@pytest.mark.parametrize(
    ("number", "more", "rows"), [("4.1", ["--grids", "3", "--t1", "0.8", "1", "--t2", "0.5"], 1), ("5.2", ["--pieces", "24"], 6)]
)
def test_the_tables_of_the_thesis_are_made_of_any_pictures(here, number, more, rows):
    assert main(["tables", number, ".", "--out", "out", *more]) == 0
    assert names(here / "out") == {f"table-{number}.{kind}" for kind in ("md", "csv", "html")}
    assert len(list(csv.DictReader((here / f"out/table-{number}.csv").open()))) == rows
    assert "| mean |" in (here / f"out/table-{number}.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["4.1", "nowhere"], "not a folder"), (["5.2", "empty"], "no images"), (["4.1", ".", "--grids", "1"], "--grids"),
     (["4.1", ".", "--t1", "2"], "thresholds"), (["4.1", ".", "--resolution", "3"], "--resolution"),
     (["5.2", ".", "--seed", "-1"], "--seed"), (["4.1", ".", "--set", "x=1"], "no parameter"), (["9.9", "."], "9.9")],
)  # fmt: skip
def test_a_table_that_cannot_be_made_is_said(here, capsys, arguments, words):
    (here / "empty").mkdir()
    assert main(["tables", *arguments, "--out", "out"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not (here / "out").exists()
