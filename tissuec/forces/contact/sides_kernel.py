"""Points that closed surfaces keep outside, as scalar loops; see ``contact.pairs``.

Shared arguments:
    k: Index of the point among those of the contact.
    i: Index of its first component in ``x``.
    pair, last: Pairs of the point with one surface: from ``pair`` up to before ``last``.
    sided: ``CLOSED`` or ``TORN`` of pairs whose triangle determines the side of the point.
    alike: Length below which distances are equal [m].
    x, v: Positions [m] and velocities [m/s], flat.
    touches: Record of the contact; its fields give the shapes and units.
"""

from math import inf, pi, sqrt

from tissuec.forces.contact.place_kernel import corners, nearest
from tissuec.forces.contact.rows_kernel import BENDS, COLUMNS, PAIR, PLACES, lay
from tissuec.kernels.records import ContactTable, Floats, Integers

Three = tuple[float, float, float]
#: Of the longest way in a step: triangles so much further away than the nearest one are as
#: near, and so near to a surface a point is pushed straight out of it, as differences of places
#: are inaccurate.
ALIKE = 1e-11
NONE = 1e-9  # weight of a corner that counts as none
#: Kinds of surfaces that keep points outside: those that are closed, and those that were, of
#: which triangles are cut or torn. At the rim of a hole, nothing is inside.
CLOSED, TORN = 1, 2


def push_outside(
    k: int,
    begin: int,
    end: int,
    x: Floats,
    v: Floats,
    touches: ContactTable,
    sided: Integers,
    alike: float,
) -> int:
    """Set rows for the triangles that a point is nearest to and behind; return the new end.

    Args:
        begin, end: All rows of the point, which ``look`` has set: from ``begin`` up to before
            ``end``.
    """
    i, pair, stop = 3 * touches.nodes[k], touches.first[k], touches.first[k + 1]
    while pair < stop:
        last = pair + 1
        surface = touches.surface[touches.shape[pair]]
        while last < stop and touches.surface[touches.shape[last]] == surface:
            last += 1
        if sided[pair]:
            behind, below, outwards = nearest_behind(i, pair, last, x, touches, sided, alike)
            if behind >= 0 and touches.radius[behind] + below > 0.0:
                row = begin
                while row < end and touches.at[row, PAIR] < behind:
                    row += 1
                if row == end or touches.at[row, PAIR] != behind:
                    make_room(row, end, touches)
                    end += 1
                lay_inside(k, row, i, behind, below, outwards, x, v, touches, alike)
        pair = last
    return end


def make_room(row: int, end: int, touches: ContactTable) -> None:
    """Move rows by one place.

    Args:
        row, end: They are from ``row`` up to before ``end``.
    """
    for each in range(end, row, -1):
        for column in range(COLUMNS):
            touches.met[each, column] = touches.met[each - 1, column]
        for column in range(PLACES):
            touches.at[each, column] = touches.at[each - 1, column]


def nearest_behind(
    i: int,
    pair: int,
    last: int,
    x: Floats,
    touches: ContactTable,
    sided: Integers,
    alike: float,
) -> tuple[int, float, Three]:
    """Return the nearest triangle of a point that is inside, or on the surface.

    Returns:
        Its pair, -1 if the point is outside; how deep the point is below it [m]; and the normal
        of the surface there, of any length.
    """
    least, found, alone, near = inf, -1, False, 0
    for each in range(pair, last):
        if sided[each]:
            least = min(least, distance(i, each, x, touches))
    below = least
    side = n0 = n1 = n2 = 0.0
    for each in range(pair, last):
        if alone or not sided[each]:
            continue
        shape = touches.shape[each]
        r0, r1, r2, wb, wc = above(i, shape, x, touches)
        away, wa = sqrt(r0 * r0 + r1 * r1 + r2 * r2), 1.0 - wb - wc
        if away > least + alike:
            continue
        near += 1
        if found < 0:
            found, below = each, away
            alone = wa > NONE and wb > NONE and wc > NONE
        f0, f1, f2 = facing(shape, wa, wb, wc, x, touches)
        side += f0 * r0 + f1 * r1 + f2 * r2
        n0, n1, n2 = n0 + f0, n1 + f1, n2 + f2
    on_rim = sided[found] == TORN and near == 1 and not alone
    if on_rim or (side >= 0.0 and below > alike):
        found = -1
    return found, below if side < 0.0 else -below, (n0, n1, n2)


def lay_inside(
    k: int, row: int, i: int, pair: int, below: float, outwards: Three, x: Floats, v: Floats,
    touches: ContactTable, alike: float,
) -> None:  # fmt: skip
    """Set a row for the nearest triangle of a point that is inside, without forces.

    Args:
        row: Index of the row.
        below: How deep the point is below the triangle [m].
        outwards: Normal of the surface, for a point that is on it.
    """
    shape = touches.shape[pair]
    n0, n1, n2, wb, wc = above(i, shape, x, touches)
    wa, turned = 1.0 - wb - wc, -1.0
    if abs(below) <= alike:
        n0, n1, n2 = outwards
        turned = 1.0
    size = sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    inverse = turned / size if size > 0.0 else 0.0
    n0, n1, n2 = n0 * inverse, n1 * inverse, n2 * inverse
    depth = touches.radius[pair] + below
    lay(k, row, pair, (depth, n0, n1, n2, wa, wb, wc, 0.0, 0.0, 0.0), v, touches)
    # Forces jump where another triangle becomes the nearest one, if it faces elsewhere.
    way = 9.0 * third(n0) + 3.0 * third(n1) + third(n2)
    touches.met[row, BENDS] += 4.0 * (1.0 + way)


def third(component: float) -> float:
    """Return in which third of the range from -1 to 1 a component of a normal is: 0, 1 or 2."""
    if component < -1.0 / 3.0:
        return 0.0
    return 2.0 if component > 1.0 / 3.0 else 1.0


def above(
    i: int, shape: int, x: Floats, touches: ContactTable
) -> tuple[float, float, float, float, float]:
    """Return where a point is as seen from the nearest point of a triangle [m].

    Args:
        shape: The triangle.

    Returns:
        The three components, and the weights of the second and third corner.
    """
    a, b, c = corners(shape, touches)
    d0, d1, d2 = x[b] - x[a], x[b + 1] - x[a + 1], x[b + 2] - x[a + 2]
    e0, e1, e2 = x[c] - x[a], x[c + 1] - x[a + 1], x[c + 2] - x[a + 2]
    r0, r1, r2 = x[i] - x[a], x[i + 1] - x[a + 1], x[i + 2] - x[a + 2]
    wb, wc = nearest(
        d0 * d0 + d1 * d1 + d2 * d2,
        d0 * e0 + d1 * e1 + d2 * e2,
        e0 * e0 + e1 * e1 + e2 * e2,
        d0 * r0 + d1 * r1 + d2 * r2,
        e0 * r0 + e1 * r1 + e2 * r2,
    )
    r0 -= wb * d0 + wc * e0
    r1 -= wb * d1 + wc * e1
    r2 -= wb * d2 + wc * e2
    return r0, r1, r2, wb, wc


def distance(i: int, pair: int, x: Floats, touches: ContactTable) -> float:
    """Return the distance of a point from a triangle [m]."""
    r0, r1, r2, _, _ = above(i, touches.shape[pair], x, touches)
    return sqrt(r0 * r0 + r1 * r1 + r2 * r2)


def facing(
    shape: int, wa: float, wb: float, wc: float, x: Floats, touches: ContactTable
) -> Three:
    """Return the normal of a triangle times its angle at a point of it.

    Args:
        shape: The triangle.
        wa, wb, wc: Weights of the corners in the point.
    """
    a, b, c = corners(shape, touches)
    if wb > wa and wb >= wc:
        a, b, c = b, c, a
    elif wc > wa and wc > wb:
        a, b, c = c, a, b
    d0, d1, d2 = x[b] - x[a], x[b + 1] - x[a + 1], x[b + 2] - x[a + 2]
    e0, e1, e2 = x[c] - x[a], x[c + 1] - x[a + 1], x[c + 2] - x[a + 2]
    n0, n1, n2 = d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0
    twice, angle = sqrt(n0 * n0 + n1 * n1 + n2 * n2), pi
    if max(wa, wb, wc) > 1.0 - NONE:
        angle = angle_of(d0 * e0 + d1 * e1 + d2 * e2, twice)
    part = angle / twice if twice > 0.0 else 0.0
    return part * n0, part * n1, part * n2


def angle_of(along: float, across: float) -> float:
    """Return the angle of a vector in a half plane to 7e-5, without a library function [rad].

    By M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions (1964), 4.4.45.

    Args:
        along, across: Components of the vector, the second one at least 0, in any unit.
    """
    size = sqrt(along * along + across * across)
    c = abs(along) / size if size > 0.0 else 1.0
    sharp = sqrt(1.0 - c) * (1.5707288 + c * (-0.2121144 + c * (0.0742610 - 0.0187293 * c)))
    return sharp if along >= 0.0 else pi - sharp
