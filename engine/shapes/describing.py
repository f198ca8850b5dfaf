"""All that is slow about one shape: its graphs, measures and descriptors, kept on disk between runs."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from ..errors import BadInput
from ..progress import Progress, share, silent
from ..store import Cache, cache_key
from .hops import hop_distances
from .identity import mesh_id, node_id, segment_ids
from .lightfield import light_field_descriptors, quantile_signatures
from .measures import Measures, measure
from .multilayer import MultiLayerGraph, build_multilayer_graph
from .parameters import MatchParameters
from .result import ShapeRecord
from .segmentation import SegmentedShape, SegmentGraph
from .segmentgraph import build_segment_graph

CACHE_VERSION = "describe/2"


@dataclass(frozen=True, slots=True, eq=False)
class DescribedShape:
    """A shape with everything that does not depend on its partner.

    `hops` (k, k) uint8 distances in the multi-layer graph; `descriptors` (k, light fields, 10, 45) float32;
    `signatures` (k, 450) float32; `segment_ids` the s content hashes; `notes` what was assumed or capped, in sentences.
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
    notes: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)


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
    with watch("segment graph"):
        graph, notes = build_segment_graph(
            shape, adjacency=parameters.adjacency, touch_distance=parameters.touch_distance,
            touch_samples=parameters.touch_samples, seed=parameters.seed)  # fmt: skip
    with watch("multi-layer graph"):
        weights = graph.adjacency().astype(np.float64)
        layers = build_multilayer_graph(graph, parameters, weights, progress=share(progress, 0.05, 0.1))
        hops = hop_distances(len(layers.members), layers.edges)
    progress(0.1, f"geodesic distances of {shape.mesh.name}")
    with watch("geodesics"):
        measures = measure(shape, graph, layers.members, points=parameters.geodesic_points, seed=parameters.seed)
    with watch("descriptors"):
        descriptors = _descriptors(shape, layers.members, parameters, progress, cache)
    ids = segment_ids(shape.mesh, shape.segmentation)
    record = ShapeRecord(
        shape.file, mesh_id(shape.mesh), shape.segmentation.names, len(shape.mesh.faces), node_id(ids))  # fmt: skip
    notes = (*shape.notes, *notes, *([f"{shape.mesh.name}: {layers.capped}"] if layers.capped else []))
    return DescribedShape(
        shape, record, ids, graph, layers, hops, measures, descriptors,
        quantile_signatures(descriptors), notes, watch.seconds)  # fmt: skip


def _descriptors(
    shape: SegmentedShape, members: np.ndarray, p: MatchParameters, progress: Progress, cache: Cache | None
) -> np.ndarray:
    def make() -> dict[str, np.ndarray]:
        found = light_field_descriptors(
            shape.mesh, shape.segmentation.labels, members, light_fields=p.light_fields, resolution=p.resolution,
            seed=p.seed, own_scale=p.own_scale, progress=share(progress, 0.2, 1.0))  # fmt: skip
        return {"descriptors": found}

    if cache is None:
        return make()["descriptors"]
    key = cache_key(CACHE_VERSION, shape.mesh.vertices, shape.mesh.faces, shape.segmentation.labels,
                    np.packbits(members, axis=1), p.light_fields, p.resolution, p.seed, p.own_scale)  # fmt: skip
    return cache.arrays(key, make)["descriptors"]


