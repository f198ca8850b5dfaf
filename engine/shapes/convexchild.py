"""The process in which CoACD runs: `python convexchild.py IN.npz OUT.npz PARENT`, alone, so that it can be stopped.

It reads `vertices` (n, 3), `faces` (m, 3), `threshold` and `seed`, and writes the planes (p, 4) of all convex hulls,
outward normal and offset, and the number of the hull (p,) that each belongs to. It imports nothing of Concord.
"""

import os
import sys
import threading
import time
from typing import Any

import numpy as np

# A coarse search: the hulls are joined and their borders straightened afterwards.
SEARCH: dict[str, Any] = {"preprocess_resolution": 30, "resolution": 1000, "mcts_nodes": 10, "mcts_iterations": 30,
                          "mcts_max_depth": 1, "merge": False}  # fmt: skip


def end_with(parent: int) -> None:
    """Stop this process when the one that started it is gone, however it went."""
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def main(source: str, target: str, parent: str) -> None:
    """Decompose the mesh in one file and write the hulls to the other, as long as the parent process lives."""
    import coacd

    threading.Thread(target=end_with, args=(int(parent),), daemon=True).start()
    coacd.set_log_level("off")
    with np.load(source, allow_pickle=False) as given:
        mesh = coacd.Mesh(given["vertices"], given["faces"])
        threshold, seed = float(given["threshold"]), int(given["seed"])
    parts = coacd.run_coacd(mesh, threshold=threshold, seed=seed, **SEARCH)
    planes = [planes_of(np.asarray(vertices), np.asarray(faces)) for vertices, faces in parts]
    with open(target + ".part", "wb") as handle:
        np.savez(handle, planes=np.concatenate(planes), hull=np.repeat(np.arange(len(planes)), [len(p) for p in planes]))
    os.replace(target + ".part", target)


def planes_of(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Outward planes (p, 4) of a convex hull: a point x lies inside where n·x <= d for all of them."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    normal, a = normal[length > 1e-14] / length[length > 1e-14, None], a[length > 1e-14]
    offset = np.einsum("ij,ij->i", normal, a)
    side = np.sign(offset - normal @ vertices.mean(axis=0))
    side[side == 0] = 1.0
    return np.unique(np.round(np.c_[normal * side[:, None], offset * side], 12), axis=0)


if __name__ == "__main__":
    main(*sys.argv[1:4])
