"""The order of questions in one window, by hand."""

from annotation.records import OpenItem, Practice, VotingProgress
from gui.pages.voting.faults import fault_report, unknown_trouble
from gui.pages.voting.queue import Queue
from gui.pages.voting.watch import LONGEST_PAUSE, Watch
from gui.pages.voting.words import done_text, feedback, guideline_html, progress_text, welcome_text

P, A, B, C = (OpenItem(name, 0 if name == "p" else 1) for name in "pabc")
ALL = Queue(open=(P, A, B, C))


def test_what_is_answered_or_cannot_be_shown_is_not_asked():
    assert ALL.upcoming() == (P, A, B, C)
    assert ALL.upcoming(2) == (P, A)
    assert ALL.answer(P, 10).hide(B).upcoming() == (A, C)


def test_what_is_skipped_comes_at_the_end_in_the_order_of_skipping():
    queue = ALL.answer(P, 10).skip(A).skip(B)
    assert queue.upcoming() == (C, A, B)
    assert queue.upcoming(2) == (C, A)
    assert queue.skip(A).upcoming() == (C, B, A)
    assert queue.answer(A, 5).upcoming() == (C, B)


def test_what_is_taken_back_comes_first_again():
    queue = ALL.answer(P, 10).answer(A, 20).skip(B)
    assert queue.reopen(A).upcoming() == (A, C, B)
    assert queue.reopen(A).spent == ()
    assert queue.reopen(A, standing=True).spent == (20,)
    assert queue.reopen(P).spent == (20,)


def test_progress_counts_neither_practice_nor_what_cannot_be_shown():
    assert ALL.progress() == VotingProgress(0, 3, None)
    queue = ALL.answer(P, 99_000).answer(A, 4_000)
    assert queue.progress() == VotingProgress(1, 3, 8.0)
    assert queue.hide(C).progress() == VotingProgress(1, 2, 4.0)
    assert queue.answer(B, 6_000).answer(B, 1, again=True).progress() == VotingProgress(2, 3, 5.0)


def test_what_others_have_settled_is_neither_asked_nor_counted():
    queue = ALL.answer(P, 10).answer(A, 4_000).skip(B).settle([B])
    assert queue.upcoming() == (C,)
    assert queue.progress() == VotingProgress(1, 2, 4.0)
    assert queue.refresh((B, C), queue.step).upcoming() == (C, B)  # a vote was taken back: it is asked again


def test_practice_is_numbered():
    q = OpenItem("q", 0)
    queue = Queue(open=(P, q, A))
    assert queue.practising(P) == (1, 2)
    assert queue.answer(P, 1).practising(q) == (2, 2)
    assert queue.answer(P, 1).practising(P) == (1, 2)


def test_an_older_reading_does_not_ask_again_what_was_answered_meanwhile():
    queue = ALL.answer(P, 10)
    step = queue.step
    queue = queue.answer(A, 20)
    assert queue.refresh((A, B), step).upcoming() == (B,)
    assert queue.refresh((A, B), queue.step).upcoming() == (A, B)
    assert queue.reopen(A).refresh((B, C), step).upcoming() == (A, B, C)


def test_time_counts_while_somebody_is_there():
    now = [0.0]
    watch = Watch(lambda: now[0])
    now[0] = 5.0
    watch.touch()
    now[0] = 5.0 + LONGEST_PAUSE + 40.0  # a long pause is cut
    assert watch.read() == (105_000, 65_000)
    watch.leave()
    now[0] += 30.0
    watch.come_back()
    now[0] += 2.0
    assert watch.read() == (137_000, 67_000)
    watch.start()
    assert watch.read() == (0, 0)


def test_words_are_plain_and_count():
    assert progress_text(VotingProgress(37, 240, 1500.0)) == "37 of 240, about 25 min left"
    assert progress_text(VotingProgress(37, 240, 40.0)) == "37 of 240, about a minute left"
    assert "First 1 example" in welcome_text(1, VotingProgress(0, 3, None))
    assert "Then 3 questions." in welcome_text(1, VotingProgress(0, 3, None))
    assert "answered 2 of 3" in welcome_text(0, VotingProgress(2, 3, 9.0))
    assert "1 match cannot be shown here" in done_text(2, 1)
    assert "cannot" not in done_text(2, 0)
    assert guideline_html("<b>x</b>") == "<p style='white-space:pre-wrap'>&lt;b&gt;x&lt;/b&gt;</p>"
    assert "sqlalchemy" not in unknown_trouble("Something went wrong that should not have (sqlalchemy.exc.X: SELECT).")


def test_feedback_says_what_is_right_and_why():
    known = Practice("wrong", "One is a leg.")
    assert feedback("wrong", known).right
    told = feedback("unsure", known)
    assert (told.right, told.heading, told.reason) == (False, "Not quite: you said Unsure, the right answer is Wrong.", "One is a leg.")


def test_a_fault_is_reported_by_its_place_and_not_by_what_it_quotes():
    details = (
        'Traceback (most recent call last):\n  File "/home/eva/concord/gui/jobs.py", line 7, in _run\n    work("zq")\n'
        "sqlite3.IntegrityError: UNIQUE constraint failed: event.uuid\n\nDuring handling of …\n"
        "sqlalchemy.exc.IntegrityError: (x) zq-method\n[SQL: SELECT zq]\nzq-method\n"
    )
    assert fault_report(details).splitlines()[1:] == [
        "  concord/gui/jobs.py:7 in _run", "sqlite3.IntegrityError: UNIQUE constraint failed: event.uuid",
        "sqlalchemy.exc.IntegrityError",
    ]  # fmt: skip
