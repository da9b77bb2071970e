"""Threads that share the loops of a run over nodes and springs.

While compiled code steps, they busy-wait for the next loop, which
``kernels.thread_loops.share`` begins; between calls of that code they sleep.
"""

import ctypes
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Self

import numpy as np

from tissuec.compiled import loading
from tissuec.compiled.record_tables import aligned_zeros
from tissuec.forces.pairs_kernel import ROOM
from tissuec.kernels import records
from tissuec.kernels.thread_loops import pieces_of

LEAST_SPRINGS = 20_000  # of a thread; with fewer, waiting costs more than sharing gains
PARTS = 4  # of a loop for each thread: who is held up by something else leaves parts to others
# As in ``compiled/team.ll``.
LOOP, ALL_PARTS, OWN_PARTS, GIVE_WAY, TAKEN, APART = 0, 3, 4, 24, 32, 8


class ThreadTeam:
    """The threads of one run, awake within ``with team:``.

    Args:
        threads: How many, the one that enters included.
        nodes: Of the net.

    Attributes:
        parts: Into how many parts loops are divided.
        record: What kernels are given.
    """

    def __init__(self, threads: int, nodes: int):
        pieces, self.parts = max(pieces_of(nodes), 1), PARTS * threads if threads > 1 else 1
        self.record = records.Team(
            threads=threads,
            words=aligned_zeros(TAKEN + APART * self.parts).view(np.int64),
            found=np.zeros((2, self.parts)),
            each=aligned_zeros(self.parts, ROOM),
            work=np.zeros(pieces),
            lost=np.zeros(pieces),
            near=np.zeros(pieces, dtype=np.int64),
        )
        self._pool: ThreadPoolExecutor | None = None
        self._awake: list[Future[None]] = []

    def __enter__(self) -> Self:
        others, words = self.record.threads - 1, self.record.words
        if others and self._pool is None:
            self._pool = ThreadPoolExecutor(others, "tissuec")
            words[ALL_PARTS], words[OWN_PARTS] = self.parts, PARTS
            words[GIVE_WAY] = _giving_way()
        if self._pool is not None:
            serve = _function("serve", ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)
            place, before = words.ctypes.data, int(words[LOOP])
            self._awake = [
                self._pool.submit(serve, place, thread, before)
                for thread in range(1, others + 1)
            ]
        return self

    def __exit__(self, *failure: object) -> None:
        if self._awake:
            dismiss = _function("dismiss", ctypes.c_void_p, ctypes.c_int64)
            dismiss(self.record.words.ctypes.data, len(self._awake))
            for thread in self._awake:
                thread.result()
            self._awake = []


def useful(threads: int, springs: int) -> int:
    """Return how many of some threads a net keeps busy."""
    return max(1, min(threads, springs // LEAST_SPRINGS))


def _function(name: str, *arguments: Any) -> Callable[..., None]:
    """Return a function of threads, for C."""
    return ctypes.CFUNCTYPE(None, *arguments)(loading.address("team", name))


def _giving_way() -> int:
    """Return where the function of the system is that lets others have the processor."""
    if os.name == "nt":
        function = ctypes.WinDLL("kernel32").SwitchToThread  # type: ignore[attr-defined]
    else:
        function = ctypes.CDLL(None).sched_yield
    return ctypes.cast(function, ctypes.c_void_p).value or 0
