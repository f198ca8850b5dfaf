"""Delete me: the code leaves every byte of the study and its backups, and no merge brings it back."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from exchange_world import content, ids_of, strip_study

from annotation import study
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import merge
from annotation.exchange.packets import make_packet
from annotation.exchange.tombstones import Tombstones, day, joined, tombstone
from annotation.storage import schema
from annotation.storage.backup import back_up, every_backup
from engine.errors import BadInput

CODE = "anna-quillfeather"
COMMENT = "I know this lamp from home"


def voted(path: Path, **more) -> study.StudyHandle:
    """A study with votes of two, one of whom will ask to be deleted."""
    handle = strip_study(path, **more)
    for code in (CODE, "bert"):
        for item, answer in zip(ids_of(handle)[:3], ("correct", "wrong", "unsure"), strict=True):
            study.record_vote(handle, item, code, answer, comment=f"{COMMENT}, says {code}", presentation={"by": code})
        study.undo_vote(handle, code)
    return handle


def disk(folder: Path) -> bytes:
    """All bytes of all files of a folder, logs and backups with them."""
    return b"".join(path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file())


def test_the_code_is_in_no_byte_afterwards_and_the_votes_stay(tmp_path):
    handle = voted(tmp_path / "a.db", settings={"head": CODE})
    before = study.majority(handle)
    with closing(sqlite3.connect(tmp_path / "a.db")) as raw:
        back_up(raw, tmp_path / "a.db")
        back_up(raw, tmp_path / "a.db", "version-1")
    assert disk(tmp_path).count(CODE.encode()) > 10
    gone = forget(handle, CODE)
    assert (gone.kept, gone.removed, gone.mentions) == (4, 0, 0)
    assert gone.backups == (tuple(every_backup(tmp_path / "a.db")), ())
    assert len(gone.backups.rewritten) == 2
    assert CODE.encode() not in disk(tmp_path)
    assert f"{COMMENT}, says anna".encode() not in disk(tmp_path)
    assert study.majority(handle) == before
    assert study.about(handle).settings["head"] == gone.pseudonym
    events = [row for row in content(tmp_path / "a.db")["event"] if row[3] == gone.pseudonym]
    assert {row[6] for row in events} == {""}
    assert {row[13] for row in events} == {day(events[0][13])}
    assert {row[11] for row in events} == {"{}"}
    kept = [row for row in content(tmp_path / "a.db")["event"] if row[3] == "bert"]
    assert any(COMMENT in row[6] for row in kept)
    handle.close()
    assert CODE.encode() not in disk(tmp_path)
    with study.open_study(tmp_path / "a.db") as again, pytest.raises(sqlite3.IntegrityError, match="only ever added"):
        again._engine.raw_connection().execute("DELETE FROM event")


def test_the_votes_can_go_too(tmp_path):
    with voted(tmp_path / "a.db") as handle:
        gone = forget(handle, CODE, votes_too=True)
        assert (gone.kept, gone.removed) == (0, 4)
        assert {vote.volunteer for vote in study.current_votes(handle)} == {"bert"}
        assert gone.pseudonym not in {one.code for one in study.volunteers(handle)}
    assert CODE.encode() not in disk(tmp_path)


def test_votes_that_stayed_may_go_later_but_never_come_back(tmp_path):
    with voted(tmp_path / "b.db") as handle:
        new = forget(handle, CODE).pseudonym
        assert (forget(handle, new).kept, forget(handle, new, votes_too=True).removed) == (4, 4)
        assert len(content(tmp_path / "b.db")["forgotten"]) == 1
    with voted(tmp_path / "a.db") as handle:
        forget(handle, CODE)
        assert forget(handle, CODE, votes_too=True).removed == 4
        assert forget(handle, CODE) == forget(handle, CODE)
        assert {vote.volunteer for vote in study.current_votes(handle)} == {"bert"}


@pytest.mark.parametrize("votes_too", [False, True])
def test_no_copy_or_packet_brings_the_code_back(tmp_path, votes_too):
    handle = voted(tmp_path / "a.db")
    packet = make_packet(handle, CODE, tmp_path / "packet.db").path
    handle.purge()
    shutil.copy(tmp_path / "a.db", tmp_path / "old.db")
    with study.open_study(packet) as one:
        for item in study.open_items(one, CODE):
            study.record_vote(one, item.item_id, CODE, "wrong", comment="from the packet")
    gone = forget(handle, CODE, votes_too=votes_too)
    with study.open_study(tmp_path / "old.db") as old:
        study.record_vote(old, ids_of(old)[5], CODE, "wrong")
    for source in ("old.db", "packet.db"):
        merge(tmp_path / "a.db", tmp_path / source)
    votes = [vote for vote in study.current_votes(handle) if vote.volunteer == gone.pseudonym]
    assert len(votes) == (0 if votes_too else 6)
    handle.purge()
    for name in ("a.db", "a.db-wal"):
        assert CODE.encode() not in (tmp_path / name).read_bytes()
    merge(tmp_path / "old.db", tmp_path / "a.db")  # and the other way round: the old copy forgets too
    assert CODE.encode() not in (tmp_path / "old.db").read_bytes()
    assert not [copy for copy in every_backup(tmp_path / "old.db") if CODE.encode() in copy.read_bytes()]
    assert content(tmp_path / "old.db")["event"] == content(tmp_path / "a.db")["event"]
    handle.close()


def test_a_deleted_code_is_not_given_again(tmp_path):
    with voted(tmp_path / "a.db") as handle:
        forget(handle, CODE)
        with pytest.raises(BadInput, match="take another code"):
            study.record_vote(handle, ids_of(handle)[0], CODE, "correct")
        with pytest.raises(BadInput, match="take another code"):
            study.volunteer(handle, CODE)
        study.record_vote(handle, ids_of(handle)[0], "anna", "correct")


def test_texts_that_others_wrote_are_counted_not_changed(tmp_path):
    with voted(tmp_path / "a.db", guideline=f"Ask {CODE}.") as handle:
        study.record_vote(handle, ids_of(handle)[4], "bert", "wrong", comment=f"{CODE} said so")
        assert forget(handle, CODE).mentions == 2


def test_backups_that_cannot_be_rewritten_are_removed(tmp_path):
    with voted(tmp_path / "a.db") as handle:
        with closing(sqlite3.connect(tmp_path / "a.db")) as raw:
            old, damaged = back_up(raw, tmp_path / "a.db", "version-1"), back_up(raw, tmp_path / "a.db")
            innocent = back_up(raw, tmp_path / "a.db", "version-0")
        with closing(sqlite3.connect(innocent)) as raw:
            raw.executescript("DROP TRIGGER event_never_deleted; DELETE FROM event; DELETE FROM volunteer; VACUUM")
            raw.execute(next(sql for sql in schema.SQLITE_TRIGGERS if "never_deleted" in sql))
        for copy in (old, innocent):
            with closing(sqlite3.connect(copy)) as raw:
                raw.execute("PRAGMA user_version=1")
        damaged.write_bytes(damaged.read_bytes()[:5000])
        assert forget(handle, CODE).backups == ((), (damaged, old))
        assert every_backup(tmp_path / "a.db") == [innocent]
    assert CODE.encode() not in disk(tmp_path)


def test_what_cannot_be_deleted_is_told_and_changes_nothing(tmp_path):
    with voted(tmp_path / "a.db") as handle:
        before = content(tmp_path / "a.db")
        with pytest.raises(BadInput, match="no volunteer carl"):
            forget(handle, "carl")
        assert content(tmp_path / "a.db") == before
        packet = make_packet(handle, CODE, tmp_path / "p.db").path
    with study.open_study(packet) as one, pytest.raises(BadInput, match="for one volunteer alone"):
        forget(one, CODE)


def test_a_reader_elsewhere_is_named_and_asking_again_cleans_up(tmp_path):
    voted(tmp_path / "a.db").close()
    with study.open_study(tmp_path / "a.db") as handle, study.open_study(tmp_path / "a.db", busy_seconds=0.2) as impatient:
        with handle.reading() as reader:
            reader.exec_driver_sql("SELECT * FROM event").all()
            with pytest.raises(BadInput, match="close it there and do this again"):
                forget(impatient, CODE)
        assert CODE not in {one.code for one in study.volunteers(handle)}
        forget(impatient, CODE)
    assert CODE.encode() not in disk(tmp_path)


def test_tombstones_are_joined_alike_in_any_order():
    kept, dropped = (tombstone("s", CODE, votes_kept=keep, at=at) for keep, at in ((True, "2026-01-02T1"), (False, "2026-03-04T5")))
    assert joined(kept, dropped) == joined(dropped, kept) == kept._replace(votes_kept=0)
    assert kept.at == "2026-01-02T00:00:00.000000+00:00"
    assert Tombstones("s", [kept]).of(CODE) == Tombstones("s", [kept]).of(kept.pseudonym) == kept
    assert Tombstones("other", [kept]).of(CODE) is None
    assert CODE not in repr(kept)


def test_a_backup_that_cannot_be_removed_is_told(tmp_path, monkeypatch):
    handle = voted(tmp_path / "a.db")
    with closing(sqlite3.connect(tmp_path / "a.db")) as raw:
        kept = back_up(raw, tmp_path / "a.db")
    kept.write_bytes(kept.read_bytes()[:5000])

    def refuse(self: Path, missing_ok: bool = False) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "unlink", refuse)
    with pytest.raises(BadInput, match=r"still names the volunteer and cannot be removed \(Permission denied\)"):
        forget(handle, CODE)
    monkeypatch.undo()
    assert forget(handle, CODE).backups.removed == (kept,)
    handle.close()
