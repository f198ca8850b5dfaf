"""Steps that lead an older study to this version, written in Alembic's operations so that they run on any database.

A step is kept as it was when its version came out and repeats the columns it adds: the tables of `annotation.storage.schema`
go on changing. Views hold no votes but the rules of counting them; they are made anew after every step.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from sqlalchemy import Connection

from .. import schema
from . import version2

if TYPE_CHECKING:
    from alembic.operations import Operations

STEPS: dict[int, Callable[["Operations"], None]] = {1: version2.upgrade}  # from which version each one leads to the next


def migrate(connection: Connection, version: int) -> None:
    """Lead the study of an open transaction from `version` to `schema.SCHEMA_VERSION`.

    The number itself is kept by whoever opens the database: in the header of a file, in a table of a server. On a
    server, what was granted on views is to be granted again.
    """
    from alembic.operations import Operations
    from alembic.runtime.migration import MigrationContext

    operations = Operations(MigrationContext.configure(connection))
    schema.drop_views(connection)
    for older in range(version, schema.SCHEMA_VERSION):
        STEPS[older](operations)
    schema.create_views(connection)
