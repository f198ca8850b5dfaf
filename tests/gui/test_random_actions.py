"""Hundreds of random actions on all pages of shapes: no exception, no widget left behind, and the window still works."""

import random

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QDialog, QFileDialog, QInputDialog

from engine.shapes.families.collection import off_text
from gui import actions
from gui.main_window import MainWindow
from gui.pages.shapes.arrange import SHOWN
from gui.pages.study.wizard import StudyWizard

ACTIONS = 300


def settle(window, qtbot):
    qtbot.waitUntil(lambda: not (window.jobs.busy() or window.study_jobs.busy() or window.studies.jobs.busy()), timeout=60_000)


@pytest.fixture
def meshes(tmp_path, make_bar):
    """Three bars, the last without labels, and a file that is none."""
    paths = []
    for sections, name in ((4, "long"), (3, "short"), (5, "bare")):
        bar = make_bar(sections)
        paths.append(tmp_path / f"{name}.off")
        paths[-1].write_text(off_text(bar.mesh))
        if name != "bare":
            paths[-1].with_suffix(".seg").write_text("\n".join(map(str, bar.segmentation.labels)))
    (tmp_path / "broken.off").write_text("OFF\n1 1 0\n0 0")
    return [str(path) for path in paths]


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch):
    monkeypatch.setenv("CONCORD_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("CONCORD_CACHE", str(tmp_path / "cache"))
    for name in ("getOpenFileName", "getSaveFileName"):
        monkeypatch.setattr(QFileDialog, name, lambda *_, **__: ("", ""))
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *_, **__: ([], ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_, **__: "")
    monkeypatch.setattr(QInputDialog, "getText", lambda *_, **__: ("", False))
    made = MainWindow(dark=False)
    made.furnish()
    qtbot.addWidget(made)
    made.show()
    qtbot.waitUntil(lambda: made.judging.handle is not None)
    yield made
    made.close()


class Hands:
    """What a hand can do beside the commands, wherever it happens to be."""

    def __init__(self, window, meshes, rng):
        self.window, self.meshes, self.rng = window, meshes, rng
        window.segments.ask = lambda _text, _more, answers: rng.choice(list(answers))
        self.commands = [row.id for row in actions.TABLE if row.id not in ("quit", "solve", "alone")]
        self.kinds = (self.command, self.command, self.command, self.slide, self.prefer, self.look, self.segment, self.support,
                      self.part, self.edit_segments, self.number, self.collection_value, self.drop, self.results, self.plan)  # fmt: skip

    def __call__(self):
        self.rng.choice(self.kinds)()

    def command(self):
        action = self.window.actions_by_id[self.rng.choice(self.commands)]
        action.trigger() if action.isEnabled() else None

    def slide(self):
        row = self.rng.choice([r for r in self.window.shapes.form.rows.values() if r.slider and r.info.live])
        row.slider.setValue(self.rng.randint(0, row.slider.maximum()))

    def prefer(self):
        presets = self.window.shapes.presets
        presets.textActivated.emit(presets.itemText(self.rng.randrange(presets.count())))

    def look(self):
        self.window.shapes.filter.activated.emit(self.rng.randrange(len(SHOWN)))
        self.window.shapes.list.ordered.emit(self.rng.choice(("score", "-votes", "support", "state")))

    def segment(self):
        self.window.shapes.view.segment_clicked.emit(self.rng.randint(0, 1), self.rng.randint(0, 2))

    def support(self):
        self.window.shapes.least.slider.setValue(self.rng.randint(0, 20))

    def part(self):
        desk = self.window.collection
        found, page = desk.session.state.found, desk.page.made
        if found is not None:
            page.view.part_clicked.emit(self.rng.randint(-1, found.part_count - 1))
            page.view.shape_clicked.emit(self.rng.randrange(len(found.names)))
            page.pair_wanted.emit(self.rng.randrange(len(found.pairs)))

    def edit_segments(self):
        desk = self.window.segments
        if desk.state.labels is None:
            return
        face = self.rng.randrange(len(desk.state.labels))
        self.rng.choice((
            lambda: desk.pick(face, False), lambda: desk.pick(face, True), lambda: desk.paint([face]), desk.session.settle,
            lambda: desk.cut(np.arange(len(desk.state.labels)) - self.rng.randint(3, 12) + 0.5, face),
            lambda: desk.edit_parameter("segments", self.rng.randint(2, 9), True), desk.segment, desk.done,
        ))()  # fmt: skip

    def number(self):
        row = self.rng.choice(self.window.shapes.automatic.rows)
        if not row.isHidden():
            row.numbered.emit(self.rng.randint(2, 9))

    def collection_value(self):
        row = self.rng.choice([r for r in self.window.collection.page.made.form.rows.values() if r.slider]
                              if self.window.collection.page.made else [None])  # fmt: skip
        if row is not None:
            row.slider.setValue(self.rng.randint(0, row.slider.maximum()))

    def results(self):
        page = self.window.results
        self.window.show_page("results")
        self.rng.choice((*page.bar.buttons.values(), page.precision.thesis)).click()
        page.volunteers.buttons[self.rng.choice(("packet", "merge", "invite"))].click()

    def plan(self):
        """Wander about in the steps of a new study, with whatever the window shows, and leave it."""
        self.window.studies.new_study()
        wizard = [one for one in self.window.findChildren(StudyWizard) if not one.gone][-1]
        rows = [row for step in wizard.steps if hasattr(step, "form") for row in step.form.rows.values()]
        rows += wizard.sample.expectations.rows.values()
        for _ in range(12):
            row = self.rng.choice(rows)
            self.rng.choice((
                lambda: wizard.go(self.rng.randrange(5)), wizard.forward, wizard.back.click, wizard.sample.use.click,
                lambda: self.rng.choice([*wizard.checks.source.buttons.values(), *wizard.place.ways.buttons.values()]).click(),
                lambda row=row: row.show_value(self.rng.choice(("", "x" * 500, "=1")) if row.text else self.rng.choice((0, 1, 9))),
            ))()  # fmt: skip
            if wizard.number == len(wizard.steps) - 1:  # nothing is made here
                wizard.show_step(0)
        QApplication.processEvents()

    def drop(self):
        broken = self.meshes[0].replace("long.off", "broken.off")
        self.window.files.drop(self.rng.choice((self.meshes[:2], self.meshes[1:], self.meshes, [self.meshes[0], broken], ["x.pdf"])))


def test_hundreds_of_random_actions_leave_nothing_behind(window, meshes, qtbot, monkeypatch):
    unexpected, widgets = [], []
    monkeypatch.setattr("sys.excepthook", lambda kind, error, trace: unexpected.append(error))
    window.jobs.failed.connect(lambda text, _: unexpected.append(text) if "should not have" in text else None)
    window.judging.failed.connect(lambda *texts: unexpected.append(texts))
    act = Hands(window, meshes, random.Random(7))
    for step in range(ACTIONS):
        act()
        QApplication.processEvents()
        for dialog in window.findChildren(QDialog):
            dialog.reject()
        assert unexpected == [], f"step {step}"
        if step % 50 == 49:
            settle(window, qtbot)
            widgets.append(len(QApplication.allWidgets()))
    assert unexpected == []
    assert widgets[-1] <= widgets[len(widgets) // 2] + 5, widgets
    window.segments.ask = lambda *_: "discard"
    window.files.pair(*meshes[:2])
    settle(window, qtbot)
    assert np.isfinite(window.session.state.result.score).all()
