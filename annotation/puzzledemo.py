"""The puzzle of `concord demo`: the bundled picture cut up, solved in several ways, written, and judged by its truth."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from assets import example_picture
from engine.progress import Progress, share, silent

from .study import answers, record_votes

if TYPE_CHECKING:
    from engine.puzzles.pieces import Puzzle, Truth
    from engine.puzzles.solution import PuzzleSolution

    from .database import StudyFile

WAYS = (("auto", "learned"), ("mst", "mgc-root"), ("mst", "emd-lab"), ("diffusion", "emd-lab"))  # methods and measures to be compared
PIECE_SIZE = 28  # pixels of a square: 378 pieces
SET = "portrait"


def judge_example_puzzle(study: "StudyFile", folder: Path, volunteer: str, *, progress: Progress = silent) -> str:
    """Solve the bundled picture in each way, put the joins into the study and let `volunteer` vote as the truth does.

    What the first way found is written into `folder`: solution.json, joins.csv, assembled.png and report.html. Returns
    one sentence about it.
    """
    from engine.puzzles.gathering import Cutting, gather
    from engine.puzzles.parameters import PuzzleParameters
    from engine.puzzles.solving import solve

    from .puzzlejoins import add_solution, join_ids, truth_answers

    puzzle, truth, source = gather([example_picture()], Cutting(piece_size=PIECE_SIZE))
    assert truth is not None
    found = []
    for number, (method, measure) in enumerate(WAYS):
        step = share(progress, number / len(WAYS), (number + 1) / len(WAYS))
        found.append(solve(puzzle, PuzzleParameters().changed(method=method, measure=measure), progress=step))
        add_solution(study, puzzle, found[-1], set_name=SET)
        joins = found[-1].joins
        vote_by_truth(study, volunteer, join_ids(puzzle, joins), truth_answers(puzzle, truth, joins))
    return _write(folder, puzzle, truth, found[0], source)


def vote_by_truth(study: "StudyFile", volunteer: str, items: Sequence[str], right: Sequence[bool]) -> None:
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
        f"{int(right.sum())} of {puzzle.count} pieces of {puzzle.name} stand where they belong; the picture and its "
        f"{len(solution.joins)} joins are in {folder}"
    )
