"""The puzzles of `concord demo`: two pictures cut up, put together again in several ways, and judged by their truth."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from assets import example_picture
from engine.progress import Progress, share, silent
from engine.store import output_folder, write_atomically

from .study import answers, record_votes

if TYPE_CHECKING:
    from engine.puzzles.pieces import Puzzle, Truth
    from engine.puzzles.solution import PuzzleSolution

    from .storage.handle import StudyHandle

Ways = Sequence[tuple[str, str]]  # methods and measures to be compared
WAYS: Ways = (("auto", "learned"), ("mst", "mgc-root"), ("mst", "emd-lab"), ("diffusion", "emd-lab"))
TURNED_WAYS: Ways = (("auto", "learned"),)
PIECE_SIZE = 28  # pixels of a square: 378 pieces of the portrait, 432 of the landscape


def judge_example_puzzles(
    study: "StudyHandle", folder: Path, volunteer: str, *, progress: Progress = silent
) -> tuple[str, str]:
    """Solve the bundled portrait into `folder/puzzle`, and a painted landscape of turned pieces into `folder/turned`.

    Their joins go into the study, and `volunteer` votes on them as the truth does. Each folder holds solution.json,
    joins.csv, assembled.png and report.html of the first way. Returns a sentence about each.
    """
    from engine.puzzles.imagefile import png_bytes
    from engine.puzzles.scenery import landscape

    upright, turned = output_folder(folder / "puzzle"), output_folder(folder / "turned")
    write_atomically(turned / "landscape.png", png_bytes(landscape()))
    return (
        _judge(study, upright, volunteer, example_picture(), WAYS, progress=share(progress, 0.0, 0.7)),
        _judge(study, turned, volunteer, turned / "landscape.png", TURNED_WAYS, True, progress=share(progress, 0.7, 1.0)),
    )


def _judge(
    study: "StudyHandle", folder: Path, volunteer: str, picture: Path, ways: Ways, turned: bool = False, *,
    progress: Progress,
) -> str:  # fmt: skip
    """Solve one picture in each way, let the truth vote on the joins, and write what the first way found."""
    from engine.puzzles.gathering import Cutting, gather
    from engine.puzzles.parameters import PuzzleParameters
    from engine.puzzles.solving import solve

    from .results.puzzlejoins import add_solution, join_ids, truth_answers

    puzzle, truth, source = gather([picture], Cutting(piece_size=PIECE_SIZE, turned=turned))
    assert truth is not None
    found = []
    for number, (method, measure) in enumerate(ways):
        step = share(progress, number / len(ways), (number + 1) / len(ways))
        found.append(solve(puzzle, PuzzleParameters().changed(method=method, measure=measure), progress=step))
        add_solution(study, puzzle, found[-1], set_name=puzzle.name)
        joins = found[-1].joins
        vote_by_truth(study, volunteer, join_ids(puzzle, joins), truth_answers(puzzle, truth, joins))
    return _write(folder, puzzle, truth, found[0], source)


def vote_by_truth(study: "StudyHandle", volunteer: str, items: Sequence[str], right: Sequence[bool]) -> None:
    """One vote an item, by whether it is right, unless that is the volunteer's vote already."""
    given, votes = answers(study, volunteer), dict(zip(items, right, strict=True))
    told = {item: "correct" if is_right else "wrong" for item, is_right in votes.items()}
    record_votes(study, volunteer, {item: vote for item, vote in told.items() if given.get(item) != vote})


def _write(
    folder: Path, puzzle: "Puzzle", truth: "Truth", solution: "PuzzleSolution", source: dict[str, object]
) -> str:
    from engine.puzzlereport import puzzle_report
    from engine.puzzles.scoring import right_joins, right_places, score
    from engine.puzzles.solutionfile import write_solution

    scores, right = score(puzzle, truth, solution), right_places(puzzle, truth, solution)
    joined = right_joins(puzzle, truth, solution)
    report = puzzle_report(puzzle, solution, scores=scores, right=right, right_joins=joined, source=source)
    write_solution(folder, puzzle, solution, scores=scores, source=source, right=joined, report=report)
    return (
        f"{int(right.sum())} of {puzzle.count} {'turned ' if puzzle.turned else ''}pieces of {puzzle.name} stand where "
        f"they belong; the picture and its {len(solution.joins)} joins are in {folder}"
    )
