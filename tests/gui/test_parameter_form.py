"""The form is the declaration: ranges, steps, choices, help, and who may speak when."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox

from engine.parameters import Parameters, declared, parameter
from engine.shapes.parameters import PRESETS, MatchParameters, preset
from gui.parameter_form import ParameterForm, applies, caption, help_text, live_groups_first, scale

INFO = {info.name: info for info in declared(MatchParameters)}
RIGID = preset("thesis-rigid")


@pytest.fixture
def form(qtbot):
    made = ParameterForm(MatchParameters)
    qtbot.addWidget(made)
    made.show_values(RIGID, RIGID)
    made.resize(330, 900)
    made.show()
    return made


@pytest.fixture
def heard(form):
    said = []
    form.edited.connect(lambda *what: said.append(what))
    return said


@pytest.mark.parametrize("info", [i for i in INFO.values() if scale(i)], ids=lambda i: i.name)
def test_a_scale_covers_the_declared_range(info):
    s = scale(info)
    assert s.value(0) == info.low
    assert s.value(s.steps) == pytest.approx(info.high, abs=s.step / 2)
    assert s.value(s.position(info.default)) == pytest.approx(info.default)
    assert isinstance(s.value(1), int) == (info.kind == "integer")
    assert s.position(s.value(1)) == 1


def test_every_parameter_has_the_editor_of_its_kind(form):
    kinds = {"switch": QCheckBox, "choice": QComboBox, "real": QDoubleSpinBox, "integer": QDoubleSpinBox}
    assert sorted(form.rows) == sorted(INFO)
    for name, row in form.rows.items():
        assert isinstance(row.editor, kinds[INFO[name].kind]), name
    assert form.rows["delta_1"].slider is not None
    assert form.rows["seed"].slider is None  # two thousand million positions are no slider


def test_choices_are_the_declared_ones(form):
    combo = form.rows["mode"].editor
    assert tuple(combo.itemText(k) for k in range(combo.count())) == INFO["mode"].choices


def test_moving_to_either_end_emits_the_declared_limits(form, heard):
    for name in ("delta_1", "K", "touch_distance", "layers"):
        slider, info = form.rows[name].slider, INFO[name]
        slider.setValue(slider.minimum())
        slider.setValue(slider.maximum())
        assert [what[1] for what in heard if what[0] == name][-2:] == [info.low, info.high]
    assert all(settled for _, _, settled in heard)


def test_showing_values_tells_nobody(form, heard):
    form.show_values(preset("thesis-nonrigid").changed(K=3, voting=False, anchors="off", seed=5), RIGID)
    assert heard == []
    assert form.rows["delta_1"].editor.value() == 0.8
    assert form.rows["delta_1"].slider.value() == 80
    assert not form.rows["voting"].editor.isChecked()
    assert form.rows["anchors"].editor.currentText() == "off"


def test_a_live_slider_is_followed_while_it_moves(form, heard, qtbot):
    slider = form.rows["delta_1"].slider
    slider.setSliderDown(True)
    slider.setSliderPosition(30)
    qtbot.waitUntil(lambda: heard == [("delta_1", 0.3, False)])
    slider.setSliderPosition(35)
    slider.setSliderDown(False)
    qtbot.waitUntil(lambda: heard[-1] == ("delta_1", 0.35, True))


def test_an_expensive_slider_speaks_when_it_is_let_go(form, heard, qtbot):
    row = form.rows["layers"]
    row.slider.setSliderDown(True)
    row.slider.setSliderPosition(9)
    qtbot.wait(40)
    assert heard == []
    assert row.editor.value() == row.scale.value(9)  # but the number moves along
    row.slider.setSliderDown(False)
    assert heard == [("layers", row.scale.value(9), True)]


def test_a_slider_in_hand_is_not_pulled_back(form):
    row = form.rows["delta_1"]
    row.slider.setSliderDown(True)
    row.slider.setSliderPosition(40)
    form.show_values(RIGID.changed(delta_1=0.39), RIGID)
    assert row.slider.value() == 40
    row.slider.setSliderDown(False)


def test_typed_numbers_stay_in_the_range(form, heard, qtbot):
    box = form.rows["c_0"].editor
    box.lineEdit().selectAll()
    qtbot.keyClicks(box.lineEdit(), "0.5")
    qtbot.keyClick(box.lineEdit(), Qt.Key.Key_Return)
    assert heard == [("c_0", 0.5, True)]
    box.setValue(7)
    assert heard[-1] == ("c_0", 0.99, True)


def test_dot_and_reset_where_a_value_differs(form, heard):
    row = form.rows["K"]
    assert (row.dot.text(), row.reset.isEnabled()) == ("", False)
    form.show_values(RIGID.changed(K=9), RIGID)
    assert (row.dot.text(), row.reset.isEnabled()) == ("●", True)
    row.reset.click()
    assert heard == [("K", 7, True)]


@pytest.mark.parametrize("name", PRESETS)
def test_only_parameters_of_the_method_are_visible(form, name):
    values = preset(name)
    form.show_values(values, values)
    visible = set(form.visible_names())
    assert visible == {i.name for i in INFO.values() if applies(i, values.method)}
    assert ("delta_1" in visible) == (values.method in ("thesis", "bottom"))
    for group, (head, rows) in form._heads.items():
        assert head.isHidden() == (not any(row.info.name in visible for row in rows)), group


def test_the_wheel_scrolls_and_changes_nothing(form, heard, qtbot):
    from PySide6.QtCore import QPointF
    from PySide6.QtGui import QWheelEvent
    from PySide6.QtWidgets import QApplication

    slider = form.rows["delta_1"].slider
    none, at = Qt.KeyboardModifier.NoModifier, QPointF(5, 5)
    event = QWheelEvent(at, slider.mapToGlobal(at), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton, none,
                        Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(slider, event)
    assert heard == []
    assert slider.value() == 20


def test_help_holds_what_was_declared():
    text = help_text(INFO["delta_1"], 0.2)
    for piece in (INFO["delta_1"].doc, "Equation 3.3", "0 to 1 diameter", "preset: 0.2", "while you move"):
        assert piece in text
    assert "let go" in help_text(INFO["layers"], 8)


def test_captions_do_not_say_a_symbol_twice():
    assert caption(INFO["delta_1"]) == "δ₁"
    assert caption(INFO["K"]) == "K"
    assert caption(INFO["layers"]) == "L  layers"
    assert caption(INFO["node_cap"]) == "node cap"


def test_any_group_of_parameters_makes_a_form(qtbot):
    class Two(Parameters):
        gap: float = parameter(0.5, "A gap.", low=0.0, high=2.0, symbol="g", group="Pieces")
        turn: bool = parameter(True, "Turned pieces.", group="Pieces")

    form = ParameterForm(Two)
    qtbot.addWidget(form)
    form.show_values(Two(gap=1.0), Two())
    assert form.rows["gap"].slider.maximum() == 100
    assert form.rows["gap"].slider.value() == 50


def test_groups_that_follow_a_slider_come_first_and_keep_their_order():
    groups = list(dict.fromkeys(info.group for info in live_groups_first(declared(MatchParameters))))
    live = {info.group for info in declared(MatchParameters) if info.live}
    assert groups[: len(live)] == ["Method", "Candidates", "Pruning", "Voting", "Further descriptors"]
    assert groups[len(live) :] == ["Segment graph", "Multi-layer graph", "Descriptor"]
