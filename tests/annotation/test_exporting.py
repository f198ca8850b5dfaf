"""Exports: every vote with its state, the same rows in each format, and a dictionary that tells of every column."""

import builtins
import csv
import io
import json
import sys
from datetime import datetime

import pytest
from exchange_world import ask, ids_of, strip_study
from judging_world import LAMP, ONE_TO_ONE, VASE, identity, study_of

from annotation import study
from annotation.exchange.exporting import FORMATS, contents, export, table_rows, votes_csv
from annotation.exchange.exporttables import ABOUT, TABLES, names
from annotation.voting.answering import make_adjudicator
from engine.errors import BadInput, BadParameter

FOOT, STEM, SHADE = (identity(LAMP, one, VASE, other) for one, other in ONE_TO_ONE)


def test_votes_are_exported_with_their_state(tmp_path):
    with study_of(tmp_path / "a.db") as handle:
        study.record_vote(handle, FOOT, "anna", "wrong", comment='=HYPERLINK("x")')
        study.record_vote(handle, FOOT, "anna", "correct", comment="-1", active_ms=700)
        study.record_vote(handle, STEM, "anna", "unsure", comment='+cmd, "quoted"\nand broken')
        study.undo_vote(handle, "anna")
        study.record_vote(handle, SHADE, "-bert", "wrong", comment="@x")
        text = votes_csv(handle)
    rows = list(csv.DictReader(io.StringIO(text)))
    assert tuple(rows[0]) == names("votes")
    assert [(r["volunteer"], r["answer"], r["state"]) for r in rows] == [
        ("'-bert", "wrong", "current"), ("anna", "wrong", "replaced"), ("anna", "correct", "current"),
        ("anna", "unsure", "retracted"),
    ]  # fmt: skip
    assert [r["comment"] for r in rows] == ["'@x", '\'=HYPERLINK("x")', "-1", '\'+cmd, "quoted"\nand broken']
    assert [r["active_ms"] for r in rows] == ["", "", "700", ""]
    assert rows[1]["item"] == FOOT
    assert "lamp.off" in rows[1]["payload"]


@pytest.fixture
def whole(tmp_path):
    """A study with everything that a table can hold: a design, votes of three, practice, texts that are not harmless."""
    with strip_study(tmp_path / "a.db", votes=2) as handle:
        ids = ids_of(handle)
        ask(handle, dict(zip(ids[:5], ("practice", "gold", "judged", "judged", "judged"), strict=True)), reason="=1+1", stratum="s")
        study.record_vote(handle, ids[0], "anna", "wrong", round=0)
        for code, answer in (("anna", "correct"), ("bert", "wrong"), ("carl", "unsure")):
            study.record_vote(handle, ids[1], code, answer, comment="@ends\r\nhere, “quoted”", shown_ms=900, active_ms=800)
        study.record_vote(handle, ids[2], "anna", "wrong")
        study.undo_vote(handle, "anna")
        make_adjudicator(handle, "dora")
        yield handle


def read(table: str, format: str, content: bytes) -> list[tuple]:
    """The rows of a file as other programs see them."""
    if format == "parquet":
        import pyarrow.parquet

        found = pyarrow.parquet.read_table(io.BytesIO(content))
        assert tuple(found.column_names) == names(table)
        return [tuple(row.values()) for row in found.to_pylist()]
    if format == "jsonl":
        rows = [json.loads(line) for line in content.decode().splitlines()]
        assert all(sorted(row) == sorted(names(table)) for row in rows)
        return [tuple(row[name] for name in names(table)) for row in rows]
    header, *rows = csv.reader(io.StringIO(content.decode(), newline=""))
    assert tuple(header) == names(table)
    return [tuple(row) for row in rows]


def expected(table: str, format: str, row: tuple) -> tuple:
    """A row of the study as a format writes it."""

    def cell(value: object, type: str) -> object:
        if format == "jsonl":
            return json.loads(value) if type == "json" else value
        if format == "parquet":
            return value
        text = "" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
        return f"'{text}" if isinstance(value, str) and text[:1] in ("=", "@") else text

    return tuple(cell(value, column.type) for value, column in zip(row, TABLES[table], strict=True))


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("format", FORMATS)
def test_what_is_written_can_be_read_again(whole, table, format):
    rows = table_rows(whole, table)
    assert rows
    found = read(table, format, contents(whole, [format], gold=True)[f"{table}.{format}"])
    assert found == [expected(table, format, row) for row in rows]


def test_every_cell_is_of_its_declared_type_and_range(whole):
    types = {"text": str, "integer": int, "number": float, "boolean": bool, "time": str, "json": str}
    seen = set()
    for table, columns in TABLES.items():
        for row in table_rows(whole, table):
            for value, column in zip(row, columns, strict=True):
                if value is None:
                    continue
                seen.add(column.type)
                assert type(value) is types[column.type], (table, column.name)
                if column.type == "json":
                    json.loads(value)
                if column.type == "time":
                    datetime.fromisoformat(value)
                if column.range and column.type == "text" and "," in column.range and "letters" not in column.range:
                    assert value in column.range.replace(" or empty", "").split(", "), (table, column.name)
                if "≥" in column.range and column.type in ("integer", "number"):
                    assert value >= int(column.range.split()[1])
    assert seen == set(types)


def test_the_dictionary_and_the_files_agree(whole, tmp_path):
    files = {path.name: path.read_text(encoding="utf-8") for path in export(whole, tmp_path / "out", ["csv"], gold=True)}
    told = json.loads(files["dictionary.json"])["tables"]
    assert {f"{table}.csv" for table in told} | {"dictionary.json", "dictionary.md"} == set(files)
    for table, entry in told.items():
        assert next(csv.reader(io.StringIO(files[f"{table}.csv"]))) == [column["name"] for column in entry["columns"]]
        assert all(column["meaning"].endswith((".", ")")) and column["type"] for column in entry["columns"])
        lines = files["dictionary.md"].split(f"## {table}\n")[1].split("\n## ")[0].splitlines()
        assert [line.split(" | ")[0][2:] for line in lines[5:] if line] == [column["name"] for column in entry["columns"]]
    assert set(ABOUT) == set(TABLES)


def test_known_answers_are_written_only_where_asked_for(whole, tmp_path):
    secret = export(whole, tmp_path / "out", ["csv", "jsonl"])
    assert "gold.csv" not in [path.name for path in secret]
    assert not [path for path in secret if "=1+1" in path.read_text(encoding="utf-8")]
    rows = {(row[0], row[4]): (row[1], row[2], row[5], row[6]) for row in table_rows(whole, "gold")}
    ids = ids_of(whole)
    assert rows == {
        (ids[0], "anna"): ("practice", "correct", "wrong", False), (ids[1], "anna"): ("gold", "correct", "correct", True),
        (ids[1], "bert"): ("gold", "correct", "wrong", False), (ids[1], "carl"): ("gold", "correct", "unsure", None),
    }  # fmt: skip


def test_volunteers_and_matches_are_counted(whole):
    ids = ids_of(whole)
    found = {row[0]: row[1:4] for row in table_rows(whole, "volunteers")}
    assert found == {"anna": (False, 1, 2), "bert": (False, 1, 1), "carl": (False, 1, 1), "dora": (True, 0, 0), "nobody": (False, 0, 0)}
    items = {row[0]: row[2:6] for row in table_rows(whole, "items")}
    assert items[ids[2]] == (True, "s", 0.5, False)
    assert items[ids[5]] == (False, "", None, False)
    assert {row[0]: row[1:] for row in table_rows(whole, "majority")}[ids[1]] == (1, 1, 1, "tie")


def test_what_cannot_be_exported_is_told_and_nothing_is_written(whole, tmp_path, monkeypatch):
    with pytest.raises(BadParameter, match=r"xlsx is no format .* csv, jsonl, parquet"):
        export(whole, tmp_path / "out", ["csv", "xlsx"])
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="cannot be written"):
        export(whole, tmp_path / "file")
    usual = builtins.__import__

    def missing(name, *rest, **more):
        if name.startswith("pyarrow"):
            raise ImportError(name)
        return usual(name, *rest, **more)

    for name in [name for name in sys.modules if name.startswith("pyarrow")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(BadInput, match=r"\[parquet\]"):
        export(whole, tmp_path / "out", ["csv", "parquet"])
    monkeypatch.undo()
    assert not (tmp_path / "out").exists()
