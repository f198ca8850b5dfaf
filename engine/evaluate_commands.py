"""The command `evaluate`: methods on all pairs of a collection, judged by the truth; tables and pictures."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from .cli import progress_bar, results_folder
from .errors import BadParameter
from .parameters import assignments
from .progress import Progress, share
from .shapes.parameters import DEFAULT_PRESET

if TYPE_CHECKING:
    from .report import PictureMaker
    from .runs.collection import Collection
    from .runs.judging import Method
    from .runs.pairs import Pair
    from .runs.sweep import Result

Words = Annotated[list[str] | None, Parameter(negative="", consume_multiple=True)]
Switch = Parameter(negative="")
MOST_JOBS = 256


@Parameter(name="*")
@dataclass(frozen=True, slots=True)
class Asked:
    """Which pairs of a collection are meant."""

    families: Annotated[Words, Parameter(help="Only these families (sub-folders); all if none is named.")] = None
    pairs: Annotated[str, Parameter(help="auto: NAME_a with NAME_b, else each shape with the next; all; or how many pairs of "
                                         "each family.")] = "auto"  # fmt: skip
    case: Annotated[str, Parameter(help="Two segmentations by their names: coarse-fine takes NAME.coarse.seg for the first "
                                        "shape of a pair and NAME.fine.seg for the second.")] = ""  # fmt: skip
    source_labels: Annotated[str, Parameter(help="Ending of the segment labels of the first shape, such as .over.seg.")] = ""
    target_labels: Annotated[str, Parameter(help="The same for the second shape; that of the first if left out.")] = ""
    truth: Annotated[str, Parameter(help="Ending of the truth labels, one class a face.")] = ".sem"
    segments: Annotated[str, Parameter(help="LOW-HIGH: cut the truth at random into so many segments, by --seed; 10-16 for "
                                            "generated shapes and for folders without segment labels.")] = ""  # fmt: skip
    seed: Annotated[int, Parameter(help="Seed of random cuts; of the first generated pair.")] = 0
    variant: Annotated[Literal["touching", "welded", "both"], Parameter(help="Surface of generated shapes.")] = "both"
    pose: Annotated[Literal["upright", "turned"], Parameter(help="Pose of generated shapes.")] = "turned"


EVERYTHING = Asked()


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a sweep gave: the results by pair and method, in the order of the collection; `layers` by family, where set."""

    collection: "Collection"
    methods: "tuple[Method, ...]"
    layers: dict[str, int]
    results: "dict[tuple[int, int], Result]"

    def method_on(self, pair: "Pair", number: int) -> "Method":
        """A method as it was run on a pair: with the layers of the pair's family, where they were set."""
        method = self.methods[number]
        layers = self.layers.get(pair.family, method.parameters.layers)
        return method._replace(parameters=method.parameters.changed(layers=layers))


def mount(app: App, draw: "PictureMaker") -> None:
    """Add the command to an application; `draw` makes the pictures."""

    @app.command
    def evaluate(
        collection: str,
        *,
        out: Path,
        methods: Words = None,
        asked: Asked = EVERYTHING,
        set: Words = None,
        jobs: int = 0,
        keep_matches: Annotated[bool, Switch] = False,
        pictures: int = 2,
        cold: Annotated[bool, Switch] = False,
    ) -> None:
        """Run methods on all pairs of a collection and judge them by the truth: tables, tests and pictures.

        Writes report.html, tables and pairs as .md and .tex, and pairs.csv, sets.csv, sizes.csv, tests.csv. Started
        again with the same --out, only what is missing is run.

        Parameters
        ----------
        collection
            A folder of meshes with truth labels (NAME.off, NAME.sem) and segment labels (NAME.seg), each sub-folder a
            family; or the word generated, for pairs made by seed.
        out
            Folder for the results; made if it is missing.
        methods
            Presets, or methods (which stand for their first preset); every other one is tested against the first.
        set
            NAME=VALUE, replaces single parameters of all methods; may be given several times.
        jobs
            Processes to use; 0 leaves one core free.
        keep_matches
            Also write the matches of every pair and method into OUT/matches.
        pictures
            How many of the best and of the worst pairs of each method to draw.
        cold
            Compute every descriptor anew, for honest seconds.
        """
        from .evaluate_report import write_matches_of, write_report

        if not 0 <= pictures <= 20:
            raise BadParameter(f"--pictures cannot be {pictures}: it takes 0 to 20.")
        chosen = methods_of(methods or (DEFAULT_PRESET,), set or ())
        with results_folder(out) as folder, progress_bar() as progress:
            outcome = run(collection, asked, chosen, folder, jobs=jobs, cold=cold, progress=share(progress, 0.0, 0.97))
            if keep_matches:
                write_matches_of(outcome, folder)
            text = write_report(outcome, folder, draw, pictures, share(progress, 0.97, 1.0))
        print(text, end="")
        print(f"\nwritten to {out}")


def methods_of(names: Sequence[str], settings: Sequence[str]) -> "tuple[Method, ...]":
    """Methods by the names of presets or methods, with single parameters replaced; raises `BadParameter`."""
    from .runs.judging import chosen_methods

    return chosen_methods(names, assignments(settings))


def run(
    collection: str,
    asked: Asked,
    methods: "tuple[Method, ...]",
    out: Path,
    *,
    layers: dict[str, int] | None = None,
    jobs: int = 0,
    cold: bool = False,
    progress: Progress,
) -> Outcome:
    """All methods on all pairs; results are kept in OUT/runs. Raises `BadInput` or `BadParameter` before any long work.

    `layers` gives single families another number of layers.
    """
    from .runs.judging import match_and_judge, task
    from .runs.sweep import run_tasks

    if not 0 <= jobs <= MOST_JOBS:
        raise BadParameter(f"--jobs cannot be {jobs}: it takes 0 to {MOST_JOBS}.")
    found = the_collection(collection, asked, progress=share(progress, 0.0, 0.05))
    unknown = [name for name in layers or {} if name not in {pair.family for pair in found.pairs}]
    if unknown:
        raise BadParameter(f"--layers names '{unknown[0]}', which is no set of {found.name}.")
    outcome = Outcome(found, methods, dict(layers or {}), {})
    tasks = [task(pair, [outcome.method_on(pair, k) for k in range(len(methods))], cold=cold) for pair in found.pairs]
    processes = jobs or max(1, (os.cpu_count() or 2) - 1)
    kept = run_tasks(tasks, match_and_judge, out / "runs", jobs=processes, progress=share(progress, 0.05, 1.0))
    outcome.results.update({(i, k): kept[key] for i, one in enumerate(tasks) for k, key in enumerate(one.keys)})
    return outcome


def the_collection(name: str, asked: Asked, *, progress: Progress) -> "Collection":
    """The pairs that were asked for; raises `BadInput` or `BadParameter` in one sentence."""
    from .runs.collection import GENERATED, Layout, folder_collection, generated_collection
    from .shapes.families import parse_segments

    if not 0 <= asked.seed < 2**31:
        raise BadParameter(f"--seed cannot be {asked.seed}: it takes a whole number from 0 to {2**31 - 1}.")
    source, target = _labels(asked)
    layout = Layout(source, target, _ending(asked.truth, "--truth"), parse_segments(asked.segments or "10-16"),
                    bool(asked.segments), asked.seed, asked.pairs, tuple(dict.fromkeys(asked.families or ())))  # fmt: skip
    if name == GENERATED:
        if source or asked.truth != ".sem":
            raise BadParameter("Generated shapes bring their own labels; leave out --case, --source-labels, --target-labels "
                               "and --truth.")  # fmt: skip
        variants = ("touching", "welded") if asked.variant == "both" else (asked.variant,)
        return generated_collection(layout, variants, asked.pose)
    return folder_collection(Path(name), layout, progress=progress)


def _labels(asked: Asked) -> tuple[str, str]:
    """The endings of the segment labels of both shapes, empty where they are to be found or made."""
    ways = [name for name, value in (("--case", asked.case), ("--segments", asked.segments),
                                     ("--source-labels", asked.source_labels or asked.target_labels)) if value]  # fmt: skip
    if len(ways) > 1:
        raise BadParameter(f"{ways[0]} and {ways[1]} contradict each other; give one of them.")
    if asked.case:
        first, dash, second = asked.case.partition("-")
        if not (first and dash and second):
            raise BadParameter(f"--case cannot be '{asked.case}': it takes two names of segmentations, as in coarse-fine.")
        return f".{first}.seg", f".{second}.seg"
    if asked.target_labels and not asked.source_labels:
        raise BadParameter("--target-labels needs --source-labels beside it.")
    source = _ending(asked.source_labels, "--source-labels")
    return source, _ending(asked.target_labels, "--target-labels") or source


def _ending(text: str, option: str) -> str:
    """An ending of file names with its dot."""
    if "/" in text or "\\" in text or text in (".", ".."):
        raise BadParameter(f"{option} cannot be '{text}': it takes the ending of file names, such as .seg.")
    return text if not text or text.startswith(".") else f".{text}"
