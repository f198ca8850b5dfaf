"""Where the sides of two placed polygons touch, and how well the pixels along the contact continue each other.

All functions here are compiled and work on a `Ground`: the sides and masks of all pieces as plain arrays.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .measures import _DUMMIES, EMD, LPQ, MGC, MGC_PT, MGC_ROOT, PT, SSD, P, Q, emd, lpq, mgc, predicted_l1, ssd
from .pieces import Piece
from .subedges import Sides

LEARNED = -1  # the code of the learned measure
FEATURES = 9  # of a contact under the learned measure; the first WITHIN of them under any other
WITHIN = 3
SHORTEST = 4.0  # pixels of a contact that says something


class Ground(NamedTuple):
    """Everything compiled loops need to know of n pieces with s sides.

    Of the sides: `first` (n+1,), `start` and `end` (s, 4, 2) by quarter turns, `strip` (s+1,), `outer` and `inner`
    (p, 3) float32, `step` and `reach` (s,), as in `Sides`. Of the pieces: `size` (n, 2) int64 (w, h) unturned,
    `full` (n,) bool whether the mask fills the raster, `mask` (q,) bool row by row from `mask_first` (n,).
    `slack` is how many pixels an outline may be off, 0 where all outlines are exact. `code` is the measure,
    `form` (k+1, k+1) float64 its quadratic form of log odds.
    """

    first: np.ndarray
    start: np.ndarray
    end: np.ndarray
    strip: np.ndarray
    outer: np.ndarray
    inner: np.ndarray
    step: np.ndarray
    reach: np.ndarray
    size: np.ndarray
    full: np.ndarray
    mask: np.ndarray
    mask_first: np.ndarray
    slack: float
    code: int
    form: np.ndarray


def ground_of(
    pieces: tuple[Piece, ...], sides: Sides, outer: np.ndarray, inner: np.ndarray, *, slack: float, code: int, form: np.ndarray
) -> Ground:  # fmt: skip
    """Gather the arrays; `outer` and `inner` are the samples in the colours of the measure."""
    areas = np.array([piece.mask.size for piece in pieces])
    return Ground(
        sides.first, sides.start, sides.end, sides.strip, np.ascontiguousarray(outer), np.ascontiguousarray(inner),
        sides.step, sides.reach, np.array([piece.mask.shape[::-1] for piece in pieces]),
        np.array([bool(piece.mask.all()) for piece in pieces]), np.concatenate([piece.mask.ravel() for piece in pieces]),
        np.concatenate([[0], np.cumsum(areas)[:-1]]), slack, code, form,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def touching(g, e, te, f, tf, dx, dy):  # type: ignore[no-untyped-def]
    """The contact of side e (its piece turned te) with side f (turned tf, its raster moved by (dx, dy)).

    Returns (n, i, j): the samples i..i+n-1 of e lie on the samples j..j+n-1 of f, read backwards; n = 0 for none.
    """
    px, py = g.start[e, te, 0], g.start[e, te, 1]
    ax, ay = g.end[e, te, 0] - px, g.end[e, te, 1] - py
    qx, qy = g.start[f, tf, 0] + dx - px, g.start[f, tf, 1] + dy - py
    rx, ry = g.end[f, tf, 0] + dx - px, g.end[f, tf, 1] + dy - py
    bx, by = rx - qx, ry - qy
    length, other = np.sqrt(ax * ax + ay * ay), np.sqrt(bx * bx + by * by)
    off = g.slack + 0.01
    if ax * bx + ay * by >= 0 or abs(ax * by - ay * bx) > off * max(length, other, 1.0) + off * min(length, other):
        return 0, 0, 0
    ax, ay = ax / length, ay / length
    if abs(ax * qy - ay * qx) > 1.5 * off and abs(ax * ry - ay * rx) > 1.5 * off:
        return 0, 0, 0
    near, far = rx * ax + ry * ay, qx * ax + qy * ay  # where f ends and starts along e
    low, high = max(0.0, near), min(length, far)
    if high - low < SHORTEST:
        return 0, 0, 0
    i, j = round(low / g.step[e]), round((far - high) / g.step[f])
    n = round((high - low) / g.step[e])
    n = min(n, g.strip[e + 1] - g.strip[e] - i, g.strip[f + 1] - g.strip[f] - j)
    return max(n, 0), i, j


@njit(cache=True, nogil=True)
def statistics(outer, inner, mean, inverse):  # type: ignore[no-untyped-def]
    """μ and S⁻¹ of the gradients of a strip (n, 3), the dummies in S only; written into `mean` and `inverse`."""
    n, m = len(outer), len(outer) + len(_DUMMIES)
    s = np.zeros((3, 3))
    for k in range(3):
        total = 0.0
        for p in range(n):
            total += outer[p, k] - inner[p, k]
        mean[k] = total
    c0, c1, c2 = mean[0] / m, mean[1] / m, mean[2] / m
    for p in range(m):
        if p < n:
            x, y, z = outer[p, 0] - inner[p, 0] - c0, outer[p, 1] - inner[p, 1] - c1, outer[p, 2] - inner[p, 2] - c2
        else:
            x, y, z = _DUMMIES[p - n, 0] - c0, _DUMMIES[p - n, 1] - c1, _DUMMIES[p - n, 2] - c2
        s[0, 0] += x * x
        s[1, 1] += y * y
        s[2, 2] += z * z
        s[0, 1] += x * y
        s[0, 2] += x * z
        s[1, 2] += y * z
    for k in range(3):
        mean[k] /= n
    _invert(s, m - 1.0, inverse)


@njit(cache=True, nogil=True)
def _invert(s, scale, inverse):  # type: ignore[no-untyped-def]
    """The inverse of the symmetric 3×3 matrix s / scale, of which the upper half is read."""
    a, b, c, d, e, f = s[0, 0], s[0, 1], s[0, 2], s[1, 1], s[1, 2], s[2, 2]
    x, y, z = d * f - e * e, c * e - b * f, b * e - c * d
    by = scale / (a * x + b * y + c * z)
    inverse[0, 0], inverse[0, 1], inverse[0, 2] = x * by, y * by, z * by
    inverse[1, 0], inverse[1, 1], inverse[1, 2] = y * by, (a * f - c * c) * by, (b * c - a * e) * by
    inverse[2, 0], inverse[2, 1], inverse[2, 2] = z * by, (b * c - a * e) * by, (a * d - b * b) * by


@njit(cache=True, nogil=True)
def _sorted(a):  # type: ignore[no-untyped-def]
    """A strip (n, 3), each channel sorted on its own."""
    result = np.empty_like(a)
    for k in range(3):
        result[:, k] = np.sort(a[:, k])
    return result


@njit(cache=True, nogil=True)
def unlikeness(code, a, a_in, b, b_in, seam):  # type: ignore[no-untyped-def]
    """The measure `code` of two strips (n, 3), the second read backwards, per sample; `seam` is their distance."""
    n = len(a)
    if code == SSD:
        return ssd(a, b) / n
    if code == LPQ:
        return lpq(a, a_in, b, b_in) / n ** (Q / P)
    if code == PT:
        return predicted_l1(a, a_in, b, b_in) / n
    if code == EMD:
        return emd(_sorted(a), _sorted(b), 1)
    mean_a, mean_b = np.empty(3), np.empty(3)
    inverse_a, inverse_b = np.empty((3, 3)), np.empty((3, 3))
    statistics(a, a_in, mean_a, inverse_a)
    statistics(b, b_in, mean_b, inverse_b)
    mean_a *= seam
    mean_b *= seam
    value = mgc(a, mean_a, inverse_a, b, mean_b, inverse_b, 1.0, code != MGC) / n
    return value * np.sqrt(predicted_l1(a, a_in, b, b_in) / n + 1e-3) if code == MGC_PT else value


@njit(cache=True, nogil=True)
def contact_features(code, a, a_in, b, b_in, seam, z):  # type: ignore[no-untyped-def]
    """Features of a contact of two strips (n, 3), the second read backwards, written into z.

    The measure, the activity (how much neighbouring samples differ, across and along the seam) and the length; for
    the learned measure also the border predicted one step outwards, the changes along the seam against each other,
    the plain and the mean differences and the activity across alone. All these are logarithms; last comes the distance
    of the strips.
    """
    n = len(a)
    across, along, changes, predicted, squares, shift = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        total = 0.0
        for p in range(n):
            o = n - 1 - p
            x, y, x_in, y_in = np.float64(a[p, k]), np.float64(b[o, k]), np.float64(a_in[p, k]), np.float64(b_in[o, k])
            across += abs(x - x_in) + abs(y - y_in)
            predicted += abs(x + (x - x_in) * seam - y) + abs(y + (y - y_in) * seam - x)
            squares += (y - x) ** 2
            total += y - x
            if p:
                dx, dy = x - a[p - 1, k], y - b[o + 1, k]
                along += abs(dx) + abs(dy)
                changes += abs(dx - dy)
        shift += abs(total)
    m = max(n - 1, 1)
    z[0] = np.log(unlikeness(MGC_ROOT if code == LEARNED else code, a, a_in, b, b_in, seam) + 0.1)
    z[1] = np.log(across / n + along / m + 1)
    z[2] = np.log(n)
    if code == LEARNED:
        z[3] = np.log(predicted / n + 1)
        z[4] = np.log(changes / m + 1)
        z[5] = np.log(np.sqrt(squares / n) + 1)
        z[6] = np.log(shift / n + 1)
        z[7] = np.log(across / n + 1)
        z[8] = seam


@njit(cache=True, nogil=True)
def log_odds(form, z):  # type: ignore[no-untyped-def]
    """The quadratic form (1, z)ᵀ Q (1, z), Q (k+1, k+1) stored as its upper triangle."""
    k, total = len(form) - 1, form[0, 0]
    for i in range(k):
        total += form[0, i + 1] * z[i]
        for j in range(i, k):
            total += form[i + 1, j + 1] * z[i] * z[j]
    return total


@njit(cache=True, nogil=True)
def features_of(g, e, i, f, j, n, z):  # type: ignore[no-untyped-def]
    """Features of the contact of n samples from i on side e and from j on side f."""
    p, q = g.strip[e] + i, g.strip[f] + j
    a, b = slice(p, p + n), slice(q, q + n)
    contact_features(g.code, g.outer[a], g.inner[a], g.outer[b], g.inner[b], g.reach[e] + g.reach[f], z)


@njit(cache=True, nogil=True)
def side_odds(g, e, i, f, j, n, z):  # type: ignore[no-untyped-def]
    """Log odds that the contact of n samples from i on side e and from j on side f is a true one (z is scratch)."""
    features_of(g, e, i, f, j, n, z)
    return log_odds(g.form, z)


@njit(cache=True, nogil=True)
def overlapping(g, a, ta, b, tb, dx, dy):  # type: ignore[no-untyped-def]
    """Whether piece b (turned tb, moved by (dx, dy)) covers pixels of piece a (turned ta), beyond the slack."""
    wa, ha = g.size[a, ta % 2], g.size[a, 1 - ta % 2]
    wb, hb = g.size[b, tb % 2], g.size[b, 1 - tb % 2]
    w, h = min(wa, dx + wb) - max(0, dx), min(ha, dy + hb) - max(0, dy)
    if w <= 0 or h <= 0:
        return False
    most = g.slack * max(w, h)
    return shared_pixels(g, a, ta, b, tb, dx, dy, most) > most


@njit(cache=True, nogil=True)
def shared_pixels(g, a, ta, b, tb, dx, dy, most):  # type: ignore[no-untyped-def]
    """The number of pixels that both pieces cover, counted until there are more than `most`."""
    wa, ha = g.size[a, ta % 2], g.size[a, 1 - ta % 2]
    wb, hb = g.size[b, tb % 2], g.size[b, 1 - tb % 2]
    left, top, right, bottom = max(0, dx), max(0, dy), min(wa, dx + wb), min(ha, dy + hb)
    if left >= right or top >= bottom:
        return 0
    if g.full[a] and g.full[b]:
        return (right - left) * (bottom - top)
    both = 0
    for y in range(top, bottom):
        for x in range(left, right):
            if _belongs(g, a, ta, x, y) and _belongs(g, b, tb, x - dx, y - dy):
                both += 1
                if both > most:
                    return both
    return both


@njit(cache=True, nogil=True)
def _belongs(g, i, turns, x, y):  # type: ignore[no-untyped-def]
    """Whether the pixel (x, y) of the raster of piece i after quarter turns belongs to it."""
    if g.full[i]:
        return True
    w, h = g.size[i]
    if turns == 1:
        x, y = y, h - 1 - x
    elif turns == 2:
        x, y = w - 1 - x, h - 1 - y
    elif turns == 3:
        x, y = w - 1 - y, x
    return g.mask[g.mask_first[i] + y * w + x]


@njit(cache=True, nogil=True)
def all_odds(form, features):  # type: ignore[no-untyped-def]
    """Log odds (c,) of contacts with features (c, k)."""
    result = np.empty(len(features))
    for k in range(len(features)):
        result[k] = log_odds(form, features[k])
    return result
