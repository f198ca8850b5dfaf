"""The voting page of the researcher's window: joins of a puzzle among matches of shapes, the same answers for both."""

import pytest
from puzzle_world import cut_up, joins_of, solved, touching
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QPushButton
from voting_world import settle

from annotation import study
from annotation.results.puzzlejoins import add_solution, join_ids
from engine.shapes.identity import match_id, mesh_id, node_id, segment_ids
from gui.jobs import Jobs
from gui.pages.judging import Judging
from gui.pages.voting.page import StudyPage
from gui.pages.voting.questions import JOIN_QUESTION, JoinQuestion, Question, keep
from gui.session import Session, State

PAIRS = 2


@pytest.fixture
def mixed(tmp_path, bar):
    """A study of two joins and one match of a bar with itself; the id of the match."""
    puzzle, truth = cut_up()
    joins = joins_of(truth, touching(truth)[:PAIRS])
    ids = [node_id([segment]) for segment in segment_ids(bar.mesh, bar.segmentation)]
    sides = [{"file": "bar.off", "sha256": mesh_id(bar.mesh), "segments": [k]} for k in (0, 2)]
    match = study.shape_item(match_id(ids[0], ids[2]), *sides)
    with study.create_study(tmp_path / "mixed.study", name="Mixed", seed="7") as handle:
        add_solution(handle, puzzle, solved(puzzle, truth, joins))
        study.add_items(handle, [match])
    return tmp_path / "mixed.study", match.id, join_ids(puzzle, joins)


@pytest.fixture
def page(qtbot, mixed, bar):
    """The page by itself, open on that study, with the bar at hand."""
    session, jobs = Session(State(volunteer="anna")), Jobs()
    judging = Judging(session, jobs)
    page = StudyPage(session, judging)
    qtbot.addWidget(page)
    keep(page.desk._kept, mesh_id(bar.mesh), bar)
    page.resize(1000, 640)
    page.show()
    judging.open(mixed[0])
    qtbot.waitUntil(lambda: judging.handle is not None and page.question is not None, timeout=20_000)
    yield page
    judging.close()
    page.shutdown()
    jobs.close()


def walk(qtbot, page, answers):
    """Answer one question after the other; the questions as they were asked."""
    asked = []
    for answer in answers:
        asked.append(page.question)
        page.answer(answer)
        settle(qtbot, page.desk)
    return asked


def test_joins_and_matches_are_asked_once_each(qtbot, page, mixed):
    _, match, joins = mixed
    asked = walk(qtbot, page, ["correct"] * 3)
    assert {question.asked.item_id for question in asked} == {match, *joins}
    assert page.question is None
    assert "All done" in page.screen.notice.heading.text()
    assert set(study.answers(page.judging.handle, "anna").values()) == {"correct"}


def test_the_rest_of_the_window_learns_of_the_votes(qtbot, page):
    (question,) = walk(qtbot, page, ["wrong"])
    qtbot.waitUntil(lambda: page.session.state.answers == {question.asked.item_id: "wrong"}, timeout=10_000)


def test_each_kind_has_its_view_and_its_words(qtbot, page):
    for _ in range(3):
        joined = isinstance(page.question, JoinQuestion)
        assert joined or isinstance(page.question, Question)
        screen = page.screen
        assert screen.stage.currentWidget() is (screen.join_view if joined else screen.view)
        assert screen.words.text() == (JOIN_QUESTION if joined else study.DEFAULT_QUESTION)
        assert screen.small.tools["turn"].isVisible() != joined
        if joined:
            assert screen.join_view.picture is page.question.picture
        page.answer("unsure")
        settle(qtbot, page.desk)


def test_a_vote_can_be_taken_back_and_its_join_shows_again(qtbot, page, mixed):
    while not isinstance(page.question, JoinQuestion):
        walk(qtbot, page, ["correct"])
    (question,) = walk(qtbot, page, ["wrong"])
    (vote,) = study.current_votes(page.judging.handle, [question.asked.item_id])
    assert (vote.answer, vote.volunteer, vote.presentation) == ("wrong", "anna", {})
    page.undo()
    settle(qtbot, page.desk)
    assert page.question.asked == question.asked
    assert question.asked.item_id not in study.answers(page.judging.handle, "anna")


def test_a_question_left_for_the_end_comes_back(qtbot, page):
    first = page.question.asked
    page.skip()
    settle(qtbot, page.desk)
    asked = walk(qtbot, page, ["correct"] * 2)
    assert first not in {question.asked for question in asked}
    assert page.question.asked == first
    page.skip()  # the last one stays
    settle(qtbot, page.desk)
    assert page.question.asked == first


def test_what_cannot_be_shown_is_told_to_the_researcher(qtbot, page, mixed):
    page.desk._kept.clear()
    page.begin()
    settle(qtbot, page.desk)
    walk(qtbot, page, ["correct"] * 2)
    assert page.question is None
    assert "bar.off" in page.screen.notice.text.text()
    assert page.screen.notice.heading.text() == "2 of 3 answered"


def test_a_study_s_own_question_is_asked_of_joins_too(qtbot, tmp_path, page):
    puzzle, truth = cut_up()
    with study.create_study(tmp_path / "own.study", name="Own", question="Same jar?") as handle:
        add_solution(handle, puzzle, solved(puzzle, truth))
    page.judging.open(tmp_path / "own.study")
    qtbot.waitUntil(lambda: page.screen.words.text() == "Same jar?", timeout=20_000)
    assert isinstance(page.question, JoinQuestion)


def test_keys_work_without_menus(qtbot, page):
    first = page.question.asked.item_id
    qtbot.keyClick(page.screen, Qt.Key.Key_G)
    assert page.screen.notice.heading.text() == "Help"
    qtbot.keyClick(page.screen, Qt.Key.Key_Escape)
    qtbot.keyClick(page.screen, Qt.Key.Key_J)
    settle(qtbot, page.desk)
    assert study.answers(page.judging.handle, "anna") == {first: "correct"}


def test_nothing_shown_tells_who_proposed_a_join(page, qtbot):
    words = " ".join(w.text() for kind in (QLabel, QPushButton) for w in page.findChildren(kind))
    for telling in ("loops", "mgc", "0.9", ".90", "noise", "piece "):
        assert telling not in words
