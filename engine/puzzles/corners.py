"""Corners of square pieces as elements that MatchLift matches (thesis, chapter 4).

Piece i has the corners 4 i + k, k clockwise from the top left: corner k is where side k begins. The thesis numbers
them I, III, IV, II. All corners that meet at one point of the assembled picture are one element of the universe, so a
frame of R × C pieces has (R + 1)(C + 1) of them; every piece is an object, whose four corners all differ.
"""

import numpy as np

from .halves import least_of_halves, meeting_halves, smallest_unit


def meeting_corners(rows: np.ndarray) -> np.ndarray:
    """The corners that come together where the sides of `rows` (c, 2) meet, (c, 2, 2) int64: [:, k] by the k-th halves."""
    side, second = np.divmod(meeting_halves(rows), 2)
    return 4 * (side // 4) + (side + second) % 4


def universe_of(columns: int, rows: int) -> int:
    """m: the points of the grid of a picture that is so many pieces wide and high."""
    return (columns + 1) * (rows + 1)


def corner_similarity(rows: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Similarity (c, 2) in (0, 1] of the halves of candidates from their dissimilarity (c, 2).

    (min(least of either half) + ε) / (D + ε): 1 iff each is the best of the other. Thresholds t1 in .6 to 1 then cut.
    """
    least = least_of_halves(rows, halves)[meeting_halves(rows)].min(axis=2)
    epsilon = smallest_unit(halves)
    return (least + epsilon) / (halves + epsilon)


def corner_matrix(rows: np.ndarray, similarity: np.ndarray, count: int, *, t_1: float) -> np.ndarray:
    """M (4 n, 4 n) of Eq 4.5 without its diagonal: the similarities >= t1 of the corners of n pieces, symmetric."""
    corners, kept = meeting_corners(rows), similarity >= t_1
    a, b = corners[kept].T
    matrix = np.zeros((4 * count, 4 * count))
    np.maximum.at(matrix, (np.r_[a, b], np.r_[b, a]), np.tile(similarity[kept], 2))
    return matrix


def unlike_corners(count: int, *, turned: bool) -> list[np.ndarray]:
    """Labels (4 n,) that two corners which meet never share: their piece, and their kind if no piece is turned (Eq 4.4)."""
    corner = np.arange(4 * count)
    return [corner // 4] if turned else [corner // 4, corner % 4]


def join_confidence(rows: np.ndarray, matches: np.ndarray) -> np.ndarray:
    """Confidence (c, 2) of the halves of candidates: the lifted matches (4 n, 4 n) of the corners where they meet."""
    corners = meeting_corners(rows)
    return matches[corners[:, :, 0], corners[:, :, 1]]
