"""One small world drawn by hand, for all tests."""

import os
from pathlib import Path

import numpy as np
import pytest
from world import LAMP, boxes

from engine.shapes.segmentation import SegmentedShape

DATA = Path(os.environ.get("CONCORD_DATA", Path(__file__).parents[1].parent / "shared" / "data"))


@pytest.fixture(scope="session")
def real_shapes() -> Path:
    """The folder of real labelled meshes; skips where they are not on this machine."""
    folder = DATA / "shapes"
    if not folder.is_dir():
        pytest.skip(f"the real meshes are not here ({folder}); set CONCORD_DATA to the folder that holds 'shapes'")
    return folder


@pytest.fixture(scope="session")
def real_puzzles() -> Path:
    """The folder of real pictures; skips where they are not on this machine."""
    folder = DATA / "puzzles"
    if not folder.is_dir():
        pytest.skip(f"the real pictures are not here ({folder}); set CONCORD_DATA to the folder that holds 'puzzles'")
    return folder


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    """No test reads or writes the user's own cache."""
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))


@pytest.fixture
def lamp() -> SegmentedShape:
    """Five touching boxes: foot 0, lower stem 1, upper stem 2, shade 3, knob 4."""
    return boxes(LAMP, "lamp")


@pytest.fixture
def coarse_lamp() -> SegmentedShape:
    """The same lamp, a little larger, its stem in one piece: foot 0, stem 1, shade 2, knob 3."""
    parts = [LAMP[0], ((-0.2, -0.2, 0.5), (0.2, 0.2, 5.5)), LAMP[3], LAMP[4]]
    return boxes([(np.multiply(low, 1.1), np.multiply(high, 1.1)) for low, high in parts], "coarse lamp")
