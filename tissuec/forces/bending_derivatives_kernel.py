"""Derivatives of the forces of hinges; for the equations see ``tissuec.forces.bending``.

With g = ∂θ/∂x, a hinge has the force

    f = -k (w sin(θ - θ0) g + (1 - cos(θ - θ0)) ∂w/∂x) - d w (g·v) g.

All vectors are relative to the lower end i of the edge, which bears the opposite of the sum of
the others. ``Nine`` numbers are those of the upper end and of both tips.

Shared arguments:
    z: A hinge in a state, see ``bend``.
    u: Changes of e, x_k - x_i and x_l - x_i.
"""

from math import sqrt
from typing import NamedTuple

from tissuec.forces.bending_kernel import COLLAPSE, TINY, WHOLE, HingeTable, take
from tissuec.kernels.records import Floats


class Bend(NamedTuple):
    """A hinge in a state, and how its fold and its weight w change.

    Attributes:
        e0 … r2: e, x_k - x_i and x_l - x_i [m].
        a0 … b2: The normals a and b [m²].
        square, length: e² [m²] and |e| [m].
        along_k, along_m: e·(x_k - x_i) and e·(x_l - x_i) [m²].
        a, b: a² and b² [m⁴].
        j0 … m2: ∂θ/∂x of the upper end of the edge and of both tips [1/m].
        sine, cosine: Of θ - θ0.
        grip: w.
        by_a, by_b: ∂w by a² and b² [1/m⁴].
        by_aa, by_ab, by_bb: Its second derivatives [1/m⁸].
    """

    e0: float
    e1: float
    e2: float
    q0: float
    q1: float
    q2: float
    r0: float
    r1: float
    r2: float
    a0: float
    a1: float
    a2: float
    b0: float
    b1: float
    b2: float
    square: float
    length: float
    along_k: float
    along_m: float
    a: float
    b: float
    j0: float
    j1: float
    j2: float
    k0: float
    k1: float
    k2: float
    m0: float
    m1: float
    m2: float
    sine: float
    cosine: float
    grip: float
    by_a: float
    by_b: float
    by_aa: float
    by_ab: float
    by_bb: float


#: Three vectors: of the upper end of an edge and of both tips, relative to its lower end.
Nine = tuple[float, ...]


def bend(h: int, x: Floats, folds: HingeTable) -> Bend:
    """Return a hinge in a state.

    Args:
        h: Its index.
        x: Positions of all nodes [m], flat, shape (3 node,).
    """
    e0, e1, e2, q0, q1, q2, r0, r1, r2 = spread_of(h, x, folds)
    a0, a1, a2 = e1 * q2 - e2 * q1, e2 * q0 - e0 * q2, e0 * q1 - e1 * q0
    b0, b1, b2 = r1 * e2 - r2 * e1, r2 * e0 - r0 * e2, r0 * e1 - r1 * e0
    square = e0 * e0 + e1 * e1 + e2 * e2
    length = sqrt(square)
    sine = e0 * (b1 * a2 - b2 * a1) + e1 * (b2 * a0 - b0 * a2) + e2 * (b0 * a1 - b1 * a0)
    cosine = a0 * b0 + a1 * b1 + a2 * b2
    a = a0 * a0 + a1 * a1 + a2 * a2 + TINY
    b = b0 * b0 + b1 * b1 + b2 * b2 + TINY
    sine, both, upper, lower = sine / length, sqrt(a * b), length / a, length / b
    along_k, along_m = q0 * e0 + q1 * e1 + q2 * e2, r0 * e0 + r1 * e1 + r2 * e2
    at_k, at_m = along_k / square, along_m / square
    k0, k1, k2, m0, m1, m2 = (
        upper * a0, upper * a1, upper * a2, lower * b0, lower * b1, lower * b2,
    )  # fmt: skip
    first, second, rise = folds.squares[h, 0], folds.squares[h, 1], WHOLE * COLLAPSE
    u, w = a / first + COLLAPSE, b / second + COLLAPSE
    grip_a, grip_b = WHOLE * (u - COLLAPSE) / u, WHOLE * (w - COLLAPSE) / w
    rise_a, rise_b = rise / (u * u * first), rise / (w * w * second)
    return Bend(
        e0, e1, e2, q0, q1, q2, r0, r1, r2, a0, a1, a2, b0, b1, b2,
        square, length, along_k, along_m, a, b,
        -at_k * k0 - at_m * m0, -at_k * k1 - at_m * m1, -at_k * k2 - at_m * m2,
        k0, k1, k2, m0, m1, m2,
        (sine * folds.cosine[h] - cosine * folds.sine[h]) / both,
        (cosine * folds.cosine[h] + sine * folds.sine[h]) / both,
        grip_a * grip_b, grip_b * rise_a, grip_a * rise_b,
        -2.0 * grip_b * rise_a / (u * first), rise_a * rise_b,
        -2.0 * grip_a * rise_b / (w * second),
    )  # fmt: skip


def spread_of(h: int, u: Floats, folds: HingeTable) -> Nine:
    """Return a nodal vector of the upper end of an edge and of both tips, less its lower end's.

    Args:
        h: Index of the hinge.
        u: Vectors of all nodes in any unit, flat, shape (3 node,).
    """
    i, j = int(3 * folds.nodes[h, 0]), int(3 * folds.nodes[h, 1])
    k, m = int(3 * folds.nodes[h, 2]), int(3 * folds.nodes[h, 3])
    return (
        u[j] - u[i], u[j + 1] - u[i + 1], u[j + 2] - u[i + 2],
        u[k] - u[i], u[k + 1] - u[i + 1], u[k + 2] - u[i + 2],
        u[m] - u[i], u[m + 1] - u[i + 1], u[m + 2] - u[i + 2],
    )  # fmt: skip


def times(z: Bend, u: Nine) -> float:
    """Return ∂θ/∂x·u."""
    return (
        z.j0 * u[0] + z.j1 * u[1] + z.j2 * u[2] + z.k0 * u[3] + z.k1 * u[4] + z.k2 * u[5]
        + z.m0 * u[6] + z.m1 * u[7] + z.m2 * u[8]
    )  # fmt: skip


def inner(one: Nine, other: Nine) -> float:
    """Return the inner product of two vectors."""
    return (
        one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
        + one[3] * other[3] + one[4] * other[4] + one[5] * other[5]
        + one[6] * other[6] + one[7] * other[7] + one[8] * other[8]
    )  # fmt: skip


def turned_by(z: Bend, u: Nine) -> Nine:
    """Return ∂²θ/∂x∂x·u, how ∂θ/∂x changes with positions."""
    e0, e1, e2, q0, q1, q2, r0, r1, r2 = u
    along = (z.e0 * e0 + z.e1 * e1 + z.e2 * e2) / z.square
    a0 = (e1 * z.q2 - e2 * z.q1) + (z.e1 * q2 - z.e2 * q1)
    a1 = (e2 * z.q0 - e0 * z.q2) + (z.e2 * q0 - z.e0 * q2)
    a2 = (e0 * z.q1 - e1 * z.q0) + (z.e0 * q1 - z.e1 * q0)
    b0 = (r1 * z.e2 - r2 * z.e1) + (z.r1 * e2 - z.r2 * e1)
    b1 = (r2 * z.e0 - r0 * z.e2) + (z.r2 * e0 - z.r0 * e2)
    b2 = (r0 * z.e1 - r1 * z.e0) + (z.r0 * e1 - z.r1 * e0)
    upper, lower = z.length / z.a, z.length / z.b
    # The change of |e|/a² relative to itself, and likewise of |e|/b².
    more_k = along - 2.0 * (z.a0 * a0 + z.a1 * a1 + z.a2 * a2) / z.a
    more_m = along - 2.0 * (z.b0 * b0 + z.b1 * b1 + z.b2 * b2) / z.b
    k0, k1, k2 = (
        upper * a0 + more_k * z.k0,
        upper * a1 + more_k * z.k1,
        upper * a2 + more_k * z.k2,
    )
    m0, m1, m2 = (
        lower * b0 + more_m * z.m0,
        lower * b1 + more_m * z.m1,
        lower * b2 + more_m * z.m2,
    )
    at_k, at_m = z.along_k / z.square, z.along_m / z.square
    shift_k = (
        q0 * z.e0 + q1 * z.e1 + q2 * z.e2 + z.q0 * e0 + z.q1 * e1 + z.q2 * e2
    ) / z.square - 2.0 * at_k * along
    shift_m = (
        r0 * z.e0 + r1 * z.e1 + r2 * z.e2 + z.r0 * e0 + z.r1 * e1 + z.r2 * e2
    ) / z.square - 2.0 * at_m * along
    return (
        -shift_k * z.k0 - at_k * k0 - shift_m * z.m0 - at_m * m0,
        -shift_k * z.k1 - at_k * k1 - shift_m * z.m1 - at_m * m1,
        -shift_k * z.k2 - at_k * k2 - shift_m * z.m2 - at_m * m2,
        k0, k1, k2, m0, m1, m2,
    )  # fmt: skip


def gripping(z: Bend, by_a: float, by_b: float) -> Nine:
    """Return by_a ∂a²/∂x + by_b ∂b²/∂x; with z.by_a and z.by_b, ∂w/∂x [1/m].

    Args:
        by_a, by_b: Factors [1/m⁴].
    """
    q_q, r_r = z.q0 * z.q0 + z.q1 * z.q1 + z.q2 * z.q2, z.r0 * z.r0 + z.r1 * z.r1 + z.r2 * z.r2
    of_k, of_m = 2.0 * by_a, 2.0 * by_b
    of_e = of_k * q_q + of_m * r_r
    k_e, m_e = of_k * z.along_k, of_m * z.along_m
    k_k, m_m = of_k * z.square, of_m * z.square
    return (
        of_e * z.e0 - k_e * z.q0 - m_e * z.r0,
        of_e * z.e1 - k_e * z.q1 - m_e * z.r1,
        of_e * z.e2 - k_e * z.q2 - m_e * z.r2,
        k_k * z.q0 - k_e * z.e0, k_k * z.q1 - k_e * z.e1, k_k * z.q2 - k_e * z.e2,
        m_m * z.r0 - m_e * z.e0, m_m * z.r1 - m_e * z.e1, m_m * z.r2 - m_e * z.e2,
    )  # fmt: skip


def gripped_by(z: Bend, u: Nine) -> Nine:
    """Return ∂²w/∂x∂x·u, how ∂w/∂x changes with positions; see ``turned_by``."""
    e0, e1, e2, q0, q1, q2, r0, r1, r2 = u
    square = 2.0 * (z.e0 * e0 + z.e1 * e1 + z.e2 * e2)
    q_q = 2.0 * (z.q0 * q0 + z.q1 * q1 + z.q2 * q2)
    r_r = 2.0 * (z.r0 * r0 + z.r1 * r1 + z.r2 * r2)
    along_k = q0 * z.e0 + q1 * z.e1 + q2 * z.e2 + z.q0 * e0 + z.q1 * e1 + z.q2 * e2
    along_m = r0 * z.e0 + r1 * z.e1 + r2 * z.e2 + z.r0 * e0 + z.r1 * e1 + z.r2 * e2
    own_q = z.q0 * z.q0 + z.q1 * z.q1 + z.q2 * z.q2
    own_r = z.r0 * z.r0 + z.r1 * z.r1 + z.r2 * z.r2
    # a² = e² q² - (e·q)², and so b².
    a = square * own_q + z.square * q_q - 2.0 * z.along_k * along_k
    b = square * own_r + z.square * r_r - 2.0 * z.along_m * along_m
    more = gripping(z, z.by_aa * a + z.by_ab * b, z.by_ab * a + z.by_bb * b)
    of_k, of_m = 2.0 * z.by_a, 2.0 * z.by_b
    of_e, of_de = of_k * q_q + of_m * r_r, of_k * own_q + of_m * own_r
    k_e, k_de = of_k * along_k, of_k * z.along_k
    m_e, m_de = of_m * along_m, of_m * z.along_m
    k_k, k_dk, m_m, m_dm = of_k * square, of_k * z.square, of_m * square, of_m * z.square
    return (
        more[0] + of_e * z.e0 + of_de * e0 - k_e * z.q0 - k_de * q0 - m_e * z.r0 - m_de * r0,
        more[1] + of_e * z.e1 + of_de * e1 - k_e * z.q1 - k_de * q1 - m_e * z.r1 - m_de * r1,
        more[2] + of_e * z.e2 + of_de * e2 - k_e * z.q2 - k_de * q2 - m_e * z.r2 - m_de * r2,
        more[3] + k_k * z.q0 + k_dk * q0 - k_e * z.e0 - k_de * e0,
        more[4] + k_k * z.q1 + k_dk * q1 - k_e * z.e1 - k_de * e1,
        more[5] + k_k * z.q2 + k_dk * q2 - k_e * z.e2 - k_de * e2,
        more[6] + m_m * z.r0 + m_dm * r0 - m_e * z.e0 - m_de * e0,
        more[7] + m_m * z.r1 + m_dm * r1 - m_e * z.e1 - m_de * e1,
        more[8] + m_m * z.r2 + m_dm * r2 - m_e * z.e2 - m_de * e2,
    )  # fmt: skip


def summed(
    z: Bend, of_g: float, of_w: float, slope: Nine, of_bent: float, bent: Nine, held: Nine
) -> Nine:
    """Return of_g ∂θ/∂x + of_w ∂w/∂x + of_bent bent + held.

    Args:
        of_g, of_w, of_bent: Factors.
        slope: ∂w/∂x, of ``gripping``.
        bent: Of ``turned_by``.
        held: Of ``gripped_by``, with its factor.
    """
    return (
        of_g * z.j0 + of_w * slope[0] + of_bent * bent[0] + held[0],
        of_g * z.j1 + of_w * slope[1] + of_bent * bent[1] + held[1],
        of_g * z.j2 + of_w * slope[2] + of_bent * bent[2] + held[2],
        of_g * z.k0 + of_w * slope[3] + of_bent * bent[3] + held[3],
        of_g * z.k1 + of_w * slope[4] + of_bent * bent[4] + held[4],
        of_g * z.k2 + of_w * slope[5] + of_bent * bent[5] + held[5],
        of_g * z.m0 + of_w * slope[6] + of_bent * bent[6] + held[6],
        of_g * z.m1 + of_w * slope[7] + of_bent * bent[7] + held[7],
        of_g * z.m2 + of_w * slope[8] + of_bent * bent[8] + held[8],
    )  # fmt: skip


def scaled(factor: float, u: Nine) -> Nine:
    """Return a vector times a number.

    Args:
        factor: The number.
    """
    return (
        factor * u[0], factor * u[1], factor * u[2], factor * u[3], factor * u[4],
        factor * u[5], factor * u[6], factor * u[7], factor * u[8],
    )  # fmt: skip


def mixed(one: float, first: Nine, other: float, second: Nine) -> Nine:
    """Return the sum of two vectors times numbers.

    Args:
        one, other: The numbers.
        first, second: The vectors.
    """
    return (
        one * first[0] + other * second[0], one * first[1] + other * second[1],
        one * first[2] + other * second[2], one * first[3] + other * second[3],
        one * first[4] + other * second[4], one * first[5] + other * second[5],
        one * first[6] + other * second[6], one * first[7] + other * second[7],
        one * first[8] + other * second[8],
    )  # fmt: skip


def pull_folds(
    time: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    by: Floats,
    folds: HingeTable,
) -> None:
    """Add the derivatives of Σ weight · f; see ``tissuec.forces.matrices``.

    With g = ∂θ/∂x, the dashpots give -d w (g·v) (g·weight), whose factors all depend on x.

    Args:
        by: Derivatives by stiffness, damping and drawn folds.
    """
    count = folds.stiffness.size
    for h in range(count):
        z, w = bend(h, x, folds), spread_of(h, weight, folds)
        stiffness, damping = folds.stiffness[h], folds.damping[h]
        slope, less = gripping(z, z.by_a, z.by_b), 1.0 - z.cosine
        along, grip = times(z, w), inner(slope, w)
        by[h] -= z.grip * z.sine * along + less * grip
        by[2 * count + h] += stiffness * (z.grip * z.cosine * along + z.sine * grip)
        of_g = stiffness * (z.grip * z.cosine * along + z.sine * grip)
        of_w, of_bent = stiffness * z.sine * along, stiffness * z.grip * z.sine
        way = scaled(of_bent, w)
        if damping != 0.0:
            u = spread_of(h, v, folds)
            speed = times(z, u)
            by[count + h] -= z.grip * speed * along
            of_w += damping * speed * along
            # ∂²θ/∂x∂x acts on the weights and on the velocities alike.
            way = mixed(of_bent + damping * z.grip * speed, w, damping * z.grip * along, u)
            fold = z.j0, z.j1, z.j2, z.k0, z.k1, z.k2, z.m0, z.m1, z.m2
            push_nine(h, -damping * z.grip * along, fold, by_v, folds)
        held = gripped_by(z, scaled(stiffness * less, w))
        found = summed(z, of_g, of_w, slope, 1.0, turned_by(z, way), held)
        push_nine(h, -1.0, found, by_x, folds)


def push_nine(h: int, factor: float, part: Nine, to: Floats, folds: HingeTable) -> None:
    """Add a multiple of three vectors to those of the nodes of a hinge; all sum up to zero.

    Args:
        h: Index of the hinge.
        part: The vectors.
        to: Vectors of all nodes in any unit, flat, shape (3 node,).
    """
    i, j = 3 * folds.nodes[h, 0], 3 * folds.nodes[h, 1]
    k, m = 3 * folds.nodes[h, 2], 3 * folds.nodes[h, 3]
    take(j, -factor * part[0], -factor * part[1], -factor * part[2], to)
    take(k, -factor * part[3], -factor * part[4], -factor * part[5], to)
    take(m, -factor * part[6], -factor * part[7], -factor * part[8], to)
    take(
        i,
        factor * (part[0] + part[3] + part[6]),
        factor * (part[1] + part[4] + part[7]),
        factor * (part[2] + part[5] + part[8]),
        to,
    )


def push_folds(
    time: float,
    x: Floats,
    v: Floats,
    dx: Floats,
    dv: Floats,
    dn: Floats,
    df: Floats,
    room: Floats,
    folds: HingeTable,
) -> None:
    """Add the changes of the forces for many changes; see ``tissuec.forces.matrices``.

    Args:
        dn: Changes of stiffness, damping and drawn folds.
    """
    count, own = folds.stiffness.size, room.size
    for h in range(count):
        z = bend(h, x, folds)
        stiffness, damping = folds.stiffness[h], folds.damping[h]
        slope, u = gripping(z, z.by_a, z.by_b), spread_of(h, v, folds)
        speed, spun, less = times(z, u), turned_by(z, u), 1.0 - z.cosine
        of_bent = z.grip * (stiffness * z.sine + damping * speed)
        of_k, of_d, of_0 = (
            dn[own * h : own * (h + 1)],
            dn[own * (count + h) : own * (count + h + 1)],
            dn[own * (2 * count + h) : own * (2 * count + h + 1)],
        )
        i, j = 3 * own * folds.nodes[h, 0], 3 * own * folds.nodes[h, 1]
        k, o = 3 * own * folds.nodes[h, 2], 3 * own * folds.nodes[h, 3]
        at_i, at_j = slice(i, i + 3 * own), slice(j, j + 3 * own)
        at_k, at_o = slice(k, k + 3 * own), slice(o, o + 3 * own)
        xi, xj, xk, xl = dx[at_i], dx[at_j], dx[at_k], dx[at_o]
        vi, vj, vk, vl = dv[at_i], dv[at_j], dv[at_k], dv[at_o]
        fi, fj, fk, fl = df[at_i], df[at_j], df[at_k], df[at_o]
        for m in range(own):
            y, w = m + own, m + 2 * own
            dq = (
                xj[m] - xi[m], xj[y] - xi[y], xj[w] - xi[w],
                xk[m] - xi[m], xk[y] - xi[y], xk[w] - xi[w],
                xl[m] - xi[m], xl[y] - xi[y], xl[w] - xi[w],
            )  # fmt: skip
            du = (
                vj[m] - vi[m], vj[y] - vi[y], vj[w] - vi[w],
                vk[m] - vi[m], vk[y] - vi[y], vk[w] - vi[w],
                vl[m] - vi[m], vl[y] - vi[y], vl[w] - vi[w],
            )  # fmt: skip
            turn, grip, stiffer, drawn = times(z, dq), inner(slope, dq), of_k[m], of_0[m]
            # The change of the moment by which the fold turns, but for that of w.
            moment = z.sine * stiffer + stiffness * z.cosine * (turn - drawn)
            moment += of_d[m] * speed + damping * (inner(spun, dq) + times(z, du))
            of_g = z.grip * moment + (stiffness * z.sine + damping * speed) * grip
            of_w = less * stiffer + stiffness * z.sine * (turn - drawn)
            held = gripped_by(z, scaled(stiffness * less, dq))
            g = summed(z, of_g, of_w, slope, of_bent, turned_by(z, dq), held)
            take_nine(m, g, fi, fj, fk, fl)


def take_nine(m: int, part: Nine, fi: Floats, fj: Floats, fk: Floats, fl: Floats) -> None:
    """Subtract three vectors from those of the nodes of a hinge, for one of many changes.

    Args:
        m: Index of the change.
        part: The vectors.
        fi, fj, fk, fl: Changes of the forces on the nodes, in any unit, shape (3 change,).
    """
    y, w = m + fi.size // 3, m + 2 * (fi.size // 3)
    fj[m] -= part[0]
    fj[y] -= part[1]
    fj[w] -= part[2]
    fk[m] -= part[3]
    fk[y] -= part[4]
    fk[w] -= part[5]
    fl[m] -= part[6]
    fl[y] -= part[7]
    fl[w] -= part[8]
    fi[m] += part[0] + part[3] + part[6]
    fi[y] += part[1] + part[4] + part[7]
    fi[w] += part[2] + part[5] + part[8]
