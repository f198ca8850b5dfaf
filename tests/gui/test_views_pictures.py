import struct

import numpy as np
import pytest
from PySide6.QtGui import QImage

from engine.errors import ConcordError
from engine.shapes.parameters import preset
from engine.shapes.result import MatchResult, ShapeRecord
from gui import glprobe
from gui.views.inspector import NO_SCREEN, Inspector, describe
from gui.views.pictures import draw_pair, draw_shape, report_pictures
from gui.views.scene import Link, links_of, prepare


@pytest.fixture
def result() -> MatchResult:
    """Two matches between bars of three and two sections: 0 with 0, and 1 and 2 together with 1."""
    return MatchResult(
        method="thesis", preset="thesis-rigid", parameters=preset("thesis-rigid"),
        source=ShapeRecord("a", "0", (0, 1, 2), 28), target=ShapeRecord("b", "1", (0, 1), 20),
        pairs=np.array([[0, 0], [3, 1]]), score=np.array([1.0, 0.5]), similarity=np.ones(2), votes=np.ones(2),
        source_members=np.array([[1, 0, 0], [0, 1, 1]], bool), target_members=np.array([[1, 0], [0, 1]], bool),
        source_layer=np.array([1, 2]), target_layer=np.array([1, 1]), ids=("one", "two"), source_nodes=6,
        target_nodes=3)  # fmt: skip


def png_size(data: bytes) -> tuple[int, int]:
    assert data.startswith(b"\x89PNG")
    return struct.unpack(">II", data[16:24])


def test_links_of_a_result_have_the_best_on_top(result):
    assert links_of(result, {"one": "correct"}) == [
        Link("two", (1, 2), (1,), "undecided", 0.5, merged=True),
        Link("one", (0,), (0,), "correct", 1.0, merged=False),
    ]


def test_pictures_have_the_wanted_size(qapp, make_bar):
    assert png_size(draw_shape(make_bar(), (120, 100))) == (240, 200)
    assert png_size(draw_pair(make_bar(), make_bar(), [], (200, 100))) == (400, 200)


def test_a_report_shows_lines_and_polygons_apart(qapp, result, make_bar):
    pictures = report_pictures(make_bar(3), make_bar(2), result)
    assert [title for title, _ in pictures] == ["1 one-to-one match", "1 match of merged segments"]
    assert pictures[0][1] != pictures[1][1]
    assert all(png_size(data) == (2400, 1200) for _, data in pictures)


def test_without_opengl_pictures_are_refused_in_one_sentence(monkeypatch, make_bar):
    monkeypatch.setattr(glprobe, "problem", lambda: glprobe.NO_GL)
    with pytest.raises(ConcordError, match="libgl1"):
        draw_shape(make_bar())


@pytest.fixture
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path))


@pytest.mark.parametrize(
    ("code", "answer"),
    [("import os; os.kill(os.getpid(), 11)", glprobe.NO_GL), ("import missing_package", glprobe.NO_VTK),
     ("print('drawn')", None)],
)  # fmt: skip
def test_the_probe_survives_a_crash_and_says_what_to_install(own_cache, monkeypatch, code, answer):
    monkeypatch.setattr(glprobe, "_TRIAL", code)
    assert glprobe.problem() == answer


def test_vtk_draws_here_and_the_answer_is_kept(own_cache, monkeypatch):
    assert glprobe.problem() is None
    monkeypatch.setattr(glprobe, "_TRIAL", "raise SystemExit(1)")
    assert glprobe.problem() is None
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "another")
    assert glprobe.problem() == glprobe.NO_GL


def test_a_picked_segment_is_described(bar):
    assert describe(prepare(bar), 1) == "Segment 1 · 28.6% of the area · 8 faces"


def test_the_inspector_needs_a_screen(qapp, make_bar):
    if qapp.platformName() != "offscreen":
        pytest.skip("there is a screen")
    with pytest.raises(ConcordError, match=NO_SCREEN):
        Inspector(make_bar())


@pytest.mark.xvfb
def test_the_inspector_picks_hides_and_isolates(qapp, qtbot, tmp_path, make_bar):
    if qapp.platformName() == "offscreen":
        pytest.skip("needs a screen: run with QT_QPA_PLATFORM=xcb under Xvfb")
    window = Inspector(make_bar())
    window.show()
    qtbot.waitExposed(window)
    middle = window.plotter.interactor.rect().center()
    assert window.segment_at(middle.toPointF()) == 1
    window.pick(1)
    window.hide_picked()
    assert window.segment_at(middle.toPointF()) != 1
    window.pick(2)
    window.isolate_picked()
    assert window.hidden == {0, 1}
    window.show_all()
    window.save_picture(tmp_path / "a.png")
    assert png_size((tmp_path / "a.png").read_bytes())[0] > 100
    window.close()


def test_a_match_is_drawn_with_its_parts_marked(qapp, make_bar):
    from annotation.results.shownitems import ShownParts
    from gui.palette import LIGHT, rgb
    from gui.views.parts_picture import draw_parts

    def near_accent(data: bytes) -> int:
        image = QImage.fromData(data, "PNG").convertToFormat(QImage.Format.Format_RGB888)
        pixels = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)[:, : 3 * image.width()].reshape(-1, 3)
        hue = pixels.astype(float) / np.maximum(pixels.sum(axis=1, keepdims=True), 1)
        accent = rgb(LIGHT.accent) / rgb(LIGHT.accent).sum()
        return int((np.abs(hue - accent).max(axis=1) < 0.06).sum())

    one, other = make_bar(3), make_bar(2)
    marked, more = (draw_parts(ShownParts(one, other, rows, (0,)), (400, 200)) for rows in ((0,), (0, 1, 2)))
    assert png_size(marked) == (800, 400)
    assert 0 < near_accent(marked) < near_accent(more)
