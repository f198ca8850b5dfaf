"""Damaged files end in a valid shape or in one sentence: a small run of the benchmark, and that it would notice."""

import importlib.util
import sys
from collections import Counter
from pathlib import Path
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest

from engine.errors import BadInput
from engine.shapes import meshfile

pytest.importorskip("resource", reason="limits on memory are set by POSIX systems only")
PATH = Path(__file__).parents[1] / "benchmarks" / "strangers.py"
SPEC = importlib.util.spec_from_file_location("strangers", PATH)
strangers = importlib.util.module_from_spec(SPEC)
sys.modules["strangers"] = strangers
SPEC.loader.exec_module(strangers)


def test_150_damaged_files_give_shapes_or_sentences(tmp_path):
    records = strangers.run(150, 11, tmp_path)
    assert [record["index"] for record in records] == list(range(150))
    assert [record for record in records if record["state"] not in strangers.ALLOWED] == []
    assert min(Counter(record["state"] for record in records)[state] for state in strangers.ALLOWED) >= 10


def test_without_damage_all_files_are_valid(tmp_path):
    for number, (_, files) in enumerate(strangers.valid_files()):
        for suffix, content in files.items():
            (tmp_path / f"v{number}{suffix}").write_bytes(content)
        state, words = strangers.verdict(tmp_path / f"v{number}{next(iter(files))}")
        assert state == "valid", words


def test_a_seed_always_damages_alike():
    valid = strangers.valid_files()
    texts = [strangers.damaged(Random("3/7"), valid) for _ in range(2)]
    assert texts[0] == texts[1]
    assert texts[0] != strangers.damaged(Random("3/8"), valid)


@pytest.mark.parametrize(
    ("error", "state"),
    [
        (ValueError("oops"), "other exception"),
        (SystemExit(1), "other exception"),
        (BadInput("shape.off has\ntwo lines"), "no sentence"),
        (BadInput("the file is bad"), "no sentence"),
        (BadInput("shape.off " + "is bad " * 50), "no sentence"),
        (BadInput("shape.off is bad."), "sentence"),
    ],
)
def test_the_benchmark_tells_a_sentence_from_other_failures(monkeypatch, error, state):
    def fail(path):
        raise error

    monkeypatch.setattr(meshfile, "load_shape", fail)
    assert strangers.verdict(Path("/x/shape.off"))[0] == state


@pytest.mark.parametrize(
    ("faces", "labels", "height", "words"),
    [([[0, 1, 3]], [0], 0, "range"), ([[0, 1, -1]], [0], 0, "range"), ([[0, 1, 2]], [0], np.nan, "finite"),
     ([[0, 1, 2]], [1], 0, "labels"), ([[0, 1, 2]], [0, 0], 0, "labels"), ([[0, 1, 2]], [0], 0, "")],
)  # fmt: skip
def test_the_benchmark_notices_invalid_shapes(faces, labels, height, words):
    mesh = SimpleNamespace(vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 1, height]]), faces=np.array(faces))
    shape = SimpleNamespace(mesh=mesh, segmentation=SimpleNamespace(labels=np.array(labels), names=(5,)))
    found = strangers.fault(shape)
    assert (words in found) and bool(found) == bool(words)  # noqa: PT018


def test_the_benchmark_goes_on_after_a_child_that_died(monkeypatch, tmp_path):
    """Files 1 and 3 kill the child; both are counted, and the others are loaded."""
    source = PATH.read_text(encoding="utf-8")
    before = "    begin = time.perf_counter()\n"
    death = "        if index in (1, 3):\n            signal.raise_signal((signal.SIGKILL, signal.SIGALRM)[index > 1])\n"
    deadly = source.replace(before, before + death)
    script = tmp_path / "tests" / "benchmarks" / "strangers.py"
    script.parent.mkdir(parents=True)
    script.write_text(deadly, encoding="utf-8")
    monkeypatch.setattr(strangers, "__file__", str(script))
    records = strangers.run(5, 0, tmp_path)
    assert [record["state"] for record in records if record["index"] in (1, 3)] == ["killed", "hang"]
    assert all(record["state"] in strangers.ALLOWED for record in records if record["index"] not in (1, 3))
