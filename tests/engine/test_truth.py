"""Truth of shapes by the class of each face, and agreement with an independent judge where one stands near."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from engine.errors import BadInput
from engine.evaluation.correspondence import evaluate_tables
from engine.shapes.families import make_pair, write_pair
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.shapes.truth import counts, evaluate_matches, label_table, lenient_answers

JUDGE = Path(__file__).resolve().parents[3] / "shared" / "tools" / "judge_matches.py"


def squares() -> SegmentedShape:
    """Three unit squares in a row, two triangles each; segment 0 is the first and half of the second."""
    x = np.arange(4.0)
    vertices = np.vstack([np.c_[x, 0 * x, 0 * x], np.c_[x, 0 * x + 1, 0 * x]])
    faces = np.array([face for k in range(3) for face in ((k, k + 1, k + 5), (k, k + 5, k + 4))])
    return SegmentedShape(Mesh(vertices, faces, "squares"), segmentation_from_labels([7, 7, 7, 9, 9, 9]))


def test_the_table_holds_the_area_of_each_class_in_each_segment():
    table = label_table(squares(), np.array([4, 4, 5, 5, 5, 5]), np.array([4, 5, 6]))
    assert table == pytest.approx(np.array([[1, 0.5, 0], [0, 1.5, 0]]))


def test_labels_that_do_not_fit_are_refused():
    with pytest.raises(BadInput, match="6 faces but 2 semantic labels"):
        label_table(squares(), np.array([4, 4]), np.array([4]))
    with pytest.raises(BadInput, match="not listed"):
        label_table(squares(), np.array([4, 4, 4, 4, 4, 8]), np.array([4, 5]))


def test_a_shape_against_itself_is_all_correct():
    shape, label = squares(), np.array([1, 1, 1, 2, 2, 2])
    e = evaluate_matches(shape, shape, label, label, [((0,), (0,)), ((1,), (1,))])
    assert (e.lenient, e.strict, e.transfer_precision, e.transfer_recall) == (1, 1, 1, 1)
    swapped = evaluate_matches(shape, shape, label, label, [((0,), (1,)), ((1,), (0,))])
    assert (swapped.lenient, swapped.strict, swapped.transfer_recall) == (0, 0, 0)


def random_matches(pair, seed: int, count: int) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Unions of one to five segments, whole shapes, and some plausible matches."""
    rng = np.random.default_rng(seed)
    s, t = pair.source.segmentation.count, pair.target.segmentation.count
    rows = []
    for _ in range(count):
        a = rng.choice(s, rng.integers(1, 6), replace=False)
        b = rng.choice(t, rng.integers(1, 6), replace=False)
        rows.append((tuple(a.tolist()), tuple(b.tolist())))
    return [*rows, (tuple(range(s)), tuple(range(t)))]


@pytest.mark.skipif(not JUDGE.exists(), reason=f"the independent judge {JUDGE} is not beside this checkout")
@pytest.mark.parametrize(("family", "seed", "count"), [("lamps", 1, 40), ("aeroplanes", 2, 15), ("animals", 3, 1)])
def test_every_figure_agrees_with_the_independent_judge(family, seed, count, tmp_path):
    spec = importlib.util.spec_from_file_location("judge_matches", JUDGE)
    judge = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(judge)
    pair = make_pair(family, seed)
    matches = random_matches(pair, seed, count)
    a, b = write_pair(tmp_path, "pair", pair)
    labels = [
        (np.loadtxt(p.with_suffix(".seg"), dtype=int), np.loadtxt(p.with_suffix(".sem"), dtype=int)) for p in (a, b)
    ]
    classes = np.unique(np.concatenate([labels[0][1], labels[1][1]]))
    tables = [judge.table(judge.read_off(p), *x, classes) for p, x in zip((a, b), labels, strict=True)]
    theirs = judge.judge(*tables, matches)
    ours = evaluate_matches(pair.source, pair.target, pair.source_label, pair.target_label, matches)

    assert ours.judged == theirs["judged"] > 0
    for name, value in (
        ("lenient", ours.lenient),
        ("strict", ours.strict),
        ("chance lenient", ours.chance_lenient),
        ("chance strict", ours.chance_strict),
        ("transfer precision", ours.transfer_precision),
        ("transfer recall", ours.transfer_recall),
    ):
        assert value == pytest.approx(theirs[name], abs=1e-9), name
    sizes = {
        f"size {s.name} ({s.judged}): lenient/strict": f"{s.lenient / s.judged:.2f}/{s.strict / s.judged:.2f}"
        for s in ours.sizes
    }
    assert sizes == {key: value for key, value in theirs.items() if key.startswith("size")}


def test_areas_of_a_generated_pair_add_up_to_the_surface():
    pair = make_pair("vases", 0)
    classes = np.arange(len(pair.label_names))
    table = label_table(pair.source, pair.source_label, classes)
    assert table.sum() == pytest.approx(face_areas(pair.source.mesh).sum())
    e = evaluate_tables(table, table, [((k,), (k,)) for k in range(len(table))])
    assert e.lenient == e.strict == 1


@pytest.mark.parametrize("seed", range(3))
def test_what_counts_and_is_right_adds_up_to_the_figures(seed):
    pair = make_pair("lamps", seed)
    matches = random_matches(pair, seed, 30)
    s, t = pair.source.segmentation.count, pair.target.segmentation.count
    sides = [np.array([np.isin(np.arange(n), match[side]) for match in matches]) for side, n in enumerate((s, t))]
    result = SimpleNamespace(ids=range(len(matches)), source_members=sides[0], target_members=sides[1])
    judged = counts(pair.source, pair.target, result)
    right = lenient_answers(pair.source, pair.target, pair.source_label, pair.target_label, result)
    e = evaluate_matches(pair.source, pair.target, pair.source_label, pair.target_label, matches)
    assert not judged[-1]
    assert (sum(judged), sum(np.array(judged) & right)) == (e.judged, e.lenient_correct)
