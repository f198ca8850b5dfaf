"""What a few answers bring: somebody who knows the truth judges the first matches of the list, and the rest comes anew.

    python tests/benchmarks/anchors.py --families vases lamps --pairs 6 --seed 7000 --answers 5
    python tests/benchmarks/anchors.py --folder shapes/princeton --case coarse-fine --families Airplane --limit 5

Each round the next matches of the list, best first, are judged by the strict rule; correct ones are pinned and wrong ones
forbidden. Printed are the figures of all matches, and those of the matches that nobody has judged: there is what the
answers bring beyond themselves. Beside it stands the same without matching again, wrong ones only struck out.
"""

import argparse
from functools import reduce

import numpy as np

from engine.evaluate_commands import Asked, the_collection
from engine.evaluation.correspondence import Evaluation, pooled, verdicts
from engine.progress import silent
from engine.runs.pairs import LabelledPair, load_pair
from engine.shapes.describing import describe
from engine.shapes.matching import propose, rematch
from engine.shapes.parameters import DEFAULT_PRESET, preset
from engine.shapes.truth import evaluate_matches, label_table
from engine.shapes.wishes import NO_WISHES, Pair, Wishes
from engine.store import default_cache


def right(pair: LabelledPair, match: Pair) -> bool:
    """Whether a match is right by the strict rule."""
    classes = np.unique(np.concatenate([pair.source_label, pair.target_label]))
    tables = [label_table(shape, label, classes)
              for shape, label in ((pair.source, pair.source_label), (pair.target, pair.target_label))]  # fmt: skip
    rows = [table[list(union)].sum(axis=0, keepdims=True) for table, union in zip(tables, match, strict=True)]
    return bool(verdicts(*rows, *(table.sum(axis=0) for table in tables))[1][0, 0])


def judged(pair: LabelledPair, matches: list[Pair], known: dict[Pair, bool], most: int) -> dict[Pair, bool]:
    """The answers so far and those to the next matches that have none."""
    new = [match for match in matches if match not in known][:most]
    return known | {match: right(pair, match) for match in new}


def wishes_of(known: dict[Pair, bool]) -> Wishes:
    """The answers as wishes; where two right ones share a union, the first stays."""
    first = reduce(lambda kept, match: kept if any(match[0] == s or match[1] == t for s, t in kept) else (*kept, match),
                   (match for match, answer in known.items() if answer), ())  # fmt: skip
    return Wishes(first, tuple(match for match, answer in known.items() if not answer))


def figures(evaluations: list[Evaluation]) -> str:
    """Lenient and strict precision and label transfer, pooled."""
    e = pooled(evaluations)
    return f"{e.lenient:.3f} / {e.strict:.3f}   {e.transfer_precision:.3f} / {e.transfer_recall:.3f}   {e.judged:5d}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", default="generated")
    parser.add_argument("--case", default="")
    parser.add_argument("--families", nargs="*")
    parser.add_argument("--pairs", default="auto", help="how many of each family")
    parser.add_argument("--limit", type=int, default=1000, help="most pairs in all")
    parser.add_argument("--seed", type=int, default=7000)
    parser.add_argument("--answers", type=int, default=5, help="answers in each round")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--preset", default=DEFAULT_PRESET)
    options = parser.parse_args()
    asked = Asked(families=options.families, pairs=options.pairs, case=options.case, seed=options.seed)
    chosen, cache = preset(options.preset), default_cache()
    rows: dict[tuple[int, str], list[Evaluation]] = {}
    for entry in the_collection(options.folder, asked, progress=silent).pairs[: options.limit]:
        pair = load_pair(entry)
        proposals = propose(*(describe(shape, chosen, cache=cache) for shape in pair[:2]), chosen, cache=cache)
        known: dict[Pair, bool] = {}
        free = [(m.source, m.target) for m in rematch(proposals, chosen).matches()]
        alone: dict[Pair, bool] = {}
        for number in range(options.rounds + 1):
            wishes = wishes_of(known) if known else NO_WISHES
            found = [(m.source, m.target) for m in rematch(proposals, chosen, wishes=wishes).matches()]
            struck = [match for match in free if alone.get(match, True)]
            for words, matches, said in (("matched again", found, known), ("struck out only", struck, alone)):
                for part, some in (("all", matches), ("not judged", [m for m in matches if m not in said])):
                    rows.setdefault((number, f"{words}, {part}"), []).append(evaluate_matches(*pair, some))
            known, alone = judged(pair, found, known, options.answers), judged(pair, free, alone, options.answers)
    print(f"{'answers':<8}{'':<28}lenient / strict   transfer precision / recall   matches")
    for (number, words), evaluations in sorted(rows.items()):
        print(f"{number * options.answers:<8}{words:<28}{figures(evaluations)}")


if __name__ == "__main__":
    main()
