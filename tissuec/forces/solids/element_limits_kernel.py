"""How near elements are to breaking, as scalar loops; see ``solids.element_limits``."""

from math import exp, sqrt
from typing import NamedTuple

from tissuec.forces.solids.elements_kernel import (
    ElementTable,
    call_law,
    deform,
    isochoric,
    stress,
    stretch,
)
from tissuec.kernels.records import Floats, Rows

NONE = 1e300  # limits that are larger are none
_SWEEPS = 8  # of rotations; four leave rounding
_SMALL = 1e-2  # exponents whose exponential is summed up as a series


class LimitTable(NamedTuple):
    """Elements that can break as the kernel reads them; a limit that one lacks is infinite."""

    strain: Floats  # shape (element,)
    stress: Floats  # [Pa], shape (element,)
    energy: Floats  # [J], shape (element,)
    energies: int  # address of the energies of laws; 0 where no energy breaks elements
    solid: ElementTable
    mean: Rows  # mean of ∂N/∂X by node and component [1/m], shape (row, 3 node)
    here: Floats  # scratch: as a row of ``ElementTable.points``


def burden_elements(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, limits: LimitTable
) -> None:
    """Set the load of each element, divided by its limit.

    Args:
        f: Set, dimensionless, shape (element,).
        limits: The elements.
    """
    solid, here = limits.solid, limits.here
    at = solid.own[0]
    for e in range(solid.nodes.shape[0]):
        for a in range(solid.nodes.shape[1]):
            i = 3 * solid.nodes[e, a]
            for k in range(3):
                at[3 * a + k] = x[i + k]
        deform(at, limits.mean[solid.row[e]], here)
        widest = longest(here)
        f[e] = (widest - 1.0) / limits.strain[e]
        if limits.stress[e] < NONE or limits.energy[e] < NONE:
            pull, stored = loaded(e, at, limits)
            f[e] = max(f[e], max(pull / widest / limits.stress[e], stored / limits.energy[e]))


def longest(here: Floats) -> float:
    """Return the largest principal stretch.

    Args:
        here: F, dimensionless, shape (9,) or longer.
    """
    f0, f1, f2, f3, f4 = here[0], here[1], here[2], here[3], here[4]
    f5, f6, f7, f8 = here[5], here[6], here[7], here[8]
    return sqrt(
        greatest(
            f0 * f0 + f3 * f3 + f6 * f6,
            f1 * f1 + f4 * f4 + f7 * f7,
            f2 * f2 + f5 * f5 + f8 * f8,
            f0 * f1 + f3 * f4 + f6 * f7,
            f0 * f2 + f3 * f5 + f6 * f8,
            f1 * f2 + f4 * f5 + f7 * f8,
        )
    )


def loaded(e: int, at: Floats, limits: LimitTable) -> tuple[float, float]:
    """Return the largest principal Kirchhoff stress of an element [Pa], and its energy [J].

    Where no energy breaks it, that is not all of the energy.

    Args:
        e: Number of the element.
        at: Positions of its nodes [m], flat, shape (3 node,).
        limits: The elements.
    """
    solid = limits.solid
    row, volume, total = solid.row[e], 0.0, 0.0
    for q in range(solid.points.shape[0]):
        weight = solid.weight[row, q]
        volume += weight
        total += weight * deform(at, solid.gradients[row, q], solid.points[q])
    strain = total / volume - 1.0
    stored = 0.5 * solid.bulk[e] * volume * strain * strain
    a = b = c = p = q_ = r = 0.0
    for q in range(solid.points.shape[0]):
        weight, here = solid.weight[row, q], solid.points[q]
        j = here[18]
        if limits.energy[e] < NONE:
            stored += weight * stored_at(e, here, limits)
        stress(e, solid.bulk[e] * strain + solid.local[e] * (j - 1.0), here, solid)
        for family in range(solid.fibres.shape[1]):
            stretch(e, solid.fibres[e, family], here, solid)
        # P Fᵀ, which is symmetric.
        a += weight * (here[20] * here[0] + here[21] * here[1] + here[22] * here[2])
        b += weight * (here[23] * here[3] + here[24] * here[4] + here[25] * here[5])
        c += weight * (here[26] * here[6] + here[27] * here[7] + here[28] * here[8])
        p += weight * (here[20] * here[3] + here[21] * here[4] + here[22] * here[5])
        q_ += weight * (here[20] * here[6] + here[21] * here[7] + here[22] * here[8])
        r += weight * (here[23] * here[6] + here[24] * here[7] + here[25] * here[8])
    return greatest(a, b, c, p, q_, r) / volume, stored


def stored_at(e: int, here: Floats, limits: LimitTable) -> float:
    """Return the energy per volume at a point [J/m³], without that of the mean volume.

    Args:
        e: Number of the element.
        here: The state there; see ``elements_kernel.deform``, shape (STATE,).
        limits: The elements.
    """
    solid, j, i1 = limits.solid, here[18], here[19]
    g, _ = isochoric(j)
    if solid.is_curved and solid.law[e] > 0:
        i2 = 0.0
        for k in range(9, 18):
            i2 += here[k] * here[k]
        stored = solid.shear[e] * call_law(limits.energies, solid.law[e], g * i1, g * g * i2)
    else:
        stored = 0.5 * solid.shear[e] * (g * i1 - 3.0)
    stored += 0.5 * solid.local[e] * (j - 1.0) * (j - 1.0)
    spread = solid.dispersion[e]
    for family in range(solid.fibres.shape[1]):
        along = solid.fibres[e, family]
        square = 0.0
        for k in range(3):
            part = here[3 * k] * along[0] + here[3 * k + 1] * along[1]
            part += here[3 * k + 2] * along[2]
            square += part * part
        strain = spread * (g * i1 - 3.0) + (1.0 - 3.0 * spread) * (square - 1.0)
        if strain > 0.0:
            steep = solid.fibre_stiffening[e]
            power = steep * strain * strain
            stored += 0.5 * solid.fibre_stiffness[e] / steep * grown(power)
    return float(stored)


def grown(exponent: float) -> float:
    """Return exp(z) - 1, exact for small z, too."""
    if exponent > _SMALL:
        return exp(exponent) - 1.0
    series = 1.0 + exponent / 5.0 * (1.0 + exponent / 6.0 * (1.0 + exponent / 7.0))
    series = 1.0 + exponent / 3.0 * (1.0 + exponent / 4.0 * series)
    return exponent * (1.0 + exponent / 2.0 * series)


def greatest(a: float, b: float, c: float, p: float, q: float, r: float) -> float:
    """Return the largest eigenvalue of a symmetric matrix, by Jacobi's rotations.

    Unlike closed forms, they leave no more than rounding where eigenvalues are equal.

    Args:
        a, b, c: The diagonal, in any unit.
        p, q, r: Components of the first row and second column, of the first row and third
            column, and of the second row and third column.
    """
    for _ in range(_SWEEPS):
        size = max(abs(a), max(abs(b), abs(c)))
        if abs(p) + abs(q) + abs(r) <= 1e-17 * size:
            break
        a, b, p, q, r = turned(a, b, p, q, r)
        a, c, q, p, r = turned(a, c, q, p, r)
        b, c, r, p, q = turned(b, c, r, p, q)
    return max(a, max(b, c))


def turned(
    a: float, b: float, p: float, q: float, r: float
) -> tuple[float, float, float, float, float]:
    """Return a matrix after the rotation that makes one of its components zero.

    Args:
        a, b: Two of the diagonal.
        p: The component in the row of the one and the column of the other.
        q, r: The components that each of their rows has in the third column.

    Returns:
        What takes the places of the arguments.
    """
    if p == 0.0:
        return a, b, p, q, r
    half = 0.5 * (b - a) / p
    t = 1.0 / (abs(half) + sqrt(half * half + 1.0))
    t = -t if half < 0.0 else t
    cosine = 1.0 / sqrt(t * t + 1.0)
    sine = t * cosine
    return a - t * p, b + t * p, 0.0, cosine * q - sine * r, sine * q + cosine * r
