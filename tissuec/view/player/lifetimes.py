"""Lifetimes of drawn objects: from the topologies of a file to ranges of frames."""

from collections import defaultdict
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import Event

FOREVER = 1e9  # frames
_MOST_NODES = 1 << 21  # for numbers of three nodes to fit into one of 63 bits
Mask = NDArray[np.bool_]


class Lifetimes(NamedTuple):
    """Lifetimes of items; one that returns is listed more than once.

    Attributes:
        of: Numbers of what is there, ascending, shape (life,).
        life: From which frame on, and until which, shape (life, 2).
    """

    of: Indices
    life: Floats


def is_there(life: Floats, frame: float) -> Mask:
    """Return which items exist in a frame, or between two, shape (life,).

    Args:
        life: First and last frame, in units of frames, shape (life, 2).
    """
    return (life[:, 0] <= frame) & (frame < life[:, 1])


def lives(changes: Iterable[tuple[float, Mask]], count: int) -> Lifetimes:
    """Return the lives of ``count`` things.

    Args:
        changes: In order, a frame, and which of them are there from then on, shape (count,).
    """
    there, since = np.zeros(count, dtype=bool), np.zeros(count)
    found: list[tuple[Indices, Floats, float]] = []
    for frame, now in changes:
        gone = np.flatnonzero(there & ~now)
        found.append((gone, since[gone], frame))
        since[now & ~there] = frame
        there = now
    left = np.flatnonzero(there)
    found.append((left, since[left], FOREVER))
    of = np.concatenate([one[0] for one in found])
    births = np.concatenate([one[1] for one in found])
    deaths = np.concatenate([np.full(len(one[0]), one[2]) for one in found])
    order = np.lexsort((births, of))
    return Lifetimes(of[order], np.stack([births, deaths], axis=1)[order])


class Timeline(Struct, frozen=True, eq=False):
    """The frames that are shown.

    Attributes:
        times: [s], shape (frame,).
    """

    times: Floats

    def frame_of(self, time: float | Floats) -> Floats:
        """Return the places of times [s] among the frames, in the shape of ``time``."""
        return np.asarray(np.interp(time, self.times, np.arange(len(self.times))))

    def sharpened(
        self, found: Lifetimes, springs: Indices, events: Iterable[Event]
    ) -> Lifetimes:
        """Return lives of springs that end at the times of events, between frames.

        Args:
            found: They end at the first frame that lacks the spring.
            springs: Network numbers of their springs, shape (spring,).
            events: The log of events.
        """
        when: dict[int, list[float]] = defaultdict(list)
        for event in events:
            for spring in event.springs:
                when[spring].append(float(self.frame_of(event.time)))
        life = found.life.copy()
        for row in np.flatnonzero(life[:, 1] < FOREVER) if when else ():
            end = life[row, 1]
            fits = [at for at in when[int(springs[found.of[row]])] if end - 1 < at <= end]
            life[row, 1] = fits[-1] if fits else end
        return Lifetimes(found.of, life)


def sharpened_triangles(life: Floats, ends: Floats) -> Floats:
    """Return lives of triangles that end with the first spring that ends between two frames.

    Args:
        life: Of triangles, in units of frames; they end at the first frame that lacks them,
            shape (triangle, 2).
        ends: When springs end, in units of frames, shape (spring,).
    """
    ends = np.sort(ends[ends < FOREVER])
    life = life.copy()
    for row in np.flatnonzero(life[:, 1] < FOREVER) if len(ends) else ():
        end = int(life[row, 1])
        first = int(np.searchsorted(ends, end - 1, side="right"))
        if first < len(ends) and ends[first] <= end:
            life[row, 1] = ends[first]
    return life


class Register:
    """Numbers rows of node numbers in the order in which they are met, each once.

    Raises:
        TissueError: There are too many nodes.
    """

    def __init__(self, nodes: int, width: int):
        if nodes > _MOST_NODES:
            raise TissueError(f"a net of more than {_MOST_NODES} nodes cannot be shown")
        self._base = nodes ** np.arange(width, dtype=np.int64)
        self._keys = np.zeros(0, dtype=np.int64)  # ascending
        self._numbers = np.zeros(0, dtype=np.int64)
        self.rows = np.zeros((0, width), dtype=np.int64)

    def numbers(self, table: NDArray[np.integer]) -> Indices:
        """Return the numbers of the rows of a table, shape (row,); new rows are added.

        Args:
            table: Node numbers, shape (row, column).
        """
        keys = table.astype(np.int64) @ self._base
        fresh, first = np.unique(keys, return_index=True)
        is_new = ~np.isin(fresh, self._keys, assume_unique=True)
        if is_new.any():
            chosen = np.sort(first[is_new])
            count = len(self.rows)
            self.rows = np.concatenate([self.rows, table[chosen]])
            together = np.concatenate([self._keys, keys[chosen]])
            numbered = np.concatenate([self._numbers, count + np.arange(len(chosen))])
            order = np.argsort(together)
            self._keys, self._numbers = together[order], numbered[order]
        return self._numbers[np.searchsorted(self._keys, keys)]
