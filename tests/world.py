"""The small world that all tests share, drawn by hand: boxes, a bar, and a lamp of boxes."""

import numpy as np

from engine.shapes.mesh import Mesh
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels


def box(low, high) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (8, 3) and outward triangles (12, 3) of an axis-parallel box."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return vertices, np.array(faces)


def boxes(corners, name="boxes") -> SegmentedShape:
    """Separate boxes, each a segment; they touch where their corners say so, but share no vertex rows."""
    parts = [box(low, high) for low, high in corners]
    start = np.cumsum([0] + [8] * len(parts))
    vertices = np.concatenate([v for v, _ in parts])
    faces = np.concatenate([f + s for (_, f), s in zip(parts, start, strict=False)])
    return SegmentedShape(Mesh(vertices, faces, name), segmentation_from_labels(np.repeat(range(len(parts)), 12)))


def bar(lengths, name="bar") -> SegmentedShape:
    """A closed square bar along x, 1 x 1 across, welded; its pieces of the given lengths are the segments."""
    x = np.concatenate([[0.0], np.cumsum(lengths)])
    ring = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    vertices = np.array([[at, y, z] for at in x for y, z in ring])
    faces, labels = [], []
    for piece in range(len(lengths)):
        a, b = 4 * piece, 4 * piece + 4
        for k in range(4):
            n = (k + 1) % 4
            faces += [(a + k, a + n, b + n), (a + k, b + n, b + k)]
            labels += [piece, piece]
    end = 4 * len(lengths)
    faces += [(0, 2, 1), (0, 3, 2), (end, end + 1, end + 2), (end, end + 2, end + 3)]
    labels += [0, 0, len(lengths) - 1, len(lengths) - 1]
    return SegmentedShape(Mesh(vertices, np.array(faces), name), segmentation_from_labels(labels))


# A lamp of boxes: foot, lower stem, upper stem, shade, and a knob on the shade. No two parts are alike.
LAMP = [((-2, -1.5, 0), (2, 1.5, 0.5)), ((-0.2, -0.2, 0.5), (0.2, 0.2, 2.5)), ((-0.2, -0.2, 2.5), (0.2, 0.2, 5.5)),
        ((-1, -1, 5.5), (1, 1, 7)), ((-0.3, -0.2, 7), (0.3, 0.2, 7.3))]  # fmt: skip
