"""The pressure of enclosed volumes, as scalar loops; what it is stands in ``enclosures``."""

from tissuec.kernels.acts import total
from tissuec.kernels.records import Acts, Enclosures, Floats


def press(time: float, x: Floats, f: Floats, acts: Acts, enclosures: Enclosures) -> float:
    """Add the forces of enclosed volumes to those on nodes; return the power of pumps [W]."""
    power = 0.0
    corners = enclosures.corners
    for cell in range(enclosures.drawn.size):
        start, stop = enclosures.first[cell], enclosures.first[cell + 1]
        o = 3 * corners[start, 0]
        volume = 0.0
        for triangle in range(start, stop):
            i, j, k = (
                3 * corners[triangle, 0],
                3 * corners[triangle, 1],
                3 * corners[triangle, 2],
            )
            a0, a1, a2 = x[i] - x[o], x[i + 1] - x[o + 1], x[i + 2] - x[o + 2]
            b0, b1, b2 = x[j] - x[o], x[j + 1] - x[o + 1], x[j + 2] - x[o + 2]
            c0, c1, c2 = x[k] - x[o], x[k + 1] - x[o + 1], x[k + 2] - x[o + 2]
            volume += a0 * (b1 * c2 - b2 * c1)
            volume += a1 * (b2 * c0 - b0 * c2)
            volume += a2 * (b0 * c1 - b1 * c0)
        drawn = enclosures.drawn[cell]
        swell, _, _, rate, _, _ = total(enclosures.act[cell], time, acts)
        due = drawn * (1.0 + swell)
        pressure = enclosures.modulus[cell] * (due - volume / 6.0) / drawn
        power += pressure * drawn * rate
        share = pressure / 6.0
        for triangle in range(start, stop):
            for corner in range(3):
                i = 3 * corners[triangle, corner]
                j = 3 * corners[triangle, (corner + 1) % 3]
                k = 3 * corners[triangle, (corner + 2) % 3]
                b0, b1, b2 = x[j] - x[o], x[j + 1] - x[o + 1], x[j + 2] - x[o + 2]
                c0, c1, c2 = x[k] - x[o], x[k + 1] - x[o + 1], x[k + 2] - x[o + 2]
                f[i] += share * (b1 * c2 - b2 * c1)
                f[i + 1] += share * (b2 * c0 - b0 * c2)
                f[i + 2] += share * (b0 * c1 - b1 * c0)
    return power
