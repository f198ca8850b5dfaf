"""The pairs that Concord ships, made again: `python -m engine.shapes.families.examples FOLDER`."""

import sys
from pathlib import Path
from typing import NamedTuple

from .collection import write_shape
from .generated import make_shape
from .pairs import segmented

COARSE_MERGE = 0.3


class Example(NamedTuple):
    """A fine source against a coarse target, with some parts of the target joined."""

    folder: str
    stem: str
    family: str
    seed: int
    variant: str
    fine: int
    coarse: int


EXAMPLES = (
    Example("lamps", "lamp", "lamps", 3, "touching", 15, 10),
    Example("vases", "vase", "vases", 1, "touching", 14, 10),
    Example("candles", "candle", "candles", 1, "touching", 15, 12),
    Example("aeroplanes", "aeroplane", "aeroplanes", 4, "welded", 16, 12),
    Example("animals", "animal", "animals", 3, "welded", 20, 17),
    Example("lamps-welded", "lamp", "lamps", 1, "welded", 14, 11),
)


def write_examples(out: Path | str) -> list[Path]:
    """Write all examples below `out`; gives the paths of the meshes, source and target in turn."""
    written = []
    for e in EXAMPLES:
        for k, (letter, count, merge) in enumerate((("a", e.fine, 0.0), ("b", e.coarse, COARSE_MERGE))):
            shape = make_shape(e.family, 2 * e.seed + k, variant=e.variant)
            cut = segmented(shape, count, 2 * e.seed + k, merge).segmentation
            path = write_shape(
                Path(out) / e.folder, f"{e.stem}_{letter}", shape.mesh, cut, shape.label, shape.label_names
            )
            written.append(path)
    return written


if __name__ == "__main__":
    for made in write_examples(sys.argv[1] if len(sys.argv) > 1 else "assets/examples"):
        print(made)
