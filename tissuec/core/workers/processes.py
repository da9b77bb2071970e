"""Processes of this machine: an executor with a thread and a pipe for each of them.

A process that dies costs the call that it was at, and no other one. (Of those of
``concurrent.futures`` all are ended then, and all calls under way are lost.)
"""

import gc
import os
import pickle
import signal
import sys
import tempfile
import threading
import time as clock
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from multiprocessing import connection, get_context, parent_process
from queue import SimpleQueue
from typing import Any, NoReturn, Self

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.version import __version__
from tissuec.core.workers.portions import WorkerDied, carried_out, handed_out
from tissuec.core.workers.workers import Common, Item, Lost, Result, Work

TRIALS, PAUSE = 4, 0.2  # of starting a process, and between them, ever longer [s]
MANY_OBJECTS = 50_000  # more, before cycles among them are searched for: few are garbage
_FORKS = hasattr(os, "fork")
_SAFE_PATH = "PYTHONSAFEPATH"
_OF_MAIN = ("__spec__", "__file__")
_SHORT, _LONGEST = "/tmp", 60  # bytes of a folder for sockets, whose paths have to be short
_starting = threading.RLock()  # what is changed meanwhile belongs to the whole process


class Processes:
    """Applies functions in processes of this machine.

    Args:
        count: Number of processes.
    """

    def __init__(self, count: int):
        self.count, self._executor = count, ProcessExecutor(count)

    def map(
        self, work: Work[Common, Item, Result], common: Common, items: Sequence[Item]
    ) -> Generator[tuple[int, Result | Lost], None, None]:
        """Yield the number of each item with its result; see `Workers`."""
        self._executor.preload = [carried_out.__module__, work.__module__]
        yield from handed_out(self, work, common, items)

    def capacity(self) -> int:
        """Return the number of processes."""
        return self.count

    def submit(self, packed: bytes, items: Sequence[Any]) -> Future[Any]:
        """Hand out a portion; see `Crew`."""
        return self._executor.submit(carried_out, __version__, packed, items)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self._executor.shutdown(wait=False)


class _Worker(Struct, frozen=True, eq=False):
    """A process, and the end of its pipe that is here."""

    process: Any
    pipe: Any


class ProcessExecutor(Executor):
    """Calls functions in processes, which are started when there is something to do.

    Args:
        count: Number of processes.

    Attributes:
        preload: Modules that processes have from their beginning.
    """

    def __init__(self, count: int):
        self.preload: list[str] = []
        self._count, self._calls = count, SimpleQueue[Any]()
        self._is_over = False
        self._workers: set[_Worker] = set()
        for _ in range(count):
            # No program waits for these threads at its end.
            threading.Thread(target=self._serve, daemon=True).start()

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        """Have a function called in a process.

        Args:
            call: A function of a module.
            args, named: Its arguments, which are pickled.

        Returns:
            What raises as the function does, `WorkerDied` if the process ends before its
            answer, and TissueError if no process can be started.
        """
        future = Future[Any]()
        self._calls.put((future, pickle.dumps((call, args, named))))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End all processes at once, whatever they are doing."""
        self._is_over = True
        for worker in tuple(self._workers):
            worker.process.kill()
        for _ in range(self._count):
            self._calls.put(None)

    def _serve(self) -> None:
        """Hand calls to one process after the other; the work of a thread."""
        worker = None
        while (item := self._calls.get()) is not None and not self._is_over:
            future, packed = item
            if not future.set_running_or_notify_cancel():
                continue
            try:
                worker = worker or self._started()
                worker.pipe.send_bytes(packed)
                is_right, answer = worker.pipe.recv()
            except (EOFError, OSError):
                self._buried(worker)
                worker = None
                future.set_exception(WorkerDied())
            except BaseException as error:
                future.set_exception(error)
            else:
                (future.set_result if is_right else future.set_exception)(answer)

    def _started(self) -> _Worker:
        """Return a new process that is ready.

        Raises:
            TissueError: It does not start.
        """
        reason: BaseException | None = None
        for trial in range(TRIALS):
            clock.sleep(trial * PAUSE)  # a server of processes that was killed is still noticed
            try:
                worker = _launched(self.preload)
                self._workers.add(worker)
                if self._is_over:  # so that nobody would end it
                    worker.process.kill()
                worker.pipe.recv()
                return worker
            except (EOFError, OSError) as error:
                reason = error
        raise TissueError(
            f"no worker process starts: {reason or 'they end at once'}; --workers 1 does "
            "without them"
        )

    def _buried(self, worker: _Worker | None) -> None:
        if worker is not None:
            self._workers.discard(worker)
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()


def _launched(preload: Sequence[str]) -> _Worker:
    """Start a process, which does not import the script that is running here."""
    # Neither threads nor open files of this process are taken along.
    context = get_context("forkserver") if _FORKS else get_context("spawn")
    if _FORKS:
        context.set_forkserver_preload(list(preload))
    here, there = context.Pipe()
    try:
        with _starting, _without_main(), _safe_path(), _short_sockets():
            process = context.Process(target=_work, args=(there,), daemon=True)
            process.start()
    finally:
        there.close()  # so that the end of the process ends the pipe
    return _Worker(process, here)


@contextmanager
def _without_main() -> Generator[None]:
    """Hide what the script is that runs here."""
    main = sys.modules["__main__"]
    hidden = {name: vars(main).pop(name) for name in _OF_MAIN if name in vars(main)}
    main.__spec__ = None
    try:
        yield
    finally:
        vars(main).update(hidden)


@contextmanager
def _safe_path() -> Generator[None]:
    """Have new interpreters import nothing from the current folder, where anything may lie."""
    before = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_SAFE_PATH]
        else:
            os.environ[_SAFE_PATH] = before


@contextmanager
def _short_sockets() -> Generator[None]:
    """Keep sockets out of folders with long names, such as those of batch systems."""
    usual = tempfile.gettempdir()
    if _FORKS and len(os.fsencode(usual)) > _LONGEST and os.access(_SHORT, os.W_OK):
        tempfile.tempdir = _SHORT
    try:
        yield
    finally:
        tempfile.tempdir = usual


# --- in a process -----------------------------------------------------------------------------


def _work(pipe: Any) -> None:
    """Answer calls until the pipe ends."""
    _begin()
    with suppress(EOFError, OSError):
        pipe.send(None)
        while True:
            packed = pipe.recv_bytes()
            pipe.send_bytes(_answer(packed))


def _answer(packed: bytes) -> bytes:
    """Return the pickled result of a call, or what it raised."""
    try:
        call, args, named = pickle.loads(packed)
        return pickle.dumps((True, call(*args, **named)))
    except BaseException as error:
        with suppress(Exception):
            packed = pickle.dumps((False, error))
            pickle.loads(packed)
            return packed
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))


def _begin() -> None:
    """Make a process ready: it ends by signals at once, and does not outlive its parent."""
    gc.freeze()  # what was imported, which no search for cycles needs to visit
    gc.set_threshold(MANY_OBJECTS)
    for name in ("SIGINT", "SIGHUP"):  # those of a terminal, which the parent gets, too
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # A run leaves alone what somebody handles; by itself it would take time to end.
    signal.signal(signal.SIGTERM, _end)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()


def _end(*_: object) -> NoReturn:
    os._exit(1)


def _die_with(sentinel: Any) -> None:
    connection.wait([sentinel])
    _end()
