"""Friction of faces by bristles that are cut, as scalar loops; see ``forces.contact``.

A bristle bends with the sliding velocity u and exerts k |z| up to the largest friction G = Σ μ
N. At the end of each step it is cut to the length G/k. One that was cut slips until G/k grows
faster than u lengthens it: it exerts G, and follows G/k,

    z' = u,  or  z' = u - max(0, u·e - (G/k)') e  where it slips,    e = z / |z|.

So a steady load below G causes no creep, however the contact is shaken; no rate u k / G limits
steps, and nothing jumps within a step.

Shared arguments:
    touches: Record of the contact; its fields give the shapes and units.
"""

from math import sqrt

from tissuec.forces.contact.friction_kernel import drag_along
from tissuec.forces.contact.rows_kernel import BENDS, LOST, end_of_surface
from tissuec.kernels.records import ContactTable, Floats

# Columns of ``bent`` after the rates: length at which a bristle slips [m]; whether it does;
# the rate u·e - (G/k)' at which it would become too long if it did not [m/s]. (Where it slips,
# rounding is all that is left of that rate, and its sign says nothing.)
SLIPS, SLIDES, AHEAD = 3, 4, 5
OVER = 1.0 + 1e-9  # times the length: what slips stays on the far side of the corner of the law


def bend(
    k: int,
    begin: int,
    end: int,
    total: float,
    grip: float,
    growth: float,
    u0: float,
    u1: float,
    u2: float,
    x: Floats,
    v: Floats,
    touches: ContactTable,
) -> None:
    """Add friction to the forces and the power of the rows of a node, and set its bristle.

    Args:
        k: Index of the node among those of the contact.
        begin, end: All rows of the node: from ``begin`` up to before ``end``.
        total: Sum of the pressures on it [N].
        grip: Sum of the largest frictions [N].
        growth: Its rate [N/s].
        u0, u1, u2: Sum of these times velocities along the surfaces [W].
    """
    bent, rate, memory = touches.bent, touches.rate, 3 * touches.memory[k]
    bent[k, 0] = bent[k, 1] = bent[k, 2] = bent[k, SLIPS] = bent[k, AHEAD] = 0.0
    if grip <= 0.0:
        return
    stiffness = touches.stiffness[k]
    # In the layer where contact begins, bristles bend more slowly, so that nothing jumps.
    begins = min(2.0 * total / (stiffness * touches.layer), 1.0)
    u0, u1, u2 = u0 / grip, u1 / grip, u2 / grip
    d0, d1, d2 = begins * u0, begins * u1, begins * u2
    lag, slips = touches.lag[0], grip / stiffness
    bent[k, SLIPS] = slips
    z0 = v[memory] / rate + lag * d0
    z1 = v[memory + 1] / rate + lag * d1
    z2 = v[memory + 2] / rate + lag * d2
    length, slip = sqrt(z0 * z0 + z1 * z1 + z2 * z2), 0.0
    if length > 0.0:
        e0, e1, e2 = z0 / length, z1 / length, z2 / length
        bent[k, AHEAD] = d0 * e0 + d1 * e1 + d2 * e2 - growth / stiffness
        slip = bent[k, SLIDES] * max(bent[k, AHEAD], 0.0)
        d0, d1, d2 = d0 - slip * e0, d1 - slip * e1, d2 - slip * e2
        length = max(length - lag * slip, 0.0)
        z0, z1, z2 = length * e0, length * e1, length * e2
    bent[k, 0], bent[k, 1], bent[k, 2] = rate * d0, rate * d1, rate * d2
    bears = stiffness
    if length > slips or slip > 0.0:
        bears = grip / length if length > 0.0 else 0.0
        touches.met[begin, BENDS] += 1.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        drag_along(start, stop, bears / grip, z0, z1, z2, x, touches)
        start = stop
    touches.met[begin, LOST] += bears * (z0 * u0 + z1 * u1 + z2 * u2)


def cut_bristles(v: Floats, a: Floats, touches: ContactTable) -> None:
    """Cut bristles to the length at which they slip, and note which of them do.

    Those that slip get this length even if it has grown in the step.

    Args:
        v: Velocities of all nodes at the end of a step [m/s], flat, shape (3 node,). Those that
            are bristles are changed in place.
        a: Accelerations there [m/s²], shape as ``v``; those of bristles that slip are changed.
    """
    bent = touches.bent
    if bent.shape[1] <= SLIDES:
        return
    for k in range(touches.memory.size):
        i, most = 3 * touches.memory[k], OVER * touches.rate * bent[k, SLIPS]
        size = sqrt(v[i] * v[i] + v[i + 1] * v[i + 1] + v[i + 2] * v[i + 2])
        slid, bent[k, SLIDES] = bent[k, SLIDES], 0.0
        if size <= 0.0:
            continue
        e0, e1, e2 = v[i] / size, v[i + 1] / size, v[i + 2] / size
        if OVER * size >= most or (slid > 0.0 and bent[k, AHEAD] >= 0.0):
            v[i], v[i + 1], v[i + 2] = most * e0, most * e1, most * e2
            if most > 0.0:
                longer = a[i] * e0 + a[i + 1] * e1 + a[i + 2] * e2
                bent[k, SLIDES], lost = 1.0, max(longer, 0.0)
                a[i] -= lost * e0
                a[i + 1] -= lost * e1
                a[i + 2] -= lost * e2
