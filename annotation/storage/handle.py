"""What every function of a study needs of an open one, be it a file or a database server."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol, Self

from sqlalchemy import Connection


class StudyHandle(Protocol):
    """An open study: `reading()` and `writing()` give a connection in a transaction; safe to share by threads.

    `where` names it in sentences (never with a password); `folder` is where its shapes may lie, None on a server;
    `volunteer` is the code of the only one who may vote through this handle, None for the researcher.
    """

    @property
    def where(self) -> str: ...
    @property
    def folder(self) -> Path | None: ...
    @property
    def volunteer(self) -> str | None: ...

    def reading(self) -> AbstractContextManager[Connection]:
        """A consistent snapshot."""
    def writing(self) -> AbstractContextManager[Connection]:
        """One transaction: on the disk when the block ends without an error, and undone whole otherwise."""
    def rewriting(self) -> AbstractContextManager[Connection]:
        """As `writing()`, but votes may be changed and removed: for volunteers who asked to be deleted, and no others."""
    def purge(self) -> None:
        """Leave nothing of what was removed to be read from the disk."""
    def close(self) -> None: ...
    def __enter__(self) -> Self: ...
    def __exit__(self, *_: object) -> None: ...
