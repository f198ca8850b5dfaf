"""The volunteers' window on a server: the login's own code, and a server that goes away in between."""

import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from test_volunteer import press, windows  # noqa: F401  (the fixture)
from test_volunteer_blind import reachable, texts
from voting_world import SECRETS, make_study, settle

from annotation import study
from annotation.server import invitations

sys.path.append(str(Path(__file__).parents[1] / "annotation"))
from postgres_server import Unavailable, running

K = Qt.Key


@pytest.fixture(scope="module")
def server():
    """A PostgreSQL server of its own, which a test may stop; skips where its programs are missing."""
    try:
        with running() as started:
            yield started
    except Unavailable as error:
        pytest.skip(f"no PostgreSQL server for tests: {error}")


def test_an_answer_outlives_a_server_that_goes_away(server, qtbot, windows, make_bar):  # noqa: F811
    address = server.database()
    ids = make_study(address, make_bar, practice=1, gold=1, joins=1, votes=2)
    with study.open_study(address) as owner:
        hers = invitations.invite(owner, "anna")
    window = windows(hers, "")
    assert window.desk.code == "anna"
    assert window.desk.question.asked == (ids["practice"][0], 0)
    press(qtbot, window, K.Key_J, K.Key_Return, K.Key_F)
    question = window.desk.question
    said = "\n".join([*texts(window), *reachable(window.desk, window.screen)])
    assert not [name for name, secret in SECRETS.items() if secret in said]
    server.control("stop", "-m", "immediate")
    press(qtbot, window, K.Key_J)
    assert window.desk.question is question
    assert window.screen.trouble.isVisible()
    sentence = window.screen.trouble.words.text()
    assert "\n" not in sentence
    assert "Traceback" not in sentence
    assert hers.split(":")[2].split("@")[0] not in sentence  # the password
    server.control("start", "-w")
    qtbot.mouseClick(window.screen.trouble.button, Qt.MouseButton.LeftButton)
    settle(qtbot, window.desk)
    assert window.desk.question is not question
    with study.open_study(address) as owner:
        assert study.answers(owner, "anna")[question.asked.item_id] == "correct"
        assert len(study.answers(owner, "anna")) == 2
    press(qtbot, window, K.Key_C)
    qtbot.keyClicks(window.screen.comment.line, "odd cut")
    qtbot.keyClick(window.screen.comment.line, K.Key_Return)
    press(qtbot, window, K.Key_J, K.Key_Backspace)
    assert "✓" in window.screen.small.tools["comment"].text()  # her own words may be read back under her own login
