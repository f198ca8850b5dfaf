"""How well single descriptors, and mixes of them, find the true partners of nodes on the pairs of a collection."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..errors import BadParameter
from ..evaluation.correspondence import SIZE_CLASSES, WHOLE, verdicts
from ..evaluation.retrieval import MEASURES, joined, retrieval
from ..progress import Progress, share
from ..shapes.describing import DescribedShape, describe
from ..shapes.features import FEATURES
from ..shapes.parameters import MatchParameters
from ..shapes.proposing import EXACT, SIGNATURE, every_pair, geometric_distance
from ..shapes.truth import label_table
from ..store import cache_key, default_cache
from .judging import code_digest
from .pairs import LabelledPair, Pair, content, load_pair
from .sweep import Result, Task, failed

FORM = "retrieval/1"
WEIGHTED = ("lfd", "size", "extent", "centrality", *FEATURES)
ALL_SIZES = "all"
SIZES = (ALL_SIZES, *(name for name, _, _ in SIZE_CLASSES))


class Mix(NamedTuple):
    """Descriptors by the names in WEIGHTED with their weights; `lfd` is the kind of light field distance."""

    name: str
    weights: tuple[tuple[str, float], ...]
    lfd: str = EXACT


class Payload(NamedTuple):
    """A pair, the parameters that it is described by, and the mixes to judge."""

    pair: Pair
    parameters: MatchParameters
    mixes: tuple[Mix, ...]


def _mix(name: str, **weights: float) -> Mix:
    return Mix(name, tuple(weights.items()))


def _five(weight: float) -> dict[str, float]:
    return dict.fromkeys(("d1", "d2", "d3", "d4", "a3"), weight)


SINGLES = (
    _mix("LFD, exact", lfd=1), Mix("LFD, quantile signature", (("lfd", 1.0),), SIGNATURE),
    _mix("D1", d1=1), _mix("D2", d2=1), _mix("D3", d3=1), _mix("D4", d4=1), _mix("A3", a3=1),
    _mix("principal components", pca=1), _mix("HKS", hks=1), _mix("persistent HKS", phks=1),
    _mix("volume and area", volume=1), _mix("relative size", size=1), _mix("relative extent", extent=1),
    _mix("mean geodesic distance", centrality=1),
)  # fmt: skip
TOGETHER = (
    _mix("D1–D4 + A3", **_five(1)),
    _mix("LFD + size", lfd=1, size=1),
    _mix("LFD + size + geodesic", lfd=1, size=2, centrality=4),
    _mix("LFD + extent + geodesic", lfd=1, extent=0.5, centrality=2),
    _mix("LFD + D1–D4 + A3", lfd=1, **_five(0.4)),
    _mix("D1–D4 + A3 + size + geodesic", **_five(0.4), size=2, centrality=4),
    _mix("LFD + persistent HKS", lfd=1, phks=0.7),
    _mix("all", lfd=1, size=1, extent=0.5, centrality=4, **_five(0.2), pca=0.5, hks=0.5, phks=0.7, volume=0.6),
)


def custom_mix(text: str) -> Mix:
    """A mix from NAME=WEIGHT,NAME=WEIGHT, such as lfd=1,size=2; raises `BadParameter` in one sentence."""
    weights: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = part.partition("=")
        try:
            weights[name.strip()] = float(number)
        except ValueError:
            raise BadParameter(f"--mix cannot be '{text}': it takes NAME=WEIGHT,NAME=WEIGHT, as in lfd=1,size=2.") from None
    unknown = [name for name in weights if name not in WEIGHTED]
    if unknown:
        raise BadParameter(f"There is no descriptor named '{unknown[0]}'; the descriptors are: {', '.join(WEIGHTED)}.")
    mix = Mix(" + ".join(f"{value:g} {name}" for name, value in weights.items()), tuple(weights.items()))
    weighted(MatchParameters(), mix)
    if not any(weights.values()):
        raise BadParameter(f"--mix cannot be '{text}': at least one weight must be above 0.")
    return mix


def weighted(parameters: MatchParameters, mix: Mix) -> MatchParameters:
    """The parameters with the weights of the mix and no others; raises `BadParameter` for a weight out of range."""
    weights = {f"{name}_weight": 0.0 for name in WEIGHTED} | {f"{name}_weight": value for name, value in mix.weights}
    return parameters.changed(**weights, lfd=mix.lfd)


def retrieval_task(pair: Pair, parameters: MatchParameters, mixes: Sequence[Mix]) -> Task:
    """All mixes on one pair; the keys change with the files, the parameters and the code."""
    values = [sorted(weighted(parameters, mix).model_dump().items()) for mix in mixes]
    source = content(pair)
    keys = tuple(cache_key(FORM, code_digest(), source, value)[:32] for value in values)
    return Task(f"{pair.family} {pair.name}", keys, Payload(pair, parameters, tuple(mixes)))


def retrieve(payload: Payload, wanted: tuple[int, ...], progress: Progress) -> list[Result]:
    """The figures of the mixes numbered `wanted`: for each size of query, their number and the sums of all measures.

    `sums` maps a size class to [queries, measures ..., their values by chance ...], in the order of MEASURES; or there
    is the sentence of what went wrong.
    """
    mixes = [payload.mixes[number] for number in wanted]
    pair = load_pair(payload.pair)
    try:
        return _retrieved(pair, payload.parameters, mixes, progress)
    except Exception as error:
        return [{**failed(error), "sums": {}}] * len(mixes)


def _retrieved(pair: LabelledPair, parameters: MatchParameters, mixes: Sequence[Mix], progress: Progress) -> list[Result]:
    cache = default_cache()
    source = describe(pair.source, parameters, progress=share(progress, 0.0, 0.4), cache=cache)
    target = describe(pair.target, parameters, progress=share(progress, 0.4, 0.8), cache=cache)
    truth = true_partners(pair, source, target)
    every = {kind: every_pair(source, target, kind, cache=cache) for kind in dict.fromkeys(mix.lfd for mix in mixes)}
    results: list[Result] = []
    for mix in mixes:
        distance = geometric_distance(every[mix.lfd], weighted(parameters, mix))
        results.append({"failure": "", "sums": _sums(distance.reshape(truth.shape), truth, (source, target))})
    return results


def true_partners(pair: LabelledPair, source: DescribedShape, target: DescribedShape) -> np.ndarray:
    """Strict truth (n, m) bool of all nodes but the last, the whole shape: Jaccard of class coverage at least one half."""
    classes = np.unique(np.concatenate([pair.source_label, pair.target_label]))
    tables = [label_table(shape, label, classes)
              for shape, label in ((pair.source, pair.source_label), (pair.target, pair.target_label))]  # fmt: skip
    h, g = (d.layers.members[:-1].astype(np.float64) @ table for d, table in zip((source, target), tables, strict=True))
    return verdicts(h, g, tables[0].sum(axis=0), tables[1].sum(axis=0))[1]


def _sums(distance: np.ndarray, truth: np.ndarray, described: Sequence[DescribedShape]) -> dict[str, list[float]]:
    """Sums over the queries of both directions, by size class; nodes of nearly all of a shape are left out."""
    rows, columns = (d.measures.size[:-1] <= WHOLE for d in described)
    sizes = [d.layers.members[:-1].sum(axis=1) for d in described]
    d, t = distance[np.ix_(rows, columns)], truth[np.ix_(rows, columns)]
    found = joined([retrieval(d, t, sizes[0][rows]), retrieval(d.T, t.T, sizes[1][columns])])
    chosen = {ALL_SIZES: np.ones(len(found.size), dtype=bool)}
    chosen |= {name: (found.size >= low) & (found.size <= high) for name, low, high in SIZE_CLASSES}
    both = np.concatenate([found.figures, found.chance], axis=1)
    return {name: [int(mask.sum()), *both[mask].sum(axis=0).tolist()] for name, mask in chosen.items()}


class Row(NamedTuple):
    """The figures of one mix on a set of pairs for one size of query, means over pairs in the order of MEASURES."""

    mix: str
    set_name: str
    size: str
    pairs: int
    queries: int
    figures: tuple[float, ...]
    chance: tuple[float, ...]


def row_of(mix: str, set_name: str, size: str, results: Iterable[Result]) -> Row:
    """Means over the pairs that have such a query; NaN where none has."""
    sums = [np.array(result["sums"][size]) for result in results if result["sums"] and result["sums"][size][0]]
    means = np.mean([s[1:] / s[0] for s in sums], axis=0) if sums else np.full(2 * len(MEASURES), np.nan)
    queries = int(sum(s[0] for s in sums))
    half = len(MEASURES)
    return Row(mix, set_name, size, len(sums), queries, tuple(means[:half].tolist()), tuple(means[half:].tolist()))
