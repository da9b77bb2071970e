"""The kernels that follow from the potential of an item; see ``potential_fields``."""

from collections.abc import Mapping
from functools import cache, cached_property, partial

import numpy as np

from tissuec.autodiff.graph import Number
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import items as loops
from tissuec.compiled.loops.frame import LoopText
from tissuec.compiled.loops.tables import ItemTable, recorded, room_for
from tissuec.model.network import Floats, Indices


class PotentialKernels:
    """The kernels of items whose potential was traced, each made when it is needed.

    Args:
        name: By which they are known in the cache.
        item: As traced.
        learnt: By the name of each number that can be learnt, whether all items share it.
    """

    def __init__(self, name: str, item: TracedItem, learnt: Mapping[str, bool]):
        self._name, self.item, self._learnt = name, item, learnt
        self._records: dict[str, tuple[GeneratedKernel, int]] = {}

    def _named(self, what: str, loop: "partial[LoopText]") -> GeneratedKernel:
        return GeneratedKernel(f"{self._name}_{what}", loop)

    @cached_property
    def forces(self) -> GeneratedKernel:
        """Return the kernel that adds forces and powers."""
        return self._named("forces", partial(loops.force_loop, item=self.item))

    @cached_property
    def pull(self) -> GeneratedKernel:
        """Return ``pull_back`` of ``forces.matrices``."""
        loop = partial(loops.pull_loop, item=self.item, learnt=self._learnt)
        return self._named("pull", loop)

    @cached_property
    def push(self) -> GeneratedKernel:
        """Return ``push_forward`` of ``forces.matrices``."""
        loop = partial(loops.push_loop, item=self.item, learnt=self._learnt)
        return self._named("push", loop)

    def recorded(self, what: str, x: Floats, v: Floats, table: ItemTable) -> Floats:
        """Return an attribute of the traced item for each item, shape (item, number).

        Args:
            what: Its name, such as "matrix"; its numbers have any unit.
            x, v: Positions [m] and velocities [m/s] of all nodes, shape (3 node,).
        """
        if what not in self._records:
            self._records[what] = self._recording(what)
        kernel, count = self._records[what]
        room = room_for(count, table.size)
        kernel(0.0, x, v, room.reshape(-1), table)
        return recorded(room, table.size)

    def _recording(self, what: str) -> tuple[GeneratedKernel, int]:
        """Return the kernel that records an attribute, and how many numbers it has."""
        found: Number | list[Number] | dict[tuple[int, int], Number]
        found = getattr(self.item, what)
        if isinstance(found, Number):
            found = [found]
        outputs = list(found.values()) if isinstance(found, dict) else found
        # Constants are not read by what records them.
        known = [] if what == "constants" else self.item.constants
        loop = partial(loops.record_loop, item=self.item, outputs=outputs, constants=known)
        return self._named(what, loop), len(outputs)

    def table(self, nodes: Indices, columns: Floats, slots: Indices | None = None) -> ItemTable:
        """Return the table of items, with the constants that follow from their numbers.

        Args:
            nodes: Shape (item, corner).
            columns: Numbers of the items, in SI units, shape (number, item).
            slots: Components of velocities that are internal variables, shape (item, slot).
        """
        found = ItemTable.of(nodes, columns, slots)
        if not self.item.constants or not len(nodes):
            return found
        none = np.zeros(0)
        more = self.recorded("constants", none, none, found).T
        return ItemTable.of(nodes, np.concatenate([columns, more]), slots)


@cache
def kernels_of(
    name: str, item: TracedItem, learnt: tuple[tuple[str, bool], ...]
) -> PotentialKernels:
    """Return ``PotentialKernels``, once for each; the arguments are theirs."""
    return PotentialKernels(name, item, dict(learnt))
