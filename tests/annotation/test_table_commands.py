"""`concord study table`, `overview` and `datasheet`: what they write, and what they refuse in a sentence."""

import base64
import csv
import io
import json
import os
import re
import stat

import pytest
from judging_world import CANDLE, LAMP, ONE_TO_ONE, VASE, identity, result, study_of
from PIL import Image
from puzzle_world import cut_up, solved

from annotation import study
from annotation.__main__ import app, main
from annotation.findings.commands import mount
from annotation.results.puzzlejoins import add_solution

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)


@pytest.fixture
def file(tmp_path):
    """Two methods on two pairs; three volunteers, who differ about the stem."""
    path = tmp_path / "lamps.db"
    results = result(*ONE_TO_ONE), result(((0,), (0,)), target=CANDLE), result(((0,), (0,)), preset="other")
    with study_of(path, *results, set_name="lamps") as handle:
        for code, answers in {"anna": "ccw", "bert": "cww", "carl": "cuw"}.items():
            for item, letter in zip((FOOT, STEM, SHADE), answers, strict=True):
                answer = {"c": "correct", "w": "wrong", "u": "unsure"}[letter]
                study.record_vote(handle, item, code, answer, comment="<b>odd</b>" if letter == "u" else "", shown_ms=2000)
    return path


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def said(capsys, *arguments: object) -> str:
    assert run(*arguments) == 0
    return capsys.readouterr().out


def fails(capsys, *arguments: object) -> str:
    assert run(*arguments) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.strip().count("\n") == 0
    return told.err


def test_all_sections_are_printed_or_one(file, capsys):
    text = said(capsys, "table", file)
    titles = "Precision by majority", "Pooled recall", "Agreement", "Volunteers", "Methods compared", "single volunteers"
    assert all(title in text for title in (*titles, "The most disputed"))
    alone = said(capsys, "table", file, "--section", "agreement", "--format", "markdown")
    assert "## Agreement" in alone
    assert "Precision by majority" not in alone
    (row,) = csv.DictReader(io.StringIO(said(capsys, "table", file, "--section", "disputed", "--format", "csv")))
    assert (row["match"], row["correct"], row["wrong"], row["unsure"], row["comments"]) == (STEM, "1", "1", "1", "<b>odd</b>")


def test_the_preset_of_the_thesis(file, capsys):
    text = said(capsys, "table", file, "--preset", "thesis", "--section", "precision")
    assert "as in Tables 3.1 and 3.2" in text
    assert "average" in text


def test_latex_to_a_file(file, tmp_path, capsys):
    assert said(capsys, "table", file, "--format", "latex", "--out", tmp_path / "t.tex") == ""
    assert r"\begin{tabular}" in (tmp_path / "t.tex").read_text()


def test_tuned_methods_and_pairs_held_out_are_told_apart(file, capsys):
    text = said(capsys, "table", file, "--tuned", "other", "--held-out", 1, "--section", "precision")
    assert text.count("chosen with help") >= 1
    assert "the pairs that were not held out" in text
    assert "; 1 pair held out by seed 0: lamp.off – " in text
    assert "no method or preset 'nobody'" in fails(capsys, "table", file, "--tuned", "nobody")
    assert "2 of 2 pairs cannot be held out" in fails(capsys, "table", file, "--held-out", 2)


def test_a_page_shows_disputed_joins_without_a_window(tmp_path, capsys):
    puzzle, truth = cut_up()
    with study.create_study(tmp_path / "p.db", name="Puzzle") as handle:
        add_solution(handle, puzzle, solved(puzzle, truth), set_name="pieces")
        first, *_ = study.items(handle, "anna")
        study.record_vote(handle, first.id, "anna", "correct")
        study.record_vote(handle, first.id, "bert", "wrong", comment="<img src=x>")
    assert run("table", tmp_path / "p.db", "--format", "html", "--out", tmp_path / "t.html") == 0
    page = (tmp_path / "t.html").read_text()
    (picture,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert Image.open(io.BytesIO(base64.b64decode(picture))).width > 20
    assert "<img src=x>" not in page
    assert "src=x" in page


def test_a_page_of_shapes_without_a_way_to_draw_says_so(file, tmp_path, capsys):
    page = said(capsys, "table", file, "--format", "html")
    assert "neither in the study nor beside it" in page
    assert "<svg" in page
    assert "Pictures" not in said(capsys, "table", file, "--format", "html", "--pictures", 0)
    assert "--pictures" in fails(capsys, "table", file, "--pictures", 101)


def test_mounting_again_hands_in_how_to_draw(file):
    before = len(list(app))
    mount(app, lambda shown: b"")
    assert len(list(app)) == before
    mount(app)


@pytest.mark.parametrize("words", [["table"], ["overview"], ["datasheet", "--out", "sheet"]])
def test_a_study_that_cannot_be_written_can_be_read(file, tmp_path, capsys, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    locked = tmp_path / "locked"
    locked.mkdir()
    file = file.rename(locked / "lamps.db")
    before = file.read_bytes()
    for path in (file, locked):
        os.chmod(path, stat.S_IRUSR | (stat.S_IXUSR if path.is_dir() else 0))
    try:
        assert run(words[0], file, *words[1:]) == 0
        assert file.read_bytes() == before
        assert [path.name for path in locked.iterdir()] == ["lamps.db"]
    finally:
        os.chmod(locked, stat.S_IRWXU)
    capsys.readouterr()
    assert "nowhere" in fails(capsys, words[0], "nowhere.db", *words[1:])


def test_overview(file, capsys):
    text = said(capsys, "overview", file)
    assert re.search(r"anna +3 +1 +0 +0\.0 +2\.0 ", text)
    rows = list(csv.DictReader(io.StringIO(said(capsys, "overview", file, "--format", "csv"))))
    found = [(row["volunteer"], row["judged"], row["comments"]) for row in rows]
    assert found == [("anna", "3", "0"), ("bert", "3", "0"), ("carl", "3", "1")]
    assert "| anna |" in said(capsys, "overview", file, "--format", "markdown")


def test_the_datasheet_answers_what_the_study_knows(file, tmp_path, capsys):
    words = {"question": "Same ```part```?", "guideline": "Look\n```\n# twice"}
    with study.create_study(tmp_path / "b.db", name="B", unsure=False, **words) as handle:
        study.add_result(handle, result(*ONE_TO_ONE))
        study.record_vote(handle, FOOT, "anna", "correct")
    assert "questions are answered" in said(capsys, "datasheet", tmp_path / "b.db", "--out", tmp_path / "sheet")
    sheet = json.loads((tmp_path / "sheet" / "datasheet.json").read_text())
    answers = {answer["number"]: answer for answer in sheet["answers"]}
    assert len(answers) == 45
    assert answers["4.3.7"]["answer"] == "Same ```part```?"
    assert (answers["4.3.3"]["answer"], answers["4.3.4"]["answer"]) == ("2", "correct, wrong")
    assert (answers["3.2.1"]["answer"], answers["3.1.1"]["answer"]) == ("1", "- top-down: 1 of 3 proposed")
    assert answers["5.1"]["answer"] is None
    assert answers["5.1"]["to_fill_in"]
    text = (tmp_path / "sheet" / "datasheet.md").read_text()
    assert text.count("### ") == 45
    assert text.count("[TO BE FILLED IN") == sum(bool(answer["to_fill_in"]) for answer in sheet["answers"]) + 1
    assert "````\nLook\n```\n# twice\n````" in text
    (tmp_path / "taken").write_text("a file")
    fails(capsys, "datasheet", file, "--out", tmp_path / "taken")
