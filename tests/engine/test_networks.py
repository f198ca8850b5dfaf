"""Networks evaluated by hand."""

import numpy as np
import pytest

from engine.networks import log_odds, logistic

NET = {"mean": np.array([1.0, 0.0], dtype=np.float32), "scale": np.array([2.0, 1.0], dtype=np.float32), "layers": [
    {"weights": np.array([[1.0, -1.0], [0.0, 2.0]], dtype=np.float32), "bias": np.array([0.0, 0.5], dtype=np.float32)},
    {"weights": np.array([[1.0], [3.0]], dtype=np.float32), "bias": np.array([-1.0], dtype=np.float32)}]}  # fmt: skip


def test_layers_with_rectified_units_between():
    # (3, 1) becomes (1, 1), then (1, -1 + 2 + .5) and 1 + 3 · 1.5 - 1; (-1, 0) becomes (-1, 0), then (0, 1.5)
    assert log_odds(NET, np.array([[3.0, 1.0], [-1.0, 0.0]])) == pytest.approx(np.array([[4.5], [3.5]]))


def test_inputs_far_out_are_cut_off():
    far = log_odds({**NET, "clip": 2}, np.array([[101.0, 50.0]]))
    assert far == pytest.approx(log_odds(NET, np.array([[5.0, 2.0]])))


def test_the_logistic_function():
    assert logistic(np.array([0.0, np.log(3), -np.log(3)])) == pytest.approx([0.5, 0.75, 0.25])
