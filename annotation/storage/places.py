"""Where a study lies: one file, or a project folder `name.concord` with the file, results and backups in it."""

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

from engine.errors import BadInput
from engine.store import write_atomically

from .handle import StudyHandle

FOLDER_SUFFIX = ".concord"
FILE_IN_FOLDER = "study.db"


def study_file(path: Path | str) -> Path:
    """The file of a study that is given by it or by its folder; it need not exist."""
    found = Path(path).absolute()
    if found.is_file():
        return found
    return found / FILE_IN_FOLDER if found.suffix == FOLDER_SUFFIX or (found / FILE_IN_FOLDER).is_file() else found


def project_folder(file: Path) -> Path | None:
    """The project folder that a study file lies in; None for one that stands alone."""
    return file.parent if file.parent.suffix == FOLDER_SUFFIX and file.name == FILE_IN_FOLDER else None


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Where to make a new study file, which gets its name (with its project folder) when the block ends well.

    Nothing that exists is ever replaced, and nothing is left of a block that fails.
    """
    folder = project_folder(path)
    named = folder or path
    for taken in (named, Path(f"{path}-wal")):
        if os.path.lexists(taken):
            raise BadInput(f"{taken} exists already; open that study, or choose another name.")
    try:
        with tempfile.TemporaryDirectory(dir=named.parent, prefix=f".{named.name}.") as place:
            staged = Path(place) / "whole"
            staged.mkdir()
            yield staged / path.name
            if folder is not None:
                for part in ("results", "backups"):
                    (staged / part).mkdir()
            _give_name(staged if folder is not None else staged / path.name, named)
            sync_folder(named.parent)
    except OSError as error:
        raise BadInput(f"{named} cannot be written ({error.strerror}); choose another folder or make room.") from None


def keep_result(handle: StudyHandle, path: Path | str) -> Path | None:
    """Copy a file of results into the `results` of the study's project folder, once; None where it has no such folder.

    The copy is named by the folder and the name of the original, and by its content.
    """
    project = None if handle.folder is None else project_folder(handle.folder / FILE_IN_FOLDER)
    if project is None:
        return None
    source = Path(path).absolute()
    try:
        content = source.read_bytes()
        (project / "results").mkdir(exist_ok=True)
    except OSError as error:
        raise BadInput(f"{source} cannot be copied into {project} ({error.strerror}); check both.") from None
    stem = re.sub(r"[^\w.-]+", "_", f"{source.parent.name}-{source.stem}")[-80:].strip(".-_")
    kept = project / "results" / f"{stem}-{sha256(content).hexdigest()[:12]}{source.suffix}"
    if not kept.exists():
        write_atomically(kept, content)
    return kept


def copy_with_log(path: Path, copy: Path) -> None:
    """Copy a study file and the log that lies beside it."""
    for part in ("", "-wal"):
        if os.path.exists(f"{path}{part}"):
            shutil.copyfile(f"{path}{part}", f"{copy}{part}")


def sync_folder(folder: Path) -> None:
    """Put the names in a folder on the disk, where the system can."""
    with contextlib.suppress(OSError):
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def _give_name(staged: Path, path: Path) -> None:
    """Name what is staged without ever replacing anything (a second process may create the same study)."""
    try:
        if staged.is_dir():
            os.rename(staged, path)  # refused where a folder with anything in it has the name
        else:
            os.link(staged, path)
    except OSError as error:
        if os.path.lexists(path):
            raise BadInput(f"{path} exists already; open that study, or choose another name.") from None
        if staged.is_dir():
            raise error
        os.rename(staged, path)  # a file system without hard links
