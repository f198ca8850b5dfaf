"""The plain tree by hand and against the scorer of solutions; the thesis's tables on pictures drawn by numbers."""

import csv
import io

import numpy as np
import pytest
from test_puzzle_confirming import picture

from engine.errors import BadInput, BadParameter, Cancelled
from engine.puzzles.cutting import cut
from engine.puzzles.measures import side_strips
from engine.puzzles.parameters import PuzzleParameters
from engine.puzzles.plaintree import Ratios, direct_and_neighbour, gallagher, judged, plain_tree, ratios_of
from engine.puzzles.scoring import score
from engine.puzzles.solution import PuzzleSolution, no_joins
from engine.puzzles.thesis_tables import table_4_1, table_5_2
from engine.puzzles.thesis_tables_text import csv_of_4_1, csv_of_5_2, table_of_4_1, table_of_5_2
from engine.table_commands import table_4_1 as command_4_1
from engine.table_commands import table_5_2 as command_5_2

NONE = np.zeros(0, dtype=np.int64)


def ratios_from(right, down):
    """Ratios of n pieces from two tables (n, n)."""
    right, down = (np.where(np.eye(len(t), dtype=bool), np.inf, t) for t in (right, down))
    i, j = np.nonzero(~np.eye(len(right), dtype=bool))
    pairs = np.concatenate([np.column_stack([4 * i + 1, 4 * j + 3]), np.column_stack([4 * i + 2, 4 * j])])
    return Ratios(right, down, pairs, np.concatenate([right[i, j], down[i, j]]))


def square_of_four():
    """Pieces 0 1 / 2 3: each true join has the ratio 0.5, all others 3."""
    right, down = np.full((4, 4), 3.0), np.full((4, 4), 3.0)
    right[0, 1] = right[2, 3] = down[0, 2] = down[1, 3] = 0.5
    return ratios_from(right, down)


TRUE = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])


def test_gallaghers_ratio_by_hand():
    d = np.array([[0, 1, 4], [2, 0, 8], [6, 3, 0]], dtype=float)
    n = gallagher(d)
    assert np.isinf(np.diag(n)).all()
    assert n[0, 1] == pytest.approx(1 / 3, rel=0.01)  # the rivals are 4 in its row and 3 in its column
    assert n[0, 2] == pytest.approx(4.0, rel=0.01)  # 1 in its row
    assert n[1, 0] == pytest.approx(2 / 6, rel=0.01)


def test_the_tree_puts_a_square_together_with_and_without_a_frame():
    for frame in ((2, 2), None):
        cells = plain_tree(square_of_four(), frame, NONE)
        assert np.array_equal(cells, TRUE)
    assert judged(square_of_four(), TRUE) == pytest.approx(0.5)
    assert judged(square_of_four(), TRUE[[1, 0, 2, 3]]) == pytest.approx((3 + 0.5 + 3 + 3) / 4)


def test_confirmed_joins_come_before_likelier_ones():
    ratios = square_of_four()
    wrong = int(np.flatnonzero((ratios.pairs == [4 * 0 + 1, 4 * 3 + 3]).all(axis=1))[0])
    cells = plain_tree(ratios, None, np.array([wrong]))
    assert (cells[3] - cells[0]).tolist() == [1, 0]


def test_a_frame_is_kept_to_and_all_its_cells_are_filled():
    rng = np.random.default_rng(0)
    ratios = ratios_from(rng.uniform(0.5, 3, (15, 15)), rng.uniform(0.5, 3, (15, 15)))
    cells = plain_tree(ratios, (5, 3), NONE)
    assert sorted(map(tuple, cells.tolist())) == [(x, y) for x in range(5) for y in range(3)]


def test_shares_are_those_of_the_scorer():
    made, truth = cut(picture(), piece_size=21, seed=0)
    ratios = ratios_of("ssd", side_strips(made.rasters()))
    cells = plain_tree(ratios, (8, 6), NONE)
    solution = PuzzleSolution(
        "p", np.zeros(48), 21 * cells, np.zeros(48), np.array([[168, 126]]), no_joins(), "mst", "ssd", PuzzleParameters())
    scores = score(made, truth, solution)
    mine = direct_and_neighbour(cells, truth.position // 21, shifted=False)
    assert mine == pytest.approx((scores.direct, scores.neighbour))
    assert scores.neighbour > 0.2


def test_a_shift_counts_only_where_it_is_allowed():
    assert direct_and_neighbour(TRUE, TRUE + np.array([1, 0]), shifted=True) == (1.0, 1.0)
    assert direct_and_neighbour(TRUE, TRUE + np.array([1, 0]), shifted=False) == (0.0, 1.0)
    assert direct_and_neighbour(TRUE[[1, 0, 2, 3]], TRUE, shifted=False) == (0.5, 0.25)


@pytest.fixture(scope="module")
def pictures():
    return [("smooth.png", picture(96, 80, seed=1)), ("=other.png", picture(90, 90, seed=2))]


def test_table_4_1_keeps_what_the_truth_chose_apart(pictures):
    rows = table_4_1(pictures, PuzzleParameters(), grids=(4, 5), t_1=(0.6, 0.9), t_2=(0.5, 0.9), resolution=80)
    assert [(row.image, row.pieces) for row in rows] == [("smooth.png", 16), ("smooth.png", 25), ("=other.png", 16), ("=other.png", 25)]
    for row in rows:
        assert row.best.direct >= row.chosen.direct
        assert row.chosen.judge <= row.best.judge
        assert row.chosen.t_1 in (0.6, 0.9)
        assert row.tree.neighbour > 0.5
    made = table_of_4_1(rows)
    assert [table.title for table in made] == ["16 pieces", "25 pieces"]
    assert made[0].rows[-1][0] == "mean"
    lines = list(csv.DictReader(io.StringIO(csv_of_4_1(rows))))
    assert float(lines[3]["best_direct"]) == pytest.approx(rows[3].best.direct, abs=1e-6)
    assert lines[2]["image"] == "'=other.png"
    again = table_4_1(pictures, PuzzleParameters(), grids=(4, 5), t_1=(0.6, 0.9), t_2=(0.5, 0.9), resolution=80)
    assert [row[:5] for row in again] == [row[:5] for row in rows]


def test_table_5_2_has_every_way_and_is_never_unshuffled(pictures):
    rows = table_5_2(pictures, PuzzleParameters(), pieces=30, frame=True)
    ways = rows[0].ways
    assert ways["MGC"].neighbour > 0.9
    assert ways["pruned, MGC"].precision > 0.8
    assert np.isnan(ways["EMD"].precision)
    made = table_of_5_2(rows)[0]
    assert len(made.rows) == 3
    assert all(len(row) == len(made.head) for row in made.rows)
    lines = list(csv.DictReader(io.StringIO(csv_of_5_2(rows))))
    assert len(lines) == 12
    assert lines[0]["precision"] == ""
    plain = table_5_2([("plain", np.full((80, 96, 3), 90, np.uint8))], PuzzleParameters(), pieces=30, frame=True)
    assert plain[0].ways["MGC"].direct < 0.5  # ties do not leak the truth


def test_the_tables_are_written_whole(tmp_path, capsys):
    from PIL import Image

    folder, out = tmp_path / "pictures", tmp_path / "out"
    folder.mkdir()
    Image.fromarray(picture(60, 60)).save(folder / "a.png")
    command_4_1(folder, out=out, grids=[3], t1=[0.7], t2=[0.5])
    assert sorted(path.name for path in out.iterdir()) == ["table-4.1.csv", "table-4.1.html", "table-4.1.md"]
    assert "spanning tree" in capsys.readouterr().out
    command_5_2(folder, out=out, pieces=9, frame="known")
    assert "pruned, EMD" in (out / "table-5.2.md").read_text()
    assert (out / "table-5.2.html").read_text().startswith("<!doctype html>")


@pytest.mark.parametrize(
    ("command", "change", "error", "words"),
    [
        (command_4_1, {"folder": "missing"}, BadInput, "not a folder"),
        (command_4_1, {"folder": "empty"}, BadInput, "holds no images"),
        (command_4_1, {"grids": [24], "resolution": 40}, BadInput, "too small"),
        (command_4_1, {"set": ["lift_sparsity=9"]}, BadParameter, "lift_sparsity"),
        (command_5_2, {"pieces": 100_000}, BadInput, "too small"),
        (command_5_2, {"pieces": 1}, BadInput, "at least 2"),
    ],
)
def test_bad_requests_are_refused_in_a_sentence(tmp_path, command, change, error, words):
    from PIL import Image

    for name in ("pictures", "empty"):
        (tmp_path / name).mkdir()
    Image.fromarray(picture(60, 60)).save(tmp_path / "pictures" / "a.png")
    arguments = {"folder": "pictures"} | change
    with pytest.raises(error, match=words):
        command(tmp_path / arguments.pop("folder"), out=tmp_path / "out", **arguments)
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_tables_can_be_cancelled(pictures):
    def cancel(share, words):
        raise Cancelled

    with pytest.raises(Cancelled):
        table_4_1(pictures, PuzzleParameters(), grids=(3,), progress=cancel)
    with pytest.raises(Cancelled):
        table_5_2(pictures, PuzzleParameters(), pieces=9, progress=cancel)
