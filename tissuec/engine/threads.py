"""Threads that share loops over nodes and springs, and the chunks that each of them takes.

A spring belongs to the chunk of its lower node. What it does to an upper node of another chunk
is summed in a slot that its chunk has for that node; afterwards, each node adds up its slots in
the order of the chunks. What is computed at a time in blocks has no node in common, and the
order of what is computed in succession is fixed. So sums depend neither on the number of
threads nor on their pace.

Threads that share the loops of a run over nodes and springs.

While compiled code steps, they busy-wait for the next loop, which
``kernels.thread_loops.share`` begins; between calls of that code they sleep.
"""

import ctypes
import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled import loading
from tissuec.compiled.record_tables import aligned_zeros
from tissuec.forces.fields import Field
from tissuec.forces.springs.pairs_kernel import ROOM
from tissuec.kernels import records
from tissuec.kernels.records import Chunks
from tissuec.kernels.thread_loops import PIECE, pieces_of
from tissuec.model.network import Indices

Places = NDArray[np.integer]
BLOCK_NODES = 1024  # of a block, at least; what belongs to its springs fits into a cache
LEAST_BLOCKS = 4  # that are worth being shared by threads
BITS = 64  # blocks that a number can name


def block_size(low: Places, high: Places) -> int:
    """Return the number of nodes of a block such that no spring is longer than a block.

    Then every other block, with all springs that begin in it, has no node in common with the
    next one.

    Args:
        low, high: Lower and upper nodes of springs, shape (spring,).
    """
    return _rounded(int((high - low).max(initial=0)))


def are_several(high: Places, size: int) -> bool:
    """Return whether there are enough blocks for threads to share.

    Args:
        high: Upper nodes of springs, shape (spring,).
        size: Number of nodes of a block.
    """
    return int(high.max(initial=0)) + 1 >= LEAST_BLOCKS * size


def parts_of(field: Field, place: Indices) -> list[list[Field]]:
    """Return the parts of a field, in groups whose members have no node in common.

    Items are in one part if their nodes are in the same blocks. Greedily, each part joins the
    first group whose parts have nodes in other blocks only.

    Args:
        place: Index of each node in the arrays of the kernel, shape (node,).
    """
    count = len(place) - len(field.internal_rows)  # none of which has two items
    is_small = count < LEAST_BLOCKS * BLOCK_NODES
    items = None if is_small else field.items(place)
    if items is None or len(items.first) < 2:
        return [[field]]
    low, high = (
        extreme.reduceat(items.places, items.first[:-1]) for extreme in (np.minimum, np.maximum)
    )
    size = _rounded(max(-(-count // BITS), int(np.median(high - low))))
    blocks = np.left_shift(np.uint64(1), (items.places // size).astype(np.uint64))
    touched = np.bitwise_or.reduceat(blocks, items.first[:-1])
    order = np.argsort(touched, kind="stable")
    found, begins = np.unique(touched[order], return_index=True)
    groups: list[list[Field]] = []
    taken: list[int] = []
    for part, which in zip(found.tolist(), np.split(order, begins[1:]), strict=True):
        group = next((k for k, other in enumerate(taken) if not other & part), len(groups))
        if group == len(groups):
            groups.append([])
            taken.append(0)
        groups[group].append(field.only(which))
        taken[group] |= part
    return groups


def _rounded(nodes: int) -> int:
    """Return the number of nodes of a block that has at least some."""
    return -(-max(nodes, BLOCK_NODES) // PIECE) * PIECE


NODES = 4096  # of a chunk, at least
MOST = 64  # chunks
LEAST = 4  # chunks that are worth being shared by threads


def are_chunks(nodes: int) -> bool:
    """Return whether a net has several chunks, so that threads can share them."""
    return nodes >= LEAST * NODES


def chunks_of(low: Places, high: Places, nodes: int, whole: int | None = None) -> Chunks:
    """Return chunks of a net.

    Args:
        low, high: Ends of springs as places of nodes, by ascending lower ones, shape (spring,).
        nodes: How many there are.
        whole: How many there are with rows of variables that are left out for a time, on which
            the chunks of all others must not depend; by default none are.
    """
    lower, upper = (4 * low).astype(np.uint32), (4 * high).astype(np.uint32)
    whole = nodes if whole is None else whole
    size = max(whole, 1)
    if are_chunks(whole):
        size = -(-max(NODES, -(-whole // MOST)) // PIECE) * PIECE
    begins = np.append(np.arange(0, nodes, size), nodes)
    chunk = low // size
    away = np.flatnonzero(high // size != chunk)
    keys, inverse = np.unique(
        chunk[away].astype(np.int64) * nodes + high[away], return_inverse=True
    )
    to = upper.copy() if len(away) else upper
    to[away] = 4 * (nodes + inverse)
    node = keys % nodes
    of = np.argsort(node, kind="stable")
    return Chunks(
        node=begins,
        low=lower,
        high=upper,
        to=to,
        states=aligned_zeros(8 * nodes),
        sums=aligned_zeros(4 * (nodes + len(keys))),
        slot=np.searchsorted(keys, np.arange(len(begins)) * nodes),
        first=np.searchsorted(node[of], np.arange(nodes + 1)).astype(np.uint32),
        of=(4 * of).astype(np.uint32),
    )


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
