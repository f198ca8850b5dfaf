"""A whole study in one zip: the study file, its exports with the data dictionary, and what each file's bytes hash to."""

import contextlib
import hashlib
import os
import re
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from sqlalchemy import Connection, insert, select

from engine.errors import BadInput

from ..storage import schema
from ..storage.database import create_file
from ..storage.handle import StudyHandle
from ..storage.stamps import app_version, now
from ..study import about, open_study
from .anonymising import Unchanged
from .exporting import contents

STUDY, README = "study.db", "README.txt"
MOST_FILES, LONGEST_README = 64, 2**16
_ALLOWED = re.compile(r"study\.db|README\.txt|exports/[a-z]+\.[a-z]+")
_SUM = re.compile(r"([0-9a-f]{64})  (\S+)")


class Archived(NamedTuple):
    """The files of an archive and the hash of each."""

    path: Path
    sums: dict[str, str]


def archive(handle: StudyHandle, out: Path | str, changing: Unchanged | None = None) -> Archived:
    """Write a study as one zip; `changing` says what becomes of each row (see `annotation.exchange.anonymising`).

    Exports are made of the study as it is in the zip. Raises `BadInput` where the file exists or cannot be written.
    """
    path = Path(out).absolute()
    if handle.volunteer is not None:
        raise BadInput(f"{handle.where} is for {handle.volunteer} alone; make the archive from the study itself.")
    with _staged(path) as folder:
        copied = folder / STUDY
        try:
            copy_study(handle, copied, changing or Unchanged())
        except BadInput as error:
            raise BadInput(str(error).replace(str(copied), str(path))) from None
        with open_study(copied, backup=False) as copy:
            name, files = about(copy).name, contents(copy, ("csv",), gold=True)
        (folder / "exports").mkdir()
        for file, content in files.items():
            (folder / "exports" / file).write_bytes(content)
        names = [STUDY, *sorted(f"exports/{file}" for file in files)]
        sums = {file: _hash(folder / file) for file in names}
        (folder / README).write_text(_readme(name, sums), encoding="utf-8")
        whole = folder / "whole.zip"
        with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as packed:
            for file in (README, *names):
                packed.write(folder / file, file)
        os.replace(whole, path)
    return Archived(path, sums)


def unpack(path: Path | str, folder: Path | str) -> Path:
    """Take an archive apart into a new folder and return the study file in it.

    Only files that an archive has are taken, of the size and the hash that it states. Raises `BadInput` for all else.
    """
    target = Path(folder).absolute()
    try:
        with zipfile.ZipFile(path) as packed, _staged(target) as staged:
            whole = staged / "whole"
            (whole / "exports").mkdir(parents=True)
            for info in _checked(packed, path, shutil.disk_usage(staged).free):
                with packed.open(info) as source, open(whole / info.filename, "xb") as file:
                    shutil.copyfileobj(source, file, 2**20)
            _check_sums(whole, path)
            open_study(whole / STUDY, backup=False).close()
            os.rename(whole, target)
    except FileNotFoundError:
        raise BadInput(f"{path} does not exist; give the zip that `concord study archive` wrote.") from None
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError) as error:
        raise BadInput(f"{path} cannot be taken apart ({error}); get the archive again.") from None
    return target / STUDY


def copy_study(handle: StudyHandle, path: Path, changing: Unchanged) -> None:
    """Write all rows of a study, as they are changed, into a fresh file, which so holds nothing that was removed."""
    with handle.reading() as connection:
        create_file(path, lambda fresh: _copy(connection, fresh, changing))


def _copy(connection: Connection, fresh: Connection, changing: Unchanged) -> None:
    """All rows, what others refer to first: on a server the votes lie in no order."""
    for table in schema.metadata.sorted_tables:
        if table is schema.blob:
            continue
        query = select(table).order_by(schema.event.c.clock, schema.event.c.uuid) if table is schema.event else select(table)
        rows = [dict(row._mapping) for row in connection.execute(query)]
        if changed := changing.rows(table.name, rows):
            fresh.execute(insert(table), changed)
    for key in connection.scalars(select(schema.blob.c.key).order_by(schema.blob.c.key)).all():
        content: Any = connection.scalars(select(schema.blob.c.content).where(schema.blob.c.key == key)).one()
        fresh.execute(insert(schema.blob).values(key=key, content=bytes(content)))


@contextlib.contextmanager
def _staged(path: Path) -> Iterator[Path]:
    """A folder beside a file or folder to be made, which must not exist; gone when the block ends."""
    if os.path.lexists(path):
        raise BadInput(f"{path} exists already; choose another name.")
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            yield Path(folder)
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); choose another folder or make room.") from None


def _checked(packed: zipfile.ZipFile, path: Path | str, room: int) -> list[zipfile.ZipInfo]:
    """The entries of a zip, when they are those of an archive and there is room for them (in bytes)."""
    infos = packed.infolist()
    names = [info.filename for info in infos]
    strange = [info.filename for info in infos if not _ALLOWED.fullmatch(info.filename) or stat.S_ISLNK(info.external_attr >> 16)]
    if strange or len(set(names)) < len(names) or len(infos) > MOST_FILES or not {STUDY, README} <= set(names):
        what = f"it holds {strange[0]!r}" if strange else "its files are not those of one"
        raise BadInput(f"{path} is no archive of a study ({what}); give the zip that `concord study archive` wrote.")
    if packed.getinfo(README).file_size > LONGEST_README:
        raise BadInput(f"{path} is no archive of a study (its {README} is too long); give another zip.")
    if (needed := sum(info.file_size for info in infos)) > room:
        raise BadInput(f"{path} needs {needed / 1e9:.1f} GB where {room / 1e9:.1f} GB are free; make room, or check where it is from.")
    return infos


def _check_sums(folder: Path, path: Path | str) -> None:
    """Whether all files but the README are as that says."""
    sums = {file: found for found, file in _SUM.findall((folder / README).read_text(encoding="utf-8"))}
    files = {f.relative_to(folder).as_posix() for f in folder.rglob("*") if f.is_file()} - {README}
    if wrong := sorted(file for file in files | sums.keys() if file not in files or sums.get(file) != _hash(folder / file)):
        raise BadInput(f"{path} is damaged ({wrong[0]} is not what {README} says); get the archive again.")


def _hash(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _readme(name: str, sums: dict[str, str]) -> str:
    """What is in the zip, for a person, with a line for each file that `sha256sum -c README.txt` reads."""
    lines = [
        f"The study {name!r}, archived {now()[:10]} with Concord {app_version()}.", "",
        f"{STUDY} is the whole study: an SQLite file that Concord opens and `sqlite3` reads.",
        "exports/ holds the same as tables (CSV in UTF-8), and dictionary.md says what every column means.",
        "concord study unpack takes this zip apart and checks it. SHA-256 of each file:", "",
    ]  # fmt: skip
    return "\n".join([*lines, *(f"{found}  {file}" for file, found in sums.items())]) + "\n"
