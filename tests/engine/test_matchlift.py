"""MatchLift against a general solver, on problems whose answer is known, and its fast way against the dense one."""

import numpy as np
import pytest

from engine.consistency.matchlift import estimate_universe, matchlift
from engine.consistency.semidefinite import Follower, lower_bound, nearest_semidefinite, one_thread
from engine.errors import BadInput, Cancelled


@pytest.fixture(autouse=True)
def on_one_thread():
    """Decompositions of these sizes wait for each other on a busy machine."""
    with one_thread():
        yield


SOLVE = {"sparsity": 0.1, "penalty": 4.0, "tolerance": 1e-3, "max_steps": 1000}


def cycles(count, size, *, wrong, seen=1.0, seed=0):
    """`count` objects that each see a share of `size` elements; of the matches given, a share `wrong` is shuffled.

    Returns the similarity, the objects and the truth.
    """
    rng = np.random.default_rng(seed)
    labels = [rng.permutation(size)[: max(2, round(seen * size))] for _ in range(count)]
    element, objects = np.concatenate(labels), np.repeat(np.arange(count), [len(k) for k in labels])
    truth = (element[:, None] == element[None]) & (objects[:, None] != objects[None])
    given = truth.copy()
    for a in range(count):
        for b in range(a):
            if rng.random() < wrong:
                rows, columns = np.flatnonzero(objects == a), np.flatnonzero(objects == b)
                block = given[np.ix_(rows, columns)][:, rng.permutation(len(columns))]
                given[np.ix_(rows, columns)] = block
                given[np.ix_(columns, rows)] = block.T
    return given.astype(float), objects, truth


def by_cvxpy(similarity, objects, universe, sparsity, impossible):
    import cvxpy

    n = len(objects)
    lifted = cvxpy.Variable((n + 1, n + 1), PSD=True)
    x = lifted[1:, 1:]
    zero = ((objects[:, None] == objects[None]) & ~np.eye(n, dtype=bool)) | impossible
    rules = [lifted[0, 0] == universe, lifted[0, 1:] == 1, cvxpy.diag(x) == 1, x >= 0, cvxpy.multiply(zero, x) == 0]
    free = (~zero & ~np.eye(n, dtype=bool)).astype(float)
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.sum(cvxpy.multiply(free * (sparsity - similarity), x))), rules)
    problem.solve(solver=cvxpy.SCS, eps=1e-6, max_iters=50_000)
    return x.value, problem.value


@pytest.mark.parametrize(("seed", "universe"), [(0, 5), (1, 5), (2, 6)])
def test_equals_a_general_solver(seed, universe):
    rng = np.random.default_rng(seed)
    objects = np.repeat(np.arange(5), 4)
    similarity = np.where(rng.random((20, 20)) < 0.4, rng.random((20, 20)), 0)
    similarity = np.triu(similarity, 1) + np.triu(similarity, 1).T
    impossible = np.zeros((20, 20), bool)
    impossible[0, 5] = impossible[7, 12] = True
    expected, best = by_cvxpy(similarity, objects, universe, 0.1, impossible | impossible.T)
    found = matchlift(similarity, objects, universe=universe, impossible=impossible,
                      **SOLVE | {"tolerance": 1e-5, "max_steps": 5000})  # fmt: skip
    free = objects[:, None] != objects[None]
    assert found.converged
    assert (0.1 - similarity)[free] @ found.matches[free] == pytest.approx(best, abs=1e-3)
    assert found.matches == pytest.approx(expected, abs=5e-3)
    assert not found.matches[impossible | impossible.T].any()


@pytest.mark.parametrize("seen", [1.0, 0.7])
def test_recovers_the_truth_exactly_below_a_level_of_noise(seen):
    for seed in range(3):
        similarity, objects, truth = cycles(14, 6, wrong=0.3, seen=seen, seed=seed)
        found = matchlift(similarity, objects, universe=6, **SOLVE)
        assert (found.matches > 0.5).astype(int)[~np.eye(len(objects), dtype=bool)].sum() == truth.sum()
        assert np.array_equal(found.matches > 0.5, truth | np.eye(len(objects), dtype=bool))
        assert not np.array_equal(similarity > 0.5, truth)  # the input was not right


def test_noise_alone_gives_no_truth_back():
    similarity, objects, truth = cycles(14, 6, wrong=1.0)
    found = matchlift(similarity, objects, universe=6, **SOLVE)
    kept = (found.matches > 0.5) & (objects[:, None] != objects[None])
    assert (kept & truth).sum() < 0.5 * truth.sum()


def test_completes_a_match_that_was_never_given():
    similarity, objects, truth = cycles(8, 4, wrong=0.0)
    apart = (objects[:, None] == 0) & (objects[None] == 1)
    found = matchlift(np.where(apart | apart.T, 0, similarity), objects, universe=4, **SOLVE)
    assert np.array_equal(found.matches > 0.9, truth | np.eye(32, dtype=bool))


def test_a_permutation_of_the_elements_permutes_the_answer():
    similarity, objects, _ = cycles(10, 5, wrong=0.4, seed=3)
    order = np.random.default_rng(1).permutation(50)
    found = matchlift(similarity, objects, universe=5, **SOLVE).matches
    again = matchlift(similarity[np.ix_(order, order)], objects[order], universe=5, **SOLVE).matches
    assert again == pytest.approx(found[np.ix_(order, order)], abs=1e-4)


@pytest.mark.parametrize(("count", "size", "wrong", "slack"), [(40, 6, 0.4, 0), (12, 12, 0.3, 0), (30, 8, 0.6, 6)])
def test_the_fast_way_gives_the_answer_of_the_dense_one(monkeypatch, count, size, wrong, slack):
    monkeypatch.setattr("engine.consistency.semidefinite.DENSE_BELOW", 50)
    similarity, objects, _ = cycles(count, size, wrong=wrong, seen=0.9)
    how = SOLVE | {"penalty": 2.0, "tolerance": 2e-4, "max_steps": 3000}
    fast = matchlift(similarity, objects, universe=size + slack, **how)
    dense = matchlift(similarity, objects, universe=size + slack, follow=False, **how)
    assert dense.dense == dense.steps
    assert fast.dense < 0.2 * fast.steps
    assert fast.converged
    assert dense.converged
    assert np.abs(fast.matches - dense.matches).max() < 1e-2
    assert np.array_equal(fast.matches > 0.5, dense.matches > 0.5)


def test_the_universe_is_estimated_from_the_input():
    similarity, objects, _ = cycles(20, 6, wrong=0.3, seen=0.7)
    assert estimate_universe(similarity, objects) == 6


def test_the_result_is_symmetric_bounded_and_frozen():
    similarity, objects, _ = cycles(6, 3, wrong=0.5)
    found = matchlift(similarity, objects, universe=3, **SOLVE).matches
    assert np.array_equal(found, found.T)
    assert found.min() >= 0 and found.max() <= 1 and (np.diag(found) == 1).all()  # noqa: PT018
    with pytest.raises(ValueError):
        found[0, 0] = 0


def test_steps_are_bounded_and_said():
    similarity, objects, _ = cycles(6, 3, wrong=0.5)
    found = matchlift(similarity, objects, universe=3, **SOLVE | {"max_steps": 3})
    assert found.steps == 3
    assert not found.converged


def test_progress_rises_and_can_cancel():
    similarity, objects, _ = cycles(10, 5, wrong=0.5)
    seen = []
    matchlift(similarity, objects, universe=5, progress=lambda share, words: seen.append(share), **SOLVE)
    assert min(seen) >= 0 and max(seen) <= 1 and len(seen) > 5  # noqa: PT018

    def cancel(share, words):
        raise Cancelled

    with pytest.raises(Cancelled):
        matchlift(similarity, objects, universe=5, progress=cancel, **SOLVE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"similarity": np.ones((3, 4))}, "shape"),
        ({"similarity": np.full((4, 4), 2.0)}, r"\[0, 1\]"),
        ({"similarity": np.full((4, 4), np.nan)}, r"\[0, 1\]"),
        ({"similarity": np.triu(np.ones((4, 4)))}, "symmetric"),
        ({"objects": np.zeros(4, int)}, "2 objects"),
        ({"universe": 1}, "too small"),
        ({"impossible": np.zeros((2, 2), bool)}, "impossible"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(change, words):
    good = {"similarity": np.eye(4), "objects": np.array([0, 0, 1, 1]), "universe": 2}
    matchlift(**good, **SOLVE)
    with pytest.raises(BadInput, match=words):
        matchlift(**good | change, **SOLVE)


def test_nearest_semidefinite_satisfies_the_conditions_of_the_projection():
    for shift in (-6, 0, 6):  # few, half and most eigenvalues positive
        a = np.random.default_rng(0).standard_normal((30, 30))
        a = a + a.T + shift * np.eye(30)
        p, rank = nearest_semidefinite(a)
        assert np.linalg.eigvalsh(p).min() > -1e-9
        assert np.linalg.eigvalsh(p - a).min() > -1e-9
        assert abs(np.sum(p * (p - a))) < 1e-8
        assert rank == (np.linalg.eigvalsh(a) > 0).sum()


def test_following_a_changing_matrix_stays_with_the_full_projection():
    rng = np.random.default_rng(0)
    basis = rng.standard_normal((700, 60))
    still, moving = (np.diag(rng.standard_normal(700)) - 3 * np.eye(700), rng.standard_normal((700, 700)) / 60)
    project = Follower()
    for step in range(12):
        basis += 0.01 * rng.standard_normal(basis.shape)
        a = basis @ basis.T / 70 + still + (moving + moving.T) * (1 + step / 50)
        followed, rank = project(a)
        expected, its_rank = nearest_semidefinite(a)
        assert np.linalg.norm(followed - expected) < 1e-2 * np.linalg.norm(expected)
        assert abs(rank - its_rank) <= 1
    assert project.dense < 6


def test_a_jump_of_the_spectrum_is_seen():
    project = Follower()
    a = np.diag(np.r_[np.full(650, -1.0), np.linspace(1, 2, 50)])
    project(a)
    b = np.diag(np.r_[np.full(300, -1.0), np.full(400, 1.0)])
    for _ in range(3):
        followed, rank = project(b)
    assert rank == 400
    assert followed == pytest.approx(np.maximum(b, 0), abs=1e-6)


def test_the_lower_bound_is_below_and_near():
    for seed in range(20):
        a = np.random.default_rng(seed).standard_normal((80, 80))
        a += a.T
        smallest = np.linalg.eigvalsh(a)[0]
        assert 3 * smallest < lower_bound(a, np.random.default_rng(seed)) <= smallest
