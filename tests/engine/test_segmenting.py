"""Automatic segments: laws on every kind of mesh, hand-made regions, CoACD's process, the command and the door."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from world import LAMP, bar, boxes

from engine.__main__ import main
from engine.errors import BadInput, BadParameter, Cancelled
from engine.shapes import convexparts
from engine.shapes.convexparts import nearest_hull, simplified
from engine.shapes.facegraph import coarsened, face_graph, pieces
from engine.shapes.families.collection import off_text
from engine.shapes.mesh import Mesh, face_areas
from engine.shapes.meshfile import load_shape
from engine.shapes.patches import geodesic_patches
from engine.shapes.regions import joined, joining_order, tidied, whole
from engine.shapes.segmentationparameters import DEFAULT
from engine.shapes.segmenting import auto_segment, surface_patches
from engine.store import Cache

SPHERES_APART = 3.0


def sphere(fine=3, at=0.0, radius=1.0) -> Mesh:
    import trimesh

    ball = trimesh.creation.icosphere(fine)
    return Mesh(ball.vertices * radius + [at, 0, 0], ball.faces, "ball")


def dumbbell(bumpy=True) -> Mesh:
    """A closed surface of revolution: two balls and a thin neck between them, without symmetry of the balls."""
    x = np.linspace(0, np.pi, 60)
    profile = np.sin(x) * (0.15 + 0.85 * np.cos(x) ** 2) + 1e-3
    around = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    height = 2.0 * x * np.where(x > np.pi / 2, 1.02, 1.0)
    points = np.array([[h, r * np.cos(a), r * np.sin(a)] for h, r in zip(height, profile, strict=True) for a in around])
    if bumpy:
        points *= 1 + 0.004 * np.random.default_rng(4).normal(size=points.shape)
    faces = [(24 * i + k, 24 * i + (k + 1) % 24, 24 * i + 24 + (k + 1) % 24, 24 * i + 24 + k) for i in range(59) for k in range(24)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    triangles += [(0, k + 1, k) for k in range(1, 23)] + [(24 * 59, 24 * 59 + k, 24 * 59 + k + 1) for k in range(1, 23)]
    return Mesh(points, np.array(triangles)[:, ::-1], "dumbbell")


def sheet(side=10) -> Mesh:
    points = np.array([[x, y, 0.0] for x in range(side + 1) for y in range(side + 1)])
    squares = [((side + 1) * i + j, (side + 1) * i + j + 1, (side + 1) * (i + 1) + j + 1, (side + 1) * (i + 1) + j)
               for i in range(side) for j in range(side)]  # fmt: skip
    return Mesh(points, np.array([t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))]), "sheet")


def soup(mesh: Mesh) -> Mesh:
    """Every face with vertices of its own."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), "soup")


TRIANGLE = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]), "triangle")
BOOK = Mesh(np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0.0]]),
            np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 0, 1]]), "book")  # fmt: skip
STRANGE = {"triangle": TRIANGLE, "book": BOOK, "sheet": sheet(), "soup": soup(sphere(2)), "boxes": boxes(LAMP).mesh,
           "dumbbell": dumbbell(), "ball": sphere(2)}  # fmt: skip


@pytest.mark.parametrize("method", ["parts", "patches"])
@pytest.mark.parametrize("name", STRANGE)
@pytest.mark.parametrize("count", [2, 7, 40])
def test_every_face_has_a_segment_and_the_number_is_that_asked_for(name, method, count):
    mesh = STRANGE[name]
    found = auto_segment(mesh, DEFAULT.changed(method=method, segments=count))
    assert len(found.labels) == len(mesh.faces)
    assert found.count == min(count, len(mesh.faces))
    assert found.names == tuple(range(found.count))


@pytest.mark.parametrize("method", ["parts", "patches"])
@pytest.mark.parametrize("name", ["sheet", "soup", "dumbbell", "ball"])
def test_segments_of_one_surface_are_connected(name, method):
    graph = face_graph(STRANGE[name])
    labels = auto_segment(STRANGE[name], DEFAULT.changed(method=method, segments=9)).labels
    assert pieces(graph, labels, bridges=False).max() + 1 == 9


def test_separate_pieces_get_segments_of_their_own_before_any_is_cut():
    mesh = boxes([((k, 0, 0), (k + 0.5, 1 + k / 5, 1)) for k in range(4)]).mesh
    labels = geodesic_patches(mesh, count=4, seed=0, crease=2.0)
    assert [len(np.unique(labels[12 * k : 12 * k + 12])) for k in range(4)] == [1] * 4
    assert len(np.unique(labels)) == 4
    assert len(np.unique(geodesic_patches(mesh, count=2, seed=0, crease=2.0))) == 2


@pytest.mark.parametrize("method", ["parts", "patches"])
def test_turning_moving_and_scaling_change_nothing(method):
    mesh = dumbbell()
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = Mesh(37.5 * mesh.vertices @ turn.T + [4, -7, 100], mesh.faces, "moved")
    chosen = DEFAULT.changed(method=method, segments=6)
    area = face_areas(mesh)
    same = auto_segment(mesh, chosen).labels == auto_segment(moved, chosen).labels
    assert area[same].sum() > 0.99 * area.sum()


def test_the_winding_of_a_closed_surface_does_not_matter():
    mesh = dumbbell()
    inside_out = Mesh(mesh.vertices, mesh.faces[:, ::-1], "inside out")
    assert np.allclose(face_graph(mesh).turn, face_graph(inside_out).turn)
    assert face_graph(mesh).inside


def test_concave_turns_are_positive_convex_ones_negative_and_flat_ones_nothing():
    graph = face_graph(bar([1.0, 2.0]).mesh)
    assert set(np.round(np.degrees(graph.turn))) == {-90, 0}
    notch = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1.0]]), np.array([[0, 1, 2], [1, 3, 2]]), "valley")
    assert not face_graph(notch).inside
    points = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2.0]])
    rows = np.r_[np.c_[points, np.zeros(6)], np.c_[points, np.ones(6)]]
    walls = [t for k in range(6) for t in ((k, (k + 1) % 6, (k + 1) % 6 + 6), (k, (k + 1) % 6 + 6, k + 6))]
    caps = [(0, 3, 1), (1, 3, 2), (0, 5, 3), (3, 5, 4)]
    ell = face_graph(Mesh(rows, np.array(walls + caps + [tuple(k + 6 for k in t[::-1]) for t in caps]), "ell"))
    turns = np.round(np.degrees(ell.turn)).astype(int)
    assert sorted(set(turns.tolist())) == [-90, 0, 90]
    assert (turns == 90).sum() == 1


def test_parts_of_a_dumbbell_meet_at_its_neck():
    mesh = dumbbell()
    labels = auto_segment(mesh, DEFAULT.changed(segments=2)).labels
    x = mesh.vertices[mesh.faces].mean(axis=1)[:, 0]
    x = (x - x.min()) / np.ptp(x)
    middle = [x[labels == k].max() for k in range(2)]
    assert 0.35 < min(middle) < 0.65


def test_patches_meet_at_a_fold_rather_than_half_way():
    flat = sheet(12)
    x = flat.vertices[:, 0]
    folded = Mesh(np.c_[np.minimum(x, 4), flat.vertices[:, 1], np.maximum(x - 4, 0)], flat.faces, "folded")
    before_fold = x[flat.faces].mean(axis=1) < 4

    def wrong(crease):
        labels = geodesic_patches(folded, count=2, seed=0, crease=crease)
        return min((labels == before_fold).mean(), (labels != before_fold).mean())

    assert wrong(0.0) > 0.1
    assert wrong(6.0) == 0.0


def test_regions_are_made_whole_by_their_largest_piece():
    mesh = bar([1.0] * 6).mesh
    labels = np.repeat([0, 1, 0, 0, 2, 2], 8)
    labels = np.r_[labels, [0, 0, 2, 2]]
    found = whole(face_graph(mesh), labels)
    assert found[:8].tolist() == [1] * 8  # the first piece of label 0 is smaller than the second
    assert found[48:50].tolist() == [1, 1]
    assert (found[16:32] == 0).all()


def test_teeth_are_taken_from_borders():
    mesh = sheet(12)
    x = mesh.vertices[mesh.faces].mean(axis=1)[:, 0]
    straight = (x > 6).astype(int)
    rough = straight.copy()
    rng = np.random.default_rng(0)
    near = np.flatnonzero(np.abs(x - 6) < 0.9)
    rough[rng.choice(near, len(near) // 3, replace=False)] ^= 1
    graph = face_graph(mesh)

    def border(labels):
        return graph.border[labels[graph.pairs[:, 0]] != labels[graph.pairs[:, 1]]].sum()

    assert border(tidied(graph, rough)) < 0.7 * border(rough)


def test_joining_takes_one_region_at_a_time_and_keeps_the_balls_apart():
    mesh = dumbbell()
    graph = face_graph(mesh)
    fine = surface_patches(graph, count=30, seed=0, crease=2.0)
    steps = joining_order(graph, mesh.vertices[mesh.faces] / 10, fine)
    assert steps.shape == (29, 2)
    for count in (30, 12, 2, 1):
        found = joined(fine, steps, count)
        assert found.max() + 1 == count
        assert all(len(np.unique(found[fine == k])) == 1 for k in range(30))


def test_cells_of_a_fine_surface_are_connected_and_cover_it():
    graph = face_graph(sphere(4))
    cell, coarse = coarsened(graph, 300)
    assert 50 < coarse.faces < 900
    assert np.allclose(np.bincount(cell, graph.area), coarse.area)
    assert pieces(graph, cell).max() + 1 == coarse.faces
    assert pieces(coarse).max() == 0
    assert coarse.turn.max() <= 1e-9  # a ball is convex everywhere


def test_hulls_hold_points_and_outside_the_nearest_wins():
    def cube(at):
        sides = np.concatenate([np.eye(3), -np.eye(3)])
        return np.c_[sides, 0.5 + sides @ np.array([at, 0, 0])]

    points = np.array([[0, 0, 0], [3, 0.4, 0], [1.2, 0, 0], [1.8, 0, 0], [9, 0, 0.0]])
    assert nearest_hull(points, [cube(0), cube(3)]).tolist() == [0, 1, 0, 1, 1]


def test_fine_surfaces_are_simplified_before_they_are_decomposed():
    mesh = sphere(4)
    points, faces = simplified(mesh.vertices, mesh.faces, 1000)
    assert 200 < len(faces) < 2500
    assert np.abs(np.linalg.norm(points[np.unique(faces)], axis=1) - 1).max() < 0.05
    assert simplified(mesh.vertices, mesh.faces, 10_000)[1] is mesh.faces


def test_convex_parts_of_two_balls_are_the_balls_and_come_from_the_cache(tmp_path):
    one, other = sphere(2), sphere(2, at=SPHERES_APART)
    mesh = Mesh(np.r_[one.vertices, other.vertices], np.r_[one.faces, other.faces + len(one.vertices)], "balls")
    chosen, cache = DEFAULT.changed(method="convex", segments=2, concavity=0.2), Cache(tmp_path)
    labels = auto_segment(mesh, chosen, cache=cache).labels
    half = len(one.faces)
    assert (labels[:half] == 0).all()
    assert (labels[half:] == 1).all()
    began = time.monotonic()
    assert auto_segment(mesh, chosen.changed(segments=3), cache=cache).count == 3
    assert time.monotonic() - began < 30
    assert len(list(tmp_path.glob("*.npz"))) == 1


@pytest.fixture
def children(monkeypatch):
    """The processes that are started, as they come."""
    started, real = [], subprocess.Popen

    def start(*words, **options):
        started.append(real(*words, **options))
        return started[-1]

    monkeypatch.setattr(convexparts.subprocess, "Popen", start)
    return started


def alive(pid):
    listing = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True).stdout.strip()
    return bool(listing) and listing[0] != "Z"


def test_a_killed_decomposition_is_one_sentence(children):
    def kill(share, words):
        if children and share > 0:
            children[0].send_signal(signal.SIGKILL)

    with pytest.raises(BadInput, match="could not be cut into convex parts"):
        auto_segment(sphere(4), DEFAULT.changed(method="convex", concavity=0.01), progress=kill)
    assert len(children) == 1


def test_cancelling_ends_the_process(children):
    def stop(share, words):
        if children and share > 0:
            raise Cancelled

    with pytest.raises(Cancelled):
        auto_segment(sphere(4), DEFAULT.changed(method="convex", concavity=0.01), progress=stop)
    assert [child.poll() for child in children] == [-signal.SIGKILL]


def test_a_process_whose_starter_is_killed_ends_itself():
    code = ("import subprocess, engine.shapes.convexparts as c; from test_segmenting import sphere, auto_segment, DEFAULT\n"
            "real = subprocess.Popen\n"
            "def start(*words, **options):\n"
            "    child = real(*words, **options); print(child.pid, flush=True); return child\n"
            "subprocess.Popen = start\n"
            "auto_segment(sphere(5), DEFAULT.changed(method='convex', concavity=0.01))")  # fmt: skip
    here = Path(__file__).parent
    path = os.pathsep.join(map(str, (here, here.parent, here.parents[1])))
    parent = subprocess.Popen([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.PIPE)
    child = int(parent.stdout.readline())
    assert alive(child)
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 20
    while alive(child) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not alive(child)


def test_a_child_that_writes_rubbish_is_one_sentence(monkeypatch, tmp_path):
    liar = tmp_path / "liar.py"
    liar.write_text("import sys\nopen(sys.argv[2], 'w').write('rubbish')\n")
    monkeypatch.setattr(convexparts.convexchild, "__file__", str(liar))
    with pytest.raises(BadInput, match="segment it by patches instead"):
        auto_segment(sphere(1), DEFAULT.changed(method="convex"))


def test_the_decomposition_is_silent(tmp_path):
    mesh = tmp_path / "ball.off"
    mesh.write_text(off_text(sphere(1)))
    command = [sys.executable, "-m", "engine", "segment", str(mesh), "--method", "convex", "--segments", "3"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"3 segments of ball (80 faces) written to {mesh.with_suffix('.seg')}\n"
    assert done.stderr == ""


def test_the_command_writes_one_number_a_face_and_replaces_nothing_unasked(tmp_path, capsys):
    mesh = tmp_path / "dumbbell.off"
    mesh.write_text(off_text(dumbbell()))
    assert main(["segment", str(mesh), "--segments", "5"]) == 0
    written = mesh.with_suffix(".seg").read_text().split()
    assert len(written) == len(dumbbell().faces)
    assert set(written) == set("01234")
    assert main(["segment", str(mesh), "--segments", "6"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["segment", str(mesh), "--segments", "6", "--overwrite", "--out", str(tmp_path / "new" / "six.seg")]) == 0
    assert len(set((tmp_path / "new" / "six.seg").read_text().split())) == 6
    assert main(["segment", str(mesh), "--segments", "1", "--out", str(tmp_path / "one.seg")]) == 2
    assert "whole number from 2 to 200" in capsys.readouterr().err


def test_a_mesh_without_labels_is_segmented_at_the_door_and_says_so(tmp_path):
    path = tmp_path / "dumbbell.off"
    path.write_text(off_text(dumbbell()))
    shape = load_shape(path)
    assert shape.automatic
    assert shape.segmentation.count == DEFAULT.segments
    assert shape.notes == ("dumbbell has no labels: it was cut into 14 segments automatically (parts).",)
    assert load_shape(path, automatic=DEFAULT.changed(segments=4)).segmentation.count == 4
    path.with_suffix(".seg").write_text("3\n" * len(dumbbell().faces))
    assert not load_shape(path, automatic=DEFAULT.changed(segments=4)).automatic


def test_components_serve_only_where_they_look_like_parts(tmp_path):
    path = tmp_path / "a.off"
    path.write_text(off_text(boxes([((0, 0, 0), (9, 9, 9)), ((9, 9, 9), (9.2, 9.2, 9.2))]).mesh))
    assert load_shape(path).automatic
    path.write_text(off_text(boxes([((0, 0, 0), (9, 9, 9)), ((9, 9, 9), (12, 12, 15))]).mesh))
    assert not load_shape(path).automatic
    assert load_shape(path, automatic=DEFAULT).segmentation.count == DEFAULT.segments


def test_fewer_than_one_patch_is_refused():
    with pytest.raises(BadParameter, match="at least 1"):
        geodesic_patches(TRIANGLE, count=0, seed=0, crease=1.0)
