"""The volunteers' window: from the welcome to the thanks, with keys alone, and nothing lost on the way."""

import sqlite3
import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from voting_world import REASON, make_study, put_roles, settle

from annotation import study
from engine.errors import BadInput
from gui.pages.voting import desk as voting_desk
from gui.pages.voting.questions import Question
from gui.volunteer import SMALLEST, VolunteerWindow

K = Qt.Key


@pytest.fixture
def windows(qtbot):
    """Opens volunteers' windows and closes them in the end."""
    made = []

    def opened(path, code="anna", *, start=True):
        window = VolunteerWindow(str(path), code, dark=False)
        qtbot.addWidget(window)
        window.resize(1024, 700)
        window.show()
        window.begin()
        made.append(window)
        if start:
            qtbot.waitUntil(lambda: window.screen.notice.heading.text().startswith("Welcome"), timeout=20_000)
            press(qtbot, window, K.Key_Return)
        return window

    yield opened
    for window in made:
        window.desk.unsaved = False
        window.close()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "bars.study"


def press(qtbot, window, *keys):
    for key in keys:
        qtbot.keyClick(window.screen, key)
        settle(qtbot, window.desk)


def heading(window):
    return window.screen.notice.heading.text() if window.screen.whole.currentIndex() == 1 else ""


def current(path, code="anna"):
    """The volunteer's current votes as another program reads them: (item, round) to answer."""
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as connection:
        rows = connection.execute("SELECT item_id, round, answer FROM current_vote WHERE volunteer = ?", (code,))
        return {row[:2]: row[2] for row in rows}


def test_practice_comes_first_with_its_reasons_and_counts_in_no_table(qtbot, windows, path, make_bar):
    ids = make_study(path, make_bar)
    window = windows(path)
    for key, words in ((K.Key_J, "Right!"), (K.Key_F, "Not quite: you said Wrong, the right answer is Correct.")):
        assert window.desk.question.asked.item_id in ids["practice"]
        assert "practice" in window.screen.small.counter.text()
        press(qtbot, window, key)
        assert words in window.screen.told.heading.text()
        assert window.screen.told.reason.text() == REASON
        press(qtbot, window, K.Key_J, K.Key_F)  # only Enter and Space go on
        press(qtbot, window, K.Key_Return)
    assert set(current(path)) == {(item, 0) for item in ids["practice"]}
    assert sorted(current(path).values()) == ["correct", "wrong"]
    assert window.desk.question.asked.round == 1
    assert window.screen.small.counter.text() == "0 of 8"


def test_everything_is_asked_once_then_thanks(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    asked = []
    while window.desk.question is not None:
        asked.append(window.desk.question.asked)
        before = len(current(path))
        press(qtbot, window, (K.Key_J, K.Key_F, K.Key_Space)[len(asked) % 3])
        assert len(current(path)) == before + 1  # it is on the disk before the next one shows
    assert len(asked) == len(set(asked)) == 10
    assert heading(window) == "All done, thank you!"
    assert "10 questions" in window.screen.notice.text.text()
    assert set(current(path).values()) == {"correct", "wrong", "unsure"}
    press(qtbot, window, K.Key_Backspace)
    assert window.desk.question.asked == asked[-1]
    assert len(current(path)) == 9


def test_a_vote_carries_times_sides_and_view(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, joins=0)
    window = windows(path)
    question = window.desk.question
    press(qtbot, window, K.Key_C)
    qtbot.keyClicks(window.screen.comment.line, " joint fuzzy; no ")
    qtbot.keyClick(window.screen.comment.line, K.Key_Return)
    press(qtbot, window, K.Key_J)
    (vote,) = study.current_votes(window.handle, volunteer="anna")
    assert vote.comment == "joint fuzzy; no"
    assert vote.presentation["left"] == ("target" if question.swapped else "source")
    for one in vote.presentation["view"]:
        assert sum(x * x for x in one) == pytest.approx(1.0, abs=0.01)
    assert 0 <= vote.active_ms <= vote.shown_ms


def test_undo_has_no_end_and_takes_practice_back_too(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=1, gold=0, joins=0)
    window = windows(path)
    first = window.desk.question.asked
    press(qtbot, window, K.Key_J, K.Key_Return, K.Key_F, K.Key_J)
    press(qtbot, window, K.Key_Backspace, K.Key_Backspace, K.Key_Backspace, K.Key_Backspace)
    assert current(path) == {}
    assert window.desk.question.asked == first
    assert window.screen.small.saved.text() == "no answer to take back"
    press(qtbot, window, K.Key_J, K.Key_Return, K.Key_J)
    assert list(current(path).values()) == ["correct", "correct"]
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as connection:
        (events,) = connection.execute("SELECT COUNT(*) FROM event WHERE volunteer = 'anna'").fetchone()
    assert events == 3 + 3 + 2  # nothing is overwritten


def test_another_day_goes_on_where_it_stopped(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=1, gold=0)
    window = windows(path)
    press(qtbot, window, K.Key_J, K.Key_Return, K.Key_F, K.Key_J)
    following = window.desk.question.asked
    press(qtbot, window, K.Key_Escape)
    assert "Everything is saved" in window.screen.notice.text.text()
    press(qtbot, window, K.Key_Escape)
    assert not window.isVisible()
    again = windows(path, start=False)
    qtbot.waitUntil(lambda: heading(again) == "Welcome back", timeout=20_000)
    assert again.screen.notice.text.text() == "You have answered 2 of 9; you go on where you stopped."
    press(qtbot, again, K.Key_Return)
    assert again.desk.question.asked == following
    assert again.screen.small.counter.text().startswith("2 of 9, about")


def test_two_windows_never_ask_the_same(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    one, two = windows(path), windows(path)
    asked = []
    for turn in range(12):
        window = (one, two)[turn % 2]
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        settle(qtbot, window.desk)
        if window.desk.question is None:
            continue
        asked.append(window.desk.question.asked)
        press(qtbot, window, K.Key_J)
    assert len(current(path)) == 10
    assert len(asked) == len(set(asked)) == 10


def test_unsure_is_not_offered_where_the_study_takes_none(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, unsure=False)
    window = windows(path)
    before = window.desk.question
    assert not window.screen.answers.buttons["unsure"].isVisible()
    press(qtbot, window, K.Key_Space)
    assert window.desk.question is before
    assert current(path) == {}
    assert "Unsure" not in window.screen.notice.more.text()


def test_a_vote_that_cannot_be_saved_waits_and_is_not_lost(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    question, record = window.desk.question, study.record_vote

    def full(*_args, **_kwargs):
        raise BadInput("The disk is full; make room and try again.")

    monkeypatch.setattr(voting_desk.study, "record_vote", full)
    press(qtbot, window, K.Key_J)
    assert window.desk.question is question
    assert window.screen.trouble.isVisible()
    assert window.screen.trouble.words.text() == "The disk is full; make room and try again."
    assert window.screen.small.saved.text() == "not saved yet"
    window.close()
    assert window.isVisible()  # said once before going
    assert heading(window) == "Your last answer is not saved yet"
    press(qtbot, window, K.Key_Return)  # in vain
    assert window.screen.trouble.isVisible()
    press(qtbot, window, K.Key_Escape)
    assert heading(window) == "Your last answer is not saved yet"
    assert "The disk is full" in window.screen.notice.trouble.text()
    monkeypatch.setattr(voting_desk.study, "record_vote", record)
    press(qtbot, window, K.Key_Return)
    assert current(path) == {(question.asked.item_id, 1): "correct"}
    assert not window.screen.trouble.isVisible()
    assert window.desk.question is not question


def test_a_window_closed_while_it_saves_waits_for_the_answer(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    record, may = study.record_vote, threading.Event()

    def slow(*args, **kwargs):
        may.wait(10)
        return record(*args, **kwargs)

    monkeypatch.setattr(voting_desk.study, "record_vote", slow)
    qtbot.keyClick(window.screen, K.Key_J)
    window.close()
    assert window.isVisible()
    may.set()
    qtbot.waitUntil(lambda: not window.isVisible(), timeout=10_000)
    assert list(current(path).values()) == ["correct"]


def test_an_unknown_fault_is_a_plain_sentence(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)

    def broken(*_args, **_kwargs):
        raise RuntimeError("SELECT secret FROM run")

    monkeypatch.setattr(voting_desk.study, "record_vote", broken)
    press(qtbot, window, K.Key_J)
    assert "secret" not in window.screen.trouble.words.text()
    assert window.screen.trouble.words.text().startswith("Something went wrong here;")
    qtbot.mouseClick(window.screen.trouble.details, Qt.MouseButton.LeftButton)
    copied = QApplication.clipboard().text()
    assert "RuntimeError" in copied
    assert "in broken" in copied
    assert "secret" not in copied
    monkeypatch.undo()
    press(qtbot, window, K.Key_F)  # another answer instead is as good
    assert list(current(path).values()) == ["wrong"]


def test_a_file_that_was_moved_is_a_sentence_and_comes_back(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    question = window.desk.question
    path.rename(path.with_suffix(".moved"))
    press(qtbot, window, K.Key_J)
    assert "moved, deleted or replaced" in window.screen.trouble.words.text()
    assert window.desk.question is question
    path.with_suffix(".moved").rename(path)
    press(qtbot, window, K.Key_J)
    assert current(path) == {(question.asked.item_id, 1): "correct"}


def test_what_cannot_be_shown_is_counted_at_the_end_alone(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, joins=2, blobs=False)
    window = windows(path)
    assert not isinstance(window.desk.question, Question)
    press(qtbot, window, K.Key_J, K.Key_J)
    assert heading(window) == "All done, thank you!"
    assert "8 matches cannot be shown here." in window.screen.notice.text.text()


def test_a_damaged_match_or_shape_stops_nobody(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, joins=2)
    with sqlite3.connect(path) as connection:
        ids = [row[0] for row in connection.execute("SELECT id FROM item WHERE kind = 'shape' ORDER BY id")]
        for item, payload in zip(ids, ("{", "[]", "{}", '{"source": 1, "target": {}}'), strict=False):
            connection.execute("UPDATE item SET payload = ? WHERE id = ?", (payload, item))
        connection.execute("UPDATE blob SET content = x'504b0304' WHERE key = (SELECT MIN(key) FROM blob)")
    window = windows(path)
    press(qtbot, window, K.Key_J, K.Key_J)
    assert heading(window) == "All done, thank you!"
    assert "8 matches cannot be shown here." in window.screen.notice.text.text()
    assert not window.screen.trouble.isVisible()


def test_codes_are_asked_for_and_unknown_ones_refused_in_a_designed_study(qtbot, windows, path, make_bar):
    make_study(path, make_bar, votes=3)
    window = windows(path, "nobody", start=False)
    qtbot.waitUntil(lambda: heading(window) == "What is your code?", timeout=20_000)
    assert window.screen.notice.trouble.text().startswith("This study knows no volunteer nobody;")
    with study.open_study(path) as handle:
        assert "nobody" not in {one.code for one in study.volunteers(handle)}
    qtbot.mouseClick(window.screen.notice.buttons[1], Qt.MouseButton.LeftButton)  # "I am new here"
    qtbot.waitUntil(lambda: heading(window) == "Welcome", timeout=20_000)
    other = windows(path, "", start=False)
    qtbot.waitUntil(lambda: heading(other) == "What is your code?", timeout=20_000)
    assert other.screen.notice.trouble.text() == ""
    qtbot.keyClicks(other.screen.notice.field, "bad code!")
    press(qtbot, other, K.Key_Return)
    assert "no volunteer code" in other.screen.notice.trouble.text()


@pytest.mark.parametrize("content", [b"", b"no study at all", None])
def test_a_file_that_is_no_study_is_one_sentence(qtbot, windows, path, content):
    if content is not None:
        path.write_bytes(content)
    window = windows(path, start=False)
    qtbot.waitUntil(lambda: heading(window) == "This did not work", timeout=20_000)
    text = window.screen.notice.trouble.text()
    assert path.name in text
    assert "Traceback" not in text
    assert "\n" not in text


def test_what_others_settle_is_not_asked_any_more(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, votes=1)
    with study.open_study(path) as handle:
        put_roles(handle, {})
        study.volunteer(handle, "anna")
    window = windows(path)
    shown = window.desk.question.asked
    with study.open_study(path, backup=False) as handle:
        for one in study.open_items(handle, "anna"):
            if one != shown:
                study.record_vote(handle, one.item_id, "ben", "correct")
    window.desk.refresh()
    settle(qtbot, window.desk)
    press(qtbot, window, K.Key_J)
    assert heading(window) == "All done, thank you!"


def test_everything_can_be_reached_by_tab_and_has_a_name(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, joins=0)
    window = windows(path)
    for button in window.screen.page.findChildren(QPushButton):
        if button.isVisible():
            assert button.accessibleName() or button.text()
            assert button.focusPolicy() & Qt.FocusPolicy.TabFocus
    for button in window.screen.answers.buttons.values():
        assert button.height() >= 60
        assert button.accessibleName()
    assert window.screen.view.accessibleName()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    window.screen.setFocus()
    seen = []
    for _ in range(12):
        qtbot.keyClick(QApplication.focusWidget() or window.screen, K.Key_Tab)
        seen.append(QApplication.focusWidget())
    assert set(window.screen.answers.buttons.values()) <= set(seen)
    window.screen.answers.buttons["wrong"].setFocus()
    qtbot.keyClick(window.screen.answers.buttons["wrong"], K.Key_Space)
    settle(qtbot, window.desk)
    assert list(current(path).values()) == ["wrong"]


def test_a_long_guideline_is_scrolled_by_keys_and_shown_as_plain_text(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0, joins=0)
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE study SET guideline = ?", ("<img src='x.png'>\n" * 80,))
    window = windows(path)
    press(qtbot, window, K.Key_Question)
    bar = window.screen.notice.area.verticalScrollBar()
    assert "&lt;img" in window.screen.notice.more.text()
    qtbot.waitUntil(lambda: bar.maximum() > 0)
    assert bar.value() == 0
    press(qtbot, window, K.Key_PageDown)
    assert bar.value() > 0
    press(qtbot, window, K.Key_Escape)
    assert window.screen.asking


def test_a_key_that_is_held_down_counts_once(qtbot, windows, path, make_bar):
    from PySide6.QtCore import QEvent
    from PySide6.QtGui import QKeyEvent

    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    for _ in range(5):
        QApplication.sendEvent(window.screen, QKeyEvent(QEvent.Type.KeyPress, K.Key_J, Qt.KeyboardModifier.NoModifier, "j", True))
        settle(qtbot, window.desk)
    assert current(path) == {}


@pytest.mark.parametrize("size", [SMALLEST, (1024, 700)])
def test_it_fits_small_screens(windows, path, make_bar, qtbot, size):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    window.resize(*size)
    press(qtbot, window, K.Key_J)
    QApplication.processEvents()
    small = window.screen.small
    small.counter.setText("137 of 240, about 125 min left")
    small.mark_comment(True)
    small.saved.setText("no answer to take back" if size != SMALLEST else "saved ✓")
    assert small.minimumSizeHint().width() <= small.width()
    assert ("(Backspace)" in small.tools["undo"].text()) == (size != SMALLEST)
    assert window.minimumSizeHint().width() <= 1024
    assert window.minimumSizeHint().height() <= 700
    outside = [child for child in window.screen.page.findChildren(QWidget)
               if child.isVisible() and not window.screen.page.rect().contains(child.geometry().translated(
                   child.parentWidget().mapTo(window.screen.page, child.parentWidget().rect().topLeft())
                   if child.parentWidget() is not window.screen.page else child.parentWidget().rect().topLeft()))]  # fmt: skip
    assert outside == []


def test_an_answer_is_given_up_only_where_that_is_said(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)

    def full(*_args, **_kwargs):
        raise BadInput("The disk is full; make room and try again.")

    monkeypatch.setattr(voting_desk.study, "record_vote", full)
    press(qtbot, window, K.Key_J, K.Key_Escape)
    assert "saved." not in window.screen.notice.text.text()
    press(qtbot, window, K.Key_Escape)  # Leave without it
    assert not window.isVisible()
    assert current(path) == {}


def test_a_comment_comes_back_with_an_answer_that_is_taken_back(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    press(qtbot, window, K.Key_C)
    qtbot.keyClicks(window.screen.comment.line, "odd cut")
    qtbot.keyClick(window.screen.comment.line, K.Key_Return)
    assert "✓" in window.screen.small.tools["comment"].text()
    press(qtbot, window, K.Key_J)
    assert "✓" not in window.screen.small.tools["comment"].text()
    press(qtbot, window, K.Key_Backspace)
    assert "✓" in window.screen.small.tools["comment"].text()
    press(qtbot, window, K.Key_F)
    with study.open_study(path, backup=False) as handle:
        assert [(vote.answer, vote.comment) for vote in study.current_votes(handle, volunteer="anna")] == [("wrong", "odd cut")]


def test_where_nothing_is_to_be_done_that_is_said_at_once(qtbot, windows, path, make_bar):
    study.create_study(path, name="Empty", seed="1").close()
    window = windows(path, start=False)
    qtbot.waitUntil(lambda: heading(window) == "Nothing to do", timeout=20_000)
    assert [button.text() for button in window.screen.notice.buttons] == ["Close\nEnter"]
    press(qtbot, window, K.Key_Return)
    assert not window.isVisible()


def test_whoever_is_through_is_thanked_again(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    press(qtbot, window, *[K.Key_J] * 10)
    window.close()
    again = windows(path, start=False)
    qtbot.waitUntil(lambda: heading(again) == "All done, thank you!", timeout=20_000)
    press(qtbot, again, K.Key_Backspace)
    assert again.screen.asking


def test_a_fault_with_one_match_stops_nobody(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0, joins=2)

    def broken(*_args):
        raise RuntimeError("out of textures")

    monkeypatch.setattr("gui.pages.voting.questions.ready_pair", broken)
    window = windows(path)
    press(qtbot, window, K.Key_J, K.Key_J)
    assert heading(window) == "All done, thank you!"
    assert "8 matches cannot be shown here." in window.screen.notice.text.text()


def test_slow_saving_is_said(qtbot, windows, path, make_bar, monkeypatch):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    record, may = study.record_vote, threading.Event()

    def slow(*args, **kwargs):
        may.wait(10)
        return record(*args, **kwargs)

    monkeypatch.setattr(voting_desk.study, "record_vote", slow)
    qtbot.keyClick(window.screen, K.Key_J)
    qtbot.waitUntil(lambda: window.screen.small.saved.text() == "saving …", timeout=10_000)
    may.set()
    settle(qtbot, window.desk)
    assert window.screen.small.saved.text() == "saved ✓"


def test_after_practice_only_what_works_is_offered(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=1, gold=0)
    window = windows(path)
    press(qtbot, window, K.Key_J)
    assert [name for name, button in window.screen.small.tools.items() if button.isVisible()] == ["undo", "reset", "turn", "guide"]
    press(qtbot, window, K.Key_Return)
    assert window.screen.small.tools["skip"].isVisible()


def test_a_fault_in_opening_can_be_handed_on(qtbot, windows, path, monkeypatch):
    def broken(*_args, **_kwargs):
        raise RuntimeError("zq-secret")

    monkeypatch.setattr("gui.volunteer.study.open_study", broken)
    window = windows(path, start=False)
    qtbot.waitUntil(lambda: heading(window) == "This did not work", timeout=20_000)
    assert "zq-secret" not in window.screen.notice.trouble.text()
    button = next(one for one in window.screen.notice.buttons if one.text() == "Copy details")
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
    assert "RuntimeError" in QApplication.clipboard().text()
    assert "zq-secret" not in QApplication.clipboard().text()


def test_skipping_comes_round_and_ends_at_the_last(qtbot, windows, path, make_bar):
    make_study(path, make_bar, practice=0, gold=0)
    window = windows(path)
    first = window.desk.question.asked
    press(qtbot, window, *[K.Key_N] * 10)
    assert window.desk.question.asked == first
    press(qtbot, window, *[K.Key_J] * 9)
    last = window.desk.question.asked
    press(qtbot, window, K.Key_N)
    assert window.desk.question.asked == last
    assert window.screen.small.saved.text() == "this is the last one"
    press(qtbot, window, K.Key_J)
    assert heading(window) == "All done, thank you!"
