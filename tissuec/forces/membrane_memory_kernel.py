"""The memory of triangles of walls as loops: branches that relax, and plastic strain.

For the equations see ``forces.membrane_memory``.
"""

from math import sqrt

from tissuec.forces.elements_kernel import call_law
from tissuec.forces.membrane_record_kernel import MembraneTable
from tissuec.kernels.records import Floats

FLAT = 1e-6  # determinants of what gave way, below which they count as this


def remember(e: int, v: Floats, wall: MembraneTable) -> None:
    """Set the state of the internal variables of a triangle, and of its elastic strain.

    With π = det Pp, tr C, D and q become tr(C Pp⁻¹), D/π and q/√π. W11, W12, W22, tr(C W) and
    w/π [Pa] of branches follow, and π, the components 11, 12 and 22 of Pp⁻¹, and tr C.

    Args:
        e: Number of the triangle.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep P - 1 and Pp - 1.
        wall: The triangles; see ``forces.membrane_memory`` and ``forces.membrane_memory``.
    """
    state, i = wall.state, wall.yield_slot[e]
    state[12], state[13], state[14], state[15], state[16] = 1.0, 1.0, 0.0, 1.0, state[3]
    if i >= 0:
        scale = 1.0 / wall.yield_rate[e]
        a, b, c = 1.0 + scale * v[i], 1.0 + scale * v[i + 1], scale * v[i + 2]
        square = max(a * b - c * c, FLAT)
        one, mixed, other = b / square, -c / square, a / square
        state[12], state[13], state[14], state[15] = square, one, mixed, other
        state[3] = state[0] * one + 2.0 * state[1] * mixed + state[2] * other
        state[4], state[5] = state[4] / square, state[5] / sqrt(square)
    one = mixed = other = across = 0.0
    for branch in range(wall.first[e], wall.first[e + 1]):
        k, scale = wall.branch_slot[branch], 1.0 / wall.branch_rate[branch]
        a, b, c = 1.0 + scale * v[k], 1.0 + scale * v[k + 1], scale * v[k + 2]
        square, shear = max(a * b - c * c, FLAT), wall.branch_shear[branch]
        one, other = one + shear * b / square, other + shear * a / square
        mixed, across = mixed - shear * c / square, across + shear * square
    state[7], state[8], state[9] = one, mixed, other
    state[10] = state[0] * one + 2.0 * state[1] * mixed + state[2] * other
    state[11] = across / state[12]


def forget(e: int, root: float, v: Floats, f: Floats, wall: MembraneTable) -> float:
    """Add all rates of internal variables of a triangle; return the power that is lost [W/m³].

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        v: Velocities of all nodes [m/s], flat.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
        wall: The triangles; the state is that of this one.
    """
    lost = 0.0
    for branch in range(wall.first[e], wall.first[e + 1]):
        lost += relax(branch, root, v, f, wall)
    if wall.yield_slot[e] >= 0:
        lost += give_way(e, root, v, f, wall)
    return lost


def relax(branch: int, root: float, v: Floats, f: Floats, wall: MembraneTable) -> float:
    """Add the rate at which a branch gives way; return the power that it dissipates [W/m³].

    Args:
        branch: Its number.
        root: The cube root of J.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep P - 1.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
        wall: The triangles; the state is that of the triangle of the branch.
    """
    state, i = wall.state, wall.branch_slot[branch]
    rate, pace = wall.branch_rate[branch], wall.branch_pace[branch]
    scale, g, over = 1.0 / rate, 1.0 / (root * root), root * root / state[5]
    a, b, c = 1.0 + scale * v[i], 1.0 + scale * v[i + 1], scale * v[i + 2]
    square = max(a * b - c * c, FLAT)
    first, mixed, second = g * state[0], g * state[1], g * state[2]
    # X = g C P⁻¹ in the plane, and across it.
    x00, x01 = (first * b - mixed * c) / square, (mixed * a - first * c) / square
    x10, x11 = (mixed * b - second * c) / square, (second * a - mixed * c) / square
    x22 = over * over / state[12] * square
    third, give = (x00 + x11 + x22) / 3.0, rate * pace
    f[i] += give * (first - third * a)
    f[i + 1] += give * (second - third * b)
    f[i + 2] += give * (mixed - third * c)
    x00, x11, x22 = x00 - third, x11 - third, x22 - third
    found = x00 * x00 + x11 * x11 + x22 * x22 + 2.0 * x01 * x10
    return float(0.5 * wall.branch_shear[branch] * pace * found)


def give_way(e: int, root: float, v: Floats, f: Floats, wall: MembraneTable) -> float:
    """Add the rates of plastic flow of a triangle, and those of its branches.

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        v: Velocities of all nodes [m/s], flat; those of hidden ones keep P - 1 and Pp - 1.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
        wall: The triangles; the state is that of this one.

    Returns:
        The power that it dissipates [W/m³].
    """
    state, shear = wall.state, wall.shear[e]
    trace, square, over = state[3], state[4], root * root / state[5]
    g, outside = 1.0 / (root * root), over * over
    first, second = 0.5, 0.0
    if wall.is_curved and wall.law[e] > 0:
        i1, i2 = g * trace + outside, g * (g * square + outside * trace)
        first = call_law(wall.by_first, wall.law[e], i1, i2)
        second = call_law(wall.by_second, wall.law[e], i1, i2)
    # S C of law and branches at a fixed volume, in the plane and across it, is s C + t.
    by_trace = 2.0 * shear * g * (first + second * outside)
    t = 2.0 * shear * second * g * g * square
    s0, s1 = by_trace * state[13] + g * state[7], by_trace * state[14] + g * state[8]
    s2 = by_trace * state[15] + g * state[9]
    n0, n1 = s0 * state[0] + s1 * state[1] + t, s0 * state[1] + s1 * state[2]
    n2, n3 = s1 * state[0] + s2 * state[1], s1 * state[1] + s2 * state[2] + t
    n4 = outside * (2.0 * shear * (first + second * g * trace) + state[11])
    third = (n0 + n3 + n4) / 3.0
    n0, n3, n4 = n0 - third, n3 - third, n4 - third
    size_squared = n0 * n0 + n3 * n3 + n4 * n4 + 2.0 * n1 * n2
    size = sqrt(1.5 * max(size_squared, 0.0))
    if not size > wall.yield_stress[e]:
        return 0.0
    pace = 1.5 * wall.yield_pace[e] * (size - wall.yield_stress[e]) / size
    carry(wall.yield_slot[e], pace, wall.yield_rate[e], n0, n1, n2, n3, v, f)
    for branch in range(wall.first[e], wall.first[e + 1]):
        i, rate = wall.branch_slot[branch], wall.branch_rate[branch]
        carry(i, pace, rate, n0, n1, n2, n3, v, f)
    return float(pace * size_squared)


def carry(
    i: int,
    pace: float,
    rate: float,
    n0: float,
    n1: float,
    n2: float,
    n3: float,
    v: Floats,
    f: Floats,
) -> None:
    """Add λ (P N + Nᵀ P) to the rates of a tensor P that plastic flow carries along.

    Args:
        i: Index of the first number of P - 1 among velocities.
        pace: λ [1/(Pa s)].
        rate: Of P - 1 there [m/s].
        n0, n1, n2, n3: N in the plane, row by row [Pa].
        v: Velocities of all nodes [m/s], flat.
        f: Forces on all nodes [N], flat; those on hidden ones are rates [m/s²].
    """
    scale, give = 1.0 / rate, rate * pace
    a, b, c = 1.0 + scale * v[i], 1.0 + scale * v[i + 1], scale * v[i + 2]
    f[i] += 2.0 * give * (a * n0 + c * n2)
    f[i + 1] += 2.0 * give * (c * n1 + b * n3)
    f[i + 2] += give * (a * n1 + c * (n0 + n3) + b * n2)
