"""Accelerations with their derivatives; see ``accelerations`` for their sum.

Forces on node n add up to F and accelerate it by g + (F - drag v) / m, where it is not held.
``push_forward`` carries many changes of the state at once to the accelerations, ``pull_back``
is its transpose.

Shared arguments:
    forces: Everything that accelerations follow from, beside the state.
    time: [s], on which fields may depend.
    at: A state with the shapes and units of ``NodeState``.
    due: Derivatives by the state, added to.
    by: Derivatives by the numbers of springs and nodes, added to.
    seeds: Changes of the numbers.
    change: Changes of the state, shape (3 node change,).
"""

from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    Seeds,
    Sparse,
    Values,
    call_force,
    call_pull_back,
    call_push_forward,
)
from tissuec.kernels.records import Floats


def acceleration(forces: Forces, time: float, load: Floats, at: NodeState) -> None:
    """Set the accelerations of all nodes, ``at.a`` [m/s²].

    Args:
        load: Loads that change in time [N], shape (3 loaded,).
    """
    links, v, a = forces.links, at.v, at.a
    for i in range(a.size):
        a[i] = 0.0
    fields = forces.fields
    for k in range(fields.table.size):
        call_force(fields.force[k], fields.table[k], time, at.x, v, a, fields.power)
    for k in range(links.loaded.size):
        i = 3 * links.loaded[k]
        for axis in range(3):
            a[i + axis] += load[3 * k + axis]
    for node in range(links.inverse.size):
        inverse, drag = links.inverse[node], links.drag[node]
        for i in range(3 * node, 3 * node + 3):
            a[i] = links.steady[i] + inverse * (a[i] - drag * v[i])


def pull_back(forces: Forces, time: float, at: NodeState, due: NodeState, by: Values) -> None:
    """Add the derivatives of Σ due.a · a to ``due.x``, ``due.v`` and ``by``.

    Args:
        at: With the accelerations that ``acceleration`` gave.
    """
    pull_back_nodes(forces, at, due, by)
    pull_back_fields(forces, time, at, due, by)


def pull_back_nodes(forces: Forces, at: NodeState, due: NodeState, by: Values) -> None:
    """Add to ``due.v`` and ``by`` what comes from masses and drag."""
    links, weight = forces.links, due.a
    for node in range(links.inverse.size):
        inverse, total, braked = links.inverse[node], 0.0, 0.0
        if inverse == 0.0:
            continue
        for i in range(3 * node, 3 * node + 3):
            total += weight[i] * (at.a[i] - links.steady[i])
            braked += weight[i] * at.v[i]
            due.v[i] -= links.drag[node] * inverse * weight[i]
        by.mass[node] -= inverse * total
        by.drag[node] -= inverse * braked


def pull_back_fields(
    forces: Forces, time: float, at: NodeState, due: NodeState, by: Values
) -> None:
    """Add to ``due.x``, ``due.v`` and ``by`` what comes from springs and fields."""
    fields, inverse = forces.fields, forces.links.inverse
    for node in range(inverse.size):
        for i in range(3 * node, 3 * node + 3):
            fields.weight[i] = inverse[node] * due.a[i]
    for k in range(fields.table.size):
        table, own = fields.table[k], by.numbers[fields.first[k] : fields.first[k + 1]]
        call_pull_back(
            fields.pull_back[k], table, time, at.x, at.v, fields.weight, due.x, due.v, own
        )


def push_forward(
    forces: Forces, time: float, at: NodeState, seeds: Seeds, change: NodeState
) -> None:
    """Set ``change.a`` for many changes of positions, velocities and numbers.

    Args:
        at: With the accelerations that ``acceleration`` gave.
    """
    for i in range(change.a.size):
        change.a[i] = 0.0
    push_forward_fields(forces, time, at, seeds, change)
    push_forward_nodes(forces, at, seeds, change)


def push_forward_nodes(forces: Forces, at: NodeState, seeds: Seeds, change: NodeState) -> None:
    """Turn changes of forces into those of accelerations, ``change.a``."""
    links, count = forces.links, seeds.room.size
    for node in range(links.inverse.size):
        inverse, drag = links.inverse[node], links.drag[node]
        for i in range(3 * node, 3 * node + 3):
            part = slice(count * i, count * (i + 1))
            a, v = change.a[part], change.v[part]
            for m in range(count):
                a[m] = inverse * (a[m] - drag * v[m])
            if inverse > 0.0:
                sow(inverse * (links.steady[i] - at.a[i]), node, seeds.mass, a)
                sow(-inverse * at.v[i], node, seeds.drag, a)


def push_forward_fields(
    forces: Forces, time: float, at: NodeState, seeds: Seeds, change: NodeState
) -> None:
    """Add the changes of the forces of springs and fields to ``change.a``."""
    count, fields = seeds.room.size, forces.fields
    for k in range(fields.table.size):
        numbers = seeds.numbers[count * fields.first[k] : count * fields.first[k + 1]]
        call_push_forward(
            fields.push_forward[k], fields.table[k], time, at.x, at.v, change.x, change.v,
            numbers, change.a, seeds.room,
        )  # fmt: skip


def sow(factor: float, row: int, matrix: Sparse, out: Floats) -> None:
    """Add a multiple of a row of a matrix to a vector.

    Args:
        row: Index of the row.
        out: Vector of the row's unit times that of ``factor``, shape (column,).
    """
    for z in range(matrix.rows[row], matrix.rows[row + 1]):
        out[matrix.columns[z]] += factor * matrix.entries[z]
