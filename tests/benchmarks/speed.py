"""How long matching takes, by step, and how the fast loops compare with plain ones run beside them.

    python tests/benchmarks/speed.py [--quick]

Prints, for generated pairs of about 14, 20 and 30 segments, the seconds of each step with an empty cache (cold) and
with a filled one (warm); the time of a re-run (affinity, pruning, voting) at 200, 1000 and 3000 nodes, without and with
matches that people have pinned or forbidden; descriptors and distances a second; and ratios against plain
implementations of the same equations. Best of three.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from engine.shapes.agreement import affinity_degrees, affinity_table, isometry, overlap_agreement, overlap_scores
from engine.shapes.families import make_pair
from engine.shapes.guided import with_wishes
from engine.shapes.hops import hop_distances
from engine.shapes.lightfield import axis_permutations, light_field_descriptors, light_field_distances
from engine.shapes.matching import describe, match_shapes, propose, rematch
from engine.shapes.parameters import MatchParameters, preset
from engine.shapes.proposing import Proposals
from engine.shapes.wishes import NO_WISHES, Wishes
from engine.store import Cache
from engine.warm import main as warm_up


def best(action: Callable[[], object], times: int = 3) -> float:
    """Shortest of a few runs, in seconds."""
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return min(taken)


def steps() -> None:
    """Seconds by step, cold and warm."""
    for segments in (14, 20, 30):
        pair = make_pair("animals", 7, segments=(segments, segments))
        with tempfile.TemporaryDirectory() as folder:
            for state in ("cold", "warm"):
                start = time.perf_counter()
                result = match_shapes(pair.source, pair.target, preset("top-down"), cache=Cache(folder))
                total = time.perf_counter() - start
                parts = ", ".join(f"{step} {value:.3f}" for step, value in result.seconds.items())
                print(f"{pair.source.segmentation.count:>3} + {pair.target.segmentation.count:<3} segments "
                      f"{result.source_nodes:>4} + {result.target_nodes:<4} nodes  {state}: {total:6.3f} s  ({parts})")  # fmt: skip


def reruns(sizes: Sequence[int] = (200, 1000, 3000)) -> None:
    """Milliseconds of everything that a slider can touch, and of a new wish: matching again in full, wishes put in anew."""
    for nodes in sizes:
        pair = make_pair("animals", 3, segments=(24, 24))
        p = preset("top-down").changed(node_cap=nodes)
        described = [describe(shape, p) for shape in (pair.source, pair.target)]
        proposals = propose(*described, p)
        count = tuple(len(d.layers.members) for d in described)
        for name in ("thesis-rigid", "thesis-nonrigid", "top-down"):
            free = rematch(proposals, preset(name)).matches()
            found = [(m.source, m.target) for m in free]
            strange = ((tuple(range(0, 20, 2)), tuple(range(1, 21, 2))),)  # unions that no graph holds
            wanted = {"": NO_WISHES, "10 pinned, 10 forbidden": Wishes(tuple(found[:10]), tuple(found[10:20])),
                      "a pin outside the graphs": Wishes(strange)}  # fmt: skip
            for words, wishes in wanted.items():
                seconds = best(partial(_again, proposals, preset(name), wishes), 5)
                print(f"re-run at {count[0]} x {count[1]} nodes, {name:<16}{words:<26}: {1000 * seconds:7.1f} ms")


def _again(proposals: Proposals, parameters: MatchParameters, wishes: Wishes) -> None:
    with_wishes.cache_clear()
    rematch(proposals, parameters, wishes=wishes)


def descriptors() -> None:
    """Descriptors and distances a second, and ratios against plain implementations."""
    pair = make_pair("animals", 3, segments=(20, 20))
    p = preset("top-down").changed(node_cap=1000)
    a, b = (describe(shape, p) for shape in (pair.source, pair.target))
    shape, members = pair.source, a.layers.members

    def composed() -> np.ndarray:
        return light_field_descriptors(shape.mesh, shape.segmentation.labels, members, light_fields=4, resolution=256, seed=0)

    seconds = best(composed)
    print(f"descriptors (4 light fields): {len(members) / seconds:8.0f} a second")
    some = np.flatnonzero(members.sum(axis=1) > 1)[:: max(1, len(members) // 40)][:40]

    def redrawn() -> None:
        for row in some:
            one = np.where(members[row][shape.segmentation.labels], 0, 1)
            light_field_descriptors(shape.mesh, one, np.array([[True, False]]), light_fields=4, resolution=256, seed=0)

    plain = best(redrawn, 1) / len(some)
    print(f"  composed from segments against drawn anew for each union: {plain / (seconds / len(members)):.1f} times faster")
    pairs = np.stack([np.arange(2000) % len(members), np.arange(2000) * 7 % len(b.layers.members)], axis=1)
    seconds = best(lambda: light_field_distances(a.descriptors, b.descriptors, pairs)) / len(pairs)
    plain = best(lambda: [plain_distance(a.descriptors[i], b.descriptors[j]) for i, j in pairs[:20]], 1) / 20
    print(f"light field distances: {1e6 * seconds:.1f} µs a pair, {plain / seconds:.0f} times faster than in numpy")


def plain_distance(a: np.ndarray, b: np.ndarray) -> float:
    """The light field distance by its definition."""
    views = np.abs(a[:, None, :, None] - b[None, :, None]).sum(axis=-1)
    rows = np.arange(views.shape[2])
    return min(views[..., rows, p].mean(axis=-1).min() for p in axis_permutations())


def consistency() -> None:
    """Ratios of the row sums and scores against whole matrices, and of the hop distances against SciPy."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import shortest_path

    pair = make_pair("animals", 3, segments=(20, 20))
    p = preset("top-down").changed(node_cap=400)
    a, b = (describe(shape, p) for shape in (pair.source, pair.target))
    proposals = propose(a, b, p)
    rows = np.random.default_rng(0).choice(len(proposals.pairs), 3000, replace=False)
    pairs, g = proposals.pairs[np.sort(rows)], np.ones(3000)

    def matrix() -> np.ndarray:
        s, t = a.hops[np.ix_(pairs[:, 0], pairs[:, 0])], b.hops[np.ix_(pairs[:, 1], pairs[:, 1])]
        m = isometry(s, t)
        return np.where((m >= 0.7) & (s <= 6) & (t <= 6), (m - 0.7) / 0.3, 0).sum(axis=1)

    table = affinity_table(6, 6, 0.7)
    fast, plain = best(lambda: affinity_degrees(pairs, g, a.hops, b.hops, table)), best(matrix, 1)
    print(f"affinity row sums, 3000 candidates: {1000 * fast:.1f} ms, {plain / fast:.0f} times faster than the matrix")

    def agreement() -> np.ndarray:
        r, ratio = overlap_agreement(proposals.packed_source, proposals.packed_target, pairs[:, None], pairs[None])
        return np.maximum((r * ratio - 0.7) / 0.3, 0).sum(axis=1)

    fast = best(lambda: overlap_scores(pairs, g, proposals.packed_source, proposals.packed_target, 0.7))
    print(f"top-down scores, 3000 candidates: {1000 * fast:.1f} ms, {best(agreement, 1) / fast:.0f} times faster than the matrix")
    count, edges = len(a.layers.members), a.layers.edges
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    fast = best(lambda: hop_distances(count, edges))
    plain = best(lambda: shortest_path(graph, directed=False, unweighted=True), 1)
    print(f"hop distances, {count} nodes: {1000 * fast:.1f} ms, {plain / fast:.0f} times faster than SciPy")


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="leave out the seconds by step")
    options = parser.parse_args()
    warm_up()
    if not options.quick:
        steps()
    reruns()
    descriptors()
    consistency()


if __name__ == "__main__":
    main()
