"""Random lives of the copies of one study, and the law that they merge to the same study in whatever order."""

import random
import shutil
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from exchange_world import ask, content, diagonal, ids_of, record, run_of, strip, strip_study
from hypothesis import strategies as st

from annotation import study
from annotation.exchange.forgetting import forget
from annotation.exchange.merging import Merged, merge_handles
from annotation.exchange.packets import make_packet
from annotation.exchange.tombstones import code_hash
from annotation.voting.answering import make_adjudicator
from engine.errors import ConcordError

CODES = ("anna-quill", "bert-quill", "carl-quill")
KINDS = ("vote", "vote", "vote", "undo", "packet", "packet vote", "packet vote", "packet undo", "run", "merge", "merge", "merge packet",
         "forget", "forget votes", "practice", "adjudicator")  # fmt: skip
STEP = st.tuples(st.sampled_from(KINDS), st.integers(0, 2), st.sampled_from(CODES), st.integers(0, 5), st.sampled_from(study.ANSWERS))
HISTORIES = st.tuples(st.lists(STEP, min_size=12, max_size=30), st.randoms(use_true_random=False))


def template(path: Path) -> None:
    """What all copies come from: six matches between two strips, one of them gold and one for practice, two votes each."""
    with strip_study(path, votes=2, settings={"head": CODES[2]}) as handle:
        ids = ids_of(handle)
        ask(handle, dict(zip(ids, ("practice", "gold", *["judged"] * 4), strict=True)), reason="It is the same end.")


class Copies:
    """Three copies of a study and the packets made of them."""

    def __init__(self, template: Path, folder: Path) -> None:
        self.folder, self.packets = folder, []
        self.copies = [self.opened(shutil.copy(template, folder / f"copy {k}.db")) for k in range(3)]
        self.ids = ids_of(self.copies[0])
        self.forgotten: set[str] = set()
        self.done: Counter[str] = Counter()

    def opened(self, path) -> study.StudyHandle:
        return study.open_study(path, backup=False)

    def live(self, steps: Sequence[tuple]) -> None:
        for number, step in enumerate(steps):
            try:
                self.step(number, *step)
            except ConcordError:  # nothing is open, a code that was deleted, …
                self.done["refused"] += 1
            else:
                self.done[step[0]] += 1

    def step(self, number: int, kind: str, copy: int, code: str, which: int, answer: str) -> None:
        at, other = self.copies[copy], self.copies[which % 3]
        packet = self.packets[which % len(self.packets)] if self.packets else None
        if kind == "vote":
            study.record_vote(at, self.ids[which], code, answer, comment=f"by {code}", presentation={"who": code})
        elif kind == "practice":
            study.record_vote(at, self.ids[0], code, answer, round=0)
        elif kind == "undo":
            study.undo_vote(at, code)
        elif kind == "adjudicator":
            make_adjudicator(at, code, adjudicates=which > 1)
        elif kind == "packet":
            path = self.folder / f"packet {number}.db"
            make_packet(at, code, path, which + 1)
            self.packets.append(self.opened(path))
        elif kind == "packet vote" and packet is not None:
            mine = study.items(packet, packet.volunteer)
            study.record_vote(packet, mine[number % len(mine)].id, packet.volunteer, answer, comment="from the packet")
        elif kind == "packet undo" and packet is not None:
            study.undo_vote(packet, packet.volunteer)
        elif kind == "run":
            a, b = strip(1), strip(2 + which % 2)
            study.add_run(at, run_of(a, b, diagonal(a, b, 7 + which), source=record(a, f"{copy}.off"), seconds={"voting": number}))
        elif kind == "merge" and at is not other:
            merge_handles(other, at)
        elif kind == "merge packet" and packet is not None:
            merge_handles(packet, at)
        elif kind.startswith("forget"):
            forget(at, code, votes_too=kind == "forget votes")
            self.forgotten.add(code)

    def check(self, rng: random.Random) -> None:
        """Merged in any order, grouped in any way and twice, all give the same; nobody who is deleted comes back."""
        every = [*self.copies, *self.packets]
        found = []
        for number in range(3):
            rest = [one for one in every if one is not self.copies[number]]
            rng.shuffle(rest)
            with self.copied(self.copies[number], f"merged {number}") as target:
                if number == 2:  # a group first
                    whole = next(one for one in rest if one.volunteer is None)
                    rest.remove(whole)
                    cut = rng.randrange(len(rest) + 1)
                    with self.copied(whole, "group") as group:
                        for one in rest[:cut]:
                            merge_handles(one, group)
                        merge_handles(group, target)
                    rest = rest[cut:]
                for one in rest:
                    merge_handles(one, target)
                found.append(content(target.path))
                assert [merge_handles(one, target) for one in every] == [Merged(0, 0, 0, 0)] * len(every)
                assert content(target.path) == found[-1]
        assert found[0] == found[1] == found[2]
        self.check_nothing_lost(found[0])

    def check_nothing_lost(self, merged: dict[str, list]) -> None:
        events = {row[0]: row for one in (*self.copies, *self.packets) for row in content(one.path)["event"]}
        dropped = {row[0] for row in merged["forgotten"] if not row[2]}
        known = {code_hash(study.about(self.copies[0]).id, code): code for code in CODES}
        gone = {known[found] for found in dropped} | {row[1] for row in merged["forgotten"] if row[0] in dropped}
        assert {row[0] for row in merged["event"]} == {uuid for uuid, row in events.items() if row[3] not in gone}
        text = repr({table: rows for table, rows in merged.items() if table != "blob"})
        assert not [code for code in self.forgotten if code in text]
        assert len(merged["forgotten"]) == len(self.forgotten)

    def copied(self, handle: study.StudyHandle, name: str) -> study.StudyHandle:
        """A copy of a study as it stands, which lies beside it."""
        path = self.folder / f"{name}.db"
        with study.open_study(handle.path, backup=False):
            handle.purge()  # its log is in the file then
        return self.opened(shutil.copy(handle.path, path))

    def close(self) -> None:
        for one in (*self.copies, *self.packets):
            one.close()
