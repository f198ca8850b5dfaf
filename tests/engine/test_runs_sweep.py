"""Sweeps: nothing is run twice, a stop loses nothing that is done, and processes change no result."""

import json
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from engine.errors import BadInput, Cancelled
from engine.runs.sweep import Task, failed, left, read_result, run_tasks


def square(payload, wanted, progress):
    """The squares of the numbers asked for; says which process made them."""
    progress(0.5, "half")
    return [{"value": payload[k] ** 2, "process": os.getpid()} for k in wanted]


def never(payload, wanted, progress):
    raise AssertionError(f"{payload} was run again")


def refuse(payload, wanted, progress):
    raise BadInput("The file has gone.")


def die(payload, wanted, progress):
    os._exit(9)


def tasks(count):
    return [Task(f"task {n}", (f"a{n}", f"b{n}"), (n, -n - 1)) for n in range(count)]


def values(results):
    return {key: result["value"] for key, result in results.items()}


def test_results_are_kept_and_not_run_again(tmp_path):
    first = run_tasks(tasks(3), square, tmp_path)
    assert values(first) == {"a0": 0, "b0": 1, "a1": 1, "b1": 4, "a2": 4, "b2": 9}
    assert run_tasks(tasks(3), never, tmp_path) == first


def test_only_what_is_missing_or_damaged_is_run(tmp_path):
    run_tasks(tasks(2), square, tmp_path)
    (tmp_path / "b0.json").unlink()
    (tmp_path / "a1.json").write_text('{"value": ')
    seen = []

    def listen(payload, wanted, progress):
        seen.append((payload, wanted))
        return square(payload, wanted, progress)

    assert values(run_tasks(tasks(2), listen, tmp_path))["a1"] == 1
    assert seen == [((0, -1), (1,)), ((1, -2), (0,))]


def test_a_stop_keeps_what_is_done_and_the_next_run_goes_on(tmp_path):
    def stop(share, words):
        if share > 0.5:
            raise Cancelled

    with pytest.raises(Cancelled):
        run_tasks(tasks(6), square, tmp_path, progress=stop)
    kept = sorted(path.name for path in tmp_path.iterdir())
    assert 2 <= len(kept) < 12
    assert all(read_result(tmp_path / name) for name in kept)
    shares = []
    results = run_tasks(tasks(6), square, tmp_path, progress=lambda share, words: shares.append((share, words)))
    assert len(results) == 12
    assert shares[-1] == (1.0, f"{6 - len(kept) // 2} of 6 computed now")
    assert shares == sorted(shares, key=lambda s: s[0])


def test_processes_compute_and_this_one_writes(tmp_path):
    alone = run_tasks(tasks(4), square, tmp_path / "one")
    spread = run_tasks(tasks(4), square, tmp_path / "two", jobs=2)
    assert values(alone) == values(spread)
    assert {r["process"] for r in alone.values()} == {os.getpid()}
    assert os.getpid() not in {r["process"] for r in spread.values()}
    assert sorted(p.name for p in (tmp_path / "two").iterdir()) == sorted(f"{key}.json" for key in spread)


def test_a_stop_ends_the_processes(tmp_path):
    def stop(share, words):
        raise Cancelled

    before = set(multiprocessing.active_children())
    with pytest.raises(Cancelled):
        run_tasks(tasks(4), square, tmp_path, jobs=2, progress=stop)
    started = time.monotonic()
    while set(multiprocessing.active_children()) - before and time.monotonic() < started + 30:
        time.sleep(0.05)
    assert set(multiprocessing.active_children()) <= before


def linger(payload, wanted, progress):
    """The first task is done at once, the others never; each leaves its process number behind."""
    number, folder = payload
    (folder / f"{number}.pid").write_text(str(os.getpid()))
    if number:
        time.sleep(600)
    return [{"value": number}]


LINGERING = """
import sys
from pathlib import Path
sys.path[:0] = [{tests!r}]
from test_runs_sweep import linger
from engine.runs.sweep import Task, run_tasks
folder = Path({folder!r})
if __name__ == "__main__":
    run_tasks([Task(str(k), (f"k{{k}}",), (k, folder)) for k in range(3)], linger, folder / "runs", jobs=2)
"""


def alive(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until(true):
    started = time.monotonic()
    while not true() and time.monotonic() < started + 60:
        time.sleep(0.05)
    assert true()


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc to see whether a process lives")
def test_a_run_that_is_killed_leaves_whole_results_and_no_processes(tmp_path):
    script = tmp_path / "lingering.py"
    script.write_text(LINGERING.format(tests=str(Path(__file__).parent), folder=str(tmp_path)))
    run = subprocess.Popen([sys.executable, str(script)], cwd=Path(__file__).parents[2], env={**os.environ, "PYTHONPATH": "."})
    try:
        wait_until(lambda: (tmp_path / "runs" / "k0.json").exists() and len(list(tmp_path.glob("*.pid"))) == 3)
    finally:
        run.kill()
        run.wait()
    workers = {int(path.read_text()) for path in tmp_path.glob("*.pid")}
    wait_until(lambda: not any(map(alive, workers)))
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["k0.json"]
    assert read_result(tmp_path / "runs" / "k0.json") == {"value": 0}


@pytest.mark.parametrize("jobs", [1, 2])
def test_bad_input_of_a_worker_reaches_the_caller(jobs, tmp_path):
    with pytest.raises(BadInput, match="has gone"):
        run_tasks(tasks(2), refuse, tmp_path, jobs=jobs)


def test_a_worker_that_dies_is_told_in_a_sentence(tmp_path):
    with pytest.raises(BadInput, match="fewer --jobs"):
        run_tasks(tasks(2), die, tmp_path, jobs=2)
    assert threading.active_count() < 20


def test_results_are_strict_json(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        run_tasks(tasks(1), lambda p, w, g: [{"value": float("nan")}, {}], tmp_path / "runs")
    assert not (tmp_path / "runs").exists()
    (tmp_path / "list.json").write_text(json.dumps([1]))
    assert read_result(tmp_path / "list.json") is None


def test_the_time_left_is_told_from_the_pace_of_the_last_tasks():
    assert left(240, [0.0], 5.0) == "0 of 240"
    assert left(10, [0.0, 2.0, 4.0], 4.0) == "2 of 10, about 16 s left"
    assert left(10, [0.0, 2.0, 4.0], 5.0) == "2 of 10, about 15 s left"
    assert left(240, [0.0, 30.0, 60.0, 500.0], 500.0) == "3 of 240, about 118 min left"
    assert left(2, [0.0, 1.0, 2.0], 2.0) == "2 of 2"


def test_an_error_that_nobody_foresaw_is_told_and_tried_again(tmp_path):
    def once(payload, wanted, progress):
        try:
            raise ZeroDivisionError("by hand,\n twice")
        except ZeroDivisionError as error:
            return [failed(error)] * len(wanted)

    found = run_tasks(tasks(1), once, tmp_path)
    assert "(ZeroDivisionError: by hand, twice)" in found["a0"]["failure"]
    assert "test_runs_sweep.py" in found["a0"]["trace"]
    assert values(run_tasks(tasks(1), square, tmp_path)) == {"a0": 0, "b0": 1}
    assert failed(BadInput("The file has gone.")) == {"failure": "The file has gone."}
    with pytest.raises(Cancelled):
        failed(Cancelled())


def test_a_folder_that_is_none_is_refused_before_any_work(tmp_path):
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(BadInput, match="runs cannot be written to"):
        run_tasks(tasks(1), never, tmp_path / "runs")
