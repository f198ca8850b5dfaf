"""Jobs: progress, cancelling, latest wins, late answers dropped, errors told, nothing left behind on closing."""

import math
import sys
import threading
import time

import pytest

from engine.errors import BadInput, Cancelled
from gui.jobs import FOLLOW, QUEUE, Jobs, explain, remaining, show_unexpected


@pytest.fixture
def jobs(qapp):
    made = Jobs()
    yield made
    assert made.close()


def endless(began: threading.Event):
    """Work that ends by being cancelled alone."""

    def work(progress):
        began.set()
        while True:
            time.sleep(0.002)
            progress(0.5, "waiting")

    return work


def test_the_answer_comes_in_the_window_thread(jobs, qtbot):
    got = []
    jobs.start("a", lambda _: threading.get_ident(), lambda value: got.append((value, threading.get_ident())))
    qtbot.waitUntil(lambda: bool(got))
    worker, receiver = got[0]
    assert receiver == threading.get_ident() != worker


def test_progress_is_shown_with_an_estimate(jobs, qtbot):
    seen = []
    jobs.progressed.connect(lambda share, words, left: seen.append((share, words, left)))

    def work(progress):
        for k in range(13):
            progress(k / 13, "step")
            time.sleep(0.06)

    with qtbot.waitSignal(jobs.idle):
        jobs.start("a", work, lambda _: None)
    shares = [share for share, _, _ in seen]
    assert len(seen) > 3
    assert shares == sorted(shares)
    assert {words for _, words, _ in seen} == {"step"}
    assert 0 < seen[-1][2] < 1


def test_the_estimate_is_proportional():
    assert remaining(10.0, 0.25) == pytest.approx(30.0)
    assert remaining(10.0, 1.0) == 0.0
    assert math.isnan(remaining(0.1, 0.5))
    assert math.isnan(remaining(10.0, 0.0))


def test_a_newer_job_supersedes_the_running_one(jobs, qtbot):
    began, got = threading.Event(), []
    jobs.start("a", endless(began), lambda _: got.append("old"))
    assert began.wait(5)
    jobs.start("a", lambda _: "new", got.append)
    qtbot.waitUntil(lambda: got == ["new"])


def test_a_late_answer_is_dropped(jobs, qtbot):
    """Work that never looks at its progress ends anyway, but nobody hears its answer."""
    release, got = threading.Event(), []
    jobs.start("a", lambda _: release.wait(5) and "late", got.append)
    jobs.start("a", lambda _: "new", got.append)
    release.set()
    qtbot.waitUntil(lambda: bool(got))
    qtbot.wait(30)
    assert got == ["new"]


def test_many_moves_cost_two_computations(jobs, qtbot):
    """While one runs only the newest waits: of 41 moves the first and the last are computed."""
    gate, done = threading.Event(), []
    for k in range(41):
        jobs.start("slider", lambda _, k=k: gate.wait(5) and k, done.append, policy=FOLLOW)
    gate.set()
    qtbot.waitUntil(lambda: 40 in done)
    assert done == [0, 40]


def test_queued_jobs_all_run_in_their_order(jobs, qtbot):
    done = []
    for k in range(5):
        jobs.start("vote", lambda _, k=k: k, done.append, policy=QUEUE)
    qtbot.waitUntil(lambda: len(done) == 5)
    assert done == [0, 1, 2, 3, 4]


def test_cancel_stops_at_the_next_progress(jobs, qtbot):
    began, got, failures = threading.Event(), [], []
    jobs.failed.connect(lambda *texts: failures.append(texts))
    jobs.start("a", endless(began), got.append)
    assert began.wait(5)
    assert jobs.busy("a")
    with qtbot.waitSignal(jobs.idle):
        jobs.cancel()
    jobs.start("b", lambda _: "after", got.append)
    qtbot.waitUntil(lambda: got == ["after"])
    assert failures == []


def test_one_channel_can_be_cancelled_alone(jobs, qtbot):
    gate, got = threading.Event(), []
    jobs.start("a", lambda _: gate.wait(5) and "a", got.append)
    jobs.start("b", lambda _: "b", got.append)
    jobs.start("c", lambda _: "c", got.append)
    jobs.cancel("b")
    gate.set()
    qtbot.waitUntil(lambda: "c" in got)
    assert got == ["a", "c"]


@pytest.mark.parametrize(
    ("error", "said"),
    [(BadInput("lamp.off is empty."), "lamp.off is empty."), (MemoryError(), "not enough memory"),
     (ZeroDivisionError("division by zero"), "ZeroDivisionError"), (SystemExit(3), "SystemExit")],
)  # fmt: skip
def test_whatever_work_raises_becomes_a_sentence_with_details(jobs, qtbot, error, said):
    def work(_):
        raise error

    with qtbot.waitSignal(jobs.failed) as signal:
        jobs.start("a", work, lambda _: pytest.fail("there is no answer"))
    sentence, details = signal.args
    assert said in sentence
    assert type(error).__name__ in details
    assert "in work" in details


def test_cancelled_is_no_failure(jobs, qtbot):
    failures = []
    jobs.failed.connect(lambda *texts: failures.append(texts))

    def work(_):
        raise Cancelled

    with qtbot.waitSignal(jobs.idle):
        jobs.start("a", work, lambda _: failures.append("answered"))
    assert failures == []


def test_closing_cancels_and_waits(qtbot):
    jobs, began, got = Jobs(), threading.Event(), []
    jobs.start("a", endless(began), got.append)
    jobs.start("b", lambda _: 1, got.append)
    assert began.wait(5)
    before = time.monotonic()
    assert jobs.close()
    assert time.monotonic() - before < 2
    assert not any(thread.name == "concord-a" for thread in threading.enumerate())
    jobs.start("c", lambda _: 2, got.append)
    qtbot.wait(20)
    assert got == []


def test_finishing_lets_votes_come_to_their_end(qapp):
    jobs, done = Jobs(), []
    for k in range(4):
        jobs.start("vote", lambda _, k=k: time.sleep(0.02) or k, done.append, policy=QUEUE)
    assert jobs.finish()
    assert done == [0, 1, 2, 3]


def test_explain_keeps_the_sentence_of_known_errors():
    assert explain(BadInput("One sentence."))[0] == "One sentence."


def test_unexpected_errors_are_shown_and_the_hook_is_put_back():
    shown, before = [], sys.excepthook
    restore = show_unexpected(lambda *texts: shown.append(texts))
    try:
        sys.excepthook(KeyError, KeyError("part"), None)
    finally:
        restore()
    assert sys.excepthook is before
    assert "KeyError" in shown[0][0]
