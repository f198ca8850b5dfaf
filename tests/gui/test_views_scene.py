import numpy as np
import pytest

from engine.shapes.multilayer import MultiLayerGraph
from gui.views.cameras import Camera, best_direction, between, direction, fitting_distance, look_from, turned
from gui.views.scene import (
    borders,
    colour_groups,
    layer_colours,
    layer_nodes,
    prepare,
    spread_samples,
    union_colours,
    unit_box,
)


def test_the_longest_side_fills_the_unit_box(bar):
    points = unit_box(bar.mesh.vertices, bar.mesh.faces)
    assert points.min(axis=0) == pytest.approx([-0.5, -1 / 6, -1 / 6])
    assert points.max(axis=0) == pytest.approx([0.5, 1 / 6, 1 / 6])


def test_unused_vertices_do_not_count(bar):
    more = np.vstack([bar.mesh.vertices, [[1e6, np.nan, np.inf]]])
    boxed = unit_box(more, bar.mesh.faces)
    assert np.allclose(boxed[:-1], unit_box(bar.mesh.vertices, bar.mesh.faces))
    assert boxed[-1].tolist() == [0, 0, 0]


def test_links_end_on_their_own_segment(bar):
    scene = prepare(bar)
    for segment in range(3):
        own = scene.centroid[scene.labels == segment]
        for spot in scene.spots[segment]:
            assert np.linalg.norm(own - spot, axis=1).min() == pytest.approx(0)


@pytest.mark.parametrize(("group", "count"), [([0, 1, 2], 8), ([0, 0, 1], 4), ([5, 5, 5], 0), ([1, 0, 1], 8)])
def test_borders_run_between_groups_only(bar, group, count):
    assert len(borders(prepare(bar), np.array(group))) == count


def test_samples_follow_the_area():
    counts = np.bincount(spread_samples(np.array([1.0, 0.0, 3.0]), 400), minlength=3)
    assert counts.tolist() == [100, 0, 300]


def test_a_union_has_one_colour_and_the_rest_fades():
    base = np.array([[1, 1, 1], [2, 2, 2], [3, 3, 3]], np.uint8)
    out = union_colours(base, (0, 2), np.array([9, 9, 9]), np.array([7, 7, 7]))
    assert out.tolist() == [[9] * 3, [7] * 3, [9] * 3]
    assert colour_groups(out).tolist() == [1, 0, 1]


@pytest.fixture
def path_graph() -> MultiLayerGraph:
    """Segments 0-1-2: three bottom nodes, two pairs, one triple."""
    members = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [1, 1, 1]], bool)
    layer = np.array([1, 1, 1, 2, 2, 3])
    return MultiLayerGraph(members, layer, np.zeros((0, 2)), np.zeros(0), 3)


def test_walking_a_layer_shows_nodes_that_do_not_overlap(path_graph):
    assert layer_nodes(path_graph, 1).tolist() == [0, 1, 2]
    assert layer_nodes(path_graph, 2).tolist() == [3, 3, -1]
    assert layer_nodes(path_graph, 2, start=1).tolist() == [-1, 4, 4]
    assert layer_nodes(path_graph, 3).tolist() == [5, 5, 5]


def test_layer_colours_unite_a_node_and_fade_the_rest():
    base = np.array([[1, 1, 1], [2, 2, 2], [3, 3, 3]], np.uint8)
    out = layer_colours(np.array([-1, 4, 4]), base, np.array([7, 7, 7]))
    assert out.tolist() == [[7] * 3, [2] * 3, [2] * 3]


def test_the_best_view_shows_the_segment(bar):
    scene = prepare(bar)
    assert best_direction(scene, [2])[0] > 0.3
    assert best_direction(scene, [0])[0] < -0.3


def test_all_points_fit_at_the_fitting_distance(bar):
    scene = prepare(bar)
    for aspect in (0.5, 1.0, 2.0):
        towards = direction(20, 30)
        camera = look_from(towards, fitting_distance(scene, towards, aspect))
        arm = scene.points - camera.position
        depth = -arm @ towards
        right = np.cross([0, 1, 0], towards) / np.linalg.norm(np.cross([0, 1, 0], towards))
        up = np.cross(towards, right)
        slope = np.tan(np.radians(14))
        assert (np.abs(arm @ up) < depth * slope).all()
        assert (np.abs(arm @ right) < depth * slope * aspect).all()


def test_turning_keeps_the_distance_and_ends_where_it_should():
    start, end = look_from((0, 0, 1), 3.0), look_from((0, 0, -1), 3.0)
    for share in (0.0, 0.3, 0.7, 1.0):
        assert np.linalg.norm(between(start, end, share).position) == pytest.approx(3.0)
    assert between(start, end, 1.0).position == pytest.approx(end.position)
    assert between(start, end, 0.0).position == pytest.approx(start.position)


def test_a_quarter_turn_about_the_up_axis():
    camera = turned(Camera(np.array([0.0, 0, 2]), np.zeros(3), np.array([0.0, 1, 0])), 90)
    assert camera.position == pytest.approx([2, 0, 0])
