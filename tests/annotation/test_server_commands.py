"""`concord study invite` and `uninvite`: who gets an address, and what ends it."""

import re
import secrets

import psycopg
import pytest
from judging_world import LAMP, VASE, identity, result, study_of

from annotation import study
from annotation.__main__ import main
from annotation.server import invitations
from engine.errors import BadInput, BadParameter
from engine.matchfile import write_matches

FOOT = identity(LAMP, (0,), VASE, (0,))


@pytest.fixture
def address(database):
    study_of(database).close()
    return database


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def printed(capsys, *arguments: object) -> str:
    """What a command that succeeds prints."""
    assert run(*arguments) == 0
    return capsys.readouterr().out


def fails(capsys, *arguments: object) -> str:
    """The one sentence of a command that is refused."""
    assert run(*arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.strip().count("\n") == 0
    return said.err


def personal(text: str) -> str:
    (found,) = re.findall(r"postgresql://concord_\w+:[\w-]{32}@[^\s']+", text)
    return found


def test_an_invitation_is_an_address_with_which_one_may_vote(address, capsys):
    given = personal(printed(capsys, "invite", address, "anna"))
    assert run("vote", given, "--volunteer", "anna", "--item", FOOT, "--answer", "correct") == 0
    capsys.readouterr()
    assert "anna alone" in fails(capsys, "vote", given, "--volunteer", "bert", "--item", FOOT, "--answer", "wrong")
    with study.open_study(address) as owner, study.open_study(given) as anna:
        assert study.answers(owner, "anna") == study.answers(anna, "anna") == {FOOT: "correct"}
        assert invitations.invited(owner) == ("anna",)


def test_a_second_invitation_is_asked_for_and_ends_the_first(address, capsys):
    first = personal(printed(capsys, "invite", address, "anna"))
    assert "give --again" in fails(capsys, "invite", address, "anna")
    assert "never invited; leave out --again" in fails(capsys, "invite", address, "bert", "--again")
    second = personal(printed(capsys, "invite", address, "anna", "--again"))
    assert first.split(":")[1] == second.split(":")[1] != ""
    with pytest.raises(BadInput, match="does not let this user in"):
        study.open_study(first)
    study.open_study(second).close()


def test_who_is_uninvited_is_out_at_once_and_the_votes_stay(address, capsys):
    given = personal(printed(capsys, "invite", address, "anna"))
    with study.open_study(given) as window, psycopg.connect(given, autocommit=True) as other:
        study.record_vote(window, FOOT, "anna", "wrong")
        assert "the votes stay" in printed(capsys, "uninvite", address, "anna")
        with pytest.raises(BadInput):
            study.record_vote(window, FOOT, "anna", "correct")
        with pytest.raises(psycopg.OperationalError):
            other.execute("SELECT 1")
    assert "no invited volunteer anna" in fails(capsys, "uninvite", address, "anna")
    with study.open_study(address) as owner:
        assert study.answers(owner, "anna") == {FOOT: "wrong"}
    personal(printed(capsys, "invite", address, "anna"))


def test_one_who_is_uninvited_but_still_connected_sees_nothing(server, address):
    """Where the researcher may not end connections of others."""
    with study.open_study(address) as owner:
        given = invitations.invite(owner, "anna")
        with psycopg.connect(given, autocommit=True) as connection:
            server.sql("DELETE FROM concord.invited", address.rpartition("/")[2])
            for name in ("concord.event", "concord.volunteer", "concord.blob", "blind.study", "blind.item", "blind.open_item"):
                assert connection.execute(f"SELECT * FROM {name}").fetchall() == []


def test_an_adjudicator_is_asked_what_is_disputed(address, capsys):
    given = personal(printed(capsys, "invite", address, "judge", "--adjudicator"))
    with study.open_study(address) as owner, study.open_study(given) as judge:
        assert study.volunteer(judge, "judge").adjudicates
        assert study.open_items(judge, "judge") == ()
        study.record_vote(owner, FOOT, "anna", "wrong")
        study.record_vote(owner, FOOT, "bert", "correct")
        assert study.open_items(judge, "judge") == ((FOOT, 1),)


def test_a_researcher_may_do_everything_but_change_votes_and_invite(address, capsys):
    found = re.findall(r"postgresql://concord_\S+", printed(capsys, "invite", address, "--researcher"))
    with study.open_study(found[0]) as other:
        assert other.volunteer is None
        study.add_result(other, result(((0, 1), (1,))))
        study.record_vote(other, FOOT, "anna", "wrong")
        assert study.about(other).seed == "seed"
        assert len(study.majority(other)) == 4
        with pytest.raises(BadInput, match="does not let this user make logins"):
            invitations.invite(other, "bert")
        for statement in ("DELETE FROM event", "UPDATE event SET answer = 'correct'", "SELECT * FROM invited",
                          "DELETE FROM version", "ALTER TABLE event DISABLE TRIGGER ALL"):  # fmt: skip
            with pytest.raises(BadInput, match="does not let this user do that"), other.writing() as connection:
                connection.exec_driver_sql(statement)
        with pytest.raises(BadInput, match="does not let this user do that"), other.rewriting():
            pass


def test_one_who_may_not_make_logins(server, capsys):
    name = f"owner_{secrets.token_hex(4)}"
    server.sql(f"CREATE ROLE {name} LOGIN PASSWORD 's3cret'")
    server.sql(f"CREATE DATABASE {name} OWNER {name}")
    mine = server.url(name, user=name, password="s3cret")
    study_of(mine).close()
    assert "CREATEROLE" in fails(capsys, "invite", mine, "anna")
    server.sql(f"ALTER ROLE {name} CREATEROLE")
    given = personal(printed(capsys, "invite", mine, "anna"))
    with study.open_study(given) as anna, study.open_study(mine) as owner:
        study.record_vote(anna, FOOT, "anna", "wrong")
        assert study.next_item(anna, "anna") is not None
        assert study.answers(owner, "anna") == {FOOT: "wrong"}
        assert study.majority(owner)[FOOT] == (0, 1, 0, "wrong")
    assert "the votes stay" in printed(capsys, "uninvite", mine, "anna")


def test_the_log_of_the_server_holds_no_password(server, address):
    server.sql("ALTER SYSTEM SET log_statement = 'all'")
    server.sql("SELECT pg_reload_conf()")
    try:
        with study.open_study(address) as owner:
            password = invitations.invite(owner, "anna").split(":")[2].partition("@")[0]
            again = invitations.invite(owner, "anna", again=True).split(":")[2].partition("@")[0]
    finally:
        server.sql("ALTER SYSTEM RESET log_statement")
        server.sql("SELECT pg_reload_conf()")
    log = (server.folder / "log").read_text()
    assert "CREATE ROLE concord_" in log
    assert password not in log
    assert again not in log


def test_a_file_has_volunteers_and_no_logins(tmp_path, capsys):
    file = tmp_path / "a.db"
    study_of(file).close()
    said = printed(capsys, "invite", file, "judge", "--adjudicator")
    assert f"concord study packet {file} judge" in said
    with study.open_study(file) as handle:
        assert study.volunteer(handle, "judge").adjudicates
    for arguments in (("invite", file, "anna", "--again"), ("invite", file, "--researcher"), ("uninvite", file, "anna")):
        assert "is a file, which has no logins" in fails(capsys, *arguments)
    assert "Say who is invited" in fails(capsys, "invite", file)
    assert "volunteer code" in fails(capsys, "invite", file, "a b")


def test_codes_are_checked_before_anything_is_made(address):
    with study.open_study(address) as owner:
        for code in ("a'b", "a b", ""):
            with pytest.raises(BadParameter, match="volunteer code"):
                invitations.invite(owner, code)
        assert invitations.invited(owner) == ()


def test_a_study_on_a_server_from_the_command_line(database, tmp_path, capsys):
    write_matches(result(), tmp_path)
    assert "of-the-owner" not in printed(capsys, "create", database, "--name", "Lamps")
    study_of(tmp_path / "b.db").close()
    said = printed(capsys, "merge", database, tmp_path / "b.db", "--another-study")
    assert "3 matches" in said
    assert "of-the-owner" not in said
    assert run("vote", database, "--new", "--volunteer", "anna", "--item", FOOT, "--answer", "correct") == 0
    capsys.readouterr()
    assert "1 of 3" in printed(capsys, "table", database)
    assert "correct" in printed(capsys, "votes", database)
