"""Where studies lie: laws hold on a file and on a server alike."""

import os
from collections.abc import Iterator

import pytest
from postgres_server import Server, Unavailable, running


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """A PostgreSQL server for all tests; skips where its programs are missing, but in continuous integration."""
    try:
        with running() as started:
            yield started
    except Unavailable as error:
        if os.environ.get("CONCORD_SERVER_TESTS") == "required":
            raise
        pytest.skip(f"no PostgreSQL server for tests: {error}")


@pytest.fixture
def database(server) -> Iterator[str]:
    """The address of an empty database, as the superuser."""
    address = server.database()
    yield address
    server.drop(address)


@pytest.fixture(params=["file", "server"])
def place(request, tmp_path) -> str:
    """Where a new study may be made: once on a file, once on a server."""
    return str(tmp_path / "lamps.db") if request.param == "file" else request.getfixturevalue("database")
