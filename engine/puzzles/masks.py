"""Where a piece is in its image: the transparent or plain ground around it is told apart and taken away."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import ndimage as _ndimage

from .pieces import rectangle
from .tracing import trace, whole

ndimage: Any = _ndimage  # its functions are not seen by type checkers
SEEN = 128  # alpha from which a pixel belongs to a piece
HALO = 3  # pixels that a halo may be wide
CRISP, ROUGH = 1.2, 3.0  # pixels a boundary may stray from its side: cut by a program, and by hand or by a scanner


def plain_ground(images: Sequence[np.ndarray]) -> tuple[np.ndarray, float] | None:
    """The colour (3,) that all opaque images (h, w, 4) stand on and how far a pixel may be from it, or None.

    The borders of the images must be of one colour in all of them (three quarters of each border, nearly all of half
    of them), and what differs must be one thing of some size in each.
    """
    borders = [_border(image) for image in images]
    colour = np.median(np.concatenate(borders), axis=0)
    away = [np.abs(border - colour).max(axis=1) for border in borders]
    reach = float(np.clip(3 * np.quantile(np.concatenate([np.sort(a)[: len(a) * 3 // 4] for a in away]), 0.95), 12, 48))
    plain = np.array([(a <= reach).mean() for a in away])
    if plain.min() < 0.75 or np.median(plain) < 0.95:
        return None
    for image in images:
        mask, second = whole(standing_out(image, colour, reach))
        if mask.mean() < 0.05 or second > 0.2:
            return None
    return colour, reach


def _border(image: np.ndarray) -> np.ndarray:
    sides = (image[0], image[-1], image[1:-1, 0], image[1:-1, -1])
    return np.concatenate([side[..., :3] for side in sides]).astype(np.float64)


def standing_out(image: np.ndarray, colour: np.ndarray, reach: float) -> np.ndarray:
    """What is not the ground, (h, w) bool: the ground is like `colour` and reaches the border of the image.

    The halo that JPEG and scanners draw around a piece, faint beside what lies further in, is not part of it.
    """
    away = np.abs(image[..., :3] - colour.astype(np.float32)).max(axis=2)
    labels, _ = ndimage.label(np.pad(away <= reach, 1, constant_values=True))
    body = (labels != labels[0, 0])[1:-1, 1:-1]
    rim = body & ~ndimage.binary_erosion(body, iterations=HALO)
    return body & ~(rim & (away < 0.25 * ndimage.maximum_filter(away, 2 * HALO + 1)))


def is_rectangle(mask: np.ndarray) -> bool:
    """Whether a mask cropped to its bounds is an upright rectangle, but for a rough border of 2 pixels or 2 %."""
    rough_y, rough_x = (max(2, round(0.02 * side)) for side in mask.shape)
    inner = mask[rough_y:-rough_y, rough_x:-rough_x]
    return bool(mask.all() or (inner.size > 0.5 * mask.size and inner.all()))


def unbitten(mask: np.ndarray) -> np.ndarray:
    """The convex hull of a mask that nearly fills it: a convex piece into whose border pale spots bite; else the mask."""
    import cv2

    hull = cv2.convexHull(np.argwhere(mask)[:, ::-1].astype(np.int32))
    filled = np.asarray(cv2.fillConvexPoly(np.zeros(mask.shape, dtype=np.uint8), hull, 1)).astype(bool)
    return filled if mask.sum() >= 0.95 * filled.sum() else mask


def without_rough_border(mask: np.ndarray) -> tuple[slice, slice]:
    """The rows and columns of a rectangle after the border rows and columns that it fills by less than 90 %."""
    y0, x0, (y1, x1) = 0, 0, mask.shape
    while True:
        filled = (
            mask[y0, x0:x1].mean(),
            mask[y1 - 1, x0:x1].mean(),
            mask[y0:y1, x0].mean(),
            mask[y0:y1, x1 - 1].mean(),
        )
        least = int(np.argmin(filled))
        if filled[least] >= 0.9:
            return slice(y0, y1), slice(x0, x1)
        y0, y1, x0, x1 = y0 + (least == 0), y1 - (least == 1), x0 + (least == 2), x1 - (least == 3)


def polygon_of(mask: np.ndarray, *, scanned: bool) -> np.ndarray:
    """The polygon (v, 2) of a mask in one part.

    Exact where a program has cut it, from a smoothed border where it is rough: where that takes fewer corners if the
    piece was `scanned`, else only where it takes far fewer.
    """
    if mask.all():
        return rectangle(mask.shape[1], mask.shape[0])
    crisp = trace(mask, roughness=CRISP)
    smooth, _ = whole(ndimage.gaussian_filter(np.pad(mask, 4).astype(np.float32), 1.0)[4:-4, 4:-4] > 0.5)
    if len(crisp) == 3 or not smooth.any():
        return crisp
    rough = trace(smooth, roughness=max(ROUGH, 0.012 * float(np.hypot(*mask.shape))))
    return crisp if len(crisp) <= len(rough) + (0 if scanned else 2) else rough
