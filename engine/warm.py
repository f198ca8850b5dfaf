"""`python -m engine.warm`: compile the fast loops once, so that the first match does not wait for it."""

import numpy as np


def main() -> None:
    """Match two small boxes with both methods; numba keeps the compiled loops on disk."""
    import trimesh

    from .shapes.matching import describe, propose, rematch
    from .shapes.mesh import Mesh
    from .shapes.parameters import PRESETS, preset
    from .shapes.segmentation import SegmentedShape, segmentation_from_labels

    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0)).subdivide()
    labels = (box.triangles_center[:, 2] > 0) + 2 * (box.triangles_center[:, 1] > 0)
    shape = SegmentedShape(Mesh(np.asarray(box.vertices), np.asarray(box.faces), "box"), segmentation_from_labels(labels))
    described = describe(shape, preset("top-down"))
    proposals = propose(described, described, preset("top-down"))
    for name in PRESETS:
        rematch(proposals, preset(name))


if __name__ == "__main__":
    main()
