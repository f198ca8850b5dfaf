"""One pair by several methods, matched and judged: what a sweep runs, and what it keeps of it."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import BadParameter
from ..evaluation.ceiling import Ceiling, ceiling
from ..evaluation.correspondence import Evaluation, SizeClass, evaluate_tables
from ..evaluation.summary import Judged
from ..matchfile import result_to_json
from ..parameters import declared
from ..progress import Progress, share
from ..shapes.matching import Proposals, describe, match_shapes, propose, rematch
from ..shapes.parameters import PRESETS, MatchParameters
from ..shapes.result import MatchResult
from ..shapes.truth import label_table
from ..store import Cache, cache_key, default_cache
from .pairs import LabelledPair, Pair, content, load_pair
from .sweep import Result, Task, failed

FORM = "judged/1"
_SOURCES = ("runs/judging.py", "runs/pairs.py", "matchfile.py", "evaluation/correspondence.py", "evaluation/ceiling.py")


class Method(NamedTuple):
    """A method under the name that it was asked for, with all its parameters."""

    name: str
    preset: str
    parameters: MatchParameters


class Payload(NamedTuple):
    """A pair and all methods that it is matched by; `cold` computes every descriptor anew, for honest seconds."""

    pair: Pair
    methods: tuple[Method, ...]
    cold: bool


def chosen_methods(names: Sequence[str], changes: dict[str, Any]) -> tuple[Method, ...]:
    """Methods by the names of presets, or of methods, which stand for their first preset; each once.

    `changes` replaces single parameters in all of them. Raises `BadParameter`.
    """
    return tuple(_method(name, changes) for name in dict.fromkeys(names))


def _method(name: str, changes: dict[str, Any]) -> Method:
    first: dict[str, str] = {}
    for known, values in PRESETS.items():
        first.setdefault(values.method, known)
    preset = name if name in PRESETS else first.get(name, "")
    if not preset:
        every = dict.fromkeys([*PRESETS, *first])
        raise BadParameter(f"There is no method or preset named '{name}'; there are: {', '.join(every)}.")
    return Method(name, preset, PRESETS[preset].changed(**changes))


def task(pair: Pair, methods: Sequence[Method], *, cold: bool = False) -> Task:
    """All methods on one pair; the keys change with the files, the parameters and the code of the matching."""
    source = content(pair)
    keys = tuple(
        cache_key(FORM, code_digest(), source, m.preset, sorted(m.parameters.model_dump().items()), cold)[:32] for m in methods
    )
    return Task(f"{pair.family} {pair.name}", keys, Payload(pair, tuple(methods), cold))


@lru_cache(maxsize=1)
def code_digest() -> str:
    """A hash of the code and fitted numbers that results depend on: results of other code are made anew, not mixed with these."""
    engine = Path(__file__).resolve().parents[1]
    folders = [file for name in ("shapes", "consistency") for file in sorted((engine / name).rglob("*.*"))]
    hasher = hashlib.sha256()
    for file in [file for file in folders if "__pycache__" not in file.parts] + [engine / name for name in _SOURCES]:
        hasher.update(file.relative_to(engine).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return hasher.hexdigest()


def match_and_judge(payload: Payload, wanted: tuple[int, ...], progress: Progress) -> list[Result]:
    """The results of the methods numbered `wanted`: matches, figures, seconds, or the sentence of what went wrong."""
    cache = None if payload.cold else default_cache()
    pair = load_pair(payload.pair)
    results: dict[int, Result] = {}
    groups = _groups(payload.methods, wanted)
    for number, group in enumerate(groups):
        step = share(progress, number / len(groups), (number + 1) / len(groups))
        results.update(_group_results(pair, payload.methods, group, step, cache))
    return [results[row] for row in wanted]


def matched(pair: LabelledPair, method: Method, cache: Cache | None) -> MatchResult:
    """The result of one method alone; raises `BadInput` as `match_shapes` does."""
    return match_shapes(pair.source, pair.target, method.parameters, preset=method.preset, cache=cache)


def _groups(methods: Sequence[Method], wanted: Sequence[int]) -> list[list[int]]:
    """Methods whose slow steps are the same: their parameters differ in live ones only."""
    slow = [info.name for info in declared(MatchParameters) if not info.live]
    groups: dict[tuple[object, ...], list[int]] = {}
    for row in wanted:
        groups.setdefault(tuple(getattr(methods[row].parameters, name) for name in slow), []).append(row)
    return list(groups.values())


def _group_results(
    pair: LabelledPair, methods: Sequence[Method], rows: Sequence[int], progress: Progress, cache: Cache | None
) -> dict[int, Result]:
    """The results of methods that share their proposals; one that fails, however that is, leaves the others alone."""
    try:
        proposals = _proposals(pair, methods[rows[0]].parameters, progress, cache)
    except Exception as error:
        return dict.fromkeys(rows, failed(error))
    results: dict[int, Result] = {}
    for row in rows:
        try:
            result = rematch(proposals, methods[row].parameters, preset=methods[row].preset)
            results[row] = _judged(pair, proposals, result)
        except Exception as error:
            results[row] = failed(error)
    return results


def _proposals(pair: LabelledPair, parameters: MatchParameters, progress: Progress, cache: Cache | None) -> Proposals:
    first = describe(pair.source, parameters, progress=share(progress, 0.0, 0.4), cache=cache)
    second = describe(pair.target, parameters, progress=share(progress, 0.4, 0.8), cache=cache)
    return propose(first, second, parameters, progress=share(progress, 0.8, 1.0), cache=cache)


def _judged(pair: LabelledPair, proposals: Proposals, result: MatchResult) -> Result:
    """What is kept of a result: its figures, the ceiling of its nodes, and the matches as matches.json has them."""
    classes = np.unique(np.concatenate([pair.source_label, pair.target_label]))
    source, target = (
        label_table(shape, label, classes)
        for shape, label in ((pair.source, pair.source_label), (pair.target, pair.target_label))
    )
    figures = evaluate_tables(source, target, [(m.source, m.target) for m in result.matches()])
    most = ceiling(source, target, proposals.source.layers.members, proposals.target.layers.members)
    return {
        "failure": "",
        "figures": {name: _known(value) for name, value in asdict(figures).items()},
        "ceiling": most._asdict(),
        "seconds": sum(result.seconds.values()),
        "notes": list(result.notes),
        "matches": result_to_json(result),
    }


def _known(value: Any) -> Any:
    """Numbers as JSON has them: there is no NaN."""
    return None if isinstance(value, float) and math.isnan(value) else value


def judged(pair: Pair, method: Method, result: Result) -> Judged:
    """A kept result as the tables take it; `figures` None where the method failed."""
    if result["failure"]:
        return Judged(pair.family, pair.name, method.name, None, None, float("nan"), result["failure"])
    values: dict[str, Any] = {name: float("nan") if value is None else value for name, value in result["figures"].items()}
    figures = Evaluation(**{**values, "sizes": tuple(SizeClass(*row) for row in result["figures"]["sizes"])})
    return Judged(pair.family, pair.name, method.name, figures, Ceiling(**result["ceiling"]), float(result["seconds"]), "")
