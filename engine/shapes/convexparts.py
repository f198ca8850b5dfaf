"""Nearly convex parts by CoACD (Wei, Liu, Ling & Su 2022), carried from its solid hulls back to the faces of a mesh."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from ..errors import BadInput, ConcordError
from ..progress import Progress, share, silent
from . import convexchild
from .facegraph import FaceGraph
from .mesh import Mesh
from .regions import tidied

LEAST_CONCAVITY = 0.02
MOST_FACES = 20_000  # finer surfaces are simplified before they are decomposed
USUAL_SECONDS = 12.0  # only for the progress, which CoACD does not tell
POLL = 0.05
Hulls = list[np.ndarray]


def convex_regions(
    mesh: Mesh, graph: FaceGraph, *, count: int, concavity: float, seed: int, progress: Progress = silent
) -> np.ndarray:
    """Label (m,) of each face: the hull of CoACD's decomposition that holds it, or the nearest.

    Where the decomposition has fewer than `count` parts, it is made anew with half the concavity, down to 0.02; what
    is still missing is for the caller to cut. Raises `BadInput` where CoACD cannot decompose the mesh, and whatever
    `progress` raises, after which no process is left.
    """
    limit, start = concavity, 0.0
    while True:
        part = share(progress, start, start + (0.95 - start) * (0.8 if limit / 2 < LEAST_CONCAVITY else 0.5))
        labels = tidied(graph, nearest_hull(graph.centre, _hulls(centred(mesh), mesh, limit, seed, part)))
        if labels.max() + 1 >= min(count, graph.faces) or limit <= LEAST_CONCAVITY:
            return labels
        limit, start = max(LEAST_CONCAVITY, limit / 2), start + (0.95 - start) * 0.5


def centred(mesh: Mesh) -> np.ndarray:
    """Vertices (n, 3) in the coordinates of the graph of faces: about their mean, the diagonal 1."""
    used = mesh.vertices[mesh.faces.ravel()]
    points = (mesh.vertices - used.mean(axis=0)) / np.linalg.norm(np.ptp(used, axis=0))
    points[np.setdiff1d(np.arange(len(points)), mesh.faces)] = 0.0
    return points


def nearest_hull(points: np.ndarray, hulls: Hulls) -> np.ndarray:
    """The hull (q,) that each point (q, 3) lies in the deepest, or the nearest; `hulls` are planes (p, 4) each."""
    depth = np.full(len(points), np.inf)
    found = np.zeros(len(points), np.int64)
    for k, planes in enumerate(hulls):
        outside = np.concatenate([(rows @ planes[:, :3].T - planes[:, 3]).max(axis=1)
                                  for rows in np.array_split(points, len(points) // 20_000 + 1)])  # fmt: skip
        nearer = outside < depth
        depth[nearer], found[nearer] = outside[nearer], k
    return found


def simplified(points: np.ndarray, faces: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The surface itself, or where it has more than `most` faces, with its vertices gathered in the boxes of a grid."""
    if len(faces) <= most:
        return points, faces
    corners = points[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    box = np.unique(np.floor(points / np.sqrt(2 * area / most)), axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(box)
    middle = np.stack([np.bincount(box, points[:, k]) / count for k in range(3)], axis=1)
    gathered = box[faces]
    real = (gathered != np.roll(gathered, 1, axis=1)).all(axis=1)
    return middle, gathered[real]


def _hulls(points: np.ndarray, mesh: Mesh, threshold: float, seed: int, progress: Progress) -> Hulls:
    """The hulls that a child process finds."""
    with tempfile.TemporaryDirectory(prefix="concord-") as folder:
        source, target = Path(folder) / "mesh.npz", Path(folder) / "hulls.npz"
        vertices, faces = simplified(points, mesh.faces, MOST_FACES)
        np.savez(source, vertices=vertices, faces=faces.astype(np.int32), threshold=threshold, seed=seed)
        _run([sys.executable, convexchild.__file__, str(source), str(target), str(os.getpid())], folder, mesh.name, progress)
        try:
            with np.load(target, allow_pickle=False) as found:
                planes, hull = found["planes"], found["hull"]
        except (OSError, ValueError, KeyError):
            raise BadInput(_sentence(mesh.name)) from None
    if not len(planes):
        raise BadInput(_sentence(mesh.name))
    return [planes[hull == k] for k in range(int(hull.max()) + 1)]


def _run(command: list[str], folder: str, name: str, progress: Progress) -> None:
    """Run the child to its end in silence; it is killed when `progress` raises."""
    env = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONSAFEPATH": "1"}
    try:
        child = subprocess.Popen(command, cwd=folder, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL)  # fmt: skip
    except OSError as error:
        raise ConcordError(f"The convex decomposition cannot be started: {error.strerror}.") from None
    began = time.monotonic()
    try:
        while child.poll() is None:
            past = (time.monotonic() - began) / USUAL_SECONDS
            progress(past / (1 + past), "cutting into convex parts")
            time.sleep(POLL)
    finally:
        if child.poll() is None:
            child.kill()
        child.wait()
    if child.returncode != 0:
        raise BadInput(_sentence(name))


def _sentence(name: str) -> str:
    return f"{name} could not be cut into convex parts (CoACD ended without a result); segment it by patches instead."
