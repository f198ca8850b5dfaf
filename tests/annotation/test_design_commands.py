"""The commands that design a study: what they print, and one sentence with exit code 2 for what cannot be used."""

import csv
from collections import Counter

import pytest
from judging_world import CANDLE, ONE_TO_ONE, result
from sqlalchemy import select

from annotation import study
from annotation.__main__ import main
from annotation.storage import schema
from engine.matchfile import write_matches


@pytest.fixture
def results(tmp_path):
    """Results of two sets, `all/lamps/one` with three matches and `all/candles/two` with one."""
    for place, found in (("lamps/one", result(*ONE_TO_ONE)), ("candles/two", result(((1,), (2,)), target=CANDLE))):
        (tmp_path / "all" / place).mkdir(parents=True)
        write_matches(found, tmp_path / "all" / place)
    return tmp_path / "all"


def run(capsys, *arguments: object) -> str:
    """What a command prints that works."""
    assert main([str(argument) for argument in arguments]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def fails(capsys, *arguments: object) -> str:
    """The one sentence of a command that is refused."""
    assert main([str(argument) for argument in arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.strip().count("\n") == 0
    return said.err


def ids(file):
    with study.open_study(file) as handle:
        return [item.id for item in study.items(handle, "truth")]


def table(path, items, answer="correct"):
    path.write_text("item,answer,reason\n" + "".join(f"{item},{answer},look\n" for item in items))
    return path


def roles(file):
    with study.open_study(file) as handle, handle.reading() as connection:
        return Counter(connection.scalars(select(schema.asked.c.role)))


def test_a_folder_becomes_a_designed_study(tmp_path, results, capsys):
    file = tmp_path / "a.study"
    (tmp_path / "how.txt").write_text("Look at both sides.\n")
    said = run(capsys, "create", file, results, "--votes", 5, "--no-unsure", "--question", "Same?",
               "--guideline-file", tmp_path / "how.txt")  # fmt: skip
    assert "4 matches of 2 results" in said
    assert "no gold matches" in said
    assert "3 shapes are not kept in the study" in said
    with study.open_study(file) as handle:
        about = study.about(handle)
        with handle.reading() as connection:
            assert set(connection.scalars(select(schema.run.c.set_name))) == {"lamps", "candles"}
    assert (about.name, about.question, about.guideline, about.votes, about.unsure) == ("a", "Same?", "Look at both sides.", 5, False)


def test_known_answers_become_gold_and_practice(tmp_path, results, capsys):
    run(capsys, "create", tmp_path / "pilot.study", results)
    first, second, third, _ = ids(tmp_path / "pilot.study")
    run(capsys, "vote", tmp_path / "pilot.study", "--new", "--volunteer", "me", "--item", third, "--answer", "wrong")
    said = run(capsys, "create", tmp_path / "a.study", results, "--gold-answers", table(tmp_path / "g.csv", [first, "strange"]),
               "--practice-answers", table(tmp_path / "p.csv", [second], "wrong"), "--gold-from", f"{tmp_path}/pilot.study:me",
               "--gold-least", 2, "--practice", 1)  # fmt: skip
    assert "1 of 4 known answers is about no match of these results." in said
    assert "gold matches were found" not in said
    assert roles(tmp_path / "a.study") == {"judged": 1, "gold": 2, "practice": 1}
    with study.open_study(tmp_path / "a.study") as handle:
        assert study.practice(handle) == {second: ("wrong", "look")}
    assert "no volunteer 'zoe'" in fails(capsys, "create", tmp_path / "b.study", results, "--gold-from", f"{tmp_path}/pilot.study:zoe")
    assert not (tmp_path / "b.study").exists()


def test_gold_and_practice_are_named_later(place, tmp_path, results, capsys):
    file = place
    run(capsys, "create", file, results)
    first, second, *_ = ids(file)
    assert "1 gold match more, of 1 known answer." in run(capsys, "gold", file, table(tmp_path / "g.csv", [first]))
    run(capsys, "vote", file, "--new", "--volunteer", "me", "--item", first, "--answer", "wrong", "--comment", "Other foot.")
    assert "1 practice match more" in run(capsys, "practice", file, table(tmp_path / "g.csv", [second]), "--most", 1)
    assert "0 gold matches more" in run(capsys, "gold", file, "--from", f"{file}:me")
    assert "of 1 known answer." in run(capsys, "gold", file, "--from", file)
    assert roles(file) == {"judged": 2, "gold": 1, "practice": 1}
    for command in ("gold", "practice"):
        assert "either a CSV table, or --from" in fails(capsys, command, file)
        assert "either a CSV table, or --from" in fails(capsys, command, file, tmp_path / "g.csv", "--from", file)
        assert "g2.csv" in fails(capsys, command, file, tmp_path / "g2.csv")
        assert "--most" in fails(capsys, command, file, tmp_path / "g.csv", "--most", -1)


def test_a_sample_and_its_top_ups(tmp_path, results, capsys):
    file = tmp_path / "a.study"
    assert "A sample of 2 of 4 matches is asked." in run(capsys, "create", file, results, "--most", 2)
    assert "say how many more" in fails(capsys, "top-up", file)
    for number in ("1.5", "x", "1e3", ""):
        assert f"--most takes a whole number, not '{number}'." in fails(capsys, "top-up", file, "--most", number)
    assert "1 more match asked" in run(capsys, "top-up", file, "--most", 1)
    said = run(capsys, "top-up", file, tmp_path / "rest.study", "--most", 0, "--name", "Rest")
    assert f"{tmp_path}/rest.study: 4 matches of {file} without a vote." in said
    item = ids(tmp_path / "rest.study")[0]
    run(capsys, "vote", tmp_path / "rest.study", "--new", "--volunteer", "anna", "--item", item, "--answer", "wrong")
    assert "1 votes" in run(capsys, "merge", file, tmp_path / "rest.study")
    assert roles(file) == {"judged": 4}
    assert "--name is for a new study" in fails(capsys, "top-up", file, "--name", "x", "--most", 0)
    assert "exists already" in fails(capsys, "top-up", file, tmp_path / "rest.study", "--most", 0)


def test_a_new_method_is_unjudged_until_it_is_topped_up(tmp_path, results, capsys):
    file = tmp_path / "a.study"
    run(capsys, "create", file, f"lamps={results / 'lamps'}")
    run(capsys, "vote", file, "--new", "--volunteer", "anna", "--item", ids(file)[0], "--answer", "correct")
    (tmp_path / "new").mkdir()
    write_matches(result(*ONE_TO_ONE, ((0, 1), (0, 1)), preset="other"), tmp_path / "new")
    said = run(capsys, "add", file, f"lamps={tmp_path / 'new'}")
    assert "1 of their 4 matches judged." in said
    assert "1 of them are not asked; `concord study top-up` asks them too." in said
    assert "1 more match asked" in run(capsys, "top-up", file)
    (tmp_path / "t.csv").write_text(run(capsys, "table", file, "--format", "csv"))
    rows = {row["preset"]: row for row in csv.DictReader((tmp_path / "t.csv").open())}
    assert {preset: (row["judged"], row["matches"]) for preset, row in rows.items()} == {"top-down": ("1", "3"), "other": ("1", "4")}


def test_results_are_kept_in_the_project_folder(tmp_path, results, capsys):
    run(capsys, "create", tmp_path / "lamps.concord", results)
    assert len(list((tmp_path / "lamps.concord" / "results").iterdir())) == 2


def test_adjudicators_are_made_and_ended(place, results, capsys):
    file = place
    run(capsys, "create", file, results, "--votes", 2)
    for code, answer in (("anna", "correct"), ("bert", "wrong")):
        run(capsys, "vote", file, "--new", "--volunteer", code, "--item", ids(file)[0], "--answer", answer)
    assert "zoe adjudicates: 1 match is unresolved now." in run(capsys, "adjudicate", file, "zoe")
    assert "zoe is asked as everybody is." in run(capsys, "adjudicate", file, "zoe", "--end")
    assert "no volunteer code" in fails(capsys, "adjudicate", file, "z z")


def test_a_plan_takes_what_a_study_tells(tmp_path, results, capsys):
    assert "500 judged matches of 50 pairs" in run(capsys, "plan")
    run(capsys, "create", tmp_path / "a.study", results, "--votes", 1)
    said = run(capsys, "plan", tmp_path / "a.study", "--half-width", "0.1", "--precision", "0.5")
    assert "2 matches of one method on a pair (as in the study)" in said
    assert "precision 50.0 %\n" in said
    assert "1.05 for each match" in said  # one vote, and one more where it is unsure
    run(capsys, "vote", tmp_path / "a.study", "--new", "--volunteer", "me", "--item", ids(tmp_path / "a.study")[0], "--answer", "wrong")
    said = run(capsys, "plan", tmp_path / "a.study", "--per-pair", "10", "--precision", "0.8", "--correlation", "0.1")
    assert "500 judged matches of 50 pairs are needed" in said
    (line,) = said.split("The study has:\n")[1].splitlines()
    assert line.endswith(" of 500 judged; its 4 matches are of 2 of 50 pairs")
    assert "The study has" not in run(capsys, "plan")
    assert "it takes a number from 0.005 to 0.4" in fails(capsys, "plan", "--half-width", "2")


@pytest.mark.parametrize(("arguments", "words"), [
    (["--votes", "100"], "a whole number from 0 to 99"), (["--votes", "x"], "a whole number from 0 to 99"),
    (["--overlap", "nan"], "a number from 0 to 1"), (["--gold", "0.9"], "a number from 0 to 0.5"), (["--seed", "-1"], "from 0 to"),
    (["--shapes", "nowhere"], "nowhere is no folder"), (["--gold-answers", "nowhere.csv"], "nowhere.csv cannot be read"),
    (["--gold-from", "nowhere.study"], "nowhere.study"), (["--guideline-file", "nowhere.txt"], "cannot be read as a guideline"),
    (["--bogus"], "bogus"),
])  # fmt: skip
def test_what_cannot_be_used_leaves_no_study(tmp_path, results, capsys, arguments, words):
    assert words in fails(capsys, "create", tmp_path / "a.study", results, *arguments)
    assert not (tmp_path / "a.study").exists()


def test_guidelines_twice_and_empty_folders(tmp_path, results, capsys):
    (tmp_path / "how.txt").write_text("Look.")
    twice = ("--guideline", "x", "--guideline-file", tmp_path / "how.txt")
    assert "given twice" in fails(capsys, "create", tmp_path / "a.study", results, *twice)
    (tmp_path / "empty").mkdir()
    assert "holds no results" in fails(capsys, "create", tmp_path / "a.study", tmp_path / "empty")
    (tmp_path / "how.txt").write_bytes(b"\xff\xfe\xff")
    assert "no text in UTF-8" in fails(capsys, "create", tmp_path / "a.study", results, "--guideline-file", tmp_path / "how.txt")
