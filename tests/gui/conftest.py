"""Settings for tests of the window, made before Qt or VTK is imported: no screen is needed.

With QT_QPA_PLATFORM=xcb (under Xvfb) the tests that need a screen run too.
"""

import os
from collections.abc import Callable

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_API", "pyside6")
if os.environ["QT_QPA_PLATFORM"] == "offscreen":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import pytest

from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels


def _bar(sections: int = 3, name: str = "bar") -> SegmentedShape:
    """A square tube along x, closed at both ends: segment i is the i-th section, with its cap at either end."""
    ring = np.array([[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]])
    vertices = np.array([[x, y, z] for x in range(sections + 1) for y, z in ring], float)
    quads = [(4 * i + k, 4 * i + (k + 1) % 4, 4 * i + 4 + (k + 1) % 4, 4 * i + 4 + k) for i in range(sections)
             for k in range(4)]  # fmt: skip
    labels = [i for i in range(sections) for _ in range(4)] + [0, sections - 1]
    quads += [(0, 3, 2, 1), (4 * sections, 4 * sections + 1, 4 * sections + 2, 4 * sections + 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return SegmentedShape(Mesh(vertices, np.array(faces), name), segmentation_from_labels(np.repeat(labels, 2)))


@pytest.fixture
def make_bar() -> Callable[..., SegmentedShape]:
    """Makes bars of any number of sections: `make_bar(sections, name)`."""
    return _bar


@pytest.fixture
def bar() -> SegmentedShape:
    """A bar of three sections, 28 faces."""
    return _bar()
