"""Light field descriptors (Chen, Tian, Shen & Ouhyoung 2003) of segments and of unions of segments.

A light field is ten orthographic silhouettes, one for each axis of a dodecahedron; a descriptor is several light
fields under fixed random rotations. The distance of two shapes is the least mean distance of their views over all
pairs of light fields and the 60 rotations of the dodecahedron, which permute its axes. Silhouettes of segments are
drawn once and combined by OR for every union.

This module stands alone: `light_field_descriptors` and `light_field_distances` need a mesh, labels and memberships.
"""

from functools import cache

import numpy as np
from numba import njit, prange

from ..progress import Progress, silent
from .mesh import Mesh
from .moments import COEFFICIENTS, GRID, centred_disc, disc_moments, tables
from .silhouettes import draw_segments, draw_triangles, filled_box

VIEWS = 10


@cache
def dodecahedron_axes() -> np.ndarray:
    """The ten axes through opposite vertices of a dodecahedron, (10, 3) unit vectors."""
    golden = (1 + 5**0.5) / 2
    corners = [(1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (1.0, -1.0, 1.0), (-1.0, 1.0, 1.0)]
    for sign in (1, -1):
        corners += [(1 / golden, 0.0, sign * golden), (sign * golden, 1 / golden, 0.0), (0.0, golden, sign / golden)]
    return np.array(corners) / 3**0.5


@cache
def axis_permutations() -> np.ndarray:
    """How the 60 rotations of the dodecahedron permute its ten axes, (60, 10) int64; the identity comes first."""
    from scipy.spatial.transform import Rotation

    axes = dodecahedron_axes()
    cosine = np.abs(np.einsum("ad,gde,be->gab", axes, Rotation.create_group("I").as_matrix(), axes))
    permutations = cosine.argmax(axis=2)
    return permutations[np.lexsort(permutations.T[::-1])]


def view_frames(light_fields: int, seed: int) -> np.ndarray:
    """Image axes of all views, (light_fields * 10, 2, 3): the two rows span the plane that a view projects to."""
    from scipy.spatial.transform import Rotation

    axes = dodecahedron_axes()
    aside = np.where(np.abs(axes[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    u = np.cross(axes, aside)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    plane = np.stack([u, np.cross(axes, u)], axis=1)
    turns = Rotation.random(light_fields, rng=np.random.default_rng(seed)).as_matrix()
    return np.einsum("lde,vke->lvkd", turns, plane).reshape(-1, 2, 3)


def light_field_descriptors(
    mesh: Mesh,
    labels: np.ndarray,
    members: np.ndarray,
    *,
    light_fields: int,
    resolution: int,
    seed: int,
    own_scale: float = 0.25,
    progress: Progress = silent,
) -> np.ndarray:
    """Descriptors of unions of segments.

    Parameters
    ----------
    labels
        Segment of each face, (m,) int64 in 0..s-1.
    members
        (k, s) bool: the segments that each union holds, at least one.
    light_fields, resolution, seed
        Number of rotated light fields (1..10), side of a silhouette in pixels (a multiple of 8), seed of the rotations.
    own_scale
        Unions below this share of the shape's radius, and single segments, are drawn at their own scale.

    Returns
    -------
    (k, light_fields, 10, 45) float32: 35 Zernike and 10 Fourier magnitudes of each view.
    """
    frames = view_frames(light_fields, seed)
    order = np.argsort(labels, kind="stable")
    used = np.asarray(members.any(axis=0))
    order = order[used[labels[order]]]  # segments of no union need not be drawn
    bounds = np.searchsorted(labels[order], np.arange(members.shape[1] + 1))
    low, high = _segment_boxes(mesh, labels, members.shape[1])
    centre, radius = _frames_of_unions(mesh, labels, members, low, high)
    whole_centre, whole_radius = _whole_frame(mesh)
    own = (radius < own_scale * whole_radius) | (members.sum(axis=1) == 1)
    segment, start = _rows(members)
    out = np.zeros((len(frames), len(members), COEFFICIENTS), dtype=np.float32)
    for first in range(0, len(frames), VIEWS):
        part = slice(first, first + VIEWS)
        _describe_views(
            mesh.vertices, mesh.faces, frames[part], order, bounds, whole_centre, whole_radius, segment, start, own,
            centre, radius, resolution, *tables(), out[part])  # fmt: skip
        progress((first + VIEWS) / len(frames), f"silhouettes of {mesh.name}")
    shape = (light_fields, VIEWS, len(members), COEFFICIENTS)
    return np.ascontiguousarray(out.reshape(shape).transpose(2, 0, 1, 3))


def _rows(members: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The segments of all unions one after the other, and where each union starts (k + 1,)."""
    return np.nonzero(members)[1], np.concatenate([[0], np.cumsum(members.sum(axis=1))])


def _segment_boxes(mesh: Mesh, labels: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    corners = mesh.vertices[mesh.faces]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, labels, corners.min(axis=1))
    np.maximum.at(high, labels, corners.max(axis=1))
    return low, high


def _frames_of_unions(
    mesh: Mesh, labels: np.ndarray, members: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centre (k, 3) of the bounding box of each union, and a radius (k,) about it that holds all of the union."""
    most = np.where(members[:, :, None], high, -np.inf).max(axis=1)
    least = np.where(members[:, :, None], low, np.inf).min(axis=1)
    return (most + least) / 2, np.linalg.norm(most - least, axis=1) / 2


def _whole_frame(mesh: Mesh) -> tuple[np.ndarray, float]:
    used = mesh.vertices[np.unique(mesh.faces)]
    centre = (used.max(axis=0) + used.min(axis=0)) / 2
    return centre, float(np.linalg.norm(used - centre, axis=1).max())


@njit(cache=True, nogil=True)
def _project(vertices, frame, centre, radius, side, xy):  # type: ignore[no-untyped-def]
    """Orthographic projection to pixels, `centre` to the middle of the image and `radius` just inside its border."""
    scale = (side / 2 - 1) / max(radius, 1e-300)
    for i in range(len(vertices)):
        for k in range(2):
            total = 0.0
            for d in range(3):
                total += frame[k, d] * (vertices[i, d] - centre[d])
            xy[i, k] = side / 2 + scale * total


@njit(cache=True, nogil=True)
def _project_faces(vertices, faces, rows, frame, centre, radius, side, xy):  # type: ignore[no-untyped-def]
    scale = (side / 2 - 1) / max(radius, 1e-300)
    for r in rows:
        for c in range(3):
            i = faces[r, c]
            for k in range(2):
                total = 0.0
                for d in range(3):
                    total += frame[k, d] * (vertices[i, d] - centre[d])
                xy[i, k] = side / 2 + scale * total


@njit(cache=True, nogil=True, parallel=True)
def _describe_views(  # type: ignore[no-untyped-def]
    vertices, faces, frames, order, bounds, whole_centre, whole_radius, segment, start, own, centre, radius, side,
    zernike, rays, fourier, out,
):  # fmt: skip
    """Write the coefficients of all unions (k) in each view to `out` (views, k, 45)."""
    segments = len(bounds) - 1
    for v in prange(len(frames)):
        frame = frames[v]
        xy = np.empty((len(vertices), 2))
        images = np.empty((segments, side, side // 8), dtype=np.uint8)
        image = np.empty((side, side // 8), dtype=np.uint8)
        disc = np.empty((GRID, GRID), dtype=np.uint8)
        boxes = np.empty((segments, 4), dtype=np.int64)
        _project(vertices, frame, whole_centre, whole_radius, side, xy)
        draw_segments(xy, faces, order, bounds, images)
        for i in range(segments):
            box = filled_box(images[i])
            for k in range(4):
                boxes[i, k] = box[k]
        for node in range(len(own)):
            image[:] = 0
            top, bottom, left, right = side, -1, side, -1
            for p in range(start[node], start[node + 1]):
                i = segment[p]
                if own[node]:
                    rows = order[bounds[i] : bounds[i + 1]]
                    _project_faces(vertices, faces, rows, frame, centre[node], radius[node], side, xy)
                    draw_triangles(xy, faces, rows, image)
                    continue
                for y in range(boxes[i, 0], boxes[i, 1] + 1):
                    for k in range(boxes[i, 2], boxes[i, 3] + 1):
                        image[y, k] |= images[i, y, k]
                if boxes[i, 1] >= 0:
                    top, bottom = min(top, boxes[i, 0]), max(bottom, boxes[i, 1])
                    left, right = min(left, boxes[i, 2]), max(right, boxes[i, 3])
            box = filled_box(image) if own[node] else (top, bottom, left, right)
            if centred_disc(image, box, disc):
                disc_moments(disc, zernike, rays, fourier, out[v, node])


def quantile_signatures(descriptors: np.ndarray) -> np.ndarray:
    """A fast descriptor without permutations: each coefficient's quantiles over all views, (k, 450) float32.

    For single light fields the L1 distance of two signatures, per view, never exceeds the exact distance (sorting each
    coefficient over the views is the best any permutation could do); for several it comes close from below.
    """
    count, fields = descriptors.shape[:2]
    values = np.sort(descriptors.reshape(count, fields * VIEWS, COEFFICIENTS), axis=1)
    return values.reshape(count, VIEWS, fields, COEFFICIENTS).mean(axis=2).reshape(count, -1)


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def signature_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances (n, m) float32 of quantile signatures (n, 450) and (m, 450): L1 over the views, mean of ten."""
    out = np.empty((len(a), len(b)), dtype=np.float32)
    for i in prange(len(a)):
        for j in range(len(b)):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += abs(a[i, k] - b[j, k])
            out[i, j] = total / VIEWS
    return out


def light_field_distances(a: np.ndarray, b: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Light field distance of each pair (p, 2) of rows of `a` (n, l, 10, 45) and `b` (m, l', 10, 45), (p,) float64.

    View distance: L1 of the 45 coefficients. Shape distance: the least mean over the ten views, over all pairs of
    light fields and the 60 rotations. Symmetric: swapping `a` and `b` gives the same numbers.
    """
    return _pair_distances(_plain(a), _plain(b), _plain(pairs), axis_permutations())


def _plain(values: np.ndarray) -> np.ndarray:
    """The values in C order and read-only: one compiled loop for all, since others add up in another order."""
    view = np.ascontiguousarray(values).view()
    view.flags.writeable = False
    return view


@njit(cache=True, nogil=True, parallel=True, fastmath=True)
def _pair_distances(a, b, pairs, permutations):  # type: ignore[no-untyped-def]
    out = np.empty(len(pairs))
    for p in prange(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        views = np.empty((VIEWS, VIEWS), dtype=np.float32)
        best = np.float32(np.inf)
        for f in range(a.shape[1]):
            for g in range(b.shape[1]):
                for v in range(VIEWS):
                    for w in range(VIEWS):
                        total = np.float32(0)
                        for c in range(COEFFICIENTS):
                            total += abs(a[i, f, v, c] - b[j, g, w, c])
                        views[v, w] = total
                for r in range(len(permutations)):
                    total = np.float32(0)
                    for v in range(VIEWS):
                        total += views[v, permutations[r, v]]
                    best = min(best, total)
        out[p] = best / VIEWS
    return out
