"""The bending of walls of triangles as loops; for the equations see ``forces.plates``."""

from math import sqrt
from typing import NamedTuple

from tissuec.forces.bending_kernel import COLLAPSE, TINY, WHOLE
from tissuec.kernels.records import Floats, IntegerRows, Rows, Stack

#: Places in the room of a hinge: derivatives of θ and w by its four nodes, and numbers.
SLOPE, SWELL, SINE, COSINE, WEIGHT, SPEED = 0, 12, 24, 25, 26, 27


class PlateTable(NamedTuple):
    """Plates as the kernel reads them."""

    nodes: IntegerRows  # of the patch of each triangle, shape (triangle, 6)
    stiffness: Stack  # K [N m], shape (triangle, 3, 3)
    delay: Floats  # τ [s], shape (triangle,)
    cosine: Rows  # of drawn folds, shape (triangle, 3)
    sine: Rows
    upper: Rows  # squares of drawn normals: of the triangle [m⁴], shape (triangle, 3)
    lower: Rows  # of its neighbours
    room: Rows  # scratch, shape (3, 28)


def bend_plates(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, plates: PlateTable
) -> None:
    """Add the forces of bending to those on nodes, and the power that it dissipates.

    Args:
        plates: The triangles.
    """
    room = plates.room
    for t in range(plates.delay.size):
        for h in range(3):
            if plates.nodes[t, 3 + h] == plates.nodes[t, h]:
                for k in range(SINE, SPEED + 1):
                    room[h, k] = 0.0
            else:
                fold(t, h, x, v, plates)
        for h in range(3):
            if plates.nodes[t, 3 + h] == plates.nodes[t, h]:
                continue
            here = room[h]
            w, s, c = here[WEIGHT], here[SINE], here[COSINE]
            share = 0.5 * w * (3.0 - w)
            moment = drag = 0.0
            for g in range(3):
                if g != h:
                    there = room[g]
                    part = plates.stiffness[t, h, g] * 0.5 * there[WEIGHT]
                    part *= 3.0 - there[WEIGHT]
                    moment += part * there[SINE]
                    drag += part * there[COSINE] * there[SPEED]
            own = plates.stiffness[t, h, h]
            braking = plates.delay[t] * (own * w * here[SPEED] + share * c * drag)
            power[1] += braking * here[SPEED]
            turning = own * w * s + share * c * moment + braking
            swelling = own * (1.0 - c) + moment * s * (1.5 - w)
            for place in range(4):
                node = 3 * plates.nodes[t, corner(h, place)]
                for k in range(3):
                    n = 3 * place + k
                    f[node + k] -= turning * here[SLOPE + n] + swelling * here[SWELL + n]


def corner(edge: int, place: int) -> int:
    """Return the place in a patch of an end of an edge (0, 1), its own tip or the other one."""
    if place == 0:
        return (edge + 1) % 3
    if place == 1:
        return (edge + 2) % 3
    return edge if place == 2 else 3 + edge


def fold(t: int, h: int, x: Floats, v: Floats, plates: PlateTable) -> None:
    """Set the room of a hinge.

    Args:
        t: Number of the triangle.
        h: Number of the edge.
        plates: The triangles.
    """
    i: int = 3 * plates.nodes[t, corner(h, 0)]
    j: int = 3 * plates.nodes[t, corner(h, 1)]
    k: int = 3 * plates.nodes[t, h]
    m: int = 3 * plates.nodes[t, 3 + h]
    here = plates.room[h]
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
    here[SINE] = (sine * plates.cosine[t, h] - cosine * plates.sine[t, h]) / both
    here[COSINE] = (cosine * plates.cosine[t, h] + sine * plates.sine[t, h]) / both
    u, w = a / plates.upper[t, h] + COLLAPSE, b / plates.lower[t, h] + COLLAPSE
    grip_a, grip_b = WHOLE * (u - COLLAPSE) / u, WHOLE * (w - COLLAPSE) / w
    here[WEIGHT] = grip_a * grip_b
    # By the square of each normal, times two.
    by_a = 2.0 * WHOLE * COLLAPSE * grip_b / (u * u * plates.upper[t, h])
    by_b = 2.0 * WHOLE * COLLAPSE * grip_a / (w * w * plates.lower[t, h])
    along_k = q0 * e0 + q1 * e1 + q2 * e2
    along_m = r0 * e0 + r1 * e1 + r2 * e2
    at_k, at_m = along_k / square, along_m / square
    k0, k1, k2 = upper * a0, upper * a1, upper * a2
    m0, m1, m2 = lower * b0, lower * b1, lower * b2
    j0, j1, j2 = -at_k * k0 - at_m * m0, -at_k * k1 - at_m * m1, -at_k * k2 - at_m * m2
    put(here, SLOPE, j0, j1, j2, k0, k1, k2, m0, m1, m2)
    speed = k0 * (v[k] - v[i]) + k1 * (v[k + 1] - v[i + 1]) + k2 * (v[k + 2] - v[i + 2])
    speed += m0 * (v[m] - v[i]) + m1 * (v[m + 1] - v[i + 1]) + m2 * (v[m + 2] - v[i + 2])
    speed += j0 * (v[j] - v[i]) + j1 * (v[j + 1] - v[i + 1]) + j2 * (v[j + 2] - v[i + 2])
    here[SPEED] = speed
    p, q, r = by_a * square, by_a * along_k, by_a * (q0 * q0 + q1 * q1 + q2 * q2)
    k0, k1, k2 = p * q0 - q * e0, p * q1 - q * e1, p * q2 - q * e2
    j0, j1, j2 = r * e0 - q * q0, r * e1 - q * q1, r * e2 - q * q2
    p, q, r = by_b * square, by_b * along_m, by_b * (r0 * r0 + r1 * r1 + r2 * r2)
    m0, m1, m2 = p * r0 - q * e0, p * r1 - q * e1, p * r2 - q * e2
    j0, j1, j2 = j0 + r * e0 - q * r0, j1 + r * e1 - q * r1, j2 + r * e2 - q * r2
    put(here, SWELL, j0, j1, j2, k0, k1, k2, m0, m1, m2)


def put(
    here: Floats, first: int, j0: float, j1: float, j2: float, k0: float, k1: float, k2: float,
    m0: float, m1: float, m2: float,
) -> None:  # fmt: skip
    """Set derivatives by all nodes of a hinge from those by all but the first [1/m].

    Args:
        here: Room of the hinge, shape (28,).
        first: Place of the first of them.
        j0, j1, j2, k0, k1, k2, m0, m1, m2: By the second end, and by both tips.
    """
    here[first], here[first + 1] = -(j0 + k0 + m0), -(j1 + k1 + m1)
    here[first + 2], here[first + 3] = -(j2 + k2 + m2), j0
    here[first + 4], here[first + 5], here[first + 6] = j1, j2, k0
    here[first + 7], here[first + 8], here[first + 9] = k1, k2, m0
    here[first + 10], here[first + 11] = m1, m2
