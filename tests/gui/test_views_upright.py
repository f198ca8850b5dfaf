import numpy as np
import pytest

from gui.views.upright import asymmetry, rests, up_axis, upright


def table(height: float = 1.0) -> np.ndarray:
    """Points of a table with z up: a top of two by one, and four thin legs."""
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-0.5, 0.5, 21)))
    top = np.c_[u, v, np.full(len(u), height)]
    legs = [np.c_[np.tile([x, y], (60, 1)), np.linspace(0, height, 60)] for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    return np.concatenate([top, *legs])


def test_a_table_stands_on_its_legs_whichever_way_the_file_says():
    points = table()
    assert up_axis(points) == "z"
    assert up_axis(upright(points, "z")) == "y"


def test_turning_upright_keeps_right_and_left():
    turned = upright(np.eye(3), "z")
    assert turned[2] == pytest.approx([0, 1, 0])
    assert np.linalg.det(turned) == pytest.approx(1)


def test_it_does_not_stand_on_its_edge_or_on_a_point():
    tilted = table() @ np.array([[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]])
    assert rests(table(), 2)
    assert not rests(tilted, 2)
    pyramid = np.array([[x * (1 - h), y * (1 - h), -h] for h in np.linspace(0, 1, 9) for x in (-1, 1) for y in (-1, 1)])
    assert not rests(pyramid, 2)
    assert rests(-pyramid, 2)


def test_mirrored_along_its_width_a_table_is_the_same():
    assert asymmetry(table(), 0) < 0.1 < 0.5 < asymmetry(table(), 2)


def test_where_nothing_tells_y_is_up():
    ball = np.random.default_rng(0).normal(size=(500, 3))
    both_ways = np.concatenate([ball, ball[:, [0, 2, 1]]])
    assert up_axis(both_ways) == "y"
