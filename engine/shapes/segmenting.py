"""Segments for a mesh that has none: how they are made is one set of parameters, any number of them is a slider."""

from collections.abc import Callable

import numpy as np

from ..progress import Progress, share, silent
from ..store import Cache, cache_key
from .convexparts import centred, convex_regions
from .facegraph import FaceGraph, coarsened, face_graph
from .mesh import Mesh
from .patches import patches_of
from .regions import joined, joining_order, numbered, tidied, whole
from .segmentation import Segmentation
from .segmentationparameters import CONVEX, DEFAULT, PATCHES, SegmentationParameters

_WORD = "segments-2"
FINE = (100, 200, 400)  # patches that parts are joined of: the first number of at least twice the segments
HULLS = (20, 40, 80, 200)  # parts that CoACD is asked for: the first number of at least the segments
MOST_CELLS = 40_000
_SPLIT_SEED = 1


def auto_segment(
    mesh: Mesh, parameters: SegmentationParameters = DEFAULT, *, progress: Progress = silent, cache: Cache | None = None
) -> Segmentation:
    """Segments of a mesh, each connected where the surface is, numbered by where they lie in the order of the faces.

    What does not depend on the number of segments goes through the cache, so that another number costs milliseconds.
    Raises `BadInput` where CoACD fails.
    """
    graph = face_graph(mesh)
    keep = cache.arrays if cache is not None else _now
    cut = _patches if parameters.method == PATCHES else _parts
    labels = cut(mesh, graph, parameters, keep, progress)
    labels = _in_order(_filled(graph, tidied(graph, labels), parameters))
    progress(1.0, "segmented")
    return Segmentation(labels, tuple(range(int(labels.max()) + 1)))


def origin_words(mesh: Mesh, segmentation: Segmentation, parameters: SegmentationParameters) -> str:
    """One sentence that says how a mesh came by its segments."""
    count = "1 segment" if segmentation.count == 1 else f"{segmentation.count} segments"
    return f"{mesh.name} has no labels: it was cut into {count} automatically ({parameters.method})."


def segment_file_text(labels: np.ndarray, names: tuple[int | str, ...] | None = None) -> str:
    """What a `.seg` file holds: one integer a face, in face order; the names of the segments where they are numbers."""
    numbers = names is not None and all(isinstance(name, int) for name in names)
    values = np.array(names)[labels] if numbers else labels
    return "\n".join(map(str, values.tolist())) + "\n"


def _now(_key: str, make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return make()


def surface_patches(graph: FaceGraph, *, count: int, seed: int, crease: float, progress: Progress = silent) -> np.ndarray:
    """Geodesic patches (m,) of a graph of faces, of cells of it where it is very fine."""
    if graph.faces <= MOST_CELLS:
        return patches_of(graph, count=count, seed=seed, crease=crease, progress=progress)
    cell, coarse = coarsened(graph, MOST_CELLS)
    return whole(graph, patches_of(coarse, count=count, seed=seed, crease=crease, progress=progress)[cell])


def _patches(
    mesh: Mesh, graph: FaceGraph, p: SegmentationParameters, keep: Callable, progress: Progress
) -> np.ndarray:
    """Plain patches."""
    key = cache_key(_WORD, PATCHES, mesh.vertices, mesh.faces, p.seed, p.crease, p.segments)
    return keep(key, lambda: {"labels": surface_patches(
        graph, count=p.segments, seed=p.seed, crease=p.crease, progress=progress)})["labels"]  # fmt: skip


def _parts(mesh: Mesh, graph: FaceGraph, p: SegmentationParameters, keep: Callable, progress: Progress) -> np.ndarray:
    """Regions in greater number than wanted, joined to nearly convex ones."""
    convex = p.method == CONVEX
    fine = next(n for n in (HULLS if convex else FINE) if n >= (1 if convex else 2) * p.segments)
    numbers = (p.concavity if convex else p.crease, fine)

    def make() -> dict[str, np.ndarray]:
        early = share(progress, 0.0, 0.8)
        if convex:
            labels = convex_regions(mesh, graph, count=fine, concavity=p.concavity, seed=p.seed, progress=early)
        else:
            labels = surface_patches(graph, count=fine, seed=p.seed, crease=p.crease, progress=early)
        labels = numbered(labels)
        steps = joining_order(graph, centred(mesh)[mesh.faces], labels, progress=share(progress, 0.8, 1.0))
        return {"labels": labels, "steps": steps}

    found = keep(cache_key(_WORD, p.method, mesh.vertices, mesh.faces, p.seed, *numbers), make)
    return joined(found["labels"], found["steps"], p.segments)


def _filled(graph: FaceGraph, labels: np.ndarray, p: SegmentationParameters) -> np.ndarray:
    """Labels of which the largest are halved until there are as many as were asked for."""
    labels = labels.copy()
    stuck = np.zeros(p.segments, bool)
    while (count := int(labels.max()) + 1) < p.segments:
        size = np.where(stuck[:count], -1.0, np.bincount(labels, graph.area))
        faces = np.flatnonzero(labels == int(np.argmax(size)))
        if size.max() < 0:
            break
        if len(faces) < 2:
            stuck[int(np.argmax(size))] = True
            continue
        half = surface_patches(graph.restricted(faces), count=2, seed=_SPLIT_SEED, crease=p.crease)
        labels[faces[half == 1]] = count
    return labels


def _in_order(labels: np.ndarray) -> np.ndarray:
    """Labels numbered by their first face."""
    first = np.unique(labels, return_index=True)[1]
    number = np.empty(len(first), np.int64)
    number[np.argsort(first)] = np.arange(len(first))
    return number[labels]
