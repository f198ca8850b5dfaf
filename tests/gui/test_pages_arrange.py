"""What lists, layers and lines say: pure functions on a result written by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from annotation.study import VotingProgress
from engine.shapes.matching import METHODS
from engine.shapes.multilayer import MultiLayerGraph
from engine.shapes.parameters import preset
from engine.shapes.result import Match, MatchResult, ShapeRecord
from gui.folders import MOST_RECENT, with_recent
from gui.pages.files import labels_for, sorted_drop
from gui.pages.shapes.arrange import (
    SHOWN,
    arranged,
    empty_words,
    main_ids,
    match_text,
    merged,
    next_unanswered,
    reasons,
    score_help,
    share_text,
    short_notes,
    short_text,
    shows,
    smallest_with,
    state_of,
)
from gui.pages.shapes.layers import Place, layer_words, node_list, step_layer, step_node
from gui.pages.status import judged_text, left_text, seconds_text
from gui.pages.voting.words import progress_text
from gui.session import State

A = Match("a", (0,), (1,), 1.0, 5, 1, 1, 0.95)
B = Match("b", (1, 2), (0,), 0.8, 7, 2, 1, 0.90)
C = Match("c", (0, 1, 2, 3), (1, 2), 0.6, 0, 3, 2, 0.85)
MATCHES = [A, B, C]


def rows(matches, width):
    return np.array([[k in side for k in range(width)] for side in matches])


@pytest.fixture
def result():
    return MatchResult(
        "thesis", "thesis-rigid", preset("thesis-rigid"), ShapeRecord("a.off", "s", (1, 2, 3, 9), 4),
        ShapeRecord("b.off", "t", ("lid", "pot", "ear"), 3), pairs=[[0, 1], [5, 0], [6, 4]],
        score=[m.score for m in MATCHES], similarity=[m.similarity for m in MATCHES], votes=[m.votes for m in MATCHES],
        source_members=rows([m.source for m in MATCHES], 4), target_members=rows([m.target for m in MATCHES], 3),
        source_layer=[1, 2, 3], target_layer=[1, 1, 2], ids=("a", "b", "c"), source_nodes=7, target_nodes=5,
    )  # fmt: skip


def test_matches_are_named_by_the_labels_of_the_input(result):
    assert [match_text(m, result) for m in MATCHES] == ["1 → pot", "{2, 3} → lid", "{1, 2, 3, 9} → {pot, ear}"]
    assert [short_text(m, result) for m in MATCHES] == ["1→pot", "{2,3}→lid", "{1,2,+2}→{pot,ear}"]


def test_filters_part_the_matches():
    shown = {name: [m.id for m in MATCHES if shows(m, name, {"a", "c"})] for name in SHOWN}
    assert shown == {"main": ["a", "c"], "all": ["a", "b", "c"], "single": ["a"], "merged": ["b", "c"],
                     "wishes": []}
    assert [merged(m) for m in MATCHES] == [False, True, True]


@pytest.mark.parametrize(
    ("order", "ids"),
    [("score", "abc"), ("-score", "cba"), ("votes", "bac"), ("-votes", "cab"), ("match", "acb"), ("layers", "abc"),
     ("state", "bca"), ("-state", "acb"), ("nonsense", "abc")],
)  # fmt: skip
def test_orders(order, ids):
    assert [m.id for m in arranged(MATCHES, order, {"b": "correct", "c": "wrong"})] == list(ids)


def test_verdicts_that_decide_nothing_leave_a_match_undecided():
    assert [state_of(i, {"a": "correct", "b": "tie", "c": "unjudged"}) for i in "abcd"] == [
        "correct", "tie", "undecided", "undecided"]  # fmt: skip


def test_the_next_match_goes_around_and_skips_what_is_answered():
    assert next_unanswered(MATCHES, "a", {"a": "wrong"}) == "b"
    assert next_unanswered(MATCHES, "c", {"c": "wrong"}) == "a"
    assert next_unanswered(MATCHES, "a", {"a": "wrong", "b": "unsure"}) == "c"
    assert next_unanswered(MATCHES, "b", {"a": "wrong", "b": "wrong", "c": "wrong"}) == ""
    assert next_unanswered(MATCHES, "", {}) == "a"
    assert next_unanswered([], "", {}) == ""


def test_a_segment_selects_its_smallest_match():
    assert smallest_with(MATCHES, 0, 0) == "a"
    assert smallest_with(MATCHES, 0, 1) == "b"
    assert smallest_with(MATCHES, 1, 2) == "c"
    assert smallest_with(MATCHES, 1, 7) == ""


def test_main_matches_do_not_overlap_and_hold_all_single_ones(result):
    assert main_ids(result) == {"a", "b"}  # c holds the segments of both


def test_reasons_name_segments_layers_and_thresholds(result):
    said = dict(reasons(B, result))
    assert said["Source"] == "segments 2, 3  ·  layer 2"
    assert said["Target"] == "segment lid  ·  layer 1"
    assert said["Similarity"].startswith(".90")
    assert ".80" in said["Similarity"]
    assert "π" in said["Score"]
    assert said["Votes"].startswith("7")


def test_the_learned_score_is_said_to_be_a_probability(result):
    learned = replace(result, method="learned", parameters=preset("learned"))
    assert dict(reasons(B, learned))["Score"] == ".80  probability that the match is right"
    assert score_help("learned") == (
        "Score: the probability that the match is right, from 0 to 1, as fitted to shapes whose true matches are known")
    said = {method: score_help(method) for method in METHODS}
    assert len(set(said.values())) == 6  # the three that walk on candidates say the same
    assert all(text.startswith("Score: ") for text in said.values())


def test_an_empty_list_says_why(result):
    state = State(result=result, main=frozenset("ab"))
    assert empty_words(State()) == empty_words(state) == ""
    assert "press K" in empty_words(replace(state, shown="wishes"))
    assert "move the slider" in empty_words(replace(state, support={"a": 0.2, "b": 0.1}, least_support=0.5))
    assert "choose All matches" in empty_words(replace(state, main=frozenset()))


@pytest.mark.parametrize(("value", "text"), [(0.926, ".93"), (0.0, ".00"), (1.0, "1.00"), (0.996, "1.00"), (0.994, ".99")])
def test_shares(value, text):
    assert share_text(value) == text


# --- layers


@pytest.fixture
def graphs():
    members = np.eye(3, dtype=bool), np.array([[True, True, False], [False, True, True], [True, True, True]])
    layers = np.array([1, 1, 2, 2, 2, 3])
    source = MultiLayerGraph(np.vstack(members), layers, [], [], 3)
    target = MultiLayerGraph(np.eye(2, dtype=bool), np.array([1, 2]), [], [], 3)
    return source, target


def test_nodes_of_a_layer_are_listed_source_first(graphs):
    assert node_list(*graphs, 2) == [(0, 2), (0, 3), (0, 4), (1, 1)]
    assert node_list(*graphs, 3) == [(0, 5)]


def test_walking_through_layers_stops_at_both_ends():
    assert step_layer(Place(0, -1), -1, 8) == Place(0, -1)
    assert step_layer(Place(2, 5), 1, 8) == Place(3, -1)
    assert step_layer(Place(8, 0), 1, 8) == Place(8, -1)


def test_walking_through_nodes_comes_back_to_all_of_them():
    place, seen = Place(2, -1), []
    for _ in range(4):
        place = step_node(place, 1, 3)
        seen.append(place.node)
    assert seen == [0, 1, 2, -1]
    assert step_node(Place(2, -1), -1, 3).node == 2
    assert step_node(Place(2, -1), 1, 0).node == -1


def test_layer_words():
    assert layer_words(Place(3, -1), 8, 41, 38) == "layer 3 of 8 · 41 + 38 nodes"


# --- lines


def test_the_status_line_says_how_far_judging_is():
    assert judged_text(0, 0, 0, 0, 0) == "No matches with these parameters."
    assert judged_text(8, 0, 0, 0, 0).startswith("8 matches · none judged yet")
    text = judged_text(8, 5, 1, 0, 2)
    assert text.startswith("6 of 8 matches judged, precision .83 [.44, .97]")  # Wilson's interval of 5 of 6
    assert text.endswith("2 in the list left for you")
    assert "1 tied" in judged_text(8, 5, 1, 1, 0)
    assert judged_text(1, 1, 0, 0, 0).endswith("judged the whole list")


def test_seconds():
    assert [seconds_text(s) for s in (0.038, 3.14, 125)] == ["0.04 s", "3.1 s", "2 min"]
    assert [left_text(s) for s in (math.nan, 12.4, 300)] == ["", "about 12 s left", "about 5 min left"]


def test_progress_of_a_volunteer():
    assert progress_text(VotingProgress(37, 240, 1500.0)) == "37 of 240, about 25 min left"
    assert progress_text(VotingProgress(0, 9, None)) == "0 of 9"
    assert progress_text(VotingProgress(9, 9, 0.0)) == "9 of 9"


def test_dropped_files_are_told_apart():
    assert sorted_drop(["a.off", "a.seg", "b.OBJ", "x.db"]) == (["a.off", "b.OBJ"], ["a.seg"], ["x.db"])


def test_labels_go_to_the_mesh_of_their_name_first():
    assert labels_for(["p/a.off", "p/b.off"], ["q/b.seg"]) == (None, "q/b.seg")
    assert labels_for(["a.off", "b.off"], ["b.seg", "other.seg"]) == ("other.seg", "b.seg")
    assert labels_for(["1.off", "10.off"], ["10.fine.seg", "1.coarse.seg"]) == ("1.coarse.seg", "10.fine.seg")
    assert labels_for(["a.off", "b.off"], []) == (None, None)


def test_recent_pairs_are_few_and_different():
    known = [(f"{k}", "t") for k in range(20)]
    assert with_recent(known, ("3", "t"))[:2] == [("3", "t"), ("0", "t")]
    assert len(with_recent(known, ("x", "t"))) == MOST_RECENT


def test_notes_are_told_once_each_and_few_at_a_time():
    assert short_notes([], str) == ""
    assert short_notes(["one", "two", "one"], str) == "· one\n· two"
    assert short_notes(["a", "b", "c", "d"], str).splitlines() == ["· a", "· b", "· and 2 more; point here to read them"]
    assert short_notes(["a long one"], lambda line: line[:4] + "…") == "· a …"
