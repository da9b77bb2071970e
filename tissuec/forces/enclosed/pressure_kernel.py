"""Prescribed pressure as scalar loops; for the equations see ``enclosed.pressure``."""

from typing import NamedTuple

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import (
    BoundaryConditions,
    Floats,
    IntegerRows,
    Integers,
    Rows,
    Stack,
)


class PressureTable(NamedTuple):
    """Weighted triangles and caps; see ``enclosed.pressed_faces``."""

    acts: BoundaryConditions  # of its only one, the first component is the pressure [Pa]
    corners: IntegerRows  # shape (triangle, 3)
    weight: Floats  # shape (triangle,)
    rim_edges: IntegerRows  # of caps, shape (edge, 2)
    rim_weight: Floats  # shape (edge,)
    rim_first: Integers  # edges of a cap, shape (cap + 1,)
    rim_nodes: Integers  # shape (node,)
    rim_shares: Floats  # of these in the middle of a cap, shape (node,)
    rim_node_first: Integers  # nodes of a cap, shape (cap + 1,)
    within: Stack  # projection of the middles of caps, shape (cap, 3, 3)
    fixed: Rows  # added to these [m], shape (cap, 3)


def press_faces(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: PressureTable
) -> None:
    """Add the forces of a pressure to those on nodes, and the power that it supplies.

    Args:
        table: The faces.
    """
    pressure, _, _, _, _, _ = total(0, time, table.acts)
    third = pressure / 6.0
    k: int
    for n in range(table.weight.size):
        i, j, k = 3 * table.corners[n, 0], 3 * table.corners[n, 1], 3 * table.corners[n, 2]
        share = third * table.weight[n]
        p0, p1, p2 = third_of_triangle(share, i, j, x[k], x[k + 1], x[k + 2], x)
        for node in (i, j, k):
            add_push(node, p0, p1, p2, f)
            power[0] += p0 * v[node] + p1 * v[node + 1] + p2 * v[node + 2]
    for cap in range(table.rim_first.size - 1):
        start, stop = table.rim_node_first[cap], table.rim_node_first[cap + 1]
        m0, m1, m2, w0, w1, w2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(start, stop):
            i, part = 3 * table.rim_nodes[n], table.rim_shares[n]
            m0, m1, m2 = m0 + part * x[i], m1 + part * x[i + 1], m2 + part * x[i + 2]
            w0, w1, w2 = w0 + part * v[i], w1 + part * v[i + 1], w2 + part * v[i + 2]
        fixed = table.fixed[cap]
        m0, m1, m2 = turned(table.within[cap], m0, m1, m2)
        m0, m1, m2 = m0 + fixed[0], m1 + fixed[1], m2 + fixed[2]
        s0, s1, s2 = 0.0, 0.0, 0.0
        for n in range(table.rim_first[cap], table.rim_first[cap + 1]):
            # The fan closes the surface: it runs along its rim in the other direction.
            i, j = 3 * table.rim_edges[n, 1], 3 * table.rim_edges[n, 0]
            share = third * table.rim_weight[n]
            p0, p1, p2 = third_of_triangle(share, i, j, m0, m1, m2, x)
            for node in (i, j):
                add_push(node, p0, p1, p2, f)
                power[0] += p0 * v[node] + p1 * v[node + 1] + p2 * v[node + 2]
            s0, s1, s2 = s0 + p0, s1 + p1, s2 + p2
        # A projection is its own transpose.
        s0, s1, s2 = turned(table.within[cap], s0, s1, s2)
        power[0] += s0 * w0 + s1 * w1 + s2 * w2
        for n in range(start, stop):
            part = table.rim_shares[n]
            add_push(3 * table.rim_nodes[n], part * s0, part * s1, part * s2, f)


def turned(by: Rows, v0: float, v1: float, v2: float) -> tuple[float, float, float]:
    """Return the product of a matrix and a vector.

    Args:
        by: The matrix, without a unit, shape (3, 3).
        v0, v1, v2: Components of the vector.
    """
    return (
        by[0, 0] * v0 + by[0, 1] * v1 + by[0, 2] * v2,
        by[1, 0] * v0 + by[1, 1] * v1 + by[1, 2] * v2,
        by[2, 0] * v0 + by[2, 1] * v1 + by[2, 2] * v2,
    )


def third_of_triangle(
    share: float, i: int, j: int, z0: float, z1: float, z2: float, x: Floats
) -> tuple[float, float, float]:
    """Return share (x_i - z) × (x_j - z).

    Args:
        share: A sixth of the pressure [Pa].
        i, j: Indices of the first components of two corners in ``x``.
        z0, z1, z2: The third corner [m].
        x: Positions of all nodes [m], flat, shape (3 node,).
    """
    a0, a1, a2 = x[i] - z0, x[i + 1] - z1, x[i + 2] - z2
    b0, b1, b2 = x[j] - z0, x[j + 1] - z1, x[j + 2] - z2
    return (
        share * (a1 * b2 - a2 * b1),
        share * (a2 * b0 - a0 * b2),
        share * (a0 * b1 - a1 * b0),
    )


def add_push(place: int, p0: float, p1: float, p2: float, f: Floats) -> None:
    """Add a force to that on the node whose components begin at ``place``.

    Args:
        place: Index of the first component.
        p0, p1, p2: Components of the force [N].
        f: Forces on all nodes [N], flat, shape (3 node,).
    """
    f[place] += p0
    f[place + 1] += p1
    f[place + 2] += p2
