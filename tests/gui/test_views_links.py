from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage, QPainter

from gui.palette import DARK, LIGHT
from gui.views.links import apart, folded, hit_inside, hit_outline, lay_out
from gui.views.painting import line_width, paint_links
from gui.views.planar import contains, convex_hull, distance_to_segments, polygon_area
from gui.views.scene import Link

SOURCE, TARGET = np.array([[10.0, 10], [10, 90]]), np.array([[210.0, 10], [210, 90]])
SEEN = np.ones(2, bool)


def placed(*links, source_seen=SEEN):
    return lay_out(links, SOURCE, source_seen, TARGET, SEEN)


def test_distance_from_a_segment():
    a, b = np.array([[0.0, 0], [0, 0], [5, 5]]), np.array([[10.0, 0], [0, 10], [5, 5]])
    assert distance_to_segments(np.array([4.0, 3.0]), a, b) == pytest.approx([3, 4, 5**0.5])
    assert distance_to_segments(np.array([13.0, 4.0]), a[:1], b[:1]) == pytest.approx([5])


def test_hull_drops_inner_points_and_turns_counter_clockwise():
    hull = convex_hull(np.array([[0.0, 0], [4, 0], [4, 4], [0, 4], [1, 2], [2, 0]]))
    assert len(hull) == 4
    assert polygon_area(hull) == pytest.approx(16)
    assert contains(hull, np.array([1.0, 1.0]))
    assert not contains(hull, np.array([5.0, 1.0]))


def test_points_on_a_line_have_a_flat_hull():
    assert convex_hull(np.array([[0.0, 0], [1, 1], [2, 2]])).tolist() == [[0, 0], [2, 2]]


def test_a_click_hits_the_nearest_line_within_reach():
    shapes = placed(Link("top", (0,), (0,)), Link("bottom", (1,), (1,)))
    assert hit_outline(shapes, np.array([100.0, 13.0])) == "top"
    assert hit_outline(shapes, np.array([100.0, 86.0])) == "bottom"
    assert hit_outline(shapes, np.array([100.0, 50.0])) is None
    close = placed(Link("level", (0,), (0,)), Link("slanted", (0,), (1,)))
    assert hit_outline(close, np.array([18.0, 10.5])) == "level"
    assert hit_outline(close, np.array([18.0, 13.0])) == "slanted"
    assert hit_outline(shapes, np.array([100.0, 16.0])) is None


def test_the_symbol_of_a_judged_link_is_hit_too():
    judged, plain = placed(Link("a", (0,), (0,), "correct")), placed(Link("a", (0,), (0,)))
    at = judged[0].symbol + np.array([0, 9])
    assert hit_outline(judged, at) == "a"
    assert hit_outline(plain, at) is None


def test_inside_a_polygon_the_smallest_is_hit():
    big, small = Link("big", (0, 1), (0, 1), merged=True), Link("small", (0, 1), (1,), merged=True)
    shapes = placed(big, small)
    assert len(shapes[0].outline) == 4
    assert len(shapes[1].outline) == 3
    assert hit_inside(shapes, np.array([40.0, 60.0])) == "small"
    assert hit_inside(shapes, np.array([200.0, 20.0])) == "big"
    assert hit_inside(shapes, np.array([300.0, 50.0])) is None


def test_symbols_do_not_cover_each_other():
    links = [Link(str(i), (0,), (0,), "correct") for i in range(5)]
    places = np.array([shape.symbol for shape in placed(*links)])
    gaps = np.abs(places[:, None] - places[None]).sum(axis=2)[~np.eye(5, dtype=bool)]
    assert gaps.min() > 16


def test_a_link_is_hidden_when_a_whole_side_is():
    hidden = np.array([False, True])
    line, union = placed(Link("a", (0,), (0,)), Link("b", (0, 1), (0,), merged=True), source_seen=hidden)
    assert line.hidden
    assert not union.hidden
    assert union.seen.tolist() == [False, True, True]


def test_of_nested_unions_the_small_ones_stay_unfolded():
    whole, pair, other, single = (
        Link("whole", (0, 1, 2), (0, 1, 2), merged=True),
        Link("pair", (0, 1), (1,), merged=True),
        Link("other", (2,), (0, 2), merged=True),
        Link("single", (0,), (1,)),
    )
    assert apart([whole, pair, other]) == [pair, other]
    assert apart([pair, Link("better", (1,), (0, 1))])[0].id == "better"
    assert folded([whole, single, pair, other]) == {"whole"}


def test_a_folded_polygon_is_a_line_between_the_middles():
    link = Link("m", (0, 1), (0, 1), merged=True)
    (shape,) = lay_out([link], SOURCE, SEEN, TARGET, SEEN, {"m"})
    assert shape.outline.tolist() == [[10, 50], [210, 50]]
    assert hit_outline([shape], np.array([100.0, 52.0])) == "m"
    assert hit_inside([shape], np.array([100.0, 60.0])) is None


def test_no_line_crosses_the_symbol_of_a_judged_link(qapp):
    judged, later = Link("judged", (0,), (0,), "correct"), Link("later", (0,), (0,), "wrong")
    shapes = placed(judged, later)
    shapes = [replace(shape, symbol=np.array([60.0 + 80 * k, 10.0])) for k, shape in enumerate(shapes)]
    image = QImage(220, 100, QImage.Format.Format_RGB32)
    image.fill(QColor(LIGHT.paper))
    painter = QPainter(image)
    paint_links(painter, shapes, LIGHT)
    painter.end()
    discs = [[image.pixelColor(x + dx, 10).name().upper() for dx in (-6, 6)] for x in (60, 140)]
    assert discs == [[LIGHT.state("correct").upper()] * 2, [LIGHT.state("wrong").upper()] * 2]


@pytest.mark.parametrize("colours", [LIGHT, DARK])
def test_a_pinned_link_has_the_head_of_a_pin_and_is_thicker(qapp, colours):
    plain, pinned, judged = (Link("a", (0,), (0,)), Link("b", (0,), (0,), pinned=True), Link("c", (0,), (0,), "correct", pinned=True))
    shapes = placed(plain, pinned, judged)
    assert line_width(shapes[1], False) > line_width(shapes[0], False)
    shapes = [replace(shape, symbol=np.array([60.0 + 60 * k, 50.0])) for k, shape in enumerate(shapes[1:])]
    image = QImage(220, 100, QImage.Format.Format_RGB32)
    image.fill(QColor(colours.paper))
    painter = QPainter(image)
    paint_links(painter, shapes, colours)
    painter.end()

    def distance(x, y, colour):
        have, want = image.pixelColor(x, y), QColor(colour)
        return sum(abs(a - b) for a, b in zip(have.getRgb()[:3], want.getRgb()[:3], strict=True))

    assert distance(60, 50, colours.paper) < distance(60, 50, colours.ink)  # a hole
    assert distance(67, 50, colours.ink) < distance(67, 50, colours.paper)  # in a disc
    assert distance(126, 50, colours.state("correct")) < distance(126, 50, colours.paper)
    assert distance(40, 50, colours.paper) == 0
