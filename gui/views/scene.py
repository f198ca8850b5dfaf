"""What is shown of a shape and from where, in numbers only: no Qt and no VTK here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from engine.shapes.multilayer import MultiLayerGraph
from engine.shapes.result import Match, MatchResult
from engine.shapes.segmentation import SegmentedShape

from .upright import up_axis, upright

STATES = ("undecided", "correct", "wrong", "tie")


@dataclass(frozen=True, slots=True)
class Link:
    """A match as it is drawn: the segments that it joins on either side, and what was judged of it.

    `state` is one of `STATES`, `score` lies in [0, 1]; a `merged` link is drawn as a polygon, any other as a line.
    One of little `support` is drawn fainter, a `pinned` one thicker and with the head of a pin.
    """

    id: str
    source: tuple[int, ...]
    target: tuple[int, ...]
    state: str = "undecided"
    score: float = 1.0
    merged: bool = False
    support: float = 1.0
    pinned: bool = False


def link_of(match: Match, state: str = "undecided", support: float = 1.0) -> Link:
    """A match as a link, judged as `state` says; `support` in [0, 1] is that by other shapes (1 where it is unknown)."""
    merged = len(match.source) + len(match.target) > 2
    return Link(match.id, match.source, match.target, state, match.score, merged, support, match.pinned)


def links_of(result: MatchResult, states: Mapping[str, str] | None = None) -> list[Link]:
    """The matches of a result as links, the best last so that it lies on top; `states` gives judgements by id."""
    judged = states or {}
    return [link_of(m, judged.get(m.id, "undecided")) for m in reversed(result.matches())]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A shape made ready to be drawn, in the unit box around the origin.

    `points` (n, 3), y up, and `faces` (m, 3); `labels` (m,) in 0..s-1; `area` (m,) and `centroid` (m, 3) of the faces;
    `spots` (s, k, 3) surface points of each segment where a link may end, the anchor first; `edges` (e, 2) vertices
    and `sides` (e, 2) the two faces of each inner edge; `samples` (q, 3) surface points spread by area, with the
    segment of each in `sample_labels` (q,).
    """

    name: str
    points: np.ndarray
    faces: np.ndarray
    labels: np.ndarray
    names: tuple[int | str, ...]
    area: np.ndarray
    centroid: np.ndarray
    spots: np.ndarray
    edges: np.ndarray
    sides: np.ndarray
    samples: np.ndarray
    sample_labels: np.ndarray

    @property
    def count(self) -> int:
        """Number of segments."""
        return len(self.names)


def prepare(shape: SegmentedShape) -> Scene:
    """All that drawing needs of a shape, turned upright; about 0.1 s for 50,000 faces, and safe to call in a thread."""
    faces, labels = shape.mesh.faces, shape.segmentation.labels
    points = unit_box(shape.mesh.vertices, faces)
    chosen = spread_samples(face_areas(points, faces), 12_000)
    points = upright(points, up_axis(inside(points[faces[chosen]])))
    centroid, area = points[faces].mean(axis=1), face_areas(points, faces)
    edges, sides = inner_edges(faces)
    return Scene(
        name=shape.mesh.name, points=points, faces=faces, labels=labels, names=shape.segmentation.names, area=area,
        centroid=centroid, spots=spots(centroid, area, labels, shape.segmentation.count), edges=edges, sides=sides,
        samples=inside(points[faces[chosen]]), sample_labels=labels[chosen],
    )  # fmt: skip


def face_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area (m,) of each face."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def unit_box(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertices (n, 3) moved and scaled so that those in use fill the box [-1/2, 1/2] along its longest side.

    Vertices that no face uses may be anything, even NaN, and are put at the origin.
    """
    rows = np.unique(faces)
    low, high = vertices[rows].min(axis=0), vertices[rows].max(axis=0)
    points = np.zeros(vertices.shape)
    points[rows] = (vertices[rows] - (low + high) / 2) / (high - low).max()
    return points


def anchors(centroid: np.ndarray, area: np.ndarray, labels: np.ndarray, count: int) -> np.ndarray:
    """For each segment the face centre nearest to its area-weighted centre, (s, 3): it always lies on the surface."""
    weight = area + 1e-12
    total = np.bincount(labels, weight, count)
    middle = np.stack([np.bincount(labels, weight * centroid[:, k], count) / total for k in range(3)], axis=1)
    distance = np.linalg.norm(centroid - middle[labels], axis=1)
    order = np.lexsort((distance, labels))
    first = np.searchsorted(labels[order], np.arange(count))
    return centroid[order[first]]


def spots(centroid: np.ndarray, area: np.ndarray, labels: np.ndarray, count: int, most: int = 12) -> np.ndarray:
    """Places (s, most, 3) on each segment where a link may end: the anchor and others."""
    order = np.argsort(labels, kind="stable")
    parts = np.split(order, np.cumsum(np.bincount(labels, minlength=count))[:-1])
    middle = anchors(centroid, area, labels, count)
    return np.array([_spread(a, centroid[p[:: len(p) // 400 + 1]], most) for a, p in zip(middle, parts, strict=True)])


def _spread(first: np.ndarray, points: np.ndarray, most: int) -> np.ndarray:
    """The first point and most - 1 others: far from each other, then moved to the middle of what is nearest to them."""
    chosen = [first]
    distance = np.linalg.norm(points - first, axis=1)
    for _ in range(most - 1):
        chosen.append(points[np.argmax(distance)])
        distance = np.minimum(distance, np.linalg.norm(points - chosen[-1], axis=1))
    nearest = np.argmin(np.linalg.norm(points[:, None] - np.array(chosen), axis=2), axis=1)
    centres = [points[nearest == k].mean(axis=0) if (nearest == k).any() else chosen[k] for k in range(1, most)]
    moved = points[np.argmin(np.linalg.norm(points[:, None] - np.array(centres), axis=2), axis=0)]
    return np.concatenate([first[None], moved])


def inner_edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (e, 2) that two faces share, and those faces (e, 2); where more than two meet, each consecutive pair."""
    ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    face = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, face = ends[order], face[order]
    same = (ends[1:] == ends[:-1]).all(axis=1)
    return ends[1:][same], np.stack([face[:-1][same], face[1:][same]], axis=1)


def borders(scene: Scene, group: np.ndarray) -> np.ndarray:
    """Edges (b, 2) between faces whose segments lie in different groups; `group` (s,) int, so that segments of one
    group show no border between them."""
    of_face = np.asarray(group)[scene.labels]
    return scene.edges[of_face[scene.sides[:, 0]] != of_face[scene.sides[:, 1]]]


def spread_samples(area: np.ndarray, count: int) -> np.ndarray:
    """Indices (count,) of faces, each about as often as its share of the area (systematic sampling)."""
    reach = np.cumsum(area + area.max() * 1e-9)
    return np.searchsorted(reach, (np.arange(count) + 0.5) * reach[-1] / count)


def inside(corners: np.ndarray) -> np.ndarray:
    """One point (q, 3) inside each triangle (q, 3, 3), spread evenly by a fixed low-discrepancy sequence."""
    steps = np.arange(1, len(corners) + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532]) % 1.0
    u, v = np.where(steps.sum(axis=1, keepdims=True) > 1, 1 - steps, steps).T
    return corners[:, 0] + u[:, None] * (corners[:, 1] - corners[:, 0]) + v[:, None] * (corners[:, 2] - corners[:, 0])


# --- colours ---------------------------------------------------------------------------------------------------------


def union_colours(base: np.ndarray, segments: Iterable[int], colour: np.ndarray, faded: np.ndarray) -> np.ndarray:
    """Colours (s, 3) uint8 in which the given segments have one colour and all others the faded one."""
    out = np.broadcast_to(np.asarray(faded, np.uint8), base.shape).copy()
    out[list(segments)] = colour
    return out


def layer_nodes(graph: MultiLayerGraph, layer: int, start: int = 0) -> np.ndarray:
    """For each segment the row of the node that shows it when walking through a layer, (s,) int64; -1 for none.

    Nodes of one layer overlap, so they are taken in their order, from row `start` of the layer on and around, each if
    its segments are still free.
    """
    shown = np.full(graph.members.shape[1], -1, np.int64)
    for node in np.roll(np.flatnonzero(graph.layer == layer), -start):
        if (shown[graph.members[node]] < 0).all():
            shown[graph.members[node]] = node
    return shown


def layer_colours(shown: np.ndarray, base: np.ndarray, faded: np.ndarray) -> np.ndarray:
    """Colours (s, 3) uint8 of a layer: each node in the colour of its first segment, segments of no node faded."""
    first = {int(node): int(np.argmax(shown == node)) for node in np.unique(shown) if node >= 0}
    return np.array([base[first[int(node)]] if node >= 0 else faded for node in shown], np.uint8).reshape(-1, 3)


def colour_groups(colours: np.ndarray) -> np.ndarray:
    """Number (s,) int64 of each segment's colour: equal colours are one group, and show no border between them."""
    return np.unique(np.asarray(colours, np.int64) @ np.array([65536, 256, 1]), return_inverse=True)[1].ravel()
