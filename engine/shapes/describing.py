"""All that is slow about one shape: its graphs, measures and descriptors, kept on disk between runs."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import BadInput
from ..progress import Progress, share, silent
from ..store import Cache, cache_key
from .features import NodeFeatures
from .hops import hop_distances
from .identity import mesh_id, node_id, segment_ids
from .lightfield import light_field_descriptors, quantile_signatures
from .measures import Measures, measure, segment_geodesics
from .multilayer import MultiLayerGraph, build_multilayer_graph
from .parameters import MatchParameters
from .result import ShapeRecord
from .segmentation import SegmentedShape, SegmentGraph
from .segmentgraph import build_segment_graph

CACHE_VERSION = "describe/3"


@dataclass(frozen=True, slots=True, eq=False)
class DescribedShape:
    """A shape with everything that does not depend on its partner.

    `hops` (k, k) uint8 distances in the multi-layer graph; `descriptors` (k, light fields, 10, 45) float32;
    `signatures` (k, 450) float32; `segment_ids` the s content hashes; `parameters` those that it was described with;
    `notes` what was assumed or capped, in sentences. `features` are all other descriptors, made when first asked for,
    with what `kept` remembers of the shape and `cache` of earlier runs.
    """

    shape: SegmentedShape
    record: ShapeRecord
    segment_ids: tuple[str, ...]
    graph: SegmentGraph
    layers: MultiLayerGraph
    hops: np.ndarray
    measures: Measures
    descriptors: np.ndarray
    signatures: np.ndarray
    parameters: MatchParameters
    notes: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    cache: Cache | None = None
    kept: dict[str, Any] = field(default_factory=dict)
    _memory: dict[str, NodeFeatures] = field(default_factory=dict, init=False)  # of these very nodes: not for `replace`

    @property
    def features(self) -> NodeFeatures:
        """Descriptors (k, dims) float32 by name; see `features.FEATURES`."""
        if "features" not in self._memory:
            self._memory["features"] = NodeFeatures(
                self.shape, self.segment_ids, self.graph, self.layers.members, seed=self.parameters.seed,
                cache=self.cache, kept=self.kept)  # fmt: skip
        return self._memory["features"]


class Stopwatch:
    """Seconds spent in each named step."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, step: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[step] = self.seconds.get(step, 0.0) + time.perf_counter() - start


def describe(
    shape: SegmentedShape, parameters: MatchParameters, *, progress: Progress = silent, cache: Cache | None = None
) -> DescribedShape:
    """Graphs, measures and descriptors of one shape.

    Raises `BadInput` where the shape has a single segment (there is nothing to match part by part) or too many.
    """
    if shape.segmentation.count < 2:
        raise BadInput(
            f"{shape.mesh.name} has one single segment; give labels with at least two (a .seg file, one a face)."
        )
    if shape.segmentation.count > parameters.most_segments:
        raise BadInput(
            f"{shape.mesh.name} has {shape.segmentation.count:,} segments, more than most_segments = "
            f"{parameters.most_segments:,}; give labels of parts, or raise most_segments."
        )
    watch = Stopwatch()
    progress(0.0, f"segment graph of {shape.mesh.name}")
    ids = segment_ids(shape.mesh, shape.segmentation)
    with watch("segment graph"):
        graph, notes = _segment_graph(shape, ids, parameters, cache)
    with watch("multi-layer graph"):
        weights = graph.adjacency().astype(np.float64)
        layers = build_multilayer_graph(graph, parameters, weights, progress=share(progress, 0.05, 0.1))
        hops = hop_distances(len(layers.members), layers.edges)
    progress(0.1, f"geodesic distances of {shape.mesh.name}")
    with watch("geodesics"):
        measures = measure(shape, graph, layers.members, _between(shape, ids, parameters, cache))
    with watch("descriptors"):
        descriptors = _descriptors(shape, ids, layers.members, parameters, progress, cache)
    record = ShapeRecord(
        shape.file, mesh_id(shape.mesh), shape.segmentation.names, len(shape.mesh.faces), node_id(ids))  # fmt: skip
    notes = (*shape.notes, *notes, *([f"{shape.mesh.name}: {layers.capped}"] if layers.capped else []))
    return DescribedShape(
        shape, record, ids, graph, layers, hops, measures, descriptors,
        quantile_signatures(descriptors), parameters, notes, watch.seconds, cache)  # fmt: skip


def _kept(
    cache: Cache | None, make: Callable[[], dict[str, np.ndarray]], word: str, *key: object
) -> dict[str, np.ndarray]:
    """What `make` returns, from the cache where there is one; segment hashes in the key stand for mesh and labels."""
    return make() if cache is None else cache.arrays(cache_key(word, *key), make)


def _segment_graph(
    shape: SegmentedShape, ids: tuple[str, ...], p: MatchParameters, cache: Cache | None
) -> tuple[SegmentGraph, tuple[str, ...]]:
    def make() -> dict[str, np.ndarray]:
        graph, notes = build_segment_graph(
            shape, adjacency=p.adjacency, touch_distance=p.touch_distance, touch_samples=p.touch_samples, seed=p.seed)  # fmt: skip
        return {"area": graph.area, "volume": graph.volume, "edges": graph.edges, "kind": graph.kind,
                "notes": np.array(notes, dtype=str)}  # fmt: skip

    options = (shape.mesh.name, shape.segmentation.names, p.adjacency, p.touch_distance, p.touch_samples, p.seed)
    found = _kept(cache, make, "segments/1", ids, options)
    return SegmentGraph(*(found[name] for name in ("area", "volume", "edges", "kind"))), tuple(found["notes"].tolist())


def _between(shape: SegmentedShape, ids: tuple[str, ...], p: MatchParameters, cache: Cache | None) -> np.ndarray:
    def make() -> dict[str, np.ndarray]:
        return {"between": segment_geodesics(shape, points=p.geodesic_points, seed=p.seed)}

    return _kept(cache, make, "geodesics/1", ids, p.geodesic_points, p.seed)["between"]


def _descriptors(
    shape: SegmentedShape, ids: tuple[str, ...], members: np.ndarray, p: MatchParameters, progress: Progress,
    cache: Cache | None,
) -> np.ndarray:  # fmt: skip
    def make() -> dict[str, np.ndarray]:
        return {"descriptors": light_fields_of(shape, members, p, share(progress, 0.2, 1.0))}

    options = (p.light_fields, p.resolution, p.seed, p.own_scale)
    return _kept(cache, make, CACHE_VERSION, ids, np.packbits(members, axis=1), *options)["descriptors"]


def light_fields_of(
    shape: SegmentedShape, members: np.ndarray, p: MatchParameters, progress: Progress = silent
) -> np.ndarray:
    """Light field descriptors of the unions `members` (k, s) under the parameters, (k, light fields, 10, 45) float32."""
    return light_field_descriptors(
        shape.mesh, shape.segmentation.labels, members, light_fields=p.light_fields, resolution=p.resolution,
        seed=p.seed, own_scale=p.own_scale, progress=progress)  # fmt: skip
