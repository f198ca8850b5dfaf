"""How long the figures of a large study take: `python tests/benchmarks/study_table.py` (5,000 matches, 60,000 votes)."""

import random
import sys
import tempfile
import time
import uuid
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1] / "annotation")]

from design_world import run_of  # noqa: E402
from sqlalchemy import insert  # noqa: E402

from annotation import study  # noqa: E402
from annotation.findings.gathering import findings  # noqa: E402
from annotation.findings.overview import overview  # noqa: E402
from annotation.findings.precision import ballots, precision_table  # noqa: E402
from annotation.storage import schema  # noqa: E402

ITEMS, VOLUNTEERS, METHODS, SETS, PAIRS, EACH = 5000, 12, 3, 3, 30, 60


def main() -> None:
    """Make the study and print the seconds of each reading."""
    with tempfile.TemporaryDirectory() as folder, study.create_study(Path(folder) / "large.db", name="Large") as handle:
        fill(handle, random.Random(0))
        for ask in (ballots, precision_table, findings, overview):
            start = time.perf_counter()
            ask(handle)
            print(f"{ask.__name__:16} {time.perf_counter() - start:.2f} s")


def fill(handle: study.StudyHandle, rng: random.Random) -> None:
    """Every volunteer votes on every match, nine of ten times as it is; each method proposes some on each pair."""
    items = [f"{k:05d}" for k in range(ITEMS)]
    right = {item: rng.random() < 0.8 for item in items}
    for method in range(METHODS):
        for name in range(SETS):
            for pair in range(PAIRS):
                study.add_run(handle, run_of(f"set {name}", f"{name}/{pair}", rng.sample(items, EACH), f"method {method}"))
    study.add_items(handle, [study.Item(item, "puzzle", {"size": [1, 1], "pieces": []}) for item in items])
    codes = [study.volunteer(handle, f"v{k}").code for k in range(VOLUNTEERS)]
    rows = [
        {"uuid": str(uuid.uuid4()), "kind": "vote", "item_id": item, "volunteer": code, "round": 1, "comment": "", "clock": k,
         "answer": "correct" if (rng.random() < 0.9) == right[item] else "wrong", "supersedes": None, "shown_ms": 2000, "active_ms": None,
         "presentation": "{}", "app_version": "", "created_at": "2026-01-01T00:00:00+00:00"}
        for code in codes for k, item in enumerate(items, start=1)
    ]  # fmt: skip
    with handle.writing() as connection:
        connection.execute(insert(schema.event), rows)


if __name__ == "__main__":
    main()
