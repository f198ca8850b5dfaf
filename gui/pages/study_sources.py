"""What a new study may be made of: what the window shows, files of results, and other studies. No widget here."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from annotation.matchesfile import run_of_json
from annotation.puzzlejoins import solution_run
from annotation.records import Run
from annotation.resultfile import read_results
from engine.errors import BadInput
from engine.progress import Progress

if TYPE_CHECKING:
    from engine.shapes.result import MatchResult

    from ..session import State
    from .collection_state import CollectionState
    from .puzzle_state import PuzzleState

RESULT_FILES = ("matches.json", "solution.json")
MOST_FILES = 5000


class Source(NamedTuple):
    """Results that may be judged: what they are called, their runs, and the shapes that their items show."""

    title: str
    runs: tuple[Run, ...]
    shapes: tuple[Any, ...] = ()

    @property
    def detail(self) -> str:
        """'12 matches', or '21 pairs, 410 matches'."""
        return counts_text([self])


class Counted(NamedTuple):
    """How much there is to judge: distinct matches, methods, and pairs of shapes or puzzles."""

    matches: int
    methods: int
    pairs: int


def counted(sources: Iterable[Source]) -> Counted:
    """What the sources hold together; a match that several methods propose counts once."""
    runs = [run for source in sources for run in source.runs]
    items = {p.item.id for run in runs for p in run.proposals}
    inputs = {tuple(sorted((str(r.source.get("sha256", "")), str(r.target.get("sha256", ""))))) for r in runs}
    return Counted(len(items), len({(r.method, r.preset) for r in runs}), len(inputs))


def counts_text(sources: Sequence[Source]) -> str:
    """'240 matches of 3 methods on 12 pairs'."""
    found = counted(sources)
    return (f"{plural(found.matches, 'match', 'matches')} of {plural(found.methods, 'method')} "
            f"on {plural(found.pairs, 'pair or puzzle', 'pairs or puzzles')}")  # fmt: skip


def plural(count: int, one: str, many: str = "") -> str:
    """'1 match', '2 matches'."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def shown_sources(state: "State", collection: "CollectionState | None", puzzle: "PuzzleState | None") -> list[Source]:
    """What the pages of the window show: a pair, a collection, a solved puzzle."""
    found = []
    if state.result is not None and len(state.result.ids):
        names = f"{state.source.mesh.name} – {state.target.mesh.name}"
        found.append(Source(f"The pair {names}", (_run(state.result, state.set_name),), (state.source, state.target)))
    if collection is not None and collection.found is not None:
        results = [result for result in collection.found.results if len(result.ids)]
        if results:
            runs = tuple(_run(result, "collection") for result in results)
            found.append(Source("The collection that is open", runs, tuple(collection.found.shapes)))
    if puzzle is not None and puzzle.solution is not None and len(puzzle.solution.joins):
        run = solution_run(puzzle.puzzle, puzzle.solution, puzzle.puzzle.name, guided=bool(puzzle.wishes))
        found.append(Source(f"The puzzle {puzzle.puzzle.name}", (run,)))
    return found


def _run(result: "MatchResult", set_name: str) -> Run:
    from engine.matchfile import result_to_json

    return run_of_json(result_to_json(result), set_name)


def result_files(path: Path) -> list[Path]:
    """The files of results that a path means: itself, or all in a folder; raises `BadInput` where there is none."""
    if not path.is_dir():
        return [path]
    found = sorted(file for name in RESULT_FILES for file in path.rglob(name))
    if not found:
        raise BadInput(f"{path} holds no matches.json and no solution.json; choose a folder into which results were exported.")
    if len(found) > MOST_FILES:
        raise BadInput(f"{path} holds {len(found)} files of results; choose a folder with at most {MOST_FILES}.")
    return found


def read_source(path: Path, set_name: str, progress: Progress) -> Source:
    """The results in a file or a folder, as one source, with the shapes that lie where the files say."""
    files = result_files(path)
    runs = []
    for row, file in enumerate(files):
        progress(row / len(files), f"Reading {file.parent.name}/{file.name}")
        runs.append(read_results(file, set_name))
    if not any(run.proposals for run in runs):
        raise BadInput(f"{path} holds results without a single match; choose others.")
    return Source(path.name if path.is_dir() else f"{path.parent.name}/{path.name}", tuple(runs), tuple(shapes_of(runs)))


def shapes_of(runs: Iterable[Run]) -> list[Any]:
    """The shapes of runs that can be read from where they were, each once; the others are found when they are shown."""
    from engine.shapes.identity import mesh_id
    from engine.shapes.meshfile import load_shape

    found: dict[tuple[str, str], Any] = {}
    for side in (side for run in runs if run.kind == "shape" for side in (run.source, run.target)):
        key = str(side.get("file", "")), str(side.get("sha256", ""))
        if key in found or not Path(key[0] or "?").is_file():
            continue
        try:
            shape = load_shape(Path(key[0]))
        except BadInput:
            continue
        if mesh_id(shape.mesh) == key[1]:
            found[key] = shape
    return list(found.values())
