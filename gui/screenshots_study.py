"""Pictures of what researchers see: the steps of a new study, the page of results, and the dialogs, on the bundled examples."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .main_window import MainWindow

SIMULATED = (("anna", 0.05, 9000), ("ben", 0.12, 6500), ("carla", 0.3, 1500))  # share of wrong answers, milliseconds a vote


def take_study(window: "MainWindow", folder: Path, wait: Callable, shot: Callable) -> None:
    """Make a study of the bundled pairs with answers of simulated volunteers, and take a picture of everything about it."""
    path = folder / "examples.db"
    make_study(path)
    window.judging.open(path)
    wait(lambda: window.session.state.study == str(path))
    window.show_page("results")
    page = window.results
    for name in page.sections:
        page.choose(name)
        wait(lambda name=name: page.stack.currentWidget() is page.sections[name])
        if name == "disputed":
            wait(lambda: not isinstance(page.disputed.preview.shown, str))
        if name == "volunteers":
            page.volunteers.table.selectRow(2)
        shot(f"results-{name}")
    page.choose("precision")
    page.precision.thesis.setChecked(True)
    shot("results-thesis")
    page.precision.thesis.setChecked(False)
    _dialogs(window, wait, shot)
    _wizard(window, shot)


def make_study(path: Path) -> None:
    """A study of all bundled pairs under three methods, and answers of three simulated volunteers of unequal care."""
    from annotation.demo import judge_examples
    from annotation.study import answers, create_study, record_vote
    from engine.progress import silent

    with create_study(path, name="Bundled examples", votes=3) as study:
        judge_examples(study, silent)
        rng = random.Random(0)
        for item, right in sorted(answers(study, "truth").items()):
            for code, errs, pace in SIMULATED:
                wrong = {"correct": "wrong", "wrong": "correct"}[right]
                given = rng.choices((right, wrong, "unsure"), (1 - errs, errs, 0.04))[0]
                said = "the handle could be a spout" if rng.random() < 0.02 else ""
                record_vote(study, item, code, given, comment=said, active_ms=int(pace * rng.uniform(0.5, 1.6)))


def _dialogs(window: "MainWindow", wait: Callable, shot: Callable) -> None:
    from PySide6.QtWidgets import QApplication, QDialog

    for name in ("open-server", "send-packet", "top-up", "invite", "export-votes", "archive"):
        window.actions_by_id[name].trigger()
        wait(lambda: QApplication.activeModalWidget() is not None)
        shot(f"dialog-{name}", QApplication.activeModalWidget())
        for dialog in window.findChildren(QDialog):
            dialog.reject()


def _wizard(window: "MainWindow", shot: Callable) -> None:
    from .pages.study.wizard import STEPS, StudyWizard

    window.actions_by_id["new-study"].trigger()
    wizard = window.findChildren(StudyWizard)[-1]
    for number, (name, *_) in enumerate(STEPS):
        if name == "checks":
            wizard.checks.source.buttons["own"].setChecked(True)
        shot(f"wizard-{number + 1}-{name}", wizard)
        wizard.forward() if number < len(STEPS) - 1 else wizard.reject()
