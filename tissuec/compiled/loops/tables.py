"""Tables of items as loops read them: in blocks of ``LANES``, which the last item fills."""

from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.kernels.records import Floats, Integers

Indices = NDArray[np.int64]

LANES = 8  # fill the vectors of AVX-512; those of AVX2 need two instructions for each


class ItemTable(NamedTuple):
    """Items as loops read them.

    Attributes:
        size: Number of items.
        places: Three times the nodes, then the components of velocities that are internal
            variables, item by item, filled up to whole blocks of lanes.
        numbers: Numbers of the items: block by block, and in each one number of all its lanes
            after the other.
    """

    size: int
    places: Integers
    numbers: Floats

    @classmethod
    def of(
        cls, nodes: NDArray[np.integer], columns: Floats, slots: Indices | None = None
    ) -> Self:
        """Return a table.

        Args:
            nodes: Of the items, shape (item, corner).
            columns: Numbers of the items, in any unit, shape (number, item).
            slots: Components of velocities that are internal variables, shape (item, slot).
        """
        every = filled(len(nodes))
        places = 3 * nodes[every].astype(np.int64)
        if slots is not None:
            places = np.hstack([places, slots[every]])
        return cls(len(nodes), places.ravel(), blocked(columns, every))

    def some(self, part: slice, blocks: int) -> Self:
        """Return the items of some blocks, of so many."""
        size = max(0, min(self.size, LANES * part.stop) - LANES * part.start)
        return type(self)(
            size, _of_blocks(self.places, part, blocks), _of_blocks(self.numbers, part, blocks)
        )


class PoolTable(NamedTuple):
    """Items of groups as passes read them.

    Attributes:
        acts: The terms of the amount.
        carried: Parts of points that nodes carry; the nodes of each are a node and its point.
        points: Number of these points; 0 where corners of items are nodes.
        items: The corners of each, the point from which it is seen, its group, and the places
            of its learnt numbers.
        groups: Itself, and the point from which it is seen.
        begins: Where the items of each begin and, last, where all end, shape (group + 1,).
        corners: The places of ``items``.
        stored: Scratch: rows of numbers of items, flat, shape (block, row, lane).
        bends: Those of ``ContactTable``, shape (3,), or (0,) where they are not counted.
    """

    acts: ItemTable
    carried: ItemTable
    points: int
    items: ItemTable
    groups: ItemTable
    begins: Integers
    corners: Integers
    stored: Floats
    bends: Integers = np.zeros(0, dtype=np.int64)

    def in_parts(self, parts: int) -> "list[list[PoolTable]]":
        """Return tables that store the rows of some items each, and one that adds them up."""
        blocks = filled_count(self.items.size) // LANES
        cuts = np.linspace(0, blocks, parts + 1).astype(int)
        storing: list[PoolTable] = [
            self._replace(
                items=self.items.some(slice(first, end), blocks),
                groups=self.groups._replace(size=0),
                stored=_of_blocks(self.stored, slice(first, end), blocks),
            )
            for first, end in pairwise(cuts.tolist())
        ]  # fmt: skip
        return [storing, [self._replace(items=self.items._replace(size=0))]]


def filled(count: int) -> Indices:
    """Return the numbers of items, and the last one as often as fills a block, shape (n,)."""
    return np.minimum(np.arange(filled_count(count)), count - 1)


def filled_count(count: int) -> int:
    """Return the least multiple of ``LANES`` that is not below a number."""
    return -(-count // LANES) * LANES


def blocked(columns: NDArray[Any], every: Indices) -> NDArray[Any]:
    """Return columns block by block, and in each a column of all its lanes after the other.

    Args:
        columns: In any unit, shape (number, item).
        every: Numbers of the items that fill blocks, shape (block · lane,).
    """
    blocks = columns[:, every].reshape(len(columns), len(every) // LANES, LANES).swapaxes(0, 1)
    return np.ascontiguousarray(blocks).ravel()


def _of_blocks(flat: NDArray[Any], part: slice, blocks: int) -> NDArray[Any]:
    """Return the numbers of some blocks, of so many, which share their memory."""
    return flat.reshape(blocks, -1)[part].ravel() if blocks else flat


def room_for(outputs: int | tuple[int, ...], count: int) -> Floats:
    """Return room for the numbers of a ``record_loop``, in any unit.

    Args:
        outputs: Numbers of an item; or their shape, such as of points and numbers of each.
        count: Number of items.

    Returns:
        Zeros of the shape (block, *outputs, lane).
    """
    each = outputs if isinstance(outputs, tuple) else (outputs,)
    return np.zeros((filled_count(count) // LANES, *each, LANES))


def recorded(room: Floats, count: int) -> Floats:
    """Return the numbers in the room of a ``record_loop``, in any unit.

    The shape is (item, *outputs); see ``room_for``.
    """
    return np.moveaxis(room, -1, 1).reshape(filled_count(count), *room.shape[1:-1])[:count]
