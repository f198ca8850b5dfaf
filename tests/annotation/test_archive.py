"""Archives: a whole study in one zip that can be checked, and one from which nothing leads back to volunteers."""

import hashlib
import json
import sqlite3
import zipfile
from contextlib import closing
from pathlib import Path

import pytest
from exchange_world import ask, cells, content, ids_of, strip_study

from annotation import study
from annotation.exchange.anonymising import Anonymous
from annotation.exchange.archive import archive, unpack
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import merge
from annotation.exchange.packets import make_packet
from engine.errors import BadInput

CODES = ("anna-quill", "bert-quill", "zoe-quill")


@pytest.fixture
def whole(tmp_path):
    files = ("/data/secret-folder/a.off", r"C:\secret-folder\b.off")
    settings = {"tops_up": "another", "head": CODES[0], "files": ["~/secret-folder/x.json"], "share": 0.2}
    with strip_study(tmp_path / "a.db", files=files, votes=2, settings=settings) as handle:
        ids = ids_of(handle)
        ask(handle, {ids[0]: "gold"} | dict.fromkeys(ids[1:], "judged"))
        for number, code in enumerate(CODES):
            for item in ids[: 3 + number]:
                study.record_vote(handle, item, code, study.ANSWERS[(number + ids.index(item)) % 3], comment=f"{code} here",
                                  shown_ms=500, presentation={"swapped": True, "screen": "secret-folder"})  # fmt: skip
            study.undo_vote(handle, code)
            study.record_vote(handle, ids[0], code, "correct")
        make_packet(handle, CODES[2], tmp_path / "p.db")
        yield handle


def test_an_archive_is_the_whole_study_and_its_exports(whole, tmp_path):
    made = archive(whole, tmp_path / "a.zip")
    assert unpack(made.path, tmp_path / "out") == tmp_path / "out" / "study.db"
    assert content(tmp_path / "out" / "study.db") == content(tmp_path / "a.db")
    readme = (tmp_path / "out" / "README.txt").read_text()
    for file, found in made.sums.items():
        assert f"{found}  {file}" in readme
        assert hashlib.sha256((tmp_path / "out" / file).read_bytes()).hexdigest() == found
    assert {"exports/votes.csv", "exports/gold.csv", "exports/dictionary.md"} < set(made.sums)
    assert merge(tmp_path / "a.db", tmp_path / "out" / "study.db") == (0, 0, 0, 0, 0)
    with pytest.raises(BadInput, match="exists already"):
        archive(whole, tmp_path / "a.zip")


def everything(folder: Path) -> str:
    """All that the files of an archive say."""
    raw = "".join(path.read_bytes().decode("utf-8", "replace") for path in folder.rglob("*") if path.is_file())
    return raw + cells(folder / "study.db")


def test_an_anonymous_archive_leads_back_to_nobody(whole, tmp_path):
    forget(whole, "nobody")
    codes = [one.code for one in study.volunteers(whole)]
    archive(whole, tmp_path / "a.zip", Anonymous(codes))
    told = everything(unpack(tmp_path / "a.zip", tmp_path / "out").parent)
    with whole.reading() as connection:
        uuids = connection.exec_driver_sql("SELECT uuid FROM event").scalars().all()
        times = connection.exec_driver_sql("SELECT created_at FROM event").scalars().all()
        seeds = connection.exec_driver_sql("SELECT seed FROM volunteer").scalars().all()
    for secret in (*CODES, *uuids, *times, *seeds, "secret-folder", " here", study.about(whole).id, "deleted-"):
        assert secret not in told
    for kept in ("a.off", "b.off", "x.json", "v01", "v04", "swapped"):
        assert kept in told


def verdicts(path: Path) -> list[tuple]:
    """What counts, without who said it."""
    with closing(sqlite3.connect(path)) as raw:
        counted = raw.execute("SELECT item_id, round, answer FROM current_vote ORDER BY item_id, round, answer").fetchall()
        each = raw.execute("SELECT group_concat(kind || COALESCE(answer, '') || item_id, ' ') FROM "
                           "(SELECT * FROM event ORDER BY volunteer, clock) GROUP BY volunteer").fetchall()  # fmt: skip
    return [*counted, *sorted(each)]


def test_what_counts_stays_as_it_was(whole, tmp_path):
    archive(whole, tmp_path / "a.zip", Anonymous([one.code for one in study.volunteers(whole)], comments=True))
    found = unpack(tmp_path / "a.zip", tmp_path / "out")
    assert verdicts(found) == verdicts(tmp_path / "a.db")
    with study.open_study(found) as handle:
        assert {vote.comment[-5:] for vote in study.current_votes(handle)} == {" here", ""}
        assert study.about(handle).settings["share"] == 0.2
    with pytest.raises(BadInput, match="another study"):
        merge(tmp_path / "a.db", found)


def test_votes_of_parallel_copies_keep_their_order_without_times(whole):
    """Two events of one number are told apart by their time, which goes; so they are numbered anew."""
    rows = [
        {"uuid": uuid, "clock": 1, "created_at": at, "volunteer": "anna", "supersedes": None, "comment": "", "presentation": "{}",
         "answer": answer}
        for uuid, at, answer in (("b", "2026-01-01T10", "first"), ("a", "2026-01-01T11", "last"))
    ]  # fmt: skip
    changed = Anonymous(["anna"]).rows("event", rows)
    assert [(row["answer"], row["clock"]) for row in changed] == [("first", 1), ("last", 2)]


def rezipped(source: Path, target: Path, change) -> Path:
    """A zip with changed entries: `change` takes and gives a dict from name to bytes."""
    with zipfile.ZipFile(source) as packed:
        entries = {name: packed.read(name) for name in packed.namelist()}
    with zipfile.ZipFile(target, "w") as packed:
        for name, data in change(entries).items():
            packed.writestr(name, data)
    return target


def link(path: str) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo(path)
    info.external_attr = 0o120777 << 16
    return info


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda e: e | {"../evil.txt": b"x"}, "no archive of a study"),
        (lambda e: e | {"/tmp/evil.txt": b"x"}, "no archive of a study"),
        (lambda e: e | {"exports/..csv": b"x"}, "no archive of a study"),
        (lambda e: {n: d for n, d in e.items() if n != "study.db"} | {link("study.db"): b"/etc/passwd"}, "no archive of a study"),
        (lambda e: {n: d for n, d in e.items() if n != "README.txt"}, "no archive of a study"),
        (lambda e: e | {"exports/votes.csv": b"item"}, r"damaged \(exports/votes.csv"),
        (lambda e: e | {"exports/more.csv": b"item"}, r"damaged \(exports/more.csv"),
        (lambda e: {n: d for n, d in e.items() if n != "exports/votes.csv"}, r"damaged \(exports/votes.csv"),
        (lambda e: e | {"README.txt": b"\xff\xfe"}, "cannot be taken apart"),
        (lambda e: e | {"README.txt": bytes(100_000)}, "too long"),
    ],
)
def test_a_zip_that_is_no_archive_is_refused_and_leaves_nothing(whole, tmp_path, change, sentence):
    good = archive(whole, tmp_path / "a.zip").path
    bad = rezipped(good, tmp_path / "bad.zip", change)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(BadInput, match=sentence):
        unpack(bad, tmp_path / "out")
    assert sorted(tmp_path.rglob("*")) == before


def test_a_zip_that_says_to_be_larger_than_the_disk_is_refused(whole, tmp_path):
    data = bytearray(archive(whole, tmp_path / "a.zip").path.read_bytes())
    entry = data.rfind(b"PK\x01\x02", 0, data.find(b"exports/dictionary.json", data.rfind(b"study.db")))
    data[entry + 24 : entry + 28] = b"\xfe\xff\xff\xff"  # the size without compression in the directory of the zip
    (tmp_path / "b.zip").write_bytes(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shutil.disk_usage", lambda _: type("", (), {"free": 4_000_000_000}))
        with pytest.raises(BadInput, match=r"needs 4\.3 GB where 4\.0 GB are free"):
            unpack(tmp_path / "b.zip", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_files_that_are_no_zip_or_broken_are_told(whole, tmp_path):
    good = archive(whole, tmp_path / "a.zip").path
    (tmp_path / "cut.zip").write_bytes(good.read_bytes()[:-200])
    (tmp_path / "text.zip").write_text("no zip")
    damaged = bytearray(good.read_bytes())
    damaged[5000:5100] = bytes(100)
    (tmp_path / "damaged.zip").write_bytes(damaged)
    for name in ("cut", "text", "damaged"):
        with pytest.raises(BadInput, match=r"cannot be taken apart|is damaged"):
            unpack(tmp_path / f"{name}.zip", tmp_path / "out")
    with pytest.raises(BadInput, match="does not exist"):
        unpack(tmp_path / "none.zip", tmp_path / "out")
    with pytest.raises(BadInput, match="exists already"):
        unpack(good, tmp_path)
    assert not (tmp_path / "out").exists()


def test_the_study_in_a_zip_is_checked_like_any_other(whole, tmp_path):
    good = archive(whole, tmp_path / "a.zip").path

    def newer(entries):
        (tmp_path / "n.db").write_bytes(entries["study.db"])
        with closing(sqlite3.connect(tmp_path / "n.db")) as raw:
            raw.execute("PRAGMA user_version=99")
        data = (tmp_path / "n.db").read_bytes()
        old, new = (hashlib.sha256(found).hexdigest().encode() for found in (entries["study.db"], data))
        return entries | {"study.db": data, "README.txt": entries["README.txt"].replace(old, new)}

    with pytest.raises(BadInput, match="newer Concord"):
        unpack(rezipped(good, tmp_path / "new.zip", newer), tmp_path / "out")


def test_a_packet_is_not_archived(whole, tmp_path):
    with study.open_study(tmp_path / "p.db") as packet, pytest.raises(BadInput, match="from the study itself"):
        archive(packet, tmp_path / "p.zip")
    assert json.loads(content(tmp_path / "p.db")["study"][0][5]) == {"packet": CODES[2]}
