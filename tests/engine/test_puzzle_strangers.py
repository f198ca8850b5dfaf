"""Damaged pictures end in pixels or in one sentence: a small run of the benchmark, and that it would notice."""

import importlib.util
import sys
from collections import Counter
from pathlib import Path
from random import Random

import numpy as np
import pytest

from engine.errors import BadInput
from engine.puzzles import imagefile

pytest.importorskip("resource", reason="limits on memory are set by POSIX systems only")
PATH = Path(__file__).parents[1] / "benchmarks" / "strange_pictures.py"
SPEC = importlib.util.spec_from_file_location("strange_pictures", PATH)
strange = importlib.util.module_from_spec(SPEC)
sys.modules["strange_pictures"] = strange
SPEC.loader.exec_module(strange)


def test_300_damaged_pictures_give_pixels_or_sentences(tmp_path):
    records = strange.run(300, 5, tmp_path)
    assert [record["index"] for record in records] == list(range(300))
    assert [record for record in records if record["state"] not in strange.ALLOWED] == []
    counts = Counter(record["state"] for record in records)
    assert min(counts[state] for state in strange.ALLOWED) >= 30


def test_without_damage_all_pictures_are_read_or_refused_for_their_mode(tmp_path):
    for number, (suffix, content) in enumerate(strange.valid_images()):
        path = tmp_path / f"b{number}{suffix}"
        path.write_bytes(content)
        assert strange.verdict(path, None)[0] == "pixels", path


def test_a_seed_always_damages_alike():
    images = strange.valid_images()
    once, again = (strange.damaged(Random("3/7"), images) for _ in range(2))
    assert once == again
    assert once != strange.damaged(Random("3/8"), images)


@pytest.mark.parametrize(
    ("error", "state"),
    [(ValueError("oops"), "other exception"), (SystemExit(1), "other exception"),
     (BadInput("b.png has\ntwo lines"), "no sentence"), (BadInput("the file is bad."), "no sentence"),
     (BadInput("b.png " + "is bad " * 99), "no sentence"), (BadInput("b.png is bad."), "sentence")],
)  # fmt: skip
def test_the_benchmark_tells_a_sentence_from_other_failures(monkeypatch, error, state):
    def fail(path):
        raise error

    monkeypatch.setattr(imagefile, "read_image", fail)
    assert strange.verdict(Path("/x/b.png"), None)[0] == state


@pytest.mark.parametrize("pixels", [np.zeros((2, 2)), np.zeros((2, 2, 4)), np.zeros((2, 2, 5), np.uint8), np.zeros((0, 2, 4), np.uint8)])
def test_the_benchmark_notices_impossible_pixels(monkeypatch, pixels):
    monkeypatch.setattr(imagefile, "read_image", lambda path: pixels)
    assert strange.verdict(Path("/x/b.png"), None)[0] == "impossible"
