"""The stress of solid elements at a point, for their limits; see ``solids.elements``."""

from ctypes import CFUNCTYPE, c_double, c_int
from math import exp
from typing import NamedTuple

from tissuec.kernels.records import Floats, IntegerRows, Integers, Rows, Stack

#: Ratio of volumes below which the isochoric energy is continued by a parabola, so that it has
#: a value where an element is inverted, and grows.
LEAST = 0.2
#: Numbers of the state at a point: F, its cofactors, J, I1, P, g and g'; the rest is unused.
STATE = 40
_LARGEST = 4.0  # up to which the iteration for a root converges


class ElementTable(NamedTuple):
    """SolidElements of one shape as the kernel reads them."""

    nodes: IntegerRows  # shape (element, node)
    row: Integers  # of their gradients, shape (element,)
    gradients: Stack  # ∂N/∂X by node and component [1/m], shape (row, point, 3 node)
    weight: Rows  # volume of each point [m³], shape (row, point)
    shear: Floats  # [Pa], shape (element,)
    bulk: Floats  # that acts on the volume of the element [Pa], shape (element,)
    local: Floats  # that acts at points [Pa], shape (element,)
    law: Integers  # shape (element,)
    fibres: Stack  # unit vectors as drawn, shape (element, family, 3)
    fibre_stiffness: Floats  # k1 [Pa], shape (element,)
    fibre_stiffening: Floats  # k2, shape (element,)
    dispersion: Floats  # κ, shape (element,)
    is_curved: bool  # whether any law is not neo-Hookean
    by_first: int  # address of the slope of laws by the first invariant
    by_second: int  # by the second one
    points: Rows  # scratch: the state at each point, shape (point, STATE)
    own: Rows  # scratch: positions of the nodes in the first row, shape (3, 3 node)


def call_law(address: int, law: int, i1: float, i2: float) -> float:
    """Return a function of the invariants at an address; compiled code calls it directly.

    Args:
        address: Of the function.
        law: Index of the law.
        i1, i2: Isochoric invariants.
    """
    return float(CFUNCTYPE(c_double, c_int, c_double, c_double)(address)(law, i1, i2))


def stress(e: int, pressure: float, here: Floats, solid: ElementTable) -> None:
    """Set P of an element at a point.

    Args:
        e: Number of the element.
        pressure: Derivative of the volumetric energy by J [Pa].
        here: The state there, shape (STATE,); see ``deform``.
    """
    shear, j, i1 = solid.shear[e], here[18], here[19]
    g, by_j = isochoric(j)
    here[29], here[30] = g, by_j
    first, second, i2 = 0.5, 0.0, 0.0
    if solid.is_curved and solid.law[e] > 0:
        for k in range(9, 18):
            i2 += here[k] * here[k]
        first = call_law(solid.by_first, solid.law[e], g * i1, g * g * i2)
        second = call_law(solid.by_second, solid.law[e], g * i1, g * g * i2)
    s = shear * (2.0 * g * first + 2.0 * g * g * second * i1)
    t = shear * by_j * (first * i1 + 2.0 * g * second * i2) + pressure
    for k in range(9):
        here[20 + k] = s * here[k] + t * here[9 + k]
    if second != 0.0:
        f0, f1, f2, f3, f4 = here[0], here[1], here[2], here[3], here[4]
        f5, f6, f7, f8 = here[5], here[6], here[7], here[8]
        u = -2.0 * shear * g * g * second
        b0, b1 = u * (f0 * f0 + f1 * f1 + f2 * f2), u * (f0 * f3 + f1 * f4 + f2 * f5)
        b2, b4 = u * (f0 * f6 + f1 * f7 + f2 * f8), u * (f3 * f3 + f4 * f4 + f5 * f5)
        b5, b8 = u * (f3 * f6 + f4 * f7 + f5 * f8), u * (f6 * f6 + f7 * f7 + f8 * f8)
        for k in range(3):
            here[20 + k] += b0 * here[k] + b1 * here[3 + k] + b2 * here[6 + k]
            here[23 + k] += b1 * here[k] + b4 * here[3 + k] + b5 * here[6 + k]
            here[26 + k] += b2 * here[k] + b5 * here[3 + k] + b8 * here[6 + k]


def stretch(e: int, along: Floats, here: Floats, solid: ElementTable) -> None:
    """Add what a family of fibres that is under tension adds to P at a point.

    Args:
        e: Number of the element.
        along: Unit vector of the fibres as drawn, dimensionless, shape (3,).
        here: The state there; see ``deform``.
    """
    a0, a1, a2, spread = along[0], along[1], along[2], solid.dispersion[e]
    b0 = here[0] * a0 + here[1] * a1 + here[2] * a2
    b1 = here[3] * a0 + here[4] * a1 + here[5] * a2
    b2 = here[6] * a0 + here[7] * a1 + here[8] * a2
    g, by_j = here[29], here[30]
    strain = spread * (g * here[19] - 3.0)
    strain += (1.0 - 3.0 * spread) * (b0 * b0 + b1 * b1 + b2 * b2 - 1.0)
    if strain > 0.0:
        pull_along = solid.fibre_stiffness[e] * strain
        pull_along *= exp(solid.fibre_stiffening[e] * strain * strain)
        s, t = 2.0 * pull_along * spread * g, pull_along * spread * by_j * here[19]
        for k in range(9):
            here[20 + k] += s * here[k] + t * here[9 + k]
        pull_along *= 2.0 * (1.0 - 3.0 * spread)
        for k in range(3):
            here[20 + k] += pull_along * b0 * along[k]
            here[23 + k] += pull_along * b1 * along[k]
            here[26 + k] += pull_along * b2 * along[k]


def deform(at: Floats, slopes: Floats, place: Floats) -> float:
    """Set F, its cofactors, J and I1 = tr FᵀF at a point of an element; return J.

    Args:
        at: Positions of the nodes [m], flat, shape (3 node,).
        slopes: ∂N/∂X there [1/m], flat, shape (3 node,).
        place: Set, in this order; P, g and g' follow, shape (STATE,).
    """
    f0 = f1 = f2 = f3 = f4 = f5 = f6 = f7 = f8 = 0.0
    for a in range(at.size // 3):
        n0, n1, n2 = slopes[3 * a], slopes[3 * a + 1], slopes[3 * a + 2]
        x0, x1, x2 = at[3 * a], at[3 * a + 1], at[3 * a + 2]
        f0, f1, f2 = f0 + x0 * n0, f1 + x0 * n1, f2 + x0 * n2
        f3, f4, f5 = f3 + x1 * n0, f4 + x1 * n1, f5 + x1 * n2
        f6, f7, f8 = f6 + x2 * n0, f7 + x2 * n1, f8 + x2 * n2
    c0, c1, c2 = f4 * f8 - f5 * f7, f5 * f6 - f3 * f8, f3 * f7 - f4 * f6
    c3, c4, c5 = f2 * f7 - f1 * f8, f0 * f8 - f2 * f6, f1 * f6 - f0 * f7
    c6, c7, c8 = f1 * f5 - f2 * f4, f2 * f3 - f0 * f5, f0 * f4 - f1 * f3
    j = f0 * c0 + f1 * c1 + f2 * c2
    place[0], place[1], place[2], place[3], place[4] = f0, f1, f2, f3, f4
    place[5], place[6], place[7], place[8], place[9] = f5, f6, f7, f8, c0
    place[10], place[11], place[12], place[13], place[14] = c1, c2, c3, c4, c5
    place[15], place[16], place[17], place[18] = c6, c7, c8, j
    place[19] = (
        f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3 + f4 * f4 + f5 * f5 + f6 * f6 + f7 * f7 + f8 * f8
    )
    return j


def isochoric(j: float) -> tuple[float, float]:
    """Return g = J^(-2/3) and its derivative, continued by a parabola below ``LEAST``."""
    near = max(j, LEAST)
    if near > _LARGEST:
        root = near ** (-1.0 / 3.0)
    else:
        # A rational start is within 8 %; two rounds of fifth order leave rounding.
        root = (1.0 + (near - 1.0) / 3.0) / (1.0 + 2.0 * (near - 1.0) / 3.0)
        for _ in range(2):
            r = 1.0 - near * root * root * root
            root *= 1.0 + r * (
                1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0 + r * (35.0 / 243.0)))
            )
    slope = -2.0 / 3.0 * root * root / near
    bend, below = -5.0 / 3.0 * slope / near, j - near
    return root * root + below * (slope + 0.5 * bend * below), slope + bend * below
