"""Workers of a dask scheduler that is running: on this machine, or on many."""

import time as clock
import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from functools import partial
from importlib import import_module
from typing import Any, Self

from tissuec.core.errors import TissueError, TissueWarning
from tissuec.core.progress import minutes
from tissuec.core.version import __version__
from tissuec.core.workers.portions import WorkerDied, carried_out, handed_out
from tissuec.core.workers.workers import Common, Item, Lost, Result, Work

PATIENCE = 10.0  # for an answer of a scheduler [s]
LOOK = 5.0  # at the number of workers, which may come and go [s]
REMINDER = 60.0  # after which it is reported again that there are none [s]


def warn(text: str) -> None:
    """Warn the program that uses a cluster."""
    warnings.warn(text, TissueWarning, stacklevel=2)


class Cluster:
    """Applies functions by the workers of a dask scheduler.

    Args:
        address: Of the scheduler, such as "tcp://127.0.0.1:8786".
        tell: Called repeatedly with a sentence while all workers are gone.

    Raises:
        TissueError: It does not answer, has no workers, or these have another version.
    """

    def __init__(self, address: str, tell: Callable[[str], None] = warn):
        self.address, self._client, self._tell = address, _client(address), tell
        try:
            self._count = _checked(self._client, address)
        except BaseException:
            self._client.close()
            raise
        self._executor = self._client.get_executor(pure=False)
        self._looked = self._seen = clock.monotonic()
        self._reminded = 0

    def map(
        self, work: Work[Common, Item, Result], common: Common, items: Sequence[Item]
    ) -> Generator[tuple[int, Result | Lost], None, None]:
        """Yield the number of each item with its result; see `Workers`."""
        yield from handed_out(self, work, common, items)

    def capacity(self) -> int:
        """Return how many calls the workers do at once; one at the least."""
        if clock.monotonic() > self._looked + LOOK:
            self._looked = clock.monotonic()
            self._count = sum(_asked(self._client.nthreads, self.address).values())
            self._remind()
        return max(self._count, 1)

    def _remind(self) -> None:
        """Tell once in a while that there are no workers, for which a study waits."""
        if self._count:
            self._seen, self._reminded = self._looked, 0
            return
        lonely = self._looked - self._seen
        if lonely > REMINDER * (self._reminded + 0.5):
            self._reminded += 1
            self._tell(
                f'the scheduler at "{self.address}" has had no workers for {minutes(lonely)}; '
                f"the study waits for some: dask worker {self.address} --nthreads 1"
            )

    def submit(self, packed: bytes, items: Sequence[Any]) -> Future[Any]:
        """Hand out a portion; see `Crew`."""
        inner = self._executor.submit(carried_out, __version__, packed, items)
        outer = Future[Any]()
        inner.add_done_callback(partial(self._pass, outer=outer))
        return outer

    def _pass(self, ended: Future[Any], outer: Future[Any]) -> None:
        """Give what became of a call to who waits for it, in words of ours."""
        if not outer.set_running_or_notify_cancel():
            return  # nobody waits for it any more
        if ended.cancelled():
            outer.set_exception(TissueError(_gone(self.address)))
            return
        error = ended.exception()
        if error is None:
            outer.set_result(ended.result())
        else:
            is_lost = type(error).__name__ == "KilledWorker"
            outer.set_exception(WorkerDied() if is_lost else error)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self._executor.shutdown(wait=False)
        self._client.close()


def _client(address: str) -> Any:
    """Return a client of a scheduler."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise TissueError(
            'a scheduler needs dask.distributed; pip install "tissuec[cluster]" installs it'
        ) from error
    try:
        return distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise TissueError(
            f'no scheduler answers at "{address}"; start one with: dask scheduler'
        ) from error


def _asked(call: Any, address: str) -> Any:
    """Return the answer of a scheduler.

    Raises:
        TissueError: It does not.
    """
    try:
        return call()
    except (OSError, TimeoutError, RuntimeError) as error:
        raise TissueError(_gone(address)) from error


def _gone(address: str) -> str:
    return f'the scheduler at "{address}" does not answer any more'


def _checked(client: Any, address: str) -> int:
    """Return how many calls the workers of a scheduler do at once."""
    threads: dict[str, int] = client.nthreads()
    if not threads:
        raise TissueError(
            f'the scheduler at "{address}" has no workers; start some with: '
            f"dask worker {address}"
        )
    for worker, found in client.run(version, on_error="return").items():
        if found == __version__:
            continue
        if isinstance(found, BaseException):
            raise TissueError(
                f"worker {worker} cannot import tissuec: {found}; install it on all machines"
            )
        raise TissueError(
            f"worker {worker} has tissuec {found}, and here is {__version__}; install the same "
            "version on all machines"
        )
    return sum(threads.values())


def version() -> str:
    """Return the version of tissuec; called in a worker."""
    return __version__
