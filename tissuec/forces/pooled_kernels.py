"""The kernels that follow from the energy of groups of items; see ``pooled_fields``."""

from collections.abc import Mapping, Sequence
from functools import cached_property, partial

import numpy as np

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.pools import TracedPool
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import pools as loops
from tissuec.compiled.loops.items import ItemTable
from tissuec.forces.carried_points import GroupedItems
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices


class PooledKernels:
    """The kernels of groups of items, each made when it is needed.

    Args:
        name: By which they are known in the cache.
        item: As traced.
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points that corners of items are; nothing without points.
        learnt: By the name of each number that can be learnt, whether all groups share it.
    """

    def __init__(
        self, name: str, item: TracedItem, pool: TracedPool | None, carries: Sequence[str],
        learnt: Mapping[str, bool],
    ):  # fmt: skip
        self._name, self._item, self._pool = name, item, pool
        self._carries, self._learnt = carries, learnt

    @cached_property
    def forces(self) -> GeneratedKernel:
        """Return the kernel that adds forces and powers."""
        own = {"item": self._item, "pool": self._pool, "carries": self._carries}
        loop = partial(loops.force_kernel, **own)
        return GeneratedKernel(f"{self._name}_forces", loop)

    @cached_property
    def pull(self) -> GeneratedKernel:
        """Return ``pull_back`` of ``forces.matrices``."""
        assert self._pool
        loop = partial(loops.pull_kernel, pool=self._pool, learnt=self._learnt)
        return GeneratedKernel(f"{self._name}_pull", loop)

    @cached_property
    def push(self) -> GeneratedKernel:
        """Return ``push_forward`` of ``forces.matrices``."""
        assert self._pool
        loop = partial(loops.push_kernel, pool=self._pool, learnt=self._learnt)
        return GeneratedKernel(f"{self._name}_push", loop)

    def table(
        self, items: GroupedItems, of_items: Mapping[str, Floats],
        of_groups: Mapping[str, Floats], place: Indices, acts: BoundaryConditions,
    ) -> loops.PoolTable:  # fmt: skip
        """Return the table of items.

        Args:
            of_items, of_groups: Numbers in SI units, shape (component, n) or (component, 1).
            place: As for ``Field.table``.
            acts: As for ``Field.table``.
        """
        groups = np.arange(len(items.seen))
        where, carried, points = place, ItemTable.of(groups[:0, None], np.zeros((12, 0))), 0
        if self._carries:
            where, carried, points = _carried(items, place)
        seen = where[items.seen]
        nodes = np.column_stack([where[items.corners], seen[items.owner], items.owner])
        columns = _columns(of_items, len(nodes))
        if constants := self._item.constants:
            names = (str(each.operation.detail) for each in self._item.numbers)
            values = dict(zip(names, columns, strict=True))
            columns = np.concatenate([columns, np.stack(evaluate(constants, values))])
        return loops.PoolTable.of(
            acts, carried, points, ItemTable.of(nodes, columns),
            ItemTable.of(np.column_stack([groups, seen]), _columns(of_groups, len(groups))),
        )  # fmt: skip


def _columns(numbers: Mapping[str, Floats], count: int) -> Floats:
    """Return numbers side by side, shape (number, count)."""
    own = (np.broadcast_to(each, (len(each), count)) for each in numbers.values())
    return np.concatenate([np.zeros((0, count)), *own])


def _carried(items: GroupedItems, place: Indices) -> tuple[Indices, ItemTable, int]:
    """Return the points that items have instead of nodes and points, and what carries them.

    Returns:
        The place of each node among them, and, from the end, that of each point; the table of
        ``loops.carrying_loop``; and their number.
    """
    points = items.points
    used = np.unique(np.concatenate([items.corners.ravel(), items.seen]))
    used = used[used >= 0]
    count = len(used) + points.count
    where = np.full(len(place) + points.count, -1)
    where[used] = np.arange(len(used))
    where[len(place) :] = len(used) + np.arange(points.count)[::-1]
    nodes = place[np.concatenate([used, points.nodes])]
    to = np.concatenate([np.arange(len(used)), len(used) + points.point])
    own = np.broadcast_to(np.eye(3), (len(used), 3, 3))
    parts = np.concatenate([own, points.parts]).reshape(-1, 9)
    fixed = np.zeros((len(parts), 3))
    first = np.searchsorted(points.point, np.arange(points.count))
    fixed[len(used) + first] = points.fixed
    columns = np.concatenate([parts, fixed], axis=1).T
    return where, ItemTable.of(np.column_stack([nodes, to]), columns), count
