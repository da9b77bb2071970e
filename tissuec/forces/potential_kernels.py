"""The kernels that follow from the potential of an item; see ``potential_fields``."""

from functools import cache, partial

import numpy as np

from tissuec.autodiff.graph import Number
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import items as loops
from tissuec.compiled.loops.frame import LoopText
from tissuec.compiled.loops.tables import ItemTable, recorded, room_for
from tissuec.forces.matrices import ForceDerivatives
from tissuec.model.network import Floats, Indices


class PotentialKernels:
    """The kernels of items, each made when it is needed.

    Args:
        name: By which they are known in the cache.
        item: As its potential was traced.
        written: Writers of the loops that add forces and powers, and perhaps of ``pull_back``
            and ``push_forward`` of ``forces.matrices``.
    """

    def __init__(self, name: str, item: TracedItem, *written: "partial[LoopText]"):
        self._name, self.item = name, item
        whats = ("forces", "pull", "push")
        self._made = {
            what: self._named(what, one) for what, one in zip(whats, written, strict=False)
        }
        self._records: dict[str, tuple[GeneratedKernel, int]] = {}

    def _named(self, what: str, loop: "partial[LoopText]") -> GeneratedKernel:
        return GeneratedKernel(f"{self._name}_{what}", loop)

    @property
    def forces(self) -> GeneratedKernel:
        """Return the kernel that adds forces and powers."""
        return self._made["forces"]

    def derivatives(self, learnt: tuple[str, ...]) -> ForceDerivatives:
        """Return the derivatives of forces, also by the numbers that they were written for."""
        return ForceDerivatives(learnt, self._made["pull"], self._made["push"])

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
    name: str, item: TracedItem, learnt: tuple[tuple[str, bool], ...] = ()
) -> PotentialKernels:
    """Return the kernels of items whose potential was traced, once for each.

    Args:
        name, item: As of ``PotentialKernels``.
        learnt: Names of the numbers that can be learnt, and whether all items share each.
    """
    by = {"item": item, "learnt": dict(learnt)}
    return PotentialKernels(
        name, item, partial(loops.force_loop, item=item), partial(loops.pull_loop, **by),
        partial(loops.push_loop, **by),
    )  # fmt: skip
