"""Merging any histories in any order gives one study: votes, undos, packets, top-ups, deleted volunteers."""

import shutil
import tempfile
from pathlib import Path

import pytest
from exchange_world import ask, content, diagonal, ids_of, run_of, strip, strip_study
from hypothesis import HealthCheck, given, settings
from judging_world import forged
from merge_histories import HISTORIES, Copies, template
from rerun_law import reruns

from annotation import study
from annotation.design.topup import top_up_study
from annotation.exchange.merging import Merged, merge, merge_handles
from annotation.exchange.packets import make_packet
from annotation.storage.blobs import keep_shapes
from engine.errors import BadInput


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    path = tmp_path_factory.mktemp("template") / "study.db"
    template(path)
    return path


@settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
@given(HISTORIES)
def test_any_histories_merge_to_the_same_study(start, history):
    steps, rng = history
    with tempfile.TemporaryDirectory() as folder:
        world = Copies(start, Path(folder))
        try:
            world.live(steps)
            world.check(rng)
        finally:
            world.close()


def test_votes_stay_with_their_matches_in_re_runs():
    right, wrong = reruns(40)
    assert wrong == 0
    assert right > 20


def test_a_packet_gives_votes_and_comments_alone(tmp_path):
    with strip_study(tmp_path / "a.db") as whole:
        made = make_packet(whole, "anna", tmp_path / "p.db")
        with study.open_study(made.path) as packet:
            first = study.open_items(packet, "anna")[0].item_id
            study.record_vote(packet, first, "anna", "wrong", comment="Other end.")
            study.add_run(packet, run_of(strip(1), strip(2), diagonal(strip(1), strip(2), 9)))  # it has no business there
        before = content(tmp_path / "a.db")
        assert merge(tmp_path / "a.db", made.path) == Merged(items=0, runs=0, volunteers=0, events=1)
        after = content(tmp_path / "a.db")
        assert [vote.comment for vote in study.current_votes(whole)] == ["Other end."]
        for table in ("study", "item", "run", "run_match", "asked", "assignment", "blob"):
            assert after[table] == before[table]
        assert merge(tmp_path / "a.db", made.path) == Merged(0, 0, 0, 0)


def test_the_packet_of_a_copy_that_knew_more_is_taken_and_told_later(tmp_path):
    """A vote on a match that the study gets only afterwards is not lost, and the order makes no difference."""
    strip_study(tmp_path / "old.db").close()
    shutil.copy(tmp_path / "old.db", tmp_path / "new.db")
    with study.open_study(tmp_path / "new.db") as new:
        study.add_run(new, run_of(strip(1), strip(2), diagonal(strip(1), strip(2), 9)))
        packet = make_packet(new, "anna", tmp_path / "p.db").path
    with study.open_study(packet) as handle:
        for one in study.open_items(handle, "anna"):
            study.record_vote(handle, one.item_id, "anna", "correct")
    for name, order in (("one", ("new", "p")), ("other", ("p", "new"))):
        shutil.copy(tmp_path / "old.db", tmp_path / f"{name}.db")
        for source in order:
            merge(tmp_path / f"{name}.db", tmp_path / f"{source}.db")
    assert content(tmp_path / "one.db") == content(tmp_path / "other.db")
    assert len(content(tmp_path / "one.db")["event"]) == 9


def test_what_does_not_belong_together_is_refused(tmp_path):
    with strip_study(tmp_path / "a.db") as a, strip_study(tmp_path / "b.db") as b:
        packet = make_packet(a, "anna", tmp_path / "p.db").path
        with pytest.raises(BadInput, match="packet of another study"):
            merge(b.path, packet)
        with pytest.raises(BadInput, match="packet of another study"):
            merge(b.path, packet, other_study=True)
        with pytest.raises(BadInput, match="takes nothing in"):
            merge(packet, a.path)
        with pytest.raises(BadInput, match="belongs to another study"):
            merge(b.path, a.path)


@pytest.mark.parametrize(
    ("statement", "sentence"),
    [
        ("UPDATE event SET answer = 'wrong'", "another version of event"),
        ("UPDATE event SET comment = 'No.'", "another version of event"),
        ("UPDATE event SET uuid = 'x', supersedes = 'nothing'", "in place of one that is not its own"),
    ],
)
def test_histories_that_contradict_are_refused_and_nothing_changes(tmp_path, statement, sentence):
    with strip_study(tmp_path / "a.db") as handle:
        study.record_vote(handle, ids_of(handle)[0], "anna", "correct")
    shutil.copy(tmp_path / "a.db", tmp_path / "b.db")
    forged(tmp_path / "b.db", statement)
    before = content(tmp_path / "a.db")
    with pytest.raises(BadInput, match=sentence) as told:
        merge(tmp_path / "a.db", tmp_path / "b.db")
    assert str(told.value).count(". ") == 0
    assert content(tmp_path / "a.db") == before


def test_who_comes_in_by_a_packet_gets_an_own_order_and_sides_when_voting_live(tmp_path):
    strip_study(tmp_path / "a.db", votes=2).close()
    shutil.copyfile(tmp_path / "a.db", tmp_path / "copy.db")
    with study.open_study(tmp_path / "copy.db") as copy:
        for code in ("anna", "bert"):
            with study.open_study(make_packet(copy, code, tmp_path / f"{code}.db", 1).path) as packet:
                study.record_vote(packet, study.open_items(packet, code)[0].item_id, code, "wrong")
    with study.open_study(tmp_path / "a.db") as handle:
        for code in ("anna", "bert"):
            merge(handle.path, tmp_path / f"{code}.db")
            assert next(one for one in study.volunteers(handle) if one.code == code).seed == ""
        seeds = [study.volunteer(handle, code).seed for code in ("anna", "bert")]
        assert len(set(seeds) - {""}) == 2
        assert [study.volunteer(handle, code).seed for code in ("anna", "bert")] == seeds
        merge(handle.path, tmp_path / "anna.db")
        assert [one.seed for one in study.volunteers(handle)] == seeds


def test_a_packet_with_votes_of_others_is_refused(tmp_path):
    with strip_study(tmp_path / "a.db") as handle:
        packet = make_packet(handle, "anna", tmp_path / "p.db").path
        item = ids_of(handle)[0]
    with study.open_study(packet) as handle:
        study.record_vote(handle, item, "anna", "correct")
    forged(packet, "UPDATE volunteer SET code = 'bert'", "UPDATE event SET volunteer = 'bert'")
    before = content(tmp_path / "a.db")
    with pytest.raises(BadInput, match="holds votes of bert"):
        merge(tmp_path / "a.db", packet)
    assert content(tmp_path / "a.db") == before


def test_a_design_and_shapes_come_along(tmp_path):
    strip_study(tmp_path / "a.db", kept=False).close()
    shutil.copy(tmp_path / "a.db", tmp_path / "b.db")
    with study.open_study(tmp_path / "b.db") as other:
        ask(other, {ids_of(other)[0]: "gold"})
        keep_shapes(other, (strip(1), strip(2)))
    with study.open_study(tmp_path / "a.db") as ours:
        merge(ours.path, tmp_path / "b.db")
        assert content(ours.path) == content(tmp_path / "b.db") | {"volunteer": content(ours.path)["volunteer"]}
        assert [len(content(ours.path)[table]) for table in ("asked", "blob")] == [1, 2]


def test_a_top_up_goes_back_into_its_study_alone(tmp_path):
    with strip_study(tmp_path / "a.db") as whole, strip_study(tmp_path / "other.db") as other:
        study.record_vote(whole, ids_of(whole)[0], "anna", "correct")
        extra, asked = top_up_study(whole, tmp_path / "more.db")
        with extra:
            assert asked == 5
            for one in study.open_items(extra, "bert"):
                study.record_vote(extra, one.item_id, "bert", "wrong")
            with pytest.raises(BadInput, match="belongs to another study"):
                merge_handles(extra, other)
            with pytest.raises(BadInput, match="belongs to another study"):
                merge_handles(whole, extra)
            assert merge_handles(extra, whole).events == 5
            assert merge_handles(extra, whole) == Merged(0, 0, 0, 0)
        assert study.about(whole).name == "Strips"
        assert sum(found.wrong for found in study.majority(whole).values()) == 5
