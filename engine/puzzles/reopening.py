"""A `solution.json` with its puzzle: the pieces are cut or read again from the files that it names."""

import hashlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import BadInput
from ..progress import Progress, silent
from .cutting import Kind
from .gathering import Cutting, cut_images
from .identity import reading_id
from .piecefolder import read_pieces
from .pieces import Puzzle, Truth
from .solution import PuzzleSolution
from .solutionfile import read_solution


class Reopened(NamedTuple):
    """A solution with its puzzle, the truth where the pieces were cut, and whether people's wishes were honoured."""

    puzzle: Puzzle
    truth: Truth | None
    solution: PuzzleSolution
    guided: bool


class _File(BaseModel):
    model_config = ConfigDict(frozen=True)

    name: Annotated[str, Field(min_length=1)]
    sha256: str
    path: str = ""


class _Source(BaseModel):
    """How the puzzle was made: pictures that were cut, or, without `cut`, a folder of pieces."""

    model_config = ConfigDict(frozen=True)

    files: Annotated[tuple[_File, ...], Field(min_length=1)]
    cut: Kind | None = None
    pieces: int | None = None
    piece_size: int | None = None
    rotate: bool = False
    seed: Annotated[int, Field(ge=0)] = 0
    missing: Annotated[float, Field(ge=0, lt=1)] = 0.0
    lock: str | None = None


class _Content(BaseModel):
    model_config = ConfigDict(frozen=True)

    source: _Source
    pieces_sha256: str


def reopen(path: Path | str, *, progress: Progress = silent) -> Reopened:
    """Read a solution and make its puzzle again.

    Files are looked for where they were, beside the solution, above it and in the current folder; only one whose hash
    is the stated one is taken. Raises `BadInput` where one is missing or the pieces are not those that were solved.
    """
    path = Path(path)
    solution = read_solution(path)
    try:
        content = _Content.model_validate(json.loads(path.read_text(encoding="utf-8")))
    except ValidationError as error:
        where = ".".join(str(part) for part in error.errors()[0]["loc"])
        raise BadInput(f"{path} does not say what its puzzle was made of ({where}); solve the puzzle again.") from None
    puzzle, truth = _made_again(content.source, path, progress)
    if reading_id(puzzle) != content.pieces_sha256 or len(solution.picture) != puzzle.count:
        raise BadInput(f"The pieces of {content.source.files[0].name} are not those of {path}; solve the puzzle again.")
    return Reopened(puzzle, truth, solution, bool(content.source.lock))


def _made_again(source: _Source, path: Path, progress: Progress) -> tuple[Puzzle, Truth | None]:
    files = [_found(file, path) for file in (source.files if source.cut else source.files[:1])]
    if source.cut is None:
        return read_pieces(files[0].parent, turned=source.rotate, progress=progress), None
    how = Cutting(source.cut, source.pieces, source.piece_size, source.rotate, source.seed, source.missing)
    return cut_images(files, how)


def _found(file: _File, path: Path) -> Path:
    """Where a file lies now."""
    changed = None
    for candidate in _candidates(file, path):
        try:
            if hashlib.sha256(candidate.read_bytes()).hexdigest() == file.sha256:
                return candidate
            changed = changed or candidate
        except OSError:
            continue
    if changed is not None:
        raise BadInput(f"{changed} is not the file that {path} was made of; put back the one that was solved.")
    raise BadInput(f"{file.name}, of which {path} was made, is not to be found; put it beside {path.name}.")


def _candidates(file: _File, path: Path) -> Iterator[Path]:
    """Likely places, the stated one first; only the name counts elsewhere, so that no path leads astray."""
    folders: Iterable[Path] = (path.parent, path.absolute().parent.parent, Path.cwd())
    yield from (Path(file.path),) if file.path else ()
    yield from (folder / Path(file.name).name for folder in folders)
