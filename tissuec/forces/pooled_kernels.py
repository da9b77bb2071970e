"""The kernels that follow from what groups of items store; see ``pooled_fields``."""

from collections.abc import Mapping
from functools import cache, partial

import numpy as np

from tissuec.autodiff.pools import TracedPool
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.loops import pools as loops
from tissuec.compiled.loops.tables import ItemTable, PoolTable, room_for
from tissuec.compiled.loops.terms import terms_of
from tissuec.forces.grouped_items import GroupedItems, as_rows
from tissuec.forces.potential_kernels import PotentialKernels
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices


@cache
def kernels_of(
    name: str, item: TracedItem, pool: TracedPool | None, carries: tuple[str, ...] = (),
    learnt: tuple[tuple[str, bool], ...] = (),
) -> PotentialKernels:  # fmt: skip
    """Return the kernels of items in groups, once for each.

    Args:
        name, item: As of ``PotentialKernels``.
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points that corners of items are; nothing without points.
        learnt: Names of the numbers of groups that can be learnt, and whether all share each.
    """
    forces = partial(loops.force_kernel, item=item, pool=pool, carries=carries)
    if pool is None:
        return PotentialKernels(name, item, forces)
    by = {"pool": pool, "learnt": dict(learnt)}
    pull, push = (partial(each, **by) for each in (loops.pull_kernel, loops.push_kernel))
    return PotentialKernels(name, item, forces, pull, push)


def pool_table(
    made: dict[bytes, PoolTable], items: GroupedItems, kernels: PotentialKernels,
    place: Indices, acts: BoundaryConditions, rows: int,
) -> PoolTable:  # fmt: skip
    """Return the table of items.

    Args:
        made: Tables by places of nodes, to which a new one is added.
        kernels: Of the items.
        place, acts: As for ``Field.table``; shape (node,).
        rows: How many numbers of an item are stored.
    """
    key = place.tobytes()
    if key not in made:
        made[key] = _made(items, kernels, place)
    terms = terms_of(acts)
    none = np.zeros((terms.shape[1], 0), dtype=np.int64)
    stored = room_for(rows, len(items.corners)).ravel()
    return made[key]._replace(acts=ItemTable.of(none, terms), stored=stored)


def _made(items: GroupedItems, kernels: PotentialKernels, place: Indices) -> PoolTable:
    """Return the table of items, without the terms of the amount."""
    groups = np.arange(len(items.seen))
    none = ItemTable.of(groups[:0, None], np.zeros((12, 0)))
    where, carried, points = place, none, 0
    if items.carries:
        where, carried, points = _carried(items, place)
    seen = where[items.seen]
    nodes = np.column_stack([where[items.corners], seen[items.owner], items.owner])
    own = kernels.table(nodes, _columns(items.numbers, len(nodes)))
    of_groups = _columns(items.of_groups, len(groups))
    every = ItemTable.of(np.column_stack([groups, seen]), of_groups)
    return PoolTable(
        none, carried, points, own, every, items.first, own.places, np.zeros(0)
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
