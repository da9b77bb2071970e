"""Derivatives of the forces of contact without friction; for equations see ``forces.contact``.

A node x touches a shape with points x_j at the point with the weights w_j. With the vector r =
x - Σ w_j x_j, the normal n = r / |r|, the pressure p and e = δx - Σ w_j δx_j, the forces are
p n on the node and -w_j p n on the points, and they change by

    δ|r| = n·e,    δn = (1 - n nᵀ) (e - b δw_b - c δw_c) / |r|,
    M (δw_b, δw_c) = (b·e + r·δb, c·e + r·δc),

where b and c are the sides between the points along which the nearest point may move, and M
their products. On a plane with a point a and another one straight in front of it, which is d
away, the forces are p n, -p (n + l) and p l, with n = d / |d| and l = (x - a + δ n) / |d|.

With friction, there are no derivatives. Forces have no jumps, but where a depth reaches the
layer and where the nearest point passes from a face to an edge, derivatives have some.

Shared arguments:
    row: Index of the row of ``met``.
    start, stop: Rows of a node with one surface: from ``start`` up to before ``stop``.
    k: Index of the node among those of the contact.
    touches: Record of the contact; its fields give the shapes and units.
"""

from tissuec.forces.contact.contact_kernel import look, press_surface
from tissuec.forces.contact.rows_kernel import (
    GAP,
    LEVER,
    NORMAL,
    PAIR,
    RATE,
    SHARE,
    STEADY,
    WEIGHT,
    end_of_surface,
    points,
    shape_of,
)
from tissuec.forces.contact.turning_kernel import (
    changed,
    lay_sides,
    pull_plane,
    pull_round,
    push_plane,
    push_round,
)
from tissuec.geometry.nearest import PLANE
from tissuec.kernels.records import ContactNodeTable, ContactTable, Floats

ALONG = SHARE  # column of ``met``: derivative of Σ weight · f by the pressure


def pull_contact(
    time: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    by: Floats,
    table: ContactNodeTable,
) -> None:
    """Add the derivatives of Σ weight · f; see ``tissuec.forces.matrices``.

    Args:
        by: Derivatives by the stiffness of each node.
    """
    touches = table.touches
    for k in range(touches.nodes.size):
        start, end = 0, look(k, 0, x, v, touches)
        while start < end:
            stop = end_of_surface(start, end, touches)
            pull_surface(k, start, stop, x, v, weight, by_x, by_v, by, touches)
            start = stop


def pull_surface(
    k: int,
    start: int,
    stop: int,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    by: Floats,
    touches: ContactTable,
) -> None:
    """Add the derivatives of what a surface does to a node.

    Args:
        by: Derivatives by the stiffness of each node [m/N], shape (m,).
    """
    steady, closing, _ = press_surface(k, start, stop, touches)
    if steady <= 0.0:
        return
    factor, damping = grip(steady, closing, touches)
    by_factor = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        met[ALONG] = along(row, weight, touches)
        by_factor += damping * met[STEADY] * met[ALONG]
    first = foremost(start, stop, steady, touches)
    for row in range(start, stop):
        met = touches.met[row]
        pressure = met[STEADY]
        by_rate = -by_factor * pressure / steady
        by_pressure = factor * met[ALONG] - by_factor * met[RATE] / steady
        if first < 0 or first == row:
            by_pressure -= by_factor * closing / (steady * steady)
        by[k] += by_pressure * pressure / touches.stiffness[k]
        by_depth = by_pressure * steepness(k, row, touches)
        p = factor * pressure
        if touches.kind[shape_of(row, touches)] == PLANE:
            pull_plane(row, p, by_depth, by_rate, x, v, weight, by_x, by_v, touches)
        else:
            pull_round(row, p, by_depth, by_rate, x, v, weight, by_x, by_v, touches)


def push_contact(
    time: float,
    x: Floats,
    v: Floats,
    dx: Floats,
    dv: Floats,
    dn: Floats,
    df: Floats,
    room: Floats,
    table: ContactNodeTable,
) -> None:
    """Add the changes of the forces for many changes; see ``tissuec.forces.matrices``.

    Args:
        dn: Changes of the stiffness of each node.
    """
    touches = table.touches
    for k in range(touches.nodes.size):
        start, end = 0, look(k, 0, x, v, touches)
        while start < end:
            stop = end_of_surface(start, end, touches)
            push_surface(k, start, stop, x, v, dx, dv, dn, df, room, touches)
            start = stop


def push_surface(
    k: int,
    start: int,
    stop: int,
    x: Floats,
    v: Floats,
    dx: Floats,
    dv: Floats,
    dn: Floats,
    df: Floats,
    room: Floats,
    touches: ContactTable,
) -> None:
    """Add the changes of what a surface does to a node; sets ``room`` to those of damping.

    Args:
        dn: Changes of the stiffness of each node [N/m], shape (m change,).
    """
    steady, closing, _ = press_surface(k, start, stop, touches)
    if steady <= 0.0:
        return
    own, (factor, damping) = room.size, grip(steady, closing, touches)
    first = foremost(start, stop, steady, touches)
    stiffer = dn[own * k : own * (k + 1)]
    for m in range(own):
        room[m] = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        pressure, steep = met[STEADY], steepness(k, row, touches)
        lay_sides(row, x, touches)
        if damping == 0.0:
            continue
        by_pressure = -damping * met[RATE] / steady
        if first < 0 or first == row:
            by_pressure -= damping * closing / (steady * steady)
        for m in range(own):
            depth, rate, _, _, _, _, _, _ = changed(row, m, own, x, v, dx, dv, touches)
            room[m] += by_pressure * (
                steep * depth + pressure / touches.stiffness[k] * stiffer[m]
            )
            room[m] -= damping * pressure / steady * rate
    for row in range(start, stop):
        pressure, steep = touches.met[row, STEADY], steepness(k, row, touches)
        p, is_plane = factor * pressure, touches.kind[shape_of(row, touches)] == PLANE
        for m in range(own):
            change = changed(row, m, own, x, v, dx, dv, touches)
            more = factor * (steep * change[0] + pressure / touches.stiffness[k] * stiffer[m])
            more += room[m] * pressure
            if is_plane:
                push_plane(row, m, own, p, more, change, df, touches)
            else:
                push_round(row, m, own, p, more, change, df, touches)


# --- pressures --------------------------------------------------------------------------------


def grip(steady: float, closing: float, touches: ContactTable) -> tuple[float, float]:
    """Return the factor of damping, and its derivative by closing / steady [s/m].

    Args:
        steady: Pressure of a surface without damping [N].
        closing: That times the rate of the depth [W].
    """
    factor = 1.0 + touches.damping * closing / steady
    if factor > 0.0:
        return factor, touches.damping
    return 0.0, 0.0


def foremost(start: int, stop: int, steady: float, touches: ContactTable) -> int:
    """Return the row whose pressure counts as that of the surface; -1 for the sum of all.

    Args:
        steady: Pressure of the surface without damping [N].
    """
    total = 0.0
    for row in range(start, stop):
        total += touches.met[row, STEADY]
    for row in range(start, stop):
        if total < steady and touches.met[row, STEADY] == steady:
            return row
    return -1


def steepness(k: int, row: int, touches: ContactTable) -> float:
    """Return the derivative of the pressure of a row by its depth [N/m]."""
    pair = touches.at[row, PAIR]
    depth = touches.radius[pair] - touches.met[row, GAP]
    share = touches.weight[pair] * min(depth / touches.layer, 1.0)
    return float(share * touches.stiffness[k])


def along(row: int, weight: Floats, touches: ContactTable) -> float:
    """Return Σ weight · f of a row for a pressure of 1."""
    met, i = touches.met[row], touches.at[row, 0]
    a, b, c = points(row, touches)
    total = 0.0
    for axis in range(3):
        n, lever = met[NORMAL + axis], met[LEVER + axis]
        total += n * weight[i + axis] - (met[WEIGHT] * n + lever) * weight[a + axis]
        total -= (met[WEIGHT + 1] * n - lever) * weight[b + axis]
        total -= met[WEIGHT + 2] * n * weight[c + axis]
    return float(total)
