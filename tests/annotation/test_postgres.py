"""Studies on a server: every way in which one can be unusable, and many who vote at once."""

import contextlib
import random
import socket
import subprocess
import sys
import threading
from pathlib import Path

import psycopg
import pytest
from judging_world import LAMP, VASE, identity, study_of
from postgres_server import running
from server_killing import kill_merging, kill_voting

from annotation import study
from annotation.server import errors as servererrors
from annotation.server import invitations, postgres
from annotation.storage import schema
from engine.errors import BadInput

FOOT = identity(LAMP, (0,), VASE, (0,))
SECRET = "of-the-owner"  # the password in the addresses of the tests' server


def refused(address: str, words: str, call=study.open_study) -> None:
    """One sentence that says these words and holds no password."""
    with pytest.raises(BadInput, match=words) as caught:
        call(address).close()
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    assert SECRET not in sentence
    assert "s3cret" not in sentence


@pytest.fixture
def address(database):
    """A study with one vote, closed."""
    with study_of(database) as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
    return database


@pytest.mark.parametrize(
    "broken",
    ["postgresql://", "postgresql://localhost", "postgresql://u:s3cret@h:port/db", "postgresql://u:s3cret@[::/db", "postgresql:x"],
)
def test_addresses_that_are_none(broken):
    refused(broken, "no address of a study")


def test_an_address_is_named_without_user_and_password():
    url = postgres.server_url("postgresql://u:s3cret@host:5433/db?password=s3cret&sslmode=require")
    assert postgres.named(url) == "postgresql://host:5433/db"
    assert postgres.named(postgres.server_url("postgres:///db?host=/run")) == "postgresql:///db"


def test_out_of_reach():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        refused(f"postgresql://u:s3cret@127.0.0.1:{probe.getsockname()[1]}/db", "cannot be reached")
    refused("postgresql://u:s3cret@no-such-host.invalid/db", "cannot be reached")


def test_a_server_that_never_answers_is_given_up(monkeypatch):
    monkeypatch.setitem(postgres._NETWORK, "connect_timeout", 2)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        refused(f"postgresql://u:s3cret@127.0.0.1:{silent.getsockname()[1]}/db", "cannot be reached")


def test_wrong_password_and_user(server, address):
    name = address.rpartition("/")[2]
    refused(server.url(name, password="s3cret"), "does not let this user in")
    refused(server.url(name, user="nobody_known"), "does not let this user in")


def test_no_such_database(server):
    refused(server.url("nowhere"), "does not exist on that server")
    refused(server.url("nowhere"), "does not exist on that server", lambda a: study.create_study(a, name="a"))


def test_a_database_without_a_study(server, database):
    refused(database, "holds no study")
    server.sql("CREATE SCHEMA concord; CREATE TABLE concord.version (x text)", database.rpartition("/")[2])
    refused(database, "holds no study")
    refused(database, "holds a study already", lambda a: study.create_study(a, name="a"))


def test_a_study_is_never_made_over_another(address):
    refused(address, "holds a study already", lambda a: study.create_study(a, name="again"))
    with study.open_study(address) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}


def test_two_who_create_the_same_study_at_once(database):
    made, refusals = [], []

    def create():
        try:
            study.create_study(database, name="a").close()
            made.append(1)
        except BadInput as error:
            refusals.append(str(error))

    rivals = [threading.Thread(target=create) for _ in range(4)]
    for rival in rivals:
        rival.start()
    for rival in rivals:
        rival.join()
    assert (len(made), len(refusals)) == (1, 3)
    assert all("holds a study already" in sentence for sentence in refusals)


def test_making_a_study_that_fails_leaves_nothing(database):
    def fail(_connection):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        postgres.create_server(database, fail)
    study.create_study(database, name="a").close()


def test_newer(server, address):
    server.sql("UPDATE concord.version SET number = 99", address.rpartition("/")[2])
    refused(address, "newer Concord .study version 99")


def test_older_is_migrated_by_the_researcher_alone(server, address, monkeypatch):
    with study.open_study(address) as handle:
        personal = invitations.invite(handle, "anna")
    monkeypatch.setattr(schema, "SCHEMA_VERSION", schema.SCHEMA_VERSION + 1)
    from annotation.storage import migrations

    step = "ALTER TABLE item ADD COLUMN x text; ALTER TABLE run DISABLE ROW LEVEL SECURITY"
    monkeypatch.setitem(migrations.STEPS, schema.SCHEMA_VERSION - 1, lambda op: op.execute(step))
    refused(personal, "older version; the researcher has to open it once")
    for _ in range(2):
        with study.open_study(address) as handle:
            assert study.answers(handle, "anna") == {FOOT: "correct"}
    with study.open_study(personal) as anna:
        study.record_vote(anna, FOOT, "anna", "wrong")
        assert study.answers(anna, "anna") == {FOOT: "wrong"}
    bare = "SELECT relname FROM pg_class WHERE relkind = 'r' AND relnamespace = 'concord'::regnamespace AND NOT relrowsecurity"
    assert server.sql(bare, address.rpartition("/")[2]) == []
    assert server.sql("SELECT number FROM concord.version", address.rpartition("/")[2]) == [(schema.SCHEMA_VERSION,)]


def test_a_user_without_rights(server, address):
    server.sql("CREATE ROLE stranger LOGIN PASSWORD 's3cret'")
    name = address.rpartition("/")[2]
    refused(server.url(name, user="stranger", password="s3cret"), "ask to be invited")
    empty = server.database().rpartition("/")[2]
    refused(server.url(empty, user="stranger", password="s3cret"), "may create studies", lambda a: study.create_study(a, name="a"))


def test_read_only(server, address):
    server.sql(f"ALTER DATABASE {address.rpartition('/')[2]} SET default_transaction_read_only = on")
    with study.open_study(address) as handle:
        with pytest.raises(BadInput, match="is read-only"):
            study.record_vote(handle, FOOT, "bert", "wrong")
        assert study.answers(handle, "anna") == {FOOT: "correct"}


@pytest.mark.parametrize(("state", "words"), [("disk_full", "disk of the server is full"), ("out_of_memory", "out of resources"),
                                              ("deadlock_detected", "at the same moment"), ("query_canceled", "took too long"),
                                              ("data_corrupted", "restore"), ("io_error", "refused .something new.")])  # fmt: skip
def test_what_the_server_says_in_the_middle(server, address, state, words):
    """A server that fails so is too much to ask; one that says so is enough."""
    name = address.rpartition("/")[2]
    server.sql(f"CREATE FUNCTION fails() RETURNS trigger LANGUAGE plpgsql AS "
               f"$$ BEGIN RAISE EXCEPTION 'something new' USING ERRCODE = '{state}'; END $$", name)  # fmt: skip
    server.sql("CREATE TRIGGER fails BEFORE INSERT ON concord.event FOR EACH ROW EXECUTE FUNCTION fails()", name)
    with study.open_study(address) as handle:
        with pytest.raises(BadInput, match=words):
            study.record_vote(handle, FOOT, "bert", "wrong")
        server.sql("DROP TRIGGER fails ON concord.event", name)
        study.record_vote(handle, FOOT, "bert", "wrong")
        assert study.majority(handle)[FOOT] == (1, 1, 0, "tie")


def test_text_that_no_database_takes(address):
    with study.open_study(address) as handle:
        with pytest.raises(BadInput, match="cannot keep this text"):
            study.record_vote(handle, FOOT, "bert", "wrong", comment="a\0b")
        assert study.answers(handle, "bert") == {}


def test_a_connection_lost_in_the_middle(server, address):
    """The vote is not taken, which is said; the next one finds its way by itself."""
    name = address.rpartition("/")[2]
    end = f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '{name}' AND pid <> pg_backend_pid()"
    with study.open_study(address) as handle:
        study.record_vote(handle, FOOT, "bert", "wrong")
        server.sql(end)
        study.record_vote(handle, FOOT, "bert", "correct")  # an idle connection that is gone is made anew unnoticed

        def lose():
            with handle.writing() as connection:
                connection.exec_driver_sql("INSERT INTO volunteer (code, seed, created_at) VALUES ('carl', '', '')")
                server.sql(end)

        with pytest.raises(BadInput, match="lost the connection before that was confirmed"):
            lose()
        assert [voter.code for voter in study.volunteers(handle)] == ["anna", "bert"]
        study.record_vote(handle, FOOT, "bert", "wrong")
        assert study.majority(handle)[FOOT] == (1, 1, 0, "tie")


def test_a_server_that_stops_and_comes_back(server, own):
    with study_of(own.database()) as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
        own.control("stop", "-m", "immediate")
        with pytest.raises(BadInput, match="lost the connection"):
            study.record_vote(handle, FOOT, "anna", "wrong")
        refused(handle.url.render_as_string(hide_password=False), "cannot be reached")
        own.control("start")
        assert study.answers(handle, "anna") == {FOOT: "correct"}
        study.record_vote(handle, FOOT, "anna", "wrong")
        assert study.answers(handle, "anna") == {FOOT: "wrong"}


def test_a_study_held_by_another_program(address, monkeypatch):
    monkeypatch.setattr(postgres, "LOCK_SECONDS", 0.2)
    with study.open_study(address) as one, study.open_study(address) as other, one.writing():
        with pytest.raises(BadInput, match="held by another program"):
            study.record_vote(other, FOOT, "bert", "wrong")
        assert study.answers(other, "anna") == {FOOT: "correct"}  # readers never wait


CHANGES = (
    "UPDATE concord.event SET answer = 'wrong'",
    "DELETE FROM concord.event",
    "DELETE FROM concord.event WHERE false",
    "TRUNCATE concord.event",
    "SET session_replication_role = replica; DELETE FROM concord.event",
    "INSERT INTO concord.event SELECT * FROM concord.event ON CONFLICT (uuid) DO UPDATE SET comment = ''",
)


def test_the_log_of_votes_cannot_be_changed(address):
    """Not even by its owner with another program, short of taking the guard away."""
    with psycopg.connect(address, autocommit=True) as connection:
        for statement in CHANGES:
            with pytest.raises(psycopg.errors.RestrictViolation, match="only ever added"):
                connection.execute(statement)
        with pytest.raises(psycopg.errors.UniqueViolation):
            connection.execute("INSERT INTO concord.event SELECT * FROM concord.event")
    with study.open_study(address) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}


def test_events_are_rewritten_only_where_that_is_said_and_the_guard_returns(address):
    with study.open_study(address) as handle:
        with handle.rewriting() as connection:
            connection.exec_driver_sql("UPDATE event SET comment = ''")
        with contextlib.suppress(ZeroDivisionError), handle.rewriting() as connection:
            connection.exec_driver_sql("DELETE FROM event")
            raise ZeroDivisionError
        handle.purge()
        with pytest.raises(Exception, match="only ever added"), handle.writing() as connection:
            connection.exec_driver_sql("DELETE FROM event")
        assert study.answers(handle, "anna") == {FOOT: "correct"}


def test_sentences_for_states_without_a_case():
    class Said(Exception):
        sqlstate = "58030"

    assert servererrors.explained("here", Said("disk on fire\nDETAIL")) == (
        "here refused (disk on fire), so nothing was saved; try again."
    )


def test_windows_of_one_volunteer_share_one_clock(address):
    """Threads of several windows, by the personal address: no number of the clock is given twice."""
    with study.open_study(address) as owner:
        personal = invitations.invite(owner, "bert")
        windows = [study.open_study(personal) for _ in range(3)]
        voters = [threading.Thread(target=vote_often, args=(window, "bert")) for window in windows for _ in range(2)]
        for voter in voters:
            voter.start()
        for voter in voters:
            voter.join()
        for window in windows:
            window.close()
        with owner.reading() as connection:
            clocks = connection.exec_driver_sql("SELECT clock FROM event WHERE volunteer = 'bert' ORDER BY clock").scalars().all()
            chain = connection.exec_driver_sql("SELECT count(DISTINCT supersedes) FROM event WHERE volunteer = 'bert'").scalar()
        assert clocks == list(range(1, 61))
        assert chain == 59  # each vote replaces the one before it


def vote_often(handle, code):
    for _ in range(10):
        study.record_vote(handle, FOOT, code, "correct")


VOTER = """
import random, sys, time
from annotation import study
address, seconds = sys.argv[1], float(sys.argv[2])
with study.open_study(address) as handle:
    code = handle.volunteer
    draw = random.Random(code)
    ids = [item.id for item in study.items(handle, code)]
    print("ready", flush=True)
    sys.stdin.readline()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if draw.random() < 0.1:
            study.undo_vote(handle, code)
            continue
        vote = study.record_vote(handle, draw.choice(ids), code, draw.choice(study.ANSWERS))
        print(vote.uuid, flush=True)
"""


def test_processes_of_volunteers_beside_the_researcher(address):
    """Each with a login of its own; all that was confirmed is there, once, and under the right name."""
    with study.open_study(address) as owner, contextlib.ExitStack() as stack:
        people = {code: invitations.invite(owner, code) for code in ("v1", "v2", "v3", "v4")}
        pipe = subprocess.PIPE
        voters = {
            code: stack.enter_context(subprocess.Popen([sys.executable, "-c", VOTER, personal, "1.5"], stdin=pipe, stdout=pipe,
                                      stderr=pipe, text=True, cwd=Path(__file__).parents[2]))
            for code, personal in people.items()
        }  # fmt: skip
        for voter in voters.values():
            assert voter.stdout.readline() == "ready\n", voter.stderr.read()
        for voter in voters.values():
            voter.stdin.write("\n")
            voter.stdin.flush()
        study.record_votes(owner, "researcher", dict.fromkeys(study.ordered_ids(owner, "anna"), "wrong"))
        for code, voter in voters.items():
            output, errors = voter.communicate(timeout=60)
            assert (voter.returncode, errors) == (0, "")
            with owner.reading() as connection:
                kept = connection.exec_driver_sql(f"SELECT uuid FROM event WHERE kind = 'vote' AND volunteer = '{code}'")
                assert set(kept.scalars()) == set(output.split())
            assert len(output.split()) > 10


@pytest.fixture(scope="module")
def own():
    """A server that may be killed."""
    with running() as started:
        yield started


@pytest.mark.parametrize("seed", [1, 2])  # of a volunteer's process, and of the server
def test_no_confirmed_vote_is_lost_by_a_kill(server, own, seed):
    assert (random.Random(seed).random() < 0.5) == (seed == 1)
    found = kill_voting(own, random.Random(seed))
    assert found.cut
    assert (found.lost, found.misattached) == (0, 0)


def test_a_merge_cut_by_a_crash_is_whole_or_not_there(server, own, tmp_path):
    found = kill_merging(own, tmp_path, random.Random(3), votes=100)
    assert (found.confirmed, found.lost, found.misattached) == (100, 0, 0)
