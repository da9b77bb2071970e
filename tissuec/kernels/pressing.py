"""The pressure of enclosed volumes, as scalar loops; what it is stands in ``enclosures``."""

from tissuec.kernels.acts import total
from tissuec.kernels.records import Floats, Net


def press(time: float, x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> None:
    """Add the forces of enclosed volumes to those on nodes, and the power of pumps."""
    acts, enclosures = net.acts, net.enclosures
    corners = enclosures.corners
    for cell in range(enclosures.drawn.size):
        start, stop = enclosures.first[cell], enclosures.first[cell + 1]
        o = 3 * corners[start, 0]
        z0, z1, z2 = x[o], x[o + 1], x[o + 2]
        volume = 0.0
        for face in range(start, stop):
            i, j = 3 * corners[face, 0], 3 * corners[face, 1]
            k, m = 3 * corners[face, 2], 3 * corners[face, 3]
            s0 = (x[i] - z0) + (x[j] - z0) + (x[k] - z0) + (x[m] - z0)
            s1 = (x[i + 1] - z1) + (x[j + 1] - z1) + (x[k + 1] - z1) + (x[m + 1] - z1)
            s2 = (x[i + 2] - z2) + (x[j + 2] - z2) + (x[k + 2] - z2) + (x[m + 2] - z2)
            p0, p1, p2 = x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2]
            q0, q1, q2 = x[m] - x[j], x[m + 1] - x[j + 1], x[m + 2] - x[j + 2]
            volume += s0 * (p1 * q2 - p2 * q1)
            volume += s1 * (p2 * q0 - p0 * q2)
            volume += s2 * (p0 * q1 - p1 * q0)
        drawn = enclosures.drawn[cell]
        swell, _, _, rate, _, _ = total(enclosures.act[cell], time, acts)
        due = drawn * (1.0 + swell)
        pressure = enclosures.modulus[cell] * (due - volume / 24.0) / drawn
        power[0] += pressure * drawn * rate
        share = pressure / 24.0
        for face in range(start, stop):
            i, j = 3 * corners[face, 0], 3 * corners[face, 1]
            k, m = 3 * corners[face, 2], 3 * corners[face, 3]
            s0 = (x[i] - z0) + (x[j] - z0) + (x[k] - z0) + (x[m] - z0)
            s1 = (x[i + 1] - z1) + (x[j + 1] - z1) + (x[k + 1] - z1) + (x[m + 1] - z1)
            s2 = (x[i + 2] - z2) + (x[j + 2] - z2) + (x[k + 2] - z2) + (x[m + 2] - z2)
            p0, p1, p2 = x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2]
            q0, q1, q2 = x[m] - x[j], x[m + 1] - x[j + 1], x[m + 2] - x[j + 2]
            # By the sum of the corners, and by one diagonal and the other.
            a0, a1, a2 = p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0
            b0, b1, b2 = q1 * s2 - q2 * s1, q2 * s0 - q0 * s2, q0 * s1 - q1 * s0
            c0, c1, c2 = s1 * p2 - s2 * p1, s2 * p0 - s0 * p2, s0 * p1 - s1 * p0
            f[i] += share * (a0 - b0)
            f[i + 1] += share * (a1 - b1)
            f[i + 2] += share * (a2 - b2)
            f[j] += share * (a0 - c0)
            f[j + 1] += share * (a1 - c1)
            f[j + 2] += share * (a2 - c2)
            f[k] += share * (a0 + b0)
            f[k + 1] += share * (a1 + b1)
            f[k + 2] += share * (a2 + b2)
            f[m] += share * (a0 + c0)
            f[m + 1] += share * (a1 + c1)
            f[m + 2] += share * (a2 + c2)
