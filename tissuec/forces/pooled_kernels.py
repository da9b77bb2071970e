"""The kernels that follow from the energy of groups of items; see ``pooled_fields``."""

from collections.abc import Mapping
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.pools import TracedPool
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops import pools as loops
from tissuec.compiled.loops.items import ItemTable
from tissuec.forces.grouped_items import GroupedItems, as_rows
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices


class PooledKernels(NamedTuple):
    """Kernels, each made when it is needed.

    Attributes:
        forces: Adds forces and powers.
        pull, push: ``pull_back`` and ``push_forward`` of ``forces.matrices``.
    """

    forces: GeneratedKernel
    pull: GeneratedKernel
    push: GeneratedKernel


@cache
def kernels_of(
    name: str, item: TracedItem, pool: TracedPool | None, carries: tuple[str, ...],
    learnt: tuple[tuple[str, bool], ...] = (),
) -> PooledKernels:  # fmt: skip
    """Return the kernels of items, once for each.

    Args:
        name: By which they are known in the cache.
        item: Potential of one, as it was traced.
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points that corners of items are; nothing without points.
        learnt: Names of the numbers that can be learnt, and whether all groups share each.
    """
    own, by = (
        {"item": item, "pool": pool, "carries": carries},
        {"pool": pool, "learnt": dict(learnt)},
    )
    parts = (loops.force_kernel, own), (loops.pull_kernel, by), (loops.push_kernel, by)
    made = (
        GeneratedKernel(f"{name}_{part.__name__}", partial(part, **given))
        for part, given in parts
    )
    return PooledKernels(*made)


def pool_table(
    made: dict[bytes, loops.PoolTable], items: GroupedItems, item: TracedItem, place: Indices,
    acts: BoundaryConditions,
) -> loops.PoolTable:  # fmt: skip
    """Return the table of items.

    Args:
        made: Tables by places of nodes, to which a new one is added.
        item: Potential of one, as it was traced.
        place, acts: As for ``Field.table``; shape (node,).
    """
    key = place.tobytes()
    if key not in made:
        made[key] = _made(items, item, place)
    return made[key].at(acts)


def _made(items: GroupedItems, item: TracedItem, place: Indices) -> loops.PoolTable:
    """Return the table of items, without the terms of the amount."""
    groups = np.arange(len(items.seen))
    none = ItemTable.of(groups[:0, None], np.zeros((12, 0)))
    where, carried, points = place, none, 0
    if items.carries:
        where, carried, points = _carried(items, place)
    seen = where[items.seen]
    nodes = np.column_stack([where[items.corners], seen[items.owner], items.owner])
    columns = _columns(items.numbers, len(nodes))
    if constants := item.constants:
        names = (str(each.operation.detail) for each in item.numbers)
        values = dict(zip(names, columns, strict=True))
        columns = np.concatenate([columns, np.stack(evaluate(constants, values))])
    return loops.PoolTable(
        none, carried, points, ItemTable.of(nodes, columns),
        ItemTable.of(np.column_stack([groups, seen]), _columns(items.of_groups, len(groups))),
    )  # fmt: skip


def _columns(numbers: Mapping[str, Floats | float], count: int) -> Floats:
    """Return numbers side by side, shape (number, count)."""
    own = (np.broadcast_to(each, (len(each), count)) for each in as_rows(numbers).values())
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
