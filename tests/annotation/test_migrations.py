"""Steps between versions run on any database."""

import hashlib
import re
import threading

import pytest
from sqlalchemy import create_engine, inspect, make_url
from version1 import TABLES, write_version1

from annotation import study
from annotation.storage import migrations, schema


def version1_statements() -> list[str]:
    """Tables, indexes and views of version 1 as any database takes them; triggers are each database's own."""
    found = [" ".join(statement.split()) for statement in TABLES.replace("END;", "END").split(";")]
    return [re.sub(r"\) STRICT$", ")", one) for one in found if one.startswith(("CREATE TABLE", "CREATE INDEX", "CREATE VIEW"))]


def columns(engine) -> dict[str, set[tuple[str, bool, str | None]]]:
    """Of every table: the names of its columns, whether they may be empty, and their defaults."""
    look = inspect(engine)
    return {
        name: {(one["name"], one["nullable"], one["default"]) for one in look.get_columns(name)} for name in look.get_table_names()
    }


def indexes(engine) -> set[tuple[str, tuple[str, ...]]]:
    look = inspect(engine)
    return {(one["name"], tuple(one["column_names"])) for name in look.get_table_names() for one in look.get_indexes(name)}


@pytest.fixture
def engines(server):
    """Two empty databases of a server."""
    made = [create_engine(make_url(server.database()).set(drivername="postgresql+psycopg")) for _ in range(2)]
    yield made
    for one in made:
        one.dispose()


def test_a_server_s_tables_of_version_1_become_those_of_today(engines):
    old, new = engines
    with old.begin() as connection:
        for statement in version1_statements():
            connection.exec_driver_sql(statement)
        connection.exec_driver_sql("INSERT INTO study VALUES ('s', 'Lamps', '', '', '', '{}', '', '')")
        connection.exec_driver_sql("INSERT INTO volunteer VALUES ('anna', '', '')")
        connection.exec_driver_sql("INSERT INTO item VALUES ('a', 'puzzle', '{}', '')")
        migrations.migrate(connection, 1)
        assert connection.exec_driver_sql("SELECT votes, adaptive, unsure FROM study").one() == (0, 1, 1)
        assert connection.exec_driver_sql("SELECT * FROM open_item").one() == ("anna", "a", 1)
    with new.begin() as connection:
        schema.metadata.create_all(connection, checkfirst=False)
        schema.create_views(connection)
    assert columns(old) == columns(new)
    assert indexes(old) == indexes(new)
    assert set(inspect(old).get_view_names()) == set(inspect(new).get_view_names())


def test_a_step_that_fails_on_a_server_changes_nothing(engines, monkeypatch):
    old, _ = engines
    with old.begin() as connection:
        for statement in version1_statements():
            connection.exec_driver_sql(statement)
    before = columns(old)
    monkeypatch.setitem(migrations.STEPS, 1, lambda op: (op.add_column("item", migrations.version2._number("gold")), 1 // 0))
    with pytest.raises(ZeroDivisionError), old.begin() as connection:
        migrations.migrate(connection, 1)
    assert columns(old) == before
    assert set(inspect(old).get_view_names()) == {"standing_vote", "current_vote"}


def test_two_who_open_an_older_file_at_once(tmp_path):
    """Whoever comes second finds it done."""
    said = write_version1(tmp_path / "old.db", items=30, votes=30)
    read, refused = [], []

    def open_it():
        try:
            with study.open_study(tmp_path / "old.db") as handle:
                read.append(study.answers(handle, "anna"))
        except Exception as error:
            refused.append(error)

    both = [threading.Thread(target=open_it) for _ in range(4)]
    for one in both:
        one.start()
    for one in both:
        one.join()
    assert refused == []
    assert read == [dict(said.values())] * 4


def test_the_rules_of_a_version_stay():
    """Files with other views or triggers than those of their version are refused: who changes them makes a new version."""
    rules = " ".join(" ".join((*schema.VIEWS, *schema.SQLITE_TRIGGERS)).split())
    known = {2: "2970cae721fc500f3f722b4a9b0fb5a4fd83fcf2588f33b75eec6c3a78c27bda"}
    assert hashlib.sha256(rules.encode()).hexdigest() == known[schema.SCHEMA_VERSION]
