import gc
import weakref

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent, QImage, QPainter, QWheelEvent
from PySide6.QtWidgets import QApplication

from engine.errors import BadInput
from gui.palette import DARK, LIGHT
from gui.views.mesh_pair import EMPTY_TEXT, MeshPairView
from gui.views.scene import Link

LINK = Link("a", (0,), (2,))


@pytest.fixture
def view(qtbot):
    view = MeshPairView(probe=lambda: None)
    view.reduced_motion = True
    view.resize(600, 300)
    qtbot.addWidget(view)
    view.show()
    yield view
    view.shutdown()


@pytest.fixture
def pair(view, make_bar):
    view.set_shapes(make_bar(3, "left bar"), make_bar(4, "right bar"))
    view.grab()
    return view


def pixels(view) -> np.ndarray:
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    return np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)[:, : 3 * image.width()].copy()


def click(qtbot, view, at) -> None:
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=QPoint(*map(round, at)))


def place(view, side: int, segment: int) -> np.ndarray:
    xy, _ = view._drawing.panes[side].spots()
    return xy[segment] + [side * view.width() / 2, 0]


def test_the_empty_view_says_what_to_do(view):
    empty = pixels(view)
    assert len(np.unique(empty)) > 2
    view.clear("Another sentence that is much longer than the first")
    assert (pixels(view) != empty).any()
    view.clear(EMPTY_TEXT)
    assert (pixels(view) == empty).all()


def test_without_opengl_it_says_what_to_install(qtbot, make_bar):
    view = MeshPairView(probe=lambda: "Install libgl1.")
    qtbot.addWidget(view)
    view.set_shapes(make_bar(), make_bar())
    view.set_links([LINK])
    assert not view.scenes_shown
    view.grab()


def test_clicking_a_segment_reports_its_side_and_number(pair, qtbot):
    for side, segment in ((0, 1), (1, 2)):
        with qtbot.waitSignal(pair.segment_clicked) as caught:
            click(qtbot, pair, place(pair, side, segment))
        assert caught.args == [side, segment]


def test_clicking_a_link_reports_it_and_nothing_else(pair, qtbot):
    pair.set_links([LINK])
    pair.grab()
    middle = (place(pair, 0, 0) + place(pair, 1, 2)) / 2
    with qtbot.assertNotEmitted(pair.segment_clicked), qtbot.waitSignal(pair.link_clicked) as caught:
        click(qtbot, pair, middle)
    assert caught.args == ["a"]


def test_clicking_inside_a_polygon_beside_the_shapes_reports_it(pair, qtbot):
    pair.set_links([Link("m", (0, 1), (0, 1), merged=True)])
    pair.grab()
    corners = pair._shapes[0].outline
    with qtbot.waitSignal(pair.link_clicked) as caught:
        click(qtbot, pair, (300, corners[:, 1].mean()))
    assert caught.args == ["m"]


def test_clicking_beside_everything_reports_the_background(pair, qtbot):
    with qtbot.waitSignal(pair.background_clicked):
        click(qtbot, pair, (5, 290))


def test_each_state_is_drawn_differently(pair):
    pictures = []
    for state in ("undecided", "correct", "wrong", "tie"):
        for merged in (False, True):
            pair.set_links([Link("a", (0, 1) if merged else (0,), (2,), state, 1.0, merged)])
            pictures.append(pixels(pair))
    for i, one in enumerate(pictures):
        assert all((one != other).any() for other in pictures[:i])


def test_a_judged_line_shows_its_colour(pair):
    for state, colour in (("correct", LIGHT.correct), ("wrong", LIGHT.wrong)):
        pair.set_links([Link("a", (0,), (2,), state)])
        picture = pixels(pair).reshape(-1, 3)
        wanted = np.frombuffer(bytes.fromhex(colour[1:]), np.uint8)
        assert (picture == wanted).all(axis=1).sum() > 300


def test_the_selected_link_is_thick_and_the_others_fade(pair):
    pair.set_links([Link("a", (0,), (0,), "correct"), Link("b", (2,), (3,), "wrong")])

    def amount(colour: str) -> int:
        wanted = np.frombuffer(bytes.fromhex(colour[1:]), np.uint8)
        return int((pixels(pair).reshape(-1, 3) == wanted).all(axis=1).sum())

    blue, red = amount(LIGHT.correct), amount(LIGHT.wrong)
    pair.set_selected("a")
    assert amount(LIGHT.correct) > 1.2 * blue
    assert amount(LIGHT.wrong) < 0.1 * red
    pair.set_selected(None)
    assert (amount(LIGHT.correct), amount(LIGHT.wrong)) == (blue, red)


def test_a_folded_polygon_unfolds_when_it_is_selected(pair):
    big, small = Link("big", (0, 1, 2), (0, 1), merged=True), Link("small", (0, 1), (1,), merged=True)
    pair.set_links([big, small])
    pair.grab()
    assert [(s.folded, len(s.outline) > 2) for s in pair._shapes] == [(True, False), (False, True)]
    pair.set_selected("big")
    pair.grab()
    assert [s.folded for s in pair._shapes] == [False, False]


def test_the_selected_link_has_a_light_halo(pair):
    pair.set_theme(DARK)
    pair.set_links([LINK])
    pair.set_selected("a")
    middle = ((place(pair, 0, 0) + place(pair, 1, 2)) / 2).round().astype(int)
    column = pixels(pair).reshape(300, 600, 3)[middle[1] - 8 : middle[1] + 9, middle[0]]
    assert column.min(axis=1).max() > 230


def test_a_double_click_resets_one_shape_or_both_if_linked(pair, qtbot):
    homes = [pane.camera.position for pane in pair._drawing.panes]
    for linked, reset in ((False, [True, False]), (True, [True, True])):
        pair.set_linked_cameras(linked)
        for pane in pair._drawing.panes:
            pane.camera = pane.camera._replace(position=np.array([0.0, 0.0, 3.0]))
        qtbot.mouseDClick(pair, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
        now = [pane.camera.position for pane in pair._drawing.panes]
        assert [bool(np.allclose(a, b)) for a, b in zip(now, homes, strict=True)] == reset


def test_highlight_and_layers_recolour_and_give_back(pair, qtbot):
    qtbot.waitUntil(lambda: not pair._moving)
    before = pixels(pair)
    pair.set_highlight((0, 1), (2,))
    assert (pixels(pair) != before).any()
    pair.set_highlight((), ())
    pair.set_layer_colours(np.full((3, 3), 90, np.uint8), None)
    assert (pixels(pair) != before).any()
    pair.set_layer_colours(None, None)
    qtbot.waitUntil(lambda: not pair._moving)
    assert (pixels(pair) == before).all()


def test_linked_cameras_turn_together(pair, qtbot):
    def drag() -> None:
        qtbot.mousePress(pair, Qt.MouseButton.LeftButton, pos=QPoint(60, 60))
        qtbot.mouseMove(pair, QPoint(90, 80))
        qtbot.mouseMove(pair, QPoint(120, 90))
        qtbot.mouseRelease(pair, Qt.MouseButton.LeftButton, pos=QPoint(120, 90))

    source, target = pair._drawing.panes
    before = [p.camera.position for p in (source, target)]
    drag()
    assert np.linalg.norm(source.camera.position - before[0]) > 0.1
    assert target.camera.position == pytest.approx(before[1])
    pair.set_linked_cameras(True)
    assert target.camera.position == pytest.approx(source.camera.position)
    drag()
    assert target.camera.position == pytest.approx(source.camera.position)
    pair.reset_view()
    assert source.camera.position == pytest.approx(before[0])


def test_framing_a_match_shows_its_segments(pair):
    pair.frame_match((0,), (3,))
    pair.grab()
    for pane, segment in zip(pair._drawing.panes, (0, 3), strict=True):
        assert pane.spots()[1][segment]
    assert pair._drawing.panes[0].camera.position[0] < 0 < pair._drawing.panes[1].camera.position[0]


def test_the_wheel_zooms_the_shape_below_it(pair):
    near = [np.linalg.norm(p.camera.position) for p in pair._drawing.panes]
    at = QPointF(450, 150)
    wheel = QWheelEvent(at, at, QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier,
                        Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(pair, wheel)
    now = [np.linalg.norm(p.camera.position) for p in pair._drawing.panes]
    assert now[0] == pytest.approx(near[0])
    assert now[1] < near[1]


def test_a_narrower_view_still_shows_the_whole_shapes(pair):
    def reach():
        """Where the ends of the bar stand, as shares of half the picture."""
        pair.grab()
        xy, _ = pair._drawing.panes[0].spots()
        return xy[[0, 2], 0] / (pair.width() / 2)

    before, start = reach(), pair._drawing.panes[0].camera
    pair.resize(400, 300)
    assert reach() == pytest.approx(before, abs=0.02)
    pair.resize(400, 200)  # each half as wide as high
    assert reach() == pytest.approx(before, abs=0.02)
    pair.resize(900, 300)
    assert pair._drawing.panes[0].camera.position == pytest.approx(start.position)
    pair.resize(600, 300)
    assert reach() == pytest.approx(before, abs=0.02)


def test_the_turntable_turns_until_it_is_stopped(pair, qtbot):
    start = pair._drawing.panes[0].camera.position
    pair.turntable(True)
    qtbot.waitUntil(lambda: np.linalg.norm(pair._drawing.panes[0].camera.position - start) > 0.01)
    pair.turntable(False)
    stopped = pair._drawing.panes[0].camera.position
    qtbot.wait(100)
    assert pair._drawing.panes[0].camera.position == pytest.approx(stopped)


def test_dropped_files_are_reported(view, qtbot):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile("/a/one.off"), QUrl("https://example.org/two.off")])
    drop = QDropEvent(QPointF(9, 9), Qt.DropAction.CopyAction, mime, Qt.MouseButton.LeftButton,
                      Qt.KeyboardModifier.NoModifier, QEvent.Type.Drop)  # fmt: skip
    with qtbot.waitSignal(view.files_dropped) as caught:
        view.dropEvent(drop)
    assert caught.args == [["/a/one.off"]]


@pytest.mark.parametrize(("name", "start"), [("f.png", b"\x89PNG"), ("f.svg", b"<?xml"), ("f.pdf", b"%PDF")])
def test_figures_are_written(pair, tmp_path, name, start):
    pair.set_links([LINK])
    pair.save_figure(tmp_path / name, (400, 200))
    data = (tmp_path / name).read_bytes()
    assert data.startswith(start)
    assert len(data) > 5000
    if name.endswith("svg"):
        assert b"left bar" in data


def test_a_png_has_two_pixels_for_one_and_may_be_transparent(pair, tmp_path):
    pair.save_figure(tmp_path / "a.png", (400, 200), transparent=True)
    image = QImage(str(tmp_path / "a.png"))
    assert (image.width(), image.height()) == (800, 400)
    assert image.pixelColor(5, 390).alpha() == 0
    pair.save_figure(tmp_path / "b.png", (400, 200))
    assert QImage(str(tmp_path / "b.png")).pixelColor(5, 390).name().upper() == LIGHT.paper


def test_a_figure_that_cannot_be_written_says_why(pair, tmp_path):
    with pytest.raises(BadInput, match=r"\.png, \.svg or \.pdf"):
        pair.save_figure(tmp_path / "a.gif")
    with pytest.raises(BadInput, match="cannot be written"):
        pair.save_figure(tmp_path / "missing" / "a.png", (100, 50))


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_links_meet_the_shapes_at_every_scale(pair, scale):
    """The end of a line lies on its segment, whatever the number of device pixels to a logical one."""
    pair.set_links([LINK])
    image = QImage(round(600 * scale), round(300 * scale), QImage.Format.Format_RGB32)
    painter = QPainter(image)
    shapes = pair._drawing.paint(painter, 600, 300, scale)
    painter.end()
    assert pair._drawing.panes[0].pick(*(shapes[0].ends[0] * scale)) == 0
    assert pair._drawing.panes[1].pick(*((shapes[0].ends[1] - [300, 0]) * scale)) == 2


def test_dark_and_light_differ(pair):
    light = pixels(pair)
    pair.set_theme(DARK)
    dark = pixels(pair)
    assert dark[-1].mean() < 60 < light[-1].mean()


def test_new_shapes_replace_the_old_ones_and_their_links(pair, make_bar):
    pair.set_links([LINK])
    pair.set_selected("a")
    pair.set_shapes(make_bar(2), make_bar(2))
    pair.grab()
    assert pair._shapes == []


def test_a_closed_view_lets_its_drawing_go(qtbot, make_bar):
    view = MeshPairView(probe=lambda: None)
    view.set_shapes(make_bar(), make_bar())
    view.grab()
    drawing, closed = weakref.ref(view._drawing), []
    for pane in view._drawing.panes:
        pane.close = lambda close=pane.close: (close(), closed.append(1))
    view.shutdown()
    assert closed == [1, 1]
    del pane
    gc.collect()
    assert drawing() is None
    assert not view.scenes_shown
    view.deleteLater()
    qtbot.wait(1)
