"""README and docs name only what is there: links, paths, commands, options."""

import contextlib
import io
import re
import shlex
from functools import cache
from pathlib import Path

import pytest

from gui.__main__ import main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FOLDERS = "engine|annotation|gui|assets|tests|scripts|docs"
SCRIPTS = ["tests/benchmarks", "scripts", "annotation/findings"]


def texts():
    return [(page, page.read_text(encoding="utf-8")) for page in PAGES]


def anchors(page: Path) -> set[str]:
    """The names under which headings can be linked to."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}


def code(text: str) -> list[str]:
    """Lines of shell blocks without their remarks, and pieces of code within sentences."""
    blocks = re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S)
    lines = [re.sub(r"\s+#.*", "", line) for block in blocks for line in block.splitlines()]
    return lines + re.findall(r"`([^`]+)`", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))


def commands() -> list[tuple[str, ...]]:
    """Every call of concord with the options that it names, once."""
    found = (tuple(shlex.split(" ".join(piece.split()))) for _, text in texts() for piece in code(text) if piece.startswith("concord "))
    return sorted({words[1:] for words in found if len(words) > 1})


@cache
def wording(*words: str) -> str:
    """All that the help of a command says."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main([*words, "--help"]) == 0
    return out.getvalue()


def test_links_lead_somewhere():
    links = [(page, *link.partition("#")[::2]) for page, text in texts() for link in re.findall(r"\]\(([^)]+)\)", text)]
    assert len(links) > 10
    for page, file, anchor in links:
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{page.name}: {file}"
        assert not anchor or anchor in anchors(target), f"{page.name}: {file}#{anchor}"


def test_paths_that_are_named_are_there():
    named = {piece for _, text in texts() for piece in re.findall(rf"(?<![\w/.-])(?:{FOLDERS})/[\w/.*-]+[\w*]", text)}
    assert len(named) > 20
    assert [path for path in sorted(named) if not list(ROOT.glob(path))] == []
    bare = {piece for _, text in texts() for piece in re.findall(r"`(\w+\.(?:py|sh))\b", text)}
    assert [name for name in sorted(bare) if not any((ROOT / folder / name).exists() for folder in SCRIPTS)] == []


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_commands_and_their_options_are_there(words, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    first = next((k for k, word in enumerate(words) if word.startswith("-")), len(words))
    told = wording(*words[:first])
    usage = told.split("Usage:")[1].splitlines()[0]
    depth = 2 if words[0] in ("study", "bench", "tables") and len(words) > 1 else 1
    assert usage.split()[: depth + 1] == ["concord", *words[:depth]]
    assert [word for word in words if word.startswith("--") and word.split("=")[0] not in told] == []


def test_options_named_by_themselves_are_there(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    every = {words[:2] if words[0] in ("study", "bench", "tables") else words[:1] for words in commands()}
    scripts = "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tests" / "benchmarks").glob("*.py")))
    told = "".join(wording(*words) for words in sorted(every)) + scripts
    named = {option for _, text in texts() for piece in code(text) for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", piece)}
    assert len(named) > 30
    assert [option for option in sorted(named) if option not in told] == []
