"""One state: what changed is told, undo and redo keep inputs and parameters together, votes are never undone."""

import pytest

from engine.shapes.parameters import preset
from gui.session import Session, State, difference

RIGID, NONRIGID = preset("thesis-rigid"), preset("thesis-nonrigid")


class Answer:
    """A result without matches."""

    def matches(self):
        return []


@pytest.fixture
def session(qapp):
    return Session(State(preset="thesis-rigid", parameters=RIGID))


@pytest.fixture
def told(session):
    heard = []
    session.changed.connect(lambda old, new, names: heard.append((old, new, set(names))))
    return heard


def test_only_what_differs_is_told(session, told):
    assert session.update(preset="thesis-rigid", layer=3, parameters=preset("thesis-rigid").changed()) == {"layer"}
    assert [names for _, _, names in told] == [{"layer"}]
    old, new, _ = told[0]
    assert (old.layer, new.layer) == (0, 3)
    assert new is session.state


def test_nothing_new_tells_nobody(session, told):
    session.update(layer=0, selected="", answers={})
    assert told == []


def test_difference_is_symmetric():
    a, b = State(dark=True, layer=1), State(layer=1, node=2)
    assert difference(a, b) == difference(b, a)
    assert {"dark", "node"} <= difference(a, b)
    assert "layer" not in difference(a, b)


def test_undo_and_redo_walk_the_same_states(session):
    session.update(parameters=RIGID.changed(delta_1=0.3))
    session.update(parameters=RIGID.changed(delta_1=0.4))
    seen = [session.state.parameters.delta_1]
    session.undo()
    seen.append(session.state.parameters.delta_1)
    session.undo()
    seen.append(session.state.parameters.delta_1)
    session.redo()
    seen.append(session.state.parameters.delta_1)
    assert seen == [0.4, 0.3, 0.2, 0.3]


def test_undo_beyond_the_first_state_changes_nothing(session, told):
    session.undo()
    session.redo()
    assert told == []
    assert not session.can_undo


def test_a_slider_that_moves_is_one_step(session):
    for value in (0.21, 0.22, 0.23):
        session.update(merge="delta_1", parameters=RIGID.changed(delta_1=value))
    session.settle()
    session.update(merge="delta_1", parameters=RIGID.changed(delta_1=0.5))
    session.undo()
    assert session.state.parameters.delta_1 == 0.23
    session.undo()
    assert session.state.parameters.delta_1 == 0.2
    assert not session.can_undo


def test_a_new_step_ends_what_was_undone(session):
    session.update(preset="thesis-nonrigid", parameters=NONRIGID)
    session.undo()
    session.update(parameters=RIGID.changed(K=3))
    assert not session.can_redo
    assert session.state.preset == "thesis-rigid"


def test_answers_of_jobs_are_no_steps_of_their_own(session):
    session.update(parameters=RIGID.changed(K=3))
    answer = Answer()
    session.update(record=False, result=answer)
    session.undo()
    assert session.state.result is None
    session.redo()
    assert session.state.result is answer


def test_votes_and_view_survive_undo(session):
    session.update(parameters=RIGID.changed(K=3))
    session.update(answers={"a": "wrong"}, verdicts={"a": "wrong"}, layer=2, dark=True, volunteer="ana")
    session.undo()
    state = session.state
    assert (state.answers, state.layer, state.dark, state.volunteer) == ({"a": "wrong"}, 2, True, "ana")
    assert not {"answers", "verdicts", "study", "volunteer"} & set(State.UNDOABLE)
