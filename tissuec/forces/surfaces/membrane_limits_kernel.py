"""How near triangles of walls are to breaking, as loops; see ``solids.element_limits``.

The stress is that of triangles that neither relax nor yield; see ``surfaces.membranes``.
"""

from math import exp, isfinite, sqrt
from typing import NamedTuple

from tissuec.forces.solids.element_limits_kernel import NONE, grown
from tissuec.forces.solids.elements_kernel import call_law
from tissuec.kernels.records import Floats, IntegerRows, Integers, Rows, Stack

#: Square of the ratio of areas below which its root is continued by a parabola, so that
#: triangles that are pressed flat have finite forces.
LEAST_SQUARE = 0.04
ROUNDS = 60  # of the iteration for the thickness, more than bisection needs
LONGEST = 1.0 / 3.0  # step of an iteration, in the logarithm of the root of J
CLOSE = 1e-8  # step after which an iteration of second order is at rounding
STATE = 7  # numbers of the state of a triangle


class MembraneTable(NamedTuple):
    """Membranes as the kernel reads them."""

    nodes: IntegerRows  # shape (triangle, 3)
    gradients: Rows  # ∂N/∂X by node and direction in the plane [1/m], shape (triangle, 6)
    weight: Floats  # volume [m³], shape (triangle,)
    shear: Floats  # [Pa], shape (triangle,)
    bulk: Floats  # [Pa], shape (triangle,)
    law: Integers  # shape (triangle,)
    fibres: Stack  # unit vectors in the plane as drawn, shape (triangle, family, 2)
    fibre_stiffness: Floats  # k1 [Pa], shape (triangle,)
    fibre_stiffening: Floats  # k2, shape (triangle,)
    dispersion: Floats  # κ, shape (triangle,)
    is_curved: bool  # whether any law is not neo-Hookean
    by_first: int  # addresses of derivatives of laws by the invariants
    by_second: int
    by_first_twice: int
    by_both: int
    by_second_twice: int
    state: Floats  # scratch, see ``measure``, shape (STATE,)


class MembraneLimitTable(NamedTuple):
    """Triangles that can break as the kernel reads them; a limit that one lacks is infinite."""

    strain: Floats  # shape (triangle,)
    stress: Floats  # [Pa], shape (triangle,)
    energy: Floats  # [J], shape (triangle,)
    energies: int  # address of the energies of laws; 0 where no energy breaks triangles
    wall: MembraneTable


def burden_membranes(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, limits: MembraneLimitTable
) -> None:
    """Set the load of each triangle, divided by its limit.

    Args:
        f: Set, dimensionless, shape (triangle,).
        limits: The triangles.
    """
    wall = limits.wall
    state = wall.state
    for e in range(wall.nodes.shape[0]):
        i, j, k = 3 * wall.nodes[e, 0], 3 * wall.nodes[e, 1], 3 * wall.nodes[e, 2]
        n0, n1, n2 = wall.gradients[e, 0], wall.gradients[e, 2], wall.gradients[e, 4]
        m0, m1, m2 = wall.gradients[e, 1], wall.gradients[e, 3], wall.gradients[e, 5]
        # The columns of F, and C.
        first = mixed = second = 0.0
        for c in range(3):
            a = x[i + c] * n0 + x[j + c] * n1 + x[k + c] * n2
            b = x[i + c] * m0 + x[j + c] * m1 + x[k + c] * m2
            first, mixed, second = first + a * a, mixed + a * b, second + b * b
        widest = sqrt(larger(first, mixed, mixed, second))
        f[e] = (widest - 1.0) / limits.strain[e]
        if limits.stress[e] < NONE or limits.energy[e] < NONE:
            measure(first, mixed, second, state)
            root = volume_root(e, wall)
            s, t, u = stress(e, root, wall)
            # S C has the principal values of F S Fᵀ.
            pull = larger(
                s * first + t * mixed, s * mixed + t * second,
                t * first + u * mixed, t * mixed + u * second,
            )  # fmt: skip
            f[e] = max(f[e], pull / widest / limits.stress[e])
            if limits.energy[e] < NONE:
                stored = wall.weight[e] * stored_in(e, root, limits)
                f[e] = max(f[e], stored / limits.energy[e])


def larger(a: float, b: float, c: float, d: float) -> float:
    """Return the larger eigenvalue of a matrix that has real ones.

    Args:
        a, b: Its first row, in any unit.
        c, d: Its second row.
    """
    half = 0.5 * (a - d)
    return 0.5 * (a + d) + sqrt(max(half * half + b * c, 0.0))


def stored_in(e: int, root: float, limits: MembraneLimitTable) -> float:
    """Return the energy of a triangle per volume [J/m³].

    Args:
        e: Its number.
        root: The cube root of J.
        limits: The triangles.
    """
    wall = limits.wall
    state = wall.state
    trace, square, over = state[3], state[4], root * root / state[5]
    g, outside = 1.0 / (root * root), over * over
    i1 = g * trace + outside
    if wall.is_curved and wall.law[e] > 0:
        i2 = g * (g * square + outside * trace)
        stored = wall.shear[e] * call_law(limits.energies, wall.law[e], i1, i2)
    else:
        stored = 0.5 * wall.shear[e] * (i1 - 3.0)
    j = root * root * root
    stored += 0.5 * wall.bulk[e] * (j - 1.0) * (j - 1.0)
    for family in range(wall.fibres.shape[1]):
        strain = fibre_strain(e, family, i1, wall)
        if strain > 0.0:
            steep = wall.fibre_stiffening[e]
            more = grown(steep * strain * strain)
            stored += 0.5 * wall.fibre_stiffness[e] / steep * more
    return float(stored)


def measure(first: float, mixed: float, second: float, state: Floats) -> None:
    """Set the strain in the plane of a triangle.

    Args:
        first, mixed, second: C11, C12 and C22.
        state: Set: C11, C12, C22, tr C, D = det C, q and dq/dD / q, dimensionless, shape
            (STATE,).
    """
    square = max(first * second - mixed * mixed, 0.0)
    near = max(square, LEAST_SQUARE)
    area, below = sqrt(near), square - near
    slope, bend = 0.5 / area, -0.25 / (area * near)
    q = area + below * (slope + 0.5 * bend * below)
    state[0], state[1], state[2] = first, mixed, second
    state[3], state[4], state[5] = first + second, square, q
    state[6] = (slope + bend * below) / q


def volume_root(e: int, wall: MembraneTable) -> float:
    """Return the cube root of J at the least energy, where there is no stress across.

    This is Newton's iteration in the logarithm, within limits between which the root lies.

    Args:
        e: Number of the triangle.
        wall: The triangles.
    """
    state, shear, bulk = wall.state, wall.shear[e], wall.bulk[e]
    trace, q = state[3], state[5]
    is_plain = (wall.fibres.shape[1] == 0 or wall.dispersion[e] == 0.0) and (
        not wall.is_curved or wall.law[e] == 0
    )
    # About q^((1 + thin)/3), which is exact at small strain, and positive at any.
    thinning = -(bulk - 2.0 / 3.0 * shear) / (bulk + 4.0 / 3.0 * shear)
    root = 1.0 + (1.0 + thinning) / 3.0 * (q - 1.0)
    low, high = 0.0, 1e300
    for _ in range(ROUNDS):
        if is_plain:
            slope, bend = plainly_across(root, shear, bulk, trace, q)
        else:
            slope, bend = across(e, root, wall)
        if slope > 0.0:
            high = root
        else:
            low = root
        step = -slope / (3.0 * bend) if bend > 0.0 else LONGEST
        if not (isfinite(step) and bend > 0.0):
            step = -LONGEST if slope > 0.0 else LONGEST
        step = min(max(step, -LONGEST), LONGEST)
        found = root * (1.0 + step * (1.0 + 0.5 * step))
        root = found if low <= found <= high else sqrt(low * high)
        if abs(step) < CLOSE:
            break
    return root


def plainly_across(
    root: float, shear: float, bulk: float, trace: float, q: float
) -> tuple[float, float]:
    """Return the derivatives of ``across`` for neo-Hookean triangles, without record for speed.

    Args:
        root: The cube root of J.
        shear, bulk: [Pa].
        trace, q: Of the state of the triangle.
    """
    square = root * root
    over = square / q
    in_plane, outside, j = trace / square, over * over, square * root
    slope = shear * (2.0 * outside - in_plane) / 3.0 + bulk * (j - 1.0) * j
    bend = shear * (2.0 * in_plane + 8.0 * outside) / 9.0
    return slope, bend + bulk * (2.0 * j - 1.0) * j


def across(e: int, root: float, wall: MembraneTable) -> tuple[float, float]:
    """Return the derivatives of the energy by the logarithm of the thickness [Pa].

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        wall: The triangles.
    """
    state = wall.state
    trace, square, over = state[3], state[4], root * root / state[5]
    r2 = root * root
    in_plane, outside = trace / r2, over * over
    i1, slope_of = in_plane + outside, (4.0 * outside - 2.0 * in_plane) / 3.0
    bend_of = (4.0 * in_plane + 16.0 * outside) / 9.0
    first, shear = 0.5, wall.shear[e]
    slope, bend = 0.0, 0.0
    if wall.is_curved and wall.law[e] > 0:
        law = wall.law[e]
        area, side = square / (r2 * r2), trace * outside / r2
        i2, slope_2 = area + side, (2.0 * side - 4.0 * area) / 3.0
        first = call_law(wall.by_first, law, i1, i2)
        second = call_law(wall.by_second, law, i1, i2)
        slope = shear * second * slope_2
        bend = shear * (
            second * (16.0 * area + 4.0 * side) / 9.0
            + call_law(wall.by_first_twice, law, i1, i2) * slope_of * slope_of
            + 2.0 * call_law(wall.by_both, law, i1, i2) * slope_of * slope_2
            + call_law(wall.by_second_twice, law, i1, i2) * slope_2 * slope_2
        )
    slope += shear * first * slope_of
    bend += shear * first * bend_of
    spread = wall.dispersion[e]
    if spread > 0.0:
        for family in range(wall.fibres.shape[1]):
            strain = fibre_strain(e, family, i1, wall)
            if strain > 0.0:
                more = wall.fibre_stiffening[e] * strain * strain
                pull = wall.fibre_stiffness[e] * exp(more)
                slope += pull * strain * spread * slope_of
                bend += pull * (1.0 + 2.0 * more) * spread * spread * slope_of * slope_of
                bend += pull * strain * spread * bend_of
    j = r2 * root
    slope += wall.bulk[e] * (j - 1.0) * j
    return slope, bend + wall.bulk[e] * (2.0 * j - 1.0) * j


def fibre_strain(e: int, family: int, i1: float, wall: MembraneTable) -> float:
    """Return the strain of a family of fibres; see ``solids.elements``.

    Args:
        e: Number of the triangle.
        family: Number of the family.
        i1: First isochoric invariant of the whole strain.
        wall: The triangles.
    """
    x, y, state = wall.fibres[e, family, 0], wall.fibres[e, family, 1], wall.state
    square = state[0] * x * x + 2.0 * state[1] * x * y + state[2] * y * y
    spread = wall.dispersion[e]
    return float(spread * (i1 - 3.0) + (1.0 - 3.0 * spread) * (square - 1.0))


def stress(e: int, root: float, wall: MembraneTable) -> tuple[float, float, float]:
    """Return S11, S12 and S22 of a triangle [Pa]; the part of K follows from W_λ = 0.

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        wall: The triangles.
    """
    state, shear = wall.state, wall.shear[e]
    trace, square, over = state[3], state[4], root * root / state[5]
    g = 1.0 / (root * root)
    outside = over * over  # g λ²
    first, second, i1 = 0.5, 0.0, g * trace + outside
    if wall.is_curved and wall.law[e] > 0:
        i2 = g * (g * square + outside * trace)
        first = call_law(wall.by_first, wall.law[e], i1, i2)
        second = call_law(wall.by_second, wall.law[e], i1, i2)
    spread = wall.dispersion[e]
    of_fibres = s = t = u = 0.0
    for family in range(wall.fibres.shape[1]):
        strain = fibre_strain(e, family, i1, wall)
        if strain > 0.0:
            pull = wall.fibre_stiffness[e] * strain
            pull *= exp(wall.fibre_stiffening[e] * strain * strain)
            of_fibres += pull * spread
            pull *= 2.0 * (1.0 - 3.0 * spread)
            x, y = wall.fibres[e, family, 0], wall.fibres[e, family, 1]
            s, t, u = s + pull * x * x, t + pull * x * y, u + pull * y * y
    along, second = shear * first, shear * second
    by_trace = 2.0 * g * (along + of_fibres + second * outside)
    by_square = 2.0 * second * g * g
    by_square -= 4.0 * state[6] * outside * (along + of_fibres + second * g * trace)
    s += by_trace + by_square * state[2]
    return s, t - by_square * state[1], u + by_trace + by_square * state[0]
