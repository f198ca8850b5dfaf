"""From what a person names, images or a folder of pieces, to a puzzle, its truth where there is one, and its source."""

import hashlib
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import BadInput
from ..progress import Progress, silent
from .cutting import Kind, cut, drop, mix
from .imagefile import opaque, plain_text, read_image
from .piecefolder import image_files, read_pieces
from .pieces import Puzzle, Truth


class Cutting(NamedTuple):
    """How pictures are cut; what is None takes the usual value."""

    kind: Kind = "squares"
    pieces: int | None = None
    piece_size: int | None = None
    turned: bool = False
    seed: int = 0
    missing: float = 0.0


def gather(
    inputs: Sequence[Path], how: Cutting, *, progress: Progress = silent
) -> tuple[Puzzle, Truth | None, dict[str, Any]]:
    """A puzzle of one picture, of several mixed, or of a folder of pieces; its truth; and what to repeat it with."""
    if not inputs:
        raise BadInput("Name an image to cut, several to mix, or a folder of pieces.")
    folders = [path for path in inputs if os.path.isdir(path)]
    if folders and len(inputs) > 1:
        raise BadInput(f"{folders[0]} is a folder of pieces, which stands alone; name one folder, or images.")
    if folders:
        if how.pieces is not None or how.piece_size is not None:
            raise BadInput(f"{folders[0]} holds pieces that are cut already; leave out --pieces and --piece-size.")
        puzzle = read_pieces(folders[0], turned=how.turned, progress=progress)
        return puzzle, None, {"files": [_file(path) for path in image_files(folders[0])], "rotate": how.turned}
    progress(0.0, "reading and cutting")
    puzzle, truth = cut_images(inputs, how)
    source = {"files": [_file(path) for path in inputs], "cut": how.kind, "pieces": how.pieces,
              "piece_size": how.piece_size, "rotate": how.turned, "seed": how.seed, "missing": how.missing}  # fmt: skip
    return puzzle, truth, source


def cut_images(paths: Sequence[Path], how: Cutting) -> tuple[Puzzle, Truth]:
    """Cut each picture, mix them where there are several, and lose the share that is to be missing."""
    parts = [
        cut(opaque(read_image(path)), kind=how.kind, pieces=how.pieces, piece_size=how.piece_size, turned=how.turned,
            seed=how.seed + k, name=plain_text(path.stem))
        for k, path in enumerate(paths)
    ]  # fmt: skip
    puzzle, truth = parts[0] if len(parts) == 1 else mix(parts, how.seed)
    return drop(puzzle, truth, how.missing, how.seed) if how.missing else (puzzle, truth)


def without_frame(puzzle: Puzzle) -> Puzzle:
    """The same puzzle, the size of its picture unknown."""
    return replace(puzzle, frame=None)


def _file(path: Path) -> dict[str, str]:
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    return {"name": plain_text(path.name), "path": plain_text(str(path.absolute())), "sha256": content}
