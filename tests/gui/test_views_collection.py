"""Tiles, their colours and where they stand."""

import numpy as np
import pytest

from gui.palette import DARK, LIGHT, rgb, segment_colours
from gui.views.collection_layout import CAPTION, GAP, SMALLEST, corner, grid_for, next_part, tile_at
from gui.views.scene import prepare
from gui.views.tiles import FINE, WHITE, Tile, TileMaker, coloured, groups, part_colours, segment_at


def test_every_tile_fits_and_none_overlap():
    for count in (1, 2, 3, 5, 12):
        grid = grid_for(count, 900, 700)
        places = [corner(grid, row) for row in range(count)]
        assert len(set(places)) == count
        for left, top in places:
            assert left >= GAP
            assert left + grid.side <= 900
            assert top - CAPTION >= 0
            assert top + grid.side <= grid.height <= 700 + GAP


def test_many_tiles_are_scrolled_to_and_never_too_small():
    grid = grid_for(200, 900, 700)
    assert grid.side >= SMALLEST
    assert grid.height > 700
    assert grid_for(3, 100, 700).columns == 1


def test_tile_at_is_the_inverse_of_corner():
    grid = grid_for(7, 900, 700)
    for row in range(7):
        left, top = corner(grid, row)
        found, x, y = tile_at(grid, 7, left + grid.side / 2, top + grid.side / 4)
        assert (found, x, y) == (row, 0.5, 0.25)
        assert tile_at(grid, 7, left + 2, top - 5)[2] < 0
    assert tile_at(grid, 7, 1, 1) is None


def test_parts_are_stepped_through_with_none_between():
    assert [next_part(np.arange(3), now, 1) for now in (-1, 0, 1, 2)] == [0, 1, 2, -1]
    assert next_part(np.arange(3), -1, -1) == 2
    assert next_part(np.arange(0), 5, 1) == -1


def test_colours_of_parts():
    parts = np.array([1, -1, 0])
    table = segment_colours(2)
    assert np.array_equal(part_colours(parts, LIGHT), [table[1], rgb(LIGHT.faded), table[0]])
    assert np.array_equal(part_colours(parts, DARK, lit=0), [rgb(DARK.faded), rgb(DARK.faded), table[0]])
    assert len(set(groups(np.array([-1, -1, 0, 0])).tolist())) == 3


def test_a_tile_is_coloured_picked_and_lined():
    segments = np.full((8, 8), -1, np.int16)
    segments[:, 2:4], segments[:, 4:6] = 0, 1
    tile = Tile(np.full((8, 8), WHITE, np.uint8), segments)
    colours = np.array([[200, 0, 0], [0, 200, 0]], np.uint8)
    apart, together = (coloured(tile, colours, np.array(group), LIGHT) for group in ([0, 1], [0, 0]))
    assert apart.width() == 8 // FINE
    assert together.pixelColor(1, 1).getRgb()[:3] == (200, 0, 0)
    assert together.pixelColor(0, 1).name().upper() == LIGHT.paper
    assert apart.pixelColor(1, 1).red() < 200  # half of it is the line between the two
    assert [segment_at(tile, x, 0.5) for x in (0.0, 0.3, 0.6, 0.99, 1.5)] == [-1, 0, 1, -1, -1]


@pytest.mark.parametrize("turn", [0.0, 90.0])
def test_tiles_show_the_segments_that_a_ray_hits(make_bar, turn):
    scene = prepare(make_bar(40))
    maker = TileMaker(LIGHT)
    try:
        tile = maker.tile(scene, 60, turn)
        assert tile.segments.shape == (120, 120)
        assert tile.segments.max() < 40
        pane = maker._pane
        pane.image(120, 120, moving=True)
        hits = [(pane.pick(x, y), tile.segments[y, x]) for x in range(1, 120, 4) for y in range(1, 120, 4)]
    finally:
        maker.close()
    seen = [(a, b) for a, b in hits if a is not None]
    assert len(seen) > 10
    assert np.mean([a == b for a, b in seen]) > 0.9
    assert 0.2 * WHITE < tile.light[tile.segments >= 0].mean() <= 255
