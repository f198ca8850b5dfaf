"""The whole pipeline on the small world: hand-made truth and laws, for both methods."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from world import LAMP, boxes

from engine.errors import BadInput, Cancelled
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from engine.shapes.matching import describe, match_shapes, propose, rematch
from engine.shapes.mesh import Mesh
from engine.shapes.meshfile import load_shape
from engine.shapes.parameters import PRESETS, SHED, preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.store import Cache


def sides(result):
    return {(m.source, m.target) for m in result.matches()}


def match(a, b, name="top-down", **changes):
    return match_shapes(a, b, preset(name).changed(**changes), preset=name)


@pytest.mark.parametrize("name", PRESETS)
def test_a_shape_matches_itself_segment_by_segment(lamp, name):
    found = sides(match(lamp, lamp, name))
    assert found
    assert all(source == target for source, target in found)


@pytest.mark.parametrize("name", ["top-down", "thesis-nonrigid-size"])
def test_the_two_stem_pieces_together_match_the_whole_stem(lamp, coarse_lamp, name):
    found = sides(match(lamp, coarse_lamp, name))
    truth = {0: {0}, 1: {1}, 2: {1}, 3: {2}, 4: {3}}
    right = [set().union(*(truth[i] for i in source)) == set(target) for source, target in found]
    assert sum(right) >= 0.8 * len(right)
    if name == "top-down":
        assert ((1, 2), (1,)) in found
        assert ((0,), (0,)) in found


@pytest.mark.parametrize("name", ["top-down", "thesis-rigid"])
def test_renumbering_moving_and_scaling_change_no_match(lamp, coarse_lamp, name):
    plain = sides(match(lamp, coarse_lamp, name, light_fields=1))
    order = np.array([3, 0, 4, 1, 2])
    mesh = Mesh(lamp.mesh.vertices * 2.0 + 5.0, lamp.mesh.faces, "other")
    renamed = SegmentedShape(mesh, segmentation_from_labels(order[lamp.segmentation.labels]))
    renumbered = sides(match(renamed, coarse_lamp, name, light_fields=1))
    assert {(tuple(sorted(int(order[i]) for i in s)), t) for s, t in plain} == renumbered


def test_a_turned_lamp_still_matches(lamp, coarse_lamp):
    turn = Rotation.from_rotvec([0.9, 0.4, 0.2]).as_matrix()
    turned = SegmentedShape(Mesh(coarse_lamp.mesh.vertices @ turn.T, coarse_lamp.mesh.faces, "turned"), coarse_lamp.segmentation)
    assert {((0,), (0,)), ((3,), (2,)), ((1, 2), (1,))} <= sides(match(lamp, turned))


def test_the_same_inputs_give_the_same_result_with_and_without_a_cache(lamp, coarse_lamp, tmp_path):
    cache = Cache(tmp_path)
    results = [match_shapes(lamp, coarse_lamp, preset("top-down"), cache=c) for c in (None, cache, cache)]
    for other in results[1:]:
        assert other.ids == results[0].ids
        assert np.array_equal(other.score, results[0].score)
    assert list(tmp_path.glob("*.npz"))
    assert not list(tmp_path.glob("*.part"))


def test_a_damaged_cache_file_is_made_anew(lamp, coarse_lamp, tmp_path):
    cache = Cache(tmp_path)
    ids = match_shapes(lamp, coarse_lamp, preset("top-down"), cache=cache).ids
    for number, file in enumerate(tmp_path.glob("*.npz")):
        file.write_bytes(b"" if number % 2 else file.read_bytes()[:100])
    assert match_shapes(lamp, coarse_lamp, preset("top-down"), cache=cache).ids == ids


def test_matches_are_the_same_items_from_either_side_and_from_any_method(lamp, coarse_lamp):
    forth, back = match(lamp, coarse_lamp), match(coarse_lamp, lamp)
    common = {(s, t) for s, t in sides(forth)} & {(t, s) for s, t in sides(back)}
    assert common
    by_pair = {(m.source, m.target): m.id for m in forth.matches()}
    by_pair_back = {(m.target, m.source): m.id for m in back.matches()}
    assert all(by_pair[pair] == by_pair_back[pair] for pair in common)
    thesis = {(m.source, m.target): m.id for m in match(lamp, coarse_lamp, "thesis-nonrigid").matches()}
    assert all(thesis[pair] == by_pair[pair] for pair in thesis.keys() & by_pair.keys())


def test_identity_is_by_content(lamp):
    ids = segment_ids(lamp.mesh, lamp.segmentation)
    assert len(set(ids)) == 5
    renamed = segmentation_from_labels(10 - lamp.segmentation.labels)
    assert set(segment_ids(lamp.mesh, renamed)) == set(ids)
    moved = Mesh(lamp.mesh.vertices + 1, lamp.mesh.faces)
    assert mesh_id(moved) != mesh_id(lamp.mesh)
    assert mesh_id(Mesh(lamp.mesh.vertices, lamp.mesh.faces, "another name")) == mesh_id(lamp.mesh)
    assert node_id(ids[:2]) == node_id(ids[1::-1])
    assert match_id("a", "b") == match_id("b", "a") != match_id("a", "b", kind="puzzle")


def test_every_result_obeys_its_own_rules(lamp, coarse_lamp):
    for name in PRESETS:
        result = match(lamp, coarse_lamp, name)
        assert len(set(result.ids)) == len(result.ids)
        if result.method != SHED:  # one-to-many
            assert len({i for i, _ in result.pairs.tolist()}) == len({j for _, j in result.pairs.tolist()}) == len(result.ids)
        assert (result.score >= 0).all()
        assert (result.score <= 1).all()
        assert (np.diff(result.score) <= 1e-12).all()
        assert not (result.source_members.all(axis=1) | result.target_members.all(axis=1)).any()


def test_live_parameters_change_the_matches_without_describing_again(lamp, coarse_lamp):
    described = [describe(shape, preset("thesis-rigid")) for shape in (lamp, coarse_lamp)]
    proposals = propose(*described, preset("thesis-rigid"))
    counts = [len(rematch(proposals, preset("top-down").changed(overlap_min=r)).ids) for r in (0.0, 1.0)]
    assert counts[0] > counts[1]
    again = rematch(proposals, preset("top-down"))
    assert again.ids == match(lamp, coarse_lamp).ids


def test_one_single_segment_is_refused(lamp):
    whole = SegmentedShape(lamp.mesh, segmentation_from_labels(np.zeros(60)))
    with pytest.raises(BadInput, match="one single segment"):
        match(whole, lamp)


def test_cancelling_stops_the_work(lamp, coarse_lamp):
    seen = []

    def stop(share, words):
        seen.append(share)
        if share > 0.3:
            raise Cancelled

    with pytest.raises(Cancelled):
        match_shapes(lamp, coarse_lamp, preset("top-down"), progress=stop)
    assert seen == sorted(seen)
    assert seen[-1] < 0.6


def test_progress_rises_to_one(lamp, coarse_lamp):
    seen = []
    match_shapes(lamp, coarse_lamp, preset("top-down"), progress=lambda share, words: seen.append((share, words)))
    shares = [share for share, _ in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert all(words for _, words in seen)


def test_two_hundred_segments_work_within_the_caps():
    grid = boxes([((x, y, 0), (x + 1, y + 1, 1 + (x * 7 + y * 3) % 5)) for x in range(20) for y in range(10)], "grid")
    row = boxes(LAMP, "lamp")
    result = match(grid, row)
    assert result.source_nodes <= preset("top-down").node_cap
    assert any("node cap" in note for note in result.notes)


def test_a_real_pair(real_shapes):
    folder = real_shapes / "princeton" / "Chair"
    source = load_shape(folder / "101.off", folder / "101.median.seg")
    target = load_shape(folder / "102.off", folder / "102.median.seg")
    result = match(source, target)
    assert len(result.ids) > 5
