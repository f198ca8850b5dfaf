"""Studies on a server take part in every exchange: published, merged, handed out as packets, archived, forgotten."""

from pathlib import Path

import psycopg
import pytest
from exchange_world import PARTS, TABLES, ask, content, ids_of, strip_study
from test_volunteer_role import everything

from annotation import study
from annotation.exchange.archive import archive, unpack
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import Merged, merge
from annotation.exchange.packets import blinded, make_packet
from annotation.server import invitations
from annotation.server.publishing import publish
from annotation.server.rules import VOLUNTEER_PATH
from annotation.storage import schema
from annotation.storage.blobs import kept_shapes
from engine.errors import BadInput

VIEWS = (*TABLES, "current_vote", "open_item")


def on_server(address: str) -> dict[str, list]:
    """As `content` of a file."""
    with psycopg.connect(address) as connection:
        found = {}
        for name in VIEWS:
            columns = ", ".join(c.name for c in schema.metadata.tables[name].columns) if name in TABLES else "*"
            found[name] = sorted(connection.execute(f"SELECT {columns} FROM concord.{name}").fetchall(), key=repr)
        return found


@pytest.fixture
def file(tmp_path) -> Path:
    """A designed study with votes, shapes and an undo."""
    with strip_study(tmp_path / "a.db") as handle:
        gold, practice, *others = ids_of(handle)
        ask(handle, {gold: "gold", practice: "practice"}, reason="because")
        ask(handle, dict.fromkeys(others, "judged"))
        for number, item in enumerate(others):
            study.record_vote(handle, item, "anna" if number % 2 else "bert", "correct", comment="ünïcode", shown_ms=9)
        study.undo_vote(handle, "anna")
        study.record_vote(handle, others[0], "bert", "wrong")
    return tmp_path / "a.db"


def test_a_vote_that_lies_behind_the_one_in_its_place_is_archived(address, tmp_path):
    with study.open_study(address) as handle:
        with handle.rewriting() as connection:  # a server puts a row that is changed behind all others
            connection.exec_driver_sql("UPDATE event SET comment = 'moved' WHERE uuid IN (SELECT supersedes FROM event)")
        archive(handle, tmp_path / "a.zip")
    unpack(tmp_path / "a.zip", tmp_path / "out")
    assert content(tmp_path / "out" / "study.db")["event"] == on_server(address)["event"]


@pytest.fixture
def address(file, database) -> str:
    with study.open_study(file, backup=False) as handle:
        publish(handle, database)
    return database


def test_what_is_published_is_the_same_study(file, address):
    assert on_server(address) == content(file)
    with study.open_study(file, backup=False) as handle, pytest.raises(BadInput, match="holds a study already"):
        publish(handle, address)
    with study.open_study(file, backup=False) as handle, pytest.raises(BadInput, match="give an address"):
        publish(handle, str(file))


def test_copies_on_a_server_and_in_files_become_one_in_any_order(file, address, tmp_path):
    assert merge(address, file) == merge(file, address) == Merged(0, 0, 0, 0)
    with study.open_study(file, backup=False) as mine, study.open_study(address) as theirs:
        first, *_ = ids_of(mine)
        for handle, code in ((mine, "carl"), (theirs, "dora"), (theirs, "anna")):
            study.record_vote(handle, first, code, "unsure")
            study.undo_vote(handle, code)
            study.record_vote(handle, first, code, "wrong")
    assert merge(address, file).events == 3
    assert merge(file, address).events == 6
    assert on_server(address) == content(file)
    assert merge(address, file).events == merge(file, address).events == 0


def test_a_packet_from_a_server_comes_back_to_it(address, tmp_path):
    with study.open_study(address) as handle:
        study.volunteer(handle, "eva")
        made = make_packet(handle, "eva", tmp_path / "eva.db")
    assert (made.items, made.practice) == (PARTS - 1, 1)
    with study.open_study(tmp_path / "eva.db", backup=False) as packet:
        answered = [one.item_id for one in study.open_items(packet, "eva") if one.round]
        for item in answered:
            study.record_vote(packet, item, "eva", "correct")
    for _ in range(2):
        merge(address, tmp_path / "eva.db")
        with study.open_study(address) as handle:
            assert study.answers(handle, "eva") == dict.fromkeys(answered, "correct")


def test_an_archive_of_a_server_is_the_study(file, address, tmp_path):
    with study.open_study(address) as handle:
        archive(handle, tmp_path / "a.zip")
    assert content(unpack(tmp_path / "a.zip", tmp_path / "out")) == content(file)


@pytest.mark.parametrize("votes_too", [False, True])
def test_a_volunteer_is_forgotten_with_the_login(address, votes_too):
    with study.open_study(address) as owner:
        personal = invitations.invite(owner, "bert")
        verdicts = study.majority(owner)
        told = forget(owner, "bert", votes_too=votes_too)
        assert (told.kept == 0) == votes_too
        assert votes_too or study.majority(owner) == verdicts
        assert "bert" not in [voter.code for voter in study.volunteers(owner)]
        assert invitations.invited(owner) == ()
        with psycopg.connect(personal, autocommit=True) as connection:
            for name in ("study", "item", "practice", "open_item", "current_vote", "standing_vote"):
                assert connection.execute(f"SELECT * FROM blind.{name}").fetchall() == []
        with pytest.raises(BadInput), study.open_study(personal) as handle:
            study.record_vote(handle, ids_of(owner)[0], "bert", "wrong")
        invitations.invite(owner, "eva")
        with pytest.raises(BadInput, match="does not let this user in"):  # the login is gone with the next invitation
            study.open_study(personal)
        assert "bert" not in repr([row for name, row in on_server(address).items() if name != "blob"])
        with pytest.raises(Exception, match="only ever added"), owner.writing() as connection:
            connection.exec_driver_sql("DELETE FROM event")


def test_an_invited_volunteer_sees_the_items_of_a_packet_and_their_shapes(address):
    with study.open_study(address) as owner:
        personal = invitations.invite(owner, "eva")
        shown = {item.id: blinded(dict(item.payload)) for item in study.items(owner, "eva")}
        piece = {"piece": "p", "x": 1, "y": 2, "png": "AA"}
        join = {"size": [3, 4], "pieces": [piece, piece | {"x": 0}]}
        noted = join | {"score": 1, "pieces": [one | {"method": "mgc"} for one in join["pieces"]]}
        study.add_items(owner, [study.Item("join", "puzzle", noted)])
    with study.open_study(personal) as eva:
        assert {item.id: item.payload for item in study.items(eva, "eva")} == shown | {"join": join}
        first = next(item for item in study.items(eva, "eva") if item.kind == "shape")
        (found,) = kept_shapes(eva, first.payload["source"])
        assert len(found.mesh.faces) == 2 * PARTS


def test_what_an_invited_volunteer_reads_names_no_file(address):
    with study.open_study(address) as owner:
        personal = invitations.invite(owner, "eva")
    with psycopg.connect(personal, autocommit=True) as connection:
        connection.execute(f"SET search_path = {VOLUNTEER_PATH}; SET jit = off")
        texts = everything(connection)
    for secret in ("a.off", "b.off", "bert", "ünïcode", '"K"'):
        assert (secret, [name for name, text in texts.items() if secret in text]) == (secret, [])
