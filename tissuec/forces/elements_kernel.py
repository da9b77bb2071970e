"""The forces of solid elements as scalar loops; for the equations see ``forces.elements``."""

from ctypes import CFUNCTYPE, c_double, c_int
from math import exp, sqrt
from typing import NamedTuple

from tissuec.kernels.records import Floats, IntegerRows, Integers, Rows, Stack

#: Ratio of volumes below which the isochoric energy is continued by a parabola, so that it has
#: a value where an element is inverted, and grows.
LEAST = 0.2
#: Numbers of the state at a point: F, its cofactors, J, I1, P, g, g', and what of P makes an
#: element yield.
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
    viscosity: Floats  # [Pa s], shape (element,)
    law: Integers  # shape (element,)
    fibres: Stack  # unit vectors as drawn, shape (element, family, 3)
    fibre_stiffness: Floats  # k1 [Pa], shape (element,)
    fibre_stiffening: Floats  # k2, shape (element,)
    dispersion: Floats  # κ, shape (element,)
    first: Integers  # branches of element e are first[e]:first[e + 1], shape (element + 1,)
    branch_shear: Floats  # μk [Pa], shape (branch,)
    branch_pace: Floats  # 1 / τ [1/s], shape (branch,)
    branch_slot: Integers  # where the first number of a branch is among velocities, (branch,)
    branch_rate: Floats  # of Ci - 1 in these [m/s], shape (branch,)
    is_yielding: bool  # whether any element yields; without, the following are empty
    yield_slot: Integers  # where the first number of Cp is; -1 in elements that do not yield
    yield_rate: Floats  # of Cp - 1 there [m/s], shape (element,)
    yield_stress: Floats  # Y [Pa], shape (element,)
    yield_pace: Floats  # 1 / η [1/(Pa s)], shape (element,)
    is_curved: bool  # whether any law is not neo-Hookean
    is_viscous: bool
    by_first: int  # address of the slope of laws by the first invariant
    by_second: int  # by the second one
    points: Rows  # scratch: the state at each point, shape (point, STATE)
    own: Rows  # scratch: positions, velocities and forces of the nodes, shape (3, 3 node)


def call_law(address: int, law: int, i1: float, i2: float) -> float:
    """Return a function of the invariants at an address; compiled code calls it directly.

    Args:
        address: Of the function.
        law: Index of the law.
        i1, i2: Isochoric invariants.
    """
    return float(CFUNCTYPE(c_double, c_int, c_double, c_double)(address)(law, i1, i2))


def press_elements(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, solid: ElementTable
) -> None:
    """Add the forces of elements to those on nodes, and the power that they dissipate.

    The rates of hidden nodes are added as forces on them.
    """
    at, flow, push = solid.own[0], solid.own[1], solid.own[2]
    for e in range(solid.nodes.shape[0]):
        row, yields = solid.row[e], solid.is_yielding and solid.yield_slot[e] >= 0
        for a in range(solid.nodes.shape[1]):
            i = 3 * solid.nodes[e, a]
            for k in range(3):
                at[3 * a + k] = x[i + k]
                push[3 * a + k] = 0.0
                if solid.is_viscous:
                    flow[3 * a + k] = v[i + k]
        total = volume = 0.0
        for q in range(solid.points.shape[0]):
            weight = solid.weight[row, q]
            volume += weight
            total += weight * deform(at, solid.gradients[row, q], solid.points[q])
        swell = solid.bulk[e] * (total / volume - 1.0)
        for q in range(solid.points.shape[0]):
            slopes, here, weight = (
                solid.gradients[row, q],
                solid.points[q],
                solid.weight[row, q],
            )
            pressure = swell + solid.local[e] * (here[18] - 1.0)
            if yields:
                bear(e, pressure, q, v, here, solid)
            else:
                stress(e, pressure, here, solid)
            for family in range(solid.fibres.shape[1]):
                stretch(e, solid.fibres[e, family], here, solid)
            if solid.is_viscous:
                power[1] += weight * resist(solid.viscosity[e], flow, slopes, here)
            if yields:
                set_apart(here)
            for branch in range(solid.first[e], solid.first[e + 1]):
                power[1] += weight * relax(branch, q, v, f, here, solid)
            if yields:
                power[1] += weight * give_way(e, q, v, f, here, solid)
            pull(-weight, slopes, here, push)
        for a in range(solid.nodes.shape[1]):
            i = 3 * solid.nodes[e, a]
            for k in range(3):
                f[i + k] += push[3 * a + k]


def pull(weight: float, slopes: Floats, here: Floats, push: Floats) -> None:
    """Add a multiple of P ∂N/∂X at a point to the forces on the nodes of an element.

    Args:
        weight: The factor [m³].
        slopes: ∂N/∂X there [1/m], flat, shape (3 node,).
        here: The state there; see ``deform``.
        push: Forces [N], flat, shape (3 node,).
    """
    p0, p1, p2 = weight * here[20], weight * here[21], weight * here[22]
    p3, p4, p5 = weight * here[23], weight * here[24], weight * here[25]
    p6, p7, p8 = weight * here[26], weight * here[27], weight * here[28]
    for a in range(slopes.size // 3):
        n0, n1, n2 = slopes[3 * a], slopes[3 * a + 1], slopes[3 * a + 2]
        push[3 * a] += p0 * n0 + p1 * n1 + p2 * n2
        push[3 * a + 1] += p3 * n0 + p4 * n1 + p5 * n2
        push[3 * a + 2] += p6 * n0 + p7 * n1 + p8 * n2


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


def resist(viscosity: float, flow: Floats, slopes: Floats, here: Floats) -> float:
    """Add the viscous part of P at a point; return the power that it dissipates [W/m³].

    Args:
        viscosity: [Pa s].
        flow: Velocities of the nodes [m/s], flat, shape (3 node,).
        slopes: ∂N/∂X there [1/m], flat, shape (3 node,).
        here: The state there; see ``deform``.
    """
    d0 = d1 = d2 = d3 = d4 = d5 = d6 = d7 = d8 = 0.0
    for a in range(slopes.size // 3):
        n0, n1, n2 = slopes[3 * a], slopes[3 * a + 1], slopes[3 * a + 2]
        v0, v1, v2 = flow[3 * a], flow[3 * a + 1], flow[3 * a + 2]
        d0, d1, d2 = d0 + v0 * n0, d1 + v0 * n1, d2 + v0 * n2
        d3, d4, d5 = d3 + v1 * n0, d4 + v1 * n1, d5 + v1 * n2
        d6, d7, d8 = d6 + v2 * n0, d7 + v2 * n1, d8 + v2 * n2
    c0, c1, c2, c3, c4 = here[9], here[10], here[11], here[12], here[13]
    c5, c6, c7, c8 = here[14], here[15], here[16], here[17]
    # The symmetric part of Ḟ cof Fᵀ without its trace: J times the rate of strain.
    e0, e4 = d0 * c0 + d1 * c1 + d2 * c2, d3 * c3 + d4 * c4 + d5 * c5
    e8 = d6 * c6 + d7 * c7 + d8 * c8
    e1 = 0.5 * (d0 * c3 + d1 * c4 + d2 * c5 + d3 * c0 + d4 * c1 + d5 * c2)
    e2 = 0.5 * (d0 * c6 + d1 * c7 + d2 * c8 + d6 * c0 + d7 * c1 + d8 * c2)
    e5 = 0.5 * (d3 * c6 + d4 * c7 + d5 * c8 + d6 * c3 + d7 * c4 + d8 * c5)
    third = (e0 + e4 + e8) / 3.0
    e0, e4, e8 = e0 - third, e4 - third, e8 - third
    thick = 2.0 * viscosity / max(here[18], LEAST)
    for k in range(3):
        here[20 + k] += thick * (e0 * here[9 + k] + e1 * here[12 + k] + e2 * here[15 + k])
        here[23 + k] += thick * (e1 * here[9 + k] + e4 * here[12 + k] + e5 * here[15 + k])
        here[26 + k] += thick * (e2 * here[9 + k] + e5 * here[12 + k] + e8 * here[15 + k])
    square = e0 * e0 + e4 * e4 + e8 * e8 + 2.0 * (e1 * e1 + e2 * e2 + e5 * e5)
    return float(thick * square)


def relax(
    branch: int, point: int, v: Floats, f: Floats, here: Floats, solid: ElementTable
) -> float:
    """Add what a branch adds to P at a point, and the rate at which it gives way there.

    Args:
        branch: Its number.
        point: Number of the point.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep Ci - 1.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
        here: The state there; see ``deform``.

    Returns:
        The power that it dissipates [W/m³].
    """
    i = solid.branch_slot[branch] + 6 * point
    rate, shear = solid.branch_rate[branch], solid.branch_shear[branch]
    pace, scale = solid.branch_pace[branch], 1.0 / rate
    # Ci by its components 00, 11, 22, 12, 02, 01, and its inverse of unit volume.
    c0, c1, c2 = 1.0 + scale * v[i], 1.0 + scale * v[i + 1], 1.0 + scale * v[i + 2]
    c3, c4, c5 = scale * v[i + 3], scale * v[i + 4], scale * v[i + 5]
    u, a0, a1, a2, a3, a4, a5 = unimodular_inverse(c0, c1, c2, c3, c4, c5)
    f0, f1, f2, f3, f4 = here[0], here[1], here[2], here[3], here[4]
    f5, f6, f7, f8, g = here[5], here[6], here[7], here[8], here[29]
    # C' likewise, and X = C' A.
    b0, b1 = g * (f0 * f0 + f3 * f3 + f6 * f6), g * (f1 * f1 + f4 * f4 + f7 * f7)
    b2, b3 = g * (f2 * f2 + f5 * f5 + f8 * f8), g * (f1 * f2 + f4 * f5 + f7 * f8)
    b4, b5 = g * (f0 * f2 + f3 * f5 + f6 * f8), g * (f0 * f1 + f3 * f4 + f6 * f7)
    x0, x1 = b0 * a0 + b5 * a5 + b4 * a4, b0 * a5 + b5 * a1 + b4 * a3
    x2, x3 = b0 * a4 + b5 * a3 + b4 * a2, b5 * a0 + b1 * a5 + b3 * a4
    x4, x5 = b5 * a5 + b1 * a1 + b3 * a3, b5 * a4 + b1 * a3 + b3 * a2
    x6, x7 = b4 * a0 + b3 * a5 + b2 * a4, b4 * a5 + b3 * a1 + b2 * a3
    x8 = b4 * a4 + b3 * a3 + b2 * a2
    trace = x0 + x4 + x8
    third, s, t = trace / 3.0, shear * g, 0.5 * shear * here[30] * trace / g
    for k in range(3):
        p, q, r = here[3 * k], here[3 * k + 1], here[3 * k + 2]
        here[20 + 3 * k] += s * (p * a0 + q * a5 + r * a4) + t * here[9 + 3 * k]
        here[21 + 3 * k] += s * (p * a5 + q * a1 + r * a3) + t * here[10 + 3 * k]
        here[22 + 3 * k] += s * (p * a4 + q * a3 + r * a2) + t * here[11 + 3 * k]
    give = rate * pace
    f[i] += give * (b0 - third * c0)
    f[i + 1] += give * (b1 - third * c1)
    f[i + 2] += give * (b2 - third * c2)
    f[i + 3] += give * (b3 - third * c3)
    f[i + 4] += give * (b4 - third * c4)
    f[i + 5] += give * (b5 - third * c5)
    x0, x4, x8 = x0 - third, x4 - third, x8 - third
    square = x0 * x0 + x4 * x4 + x8 * x8 + 2.0 * (x1 * x3 + x2 * x6 + x5 * x7)
    return float(0.5 * shear * pace * sqrt(u) * square)


def set_apart(here: Floats) -> None:
    """Subtract P from that of the law alone, before branches add to P.

    Args:
        here: The state at a point [Pa], shape (STATE,); see ``deform``.
    """
    for k in range(9):
        here[31 + k] -= here[20 + k]


def give_way(
    e: int, point: int, v: Floats, f: Floats, here: Floats, solid: ElementTable
) -> float:
    """Add the rates of plastic flow of an element, and those of its branches.

    Args:
        e: Number of the element.
        point: Number of the point.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep Cp - 1 and Ci - 1.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
        here: The state there; see ``deform``. Of what is set apart, P makes P of law and
            branches, neither fibres nor viscosity.

    Returns:
        The power that it dissipates [W/m³].
    """
    for k in range(9):
        here[31 + k] += here[20 + k]
    # Pᵀ F, whose deviator is N.
    n0 = here[31] * here[0] + here[34] * here[3] + here[37] * here[6]
    n1 = here[31] * here[1] + here[34] * here[4] + here[37] * here[7]
    n2 = here[31] * here[2] + here[34] * here[5] + here[37] * here[8]
    n3 = here[32] * here[0] + here[35] * here[3] + here[38] * here[6]
    n4 = here[32] * here[1] + here[35] * here[4] + here[38] * here[7]
    n5 = here[32] * here[2] + here[35] * here[5] + here[38] * here[8]
    n6 = here[33] * here[0] + here[36] * here[3] + here[39] * here[6]
    n7 = here[33] * here[1] + here[36] * here[4] + here[39] * here[7]
    n8 = here[33] * here[2] + here[36] * here[5] + here[39] * here[8]
    third = (n0 + n4 + n8) / 3.0
    n0, n4, n8 = n0 - third, n4 - third, n8 - third
    square = n0 * n0 + n4 * n4 + n8 * n8 + 2.0 * (n1 * n3 + n2 * n6 + n5 * n7)
    size = sqrt(1.5 * max(square, 0.0))
    if not size > solid.yield_stress[e]:
        return 0.0
    pace = 1.5 * solid.yield_pace[e] * (size - solid.yield_stress[e]) / size
    flow = (n0, n1, n2, n3, n4, n5, n6, n7, n8)
    i = solid.yield_slot[e] + 6 * point
    carry(i, pace, solid.yield_rate[e], flow, v, f)
    for branch in range(solid.first[e], solid.first[e + 1]):
        k = solid.branch_slot[branch] + 6 * point
        carry(k, pace, solid.branch_rate[branch], flow, v, f)
    return float(pace * square)


def bear(
    e: int, pressure: float, point: int, v: Floats, here: Floats, solid: ElementTable
) -> None:
    """Set P of the law of an element that yields.

    Args:
        e: Number of the element.
        pressure: Derivative of the volumetric energy by J [Pa].
        point: Number of the point.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep Cp - 1.
        here: The state there; see ``deform``. A copy of P follows it, to be set apart.
    """
    i, s = solid.yield_slot[e] + 6 * point, 1.0 / solid.yield_rate[e]
    c0, c1, c2 = 1.0 + s * v[i], 1.0 + s * v[i + 1], 1.0 + s * v[i + 2]
    c3, c4, c5 = s * v[i + 3], s * v[i + 4], s * v[i + 5]
    # A as in ``unimodular_inverse``.
    a0, a1, a2 = c1 * c2 - c3 * c3, c0 * c2 - c4 * c4, c0 * c1 - c5 * c5
    a3, a4, a5 = c4 * c5 - c0 * c3, c3 * c5 - c1 * c4, c3 * c4 - c2 * c5
    u, _ = isochoric(c0 * a0 + c5 * a5 + c4 * a4)
    a0, a1, a2, a3, a4, a5 = u * a0, u * a1, u * a2, u * a3, u * a4, u * a5
    for k in range(3):
        p, q, r = here[3 * k], here[3 * k + 1], here[3 * k + 2]
        here[20 + 3 * k] = p * a0 + q * a5 + r * a4
        here[21 + 3 * k] = p * a5 + q * a1 + r * a3
        here[22 + 3 * k] = p * a4 + q * a3 + r * a2
    # F A Fᵀ, whose invariants are those of what is elastic.
    b0 = here[20] * here[0] + here[21] * here[1] + here[22] * here[2]
    b1 = here[20] * here[3] + here[21] * here[4] + here[22] * here[5]
    b2 = here[20] * here[6] + here[21] * here[7] + here[22] * here[8]
    b4 = here[23] * here[3] + here[24] * here[4] + here[25] * here[5]
    b5 = here[23] * here[6] + here[24] * here[7] + here[25] * here[8]
    b8 = here[26] * here[6] + here[27] * here[7] + here[28] * here[8]
    i1 = b0 + b4 + b8
    i2 = b0 * b4 + b4 * b8 + b8 * b0 - b1 * b1 - b2 * b2 - b5 * b5
    g, by_j = isochoric(here[18])
    here[29], here[30] = g, by_j
    first, second, shear = 0.5, 0.0, solid.shear[e]
    if solid.is_curved and solid.law[e] > 0:
        first = call_law(solid.by_first, solid.law[e], g * i1, g * g * i2)
        second = call_law(solid.by_second, solid.law[e], g * i1, g * g * i2)
    s = shear * (2.0 * g * first + 2.0 * g * g * second * i1)
    t = shear * by_j * (first * i1 + 2.0 * g * second * i2) + pressure
    u = -2.0 * shear * g * g * second
    for k in range(3):
        p, q, r = here[20 + k], here[23 + k], here[26 + k]
        here[20 + k] = (s + u * b0) * p + u * (b1 * q + b2 * r) + t * here[9 + k]
        here[23 + k] = (s + u * b4) * q + u * (b1 * p + b5 * r) + t * here[12 + k]
        here[26 + k] = (s + u * b8) * r + u * (b2 * p + b5 * q) + t * here[15 + k]
    for k in range(9):
        here[31 + k] = here[20 + k]


def carry(
    i: int,
    pace: float,
    rate: float,
    flow: tuple[float, float, float, float, float, float, float, float, float],
    v: Floats,
    f: Floats,
) -> None:
    """Add λ (T N + Nᵀ T) to the rates of a tensor T that plastic flow carries along.

    Args:
        i: Where the first number of T - 1 is among velocities.
        pace: λ [1/(Pa s)].
        rate: Of T - 1 there [m/s].
        flow: N, row by row [Pa].
        v: Velocities of all nodes [m/s], flat.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
    """
    n0, n1, n2, n3, n4, n5, n6, n7, n8 = flow
    scale, give = 1.0 / rate, rate * pace
    c0, c1, c2 = 1.0 + scale * v[i], 1.0 + scale * v[i + 1], 1.0 + scale * v[i + 2]
    c3, c4, c5 = scale * v[i + 3], scale * v[i + 4], scale * v[i + 5]
    f[i] += 2.0 * give * (c0 * n0 + c5 * n3 + c4 * n6)
    f[i + 1] += 2.0 * give * (c5 * n1 + c1 * n4 + c3 * n7)
    f[i + 2] += 2.0 * give * (c4 * n2 + c3 * n5 + c2 * n8)
    f[i + 3] += give * (c5 * n2 + c1 * n5 + c3 * n8 + c4 * n1 + c3 * n4 + c2 * n7)
    f[i + 4] += give * (c0 * n2 + c5 * n5 + c4 * n8 + c4 * n0 + c3 * n3 + c2 * n6)
    f[i + 5] += give * (c0 * n1 + c5 * n4 + c4 * n7 + c5 * n0 + c1 * n3 + c3 * n6)


def unimodular_inverse(
    c0: float, c1: float, c2: float, c3: float, c4: float, c5: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return det(c)^(-2/3), and the components of det(c)^(1/3) c⁻¹.

    Args:
        c0, c1, c2, c3, c4, c5: Components 00, 11, 22, 12, 02, 01 of a symmetric tensor c,
            dimensionless.
    """
    a0, a1, a2 = c1 * c2 - c3 * c3, c0 * c2 - c4 * c4, c0 * c1 - c5 * c5
    a3, a4, a5 = c4 * c5 - c0 * c3, c3 * c5 - c1 * c4, c3 * c4 - c2 * c5
    u, _ = isochoric(c0 * a0 + c5 * a5 + c4 * a4)
    return u, u * a0, u * a1, u * a2, u * a3, u * a4, u * a5


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
