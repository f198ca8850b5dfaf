"""The painted landscape: the same by its seed, and in its statistics like a photograph."""

import numpy as np
import pytest

from engine.puzzles.scenery import landscape, noise


def test_the_same_seed_paints_the_same_picture():
    one = landscape(112, 84, seed=3)
    assert one.shape == (84, 112, 3)
    assert one.dtype == np.uint8
    assert np.array_equal(one, landscape(112, 84, seed=3))
    assert not np.array_equal(one, landscape(112, 84, seed=4))


@pytest.mark.parametrize("power", [0.8, 1.3])
def test_the_amplitude_of_noise_falls_with_the_power_of_the_frequency(power):
    rows = np.stack([noise(np.random.default_rng(seed), (512,), power) for seed in range(60)])
    assert np.allclose(rows.mean(axis=1), 0)
    assert np.allclose(rows.std(axis=1), 1)
    spectrum = np.abs(np.fft.rfft(rows * np.hanning(512), axis=1)).mean(axis=0)[4:100]
    slope = np.polyfit(np.log(np.arange(4, 100)), np.log(spectrum), 1)[0]
    assert slope == pytest.approx(-power, abs=0.15)


def test_stretched_noise_changes_less_along_its_last_axis():
    made = noise(np.random.default_rng(0), (200, 200), 1.2, 5.0)
    assert np.abs(np.diff(made, axis=1)).mean() < 0.5 * np.abs(np.diff(made, axis=0)).mean()


def test_neighbouring_pixels_are_alike_and_no_large_part_is_flat():
    scene = landscape(336, 252, seed=1).astype(float)
    beside, random = np.abs(np.diff(scene, axis=1)).mean(), np.abs(scene - np.roll(scene, (97, 131), (0, 1))).mean()
    assert beside < 0.35 * random
    blocks = scene[:252, :336].reshape(9, 28, 12, 28, 3).std(axis=(1, 3))
    assert (blocks.min(axis=2) > 1).all()
