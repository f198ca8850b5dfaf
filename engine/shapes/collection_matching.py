"""Collections of three and more shapes: all pairs matched, each match with its support, and parts that agree."""

from collections.abc import Sequence

import numpy as np

from ..consistency.cycles import cycle_support
from ..consistency.lifting import LiftedAtoms, lift_atoms, lifted_support
from ..errors import BadInput
from ..progress import Progress, share, silent
from ..store import Cache
from .collection_parameters import CollectionParameters
from .collection_result import CollectionResult, parts_of
from .describing import DescribedShape, Stopwatch, describe
from .matching import rematch
from .measures import Measures
from .parameters import MatchParameters
from .proposing import propose
from .result import MatchResult
from .segmentation import SegmentedShape

_PENALTY = 0.5  # of MatchLift: changes its speed alone


def match_collection(
    shapes: Sequence[SegmentedShape],
    parameters: MatchParameters,
    collection: CollectionParameters,
    *,
    preset: str = "",
    failures: Sequence[str] = (),
    progress: Progress = silent,
    cache: Cache | None = None,
) -> CollectionResult:
    """Match the pairs of a collection and make their matches consistent.

    A shape that cannot be described is left out, and said so in a sentence after the `failures` that are handed in.
    Raises `BadInput` where fewer than two shapes are left.
    """
    watch = Stopwatch()
    with watch("describing"):
        described, more = _described(shapes, parameters, share(progress, 0.0, 0.4), cache)
    failures = (*failures, *more)
    if len(described) < 2:
        raise BadInput(" ".join([f"A collection needs at least two shapes, and {len(described)} can be used.", *failures]))
    pairs = chosen_pairs(len(described), collection.partners, collection.pair_seed)
    names = unique_names([d.shape.mesh.name for d in described])
    with watch("matching pairs"):
        results = _matched(described, names, pairs, parameters, preset, share(progress, 0.4, 0.9), cache)
    progress(0.9, "support by cycles")
    with watch("support by cycles"):
        cycles = _cycles(described, pairs, results, collection.alike_power)
    with watch("MatchLift and parts"):
        areas = tuple(d.graph.area for d in described)
        atoms = _lifted(pairs, results, areas, collection, share(progress, 0.92, 1.0))
        parts = parts_of(atoms, areas, collection)
    progress(1.0, f"{sum(len(r.ids) for r in results)} matches of {len(pairs)} pairs")
    return CollectionResult(
        shapes=tuple(d.shape for d in described), names=names, pairs=pairs, results=results,
        supports={"cycles": cycles, "matchlift": _lifted_supports(pairs, results, areas, atoms)},
        atoms=atoms, areas=areas, parts=parts, parameters=collection, match_parameters=parameters, preset=preset,
        failures=failures, notes=(*_notes(len(described), pairs, atoms, collection), *_own_notes(described)),
        seconds=watch.seconds)  # fmt: skip


def chosen_pairs(count: int, partners: int, seed: int) -> tuple[tuple[int, int], ...]:
    """Pairs (a, b), a < b, sorted: all of them, or a sample in which each shape has about `partners` others.

    The sample is a ring in a seeded order in which each is joined to its nearest on either side, so that every match
    has third shapes that both of its shapes are matched with.
    """
    if count - 1 <= partners:
        return tuple((a, b) for a in range(count) for b in range(a + 1, count))
    order = np.random.default_rng(seed).permutation(count)
    steps = max(2, partners // 2)
    found = {(int(order[k]), int(order[(k + step) % count])) for k in range(count) for step in range(1, steps + 1)}
    return tuple(sorted({(min(pair), max(pair)) for pair in found}))


def unique_names(names: Sequence[str]) -> tuple[str, ...]:
    """The names, numbered from the second of the same: 'chair', 'chair (2)'."""
    found: list[str] = []
    for name in names:
        made, number = name, 1
        while made in found:
            number += 1
            made = f"{name} ({number})"
        found.append(made)
    return tuple(found)


def jaccard(measures: Measures) -> np.ndarray:
    """How alike the nodes of a shape are, (k, k) float64: shared area over united area, 1 on the diagonal."""
    size = measures.size
    shared = measures.overlap.astype(np.float64) * size[:, None]
    shared = np.minimum(shared, shared.T)
    out = np.clip(shared / (size[:, None] + size - shared), 0, 1)
    np.fill_diagonal(out, 1)
    return out


def _described(
    shapes: Sequence[SegmentedShape], parameters: MatchParameters, progress: Progress, cache: Cache | None
) -> tuple[list[DescribedShape], list[str]]:
    found, failures = [], []
    for row, shape in enumerate(shapes):
        own = share(progress, row / len(shapes), (row + 1) / len(shapes))
        try:
            found.append(describe(shape, parameters, progress=own, cache=cache))
        except BadInput as error:
            failures.append(f"{shape.mesh.name} was left out: {error}")
    return found, failures


def _matched(
    described: Sequence[DescribedShape], names: Sequence[str], pairs: Sequence[tuple[int, int]],
    parameters: MatchParameters, preset: str, progress: Progress, cache: Cache | None,
) -> tuple[MatchResult, ...]:  # fmt: skip
    results = []
    for row, (a, b) in enumerate(pairs):
        progress(row / len(pairs), f"{names[a]} and {names[b]}, pair {row + 1} of {len(pairs)}")
        proposals = propose(described[a], described[b], parameters, cache=cache)
        results.append(rematch(proposals, parameters, preset=preset))
    return tuple(results)


def _cycles(
    described: Sequence[DescribedShape], pairs: Sequence[tuple[int, int]], results: Sequence[MatchResult], power: float
) -> tuple[np.ndarray, ...]:
    found = cycle_support(
        {pair: result.pairs for pair, result in zip(pairs, results, strict=True)},
        [jaccard(d.measures) ** power for d in described])  # fmt: skip
    return tuple(found[pair] for pair in pairs)


def _lifted(
    pairs: Sequence[tuple[int, int]], results: Sequence[MatchResult], areas: Sequence[np.ndarray],
    collection: CollectionParameters, progress: Progress,
) -> LiftedAtoms:  # fmt: skip
    members = {pair: (r.source_members, r.target_members) for pair, r in zip(pairs, results, strict=True)}
    return lift_atoms(
        members, [len(area) for area in areas], sparsity=collection.lift_sparsity, penalty=_PENALTY,
        tolerance=collection.lift_tolerance, max_steps=collection.lift_steps, most=collection.lift_most,
        progress=progress)  # fmt: skip


def _lifted_supports(
    pairs: Sequence[tuple[int, int]], results: Sequence[MatchResult], areas: Sequence[np.ndarray], atoms: LiftedAtoms
) -> tuple[np.ndarray, ...]:
    """NaN where nothing was lifted, or where there is no third shape to say anything."""
    if atoms.lift is None or len(areas) < 3:
        return tuple(np.full(len(r.ids), np.nan) for r in results)
    return tuple(
        lifted_support(atoms.block(a, b), r.source_members, r.target_members, areas[a], areas[b])
        for (a, b), r in zip(pairs, results, strict=True))  # fmt: skip


def _notes(
    count: int, pairs: Sequence[tuple[int, int]], atoms: LiftedAtoms, collection: CollectionParameters
) -> list[str]:
    notes = []
    if count == 2:
        notes.append("Two shapes are one pair: a support needs a third shape.")
    if len(pairs) < count * (count - 1) // 2:
        notes.append(f"{len(pairs)} of {count * (count - 1) // 2} pairs were matched, each shape with about "
                     f"{collection.partners} others (partners, pair_seed).")  # fmt: skip
    total = int(atoms.start[-1])
    if total > collection.lift_most:
        notes.append(f"The {total:,} segments in all are more than lift_most = {collection.lift_most:,}: MatchLift was left "
                     "out, and the parts come from the matches alone.")  # fmt: skip
    elif atoms.lift is not None and not atoms.lift.converged:
        notes.append(f"MatchLift stopped after {atoms.lift.steps} steps before it had settled (lift_steps).")
    return notes


def _own_notes(described: Sequence[DescribedShape]) -> list[str]:
    return list(dict.fromkeys(note for d in described for note in d.notes))
