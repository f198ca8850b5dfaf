"""`python -m engine.warm`: compile the fast loops once, so that the first match and puzzle do not wait for it."""

import numpy as np


def main() -> None:
    """Match two small boxes and solve small puzzles; numba keeps the compiled loops on disk."""
    _shapes()
    _puzzles()


def _puzzles() -> None:
    from .puzzles.cutting import cut
    from .puzzles.measures import CODES
    from .puzzles.parameters import PuzzleParameters
    from .puzzles.solution import Joins, Pin, Wishes
    from .puzzles.solving import solve

    picture = np.random.default_rng(0).integers(0, 256, (64, 80, 3)).astype(np.uint8)
    pair, zero, one = np.array([[0, 1, 1, 3], [2, 1, 3, 3]]), np.zeros((1, 2)), np.ones(1)
    locked = Wishes(Joins(pair[:1], zero, zero[:, 0], one), Joins(pair[1:], zero, zero[:, 0], one), (Pin(4, 0, 0),))
    for turned in (False, True):
        puzzle = cut(picture, piece_size=16, turned=turned)[0]
        for method in ("auto", "diffusion", "matchlift"):
            solve(puzzle, PuzzleParameters(method=method, wear="worn" if turned else "auto"))
        solve(puzzle, PuzzleParameters(), wishes=locked)
    for measure in [*CODES, "mgc-pt"]:
        solve(puzzle, PuzzleParameters(measure=measure, method="mst"))
    for kind in ("merged", "rectangles", "triangles"):
        solve(cut(picture, kind=kind, piece_size=None if kind == "rectangles" else 32, pieces=5 if kind == "rectangles" else None)[0],
              PuzzleParameters())  # fmt: skip


def _shapes() -> None:
    import trimesh

    from .shapes.matching import describe, propose, rematch
    from .shapes.mesh import Mesh
    from .shapes.parameters import PRESETS, preset
    from .shapes.segmentation import SegmentedShape, segmentation_from_labels

    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0)).subdivide()
    labels = (box.triangles_center[:, 2] > 0) + 2 * (box.triangles_center[:, 1] > 0)
    shape = SegmentedShape(
        Mesh(np.asarray(box.vertices), np.asarray(box.faces), "box"), segmentation_from_labels(labels)
    )
    described = describe(shape, preset("top-down"))
    proposals = propose(described, described, preset("top-down"))
    for name in PRESETS:
        rematch(proposals, preset(name))
    rematch(proposals, preset("top-down").changed(d1_weight=1.0, phks_weight=1.0))


if __name__ == "__main__":
    main()
