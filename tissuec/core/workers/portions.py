"""Handing out items to an executor, in portions of about `PORTION` seconds.

A worker that dies takes the items under way with it: each of them is tried again alone, and
only one that then loses `TRIALS` workers has killed them.
"""

import pickle
import time as clock
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from functools import lru_cache
from threading import Lock
from typing import Any, Protocol

from tissuec.core.errors import TissueError
from tissuec.core.version import __version__
from tissuec.core.workers.workers import LOST, Common, Item, Lost, Result, Work

PORTION = 0.3  # of work at a time [s]
MOST_AT_ONCE = 64  # items in a portion
AHEAD = 2  # portions for each worker, so that none waits
TRIALS = 2  # of an item alone, which may lose its worker by chance
ROUND = 1.0  # after which the number of workers is read again [s]
_ONE = Lock()  # portion at a time in a process: a worker may have several threads

Portion = tuple[tuple[int, Any], ...]  # numbers of items, and items


class WorkerDied(Exception):
    """The worker ended before it answered."""


class Crew(Protocol):
    """What portions are handed out to."""

    def capacity(self) -> int:
        """Return how many portions are worked on at once."""
        ...

    def submit(self, packed: bytes, items: Sequence[Any]) -> Future[Any]:
        """Have ``carried_out`` called; the future raises `WorkerDied` if its worker died."""
        ...


def handed_out(
    crew: Crew, work: Work[Common, Item, Result], common: Common, items: Sequence[Item]
) -> Generator[tuple[int, Result | Lost], None, None]:
    """Yield the numbers of items with their results, as they come; see ``Workers.map``.

    Args:
        crew: Who does it.
        work: What is done to each.
        common: First argument of ``work``.
        items: Second ones.
    """
    packed, waiting, pace = pickle.dumps((work, common)), deque(enumerate(items)), _Pace()
    under_way: dict[Future[Any], Portion] = {}
    suspects: list[tuple[int, Item]] = []
    try:
        while waiting or under_way or suspects:
            if suspects and not under_way:
                yield from _one_by_one(crew, packed, suspects)
                suspects.clear()
            capacity = crew.capacity()
            while waiting and not suspects and len(under_way) < AHEAD * capacity:
                size = pace.size(len(waiting), capacity)
                portion = tuple(waiting.popleft() for _ in range(size))
                under_way[crew.submit(packed, [item for _, item in portion])] = portion
            ended, _ = wait(under_way, timeout=ROUND, return_when=FIRST_COMPLETED)
            for future in ended:
                portion = under_way.pop(future)
                if isinstance(future.exception(), WorkerDied):
                    suspects += portion
                    continue
                seconds, results = future.result()
                pace.add(seconds, len(results))
                yield from zip((number for number, _ in portion), results, strict=True)
    finally:
        for future in under_way:
            future.cancel()


def _one_by_one(
    crew: Crew, packed: bytes, items: Sequence[tuple[int, Any]]
) -> Generator[tuple[int, Any], None, None]:
    """Yield the results of items whose workers died, each tried alone; LOST if that fails."""
    for number, item in items:
        yield number, _alone(crew, packed, item)


def _alone(crew: Crew, packed: bytes, item: Any) -> Any:
    """Return the result of an item in a worker that does nothing else; LOST if it kills it.

    It is tried again, because somebody may have ended the worker by chance.
    """
    for _ in range(TRIALS):
        try:
            future = crew.submit(packed, [item])
            while not future.done():
                crew.capacity()  # which reports if there are no workers at all
                wait([future], timeout=ROUND)
            return future.result()[1][0]
        except WorkerDied:
            continue
    return LOST


class _Pace:
    """How many items make a portion, learnt from those that came back."""

    def __init__(self) -> None:
        self.seconds, self.items = 0.0, 0

    def size(self, waiting: int, workers: int) -> int:
        """Return how many items to hand out next, so that all workers end together."""
        if not self.items:
            return 1
        each = max(self.seconds / self.items, 1e-6)
        fair = max(1, waiting // (workers * AHEAD))
        return max(1, min(int(PORTION / each), MOST_AT_ONCE, fair))

    def add(self, seconds: float, items: int) -> None:
        """Take into account how long a portion took [s]."""
        self.seconds, self.items = self.seconds + seconds, self.items + items


# --- in a worker ------------------------------------------------------------------------------


def carried_out(version: str, packed: bytes, items: Sequence[Any]) -> tuple[float, list[Any]]:
    """Return the results of items, and how long they took [s]; called in a worker.

    Args:
        version: Of the program that sends the task.
        packed: A pickled pair of the function and its first argument.
        items: Second arguments.

    Raises:
        TissueError: This is another version.
    """
    if version != __version__:
        raise TissueError(
            f"a worker has tissuec {__version__}, and the study {version}; install the same "
            "version on all machines"
        )
    with _ONE:
        began = clock.perf_counter()
        work, common = _unpacked(packed)
        results = [work(common, item) for item in items]
        return clock.perf_counter() - began, results


@lru_cache(maxsize=2)
def _unpacked(packed: bytes) -> tuple[Any, Any]:
    return pickle.loads(packed)
