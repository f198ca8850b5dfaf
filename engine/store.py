"""Files that are whole or not there: atomic writes, and a disk cache of slow pure results."""

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from .errors import BadInput


def write_atomically(path: Path | str, data: bytes | str) -> None:
    """Write beside the file and rename over it; raises `BadInput` in one sentence where that is impossible."""
    write_together({Path(path): data})


def write_together(contents: Mapping[Path, bytes | str], *, synced: bool = True) -> None:
    """Write several files whole: all are staged beside their places before the first takes its name.

    `synced` waits until the disk has each, which takes milliseconds a file; thousands that can be made again go without.
    Raises `BadInput` in one sentence where one cannot be written; then no file has changed.
    """
    staged: dict[Path, str] = {}
    target = Path()
    try:
        for target, data in contents.items():
            if target.is_dir():
                raise IsADirectoryError(21, "there is a folder of that name")
            with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}.", delete=False) as handle:
                staged[target] = handle.name
                handle.write(data.encode("utf-8") if isinstance(data, str) else data)
                handle.flush()
                if synced:
                    os.fsync(handle.fileno())
            os.chmod(staged[target], 0o666 & ~_umask())
        for target in contents:
            os.replace(staged[target], target)
            del staged[target]
    except OSError as error:
        raise BadInput(f"{target} cannot be written ({error.strerror}); choose another folder or make room.") from None
    finally:
        for left in staged.values():
            with contextlib.suppress(OSError):
                os.unlink(left)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def output_folder(path: Path | str) -> Path:
    """Make the folder if it is missing, and prove that it can be written to before any long work starts."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BadInput(f"The output folder {folder} cannot be written to ({error.strerror}); choose another.") from None
    return folder


class Cache:
    """Results of slow pure functions on disk, one `.npz` file each, keyed by the bytes of what they came from."""

    def __init__(self, folder: Path | str, largest: int = 2 * 2**30) -> None:
        self.folder = Path(folder)
        self.largest = largest

    def arrays(self, key: str, make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
        """The arrays kept under `key`, or those that `make` returns now; a damaged file is made anew."""
        path = self.folder / f"{key}.npz"
        try:
            with np.load(path, allow_pickle=False) as content:
                found = {name: content[name] for name in content.files}
            with contextlib.suppress(OSError):
                os.utime(path)
            return found
        except MemoryError:
            raise
        except Exception:  # a damaged zip raises nearly anything: BadZipFile, NotImplementedError, zlib.error, …
            pass
        made = make()
        self._keep(path, made)
        return made

    def _keep(self, path: Path, arrays: dict[str, np.ndarray]) -> None:
        """Write the file whole; a full or read-only disk costs only the next run's time."""
        staged = ""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self.folder, suffix=".part", delete=False) as handle:
                staged = handle.name
                np.savez(handle, **arrays)  # type: ignore[arg-type]
            os.replace(staged, path)
            self._shrink()
        except OSError:
            with contextlib.suppress(OSError):
                os.unlink(staged)

    def _shrink(self) -> None:
        """Drop the files used longest ago until the folder is below its largest size."""
        files = sorted(((p.stat().st_mtime, p.stat().st_size, p) for p in self.folder.glob("*.npz")), reverse=True)
        total = 0
        for _, size, path in files:
            total += size
            if total > self.largest:
                path.unlink(missing_ok=True)


def default_cache() -> Cache:
    """The cache in the user's own cache folder (`CONCORD_CACHE` overrides it)."""
    import platformdirs

    return Cache(Path(os.environ.get("CONCORD_CACHE") or platformdirs.user_cache_dir("concord")) / "descriptors")


def digest(*parts: bytes) -> str:
    """SHA-256 of the parts, each with its length before it, as hexadecimal digits."""
    hasher = hashlib.sha256()
    for part in parts:
        hasher.update(len(part).to_bytes(8, "little"))
        hasher.update(part)
    return hasher.hexdigest()


def cache_key(word: str, *parts: object) -> str:
    """A key from a version word and numbers, texts or arrays (by dtype, shape and bytes)."""
    hasher = hashlib.sha256(word.encode() + b"\0")
    for part in parts:
        if isinstance(part, np.ndarray):
            hasher.update(f"{part.dtype.str}{part.shape}".encode())
            hasher.update(np.ascontiguousarray(part).tobytes())
        else:
            hasher.update(repr(part).encode())
        hasher.update(b"\0")
    return hasher.hexdigest()
