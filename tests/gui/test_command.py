"""The command `concord`: what needs no window works without Qt, and no window is one clear sentence."""

import csv
import io
import os
import subprocess
import sys

import pytest

from annotation.study import answers, majority, open_study, record_vote
from annotation.study import item as study_item
from assets import example_pairs
from engine.shapes.parameters import DEFAULT_PRESET, PRESETS
from gui import display
from gui.__main__ import main


def test_without_a_display_it_says_so(monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert main([]) == 2
    said = capsys.readouterr().err
    assert "no display" in said
    assert len(said.strip().splitlines()) == 1
    assert main(["open", "a.off", "b.off"]) == 2


def test_without_the_packages_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(display, "missing_packages", lambda: ["PySide6"])
    assert main([]) == 2
    assert "pip install '.[gui]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("environment", "fine"),
    [({"QT_QPA_PLATFORM": "offscreen"}, True), ({"WAYLAND_DISPLAY": "wayland-0"}, True), ({}, False),
     ({"QT_QPA_PLATFORM": "xcb", "WAYLAND_DISPLAY": "wayland-0"}, False)],
)  # fmt: skip
def test_which_displays_are_taken(environment, fine):
    assert (display.display_problem(environment) is None) == fine


def test_a_display_that_does_not_answer_is_named(monkeypatch):
    monkeypatch.setattr(display, "_loads", lambda library: True)
    monkeypatch.setattr(display, "_answers", lambda name: False)
    assert ":77" in display.display_problem({"DISPLAY": ":77"})


def test_missing_libraries_of_x_are_named_by_their_packages(monkeypatch):
    monkeypatch.setattr(display, "_loads", lambda library: "cursor" not in library)
    assert display.display_problem({"DISPLAY": ":0"}).endswith("apt install libxcb-cursor0.")


@pytest.mark.parametrize("arguments", [["match", "missing.off", "b.off", "--out", "x"], ["study", "table", "no.db"],
                                       ["nonsense"], ["open", "one.off"]])  # fmt: skip
def test_bad_commands_are_one_sentence_and_two(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert len(said.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("name", "words"), [("none.png", "no none.png"), ("one.off", "neither a picture nor a folder"), ("nowhere", "no nowhere")]
)
def test_one_file_that_is_no_puzzle_is_not_opened(name, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.off").write_text("OFF")
    assert main(["open", name]) == 2
    assert words in capsys.readouterr().err


def test_open_takes_two_meshes_a_picture_or_a_folder(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("gui.__main__.open_window", lambda *what: opened.append(what) or 0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pieces").mkdir()
    (tmp_path / "beach.JPG").write_text("")
    for files in (["a.off", "b.off", "--target-labels", "b.seg"], ["beach.JPG"], ["pieces"]):
        assert main(["open", *files]) == 0
    assert opened == [(("a.off", "b.off"), (None, "b.seg")), (("beach.JPG",),), (("pieces",),)]


def test_commands_without_a_window_import_neither_qt_nor_vtk():
    code = (
        "import sys; from gui.__main__ import main; assert main(['parameters']) == 0; assert main(['study', '-h']) == 0;"
        "bad = [m for m in sys.modules if m.split('.')[0] in ('PySide6', 'vtkmodules', 'pyvista')]; assert not bad, bad"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ})
    assert done.returncode == 0, done.stderr
    assert "thesis-rigid" in done.stdout


def test_the_demo_goes_from_meshes_and_pieces_to_a_precision_table(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("annotation.demo.example_pairs", lambda: example_pairs()[:2])
    monkeypatch.setattr("gui.__main__.report_pictures", lambda *pair: [])
    monkeypatch.setattr("annotation.puzzledemo.WAYS", (("auto", "learned"), ("mst", "ssd")))
    monkeypatch.setattr("annotation.puzzledemo.PIECE_SIZE", 50)
    assert main(["demo", "--out", str(tmp_path / "out")]) == 0
    with open_study(tmp_path / "out" / "demo.study") as study:
        item = next(i for i in majority(study) if study_item(study, i).kind == "puzzle")
        record_vote(study, item, "ann", "unsure")
    assert main(["demo", "--out", str(tmp_path / "out")]) == 0
    with open_study(tmp_path / "out" / "demo.study") as study:
        assert answers(study, "ann") == {item: "unsure"}  # a second run keeps what people said
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"matches.json", "matches.csv", "parameters.json", "report.html", "table.csv", "demo.study"} <= written
    for folder in ("puzzle", "turned"):
        written = {path.name for path in (tmp_path / "out" / folder).iterdir()}
        assert {"solution.json", "joins.csv", "assembled.png", "report.html"} <= written
    said = capsys.readouterr().out
    assert DEFAULT_PRESET in said
    assert "120 of 120 pieces of grace_hopper stand where they belong" in said
    assert main(["study", "table", str(tmp_path / "out" / "demo.study"), "--format", "csv"]) == 0
    rows = {(row["method"], row["preset"], row["set"]): row for row in csv.DictReader(io.StringIO(capsys.readouterr().out))}
    assert (PRESETS[DEFAULT_PRESET].method, DEFAULT_PRESET, "lamps") in rows
    auto, ssd = rows["auto", "learned", "grace_hopper"], rows["mst", "ssd", "grace_hopper"]
    assert (auto["judged"], auto["correct"]) == ("218", "218")  # 10 × 12 squares have 218 neighbours
    assert int(ssd["correct"]) <= 218
    assert int(rows["auto", "learned", "landscape"]["correct"]) == 13 * 9 + 12 * 10  # 13 × 10 turned squares
