"""Many independent tasks in several processes, each result in a file of its own: what is there is never run again.

A task is pure: its results depend on what its keys are made of and nothing else. Workers only compute; the one process
that started them writes, beside and renamed, so that a run killed at any moment leaves whole results behind.
"""

import contextlib
import json
import multiprocessing
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from ..errors import BadInput, Cancelled, ConcordError
from ..progress import Progress, silent
from ..store import output_folder, write_together

Result = dict[str, Any]
RECENT = 20  # tasks that the time left is estimated from
MOST_WORDS = 300  # characters of an error that was not foreseen
HEARTBEAT = 0.25  # seconds between two calls of the progress while nothing is finished
TRACE = "trace"  # in a result: what ended it was not foreseen, so that it is worth another try
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Task(NamedTuple):
    """One unit of work: its name for people, the keys of its results, and all that computing them needs."""

    name: str
    keys: tuple[str, ...]
    payload: Any


Work = Callable[[Any, tuple[int, ...], Progress], list[Result]]
Asked = tuple[Task, tuple[int, ...]]  # a task and the numbers of its results that are missing


def run_tasks(
    tasks: Sequence[Task], work: Work, folder: Path, *, jobs: int = 1, progress: Progress = silent
) -> dict[str, Result]:
    """All results by their keys, those of earlier runs read from `folder`, the others computed now and kept there.

    `work(payload, wanted, progress)` gives the JSON objects of the keys numbered `wanted`; with several `jobs` it runs
    in other processes, so it must be a function of a module. Raise `Cancelled` in `progress` to stop. Raises `BadInput`
    before any work where `folder` is there and cannot be written to.
    """
    if folder.exists():
        output_folder(folder)
    found: dict[str, Result] = {}
    open_tasks: list[Asked] = []
    for task in tasks:
        kept = [read_result(folder / f"{key}.json") for key in task.keys]
        found.update({key: result for key, result in zip(task.keys, kept, strict=True) if result is not None})
        missing = tuple(number for number, result in enumerate(kept) if result is None or TRACE in result)
        if missing:
            open_tasks.append((task, missing))
    run = _in_processes if jobs > 1 and len(open_tasks) > 1 else _here
    started, ends = time.monotonic(), [0.0]
    with contextlib.closing(run(open_tasks, work, jobs, _counted(len(open_tasks), ends, progress))) as finished:
        for (task, wanted), results in finished:
            made = {task.keys[number]: result for number, result in zip(wanted, results, strict=True)}
            files = {folder / f"{key}.json": json.dumps(result, allow_nan=False) + "\n" for key, result in made.items()}
            folder.mkdir(parents=True, exist_ok=True)
            write_together(files, synced=False)
            found.update(made)
            ends.append(time.monotonic() - started)
    progress(1.0, f"{len(open_tasks)} of {len(tasks)} computed now")
    return found


def read_result(path: Path) -> Result | None:
    """The result of an earlier run, None where there is none or it is damaged."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and found else None


def failed(error: Exception) -> Result:
    """What is kept of a task that went wrong: a sentence as `failure`, and the trace of an error that was not foreseen.

    One pair that fails says so and the others go on; someone who wants the work to stop (`Cancelled`) is no failure.
    """
    if isinstance(error, Cancelled):
        raise error
    if isinstance(error, ConcordError):
        return {"failure": str(error)}
    words = " ".join(f"{type(error).__name__}: {error}".split())
    sentence = f"An error that was not foreseen ({words[:MOST_WORDS]}); its trace is in the folder runs, and it is tried again next time."
    return {"failure": sentence, TRACE: "".join(traceback.format_exception(error))}


def left(total: int, ends: Sequence[float], now: float) -> str:
    """How far the work is, in words: '37 of 240, about 12 min left', from the median pace of the last tasks.

    `ends` are the seconds since the start at which tasks ended, the first being 0 for the start.
    """
    done = len(ends) - 1
    words = f"{done} of {total}"
    if done < 1 or done >= total:
        return words
    recent = ends[-RECENT - 1 :]
    paces = [b - a for a, b in pairwise(recent)]
    seconds = max((total - done) * median(paces) - (now - ends[-1]), 0.0)
    return f"{words}, about {seconds / 60:.0f} min left" if seconds >= 90 else f"{words}, about {seconds:.0f} s left"


def _counted(total: int, ends: list[float], progress: Progress) -> Progress:
    """Progress of the whole from that of the task that is running; `ends` grows while tasks end."""
    started = time.monotonic()

    def tell(share: float, words: str) -> None:
        progress(min((len(ends) - 1 + share) / max(total, 1), 1.0), left(total, ends, time.monotonic() - started))

    return tell


def _here(tasks: Sequence[Asked], work: Work, jobs: int, progress: Progress) -> Generator[tuple[Asked, list[Result]], None, None]:
    """One after the other in this process."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        for task in tasks:
            progress(0.0, task[0].name)
            yield task, work(task[0].payload, task[1], progress)


def _in_processes(
    tasks: Sequence[Asked], work: Work, jobs: int, progress: Progress
) -> Generator[tuple[Asked, list[Result]], None, None]:
    """In `jobs` fresh processes, as they end; all of them are stopped when the caller stops."""
    before = set(multiprocessing.active_children())
    with _one_thread_each():
        pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=_worker)
        running: dict[Future[list[Result]], Asked] = {}
        try:
            running |= {pool.submit(_call, work, asked[0].payload, asked[1]): asked for asked in tasks}
            while running:
                progress(0.0, "")
                for future in wait(running, HEARTBEAT, FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
        except BrokenProcessPool:
            raise BadInput("A worker process was ended, most likely for want of memory; start the same command again with "
                           "fewer --jobs: what is done is kept.") from None  # fmt: skip
        finally:
            pool.shutdown(wait=not running, cancel_futures=True)
            for child in set(multiprocessing.active_children()) - before:
                child.terminate()


def _call(work: Work, payload: Any, wanted: tuple[int, ...]) -> list[Result]:
    return work(payload, wanted, silent)


def _worker() -> None:
    """A worker leaves Ctrl+C to the process that started it, ends when that ends, and uses one thread."""
    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(1)


def _end_with_parent() -> None:
    """A process that is killed cannot tell its workers; they would wait for work for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes started meanwhile compute with one thread each."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
