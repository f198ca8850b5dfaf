"""How long a large study takes to answer: 5,000 matches, 20 volunteers, 60,000 votes (`python tests/benchmarks/study_size.py`).

Prints medians of what happens between a volunteer's key and the next question, and of what a researcher waits for.
"""

import argparse
import random
import statistics
import sys
import tempfile
import time
import uuid
from collections.abc import Callable
from pathlib import Path

from sqlalchemy import insert

from annotation import study
from annotation.findings.precision import precision_table
from annotation.storage import schema
from annotation.voting.asking import asked_item, needless_in_front


def fill(handle: study.StudyHandle, items: int, volunteers: int, votes: int, seed: int = 1) -> None:
    """Random items, runs of 25 of them, and votes of which a tenth replaces an earlier one and some are retracted."""
    draw = random.Random(seed)
    ids = [f"{draw.getrandbits(256):064x}" for _ in range(items)]
    codes = [f"v{n:02}" for n in range(volunteers)]
    stamp = {"created_at": "2026-01-01T00:00:00.000000+00:00"}
    side = {"file": "lamp.off", "sha256": "a" * 64, "segments": list(range(8))}
    study.add_items(handle, [study.Item(one, "shape", {"source": side, "target": side}) for one in ids])
    with handle.writing() as connection:
        connection.execute(insert(schema.volunteer), [{"code": c, "seed": c, **stamp} for c in codes])
        runs = [(f"run{n}", ids[start : start + 25]) for n, start in enumerate(range(0, items, 25))]
        connection.execute(
            insert(schema.run),
            [{"id": run, "kind": "shape", "method": f"m{n % 2}", "preset": "p", "parameters": "{}", "set_name": f"s{n % 4}",
              "pair": run, "source": "{}", "target": "{}", "seconds": "{}", "app_version": "", "added_at": ""}
             for n, (run, _) in enumerate(runs)],
        )  # fmt: skip
        connection.execute(
            insert(schema.run_match),
            [{"run_id": run, "item_id": one, "rank": rank, "score": 1.0, "votes": 1} for run, own in runs
             for rank, one in enumerate(own)],
        )  # fmt: skip
        connection.execute(insert(schema.event), events(draw, ids, codes, votes, stamp))


def events(draw: random.Random, ids: list[str], codes: list[str], votes: int, stamp: dict[str, str]) -> list[dict[str, object]]:
    """As many votes as wanted, dealt out so that items have about equally many, and a retraction for one of fifty."""
    dealt = [(one, code) for code in codes for one in draw.sample(ids, min(len(ids), round(0.9 * votes / len(codes))))]
    dealt += draw.choices(dealt, k=votes - len(dealt))
    clocks, last, rows = dict.fromkeys(codes, 0), {}, []
    for one, code in dealt:
        for kind in ("vote", "retraction") if draw.random() < 0.02 else ("vote",):
            clocks[code] += 1
            vote, before = kind == "vote", last.get((one, code))
            row = {"uuid": str(uuid.UUID(int=draw.getrandbits(128))), "kind": kind, "item_id": one, "volunteer": code,
                   "round": 1, "answer": draw.choice(study.ANSWERS) if vote else None, "comment": "",
                   "supersedes": before, "clock": clocks[code], "shown_ms": 4000 if vote else None,
                   "active_ms": 3000 if vote else None, "presentation": "{}", "app_version": "0.1.0", **stamp}  # fmt: skip
            last[one, code] = row["uuid"]
            rows.append(row)
    return rows


def median(work: Callable[[], object], times: int = 5) -> float:
    """Milliseconds."""
    taken = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        taken.append(1000 * (time.perf_counter() - began))
    return statistics.median(taken)


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--items", type=int, default=5000)
    parser.add_argument("--volunteers", type=int, default=20)
    parser.add_argument("--votes", type=int, default=60_000)
    parser.add_argument("--k", type=int, nargs="+", default=[0, 15], help="votes an item is to get (0: one of everybody)")
    chosen = parser.parse_args(arguments)
    for k in chosen.k:
        with tempfile.TemporaryDirectory() as folder:
            handle = study.create_study(Path(folder) / "large.db", name="large", votes=k)
            fill(handle, chosen.items, chosen.volunteers, chosen.votes)
            report(handle, f"{chosen.items} items, {chosen.volunteers} volunteers, {chosen.votes} votes, k = {k}")
            handle.close()


def report(handle: study.StudyHandle, title: str) -> None:
    print(title)
    left = iter(study.open_items(handle, "v03"))

    def between() -> None:
        study.record_vote(handle, next(left).item_id, "v03", "correct", shown_ms=1000, active_ms=900)
        following = [next(left) for _ in range(3)]
        assert needless_in_front(handle, "v03", following) == ((), ())
        asked_item(handle, "v03", following[0].item_id)

    for name, work in (
        ("record a vote, choose and read the next item", between),
        ("next_item", lambda: study.next_item(handle, "v03")),
        ("open_items", lambda: study.open_items(handle, "v03")),
        ("progress", lambda: study.progress(handle, "v03")),
        ("answers", lambda: study.answers(handle, "v03")),
        ("undo", lambda: study.undo_vote(handle, "v03")),
        ("majority", lambda: study.majority(handle)),
        ("precision_table", lambda: precision_table(handle)),
        ("open_study", lambda: study.open_study(handle.where, backup=False).close()),
    ):
        print(f"  {name:46}{median(work):9.1f} ms")


if __name__ == "__main__":
    main(sys.argv[1:])
