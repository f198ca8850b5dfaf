"""Files are whole or not there, and the cache never answers for something else."""

import os
import stat
from dataclasses import replace

import numpy as np
import pytest
from world import bar

from engine.errors import BadInput
from engine.shapes.describing import describe
from engine.shapes.matching import propose
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.store import Cache, cache_key, default_cache, output_folder, write_atomically, write_together

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)
NUMBERS = {"numbers": np.arange(5)}


def test_a_cache_with_other_settings_gives_what_no_cache_gives(lamp, tmp_path):
    """One folder for all settings: each must find its own descriptors, on the first and on the second time."""
    cache = Cache(tmp_path)
    settings = [{}, {"seed": 1}, {"max_segments": 2}, {"max_segments": 3}, {"own_scale": 1.0}]
    plain = [describe(lamp, LIGHT.changed(**values)).descriptors for values in settings]
    counts = [0]
    for _ in range(2):
        for values, wanted in zip(settings, plain, strict=True):
            assert np.array_equal(describe(lamp, LIGHT.changed(**values), cache=cache).descriptors, wanted), values
            counts.append(len(list(tmp_path.glob("*.npz"))))
    made = np.diff(counts)
    assert (made[: len(settings)] > 0).all()  # something of its own for each
    assert not made[len(settings) :].any()


def test_a_cache_tells_labels_apart(lamp, tmp_path):
    """Numbered from the other end the chain of parts has the same unions, row by row, of other faces."""
    turned = SegmentedShape(lamp.mesh, segmentation_from_labels(-lamp.segmentation.labels))
    cache = Cache(tmp_path)
    kept = [describe(shape, LIGHT, cache=cache) for shape in (lamp, turned)]
    assert np.array_equal(kept[0].layers.members, kept[1].layers.members)
    assert np.array_equal(kept[1].descriptors, describe(turned, LIGHT).descriptors)


def test_a_cache_tells_partners_and_pairs_apart(tmp_path):
    """Shapes of as many nodes propose the same pairs of rows; a shape with other measures proposes other pairs."""
    cache = Cache(tmp_path)
    a, b, c = (describe(bar(lengths), LIGHT) for lengths in ([1, 2, 1, 3], [2, 1, 5, 1], [1, 1, 2, 1]))
    for one, two in ((a, b), (a, c), (c, b), (b, a)):
        assert np.array_equal(propose(one, two, LIGHT, cache=cache).lfd, propose(one, two, LIGHT).lfd)
    d = describe(bar([1, 2, 1, 3, 1, 1, 2, 4, 1, 2]), LIGHT)
    other = replace(d, measures=replace(d.measures, size=d.measures.size[::-1]))
    few = LIGHT.changed(pool=30)
    for shape in (d, other):
        assert np.array_equal(propose(shape, d, few, cache=cache).lfd, propose(shape, d, few).lfd)
    assert not np.array_equal(propose(other, d, few).pairs, propose(d, d, few).pairs)


def test_a_kept_result_is_not_made_again(tmp_path):
    made = []

    def make():
        made.append(1)
        return NUMBERS

    for _ in range(3):
        assert Cache(tmp_path).arrays("key", make)["numbers"].tolist() == [0, 1, 2, 3, 4]
    assert len(made) == 1
    Cache(tmp_path).arrays("other key", make)
    assert len(made) == 2


@pytest.mark.parametrize("damage", [lambda b: b"", lambda b: b[: len(b) // 2], lambda b: b[:60] + b"\xff" * 9 + b[69:]])
def test_a_damaged_file_is_made_anew_and_mended(tmp_path, damage):
    cache = Cache(tmp_path)
    cache.arrays("key", lambda: NUMBERS)
    path = tmp_path / "key.npz"
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert cache.arrays("key", lambda: NUMBERS)["numbers"].tolist() == [0, 1, 2, 3, 4]
    assert cache.arrays("key", dict)["numbers"].tolist() == [0, 1, 2, 3, 4]
    assert [p.name for p in tmp_path.iterdir()] == ["key.npz"]


def test_an_error_while_making_keeps_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError):
        Cache(tmp_path).arrays("key", lambda: {"numbers": np.ones(1 // 0)})
    assert list(tmp_path.iterdir()) == []


def test_a_cache_that_cannot_be_written_still_answers(tmp_path):
    (tmp_path / "file").write_text("in the way")
    cache = Cache(tmp_path / "file" / "cache")
    assert cache.arrays("key", lambda: NUMBERS)["numbers"].tolist() == [0, 1, 2, 3, 4]


def test_the_files_used_longest_ago_go_first(tmp_path):
    cache = Cache(tmp_path, largest=3 * 10_000)
    big = {"bytes": np.zeros(9_000, np.uint8)}
    for number, name in enumerate(("a", "b", "c")):
        cache.arrays(name, lambda: big)
        os.utime(tmp_path / f"{name}.npz", (1000 + number, 1000 + number))
    cache.arrays("a", dict)  # used now
    cache.arrays("d", lambda: big)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "c.npz", "d.npz"]


def test_keys_differ_where_anything_differs():
    x = np.arange(6)
    parts = [(), (1,), ("1",), (1, 2), (12,), (x,), (x[::-1],), (x.reshape(2, 3),), (x.astype(np.int32),), (x, 1), (1, x),
             (x.reshape(2, 3).T,), (1.0,), (None,), (np.zeros(2),), (np.zeros(2, np.int64),)]  # fmt: skip
    assert len({cache_key(word, *p) for word in ("one", "two") for p in parts}) == 2 * len(parts)
    assert cache_key("one", x.reshape(2, 3).T) == cache_key("one", np.ascontiguousarray(x.reshape(2, 3).T))


def test_the_users_cache_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path))
    assert default_cache().folder == tmp_path / "descriptors"


def test_a_file_is_replaced_whole_with_the_usual_rights(tmp_path):
    path = tmp_path / "a.txt"
    for content in ("früher", b"later"):
        write_atomically(path, content)
        assert path.read_bytes() == (content.encode() if isinstance(content, str) else content)
    (tmp_path / "plain").write_text("made the usual way")
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "plain").stat().st_mode)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "plain"]


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"
    write_atomically(path, "old")

    def full(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BadInput, match="No space left") as error:
        write_atomically(path, "new")
    assert "\n" not in str(error.value)
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


def test_several_files_are_written_together_or_not_at_all(tmp_path):
    a, b = tmp_path / "a.txt", tmp_path / "b.txt"
    write_together({a: "old a", b: b"old b"})
    (tmp_path / "folder").mkdir()
    with pytest.raises(BadInput, match="folder"):
        write_together({a: "new a", b: "new b", tmp_path / "folder": "in the way"})
    assert (a.read_text(), b.read_text()) == ("old a", "old b")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b.txt", "folder"]


def test_an_output_folder_is_made_or_refused_in_one_sentence(tmp_path):
    assert output_folder(tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="output folder"):
        output_folder(tmp_path / "file")
