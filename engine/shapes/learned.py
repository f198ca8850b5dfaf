"""The calibrated probability that two nodes are true partners: small networks fitted to shapes with known truth.

`learned.json` is written by `tests/benchmarks/shape_training.py`, which also prints how well the fit does on classes of
shapes that it was not fitted to. Each stage is an average of a few networks with three outputs: the probability that a
pair is right by the strict and by the lenient rule of `evaluation.correspondence`, and the share of its area that gets
its own class. The first stage sees the two nodes alone, later ones also what the rest of the pair says.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..networks import log_odds, logistic, read_networks
from ..progress import Progress, silent
from ..store import cache_key, digest
from .context import Neighbourhood, context_features, hypothesis_features, neighbourhood
from .describing import DescribedShape
from .identity import node_id
from .lightfield import light_field_distances
from .nodefeatures import node_features
from .pairfeatures import Side, look_at_pairs
from .surfacepoints import SurfacePoints, restored, surface_points

FILE = Path(__file__).with_name("learned.json")
POINTS = 700
VERSION = "learned/2"
# Columns of the first inputs by which the top-down method tells how alike nodes look, and their weights: light field
# distance, extent, centrality.
LOOKS = {1: 1.0, 2: 0.5, 3: 2.0}
SCALE = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Pairs of nodes (c, 2) int64 sorted, the probability (c,) that each is right, and the share of area `pure` (c,)
    that a match of the two gives its own class, both in [0, 1]."""

    pairs: np.ndarray
    right: np.ndarray
    pure: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What the networks are asked about a pair of shapes: `pairs` (c, 2), `inputs` (c, f) of the first stage, and what
    the later ones need."""

    pairs: np.ndarray
    inputs: np.ndarray
    around: Neighbourhood


@lru_cache(maxsize=1)
def weights() -> dict[str, Any]:
    """The fitted numbers: `stages`, lists of networks."""
    return read_networks(FILE)


@lru_cache(maxsize=1)
def _fit() -> str:
    """Changes with the fitted numbers."""
    return digest(FILE.read_bytes())


def judge(source: DescribedShape, target: DescribedShape, *, progress: Progress = silent) -> Judged:
    """The pairs of nodes that are worth looking at, with their probabilities; whole shapes are not among them.

    Swapping the shapes swaps the result. Takes about a second for 400 nodes; the cache of the shapes keeps it.
    """
    if _order(target) < _order(source):
        swapped = judge(target, source, progress=progress)
        order = np.lexsort((swapped.pairs[:, 0], swapped.pairs[:, 1]))
        return Judged(swapped.pairs[order][:, ::-1], swapped.right[order], swapped.pure[order])

    def make() -> dict[str, np.ndarray]:
        from ..consistency.semidefinite import one_thread

        with one_thread():  # many small products: more threads only wait for each other
            seen = look(source, target, progress=progress)
            progress(0.8, "judging pairs")
            found = probabilities(weights()["stages"], seen)
        return {"pairs": seen.pairs, "found": found}

    if source.cache is None:
        made = make()
    else:
        known = [x for shape in (source, target) for x in _known(shape)]
        made = source.cache.arrays(cache_key(VERSION, _fit(), *known), make)
    outputs = made["found"]
    return Judged(made["pairs"], outputs[:, :2].min(axis=1), outputs[:, 2])


def _known(shape: DescribedShape) -> tuple[object, ...]:
    """All of a shape that its judgement depends on, for the key of the cache."""
    nodes = np.packbits(shape.layers.members, axis=1)
    return (shape.segment_ids, shape.descriptors, nodes, shape.graph.edges, shape.measures.between, shape.parameters.seed)


def _order(shape: DescribedShape) -> str:
    return node_id(shape.segment_ids)


def look(source: DescribedShape, target: DescribedShape, *, progress: Progress = silent) -> Seen:
    """What the networks see of a pair; the last node of either graph, the whole shape, is left out."""
    progress(0.0, "surface points")
    sides = [_side(shape) for shape in (source, target)]
    progress(0.3, "laying the shapes upon each other")
    looks = look_at_pairs(*sides)
    progress(0.6, "light field distances")
    lfd = light_field_distances(source.descriptors, target.descriptors, looks.pairs)
    i, j = looks.pairs.T
    s, t = source.measures, target.measures
    extent, centrality = (np.abs(np.log(x[i]) - np.log(y[j])) for x, y in ((s.extent, t.extent), (s.centrality, t.centrality)))
    inputs = np.column_stack([looks.near, lfd, extent, centrality, looks.inputs]).astype(np.float32)
    return Seen(looks.pairs, inputs, neighbourhood(source, target))


def probabilities(stages: list[list[dict[str, Any]]], seen: Seen) -> np.ndarray:
    """The three outputs (c, 3) of the last stage."""
    found = average(stages[0], seen.inputs)
    for stage in stages[1:]:
        found = average(stage, later_inputs(seen, found))
    return found


def later_inputs(seen: Seen, found: np.ndarray) -> np.ndarray:
    """The inputs of a later stage, (c, f): those of the first, the outputs `found` (c, 3), the context under them, and two
    hypotheses: the set that agrees best by the looks of the nodes alone, and by these outputs."""
    right = found[:, :2].min(axis=1)
    looks = np.exp(-sum(weight * seen.inputs[:, column] for column, weight in LOOKS.items()) / SCALE)
    return np.concatenate([
        seen.inputs, context_features(seen.pairs, right, seen.around), found,
        hypothesis_features(seen.pairs, looks.astype(np.float64), seen.around),
        hypothesis_features(seen.pairs, right, seen.around),
    ], axis=1).astype(np.float32)  # fmt: skip


def average(nets: list[dict[str, Any]], inputs: np.ndarray) -> np.ndarray:
    """The mean output (c, 3) of a stage's networks, to six digits: so far they agree on every machine."""
    total = sum((logistic(log_odds(net, inputs)) for net in nets), np.zeros(1))
    return np.round(total / len(nets), 6)


def points_of(shape: DescribedShape) -> SurfacePoints:
    """The surface points of a shape, made once and kept on disk."""

    def make() -> dict[str, np.ndarray]:
        return surface_points(shape.shape, count=POINTS, seed=shape.parameters.seed).arrays()

    if "points" not in shape.kept:
        key = cache_key("points/1", shape.segment_ids, POINTS, shape.parameters.seed)
        shape.kept["points"] = restored(make() if shape.cache is None else shape.cache.arrays(key, make))
    return shape.kept["points"]


def _side(shape: DescribedShape) -> Side:
    points, members = points_of(shape), shape.layers.members[:-1]
    return Side(points, members, members.shape[1], shape.signatures[:-1], node_features(points, shape.graph, members))
