"""Project folders, and reading where nothing can be written."""

import contextlib
import os
import shutil
import sqlite3
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from judging_world import LAMP, VASE, identity, study_of
from version1 import write_version1

from annotation import study
from annotation.findings.thesistables import voted_precision
from annotation.storage import backup, database, places
from engine.errors import BadInput

FOOT = identity(LAMP, (0,), VASE, (0,))
ROOT = Path(__file__).parents[2]


def listed(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_a_project_folder_holds_the_study_its_results_and_its_backups(tmp_path):
    project = tmp_path / "lamps.concord"
    with study_of(project) as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
        assert handle.folder == project
    assert listed(tmp_path) == ["lamps.concord", "lamps.concord/backups", "lamps.concord/results", "lamps.concord/study.db"]
    for given in (project, project / "study.db"):
        with study.open_study(given) as handle:
            assert study.answers(handle, "anna") == {FOOT: "correct"}
    (copy,) = backup.backups(project / "study.db")
    assert copy.parent == project / "backups"
    assert voted_precision(project)[0][0].pairs == 1


def test_a_folder_that_was_renamed_is_still_a_study(tmp_path):
    study_of(tmp_path / "lamps.concord").close()
    os.rename(tmp_path / "lamps.concord", tmp_path / "renamed")
    with study.open_study(tmp_path / "renamed") as handle:
        assert study.about(handle).name == "Lamps"


def test_a_file_that_is_named_like_a_folder(tmp_path):
    study_of(tmp_path / "lamps.db").close()
    os.rename(tmp_path / "lamps.db", tmp_path / "lamps.concord")
    with study.open_study(tmp_path / "lamps.concord") as handle:
        assert study.about(handle).name == "Lamps"


@pytest.mark.parametrize("name", ["what? 100 % #1 & [co].db", "Lämpchen ☀.db", os.fsdecode(b"caf\xe9.db")])
def test_any_name_of_a_file_will_do(tmp_path, name):
    try:
        study_of(tmp_path / name).close()
    except OSError:
        pytest.skip("no such names here")
    with study.open_study(tmp_path / name) as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
    with study.open_study(tmp_path / name, writable=False) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}
    assert {found.name for found in tmp_path.iterdir()} == {name, "backups"}
    assert len(backup.backups(tmp_path / name)) == 1


def test_a_project_folder_is_made_whole_or_not_at_all(tmp_path):
    with pytest.raises(ZeroDivisionError):
        database.create_file(tmp_path / "a.concord", lambda connection: 1 // 0)
    assert listed(tmp_path) == []
    (tmp_path / "a.concord").mkdir()
    for path in (tmp_path / "a.concord", tmp_path / "a.concord" / "study.db"):
        with pytest.raises(BadInput, match=r"a\.concord exists already"):
            study.create_study(path, name="a")
    assert listed(tmp_path) == ["a.concord"]
    with pytest.raises(BadInput, match=r"a\.concord.study\.db cannot be opened"):
        study.open_study(tmp_path / "a.concord")
    with pytest.raises(BadInput, match="is a folder; give the study file in it"):
        study.open_study(tmp_path)


def test_two_who_create_the_same_folder_at_once(tmp_path):
    said = []

    def create():
        try:
            study.create_study(tmp_path / "a.concord", name="a").close()
            said.append("made")
        except BadInput as error:
            said.append(str(error))

    rivals = [threading.Thread(target=create) for _ in range(4)]
    for rival in rivals:
        rival.start()
    for rival in rivals:
        rival.join()
    assert said.count("made") == 1
    assert sum("exists already" in sentence for sentence in said) == 3
    assert listed(tmp_path) == ["a.concord", "a.concord/backups", "a.concord/results", "a.concord/study.db"]


def test_results_are_kept_in_the_folder_once(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "matches.json").write_text(f'"{name}"')
    with study_of(tmp_path / "lamps.concord") as handle:
        kept = [places.keep_result(handle, tmp_path / name / "matches.json") for name in ("one", "two", "one")]
        assert kept[0] == kept[2] != kept[1]
        assert [path.read_text() for path in kept] == ['"one"', '"two"', '"one"']
        assert len(listed(tmp_path / "lamps.concord" / "results")) == 2
        with pytest.raises(BadInput, match="No such file"):
            places.keep_result(handle, tmp_path / "missing.json")
    with study_of(tmp_path / "alone.db") as handle:
        assert places.keep_result(handle, tmp_path / "one" / "matches.json") is None


@pytest.fixture
def path(tmp_path):
    """A closed study with one vote."""
    with study_of(tmp_path / "lamps.db") as handle:
        study.record_vote(handle, FOOT, "anna", "correct")
    return tmp_path / "lamps.db"


def test_reading_changes_nothing(path):
    before = path.read_bytes()
    with study.open_study(path, writable=False) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}
        with pytest.raises(BadInput, match="open for reading only"):
            study.record_vote(handle, FOOT, "bert", "wrong")
    assert path.read_bytes() == before
    assert listed(path.parent) == ["lamps.db"]


def test_a_read_only_file_is_read_where_it_lies(path):
    path.chmod(0o444)
    with pytest.raises(BadInput, match="read-only"):
        study.open_study(path)
    with study.open_study(path, writable=False) as handle:
        assert study.majority(handle)[FOOT] == (1, 0, 0, "correct")
        assert listed(path.parent) == ["lamps.db"]


def test_what_is_voted_meanwhile_is_read(path):
    with study.open_study(path, backup=False) as window, study.open_study(path, writable=False) as reader:
        study.record_vote(window, FOOT, "bert", "wrong")
        assert study.majority(reader)[FOOT] == (1, 1, 0, "tie")


def test_a_log_left_on_a_read_only_file_is_read_too(path, tmp_path):
    """As a stick that was pulled out of a running computer: the newest votes are in the log alone."""
    (tmp_path / "stick").mkdir()
    with study.open_study(path, backup=False) as handle:
        study.record_vote(handle, FOOT, "bert", "wrong")
        for part in ("", "-wal"):
            shutil.copy(f"{path}{part}", tmp_path / "stick")
    stick = tmp_path / "stick" / "lamps.db"
    stick.chmod(0o444)
    before = listed(stick.parent)
    with study.open_study(stick, writable=False) as handle:
        assert study.majority(handle)[FOOT] == (1, 1, 0, "tie")
    assert listed(stick.parent) == before


def test_an_older_file_is_read_in_a_copy(tmp_path):
    said = write_version1(tmp_path / "old.db")
    (tmp_path / "old.db").chmod(0o444)
    before = (tmp_path / "old.db").read_bytes()
    with study.open_study(tmp_path / "old.db", writable=False) as handle:
        assert study.answers(handle, "anna") == dict(said.values())
        place = handle._copy[0].parent
        assert place.is_dir()
    assert not place.exists()
    assert (tmp_path / "old.db").read_bytes() == before
    assert listed(tmp_path) == ["old.db"]


@pytest.mark.parametrize("content", [b"", b"solid lamp\n" * 100, b"SQLite format 3\0" + b"\0" * 5000])
def test_reading_refuses_what_is_no_study(tmp_path, content):
    (tmp_path / "a.db").write_bytes(content)
    with pytest.raises(BadInput) as caught:
        study.open_study(tmp_path / "a.db", writable=False)
    assert str(tmp_path / "a.db") in str(caught.value)


@contextlib.contextmanager
def disk(folder: Path, size: str):
    """A tiny disk of its own, where the system lets us mount one."""
    folder.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True, check=False)
    if made.returncode:
        pytest.skip("no disk can be mounted here (not root)")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


@pytest.mark.skipif(not shutil.which("mount") or os.name == "nt", reason="no disks are mounted here")
def test_a_read_only_disk(tmp_path):
    with disk(tmp_path / "disk", "4m") as folder:
        study_of(folder / "lamps.concord").close()
        with study.open_study(folder / "lamps.concord") as handle:
            study.record_vote(handle, FOOT, "anna", "correct")
        subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
        with pytest.raises(BadInput, match="read-only"):
            study.open_study(folder / "lamps.concord")
        with study.open_study(folder / "lamps.concord", writable=False) as handle:
            assert study.answers(handle, "anna") == {FOOT: "correct"}
        assert voted_precision(folder / "lamps.concord")[0][0].pairs == 1


@pytest.mark.skipif(not shutil.which("mount") or os.name == "nt", reason="no disks are mounted here")
def test_a_full_disk_refuses_votes_until_there_is_room(tmp_path):
    with disk(tmp_path / "disk", "1m") as folder:
        study_of(folder / "lamps.db").close()
        with study.open_study(folder / "lamps.db", backup=False) as handle:
            study.record_vote(handle, FOOT, "anna", "correct")
            (folder / "film").write_bytes(b"x" * room(folder))
            confirmed = vote_until_refused(handle)
            assert study.answers(handle, "anna") == {FOOT: "correct"}
            (folder / "film").unlink()
            study.record_vote(handle, FOOT, "bert", "wrong")
        with contextlib.closing(sqlite3.connect(folder / "lamps.db")) as raw:
            assert raw.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            assert confirmed <= {uuid for (uuid,) in raw.execute("SELECT uuid FROM event")}


def room(folder: Path) -> int:
    found = os.statvfs(folder)
    return found.f_bavail * found.f_frsize


def vote_until_refused(handle) -> set[str]:
    """Votes that were confirmed before the sentence came, which must come soon."""
    confirmed: set[str] = set()

    def vote_on() -> None:
        for _ in range(500):
            confirmed.add(study.record_vote(handle, FOOT, "carl", "correct", comment="x" * 500).uuid)

    with pytest.raises(BadInput, match="disk is full"):
        vote_on()
    return confirmed


def test_opening_on_a_full_disk(tmp_path):
    """What was saved can be read, and voting says what is wrong."""
    with disk(tmp_path / "disk", "1m") as folder:
        with study_of(folder / "lamps.db") as handle:
            study.record_vote(handle, FOOT, "anna", "correct")
        (folder / "film").write_bytes(b"x" * room(folder))
        with study.open_study(folder / "lamps.db", writable=False) as handle:
            assert study.answers(handle, "anna") == {FOOT: "correct"}
        with pytest.raises(BadInput, match=r"the disk is full|reports an error, or is full"):
            open_and_vote(folder / "lamps.db")
        (folder / "film").unlink()
        with study.open_study(folder / "lamps.db") as handle:
            study.record_vote(handle, FOOT, "bert", "wrong")
            assert study.answers(handle, "anna") == {FOOT: "correct"}


def open_and_vote(path: Path) -> None:
    with study.open_study(path) as handle:
        for _ in range(500):
            study.record_vote(handle, FOOT, "carl", "correct", comment="x" * 500)


@pytest.mark.skipif(os.name == "nt", reason="files have no largest size here")
def test_a_file_that_may_not_grow(path):
    """Where no disk can be mounted, a limit on the size of files is nearly the same."""
    code = (
        "import resource, sys; from annotation import study; from engine.errors import BadInput\n"
        "handle = study.open_study(sys.argv[1], backup=False)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, resource.RLIM_INFINITY))\n"
        "try:\n"
        "    for _ in range(200): study.record_vote(handle, sys.argv[2], 'bert', 'wrong', comment='x' * 2000)\n"
        "except BadInput as error: print(error)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))\n"
        "study.record_vote(handle, sys.argv[2], 'carl', 'wrong')\n"
    )
    said = subprocess.run([sys.executable, "-c", code, path, FOOT], cwd=ROOT, capture_output=True, text=True, check=False)
    assert said.stderr == ""
    assert "full" in said.stdout
    with study.open_study(path) as handle:
        assert study.answers(handle, "anna") == {FOOT: "correct"}
        assert study.answers(handle, "carl") == {FOOT: "wrong"}
