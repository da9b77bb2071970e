"""Friction of contact by bristles as scalar loops; for the equations see ``forces.contact``.

Shared arguments:
    k: Index of the node among those of the contact.
    start, stop: Rows of the node with one surface: from ``start`` up to before ``stop``.
    begin, end: All rows of the node: from ``begin`` up to before ``end``.
    factor: Pressure with damping divided by pressure without it, dimensionless.
    touches: Record of the contact; its fields give the shapes and units.
    rough: Coefficients of friction.
"""

from math import sqrt

from tissuec.forces.contact.couples_kernel import spin, twist
from tissuec.forces.contact.rows_kernel import (
    BENDS,
    GAP,
    GRIP,
    LOST,
    NORMAL,
    RATE,
    SHARE,
    SLIDE,
    STEADY,
    WEIGHT,
    end_of_surface,
    push,
    shape_of,
)
from tissuec.kernels.records import ContactTable, Floats, Roughness

SHARPNESS = 8  # power of r with which a bristle slips
LARGEST = 2.0  # r that counts
LEAST = 1e-3  # part of the pressure at the depth of the layer, where contact begins
NEWTON = 100  # iterations for the length of a bristle; bisection alone needs about 50


def rub_past(
    k: int,
    start: int,
    stop: int,
    factor: float,
    x: Floats,
    v: Floats,
    touches: ContactTable,
    rough: Roughness,
) -> tuple[float, float, float, float]:
    """Return how a surface can rub a node, by the pressures with damping.

    Also sets how the faces of the surface share couples, and stores their largest frictions.

    Returns:
        The largest friction of the surface [N], and the sum of those of its rows times
        velocities along it [W].
    """
    every = q0 = q1 = q2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        met[GRIP] = coefficient(k, row, touches, rough) * factor * met[STEADY]
        met[SHARE] = 0.0
        if met[GRIP] > 0.0:
            turns, o0, o1, o2 = spin(row, x, v, touches)
            if turns:
                met[SHARE] = met[GRIP]
                every += met[GRIP]
                q0, q1, q2 = q0 + met[GRIP] * o0, q1 + met[GRIP] * o1, q2 + met[GRIP] * o2
    if every > 0.0:
        q0, q1, q2 = q0 / every, q1 / every, q2 / every
    grip = most = u0 = u1 = u2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        if every > 0.0:
            met[SHARE] /= every
        grip += met[GRIP]
        most = max(most, met[GRIP])
        n0, n1, n2, gap = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2], met[GAP]
        s0 = met[SLIDE] - gap * (q1 * n2 - q2 * n1)
        s1 = met[SLIDE + 1] - gap * (q2 * n0 - q0 * n2)
        s2 = met[SLIDE + 2] - gap * (q0 * n1 - q1 * n0)
        u0 += met[GRIP] * (s0 - met[RATE] * n0)
        u1 += met[GRIP] * (s1 - met[RATE] * n1)
        u2 += met[GRIP] * (s2 - met[RATE] * n2)
    return max(grip, most), u0, u1, u2


def coefficient(k: int, row: int, touches: ContactTable, rough: Roughness) -> float:
    """Return the coefficient of friction of a row: the smaller one of node and face.

    Args:
        row: Number of the row.
    """
    if touches.friction >= 0.0:
        return touches.friction
    met, of = touches.met[row], rough.face[shape_of(row, touches)]
    there = met[WEIGHT] * of[0] + met[WEIGHT + 1] * of[1] + met[WEIGHT + 2] * of[2]
    return min(float(rough.node[k]), float(there))


def rub(
    k: int,
    begin: int,
    end: int,
    total: float,
    rest: float,
    growth: float,
    grip: float,
    u0: float,
    u1: float,
    u2: float,
    x: Floats,
    v: Floats,
    touches: ContactTable,
) -> None:
    """Add friction to the forces and the power of the rows of a node.

    Args:
        total: Sum of the pressures on it [N].
        rest: The same without damping [N].
        growth: Rate of that [N/s].
        grip: Sum of the largest frictions [N].
        u0, u1, u2: Sum of these times velocities along the surfaces [W].
    """
    rate, memory, bent, lag = touches.rate, 3 * touches.memory[k], touches.bent, touches.lag[0]
    z0, z1, z2 = (
        float(v[memory] / rate), float(v[memory + 1] / rate), float(v[memory + 2] / rate)
    )  # fmt: skip
    if grip <= 0.0:
        falls = -rate * rate / (1.0 + lag * rate)
        bent[k, 0], bent[k, 1], bent[k, 2] = falls * z0, falls * z1, falls * z2
        return
    u0, u1, u2 = u0 / grip, u1 / grip, u2 / grip
    stiffness, half = touches.stiffness[k], 0.5 * touches.layer
    unbend = 0.5 * growth / (rest + LEAST * stiffness * half) * half / (rest / stiffness + half)
    reach = total / stiffness + half
    slips, slip = grip / total * reach, 0.0
    if lag > 0.0:
        z0, z1, z2 = bristle_ahead(lag, z0, z1, z2, u0, u1, u2, unbend, slips)
    d0, d1, d2 = u0 - unbend * z0, u1 - unbend * z1, u2 - unbend * z2
    length = sqrt(z0 * z0 + z1 * z1 + z2 * z2)
    if length > 0.0:
        r = min(length / slips, LARGEST)
        slip = max(d0 * z0 + d1 * z1 + d2 * z2, 0.0) / (length * length) * r**SHARPNESS
    bent[k, 0] = rate * (d0 - slip * z0)
    bent[k, 1] = rate * (d1 - slip * z1)
    bent[k, 2] = rate * (d2 - slip * z2)
    bears = total / reach
    if length > slips:
        bears = grip / length
        touches.met[begin, BENDS] += 1.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        drag_along(start, stop, bears / grip, z0, z1, z2, x, touches)
        start = stop
    touches.met[begin, LOST] += bears * (z0 * u0 + z1 * u1 + z2 * u2)


def bristle_ahead(
    lag: float,
    b0: float,
    b1: float,
    b2: float,
    u0: float,
    u1: float,
    u2: float,
    unbend: float,
    slips: float,
) -> tuple[float, float, float]:
    """Return the bristle z = b + lag z' of an implicit stage [m].

    With the length L and the direction e of z, this is

        e (L (1 + lag g/2) + lag (L/l)^8 max(0, u·e - L g/2)) = b + lag u,

    so e is the direction of the right-hand side, and L is found by Newton's method within
    bounds that are halved where it leaves them. Without a solution, in a step much longer than
    the contact, the result is b, and the equations of the stage remain unsolved.

    Args:
        lag: Step size times coefficient of the implicit method [s].
        b0, b1, b2: b [m].
        u0, u1, u2: Sliding velocity u [m/s].
        unbend: g/2 [1/s].
        slips: Length l at which it slips [m].
    """
    w0, w1, w2, firm = b0 + lag * u0, b1 + lag * u1, b2 + lag * u2, 1.0 + lag * unbend
    size = sqrt(w0 * w0 + w1 * w1 + w2 * w2)
    if not (size > 0.0 and firm > 0.0):
        return b0, b1, b2
    pace = (u0 * w0 + u1 * w1 + u2 * w2) / size
    low, high = 0.0, size / firm
    length = min(high, slips)
    for _ in range(NEWTON):
        grip = min(length / slips, LARGEST) ** SHARPNESS
        slides = max(pace - unbend * length, 0.0)
        over = firm * length + lag * grip * slides - size
        low, high = (low, length) if over > 0.0 else (length, high)
        steep = firm
        if slides > 0.0:
            steep -= lag * grip * unbend
            if length < LARGEST * slips:
                steep += lag * SHARPNESS * grip / length * slides
        before = length
        length = length - over / steep if steep > 0.0 else high
        if not low < length < high:
            length = 0.5 * (low + high)
        if abs(length - before) <= 4e-16 * high:
            break
    part = length / size
    return part * w0, part * w1, part * w2


def drag_along(
    start: int,
    stop: int,
    bears: float,
    z0: float,
    z1: float,
    z2: float,
    x: Floats,
    touches: ContactTable,
) -> None:
    """Add the friction of a surface on a node: its force, its reaction and the couple of both.

    Args:
        bears: Force by largest friction and length of the bristle [1/m].
        z0, z1, z2: The bristle [m].
    """
    c0 = c1 = c2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        n0, n1, n2 = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
        share, along = -bears * met[GRIP], z0 * n0 + z1 * n1 + z2 * n2
        r0, r1, r2 = (
            share * (z0 - along * n0),
            share * (z1 - along * n1),
            share * (z2 - along * n2),
        )
        wa, wb, wc, gap = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2], met[GAP]
        push(row, 0, r0, r1, r2, touches)
        push(row, 1, -wa * r0, -wa * r1, -wa * r2, touches)
        push(row, 2, -wb * r0, -wb * r1, -wb * r2, touches)
        push(row, 3, -wc * r0, -wc * r1, -wc * r2, touches)
        c0 -= gap * (n1 * r2 - n2 * r1)
        c1 -= gap * (n2 * r0 - n0 * r2)
        c2 -= gap * (n0 * r1 - n1 * r0)
    for row in range(start, stop):
        share = touches.met[row, SHARE]
        if share > 0.0:
            twist(row, share * c0, share * c1, share * c2, x, touches)
