"""What the login of a volunteer can reach on a server: the own votes and what is to be judged, and nothing else."""

import contextlib
from collections.abc import Iterator
from typing import NamedTuple

import psycopg
import pytest
from judging_world import LAMP, ONE_TO_ONE, VASE, identity, result
from sqlalchemy import insert, update

from annotation import study
from annotation.server import invitations
from annotation.server.rules import VOLUNTEER_PATH
from annotation.storage import schema
from engine.errors import BadInput
from engine.shapes.result import ShapeRecord

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)
SECRETS = (
    "top-down", "secret_preset", "secret_set", "secret_file", "secret_reason", "secret_stratum", "secret_setting",
    "secret_seed", "bertha", "secret_comment", "secret_look", "secret_hash", "secret_pseudonym", "secret_run_file",
    "0.4375", "0.8125", "0.90625", "77777",
)  # fmt: skip
"""Planted in methods, presets, parameters, scores, gold marks, names of files, and in what others are and said."""



@contextlib.contextmanager
def planted(database: str) -> Iterator[study.StudyHandle]:
    """A study with everything in it that a volunteer may not know."""
    one, other = (ShapeRecord(f"secret_file_{s.file}", s.sha256, s.segments, s.faces) for s in (LAMP, VASE))
    found = result(*ONE_TO_ONE, source=one, target=other, preset="secret_preset", lfd_threshold=0.4375, seconds=77777.0)
    side = {"file": "secret_run_file", "sha256": "d" * 64, "pieces": 4}
    with study.create_study(database, name="Lamps", seed="secret_seed", settings={"a": "secret_setting"}) as handle:
        study.add_result(handle, found, set_name="secret_set")
        study.add_run(handle, study.Run("puzzle", "top-down", "secret_preset", {}, "secret_set", side, {}, {}, ()))
        study.record_vote(handle, FOOT, "bertha", "wrong", comment="secret_comment", presentation={"a": "secret_look"})
        study.record_vote(handle, STEM, "bertha", "unsure")
        study.undo_vote(handle, "bertha")
        with handle.writing() as connection:
            for item, role, answer, reason in (
                (FOOT, "gold", "correct", "secret_reason"), (STEM, "judged", None, ""), (SHADE, "practice", "wrong", "Turned."),
            ):  # fmt: skip
                connection.execute(insert(schema.asked).values(
                    item_id=item, role=role, answer=answer, reason=reason, stratum="secret_stratum", probability=0.8125,
                    overlapped=1, added_at=""))  # fmt: skip
            connection.execute(insert(schema.assignment).values(item_id=STEM, volunteer="bertha", made_at=""))
            connection.execute(insert(schema.forgotten).values(code_hash="secret_hash", pseudonym="secret_pseudonym", at=""))
            connection.execute(update(schema.run_match).values(score=0.90625))
        yield handle


class World(NamedTuple):
    """A planted study as its owner has it, and the personal address of anna, who has voted once."""

    owner: study.StudyHandle
    superuser: str
    address: str
    hers: str
    mine: str


@contextlib.contextmanager
def invited(database: str) -> Iterator[World]:
    with planted(database) as owner:
        address = invitations.invite(owner, "anna")
        with study.open_study(address) as anna:
            mine = study.record_vote(anna, STEM, "anna", "wrong", comment="my own words")
        (hers,) = study.current_votes(owner, volunteer="bertha")
        yield World(owner, database, address, hers.uuid, mine.uuid)


@pytest.fixture
def world(database):
    """One that a test may change."""
    with invited(database) as made:
        yield made


@pytest.fixture(scope="module")
def fixed(server):
    """One for tests that change nothing, and see to it."""
    with invited(server.database()) as made:
        yield made


@pytest.fixture(scope="module")
def connection(fixed):
    """What anna can do with her address and any other program."""
    with psycopg.connect(fixed.address, autocommit=True) as opened:
        opened.execute(f"SET search_path = {VOLUNTEER_PATH}")
        opened.execute("SET jit = off")
        yield opened


def test_a_volunteer_votes_through_the_same_functions(world):
    owner = world.owner
    with study.open_study(world.address) as anna:
        assert (anna.volunteer, study.about(anna).name) == ("anna", "Lamps")
        assert study.open_items(anna, "anna") == ((SHADE, 0), (FOOT, 1))
        assert study.practice(anna) == {SHADE: ("wrong", "Turned.")}
        study.record_vote(anna, SHADE, "anna", "wrong", round=0)
        second = study.record_vote(anna, STEM, "anna", "correct", shown_ms=900)
        assert (second.supersedes, second.clock) == (world.mine, 3)
        assert study.undo_vote(anna, "anna") == STEM
        assert study.answers(anna, "anna") == {STEM: "wrong"} == study.answers(owner, "anna")
        assert study.progress(anna, "anna")[:2] == (1, 2) == study.progress(owner, "anna")[:2]
        assert study.next_item(anna, "anna").id == FOOT
        assert study.ordered_ids(anna, "anna") == study.ordered_ids(owner, "anna")
        study.record_vote(anna, FOOT, "anna", "correct")
        assert study.next_item(anna, "anna") is None
    verdicts = {item: found.verdict for item, found in study.majority(owner).items()}
    assert verdicts == {FOOT: "tie", STEM: "wrong", SHADE: "unjudged"}


def everything(connection) -> dict[str, str]:
    """The content of every relation that the connection is able to read, as text."""
    relations = connection.execute(
        "SELECT quote_ident(table_schema) || '.' || quote_ident(table_name) FROM information_schema.tables UNION "
        "SELECT c.oid::regclass::text FROM pg_class AS c WHERE c.relkind IN ('r', 'v', 'm', 'f', 'p') UNION "
        "SELECT t.name FROM unnest(ARRAY['study', 'item', 'event', 'volunteer', 'blob', 'practice', 'open_item', "
        "'standing_vote', 'current_vote', 'run', 'asked', 'tally', 'wanted', 'invited']) AS t (name)"
    )
    found = {}
    for (name,) in relations.fetchall():
        try:
            found[name] = repr(connection.execute(f"SELECT t::text FROM {name} AS t").fetchall())
        except psycopg.Error:
            continue
    return found


def test_nothing_that_a_volunteer_can_read_holds_a_secret(connection):
    found = everything(connection)
    assert {"study", "item", "event", "volunteer", "practice", "open_item", "current_vote"} <= found.keys()
    assert not {"run", "asked", "tally", "wanted", "invited"} & found.keys()
    assert "my own words" in found["event"]
    assert FOOT in found["item"]
    assert {(name, secret) for name, text in found.items() for secret in SECRETS if secret in text} == set()


def test_the_secrets_are_there_for_the_owner(fixed):
    """Otherwise the search for them would prove nothing."""
    with psycopg.connect(fixed.superuser, autocommit=True) as connection:
        rows = (connection.execute(f"SELECT t::text FROM concord.{name} AS t").fetchall() for name in schema.metadata.tables)
        found = "".join(map(repr, rows))
    assert [secret for secret in SECRETS if secret not in found] == []


FORBIDDEN = [
    *(f"SELECT * FROM concord.{name}" for name in ("study", "item", "run", "run_match", "asked", "assignment", "forgotten",
      "invited", "tally", "wanted", "open_item", "practice", "standing_vote", "current_vote")),
    "INSERT INTO volunteer (code, seed, created_at) VALUES ('carl', '', '')",
    "INSERT INTO concord.asked VALUES ('{stem}', 'gold', 'correct', '', '', 1, 0, '')",
    "UPDATE event SET answer = 'correct'",
    "UPDATE event SET comment = 'x' WHERE volunteer = 'anna'",
    "UPDATE current_vote SET answer = 'correct'",
    "UPDATE standing_vote SET volunteer = 'bertha'",
    "UPDATE open_item SET round = 0",
    "UPDATE item SET payload = '{{}}'",
    "UPDATE study SET question = 'x'",
    "UPDATE volunteer SET adjudicates = 1",
    "UPDATE concord.version SET number = 1",
    "DELETE FROM event",
    "DELETE FROM concord.event WHERE volunteer = 'anna'",
    "DELETE FROM standing_vote",
    "DELETE FROM concord.volunteer",
    "DELETE FROM item",
    "TRUNCATE concord.event",
    "TRUNCATE concord.event CASCADE",
    "INSERT INTO blob VALUES ('x', '')",
    "DROP TABLE concord.event",
    "DROP VIEW blind.item",
    "DROP POLICY own_votes ON concord.event",
    "CREATE OR REPLACE VIEW blind.item AS SELECT * FROM concord.run",
    "CREATE TABLE concord.mine (a text)",
    "CREATE TABLE blind.mine (a text)",
    "CREATE TEMPORARY TABLE item (a text)",
    "CREATE FUNCTION blind.own_code() RETURNS text LANGUAGE sql AS 'SELECT 1'",
    "ALTER TABLE concord.event DISABLE TRIGGER ALL",
    "ALTER TABLE concord.event DISABLE ROW LEVEL SECURITY",
    "CREATE TRIGGER mine BEFORE INSERT ON concord.event FOR EACH ROW EXECUTE FUNCTION concord.refuse_change()",
    "SET session_replication_role = replica",
    "SET ROLE postgres",
    "SET SESSION AUTHORIZATION postgres",
    "CREATE ROLE friend LOGIN",
    "COPY concord.run TO STDOUT",
    "COPY concord.event TO PROGRAM 'cat'",
    "SELECT pg_read_file('PG_VERSION')",
    "SELECT * FROM pg_authid",
    "SELECT * FROM pg_statistic",
    "SELECT concord.refuse_change()",
    "SELECT * FROM event FOR UPDATE",
]  # fmt: skip


REFUSALS = (
    psycopg.errors.InsufficientPrivilege, psycopg.errors.ObjectNotInPrerequisiteState, psycopg.errors.FeatureNotSupported,
    psycopg.errors.WrongObjectType,
)  # fmt: skip


@pytest.mark.parametrize("statement", FORBIDDEN)
def test_a_volunteer_is_refused(fixed, connection, statement):
    before = study.current_votes(fixed.owner)
    with pytest.raises(REFUSALS):
        connection.execute(statement.format(stem=STEM))
    assert study.current_votes(fixed.owner) == before


EVENT = (
    "INSERT INTO {into} (uuid, kind, item_id, volunteer, round, answer, comment, supersedes, clock, presentation, "
    "app_version, created_at) VALUES ('new', {values}, 9, '{{}}', '', '')"
)


@pytest.mark.parametrize("into", ["event", "concord.event", "standing_vote", "current_vote"])
@pytest.mark.parametrize(
    "values",
    [
        "'vote', '{stem}', 'bertha', 1, 'correct', '', NULL",
        "'vote', '{stem}', 'bertha', 1, 'correct', '', '{hers}'",
        "'retraction', '{foot}', 'bertha', 1, NULL, '', '{hers}'",
        "'retraction', '{foot}', 'anna', 1, NULL, '', '{hers}'",
        "'vote', '{foot}', 'anna', 1, 'wrong', '', '{hers}'",
        "'retraction', '{foot}', 'anna', 1, NULL, '', '{mine}'",
    ],
)
def test_nobody_votes_as_somebody_else_nor_takes_back_a_vote_of_others(fixed, connection, into, values):
    before = study.current_votes(fixed.owner)
    filled = values.format(stem=STEM, foot=FOOT, hers=fixed.hers, mine=fixed.mine)
    with pytest.raises(REFUSALS):
        connection.execute(EVENT.format(into=into, values=filled))
    assert study.current_votes(fixed.owner) == before


def test_a_grant_by_mistake_still_shows_nothing(world):
    """Row-level security stands behind the missing rights."""
    with psycopg.connect(world.superuser, autocommit=True) as superuser:
        superuser.execute("GRANT USAGE ON SCHEMA concord TO PUBLIC")
        superuser.execute("GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA concord TO PUBLIC")
    with psycopg.connect(world.address, autocommit=True) as connection:
        for name in (*schema.metadata.tables, "invited"):
            seen = connection.execute(f"SELECT * FROM concord.{name}").fetchall()
            assert len(seen) == (name in ("volunteer", "event")), name
        assert connection.execute("UPDATE concord.asked SET role = 'judged'").rowcount == 0
        assert connection.execute("DELETE FROM concord.run").rowcount == 0
        with pytest.raises(psycopg.errors.InsufficientPrivilege, match="row-level security"):
            connection.execute("INSERT INTO concord.volunteer (code, seed, created_at) VALUES ('carl', '', '')")
    assert len(study.volunteers(world.owner)) == 2


def test_what_is_hidden_meets_no_condition_of_the_asker(connection):
    """A view that is no barrier would try the condition on hidden rows too, and fail on them."""
    asked = "SELECT * FROM current_vote WHERE 1 / (CASE volunteer WHEN 'bertha' THEN 0 ELSE 1 END) = 1"
    assert len(connection.execute(asked).fetchall()) == 1


def test_someone_else_cannot_vote_through_the_window_of_a_volunteer(fixed):
    with study.open_study(fixed.address) as anna:
        for code in ("bertha", "carl"):
            with pytest.raises(BadInput, match="anna alone") as caught:
                study.record_vote(anna, STEM, code, "wrong")
            assert "\n" not in str(caught.value)
        with pytest.raises(BadInput, match="lets anna vote with that address and do nothing else"):
            study.add_items(anna, [study.Item("x", "puzzle", {})])


def test_other_studies_on_the_server_are_out_of_reach(server, fixed):
    other = server.database()
    with study.create_study(other, name="Other") as handle:
        invitations.invite(handle, "carl")
    with pytest.raises(BadInput, match="does not let this user in"):
        study.open_study(fixed.address.rpartition("/")[0] + "/" + other.rpartition("/")[2])
