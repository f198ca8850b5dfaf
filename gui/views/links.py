"""Geometry of links in the picture: where they run, which one is hit, and where their symbols find room. No Qt."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from engine.shapes.result import MatchResult
from engine.shapes.summary import implied

from .planar import contains, convex_hull, distance_to_segments, polygon_area
from .scene import Link, links_of

REACH = 5.0
SYMBOL_ROOM = 19.0
_MOST_MARKS = 60
_ALONG = (0.5, 0.44, 0.56, 0.38, 0.62, 0.32, 0.68, 0.26, 0.74)


@dataclass(frozen=True, slots=True, eq=False)
class LinkShape:
    """A link in the picture, in logical pixels.

    `ends` (2, 2) are the two ends of a line or the middles of both sides of a polygon; `outline` (p, 2) is the line or
    the polygon; `dots` (q, 2) the anchors of all its segments, seen or not (`seen` (q,) bool), those of the source
    first; `hidden` says that a whole side is out of sight; `symbol` (2,) is the place of its mark;
    a `folded` polygon is drawn as a thin line.
    """

    link: Link
    ends: np.ndarray
    outline: np.ndarray
    dots: np.ndarray
    seen: np.ndarray
    hidden: bool
    symbol: np.ndarray
    folded: bool


def lay_out(
    links: Sequence[Link],
    source: np.ndarray,
    source_seen: np.ndarray,
    target: np.ndarray,
    target_seen: np.ndarray,
    folded: Collection[str] = (),
) -> list[LinkShape]:
    """Place links, given the projected anchors (s, 2), (t, 2) of all segments and which are seen (s,), (t,) bool.

    Those whose id is in `folded` become thin lines.
    """
    shapes: list[LinkShape] = []
    taken: list[tuple[float, float]] = []
    for link in links:
        a, b = list(link.source), list(link.target)
        dots = np.concatenate([source[a], target[b]])
        seen = np.concatenate([source_seen[a], target_seen[b]])
        ends = np.stack([source[a].mean(axis=0), target[b].mean(axis=0)])
        symbol = _free_place(ends, taken) if signed(link) else ends.mean(axis=0)
        if signed(link):
            taken.append((float(symbol[0]), float(symbol[1])))
        hidden = not (seen[: len(a)].any() and seen[len(a) :].any())
        fold = link.id in folded
        outline = convex_hull(dots) if link.merged and not fold else ends
        shapes.append(LinkShape(link, ends, outline, dots, seen, hidden, symbol, fold))
    return shapes


def apart(links: Sequence[Link]) -> list[Link]:
    """Links of which no two share a segment on either side, in the given order.

    Fewest segments first, then the later ones, which are drawn on top: of nested unions the small ones say most.
    """
    order = sorted(range(len(links)), key=lambda row: (len(links[row].source) + len(links[row].target), -row))
    chosen: list[int] = []
    taken: tuple[set[int], set[int]] = (set(), set())
    for row in order:
        if not (taken[0].intersection(links[row].source) or taken[1].intersection(links[row].target)):
            chosen.append(row)
            taken[0].update(links[row].source)
            taken[1].update(links[row].target)
    return [links[row] for row in sorted(chosen)]


def main_links(result: MatchResult) -> list[Link]:
    """The links to show first, the best last: one-to-one ones, and merged ones that do not follow from smaller ones and
    of which no two share a segment."""
    links = links_of(result)
    follows = implied(result.source_members, result.target_members)[::-1]
    new = apart([link for link, old in zip(links, follows, strict=True) if link.merged and not old])
    kept = {link.id for link in new}
    return [link for link in links if not link.merged or link.id in kept]


def folded(links: Sequence[Link]) -> frozenset[str]:
    """Ids of the polygons that would lie over others: all but a set of which no two share a segment."""
    merged = [link for link in links if link.merged]
    return frozenset(link.id for link in merged) - {link.id for link in apart(merged)}


def marked(link: Link) -> bool:
    """Whether a link is judged, and so drawn in the colour of its state."""
    return link.state != "undecided"


def signed(link: Link) -> bool:
    """Whether a link carries a symbol: once it is judged or pinned."""
    return marked(link) or link.pinned


def _free_place(ends: np.ndarray, taken: Sequence[tuple[float, float]]) -> np.ndarray:
    """The place along a link nearest to its middle where its symbol covers none of the last ones, or the middle."""
    near = taken[-_MOST_MARKS:]
    for t in _ALONG:
        x, y = ((1 - t) * ends[0] + t * ends[1]).tolist()
        if all(abs(x - u) + abs(y - v) > SYMBOL_ROOM for u, v in near):
            return np.array([x, y])
    return ends.mean(axis=0)


def hit_outline(shapes: Sequence[LinkShape], point: np.ndarray, reach: float = REACH) -> str | None:
    """The link whose line, outline or symbol is nearest to a point, within `reach` pixels; None if there is none.

    Of links equally near the later one, which is drawn on top, is hit.
    """
    best, best_distance = None, reach
    for shape in shapes:
        corners = shape.outline
        distance = float(distance_to_segments(point, corners, np.roll(corners, -1, axis=0)).min())
        if signed(shape.link):
            distance = min(distance, max(0.0, float(np.hypot(*(shape.symbol - point))) - SYMBOL_ROOM / 2 + 1))
        if distance <= best_distance:
            best, best_distance = shape.link.id, distance
    return best


def hit_inside(shapes: Sequence[LinkShape], point: np.ndarray) -> str | None:
    """The smallest polygonal link that a point lies in, or None."""
    inside = [s for s in shapes if s.link.merged and not s.folded and contains(s.outline, point)]
    return min(inside, key=lambda s: polygon_area(s.outline)).link.id if inside else None
