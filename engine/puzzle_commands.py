"""The commands of puzzles: `solve`, `cut` and `bench puzzles`."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from .cli import progress_bar, results_folder
from .errors import BadInput, BadParameter
from .parameters import assignments, read_values
from .puzzles.parameters import PuzzleParameters

if TYPE_CHECKING:
    from .puzzles.gathering import Cutting
    from .puzzles.pieces import Puzzle, Truth
    from .puzzles.scoring import Scores
    from .puzzles.solution import PuzzleSolution

Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
Kind = Literal["squares", "merged", "rectangles", "triangles"]


def mount(app: App) -> None:
    """Add the commands of puzzles to an application."""
    app.command(solve)
    app.command(cut)
    bench = App(name="bench", help="Run benchmarks on your own files.")
    bench.command(bench_puzzles, name="puzzles")
    app.command(bench)


def solve(
    *inputs: Path,
    out: Path,
    pieces: int | None = None,
    piece_size: int | None = None,
    cut: Kind = "squares",
    rotate: Annotated[bool, Parameter(negative="")] = False,
    seed: int = 0,
    missing: float = 0.0,
    frame: Literal["known", "unknown"] | None = None,
    method: str | None = None,
    measure: str | None = None,
    set: Words = None,
    parameters: Path | None = None,
    lock: Path | None = None,
) -> None:
    """Put a picture together from its pieces and write solution.json, joins.csv, assembled.png and report.html.

    Parameters
    ----------
    inputs
        An image, which is cut and shuffled first; several, whose pieces are mixed; or a folder with one image a piece.
    out
        Folder for the results; made if it is missing.
    pieces
        Into how many pieces a picture is cut, as nearly as its size allows.
    piece_size
        The side of a square in pixels, instead of the number of pieces; 28 if neither is given.
    cut
        Squares, squares merged with neighbours, rectangles of any size, or triangles with squares.
    rotate
        Pieces may have to be turned by quarter turns.
    seed
        Seed of cutting and shuffling.
    missing
        The share of the pieces that is lost after cutting, 0 to 1.
    frame
        Whether the solver may know the size of a picture that was cut.
    method
        auto, mst, greedy, loops, lp, matchlift or diffusion.
    measure
        How unlike two sides are; `concord parameters` lists the measures.
    set
        NAME=VALUE, replaces single parameters; may be given several times.
    parameters
        A JSON object of names and values, or a solution.json; `--method`, `--measure` and `--set` still win.
    lock
        A file of wishes: joins locked or forbidden, and pieces pinned.
    """
    from .puzzles.gathering import Cutting, gather, without_frame

    values = chosen(method, measure, frame, missing, set, parameters)
    how = Cutting(cut, pieces, piece_size, rotate, seed, missing)
    with progress_bar() as progress:
        puzzle, truth, source = gather(inputs, checked_cutting(how), progress=progress)
        if values.frame == "unknown":
            puzzle = without_frame(puzzle)
        wishes = _wishes(lock, puzzle)
        if any(path.is_dir() and path.resolve() == out.resolve() for path in inputs):
            raise BadInput(f"{out} holds the pieces; choose another folder for the results, or they would be taken for pieces.")
    with results_folder(out) as folder:
        from .puzzles.solving import solve as solved

        with progress_bar() as progress:
            solution = solved(puzzle, values, wishes=wishes, progress=progress)
        _write(folder, puzzle, truth, solution, {**source, "lock": str(lock) if lock else None})


def chosen(
    method: str | None, measure: str | None, frame: str | None, missing: float, settings: list[str] | None,
    file: Path | None,
) -> PuzzleParameters:  # fmt: skip
    """The parameters of a run: those of a file, then options, then single settings; raises `BadParameter`."""
    values: dict[str, Any] = {} if file is None else read_values(file)
    if "schema" in values and isinstance(values.get("parameters"), dict):
        values = values["parameters"]  # of a solution
    options = {"method": method, "measure": measure, "frame": frame, "missing": True if missing else None}
    values |= {name: value for name, value in options.items() if value is not None}
    return PuzzleParameters().changed(**values).changed(**assignments(settings or ()))


def checked_cutting(how: "Cutting") -> "Cutting":
    """How pictures are cut, or `BadParameter` for numbers that make no sense."""
    if how.pieces is not None and how.piece_size is not None:
        raise BadParameter("Give --pieces or --piece-size, not both.")
    if how.piece_size is not None and how.piece_size < 1:
        raise BadParameter(f"A piece of {how.piece_size} pixels has no size; give --piece-size a number of pixels such as 28.")
    if not 0 <= how.missing < 1:
        raise BadParameter(f"--missing cannot be {how.missing:g}: it takes a share from 0 to less than 1.")
    if not 0 <= how.seed < 2**31:
        raise BadParameter(f"--seed cannot be {how.seed}: it takes a whole number from 0 to {2**31 - 1}.")
    return how


def _wishes(file: Path | None, puzzle: "Puzzle") -> Any:
    from .puzzles.solution import Wishes

    if file is None:
        return Wishes()
    from .puzzles.wishfile import read_wishes

    return read_wishes(file, puzzle)


def _write(folder: Path, puzzle: "Puzzle", truth: "Truth | None", solution: "PuzzleSolution", source: dict[str, Any]) -> None:
    """Score where the truth is known, write the result files and say what came out."""
    from .puzzlereport import puzzle_report
    from .puzzles.gathering import without_frame
    from .puzzles.scoring import right_joins, right_places, score
    from .puzzles.solutionfile import write_solution

    scores = right = true_joins = None
    if truth is not None:
        scores = score(puzzle, truth, solution)
        right = right_places(without_frame(puzzle), truth, solution)  # marks are of use where all is one column off, too
        true_joins = right_joins(puzzle, truth, solution)
    report = puzzle_report(puzzle, solution, scores=scores, right=right, right_joins=true_joins, source=source)
    write_solution(folder, puzzle, solution, scores=scores, source=source, right=true_joins, report=report)
    for note in (*puzzle.notes, *solution.notes):
        print(f"note: {note}")
    print(summary(puzzle, solution, scores))
    print(f"written to {folder}")


def summary(puzzle: "Puzzle", solution: "PuzzleSolution", scores: "Scores | None") -> str:
    """What came out, in a few lines."""
    seconds = ", ".join(f"{step} {value:.2f}" for step, value in solution.seconds.items())
    lines = [f"{int(solution.placed.sum())} of {puzzle.count} pieces of {puzzle.name} placed by {solution.method} "
             f"on {solution.measure}, {len(solution.joins)} joins"]  # fmt: skip
    if scores is not None:
        perfect = "perfect" if scores.perfect else "perfect but for identical pieces" if scores.perfect_tie_aware else "not perfect"
        lines.append(f"direct {scores.direct:.3f} ({scores.direct_tie_aware:.3f} with identical pieces taken for equal), "
                     f"neighbour {scores.neighbour:.3f} ({scores.neighbour_tie_aware:.3f}), {perfect}")  # fmt: skip
    return "\n".join([*lines, f"seconds: {seconds}"])


def cut(
    image: Path,
    *,
    out: Path,
    pieces: int | None = None,
    piece_size: int | None = None,
    cut: Kind = "squares",
    rotate: Annotated[bool, Parameter(negative="")] = False,
    seed: int = 0,
    missing: float = 0.0,
) -> None:
    """Cut a picture into shuffled pieces and write each as a PNG file, transparent around it.

    Parameters
    ----------
    image
        The picture to cut.
    out
        Folder for the pieces, without images in it; made if it is missing.
    pieces
        The number of pieces, as nearly as the picture's size allows.
    piece_size
        The side of a square in pixels, instead of the number of pieces; 28 if neither is given.
    cut
        Squares, squares merged with neighbours, rectangles of any size, or triangles with squares.
    rotate
        Turn every piece by random quarter turns.
    seed
        Seed of cutting and shuffling.
    missing
        The share of the pieces that is lost, 0 to 1.
    """
    from .puzzles.gathering import Cutting, cut_images
    from .puzzles.piecefolder import write_pieces

    how = checked_cutting(Cutting(cut, pieces, piece_size, rotate, seed, missing))
    with progress_bar() as progress:
        puzzle, _ = cut_images([image], how)
        written = write_pieces(puzzle, out, progress=progress)
    print(f"{len(written)} pieces written to {out}")


def bench_puzzles(
    folder: Path,
    *,
    out: Path,
    pieces: int | None = None,
    piece_size: int | None = None,
    cut: Kind = "squares",
    rotate: Annotated[bool, Parameter(negative="")] = False,
    seeds: Annotated[list[int] | None, Parameter(negative="", consume_multiple=True)] = None,
    methods: Words = None,
    measures: Words = None,
    wear: Words = None,
    missing: float = 0.0,
    frame: Literal["known", "unknown"] | None = None,
    set: Words = None,
) -> None:
    """Cut, solve and score every picture of a folder; runs.csv, tables.md and report.html. Runs that are done are kept.

    Parameters
    ----------
    folder
        Folder of pictures.
    out
        Folder for the tables; started again with the same one, only what is missing is run.
    pieces
        Into how many pieces a picture is cut, as nearly as its size allows.
    piece_size
        The side of a square in pixels, instead of the number of pieces; 28 if neither is given.
    cut
        Squares, squares merged with neighbours, rectangles of any size, or triangles with squares.
    rotate
        Pieces may have to be turned by quarter turns.
    seeds
        Seeds of cutting and shuffling (0 if none is given).
    methods
        Methods of assembly, or all (auto if none is given).
    measures
        Measures of sides, or all (the default measure if none is given).
    wear
        What the pieces suffer: none, "eroded 1", "eroded 2", "eroded 3", "jpeg 90", "noise 3", "gain 5", or all.
    missing
        The share of the pieces that is lost after cutting, 0 to 1.
    frame
        Whether the solver may know the size of the picture.
    set
        NAME=VALUE, replaces single parameters; may be given several times.
    """
    from .puzzles.benching import NO_WEAR, Plan, checked_plan, run_plan
    from .puzzles.gathering import Cutting
    from .puzzles.parameters import MEASURES, METHODS
    from .puzzles.wearing import WEAR

    values = chosen(None, None, frame, missing, set, None)
    how = checked_cutting(Cutting(cut, pieces, piece_size, rotate, 0, missing))
    if not folder.is_dir():
        raise BadInput(f"{folder} is not a folder; name a folder of pictures.")
    plan = checked_plan(Plan(
        folder, how, tuple(seeds or (0,)), _all(wear, (NO_WEAR, *WEAR)) or (NO_WEAR,), _all(measures, MEASURES) or (values.measure,),
        _all(methods, METHODS) or (values.method,), values))  # fmt: skip
    for seed in plan.seeds:
        checked_cutting(how._replace(seed=seed))
    with results_folder(out / "runs") as runs:
        before = len(list(runs.glob("*.json")))
        with progress_bar() as progress:
            results = run_plan(plan, runs, progress=progress)
        made = len(list(runs.glob("*.json"))) - before
        print(f"{made} runs made, {len(results) - made} kept from before in {runs}")
        _write_tables(out, plan, results)


def _all(names: list[str] | None, known: tuple[str, ...]) -> tuple[str, ...]:
    return known if names == ["all"] else tuple(names or ())


def _write_tables(folder: Path, plan: Any, results: list[dict[str, Any]]) -> None:
    from .puzzles.benching import NAMING, by_image, overview, results_to_csv, to_markdown
    from .report import html_table, page
    from .store import write_together

    images = len({r["image"] for r in results})
    size = f"{plan.how.pieces} pieces" if plan.how.pieces else f"{plan.how.piece_size or 28} px"
    lead = (f"{images} pictures cut into {plan.how.kind} ({size}{', turned' if plan.how.turned else ''}), always shuffled; "
            f"seeds {', '.join(map(str, plan.seeds))}; the frame is {plan.parameters.frame}. Direct, neighbour: percent.")  # fmt: skip
    tables = [overview(results), *by_image(results)]
    sections = [
        f"<h2>{escape(t.title)}</h2>{html_table(t.head, t.rows, [name not in NAMING for name in t.head])}" for t in tables
    ]
    write_together({
        folder / "runs.csv": results_to_csv(results), folder / "tables.md": to_markdown(tables, lead),
        folder / "report.html": page(f"Puzzles of {plan.folder.name}", lead, sections),
    })  # fmt: skip
    print(to_markdown(tables[:1], lead), end="")
    print(f"written to {folder}")
