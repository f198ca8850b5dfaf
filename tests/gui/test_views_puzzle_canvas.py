"""The canvas as pixels and under a hand: warped pieces, clicks, carrying, growth; the close-up of a join."""

from dataclasses import replace

import numpy as np
import pytest
from jigsaw import cut_small, flat, true_solution, two_by_two
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QWheelEvent

from engine.puzzles.pieces import Puzzle
from engine.puzzles.solution import Joins
from gui.palette import DARK, LIGHT
from gui.views import puzzle_canvas, puzzle_sheet
from gui.views.join_closeup import JoinCloseup, Partner, PartnerStrip, pair_of, stretched, window_on
from gui.views.puzzle_canvas import PuzzleCanvas
from gui.views.puzzle_layout import arrange
from gui.views.puzzle_painting import Overlay
from gui.views.puzzle_scene import View, bins, growth_order, seams
from gui.views.puzzle_sheet import compose


@pytest.fixture
def world():
    puzzle, truth = two_by_two()
    solution = true_solution(puzzle, truth)
    return puzzle, solution, arrange(puzzle, solution)


@pytest.fixture
def canvas(qtbot, world):
    made = PuzzleCanvas()
    qtbot.addWidget(made)
    made.resize(400, 400)
    made.show()
    made.show_layout(world[2])
    made.show_overlay(marks(world))
    return made


def marks(world, **changes):
    _, solution, layout = world
    j = len(solution.joins)
    whole = Overlay(seams(layout, solution.joins), bins(solution.joins.confidence), np.ones(j, bool), {}, np.zeros(j, bool))
    return replace(whole, **changes)


def colour(widget, x, y):
    return QColor(widget.grab().toImage().pixel(round(x), round(y))).getRgb()[:3]


def on_screen(canvas, x, y):
    return canvas.view.to_screen(np.array([x, y]))


# --- pixels


def test_the_sheet_shows_every_pixel_of_a_piece_as_a_square(world):
    sheet = compose(world[2])
    seen = sheet.warped(View(4.0, 8.0, 0.0), 48, 40)
    assert seen.shape == (40, 48, 4)
    for (x, y), bgra in {(8, 0): (0, 0, 200, 255), (23, 15): (0, 0, 200, 255), (24, 15): (0, 200, 0, 255),
                         (23, 16): (200, 0, 0, 255), (39, 31): (0, 200, 200, 255)}.items():  # fmt: skip
        assert tuple(seen[y, x]) == bgra, (x, y)
    assert (seen[:, :8] == 0).all()
    assert (seen[32:] == 0).all()


def test_from_afar_smaller_copies_give_the_mean(world):
    puzzle, truth = cut_small(12, 12)
    layout = arrange(puzzle, true_solution(puzzle, truth))
    sheet = compose(layout)
    whole = sheet.levels[0][:192, :192, :3].astype(float)
    seen = sheet.warped(View(0.125), 24, 24)[:, :, :3]
    assert np.abs(seen[4:20, 4:20] - whole.reshape(24, 8, 24, 8, 3).mean(axis=(1, 3))[4:20, 4:20]).max() < 12


def test_turned_and_uneven_pieces_are_pasted_as_they_stand():
    mask = np.ones((4, 6), bool)
    mask[0, 0] = False
    piece = replace(flat([10, 20, 30], 6, 4), mask=mask)
    puzzle = Puzzle((piece, flat([200, 200, 200], 6, 6)))
    solution = replace(true_solution(*two_by_two()), picture=np.array([0, 0]), position=np.array([[0, 0], [0, 0]]),
                       turns=np.array([1, 0]), sizes=np.array([[6, 6]]))  # fmt: skip
    sheet = compose(arrange(puzzle, replace(solution, position=np.array([[1, 0], [0, 0]]))))
    assert tuple(sheet.levels[0][0, 1]) == (200, 200, 200, 255)  # pasted last
    sheet = compose(arrange(puzzle, replace(solution, picture=np.array([0, -1]))))
    top = sheet.levels[0][0, :4]
    assert [tuple(p) for p in top] == [(30, 20, 10, 255)] * 3 + [(0, 0, 0, 0)]  # turned clockwise, its hole is top right


def test_a_lifted_piece_uncovers_what_lay_below(world):
    puzzle, solution, _ = world
    over = arrange(puzzle, replace(solution, position=np.array([[0, 0], [4, 0], [0, 4], [2, 2]])))
    sheet = compose(over)
    assert tuple(sheet.levels[0][3, 3, :3]) == (0, 200, 200)
    sheet.lift(frozenset({3}))
    assert tuple(sheet.levels[0][3, 3, :3]) == (0, 0, 200)
    assert tuple(sheet.levels[0][5, 5]) == (0, 0, 0, 0)


@pytest.mark.parametrize("seed", range(4))
def test_following_another_layout_gives_the_same_pixels_as_drawing_all_anew(seed):
    puzzle, truth = cut_small(turned=True)
    rng = np.random.default_rng(seed)
    solution = true_solution(puzzle, truth)
    sheet = compose(arrange(puzzle, solution))
    for _ in range(4):
        where, at, turns = solution.picture.copy(), solution.position.copy(), solution.turns.copy()
        a, b, c = rng.choice(24, 3, replace=False)
        at[[a, b]], turns[a], where[c] = at[[b, a]], rng.integers(4), -1 - where[c]
        at[b] += rng.integers(0, 9, 2)  # overlaps others
        solution = replace(solution, picture=where, position=at, turns=turns)
        layout = arrange(puzzle, solution)
        assert sheet.follow(layout)
        whole = compose(layout).levels[0]
        differs = (sheet.levels[0] != whole).any(axis=2)
        single = _layers(layout, whole.shape[:2]) <= 1
        assert not differs[single].any()
        assert sheet.levels[0].shape == whole.shape


def _layers(layout, shape):
    """How many boxes of pieces lie on each pixel."""
    count = np.zeros(shape, int)
    for (x, y), (w, h) in zip(layout.position, layout.size, strict=True):
        count[y : y + h, x : x + w] += 1
    return count


def test_a_puzzle_too_large_for_the_sheet_is_sharp_from_close_by(world, monkeypatch):
    monkeypatch.setattr(puzzle_sheet, "MOST_PIXELS", 16)
    sheet = compose(world[2])
    assert sheet.scale == 0.5
    seen = sheet.warped(View(4.0), 32, 32)
    assert tuple(seen[15, 15]) == (0, 0, 200, 255)
    assert tuple(seen[16, 16]) == (0, 200, 200, 255)
    assert tuple(seen[31, 31]) == (0, 200, 200, 255)


def test_joins_are_drawn_where_pieces_meet_and_only_those_shown(canvas, world):
    x, y = on_screen(canvas, 2, 4)
    amber = colour(canvas, x, y)
    assert amber[0] > 200 > amber[2]  # not the red above nor the blue below
    canvas.show_overlay(marks(world, shown=np.zeros(4, bool)))
    assert colour(canvas, x, y) != amber


def test_the_canvas_follows_the_theme_and_marks_what_is_wrong(canvas, world):
    assert colour(canvas, 2, 2) == (0xFA, 0xFA, 0xF7)
    canvas.set_theme(DARK)
    assert colour(canvas, 2, 2) == (0x1E, 0x20, 0x24)
    canvas.set_theme(LIGHT)
    at = on_screen(canvas, 6.2, 1.2)
    before = colour(canvas, *at)
    canvas.show_overlay(marks(world, wrong_pieces=np.array([1])))
    after = colour(canvas, *at)
    assert before == (0, 200, 0)
    assert after[0] > 30


def test_an_error_while_painting_leaves_the_program_alive(canvas, monkeypatch):
    def break_(*_):
        raise ValueError("no paint")

    monkeypatch.setattr(puzzle_canvas, "paint_ground", break_)
    with pytest.raises(ValueError, match="no paint"):
        canvas.grab()
    monkeypatch.undo()
    assert colour(canvas, *on_screen(canvas, 2, 2)) == (200, 0, 0)


# --- hands


def test_a_click_near_a_seam_says_which_join_else_which_piece_else_nothing(canvas, qtbot):
    heard = []
    canvas.join_clicked.connect(lambda row: heard.append(("join", row)))
    canvas.piece_clicked.connect(lambda piece: heard.append(("piece", piece)))
    canvas.background_clicked.connect(lambda: heard.append(("nothing", 0)))
    for x, y in ((4, 2), (6, 6), (-0.4, 4)):
        qtbot.mouseClick(canvas, Qt.MouseButton.LeftButton, pos=QPointF(*on_screen(canvas, x, y)).toPoint())
    assert heard == [("join", 0), ("piece", 3), ("nothing", 0)]


def drag(canvas, qtbot, start, stop, button=Qt.MouseButton.LeftButton):
    a, b = (QPointF(*on_screen(canvas, *p)).toPoint() for p in (start, stop))
    qtbot.mousePress(canvas, button, pos=a)
    for share in (0.3, 0.7, 1.0):
        qtbot.mouseMove(canvas, a + (b - a) * share)
    qtbot.mouseRelease(canvas, button, pos=b)


def test_a_carried_piece_snaps_and_says_where_it_was_let_go(canvas, world, qtbot):
    puzzle, solution, _ = world
    canvas.show_layout(arrange(puzzle, replace(solution, position=np.array([[0, 0], [4, 0], [0, 4], [20, 20]]),
                                               sizes=np.array([[30, 30]]))))  # fmt: skip
    heard = []
    canvas.carried.connect(lambda *said: heard.append(said))
    canvas.piece_clicked.connect(lambda piece: heard.append(piece))
    drag(canvas, qtbot, (22, 22), (6.3, 6.2))
    assert heard == [(3, 4, 4)]
    assert colour(canvas, *on_screen(canvas, 22, 22)) == (200, 200, 0)  # until somebody shows another layout


def test_a_drag_beside_the_pieces_moves_the_view_and_fit_brings_it_back(canvas, qtbot):
    before = canvas.view
    drag(canvas, qtbot, (-0.8, 2), (-0.8, 5))
    assert canvas.view.y == pytest.approx(before.y + 3 * before.scale, abs=2)
    assert not canvas.follows
    canvas.resize(300, 300)
    assert canvas.view.scale == before.scale
    canvas.reset_view()
    assert canvas.follows
    assert canvas.view.scale < before.scale


def test_the_wheel_zooms_about_the_pointer(canvas):
    at = QPointF(*on_screen(canvas, 6, 2))
    event = QWheelEvent(at, canvas.mapToGlobal(at), QPoint(), QPoint(0, 240), Qt.MouseButton.NoButton,
                        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    before = canvas.view.scale
    canvas.wheelEvent(event)
    assert canvas.view.scale == pytest.approx(before * 1.44)
    assert on_screen(canvas, 6, 2) == pytest.approx((at.x(), at.y()))


def test_a_join_out_of_sight_is_brought_into_it(canvas, world):
    canvas.view = View(40, 4000, 4000)
    segment = marks(world).seams[0]
    canvas.look_at(segment)
    assert on_screen(canvas, *segment.mean(axis=0)) == pytest.approx((200, 128))  # and the whole picture stays in sight
    view = canvas.view
    canvas.look_at(marks(world).seams[1])  # already in sight
    assert canvas.view == view


def test_a_picture_grows_piece_by_piece_and_says_when_it_is_there(canvas, world, qtbot):
    puzzle, solution, goal = world
    full = arrange(puzzle, solution, 1.0, solution.placed)
    with qtbot.waitSignal(canvas.grown, timeout=5000):
        canvas.grow(full, goal, growth_order(solution.joins, solution.placed))
        assert canvas.is_growing
        assert not canvas.layout_shown.placed.any()
    assert not canvas.is_growing
    assert canvas.layout_shown.placed.all()
    assert (canvas.layout_shown.position == goal.position).all()
    assert (canvas._sheet.levels[0][:8, :8, 3] == 255).all()


def test_nothing_to_show_is_an_invitation(canvas):
    canvas.show_layout(None)
    canvas.set_invitation("Drop something", PartnerStrip(canvas))
    assert colour(canvas, 100, 30) != colour(canvas, 30, 30) or canvas.render_frame() is None


# --- close-ups


def test_the_pair_shows_both_pieces_as_they_stand_and_where_they_meet(world):
    puzzle, solution, _ = world
    pair = pair_of(puzzle, solution.joins, 0, 0)  # red left of green
    assert pair.pixels.shape == (4, 8, 4)
    assert tuple(pair.pixels[0, 3]) == (0, 0, 200, 255)
    assert tuple(pair.pixels[0, 4]) == (0, 200, 0, 255)
    assert np.sort(pair.seam, axis=0).tolist() == [[4, 0], [4, 4]]
    turned = pair_of(puzzle, solution.joins, 0, 1)  # red above green
    assert turned.pixels.shape == (8, 4, 4)
    assert tuple(turned.pixels[3, 0]) == (0, 0, 200, 255)
    assert tuple(turned.pixels[4, 0]) == (0, 200, 0, 255)
    assert np.sort(turned.seam, axis=0).tolist() == [[0, 4], [4, 4]]


def test_pairs_of_turned_pieces_are_cut_from_the_picture():
    puzzle, truth = cut_small(turned=True, seed=2)
    solution = true_solution(puzzle, truth)
    layout = arrange(puzzle, solution)
    picture = compose(layout).levels[0]
    for row, (a, _, b, _) in enumerate(solution.joins.sides.tolist()):
        pair = pair_of(puzzle, solution.joins, row, int(truth.turns[a]))
        x, y = np.minimum(truth.position[a], truth.position[b])
        h, w = pair.pixels.shape[:2]
        assert (pair.pixels == picture[y : y + h, x : x + w]).all()


def test_stretching_tells_dark_borders_apart_and_keeps_what_is_transparent():
    dark = Puzzle((flat([10, 10, 10], 8, 8), flat([14, 14, 14], 8, 8), flat([250, 250, 250], 8, 8)))
    joins = Joins(np.array([[0, 1, 1, 3]]), np.array([[8, 2]]), np.zeros(1), np.ones(1))
    pair = stretched(pair_of(dark, joins, 0, 0))
    assert pair.pixels.shape == (10, 16, 4)
    assert tuple(pair.pixels[3, 7]) == (0, 0, 0, 255)
    assert tuple(pair.pixels[3, 8]) == (255, 255, 255, 255)
    assert tuple(pair.pixels[0, 12]) == (0, 0, 0, 0)


def test_a_short_seam_is_seen_whole_and_a_long_one_in_part(world):
    puzzle, solution, _ = world
    pair = pair_of(puzzle, solution.joins, 0, 0)
    view = window_on(pair, 320, 200)
    ends = pair.seam * view.scale + (view.x, view.y)
    assert view.scale >= 10
    assert ((ends >= 0) & (ends <= (320, 200))).all()
    assert ends.mean(axis=0).tolist() == [160, 100]
    long = Puzzle((flat([1, 1, 1], 400, 6), flat([2, 2, 2], 400, 6)))
    joins = Joins(np.array([[0, 2, 1, 0]]), np.array([[0, 6]]), np.zeros(1), np.ones(1))
    pair = pair_of(long, joins, 0, 0)
    views = [window_on(pair, 320, 200, slide) for slide in (-1, 0, 1)]
    assert {view.scale for view in views} == {2.0}
    first, last = (pair.seam * view.scale + (view.x, view.y) for view in (views[0], views[2]))
    assert 0 <= first[0][0] <= 320
    assert 0 <= last[1][0] <= 320


def test_dragging_a_long_close_up_slides_along_the_seam(qtbot):
    long = Puzzle((flat([1, 1, 1], 400, 6), flat([2, 2, 2], 400, 6)))
    joins = Joins(np.array([[0, 2, 1, 0]]), np.array([[0, 6]]), np.zeros(1), np.ones(1))
    closeup = JoinCloseup()
    qtbot.addWidget(closeup)
    closeup.resize(320, 200)
    closeup.show_pair(pair_of(long, joins, 0, 0))
    qtbot.mousePress(closeup, Qt.MouseButton.LeftButton, pos=QPoint(200, 100))
    qtbot.mouseMove(closeup, QPoint(100, 100))
    qtbot.mouseRelease(closeup, Qt.MouseButton.LeftButton, pos=QPoint(100, 100))
    before = window_on(closeup.pair, 320, 200)
    after = window_on(closeup.pair, 320, 200, closeup.slide)
    assert after.x == pytest.approx(before.x - 100, abs=12)


def test_a_partner_is_picked_by_a_click(qtbot, world):
    puzzle, solution, _ = world
    strip = PartnerStrip()
    qtbot.addWidget(strip)
    strip.resize(330, strip.height())
    pairs = [Partner(pair_of(puzzle, solution.joins, k, 0), ".5", "#FFB000", k == 0, "") for k in range(4)]
    strip.show_partners(tuple(pairs[:3]))
    with qtbot.waitSignal(strip.picked) as heard:
        qtbot.mouseClick(strip, Qt.MouseButton.LeftButton, pos=QPoint(2 * (strip.SIZE + strip.GAP) + 10, 10))
    assert heard.args == [2]
    with qtbot.assertNotEmitted(strip.picked):
        qtbot.mouseClick(strip, Qt.MouseButton.LeftButton, pos=QPoint(3 * (strip.SIZE + strip.GAP) + 10, 10))
    assert colour(strip, 25, 38) == (200, 0, 0)
    assert colour(strip, 50, 38) == (0, 200, 0)
