"""`concord study packet`, `export`, `forget`, `archive`, `unpack`: what they print, and one sentence for what cannot be."""

import shlex
import shutil
import sqlite3
from contextlib import closing

import pytest
from exchange_world import content, ids_of, strip_study
from judging_world import forged
from test_command_line import fails, run

from annotation import study
from engine.errors import BadInput


@pytest.fixture
def file(tmp_path):
    with strip_study(tmp_path / "a.db", votes=2) as handle:
        study.record_vote(handle, ids_of(handle)[0], "anna", "correct", comment="sure")
    return tmp_path / "a.db"


def test_a_packet_goes_out_and_comes_back(tmp_path, file, capsys):
    assert run("packet", file, "bert", "--new", "--out", tmp_path / "p.db", "--items", 2) == 0
    said = capsys.readouterr().out
    assert "2 matches for bert" in said
    assert f"concord study merge {file} {tmp_path / 'p.db'}\n" in said
    with study.open_study(tmp_path / "p.db") as packet:
        first, second = (one.item_id for one in study.open_items(packet, "bert"))
        study.record_vote(packet, first, "bert", "wrong")
    refused = fails(capsys, "vote", tmp_path / "p.db", "--volunteer", "anna", "--item", second, "--answer", "wrong")
    assert "for volunteer bert alone" in refused
    assert run("merge", file, tmp_path / "p.db") == 0
    assert "1 votes and undos, 0 matches, 0 results are new" in capsys.readouterr().out
    assert "takes nothing in" in fails(capsys, "merge", tmp_path / "p.db", file)


def test_what_a_packet_cannot_be_is_told(tmp_path, file, capsys):
    out = ("--out", tmp_path / "p.db")
    assert "at least 1" in fails(capsys, "packet", file, "bert", *out, "--new", "--items", 0)
    assert "--items takes a whole number, not '2.5'" in fails(capsys, "packet", file, "bert", *out, "--new", "--items", 2.5)
    assert "no volunteer code" in fails(capsys, "packet", file, "b e", *out)
    assert "exists already" in fails(capsys, "packet", file, "bert", "--new", "--out", file)
    strip_study(tmp_path / "bare.db", kept=False).close()
    assert "a.off, b.off" in fails(capsys, "packet", tmp_path / "bare.db", "bert", *out, "--new")
    strip_study(tmp_path / "other.db").close()
    assert run("packet", tmp_path / "other.db", "bert", "--new", *out) == 0
    capsys.readouterr()
    assert "packet of another study" in fails(capsys, "merge", file, tmp_path / "p.db")


def test_commands_to_be_copied_have_their_names_quoted(tmp_path, file, capsys):
    out = tmp_path / "for bert [1].db"
    assert run("packet", file, "bert", "--new", "--out", out) == 0
    said = capsys.readouterr().out.splitlines()
    assert [shlex.split(line.split(": ", 1)[1]) for line in said[-2:]] == [
        ["concord", "vote", str(out)], ["concord", "study", "merge", str(file), str(out)]]  # fmt: skip


def test_no_design_goes_into_a_packet(tmp_path, file, capsys):
    packet, known = tmp_path / "p.db", tmp_path / "known.csv"
    assert run("packet", file, "bert", "--new", "--out", packet) == 0
    known.write_text(f"item,answer\n{'0' * 64},correct\n")
    before = content(packet)
    for command in (("top-up",), ("gold", known), ("practice", known), ("adjudicate", "zoe")):
        capsys.readouterr()
        assert "for bert alone" in fails(capsys, command[0], packet, *command[1:])
    assert content(packet) == before


@pytest.mark.parametrize("payload", ["{", "[]", '{"source": 1}', '{"source": {"sha256": "a"}}', "[" * 100_000])
def test_what_a_damaged_match_shows_is_told_and_nothing_is_handed_out(tmp_path, file, capsys, payload):
    with study.open_study(file) as handle, handle.writing() as connection:
        connection.exec_driver_sql("UPDATE item SET payload = ?", (payload,))
    assert "damaged" in fails(capsys, "packet", file, "bert", "--out", tmp_path / "p.db")
    assert not (tmp_path / "p.db").exists()
    assert run("export", file, "--out", tmp_path / "tables") == 0


def test_a_returned_packet_with_a_damaged_match_is_told(tmp_path, file, capsys):
    assert run("packet", file, "bert", "--new", "--out", tmp_path / "p.db") == 0
    with study.open_study(tmp_path / "p.db") as packet:
        study.record_vote(packet, study.open_items(packet, "bert")[0].item_id, "bert", "wrong")
        with packet.writing() as connection:
            connection.exec_driver_sql("UPDATE item SET payload = '{}'")
    capsys.readouterr()
    assert "damaged" in fails(capsys, "merge", file, tmp_path / "p.db")


def test_exports_name_their_files(tmp_path, file, capsys):
    assert run("export", file, "--out", tmp_path / "out", "--format", "jsonl, csv") == 0
    assert "votes.jsonl, votes.csv" in capsys.readouterr().out
    assert not (tmp_path / "out" / "gold.csv").exists()
    assert "xlsx is no format" in fails(capsys, "export", file, "--out", tmp_path / "out", "--format", "xlsx")
    assert "Name a format" in fails(capsys, "export", file, "--out", tmp_path / "out", "--format", ",")


def test_a_disk_that_is_full_leaves_no_folder_and_is_told_by_the_name_that_was_given(tmp_path, file, capsys, monkeypatch):
    def full(*_: object) -> None:
        raise BadInput(f"{tmp_path / 'out' / 'votes.csv'} cannot be written (No space left on device); make room.")

    monkeypatch.setattr("annotation.exchange.exporting.write_together", full)
    assert "No space left" in fails(capsys, "export", file, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()

    def also(path: object, _fill: object) -> None:
        raise BadInput(f"{path} cannot be written because the disk is full; make room.")

    monkeypatch.setattr("annotation.exchange.archive.create_file", also)
    assert f" {tmp_path / 'a.zip'} cannot be written because" in fails(capsys, "archive", file, "--out", tmp_path / "a.zip")
    assert not list(tmp_path.glob("*a.zip*"))


def test_a_volunteer_is_deleted_and_everything_that_was_done_is_told(tmp_path, file, capsys):
    assert run("vote", file, "--new", "--volunteer", "bert", "--item", "x", "--answer", "wrong") == 2  # opened, so there is a backup
    capsys.readouterr()
    assert run("forget", file, "anna") == 0
    said = capsys.readouterr().out
    assert "1 vote or undo stays as deleted-" in said
    assert f"Rewritten: {tmp_path / 'backups'}" in said
    assert run("forget", file, "anna", "--votes-too") == 0
    assert "1 vote or undo is gone" in capsys.readouterr().out
    assert "no volunteer carl" in fails(capsys, "forget", file, "carl")
    assert "take another code" in fails(capsys, "packet", file, "anna", "--out", tmp_path / "p.db")


def test_an_archive_can_be_taken_apart(tmp_path, file, capsys):
    assert run("archive", file, "--out", tmp_path / "a.zip", "--anonymous") == 0
    assert run("unpack", tmp_path / "a.zip", "--out", tmp_path / "out") == 0
    capsys.readouterr()
    assert run("votes", tmp_path / "out" / "study.db") == 0
    said = capsys.readouterr().out
    assert "v01" in said or "v02" in said
    assert "anna" not in said
    assert "sure" not in said.replace("unsure", "")
    assert "goes with --anonymous" in fails(capsys, "archive", file, "--out", tmp_path / "b.zip", "--comments")
    assert "cannot be taken apart" in fails(capsys, "unpack", file, "--out", tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("text", ["{", "[]"])
@pytest.mark.parametrize(
    ("where", "command"),
    [
        ("item.payload", "archive"), ("run.parameters", "table"), ("run.source", "table"), ("event.presentation", "archive"),
        ("run.target", "archive"),
    ],
)  # fmt: skip
def test_a_damaged_value_is_told_in_a_sentence(tmp_path, file, capsys, where, command, text):
    assert run("vote", file, "--volunteer", "anna", "--item", ids_in(file)[0], "--answer", "wrong") == 0
    table, column = where.split(".")
    forged(file, f"UPDATE {table} SET {column} = ?", values=(text,))
    capsys.readouterr()
    more = {"archive": ("--out", tmp_path / "a.zip", "--anonymous")}
    assert "damaged" in fails(capsys, command, file, *more.get(command, ()))
    assert not (tmp_path / "a.zip").exists()


def ids_in(file):
    with study.open_study(file) as handle:
        return ids_of(handle)


@pytest.mark.parametrize("statement", ["DELETE FROM study", "INSERT INTO study SELECT id || '2', name, question, guideline, seed, "
                                       "settings, app_version, created_at, votes, adaptive, unsure FROM study"])  # fmt: skip
def test_a_file_without_a_study_or_with_two_is_told(tmp_path, file, capsys, statement):
    shutil.copyfile(file, tmp_path / "whole.db")
    with closing(sqlite3.connect(file)) as raw:
        raw.execute(statement)
        raw.commit()
    for command in (("table", file), ("merge", tmp_path / "whole.db", file), ("merge", file, tmp_path / "whole.db"), ("forget", file, "a"),
                    ("archive", file, "--out", tmp_path / "a.zip"), ("plan", file), ("top-up", file), ("invite", file, "a")):  # fmt: skip
        assert "is damaged (it holds no study, or several)" in fails(capsys, *command)
