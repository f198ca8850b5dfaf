"""What is kept of a shape on disk: the same bytes again, and made anew for every parameter that it depends on."""

from dataclasses import fields

import numpy as np
import pytest
from world import LAMP, boxes

from engine.shapes import describing
from engine.shapes.describing import describe
from engine.shapes.mesh import Mesh
from engine.shapes.parameters import preset
from engine.shapes.segmentation import SegmentedShape, segmentation_from_labels
from engine.store import Cache

LIGHT = preset("top-down").changed(light_fields=1, resolution=64)
APART = [*LAMP, ((6, 6, 6), (7, 7, 7))]  # a box that touches nothing, so that there is a note


def arrays(described):
    found = {"hops": described.hops, "descriptors": described.descriptors, "signatures": described.signatures}
    for part in (described.graph, described.layers, described.measures):
        found |= {f"{type(part).__name__}.{f.name}": getattr(part, f.name) for f in fields(part)
                  if isinstance(getattr(part, f.name), np.ndarray)}  # fmt: skip
    return found


def noted(name, make, called):
    def making(*arguments, **options):
        called.add(name)
        return make(*arguments, **options)

    return making


def test_a_second_run_gives_the_same_bytes_without_making_anything(tmp_path, monkeypatch):
    shape, cache = boxes(APART, "lamp"), Cache(tmp_path)
    plain, first = describe(shape, LIGHT), describe(shape, LIGHT, cache=cache)
    for name in ("build_segment_graph", "segment_geodesics", "light_field_descriptors"):
        monkeypatch.setattr(describing, name, None)  # whoever calls it fails
    again = describe(shape, LIGHT, cache=cache)
    assert len(arrays(plain)) >= 15
    for name, wanted in arrays(plain).items():
        for other in (arrays(first)[name], arrays(again)[name]):
            assert other.dtype == wanted.dtype
            assert other.tobytes() == wanted.tobytes(), name
    assert plain.notes == first.notes == again.notes
    assert any("do not touch" in note for note in plain.notes)
    assert plain.segment_ids == again.segment_ids


@pytest.mark.parametrize(("changes", "made"), [
    ({"touch_distance": 0.05}, {"build_segment_graph"}),
    ({"adjacency": "proximity"}, {"build_segment_graph"}),
    ({"touch_samples": 30_000}, {"build_segment_graph"}),
    ({"geodesic_points": 900}, {"segment_geodesics"}),
    ({"resolution": 128}, {"light_field_descriptors"}),
    ({"max_segments": 2}, {"light_field_descriptors"}),
    ({"seed": 1}, {"build_segment_graph", "segment_geodesics", "light_field_descriptors"}),
    ({"overlap_min": 0.9, "pool": 50}, set()),
])  # fmt: skip
def test_only_what_a_parameter_touches_is_made_anew(tmp_path, monkeypatch, changes, made):
    shape, cache, called = boxes(LAMP, "lamp"), Cache(tmp_path), set()
    describe(shape, LIGHT, cache=cache)
    for name in ("build_segment_graph", "segment_geodesics", "light_field_descriptors"):
        monkeypatch.setattr(describing, name, noted(name, getattr(describing, name), called))
    fresh = describe(shape, LIGHT.changed(**changes), cache=cache)
    assert called == made
    for name, wanted in arrays(describe(shape, LIGHT.changed(**changes))).items():
        assert arrays(fresh)[name].tobytes() == wanted.tobytes(), name


def test_other_labels_and_another_order_of_labels_are_other_shapes(tmp_path):
    cache, shape = Cache(tmp_path), boxes(LAMP, "lamp")
    order = np.array([3, 0, 4, 1, 2])
    renamed = SegmentedShape(shape.mesh, segmentation_from_labels(order[shape.segmentation.labels]))
    moved = SegmentedShape(Mesh(shape.mesh.vertices * [1, 1, 2], shape.mesh.faces, "lamp"), shape.segmentation)
    for other in (shape, renamed, moved):
        kept, plain = describe(other, LIGHT, cache=cache), describe(other, LIGHT)
        for name, wanted in arrays(plain).items():
            assert arrays(kept)[name].tobytes() == wanted.tobytes(), name
