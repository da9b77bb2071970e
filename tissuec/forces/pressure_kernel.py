"""Prescribed pressure as scalar loops; for the equations see ``tissuec.forces.pressure``."""

from typing import NamedTuple

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, IntegerRows, Integers


class PressureTable(NamedTuple):
    """Weighted triangles and caps; see ``forces.pressed_faces``."""

    acts: BoundaryConditions  # of its only one, the first component is the pressure [Pa]
    corners: IntegerRows  # shape (triangle, 3)
    weight: Floats  # shape (triangle,)
    rim_edges: IntegerRows  # of caps, shape (edge, 2)
    rim_weight: Floats  # shape (edge,)
    rim_first: Integers  # edges of a cap, shape (cap + 1,)
    rim_nodes: Integers  # shape (node,)
    rim_node_first: Integers  # nodes of a cap, shape (cap + 1,)


def press_faces(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: PressureTable
) -> None:
    """Add the forces of a pressure to those on nodes, and the power that it supplies.

    Args:
        table: The faces.
    """
    pressure, _, _, _, _, _ = total(0, time, table.acts)
    third = pressure / 6.0
    for n in range(table.weight.size):
        i, j, k = 3 * table.corners[n, 0], 3 * table.corners[n, 1], 3 * table.corners[n, 2]
        a0, a1, a2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        b0, b1, b2 = x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2]
        share = third * table.weight[n]
        p0, p1, p2 = (
            share * (a1 * b2 - a2 * b1),
            share * (a2 * b0 - a0 * b2),
            share * (a0 * b1 - a1 * b0),
        )
        f[i] += p0
        f[i + 1] += p1
        f[i + 2] += p2
        f[j] += p0
        f[j + 1] += p1
        f[j + 2] += p2
        f[k] += p0
        f[k + 1] += p1
        f[k + 2] += p2
        power[0] += p0 * (v[i] + v[j] + v[k])
        power[0] += p1 * (v[i + 1] + v[j + 1] + v[k + 1])
        power[0] += p2 * (v[i + 2] + v[j + 2] + v[k + 2])
    for cap in range(table.rim_first.size - 1):
        start, stop = table.rim_node_first[cap], table.rim_node_first[cap + 1]
        part = 1.0 / (stop - start)
        m0, m1, m2, w0, w1, w2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for n in range(start, stop):
            i = 3 * table.rim_nodes[n]
            m0, m1, m2 = m0 + part * x[i], m1 + part * x[i + 1], m2 + part * x[i + 2]
            w0, w1, w2 = w0 + part * v[i], w1 + part * v[i + 1], w2 + part * v[i + 2]
        s0, s1, s2 = 0.0, 0.0, 0.0
        for n in range(table.rim_first[cap], table.rim_first[cap + 1]):
            # The fan closes the surface: it runs along its rim in the other direction.
            i, j = 3 * table.rim_edges[n, 1], 3 * table.rim_edges[n, 0]
            a0, a1, a2 = x[i] - m0, x[i + 1] - m1, x[i + 2] - m2
            b0, b1, b2 = x[j] - m0, x[j + 1] - m1, x[j + 2] - m2
            share = third * table.rim_weight[n]
            p0, p1, p2 = (
                share * (a1 * b2 - a2 * b1),
                share * (a2 * b0 - a0 * b2),
                share * (a0 * b1 - a1 * b0),
            )
            f[i] += p0
            f[i + 1] += p1
            f[i + 2] += p2
            f[j] += p0
            f[j + 1] += p1
            f[j + 2] += p2
            s0, s1, s2 = s0 + p0, s1 + p1, s2 + p2
            power[0] += p0 * (v[i] + v[j] + w0)
            power[0] += p1 * (v[i + 1] + v[j + 1] + w1)
            power[0] += p2 * (v[i + 2] + v[j + 2] + w2)
        for n in range(start, stop):
            i = 3 * table.rim_nodes[n]
            f[i] += part * s0
            f[i + 1] += part * s1
            f[i + 2] += part * s2
