"""A study on a server, from the researcher's window: made, shared with a volunteer, opened again, and out of reach."""

import sys
from pathlib import Path

import pytest
from PySide6.QtWidgets import QDialog, QLineEdit
from research_world import made_window, runs_of_bars, settle

from annotation import study
from annotation.design.designing import Design, create_design
from gui.pages.ask_dialog import AskDialog
from gui.pages.study.sources import Source
from gui.pages.study.wizard import STEPS, StudyWizard

sys.path.append(str(Path(__file__).parents[1] / "annotation"))
from postgres_server import Unavailable, running


@pytest.fixture(scope="module")
def server():
    """A PostgreSQL server of its own; skips where its programs are missing."""
    try:
        with running() as started:
            yield started
    except Unavailable as error:
        pytest.skip(f"no PostgreSQL server for tests: {error}")


@pytest.fixture
def window(qtbot, tmp_path, monkeypatch):
    yield from made_window(qtbot, tmp_path, monkeypatch)


def shown(window, kind=QDialog):
    return [dialog for dialog in window.findChildren(kind) if dialog.isVisible()][-1]


def on_server(window, qtbot):
    qtbot.waitUntil(lambda: window.session.state.study.startswith("postgresql"), timeout=30_000)
    settle(window, qtbot)


def test_a_study_is_made_on_a_server_and_a_volunteer_gets_an_address(server, window, qtbot, make_bar, tmp_path):
    address = server.database()
    password = address.split(":")[2].split("@")[0]
    window.actions_by_id["new-study"].trigger()
    settle(window, qtbot)
    wizard = shown(window, StudyWizard)
    runs, shapes = runs_of_bars(make_bar)
    wizard.results.add(Source("bars", tuple(runs), tuple(shapes)))
    for _ in STEPS[1:]:
        wizard.forward()
    wizard.place.ways.buttons["server"].click()
    wizard.place.path.line.setText(address.replace(f":{password}", ""))
    wizard.place.password.setText(password)
    wizard.next.click()
    on_server(window, qtbot)
    assert study.items(window.judging.handle, "me")
    window.actions_by_id["invite"].trigger()
    dialog = shown(window, AskDialog)
    dialog.editors["code"].setText("anna")
    dialog.ok.click()
    settle(window, qtbot)
    command = shown(window).findChild(QLineEdit).text()
    assert command.startswith("concord vote 'postgresql://")
    shown(window).accept()
    window.studies.open(command.split("'")[1])
    qtbot.waitUntil(lambda: window.session.state.volunteer == "anna", timeout=30_000)
    settle(window, qtbot)
    window.show_page("results")
    assert "one volunteer" in window.results.empty.text()
    told = window.windowTitle() + window.session.state.study + window.status.text.text() + window.results.file.text()
    assert password not in told
    assert command.split(":")[2].split("@")[0] not in told
    kept = tmp_path / "data" / "window.ini"
    assert not kept.exists() or password not in kept.read_text()


def test_a_server_that_goes_away_is_a_sentence_and_comes_back(server, window, qtbot, make_bar):
    address = server.database()
    create_design(address, runs_of_bars(make_bar)[0], Design(gold=0.0, practice=0)).close()
    window.studies.open(address)
    on_server(window, qtbot)
    handle = window.judging.handle
    server.control("stop", "-m", "immediate")
    window.show_page("results")
    qtbot.waitUntil(lambda: window.messages.isVisible(), timeout=30_000)
    settle(window, qtbot)
    assert "Traceback" not in window.messages.text.text()
    assert address.split(":")[2].split("@")[0] not in window.messages.text.text() + window.messages.details
    assert window.judging.handle is handle
    server.control("start", "-w")
    window.messages.dismiss()
    window.results.begin()
    settle(window, qtbot)
    assert window.results.stack.currentWidget() is window.results.precision
    assert [row.matches for row in window.results.content.rows] == [4, 6]
