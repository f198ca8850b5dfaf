"""A landscape that Concord paints itself, so that there are pictures to cut up wherever no photograph is at hand."""

import numpy as np

_ZENITH, _PALE, _WARM = (0.16, 0.32, 0.62), (0.62, 0.76, 0.90), (1.0, 0.80, 0.58)
_SUN, _GLOW = (1.0, 0.97, 0.86), (0.55, 0.40, 0.21)
_CLOUD_SHADE, _CLOUD_LIGHT = (0.52, 0.50, 0.60), (1.0, 0.95, 0.88)
_ROCK, _MOSS, _FOREST, _SNOW, _HAZE = (
    (0.46, 0.43, 0.45),
    (0.16, 0.30, 0.14),
    (0.15, 0.27, 0.14),
    (0.93, 0.95, 1.0),
    (0.80, 0.76, 0.73),
)
_WATER, _GRASS, _STRAW = (0.10, 0.24, 0.34), (0.20, 0.34, 0.10), (0.50, 0.58, 0.18)
_PETALS = np.array([(0.92, 0.22, 0.20), (0.98, 0.84, 0.22), (0.95, 0.95, 0.98), (0.62, 0.36, 0.80), (0.98, 0.55, 0.18)])


def landscape(width: int = 672, height: int = 504, seed: int = 0) -> np.ndarray:
    """A picture (height, width, 3) uint8 of mountains by a lake; the same seed paints the same picture.

    Everything is made of noise whose amplitude falls with a power of the frequency, as that of natural scenes does
    (Burton and Moorhead, Applied Optics 26, 1987), so that sides of its pieces compare much as those of photographs.
    """
    rng = np.random.default_rng(seed)
    shore = round(0.62 * height)
    scene = _sky(rng, width, height)
    for near in (0.0, 0.25, 0.5, 0.75, 1.0):
        scene = _ridge(rng, scene, near, shore)
    scene = _meadow(rng, _lake(rng, scene, shore), round(0.8 * height))
    grain = rng.normal(0, 0.012, (height, width, 1))
    return np.round(255 * np.clip(scene + grain, 0, 1)).astype(np.uint8)


def noise(rng: np.random.Generator, shape: tuple[int, ...], power: float, stretch: float = 1.0) -> np.ndarray:
    """Noise whose amplitude falls as 1 / frequency ** power, with mean 0 and deviation 1.

    `stretch` above 1 draws it out along the last axis.
    """
    padded = tuple(2 * n for n in shape)  # of twice the size, for such noise closes on itself
    axes = [np.fft.fftfreq(n) for n in padded[:-1]] + [stretch * np.fft.rfftfreq(padded[-1])]
    squares = np.meshgrid(*(axis * axis for axis in axes), indexing="ij")
    frequency = np.maximum(np.sqrt(np.sum(squares, axis=0)), 1 / max(shape))
    spectrum = np.fft.rfftn(rng.standard_normal(padded)) / frequency**power
    made = np.fft.irfftn(spectrum, padded, axes=range(len(padded)))[tuple(slice(n) for n in shape)]
    return (made - made.mean()) / made.std()


def _mixed(
    a: np.ndarray | tuple[float, ...], b: np.ndarray | tuple[float, ...], share: np.ndarray | float
) -> np.ndarray:
    """Colours a and b (..., 3) mixed, `share` (...) of b."""
    start = np.asarray(a)
    return start + (np.asarray(b) - start) * np.asarray(share)[..., None]


def _ramp(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 below `low`, 1 above `high`, smooth between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def _sky(rng: np.random.Generator, width: int, height: int) -> np.ndarray:
    y, x = np.mgrid[0:height, 0:width] / height
    down = np.clip(y / 0.6, 0, 1)
    sky = _mixed(_mixed(_ZENITH, _PALE, _ramp(down, 0, 0.75)), _WARM, 0.9 * _ramp(down, 0.45, 1.05))
    far = np.hypot(x - 0.62 * width / height, y - 0.17)  # from the sun
    clouds = noise(rng, (height, width), 1.55, 2.6) + 0.3 * np.cos(11 * y)
    cover = 0.85 * _ramp(clouds, 0.1, 1.5) * (0.35 + 0.65 * _ramp(1 - down, 0, 0.5))
    light = _ramp(np.roll(clouds, (4, -6), (0, 1)) - clouds, -0.35, 0.35)
    sky = sky + np.exp(-far / 0.16)[..., None] * _GLOW
    sky = _mixed(sky, _mixed(_CLOUD_SHADE, _CLOUD_LIGHT, light), cover)
    return _mixed(sky, _SUN, 1 - _ramp(far, 0.034, 0.040))


def _ridge(rng: np.random.Generator, scene: np.ndarray, near: float, shore: int) -> np.ndarray:
    """A range of hills in front of the scene; `near` from 0, snowy and in the haze, to 1, wooded, at the shore."""
    h, w = scene.shape[:2]
    top = shore * (0.46 + 0.44 * near) - h * (0.085 - 0.055 * near) * noise(rng, (w,), 1.35 - 0.25 * near)
    y = np.arange(h)[:, None]
    depth = (y - top) / h
    relief = noise(rng, (h, w), 1.35)
    slope = 0.6 * np.gradient(relief, axis=0) - np.gradient(relief, axis=1)
    shade = np.tanh(1.3 * slope / slope.std()) - 0.3 * np.tanh(0.9 * np.gradient(top)) * (1 - _ramp(depth, 0, 0.12))
    rock = _mixed(_ROCK, _MOSS, near) + 0.03 * noise(rng, (h, w), 1.2)[..., None]
    forest = 0.8 * _ramp(depth + 0.03 * relief, 0.14 - 0.12 * near, 0.26 - 0.2 * near)
    snow = 0.9 * (1 - _ramp(depth + 0.018 * relief, 0.015, 0.07)) * (near < 0.4)
    ground = _mixed(_mixed(rock, _FOREST, forest), _SNOW, snow) * (0.92 + 0.36 * shade[..., None])
    ground = _mixed(ground, _HAZE, 0.72 * (1 - near) ** 1.2)
    return np.where(((depth > 0) & (y < shore))[..., None], ground, scene)


def _lake(rng: np.random.Generator, scene: np.ndarray, shore: int) -> np.ndarray:
    """Everything below the shore mirrors what is above it, in waves that grow towards us."""
    h, w = scene.shape[:2]
    y, x = np.mgrid[shore:h, 0:w]
    close = (y - shore) / (h - shore)
    waves = noise(rng, (h - shore, w), 1.1, 6.0)
    row = np.clip(2 * shore - y - 1 + waves * (1.5 + 9 * close), 0, shore - 1).astype(int)
    column = np.clip(x + waves * (0.6 + 3 * close), 0, w - 1).astype(int)
    water = _mixed(0.82 * scene[row, column], _WATER, 0.16 + 0.42 * close)
    water = water + (0.05 * waves * (0.4 + close))[..., None]
    return np.concatenate([scene[:shore], water])


def _meadow(rng: np.random.Generator, scene: np.ndarray, top: int) -> np.ndarray:
    """Grass and flowers in front, higher at both sides."""
    h, w = scene.shape[:2]
    edge = top + h * (0.04 + 0.05 * noise(rng, (w,), 1.5) - 0.10 * np.linspace(-1, 1, w) ** 2)
    depth = (np.arange(h)[:, None] - edge) / h
    blades = noise(rng, (w, h), 0.75, 4.0).T
    green = _mixed(_GRASS, _STRAW, _ramp(noise(rng, (h, w), 1.3), -1.4, 1.6))
    green = green * (1 + 0.3 * blades + 0.1 * _ramp(depth, 0, 0.15))[..., None]
    return _flowers(rng, np.where((depth > 0)[..., None], green, scene), edge)


def _flowers(rng: np.random.Generator, scene: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """Dots in drifts of a colour, larger the closer they are; `edge` (w,) is the row where the meadow begins."""
    h, w = scene.shape[:2]
    drifts, tints = noise(rng, (h, w), 1.4), noise(rng, (h, w), 1.2)
    for _ in range(w * h // 190):
        x, close = int(rng.integers(0, w)), rng.random() ** 0.8
        y, radius = int(edge[x] + 4 + close * (h - edge[x])), 1.0 + 2.6 * close
        if not 0 <= y < h or drifts[y, x] < -0.2:
            continue
        rows, columns = slice(max(0, y - 4), y + 5), slice(max(0, x - 4), x + 5)
        v, u = np.mgrid[rows.start : min(rows.stop, h), columns.start : min(columns.stop, w)]
        petals = 0.9 * (1 - _ramp(np.hypot(u - x, 1.3 * (v - y)), radius - 0.9, radius + 0.1))
        tint = _PETALS[int(np.clip(2.5 + 1.6 * tints[y, x] + rng.normal(0, 0.6), 0, 4))]
        scene[rows, columns] = _mixed(scene[rows, columns], tint * (0.85 + 0.3 * rng.random()), petals)
    return scene
