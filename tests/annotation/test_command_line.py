"""`concord study`: what it prints, and one sentence with exit code 2 for whatever cannot be used."""

import csv
import io
import json
import shlex

import pytest
from judging_world import CANDLE, LAMP, ONE_TO_ONE, VASE, identity, result, study_of
from puzzle_world import picture, solved

from annotation import study
from annotation.__main__ import main
from engine.matchfile import result_to_json, write_matches
from engine.puzzles.gathering import Cutting, gather
from engine.puzzles.imagefile import png_bytes
from engine.puzzles.solutionfile import write_solution
from gui.__main__ import main as whole_command

FOOT = identity(LAMP, (0,), VASE, (0,))


@pytest.fixture
def matches(tmp_path):
    write_matches(result(*ONE_TO_ONE), tmp_path)
    return tmp_path / "matches.json"


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def fails(capsys, *arguments: object) -> str:
    """The one sentence of a command that is refused."""
    assert run(*arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.strip().count("\n") == 0
    assert said.err.strip()
    return said.err


def test_from_matches_to_a_table(tmp_path, matches, capsys):
    file = tmp_path / "a.db"
    (tmp_path / "more").mkdir()
    write_matches(result(((1,), (2,)), target=CANDLE), tmp_path / "more")
    assert run("create", file, matches, "--set", "lamps", "--name", "Lamps") == 0
    assert run("add", file, tmp_path / "more" / "matches.json", "--set", "lamps") == 0
    for code, answer in (("anna", "correct"), ("bert", "wrong"), ("carl", "correct")):
        assert run("vote", file, "--new", "--volunteer", code, "--item", FOOT, "--answer", answer) == 0
    capsys.readouterr()
    assert run("table", file) == 0
    assert "1 of 4" in capsys.readouterr().out
    assert run("table", file, "--format", "csv", "--out", tmp_path / "t.csv") == 0
    (row,) = csv.DictReader((tmp_path / "t.csv").open())
    assert (row["set"], row["pairs"], row["correct"], row["votes"]) == ("lamps", "2", "1", "3")
    assert run("votes", file) == 0
    assert len(list(csv.reader(io.StringIO(capsys.readouterr().out)))) == 4


def test_a_mistyped_code_is_no_new_volunteer(tmp_path, matches, capsys):
    file, packet = tmp_path / "a.db", tmp_path / "p.db"
    vote = ("vote", file, "--item", FOOT, "--answer", "wrong", "--volunteer")
    assert run("create", file, matches) == 0
    capsys.readouterr()
    assert "knows no volunteer anna (it has none yet); check the code, or give --new" in fails(capsys, *vote, "anna")
    assert run("invite", file, "anna") == 0
    assert run(*vote, "anna") == 0
    capsys.readouterr()
    assert "knows no volunteer anan (it has anna)" in fails(capsys, *vote, "anan")
    assert "knows no volunteer anan (it has anna)" in fails(capsys, "packet", file, "anan", "--out", packet)
    assert "no volunteer 'anan'; it has anna" in fails(capsys, "adjudicate", file, "anan", "--end")
    with study.open_study(file) as handle:
        assert [one.code for one in study.volunteers(handle)] == ["anna"]
    assert run(*vote, "bert", "--new") == 0
    with study.open_study(file) as handle:
        assert [one.code for one in study.volunteers(handle)] == ["anna", "bert"]


def test_where_everybody_is_asked_everything_the_first_may_come_unknown(tmp_path, matches, capsys):
    vote = ("vote", tmp_path / "a.db", "--item", FOOT, "--answer", "wrong", "--volunteer")
    assert run("create", tmp_path / "a.db", matches, "--votes", 0) == 0
    assert run(*vote, "anna") == 0
    capsys.readouterr()
    assert "knows no volunteer anan (it has anna)" in fails(capsys, *vote, "anan")


def test_an_invitation_to_a_file_prints_commands_to_be_copied(tmp_path, matches, capsys):
    file = tmp_path / "a b.db"
    assert run("create", file, matches) == 0
    capsys.readouterr()
    assert run("invite", file, "anna") == 0
    live, packet = (shlex.split(line.rsplit(": ", 1)[1]) for line in capsys.readouterr().out.splitlines())
    assert live == ["concord", "vote", str(file), "--volunteer", "anna"]
    assert packet == ["concord", "study", "packet", str(file), "anna", "--out", "anna.packet"]


def test_a_file_and_a_result_in_memory_are_the_same_run(tmp_path, matches):
    with study_of(tmp_path / "b.db", set_name="lamps") as handle:
        assert run("add", handle.path, matches, "--set", "lamps") == 0
        with handle.reading() as connection:
            assert connection.exec_driver_sql("SELECT count(*) FROM run").scalar() == 1
        assert len(study.items(handle, "anna")) == 3


def test_merge(tmp_path, capsys):
    with study_of(tmp_path / "a.db"):
        pass
    (tmp_path / "b.db").write_bytes((tmp_path / "a.db").read_bytes())
    assert run("vote", tmp_path / "b.db", "--volunteer", "anna", "--item", FOOT, "--answer", "wrong") == 0
    assert run("merge", tmp_path / "a.db", tmp_path / "b.db") == 0
    assert "1 votes" in capsys.readouterr().out
    with study.open_study(tmp_path / "a.db") as handle:
        assert study.answers(handle, "anna") == {FOOT: "wrong"}


def test_bad_arguments(tmp_path, capsys):
    study_of(tmp_path / "a.db").close()
    assert "nowhere.db" in fails(capsys, "table", tmp_path / "nowhere.db")
    assert "bogus" in fails(capsys, "bogus")
    fails(capsys, "table")
    fails(capsys, "table", tmp_path / "a.db", "--format", "poem")
    fails(capsys, "add", tmp_path / "a.db")
    assert "no item" in fails(capsys, "vote", tmp_path / "a.db", "--volunteer", "a", "--item", "x", "--answer", "wrong")
    fails(capsys, "vote", tmp_path / "a.db", "--volunteer", "a", "--item", FOOT, "--answer", "yes")
    assert "code" in fails(capsys, "vote", tmp_path / "a.db", "--volunteer", "a b", "--item", FOOT, "--answer", "wrong")
    assert "exists already" in fails(capsys, "create", tmp_path / "a.db")
    assert "cannot be written" in fails(capsys, "table", tmp_path / "a.db", "--out", tmp_path / "no" / "t.csv")


def broken(change) -> str:
    content = json.loads(json.dumps(result_to_json(result(*ONE_TO_ONE))))
    change(content)
    return json.dumps(content)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file"),
        ("{", "the file"),
        ("[]", "the file"),
        ("{}", "schema"),
        (broken(lambda c: c.update(schema="concord.matches/2")), "schema"),
        (broken(lambda c: c["matches"][0].pop("id")), "matches.0.id"),
        (broken(lambda c: c["matches"][1].update(score="high")), "matches.1.score"),
        (broken(lambda c: c["matches"][1].update(source=[])), "matches.1.source"),
        (broken(lambda c: c["target"].update(sha256="")), "target.sha256"),
        (broken(lambda c: c["matches"][0].update(score=float("nan"))), "matches.0.score"),
    ],
)
def test_bad_files_of_matches_leave_no_study(tmp_path, capsys, matches, text, words):
    (tmp_path / "bad.json").write_text(text)
    said = fails(capsys, "create", tmp_path / "a.db", matches, tmp_path / "bad.json")
    assert "bad.json is no file of matches" in said
    assert words in said
    assert not (tmp_path / "a.db").exists()


def test_missing_and_binary_files_of_matches(tmp_path, capsys):
    (tmp_path / "b.json").write_bytes(bytes(range(256)))
    assert "No such file" in fails(capsys, "create", tmp_path / "a.db", tmp_path / "none.json")
    assert "b.json" in fails(capsys, "create", tmp_path / "a.db", tmp_path / "b.json")
    assert not (tmp_path / "a.db").exists()


def solution_file(folder, seed=0, measure="mgc"):
    """A solved puzzle as the command `solve` writes it, its picture in the folder above."""
    folder.mkdir()
    (folder.parent / "noise.png").write_bytes(png_bytes(picture()))
    puzzle, truth, source = gather([folder.parent / "noise.png"], Cutting(piece_size=8, seed=seed))
    write_solution(folder, puzzle, solved(puzzle, truth, measure=measure), source=source)
    return folder / "solution.json"


def test_solutions_of_puzzles_are_added_beside_matches(tmp_path, matches, capsys):
    file = tmp_path / "both.db"
    assert run("create", file, solution_file(tmp_path / "one"), matches, "--set", "first") == 0
    assert "20 matches of 2 results" in capsys.readouterr().out
    assert run("add", file, solution_file(tmp_path / "two", seed=4, measure="ssd"), "--set", "first") == 0
    with study.open_study(file) as handle:
        assert len(study.items(handle, "anna")) == 3 + 17  # cut again, the same joins
        join = next(item for item in study.items(handle, "anna") if item.kind == "puzzle")
    assert run("vote", file, "--volunteer", "anna", "--item", join.id, "--answer", "correct") == 0
    capsys.readouterr()
    assert run("table", file, "--format", "csv") == 0
    rows = {(row["method"], row["preset"]): row for row in csv.DictReader(io.StringIO(capsys.readouterr().out))}
    assert {kind: rows[kind]["correct"] for kind in (("loops", "mgc"), ("loops", "ssd"))} == {
        ("loops", "mgc"): "1", ("loops", "ssd"): "1"}  # fmt: skip
    assert rows["top-down", "top-down"]["judged"] == "0"


def test_a_solution_that_cannot_be_used_is_one_sentence(tmp_path, capsys):
    path = solution_file(tmp_path / "one")
    (tmp_path / "noise.png").unlink()
    assert "noise.png" in fails(capsys, "create", tmp_path / "a.db", path)
    path.write_text('{"schema": "concord.solution/1"}')
    assert "damaged" in fails(capsys, "create", tmp_path / "a.db", path)
    path.write_text('{"schema": "concord.solution/9"}')
    assert "solution.json" in fails(capsys, "create", tmp_path / "a.db", path)
    assert not (tmp_path / "a.db").exists()


def test_a_command_that_is_stopped_while_it_loads_says_so(monkeypatch, capsys):
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("engine.__main__.build_app", stop)
    assert whole_command(["study", "table", "a.db"]) == 130
    assert capsys.readouterr().err == "concord: stopped.\n"
