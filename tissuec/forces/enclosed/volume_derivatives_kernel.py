"""Derivatives of the forces of enclosed volumes; for equations see ``enclosed.volume``.

A cell has the force p ∂V/∂x with p = K (1 + s - V/V0), s being the ordered change of volume, so
that a change of positions adds p ∂²V/∂x∂x δx - K/V0 ∂V/∂x (∂V/∂x·δx).
"""

from tissuec.forces.enclosed.volume_kernel import CellTable, spans
from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import Floats

#: Three vectors of a face: s, p and q, or ∂V/∂s, ∂V/∂p and ∂V/∂q times 24, or changes of them.
Nine = tuple[float, ...]


def pull_volumes(
    time: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    by: Floats,
    cells: CellTable,
) -> None:
    """Add the derivatives of Σ weight · f; see ``tissuec.forces.matrices``.

    Args:
        by: Derivatives by the bulk modulus and by drawn volumes.
        cells: The enclosed volumes.
    """
    swell, _, _, _, _, _ = total(0, time, cells.acts)
    for cell in range(cells.drawn.size):
        volume, moved = enclosed(cell, x, weight, cells)
        drawn, modulus = cells.drawn[cell], cells.modulus[cell]
        excess = 1.0 + swell - volume / drawn
        by[0] += cells.share * excess * moved
        by[1 + cell] += modulus * volume / (drawn * drawn) * moved / cells.share
        pressure, softer = modulus * excess / 24.0, modulus / drawn * moved / 24.0
        o = 3 * cells.corners[cells.first[cell], 0]
        for face in range(cells.first[cell], cells.first[cell + 1]):
            i, j = 3 * cells.corners[face, 0], 3 * cells.corners[face, 1]
            k, m = 3 * cells.corners[face, 2], 3 * cells.corners[face, 3]
            one, way = spans(i, j, k, m, o, x), spans(i, j, k, m, o, weight)
            a0, a1, a2, b0, b1, b2, c0, c1, c2 = mixed(
                pressure, turned_sides(one, way), -softer, sides(one)
            )
            give(i, a0 - b0, a1 - b1, a2 - b2, by_x)
            give(j, a0 - c0, a1 - c1, a2 - c2, by_x)
            give(k, a0 + b0, a1 + b1, a2 + b2, by_x)
            give(m, a0 + c0, a1 + c1, a2 + c2, by_x)


def push_volumes(
    time: float,
    x: Floats,
    v: Floats,
    dx: Floats,
    dv: Floats,
    dn: Floats,
    df: Floats,
    room: Floats,
    cells: CellTable,
) -> None:
    """Add the changes of the forces for many changes; see ``tissuec.forces.matrices``.

    Args:
        dn: Changes of the bulk modulus and of drawn volumes.
        cells: The enclosed volumes.
    """
    swell, _, _, _, _, _ = total(0, time, cells.acts)
    own = room.size
    for cell in range(cells.drawn.size):
        volume = enclose_changes(cell, x, dx, room, cells)
        drawn, modulus = cells.drawn[cell], cells.modulus[cell]
        excess = 1.0 + swell - volume / drawn
        # A 24th of what the pressure changes by.
        harder, stiffer = cells.share * excess / 24.0, modulus / (24.0 * drawn)
        larger, stiffer = stiffer * volume / (drawn * cells.share), stiffer / 24.0
        of_modulus, of_drawn = dn[:own], dn[own * (1 + cell) : own * (2 + cell)]
        for n in range(own):
            room[n] = harder * of_modulus[n] + larger * of_drawn[n] - stiffer * room[n]
        pressure = modulus * excess / 24.0
        o = 3 * cells.corners[cells.first[cell], 0]
        for face in range(cells.first[cell], cells.first[cell + 1]):
            i, j = 3 * cells.corners[face, 0], 3 * cells.corners[face, 1]
            k, m = 3 * cells.corners[face, 2], 3 * cells.corners[face, 3]
            one = spans(i, j, k, m, o, x)
            by = sides(one)
            at_i, at_j = slice(own * i, own * (i + 3)), slice(own * j, own * (j + 3))
            at_k, at_m = slice(own * k, own * (k + 3)), slice(own * m, own * (m + 3))
            xo = dx[own * o : own * (o + 3)]
            xi, xj, xk, xm = dx[at_i], dx[at_j], dx[at_k], dx[at_m]
            fi, fj, fk, fm = df[at_i], df[at_j], df[at_k], df[at_m]
            for n in range(own):
                y, z = n + own, n + 2 * own
                way = (
                    xi[n] + xj[n] + xk[n] + xm[n] - 4.0 * xo[n],
                    xi[y] + xj[y] + xk[y] + xm[y] - 4.0 * xo[y],
                    xi[z] + xj[z] + xk[z] + xm[z] - 4.0 * xo[z],
                    xk[n] - xi[n], xk[y] - xi[y], xk[z] - xi[z],
                    xm[n] - xj[n], xm[y] - xj[y], xm[z] - xj[z],
                )  # fmt: skip
                part = mixed(pressure, turned_sides(one, way), room[n], by)
                give_nine(n, part, fi, fj, fk, fm)


def give_nine(n: int, part: Nine, fi: Floats, fj: Floats, fk: Floats, fm: Floats) -> None:
    """Add what a face does to its corners, for one of many changes.

    Args:
        n: Index of the change.
        part: Three vectors of the face.
        fi, fj, fk, fm: Changes of the forces on the corners, in any unit, shape (3 change,).
    """
    d0, d1, d2, e0, e1, e2, f0, f1, f2 = part
    y, z = n + fi.size // 3, n + 2 * (fi.size // 3)
    fi[n] += d0 - e0
    fi[y] += d1 - e1
    fi[z] += d2 - e2
    fj[n] += d0 - f0
    fj[y] += d1 - f1
    fj[z] += d2 - f2
    fk[n] += d0 + e0
    fk[y] += d1 + e1
    fk[z] += d2 + e2
    fm[n] += d0 + f0
    fm[y] += d1 + f1
    fm[z] += d2 + f2


def sides(one: Nine) -> Nine:
    """Return p × q, q × s and s × p [m²], which are 24 ∂V/∂s, 24 ∂V/∂p and 24 ∂V/∂q.

    Args:
        one: s, p and q [m].
    """
    s0, s1, s2, p0, p1, p2, q0, q1, q2 = one
    return (
        p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0,
        q1 * s2 - q2 * s1, q2 * s0 - q0 * s2, q0 * s1 - q1 * s0,
        s1 * p2 - s2 * p1, s2 * p0 - s0 * p2, s0 * p1 - s1 * p0,
    )  # fmt: skip


def turned_sides(one: Nine, way: Nine) -> Nine:
    """Return how ``sides`` change.

    Args:
        one: s, p and q [m].
        way: Their changes.
    """
    s0, s1, s2, p0, p1, p2, q0, q1, q2 = one
    u0, u1, u2, v0, v1, v2, w0, w1, w2 = way
    return (
        v1 * q2 - v2 * q1 + p1 * w2 - p2 * w1,
        v2 * q0 - v0 * q2 + p2 * w0 - p0 * w2,
        v0 * q1 - v1 * q0 + p0 * w1 - p1 * w0,
        w1 * s2 - w2 * s1 + q1 * u2 - q2 * u1,
        w2 * s0 - w0 * s2 + q2 * u0 - q0 * u2,
        w0 * s1 - w1 * s0 + q0 * u1 - q1 * u0,
        u1 * p2 - u2 * p1 + s1 * v2 - s2 * v1,
        u2 * p0 - u0 * p2 + s2 * v0 - s0 * v2,
        u0 * p1 - u1 * p0 + s0 * v1 - s1 * v0,
    )


def mixed(first: float, one: Nine, second: float, other: Nine) -> Nine:
    """Return the sum of two such vectors times numbers.

    Args:
        first, second: The numbers.
        one, other: The vectors.
    """
    return (
        first * one[0] + second * other[0], first * one[1] + second * other[1],
        first * one[2] + second * other[2], first * one[3] + second * other[3],
        first * one[4] + second * other[4], first * one[5] + second * other[5],
        first * one[6] + second * other[6], first * one[7] + second * other[7],
        first * one[8] + second * other[8],
    )  # fmt: skip


def enclosed(cell: int, x: Floats, way: Floats, cells: CellTable) -> tuple[float, float]:
    """Return the volume of a cell [m³], and its change along a way, ∂V/∂x·way.

    Args:
        cell: Index of the cell.
        x: Positions of all nodes [m], flat, shape (3 node,).
        way: Vectors of all nodes in any unit, shape as ``x``.
        cells: The enclosed volumes.
    """
    volume, moved = 0.0, 0.0
    o = 3 * cells.corners[cells.first[cell], 0]
    for face in range(cells.first[cell], cells.first[cell + 1]):
        i, j = 3 * cells.corners[face, 0], 3 * cells.corners[face, 1]
        k, m = 3 * cells.corners[face, 2], 3 * cells.corners[face, 3]
        one = spans(i, j, k, m, o, x)
        by, along = sides(one), spans(i, j, k, m, o, way)
        volume += one[0] * by[0] + one[1] * by[1] + one[2] * by[2]
        moved += by[0] * along[0] + by[1] * along[1] + by[2] * along[2]
        moved += by[3] * along[3] + by[4] * along[4] + by[5] * along[5]
        moved += by[6] * along[6] + by[7] * along[7] + by[8] * along[8]
    return volume / 24.0, moved / 24.0


def enclose_changes(cell: int, x: Floats, dx: Floats, room: Floats, cells: CellTable) -> float:
    """Return the volume of a cell [m³], and set ``room`` to 24 times its changes [m³].

    Args:
        cell: Index of the cell.
        x: Positions of all nodes [m], flat, shape (3 node,).
        dx: Changes of positions, shape (3 node change,).
        room: Shape (change,).
        cells: The enclosed volumes.
    """
    own, volume = room.size, 0.0
    for n in range(own):
        room[n] = 0.0
    o = 3 * cells.corners[cells.first[cell], 0]
    xo = dx[own * o : own * (o + 3)]
    for face in range(cells.first[cell], cells.first[cell + 1]):
        i, j = 3 * cells.corners[face, 0], 3 * cells.corners[face, 1]
        k, m = 3 * cells.corners[face, 2], 3 * cells.corners[face, 3]
        one = spans(i, j, k, m, o, x)
        a0, a1, a2, b0, b1, b2, c0, c1, c2 = sides(one)
        volume += one[0] * a0 + one[1] * a1 + one[2] * a2
        xi, xj = dx[own * i : own * (i + 3)], dx[own * j : own * (j + 3)]
        xk, xm = dx[own * k : own * (k + 3)], dx[own * m : own * (m + 3)]
        for n in range(own):
            y, z = n + own, n + 2 * own
            room[n] += (
                a0 * (xi[n] + xj[n] + xk[n] + xm[n] - 4.0 * xo[n])
                + a1 * (xi[y] + xj[y] + xk[y] + xm[y] - 4.0 * xo[y])
                + a2 * (xi[z] + xj[z] + xk[z] + xm[z] - 4.0 * xo[z])
                + b0 * (xk[n] - xi[n]) + b1 * (xk[y] - xi[y]) + b2 * (xk[z] - xi[z])
                + c0 * (xm[n] - xj[n]) + c1 * (xm[y] - xj[y]) + c2 * (xm[z] - xj[z])
            )  # fmt: skip
    return volume / 24.0


def give(place: int, x: float, y: float, z: float, to: Floats) -> None:
    """Add a vector to that of the node whose components begin at ``place``.

    Args:
        place: Index of the first component.
        x, y, z: Components in any unit.
        to: Vectors of all nodes, flat, shape (3 node,).
    """
    to[place] += x
    to[place + 1] += y
    to[place + 2] += z
