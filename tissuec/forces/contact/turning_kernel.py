"""How the place of a node on a shape changes, and what that does to the forces of both.

For the equations see ``contact.derivatives_kernel``.

Shared arguments:
    row: Index of the row of ``met``.
    m, own: Index of a change, and number of changes.
    p: Pressure of a row [N].
    more: Change of the pressure.
    change: Of the place; see ``changed``.
    by_depth: Derivative by the depth [1/m].
    by_rate: Derivative by the velocity along the normal [s/m].
    touches: Record of the contact; its fields give the shapes and units.
"""

from math import sqrt

from tissuec.forces.contact.rows_kernel import (
    FORCE,
    GAP,
    LEVER,
    NORMAL,
    PAIR,
    SLIDE,
    WEIGHT,
    points,
    shape_of,
)
from tissuec.geometry.nearest import CAPSULE, PLANE
from tissuec.kernels.records import ContactTable, Floats

# Columns of ``met`` whose other contents are not needed here.
SIDES = FORCE  # b and c [m]
INVERSE = FORCE + 6  # of M [1/m²]: by b twice, by b and c, by c twice
ENDS = FORCE + 9  # where the coordinates of the common end of b and c begin, and of the others
CORNER = 1e-12  # weight of a point that counts as none

Three = tuple[float, float, float]
# Changes of the depth, of its rate, of n, and of w_b, w_c and nothing, or of l.
Change = tuple[float, float, float, float, float, float, float, float]


# --- planes -----------------------------------------------------------------------------------


def pull_plane(
    row: int,
    p: float,
    by_depth: float,
    by_rate: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    touches: ContactTable,
) -> None:
    """Add the derivatives of the force of a plane on a node."""
    met, i, (a, b, _) = touches.met[row], touches.at[row, 0], points(row, touches)
    inverse, depth = 1.0 / distance(a, b, x), touches.radius[touches.at[row, PAIR]] - met[GAP]
    by_n, by_l = weighed(i, a, p, weight, by_rate, v), weighed(b, a, p, weight, by_rate, v)
    n = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
    lever = met[LEVER], met[LEVER + 1], met[LEVER + 2]
    deeper = by_depth + inverse * dot(by_l, n)
    turned = inverse * dot(by_n, n) + depth * inverse * inverse * dot(by_l, n)
    longer = inverse * dot(by_l, lever)
    for axis in range(3):
        of_r = inverse * by_l[axis] - deeper * n[axis]
        of_d = inverse * (by_n[axis] + depth * inverse * by_l[axis]) - turned * n[axis]
        of_d -= longer * n[axis] + deeper * lever[axis]
        by_x[i + axis] += of_r
        by_x[a + axis] -= of_r + of_d
        by_x[b + axis] += of_d
        by_v[i + axis] += by_rate * n[axis]
        by_v[a + axis] -= by_rate * (n[axis] + lever[axis])
        by_v[b + axis] += by_rate * lever[axis]


def push_plane(
    row: int, m: int, own: int, p: float, more: float, change: Change, df: Floats,
    touches: ContactTable,
) -> None:  # fmt: skip
    """Add the change of the force of a plane on a node."""
    met, i, (a, b, _) = touches.met[row], touches.at[row, 0], points(row, touches)
    for axis in range(3):
        force = more * met[NORMAL + axis] + p * change[2 + axis]
        lever = more * met[LEVER + axis] + p * change[5 + axis]
        df[own * (i + axis) + m] += force
        df[own * (a + axis) + m] -= force + lever
        df[own * (b + axis) + m] += lever


def changed_plane(
    row: int, m: int, own: int, x: Floats, v: Floats, dx: Floats, dv: Floats,
    touches: ContactTable,
) -> Change:  # fmt: skip
    """Return the change of the place of a node on a plane."""
    met, i, (a, b, _) = touches.met[row], touches.at[row, 0], points(row, touches)
    inverse, depth = 1.0 / distance(a, b, x), touches.radius[touches.at[row, PAIR]] - met[GAP]
    n = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
    lever = met[LEVER], met[LEVER + 1], met[LEVER + 2]
    r, d = apart(i, a, m, own, dx), apart(b, a, m, own, dx)
    longer = inverse * dot(d, n)
    deeper = -dot(n, r) - dot(lever, d)
    n0, n1, n2 = (
        inverse * d[0] - longer * n[0], inverse * d[1] - longer * n[1],
        inverse * d[2] - longer * n[2],
    )  # fmt: skip
    l0 = inverse * (r[0] + deeper * n[0] + depth * n0) - longer * lever[0]
    l1 = inverse * (r[1] + deeper * n[1] + depth * n1) - longer * lever[1]
    l2 = inverse * (r[2] + deeper * n[2] + depth * n2) - longer * lever[2]
    rate = dot(n, apart(i, a, m, own, dv)) + dot(lever, apart(b, a, m, own, dv))
    rate += dot((n0, n1, n2), apart(i, a, 0, 1, v)) + dot((l0, l1, l2), apart(b, a, 0, 1, v))
    return deeper, rate, n0, n1, n2, l0, l1, l2


# --- capsules and triangles -------------------------------------------------------------------


def pull_round(
    row: int,
    p: float,
    by_depth: float,
    by_rate: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    touches: ContactTable,
) -> None:
    """Add the derivatives of the force of a capsule or triangle on a node."""
    met, i, (a, b, c) = touches.met[row], touches.at[row, 0], points(row, touches)
    gap = met[GAP]
    if gap <= 0.0:
        return
    lay_sides(row, x, touches)
    n = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
    wa, wb, wc = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2]
    u = met[SLIDE], met[SLIDE + 1], met[SLIDE + 2]
    h0 = p * pointed(0, i, a, b, c, wa, wb, wc, weight) + by_rate * u[0]
    h1 = p * pointed(1, i, a, b, c, wa, wb, wc, weight) + by_rate * u[1]
    h2 = p * pointed(2, i, a, b, c, wa, wb, wc, weight) + by_rate * u[2]
    straight = dot((h0, h1, h2), n)
    h = (
        (h0 - straight * n[0]) / gap,
        (h1 - straight * n[1]) / gap,
        (h2 - straight * n[2]) / gap,
    )
    base, one, two = int(met[ENDS]), int(met[ENDS + 1]), int(met[ENDS + 2])
    side, other = met[SIDES : SIDES + 3], met[SIDES + 3 : SIDES + 6]
    of_b = -dot(weighed(one, base, p, weight, by_rate, v), n) - dot(h, side)
    of_c = -dot(weighed(two, base, p, weight, by_rate, v), n) - dot(h, other)
    to_b = met[INVERSE] * of_b + met[INVERSE + 1] * of_c
    to_c = met[INVERSE + 1] * of_b + met[INVERSE + 2] * of_c
    for axis in range(3):
        of_e = h[axis] - by_depth * n[axis] + to_b * side[axis] + to_c * other[axis]
        by_x[i + axis] += of_e
        by_x[a + axis] -= wa * of_e
        by_x[b + axis] -= wb * of_e
        by_x[c + axis] -= wc * of_e
        by_x[one + axis] += to_b * gap * n[axis]
        by_x[two + axis] += to_c * gap * n[axis]
        by_x[base + axis] -= (to_b + to_c) * gap * n[axis]
        by_v[i + axis] += by_rate * n[axis]
        by_v[a + axis] -= wa * by_rate * n[axis]
        by_v[b + axis] -= wb * by_rate * n[axis]
        by_v[c + axis] -= wc * by_rate * n[axis]


def push_round(
    row: int, m: int, own: int, p: float, more: float, change: Change, df: Floats,
    touches: ContactTable,
) -> None:  # fmt: skip
    """Add the change of the force of a capsule or triangle on a node."""
    met, i, (a, b, c) = touches.met[row], touches.at[row, 0], points(row, touches)
    base, one, two = int(met[ENDS]), int(met[ENDS + 1]), int(met[ENDS + 2])
    for axis in range(3):
        force = more * met[NORMAL + axis] + p * change[2 + axis]
        to_b, to_c = (
            p * change[5] * met[NORMAL + axis], p * change[6] * met[NORMAL + axis]
        )  # fmt: skip
        df[own * (i + axis) + m] += force
        df[own * (a + axis) + m] -= met[WEIGHT] * force
        df[own * (b + axis) + m] -= met[WEIGHT + 1] * force
        df[own * (c + axis) + m] -= met[WEIGHT + 2] * force
        df[own * (one + axis) + m] -= to_b
        df[own * (two + axis) + m] -= to_c
        df[own * (base + axis) + m] += to_b + to_c


def changed(
    row: int, m: int, own: int, x: Floats, v: Floats, dx: Floats, dv: Floats,
    touches: ContactTable,
) -> Change:  # fmt: skip
    """Return the change of the place of a node on a shape, whose sides are laid."""
    if touches.kind[shape_of(row, touches)] == PLANE:
        return changed_plane(row, m, own, x, v, dx, dv, touches)
    met, i, (a, b, c) = touches.met[row], touches.at[row, 0], points(row, touches)
    gap = met[GAP]
    if gap <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    n = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
    wa, wb, wc = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2]
    e, u = (
        moved(m, own, i, a, b, c, wa, wb, wc, dx),
        moved(m, own, i, a, b, c, wa, wb, wc, dv),
    )
    base, one, two = int(met[ENDS]), int(met[ENDS + 1]), int(met[ENDS + 2])
    side, other = met[SIDES : SIDES + 3], met[SIDES + 3 : SIDES + 6]
    of_b = dot(e, side) + gap * dot(n, apart(one, base, m, own, dx))
    of_c = dot(e, other) + gap * dot(n, apart(two, base, m, own, dx))
    to_b = met[INVERSE] * of_b + met[INVERSE + 1] * of_c
    to_c = met[INVERSE + 1] * of_b + met[INVERSE + 2] * of_c
    farther = dot(n, e)
    n0 = (e[0] - to_b * side[0] - to_c * other[0] - farther * n[0]) / gap
    n1 = (e[1] - to_b * side[1] - to_c * other[1] - farther * n[1]) / gap
    n2 = (e[2] - to_b * side[2] - to_c * other[2] - farther * n[2]) / gap
    rate = dot(n, u) + n0 * met[SLIDE] + n1 * met[SLIDE + 1] + n2 * met[SLIDE + 2]
    rate -= to_b * dot(n, apart(one, base, 0, 1, v)) + to_c * dot(n, apart(two, base, 0, 1, v))
    return -farther, rate, n0, n1, n2, to_b, to_c, 0.0


def lay_sides(row: int, x: Floats, touches: ContactTable) -> None:
    """Set the sides along which the nearest point may move, and the inverse of M."""
    met, (a, b, c) = touches.met[row], points(row, touches)
    kind = touches.kind[shape_of(row, touches)]
    on_a, on_b = met[WEIGHT] > CORNER, met[WEIGHT + 1] > CORNER
    on_c = met[WEIGHT + 2] > CORNER and kind != CAPSULE
    base = one = two = a
    if kind != PLANE and on_a:
        one, two = b if on_b else a, c if on_c else a
    elif kind != PLANE and on_b and on_c:
        base, one, two = b, b, c
    met[ENDS], met[ENDS + 1], met[ENDS + 2] = base, one, two
    bb = bc = cc = 0.0
    for axis in range(3):
        side, other = x[one + axis] - x[base + axis], x[two + axis] - x[base + axis]
        met[SIDES + axis], met[SIDES + 3 + axis] = side, other
        bb, bc, cc = bb + side * side, bc + side * other, cc + other * other
    # A side that is none has no length, and nothing moves along it.
    bb, cc = bb if bb > 0.0 else 1.0, cc if cc > 0.0 else 1.0
    size = bb * cc - bc * bc
    met[INVERSE], met[INVERSE + 1], met[INVERSE + 2] = cc / size, -bc / size, bb / size


# --- vectors ----------------------------------------------------------------------------------


def dot(a: Three | Floats, b: Three | Floats) -> float:
    """Return a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def distance(a: int, b: int, x: Floats) -> float:
    """Return the distance of two points [m].

    Args:
        a, b: Where their coordinates begin.
        x: Coordinates of all nodes [m], flat, shape (3 node,).
    """
    d = apart(b, a, 0, 1, x)
    return sqrt(dot(d, d))


def apart(b: int, a: int, m: int, own: int, x: Floats) -> Three:
    """Return the difference of the vectors that begin at b and a.

    Args:
        b, a: Where they begin.
        m, own: Of the change, and how many there are.
        x: Components, flat, in any unit, shape (3 node own,).
    """
    return (
        float(x[own * b + m] - x[own * a + m]),
        float(x[own * (b + 1) + m] - x[own * (a + 1) + m]),
        float(x[own * (b + 2) + m] - x[own * (a + 2) + m]),
    )


def weighed(b: int, a: int, p: float, weight: Floats, by_rate: float, v: Floats) -> Three:
    """Return the sum of the differences of weights, times p, and of velocities.

    Args:
        b, a: Where the vectors begin.
        p: The pressure [N].
        weight: Of forces, flat, shape (3 node,).
        by_rate: By the velocity along the normal [s/m].
        v: Velocities [m/s], flat, shape (3 node,).
    """
    g, u = apart(b, a, 0, 1, weight), apart(b, a, 0, 1, v)
    return p * g[0] + by_rate * u[0], p * g[1] + by_rate * u[1], p * g[2] + by_rate * u[2]


def pointed(
    axis: int, i: int, a: int, b: int, c: int, wa: float, wb: float, wc: float, of: Floats
) -> float:
    """Return a component of the vector of a node less that of the nearest point.

    Args:
        axis: The component.
        i, a, b, c: Where the vectors of the node and of the three points begin.
        wa, wb, wc: Weights of the points.
        of: Components, flat, in any unit, shape (3 node,).
    """
    return float(of[i + axis] - wa * of[a + axis] - wb * of[b + axis] - wc * of[c + axis])


def moved(
    m: int,
    own: int,
    i: int,
    a: int,
    b: int,
    c: int,
    wa: float,
    wb: float,
    wc: float,
    dx: Floats,
) -> Three:
    """Return the change of a node less that of the nearest point, whose weights are fixed.

    Args:
        m, own: Of the change, and how many there are.
        i, a, b, c: Where the vectors of the node and of the three points begin.
        wa, wb, wc: Weights of the points.
        dx: Changes, shape (3 node change,).
    """
    at_i, at_a, at_b, at_c = own * i + m, own * a + m, own * b + m, own * c + m
    y, z = own, 2 * own
    return (
        float(dx[at_i] - wa * dx[at_a] - wb * dx[at_b] - wc * dx[at_c]),
        float(dx[at_i + y] - wa * dx[at_a + y] - wb * dx[at_b + y] - wc * dx[at_c + y]),
        float(dx[at_i + z] - wa * dx[at_a + z] - wb * dx[at_b + z] - wc * dx[at_c + z]),
    )
