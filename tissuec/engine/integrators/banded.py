"""The matrix of an implicit step as a Cholesky factor of narrow band.

S = M + q (D + drag) + q² K with q = h γ. Of a spring of direction n, K takes c n nᵀ and, where
it is under tension T, T/L (1 - n nᵀ); what pressed springs lose is left out: S is then positive
definite, and steps that it proposes lead downhill. Column j of the lower band is row j of
``band``, as LAPACK's dpbtrf keeps it; for the bands of tubes and sheets these loops take about
its time (0.7 to 1.7 of it for widths of 63 to 120), without a call through its interface.
"""

from math import sqrt

from tissuec.forces.springs.springs_kernel import resistance
from tissuec.kernels.records import Floats, Net, Solver
from tissuec.kernels.vectors import TINY


def assemble(q: float, x: Floats, v: Floats, net: Net, solver: Solver) -> bool:
    """Set S and its factor at a state; return False if S is not positive definite."""
    fill(q, x, v, net, solver)
    return factorise(solver.band)


def fill(q: float, x: Floats, v: Floats, net: Net, solver: Solver) -> None:
    """Set the band of S."""
    band, slot = solver.band, solver.slot
    for i in range(band.shape[0]):
        for j in range(band.shape[1]):
            band[i, j] = 0.0
    for node in range(slot.size):
        if slot[node] >= 0:
            mass = 1.0 / net.inverse_mass[node] + q * net.drag[node]
            for k in range(3):
                band[3 * slot[node] + k, 0] = mass
    for node in range(net.first.size - 1):
        for s in range(net.first[node], net.first[node + 1]):
            other = net.other[s] // 3
            here, there = slot[node], slot[other]
            if here < 0 and there < 0:
                continue
            i, j = 3 * node, 3 * other
            r = (x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2])
            length = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
            inverse = 1.0 / (length + TINY)
            along = q * net.damping[s] + q * q * net.stiffness[s]
            across = q * q * net.stiffness[s] * max(1.0 - net.rest[s] * inverse, 0.0)
            if net.law[s] > 0:
                along, across = resistance(q, s, i, j, length, x, v, net)
            for a in range(3):
                for b in range(3):
                    value = (along - across) * r[a] * r[b] * inverse * inverse
                    if a == b:
                        value += across
                    if a >= b:
                        if here >= 0:
                            band[3 * here + b, a - b] += value
                        if there >= 0:
                            band[3 * there + b, a - b] += value
                    if here >= 0 and there >= 0:
                        low, high = min(here, there), max(here, there)
                        band[3 * low + b, 3 * (high - low) + a - b] -= value


def factorise(band: Floats) -> bool:
    """Replace a matrix by its Cholesky factor; return False if it is not positive definite.

    Args:
        band: Rows of the lower band of S [kg], shape (3 free, width + 1).
    """
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(size):
        if not band[j, 0] > 0.0:
            return False
        pivot = sqrt(band[j, 0])
        band[j, 0] = pivot
        reach = min(width, size - 1 - j)
        column = band[j, 1 : reach + 1]
        for i in range(reach):
            column[i] /= pivot
        for i in range(reach):
            factor = column[i]
            if factor != 0.0:
                source, target = column[i:reach], band[j + 1 + i, : reach - i]
                for k in range(source.size):
                    target[k] -= factor * source[k]
    return True


def solve(vector: Floats, net: Net, solver: Solver) -> bool:
    """Replace residuals of accelerations r by S⁻¹ M r; held nodes get zero."""
    unknown, slot = solver.unknown, solver.slot
    for node in range(slot.size):
        if slot[node] >= 0:
            for k in range(3):
                unknown[3 * slot[node] + k] = vector[3 * node + k] / net.inverse_mass[node]
    substitute(solver.band, unknown)
    for node in range(slot.size):
        for k in range(3):
            inside = slot[node] >= 0
            vector[3 * node + k] = unknown[3 * slot[node] + k] if inside else 0.0
    return True


def substitute(band: Floats, unknown: Floats) -> None:
    """Solve with the factor, forwards and backwards.

    Args:
        band: The factor [kg^½], shape (3 free, width + 1).
        unknown: Right-hand side [N], replaced by the solution [m/s²], shape (3 free,).
    """
    size, width = band.shape[0], band.shape[1] - 1
    for j in range(size):
        reach = min(width, size - 1 - j)
        unknown[j] /= band[j, 0]
        value = unknown[j]
        column, below = band[j, 1 : reach + 1], unknown[j + 1 : j + 1 + reach]
        for i in range(reach):
            below[i] -= value * column[i]
    for j in range(size - 1, -1, -1):
        reach = min(width, size - 1 - j)
        column, below = band[j, 1 : reach + 1], unknown[j + 1 : j + 1 + reach]
        # Four sums at a time, because the next addition must wait for the last.
        one = two = three = four = 0.0
        whole = reach - reach % 4
        for i in range(0, whole, 4):
            one += column[i] * below[i]
            two += column[i + 1] * below[i + 1]
            three += column[i + 2] * below[i + 2]
            four += column[i + 3] * below[i + 3]
        for i in range(whole, reach):
            one += column[i] * below[i]
        unknown[j] = (unknown[j] - ((one + two) + (three + four))) / band[j, 0]
