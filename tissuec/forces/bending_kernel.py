"""Hinges as scalar loops; for the equations see ``tissuec.forces.bending``."""

from math import sqrt
from typing import NamedTuple

from tissuec.kernels.records import Floats, IntegerRows, Rows

COLLAPSE = 1e-2  # ε: part of the drawn a² of a triangle that counts as none
WHOLE = 1.0 + COLLAPSE
TINY = 1e-200  # keeps the direction of a triangle without area a number


class HingeTable(NamedTuple):
    """Hinges as the engine has them."""

    nodes: IntegerRows  # both ends of the edge, and the tips beside it, shape (hinge, 4)
    stiffness: Floats  # [N m], shape (hinge,)
    damping: Floats  # [N m s], shape (hinge,)
    cosine: Floats  # of the drawn fold, shape (hinge,)
    sine: Floats
    squares: Rows  # of drawn normals [m⁴], shape (hinge, 2)


def fold(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, folds: HingeTable
) -> None:
    """Add the forces of hinges to those on nodes, and the power that they dissipate."""
    for h in range(folds.stiffness.size):
        i, j = 3 * folds.nodes[h, 0], 3 * folds.nodes[h, 1]
        k, m = 3 * folds.nodes[h, 2], 3 * folds.nodes[h, 3]
        e0, e1, e2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        q0, q1, q2 = x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2]
        r0, r1, r2 = x[m] - x[i], x[m + 1] - x[i + 1], x[m + 2] - x[i + 2]
        a0, a1, a2 = e1 * q2 - e2 * q1, e2 * q0 - e0 * q2, e0 * q1 - e1 * q0
        b0, b1, b2 = r1 * e2 - r2 * e1, r2 * e0 - r0 * e2, r0 * e1 - r1 * e0
        square = e0 * e0 + e1 * e1 + e2 * e2
        length = sqrt(square)
        sine = e0 * (b1 * a2 - b2 * a1) + e1 * (b2 * a0 - b0 * a2) + e2 * (b0 * a1 - b1 * a0)
        cosine = a0 * b0 + a1 * b1 + a2 * b2
        a = a0 * a0 + a1 * a1 + a2 * a2 + TINY
        b = b0 * b0 + b1 * b1 + b2 * b2 + TINY
        sine, both, upper, lower = sine / length, sqrt(a * b), length / a, length / b
        turned = (sine * folds.cosine[h] - cosine * folds.sine[h]) / both
        kept = (cosine * folds.cosine[h] + sine * folds.sine[h]) / both
        u, w = a / folds.squares[h, 0] + COLLAPSE, b / folds.squares[h, 1] + COLLAPSE
        grip_a, grip_b = WHOLE * (u - COLLAPSE) / u, WHOLE * (w - COLLAPSE) / w
        held = folds.stiffness[h] * (1.0 - kept) * WHOLE * COLLAPSE * 2.0
        swell_a = held * grip_b / (u * u * folds.squares[h, 0])
        swell_b = held * grip_a / (w * w * folds.squares[h, 1])
        k0, k1, k2 = upper * a0, upper * a1, upper * a2
        m0, m1, m2 = lower * b0, lower * b1, lower * b2
        along_k = q0 * e0 + q1 * e1 + q2 * e2
        along_m = r0 * e0 + r1 * e1 + r2 * e2
        at_k, at_m = along_k / square, along_m / square
        j0, j1, j2 = -at_k * k0 - at_m * m0, -at_k * k1 - at_m * m1, -at_k * k2 - at_m * m2
        speed = k0 * (v[k] - v[i]) + k1 * (v[k + 1] - v[i + 1]) + k2 * (v[k + 2] - v[i + 2])
        speed += m0 * (v[m] - v[i]) + m1 * (v[m + 1] - v[i + 1]) + m2 * (v[m + 2] - v[i + 2])
        speed += j0 * (v[j] - v[i]) + j1 * (v[j + 1] - v[i + 1]) + j2 * (v[j + 2] - v[i + 2])
        braking = grip_a * grip_b * folds.damping[h] * speed
        power[1] += braking * speed
        moment = grip_a * grip_b * folds.stiffness[h] * turned + braking
        p, q, r = swell_a * square, swell_a * along_k, swell_a * (q0 * q0 + q1 * q1 + q2 * q2)
        k0 = moment * k0 + p * q0 - q * e0
        k1 = moment * k1 + p * q1 - q * e1
        k2 = moment * k2 + p * q2 - q * e2
        j0 = moment * j0 + r * e0 - q * q0
        j1 = moment * j1 + r * e1 - q * q1
        j2 = moment * j2 + r * e2 - q * q2
        p, q, r = swell_b * square, swell_b * along_m, swell_b * (r0 * r0 + r1 * r1 + r2 * r2)
        m0 = moment * m0 + p * r0 - q * e0
        m1 = moment * m1 + p * r1 - q * e1
        m2 = moment * m2 + p * r2 - q * e2
        j0 += r * e0 - q * r0
        j1 += r * e1 - q * r1
        j2 += r * e2 - q * r2
        take(k, k0, k1, k2, f)
        take(m, m0, m1, m2, f)
        take(j, j0, j1, j2, f)
        take(i, -(j0 + k0 + m0), -(j1 + k1 + m1), -(j2 + k2 + m2), f)


def take(place: int, x: float, y: float, z: float, f: Floats) -> None:
    """Subtract a force from that on the node whose components begin at ``place``.

    Args:
        place: Index of the first component.
        x, y, z: Components of the force [N].
        f: Forces on all nodes [N], flat, shape (3 node,).
    """
    f[place] -= x
    f[place + 1] -= y
    f[place + 2] -= z
