"""Workers of a study: this process, processes on this machine, or a dask scheduler.

Runs are handed out in portions of about `PORTION` seconds. A worker that dies takes the runs
under way with it: each of them is tried again alone, and only one whose worker dies again has
killed it. What any worker returns depends on the run alone.
"""

import gc
import os
import pickle
import signal
import sys
import threading
import time as clock
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import connection, get_context, parent_process
from typing import Any, Protocol

from tissuec.core.errors import TissueError
from tissuec.core.processors import permitted
from tissuec.studies.rows import DIED, Row
from tissuec.studies.trial import Job, Task, carry_out, failed, row_of

PORTION = 0.3  # of work at a time [s]
MOST_AT_ONCE = 64  # runs in a portion
AHEAD = 2  # portions for each worker, so that none waits
PATIENCE = 10.0  # for an answer of a scheduler [s]
MANY_OBJECTS = 50_000  # more, before cycles among them are searched for: few are garbage
KILLED = "its worker process died"
_OF_MAIN = ("__spec__", "__file__")

Portion = tuple[Task, ...]
#: Makes an executor with so many workers.
Make = Callable[[int], Executor]


class Workers(Protocol):
    """What carries out the runs of a study."""

    def rows(self, job: Job, tasks: Sequence[Task]) -> Iterator[Row]:
        """Yield the rows of runs as they come."""
        ...


class OwnProcess:
    """Carries out runs one after the other in this process."""

    def rows(self, job: Job, tasks: Sequence[Task]) -> Iterator[Row]:
        """Yield the rows of runs as they come."""
        for task in tasks:
            yield row_of(job, task)


class Processes:
    """Carries out runs in processes of this machine.

    Args:
        count: Number of processes.
    """

    def __init__(self, count: int):
        self.count = count

    def rows(self, job: Job, tasks: Sequence[Task]) -> Iterator[Row]:
        """Yield the rows of runs as they come."""
        count = max(1, min(self.count, len(tasks)))
        yield from _handed_out(_pool, count, job, tasks)


class Cluster:
    """Carries out runs by the workers of a dask scheduler.

    Args:
        address: Of the scheduler, such as "tcp://127.0.0.1:8786".

    Raises:
        TissueError: It does not answer, has no workers, or these have another version.
    """

    def __init__(self, address: str):
        self.client = _client(address)
        self.count = _worker_count(self.client, address)

    def rows(self, job: Job, tasks: Sequence[Task]) -> Iterator[Row]:
        """Yield the rows of runs as they come."""
        try:
            yield from _handed_out(
                lambda count: self.client.get_executor(pure=False), self.count, job, tasks
            )
        finally:
            self.client.close()


def workers_of(count: int | None = None, scheduler: str | None = None) -> Workers:
    """Return the workers that are asked for.

    Args:
        count: Number of processes; one is this process. By default one for each processor.
        scheduler: Address of a dask scheduler, instead.

    Raises:
        TissueError: The scheduler cannot be used.
    """
    if scheduler is not None:
        return Cluster(scheduler)
    count = count or permitted()
    return OwnProcess() if count == 1 else Processes(count)


# --- handing out ------------------------------------------------------------------------------


class _Pace:
    """How many runs make a portion, learnt from those that came back."""

    def __init__(self) -> None:
        self.seconds, self.runs = 0.0, 0

    def size(self, waiting: int, workers: int) -> int:
        """Return how many runs to hand out next, so that all workers end together."""
        if not self.runs:
            return 1
        each = max(self.seconds / self.runs, 1e-6)
        fair = max(1, waiting // (workers * AHEAD))
        return max(1, min(int(PORTION / each), MOST_AT_ONCE, fair))

    def add(self, seconds: float, runs: int) -> None:
        """Take into account how long a portion took [s]."""
        self.seconds, self.runs = self.seconds + seconds, self.runs + runs


def _timed(packed: bytes, tasks: Portion) -> tuple[float, list[Row]]:
    """Return the rows of runs, and how long they took [s]; called in a worker."""
    began = clock.perf_counter()
    rows = carry_out(packed, tasks)
    return clock.perf_counter() - began, rows


def _handed_out(make: Make, count: int, job: Job, tasks: Sequence[Task]) -> Iterator[Row]:
    """Yield the rows of runs; those whose workers die are tried again, one by one."""
    packed, waiting, pace = pickle.dumps(job), deque(tasks), _Pace()
    executor = make(count)
    under_way: dict[Future[tuple[float, list[Row]]], Portion] = {}
    try:
        while waiting or under_way:
            suspects: list[Task] = []
            try:
                while waiting and len(under_way) < AHEAD * count:
                    size = pace.size(len(waiting), count)
                    portion = tuple(waiting.popleft() for _ in range(min(size, len(waiting))))
                    try:
                        under_way[_submit(executor, packed, portion)] = portion
                    except BrokenProcessPool:
                        waiting.extendleft(reversed(portion))
                        raise
                ended, _ = wait(under_way, return_when=FIRST_COMPLETED)
                for future in ended:
                    portion = under_way.pop(future)
                    error = future.exception()
                    if error is None:
                        seconds, rows = future.result()
                        pace.add(seconds, len(rows))
                        yield from rows
                    elif isinstance(error, BrokenProcessPool):
                        under_way[future] = portion
                        raise error
                    else:
                        suspects += _blamed(error, portion)
            except BrokenProcessPool:
                finished, suspects = _salvaged(under_way)
                yield from finished
                under_way.clear()
                _end(executor)
                executor = make(count)
            for task in suspects:
                yield _alone(make, job, packed, task)
    finally:
        _end(executor)


def _salvaged(
    under_way: dict[Future[tuple[float, list[Row]]], Portion],
) -> tuple[list[Row], list[Task]]:
    """Return the rows that came before a pool broke, and the runs that may have broken it."""
    rows, suspects = list[Row](), list[Task]()
    for future, portion in under_way.items():
        with suppress(BaseException):
            rows += future.result(timeout=PATIENCE)[1]
            continue
        suspects += portion
    return rows, suspects


def _blamed(error: BaseException, portion: Portion) -> Portion:
    """Return the runs of a portion that was lost with its worker.

    Raises:
        BaseException: It was lost otherwise.
    """
    is_lost = isinstance(error, KeyboardInterrupt)  # somebody told the worker to end
    if is_lost or type(error).__name__ in ("KilledWorker", "CancelledError"):
        return portion
    raise error


def _alone(make: Make, job: Job, packed: bytes, task: Task) -> Row:
    """Return the row of a run in a worker of its own, or that it died."""
    executor = make(1)
    try:
        return _submit(executor, packed, (task,)).result()[1][0]
    except BrokenProcessPool:
        return failed(job, task, DIED, KILLED)
    except Exception as error:
        _blamed(error, (task,))
        return failed(job, task, DIED, KILLED)
    finally:
        _end(executor)


# --- processes --------------------------------------------------------------------------------


def _pool(count: int) -> Executor:
    # Neither threads nor open files of this process are taken along.
    context = get_context("forkserver" if hasattr(os, "fork") else "spawn")
    if hasattr(os, "fork"):
        context.set_forkserver_preload([_timed.__module__])
    return ProcessPoolExecutor(count, mp_context=context, initializer=_begin)


def _submit(
    executor: Executor, packed: bytes, portion: Portion
) -> Future[tuple[float, list[Row]]]:
    """Hand out a portion; new processes do not import the script that started the study."""
    main = sys.modules["__main__"]
    hidden = {name: vars(main).pop(name) for name in _OF_MAIN if name in vars(main)}
    main.__spec__ = None
    try:
        return executor.submit(_timed, packed, portion)
    finally:
        vars(main).update(hidden)


def _begin() -> None:
    """Make a worker ready: the study handles signals, and no worker outlives it."""
    gc.freeze()  # what was imported, which no search for cycles need look at
    gc.set_threshold(MANY_OBJECTS)
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()


def _die_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


def _end(executor: Executor) -> None:
    """End an executor at once, with its processes."""
    processes = list((getattr(executor, "_processes", None) or {}).values())
    executor.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.terminate()


# --- dask -------------------------------------------------------------------------------------


def _client(address: str) -> Any:
    """Return a client of a scheduler."""
    try:
        from distributed import (  # pyright: ignore[reportMissingImports]
            Client,
        )
    except ImportError as error:
        raise TissueError(
            'a scheduler needs dask.distributed; pip install "tissuec[cluster]" installs it'
        ) from error
    try:
        return Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise TissueError(
            f'no scheduler answers at "{address}"; start one with: dask scheduler'
        ) from error


def _worker_count(client: Any, address: str) -> int:
    """Return how many runs the workers of a scheduler do at once."""
    from tissuec.core.version import __version__

    threads: dict[str, int] = client.nthreads()
    if not threads:
        client.close()
        raise TissueError(
            f'the scheduler at "{address}" has no workers; start some with: '
            f"dask worker {address}"
        )
    versions: dict[str, str] = client.run(worker_version)
    others = {worker: found for worker, found in versions.items() if found != __version__}
    if others:
        client.close()
        worker, found = next(iter(others.items()))
        raise TissueError(
            f"worker {worker} has tissuec {found}, and here is {__version__}; "
            "install the same version on all machines"
        )
    return sum(threads.values())


def worker_version() -> str:
    """Return the version of tissuec; called in a worker."""
    from tissuec.core.version import __version__

    return __version__
