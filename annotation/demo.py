"""`concord demo`: the main job on the bundled examples, from meshes and puzzle pieces to a precision table."""

from pathlib import Path
from typing import TYPE_CHECKING

from assets import example_pairs
from engine.cli import progress_bar
from engine.progress import Progress, share
from engine.shapes.parameters import DEFAULT_PRESET, preset
from engine.store import default_cache, write_atomically

from .findings.precision import ballots, precision_table
from .findings.tabletext import render
from .puzzledemo import judge_example_puzzles, vote_by_truth
from .study import add_result, create_study, open_study

if TYPE_CHECKING:
    from engine.report import PictureMaker
    from engine.shapes.result import MatchResult

    from .storage.handle import StudyHandle

PRESETS = (DEFAULT_PRESET, "thesis-rigid", "thesis-rigid-size")
TRUTH = "truth"  # the code that the known classes of the examples vote under


def run_demo(folder: Path, draw: "PictureMaker") -> None:
    """Match the first bundled pair into `folder`, and all pairs under three presets into a study with its table.

    Beside it, two pictures are cut up and put together again into `folder/puzzle` and `folder/turned`, and their joins
    are in the study too. The study's votes come from one volunteer, "truth": the semantic classes that ship with the examples, by
    the lenient rule, and where the pieces were cut from. `table.txt`, `table.csv` and the report hold the precision
    table; `demo.study` can be opened and voted on, and a second run keeps the votes that are there.
    """
    from engine.matchfile import write_matches
    from engine.report import report_page
    from engine.shapes.meshfile import load_shape

    file = folder / "demo.study"
    opened = open_study(file) if file.exists() else create_study(file, name="Bundled examples")
    with opened as study:
        with progress_bar() as progress:
            shown = judge_examples(study, share(progress, 0.0, 0.8))
            joined = judge_example_puzzles(study, folder, TRUTH, progress=share(progress, 0.8, 1.0))
        rows, votes = precision_table(study), ballots(study)
    table = render(rows, votes)
    write_atomically(folder / "table.txt", table)
    write_atomically(folder / "table.csv", render(rows, votes, "csv"))
    source, target = (load_shape(path) for path in example_pairs()[0][1:])
    write_matches(shown, folder, report=report_page(shown, draw(source, target, shown), [_section(table)]))
    print(table)
    print(*joined, sep="\n")
    print(f"{len(shown.ids)} matches between {source.mesh.name} and {target.mesh.name}; all results are in {folder}")


def judge_examples(study: "StudyHandle", progress: Progress) -> "MatchResult":
    """Match and judge all bundled pairs; returns the first pair's result under the default preset."""
    from engine.shapes.matching import describe, propose, rematch
    from engine.shapes.meshfile import load_shape, read_labels
    from engine.shapes.truth import lenient_answers

    pairs, cache, shown = example_pairs(), default_cache(), None
    for number, (name, first, second) in enumerate(pairs):
        step = share(progress, number / len(pairs), (number + 1) / len(pairs))
        shapes = load_shape(first), load_shape(second)
        labels = [read_labels(path.with_suffix(".sem")) for path in (first, second)]
        base = preset(DEFAULT_PRESET)
        described = [describe(shape, base, progress=share(step, 0.4 * k, 0.4 * k + 0.4), cache=cache)
                     for k, shape in enumerate(shapes)]  # fmt: skip
        proposals = propose(described[0], described[1], base, progress=share(step, 0.8, 1.0), cache=cache)
        for choice in PRESETS:
            result = rematch(proposals, preset(choice), preset=choice)
            shown = shown or result
            add_result(study, result, set_name=name)
            right = lenient_answers(shapes[0], shapes[1], labels[0], labels[1], result)
            vote_by_truth(study, TRUTH, result.ids, right)
    assert shown is not None
    return shown


def _section(table: str) -> tuple[str, str]:
    from html import escape

    words = ("Votes of the semantic classes that ship with the bundled pairs (lenient rule) and of where the pieces of the "
             "two pictures were cut from, both as volunteer truth, and of people.")  # fmt: skip
    return "Precision on the bundled examples", f"<p>{escape(words)}</p><pre>{escape(table)}</pre>"
