"""The view of a join: what it is drawn from, where the seam runs, how the pieces are pulled apart and laid out."""

import base64

import numpy as np
import pytest
from PySide6.QtGui import QColor

from engine.errors import BadInput
from engine.puzzles.imagefile import png_bytes
from gui.palette import LIGHT
from gui.views.join import JoinPicture, JoinView, Placed, join_picture, layout, pulled_apart, seam

RED, BLUE = (200, 30, 30, 255), (30, 30, 200, 255)


def plain(colour, w, h, x, y) -> Placed:
    return Placed(np.full((h, w, 4), colour, np.uint8), x, y)


def beside() -> JoinPicture:
    """A red square of 4 pixels and a blue one at its right, one pixel lower."""
    return JoinPicture((8, 5), (plain(RED, 4, 4, 0, 0), plain(BLUE, 4, 4, 4, 1)))


def payload(picture: JoinPicture) -> dict:
    pieces = [{"piece": "p", "x": p.x, "y": p.y, "png": base64.b64encode(png_bytes(p.rgba)).decode()} for p in picture.pieces]
    return {"size": list(picture.size), "pieces": pieces}


def test_a_payload_becomes_the_picture_that_it_was_made_of():
    found = join_picture(payload(beside()))
    assert found.size == (8, 5)
    for piece, wanted in zip(found.pieces, beside().pieces, strict=True):
        assert np.array_equal(piece.rgba, wanted.rgba)
        assert piece.box == wanted.box


@pytest.mark.parametrize(
    "damage",
    [
        lambda p: p.pop("size"),
        lambda p: p["pieces"].pop(),
        lambda p: p["pieces"][0].update(png="no base 64"),
        lambda p: p["pieces"][0].update(png=base64.b64encode(b"no picture").decode()),
        lambda p: p["pieces"][0].update(x=-1),
        lambda p: p["pieces"][1].update(x=10**9),
        lambda p: p["pieces"][1].update(y=None),
        lambda p: p.update(size=[10**9, 10**9]),
    ],
)
def test_a_damaged_payload_is_one_sentence(damage):
    content = payload(beside())
    damage(content)
    with pytest.raises(BadInput, match="in this study"):
        join_picture(content)


def test_the_seam_is_where_the_pieces_touch():
    assert sorted(seam(beside()).tolist()) == [[4, 1], [4, 4]]
    above = JoinPicture((4, 8), (plain(RED, 4, 4, 0, 0), plain(BLUE, 4, 4, 0, 4)))
    assert sorted(seam(above).tolist()) == [[0, 4], [4, 4]]
    apart = JoinPicture((9, 4), (plain(RED, 4, 4, 0, 0), plain(BLUE, 4, 4, 5, 0)))
    assert seam(apart) is None


def test_a_slanted_seam_runs_from_corner_to_corner():
    red, blue = (np.full((6, 6, 4), colour, np.uint8) for colour in (RED, BLUE))
    low = np.tri(6, dtype=bool)
    red[~low], blue[low] = 0, 0
    ends = sorted(seam(JoinPicture((6, 6), (Placed(red, 0, 0), Placed(blue, 0, 0)))).tolist())
    assert np.abs(np.array(ends) - [[0, 0], [6, 6]]).max() <= 1


def test_pieces_are_pulled_apart_across_the_seam():
    found = pulled_apart(beside())
    (left, top, right, _), (left2, top2, right2, _) = (p.box for p in found.pieces)
    assert (left, top, top2) == (0, 0, 1)  # straight to the right, though the middles are not level
    assert left2 > right
    assert (right2, 5) == found.size
    turned = pulled_apart(JoinPicture((8, 5), beside().pieces[::-1]))
    assert turned.pieces[0].box[0] > turned.pieces[1].box[2]
    assert all(p.x >= 0 and p.y >= 0 for p in turned.pieces)


@pytest.mark.parametrize("view", [(1240, 520), (500, 700), (320, 200)])
@pytest.mark.parametrize("sizes", [((56, 28), (63, 28)), ((28, 56), (28, 63)), ((160, 160), (200, 160)), ((5, 3), (6, 3))])
@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0])
def test_both_pictures_have_their_room(view, sizes, ratio):
    large, small = layout(*sizes, view, ratio)
    for box, (w, h) in ((large, sizes[0]), (small, sizes[1])):
        assert box.left() >= 0
        assert box.top() >= 0
        assert box.right() <= view[0]
        assert box.bottom() <= view[1]
        assert box.width() / w == pytest.approx(box.height() / h)
        pixel = box.width() / w * ratio
        assert pixel < 1 or pixel == pytest.approx(round(pixel))
    assert large.right() < small.left()
    assert small.width() / sizes[1][0] <= large.width() / sizes[0][0]


def test_the_pieces_are_drawn_sharp_and_bare_at_the_seam(qtbot):
    view = JoinView()
    qtbot.addWidget(view)
    view.resize(900, 400)
    view.set_picture(join_picture(payload(beside())))
    view.set_theme(LIGHT)
    image = view.grab().toImage()
    large, _ = layout((8, 5), pulled_apart(beside()).size, (900, 400), image.devicePixelRatio())
    scale = large.width() / 8
    middle = int(large.top() + 2.5 * scale)
    seam_at = round(large.left() + 4 * scale)
    assert image.pixelColor(seam_at - 1, middle) == QColor(*RED)
    assert image.pixelColor(seam_at, middle) == QColor(*BLUE)
    above = QColor(image.pixelColor(seam_at, int(large.top() + scale - 8)))  # the mark beyond the seam's upper end
    assert above == QColor(LIGHT.accent)
