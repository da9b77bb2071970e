"""Fluids in cavities as scalar loops; for the equations see ``enclosed.fluids``."""

from typing import NamedTuple

from tissuec.forces.enclosed.pressure_kernel import add_push, turned
from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import (
    BoundaryConditions,
    Floats,
    IntegerRows,
    Integers,
    Rows,
    Stack,
)


class FluidTable(NamedTuple):
    """Cavities as the kernel reads them; see ``enclosed.fluids.FluidCavities``."""

    acts: BoundaryConditions  # of its only one, the first component is the relative change
    corners: IntegerRows  # of weighted triangles, shape (triangle, 3)
    weight: Floats  # shape (triangle,)
    first: Integers  # triangles of a cavity, shape (cavity + 1,)
    cap_first: Integers  # caps of a cavity, shape (cavity + 1,)
    rim_edges: IntegerRows  # of caps, shape (edge, 2)
    rim_weight: Floats  # shape (edge,)
    rim_first: Integers  # edges of a cap, shape (cap + 1,)
    rim_nodes: Integers  # shape (node,)
    rim_shares: Floats  # of these in the middle of a cap, shape (node,)
    rim_node_first: Integers  # nodes of a cap, shape (cap + 1,)
    within: Stack  # projection of the middles of caps, shape (cap, 3, 3)
    fixed: Rows  # added to these [m], shape (cap, 3)
    crossing: Rows  # projection of points onto all planes of symmetry, shape (3, 3)
    crossing_at: Floats  # added to these [m], shape (3,)
    drawn: Floats  # volumes [m³], shape (cavity,)
    modulus: float  # [Pa]
    density: float  # [kg/m³]
    gravity: Floats  # [m/s²], shape (3,)


def hold_fluids(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: FluidTable
) -> None:
    """Add the forces of fluids to those on nodes, and the power of pumps.

    Args:
        table: The cavities.
    """
    swell, _, _, rate, _, _ = total(0, time, table.acts)
    g0, g1, g2 = table.gravity[0], table.gravity[1], table.gravity[2]
    for cavity in range(table.drawn.size):
        o = origin_of(cavity, x, table)
        volume, lean = content(cavity, o, x, table)
        drawn = table.drawn[cavity]
        due = drawn * (1.0 + swell)
        pressure = table.modulus * (due - volume) / drawn
        middle = lean / volume if volume != 0.0 else 0.0
        height = middle + g0 * o[0] + g1 * o[1] + g2 * o[2]
        power[0] += drawn * rate * (pressure - table.density * height)
        thin = table.density * due / volume if volume != 0.0 else 0.0
        # Of a sixth of the triple product, and of a sixth of it times the sum of corners.
        base, tilt = (pressure - thin * middle) / 6.0, thin / 24.0
        for n in range(table.first[cavity], table.first[cavity + 1]):
            i, j, k = 3 * table.corners[n, 0], 3 * table.corners[n, 1], 3 * table.corners[n, 2]
            w = table.weight[n]
            at_i, at_j, at_k = seen(i, o, x), seen(j, o, x), seen(k, o, x)
            lean_on(i, w, base, tilt, at_i, at_j, at_k, table.gravity, f)
            lean_on(j, w, base, tilt, at_j, at_k, at_i, table.gravity, f)
            lean_on(k, w, base, tilt, at_k, at_i, at_j, table.gravity, f)
        for cap in range(table.cap_first[cavity], table.cap_first[cavity + 1]):
            m = middle_of_cap(cap, o, x, table)
            start, stop = table.rim_node_first[cap], table.rim_node_first[cap + 1]
            for n in range(table.rim_first[cap], table.rim_first[cap + 1]):
                i, j = 3 * table.rim_edges[n, 1], 3 * table.rim_edges[n, 0]
                w, at_i, at_j = table.rim_weight[n], seen(i, o, x), seen(j, o, x)
                lean_on(i, w, base, tilt, at_i, at_j, m, table.gravity, f)
                lean_on(j, w, base, tilt, at_j, m, at_i, table.gravity, f)
                l0, l1, l2 = leaning(w, base, tilt, m, at_i, at_j, table.gravity)
                l0, l1, l2 = turned(table.within[cap], l0, l1, l2)
                for node in range(start, stop):
                    place, part = 3 * table.rim_nodes[node], table.rim_shares[node]
                    add_push(place, part * l0, part * l1, part * l2, f)


def origin_of(cavity: int, x: Floats, table: FluidTable) -> tuple[float, float, float]:
    """Return the point from which a cavity is seen [m]: a node, on all planes of symmetry.

    Args:
        cavity: Number of the cavity.
        x: Positions of all nodes [m], flat, shape (3 node,).
        table: The cavities.
    """
    i: int = 3 * table.corners[table.first[cavity], 0]
    o0, o1, o2 = turned(table.crossing, x[i], x[i + 1], x[i + 2])
    at = table.crossing_at
    return o0 + at[0], o1 + at[1], o2 + at[2]


def content(
    cavity: int, o: tuple[float, float, float], x: Floats, table: FluidTable
) -> tuple[float, float]:
    """Return the volume V of a cavity [m³] and g·∫ x dV relative to a point [m⁵/s²].

    Args:
        cavity: Number of the cavity.
        o: The point [m].
        x: Positions of all nodes [m], flat, shape (3 node,).
        table: The cavities.
    """
    volume, lean = 0.0, 0.0
    for n in range(table.first[cavity], table.first[cavity + 1]):
        i, j, k = 3 * table.corners[n, 0], 3 * table.corners[n, 1], 3 * table.corners[n, 2]
        six, tilt = cone(seen(i, o, x), seen(j, o, x), seen(k, o, x), table.gravity)
        volume += table.weight[n] * six
        lean += table.weight[n] * tilt
    for cap in range(table.cap_first[cavity], table.cap_first[cavity + 1]):
        m = middle_of_cap(cap, o, x, table)
        for n in range(table.rim_first[cap], table.rim_first[cap + 1]):
            i, j = 3 * table.rim_edges[n, 1], 3 * table.rim_edges[n, 0]
            six, tilt = cone(m, seen(i, o, x), seen(j, o, x), table.gravity)
            volume += table.rim_weight[n] * six
            lean += table.rim_weight[n] * tilt
    return volume / 6.0, lean / 24.0


def seen(i: int, o: tuple[float, float, float], x: Floats) -> tuple[float, float, float]:
    """Return the position of a node relative to a point [m].

    Args:
        i: Index of its first component in ``x``.
        o: The point [m].
        x: Positions of all nodes [m], flat, shape (3 node,).
    """
    return x[i] - o[0], x[i + 1] - o[1], x[i + 2] - o[2]


def middle_of_cap(
    cap: int, o: tuple[float, float, float], x: Floats, table: FluidTable
) -> tuple[float, float, float]:
    """Return the middle of a cap, relative to a point on the planes that it reaches [m].

    Args:
        cap: Number of the cap.
        o: The point [m].
        x: Positions of all nodes [m], flat, shape (3 node,).
        table: The cavities.
    """
    start, stop = table.rim_node_first[cap], table.rim_node_first[cap + 1]
    m0, m1, m2 = 0.0, 0.0, 0.0
    for n in range(start, stop):
        part = table.rim_shares[n]
        a0, a1, a2 = seen(3 * table.rim_nodes[n], o, x)
        m0, m1, m2 = m0 + part * a0, m1 + part * a1, m2 + part * a2
    return turned(table.within[cap], m0, m1, m2)


def cone(
    a: tuple[float, float, float],
    b: tuple[float, float, float],
    c: tuple[float, float, float],
    gravity: Floats,
) -> tuple[float, float]:
    """Return a · (b × c) [m³], and its product with g · (a + b + c) [m⁵/s²].

    Args:
        a, b, c: Corners of a triangle [m].
        gravity: g [m/s²], shape (3,).
    """
    six = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    fall = (
        gravity[0] * (a[0] + b[0] + c[0])
        + gravity[1] * (a[1] + b[1] + c[1])
        + gravity[2] * (a[2] + b[2] + c[2])
    )
    return six, six * fall


def lean_on(
    place: int,
    w: float,
    base: float,
    tilt: float,
    a: tuple[float, float, float],
    b: tuple[float, float, float],
    c: tuple[float, float, float],
    gravity: Floats,
    f: Floats,
) -> None:
    """Add ``leaning`` to a node, whose first component is at ``place``.

    Args:
        place: Index of its first component.
        w, base, tilt, a, b, c, gravity: As there.
        f: Forces on all nodes [N], flat, shape (3 node,).
    """
    l0, l1, l2 = leaning(w, base, tilt, a, b, c, gravity)
    add_push(place, l0, l1, l2, f)


def leaning(
    w: float,
    base: float,
    tilt: float,
    a: tuple[float, float, float],
    b: tuple[float, float, float],
    c: tuple[float, float, float],
    gravity: Floats,
) -> tuple[float, float, float]:
    """Return w times base (b × c) + tilt ∂/∂a (a · (b × c) g · (a + b + c)) [N].

    Args:
        w: Weight of the triangle.
        base: [Pa].
        tilt: [kg/m³].
        a, b, c: The corner of the node and the others in turn [m].
        gravity: g [m/s²], shape (3,).
    """
    n0, n1, n2 = b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]
    fall = gravity[0] * (a[0] + b[0] + c[0])
    fall += gravity[1] * (a[1] + b[1] + c[1]) + gravity[2] * (a[2] + b[2] + c[2])
    along = w * (base + tilt * fall)
    down = w * tilt * (a[0] * n0 + a[1] * n1 + a[2] * n2)
    return (
        along * n0 + down * gravity[0],
        along * n1 + down * gravity[1],
        along * n2 + down * gravity[2],
    )
