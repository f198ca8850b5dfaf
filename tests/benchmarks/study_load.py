"""Many processes vote on one study as fast as they can; counts errors and prints how long votes took.

    python tests/benchmarks/study_load.py [--processes 8] [--seconds 20] [--url postgresql://… | --server]

Without an address, on one SQLite file; with --server, on a PostgreSQL server that is started for this and writes to its
disk, each process with the login of an invited volunteer.
"""

import argparse
import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "annotation"))

from killing import VOTER, Told, add_many, begin, started, told

from annotation import study
from annotation.server.invitations import invite


@contextlib.contextmanager
def place(url: str, server: bool) -> Iterator[str]:
    """Where a new study is to be made."""
    if url:
        yield url
    elif server:
        from postgres_server import running

        with running(fsync="on") as made:
            yield made.database()
    else:
        with tempfile.TemporaryDirectory() as folder:
            yield str(Path(folder) / "a.db")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--url", default="")
    parser.add_argument("--server", action="store_true")
    chosen = parser.parse_args(arguments)
    codes = [f"v{n:02}" for n in range(chosen.processes)]
    with place(chosen.url, chosen.server) as where, study.create_study(where, name="load") as handle:
        add_many(handle, 500)
        remote = bool(chosen.url or chosen.server)
        own: Any = {code: invite(handle, code) if remote else where for code in codes}  # type: ignore[arg-type]
        voters = [started(VOTER, own[code], code, chosen.seconds) for code in codes]
        begin(voters)
        ends = [voter.communicate() for voter in voters]
        with handle.reading() as connection:
            rows = connection.exec_driver_sql("SELECT uuid, item_id, volunteer, answer FROM event WHERE kind = 'vote'").all()
    return report(voters, ends, {row[0]: tuple(row[1:]) for row in rows}, chosen.seconds)


def report(voters: list[subprocess.Popen], ends: list[tuple[str, str]], kept: dict[str, tuple[str, ...]], seconds: float) -> int:
    """Print the figures; 1 where any vote was refused, lost or mis-attached."""
    failed = [errors.strip().splitlines()[-1] for voter, (_, errors) in zip(voters, ends, strict=True) if voter.returncode]
    votes: list[Told] = [one for output, _ in ends for one in told(output)]
    lost, wrong = sum(one.uuid not in kept for one in votes), sum(kept.get(one.uuid, one[1:4]) != one[1:4] for one in votes)
    waited = sorted(one.seconds for one in votes) or [float("nan")]
    p50, p99 = (1000 * waited[int(share * (len(waited) - 1))] for share in (0.5, 0.99))
    fewest = min(len(told(output)) for output, _ in ends)
    print(f"{len(voters)} processes, {seconds:g} s: {len(votes)} votes ({fewest} of the slowest), {len(failed)} errors, {lost} lost, "
          f"{wrong} mis-attached; a vote took {p50:.1f} ms (p50), {p99:.0f} ms (p99), {1000 * waited[-1]:.0f} ms (longest)")  # fmt: skip
    print(*failed, sep="\n", end="\n" if failed else "")
    return int(bool(failed) or lost > 0 or wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
