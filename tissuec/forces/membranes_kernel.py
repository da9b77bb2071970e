"""The forces of triangles of walls as loops; for the equations see ``forces.membranes``."""

from math import exp, isfinite, sqrt

from tissuec.forces.elements_kernel import call_law
from tissuec.forces.membrane_memory_kernel import forget, remember
from tissuec.forces.membrane_record_kernel import MembraneTable
from tissuec.kernels.records import Floats

#: Square of the ratio of areas below which its root is continued by a parabola, so that
#: triangles that are pressed flat have finite forces.
LEAST_SQUARE = 0.04
ROUNDS = 60  # of the iteration for the thickness, more than bisection needs
LONGEST = 1.0 / 3.0  # step of an iteration, in the logarithm of the root of J
CLOSE = 1e-8  # step after which an iteration of second order is at rounding


def stretch_membranes(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, wall: MembraneTable
) -> None:
    """Add the forces of triangles to those on nodes, and the power that they dissipate.

    Args:
        wall: The triangles; they neither relax nor yield.
    """
    pull_triangles(x, v, f, power, wall, remembers=False)


def relax_membranes(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, wall: MembraneTable
) -> None:
    """Do what ``stretch_membranes`` does for triangles that relax or yield.

    The rates of hidden nodes are added as forces on them.

    Args:
        wall: The triangles.
    """
    pull_triangles(x, v, f, power, wall, remembers=True)


def pull_triangles(
    x: Floats, v: Floats, f: Floats, power: Floats, wall: MembraneTable, remembers: bool
) -> None:
    """Do what both kernels do; the last is constant in each, so that the simple one is fast.

    Args:
        x, v, f: Positions [m], velocities [m/s] and forces [N] of all nodes, flat.
        power: [W], shape (2,).
        wall: The triangles.
        remembers: Whether any relaxes or yields.
    """
    state = wall.state
    for e in range(wall.nodes.shape[0]):
        i, j, k = 3 * wall.nodes[e, 0], 3 * wall.nodes[e, 1], 3 * wall.nodes[e, 2]
        n0, n1, n2 = wall.gradients[e, 0], wall.gradients[e, 2], wall.gradients[e, 4]
        m0, m1, m2 = wall.gradients[e, 1], wall.gradients[e, 3], wall.gradients[e, 5]
        # The columns of F.
        a0 = x[i] * n0 + x[j] * n1 + x[k] * n2
        a1 = x[i + 1] * n0 + x[j + 1] * n1 + x[k + 1] * n2
        a2 = x[i + 2] * n0 + x[j + 2] * n1 + x[k + 2] * n2
        b0 = x[i] * m0 + x[j] * m1 + x[k] * m2
        b1 = x[i + 1] * m0 + x[j + 1] * m1 + x[k + 1] * m2
        b2 = x[i + 2] * m0 + x[j + 2] * m1 + x[k + 2] * m2
        measure(
            a0 * a0 + a1 * a1 + a2 * a2, a0 * b0 + a1 * b1 + a2 * b2,
            b0 * b0 + b1 * b1 + b2 * b2, state,
        )  # fmt: skip
        if remembers:
            remember(e, v, wall)
        root = volume_root(e, wall, remembers)
        s, t, u = stress(e, root, wall, remembers)
        if remembers:
            power[1] += wall.weight[e] * forget(e, root, v, f, wall)
        if wall.is_viscous and wall.viscosity[e] > 0.0:
            c0 = v[i] * n0 + v[j] * n1 + v[k] * n2
            c1 = v[i + 1] * n0 + v[j + 1] * n1 + v[k + 1] * n2
            c2 = v[i + 2] * n0 + v[j + 2] * n1 + v[k + 2] * n2
            d0 = v[i] * m0 + v[j] * m1 + v[k] * m2
            d1 = v[i + 1] * m0 + v[j + 1] * m1 + v[k + 1] * m2
            d2 = v[i + 2] * m0 + v[j + 2] * m1 + v[k + 2] * m2
            # The rate of Green's strain in the plane.
            g, h = a0 * c0 + a1 * c1 + a2 * c2, b0 * d0 + b1 * d1 + b2 * d2
            o = 0.5 * (a0 * d0 + a1 * d1 + a2 * d2 + b0 * c0 + b1 * c1 + b2 * c2)
            more_s, more_t, more_u = resist(e, root, g, o, h, wall)
            power[1] += wall.weight[e] * (more_s * g + 2.0 * more_t * o + more_u * h)
            s, t, u = s + more_s, t + more_t, u + more_u
        # P = F S, with S of the components s, t, t, u.
        w = -wall.weight[e]
        p0, p1, p2 = w * (a0 * s + b0 * t), w * (a1 * s + b1 * t), w * (a2 * s + b2 * t)
        q0, q1, q2 = w * (a0 * t + b0 * u), w * (a1 * t + b1 * u), w * (a2 * t + b2 * u)
        f[i] += p0 * n0 + q0 * m0
        f[i + 1] += p1 * n0 + q1 * m0
        f[i + 2] += p2 * n0 + q2 * m0
        f[j] += p0 * n1 + q0 * m1
        f[j + 1] += p1 * n1 + q1 * m1
        f[j + 2] += p2 * n1 + q2 * m1
        f[k] += p0 * n2 + q0 * m2
        f[k + 1] += p1 * n2 + q1 * m2
        f[k + 2] += p2 * n2 + q2 * m2


def measure(first: float, mixed: float, second: float, state: Floats) -> None:
    """Set the strain in the plane of a triangle.

    Args:
        first, mixed, second: C11, C12 and C22.
        state: Set: C11, C12, C22, tr C, D = det C, q and dq/dD / q, dimensionless; the first
            seven numbers, shape (STATE,).
    """
    square = max(first * second - mixed * mixed, 0.0)
    near = max(square, LEAST_SQUARE)
    area, below = sqrt(near), square - near
    slope, bend = 0.5 / area, -0.25 / (area * near)
    q = area + below * (slope + 0.5 * bend * below)
    state[0], state[1], state[2] = first, mixed, second
    state[3], state[4], state[5] = first + second, square, q
    state[6] = (slope + bend * below) / q


def volume_root(e: int, wall: MembraneTable, remembers: bool) -> float:
    """Return the cube root of J at the least energy, where there is no stress across.

    This is Newton's iteration in the logarithm, within limits between which the root lies.

    Args:
        e: Number of the triangle.
        wall: The triangles.
        remembers: Whether ``remember`` has set its state.
    """
    state, shear, bulk = wall.state, wall.shear[e], wall.bulk[e]
    trace, q = state[3], state[5]
    is_plain = (wall.fibres.shape[1] == 0 or wall.dispersion[e] == 0.0) and (
        not wall.is_curved or wall.law[e] == 0
    )
    # About q^((1 + thin)/3), which is exact at small strain, and positive at any.
    root = 1.0 + (1.0 + wall.thinning[e]) / 3.0 * (q - 1.0)
    low, high = 0.0, 1e300
    for _ in range(ROUNDS):
        if is_plain:
            slope, bend = plainly_across(root, shear, bulk, trace, q)
        else:
            slope, bend = across(e, root, wall, remembers)
        if remembers:
            square, over = root * root, root * root / q
            in_plane, outside = state[10] / square, state[11] * over * over
            slope += (2.0 * outside - in_plane) / 3.0
            bend += (2.0 * in_plane + 8.0 * outside) / 9.0
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


def across(e: int, root: float, wall: MembraneTable, remembers: bool) -> tuple[float, float]:
    """Return the derivatives of the energy by the logarithm of the thickness [Pa].

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        wall: The triangles.
        remembers: As for ``volume_root``.
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
        if remembers:  # fibres do not yield
            in_plane, outside = state[16] / r2, outside / state[12]
            i1, slope_of = in_plane + outside, (4.0 * outside - 2.0 * in_plane) / 3.0
            bend_of = (4.0 * in_plane + 16.0 * outside) / 9.0
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
    """Return the strain of a family of fibres; see ``forces.elements``.

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


def stress(
    e: int, root: float, wall: MembraneTable, remembers: bool
) -> tuple[float, float, float]:
    """Return S11, S12 and S22 of a triangle [Pa]; the part of K follows from W_λ = 0.

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        wall: The triangles.
        remembers: As for ``volume_root``.
    """
    state, shear = wall.state, wall.shear[e]
    trace, square, over = state[3], state[4], root * root / state[5]
    g = 1.0 / (root * root)
    outside = over * over  # g λ² of the elastic strain
    first, second, i1 = 0.5, 0.0, g * trace + outside
    if wall.is_curved and wall.law[e] > 0:
        i2 = g * (g * square + outside * trace)
        first = call_law(wall.by_first, wall.law[e], i1, i2)
        second = call_law(wall.by_second, wall.law[e], i1, i2)
    # π, and Pp⁻¹ by its components.
    part, one, mixed, other = 1.0, 1.0, 0.0, 1.0
    if remembers:
        part, one, mixed, other = state[12], state[13], state[14], state[15]
        i1 = g * state[16] + outside / part
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
    by_trace, by_whole = 2.0 * g * (along + second * outside), 2.0 * g * of_fibres
    by_square = 2.0 * second * g * g / part
    by_square -= 4.0 * state[6] * outside * (along + of_fibres / part + second * g * trace)
    if remembers:
        by_square -= 2.0 * state[6] * outside * state[11]
        s, t, u = s + g * state[7], t + g * state[8], u + g * state[9]
    s += by_trace * one + by_whole + by_square * state[2]
    t += by_trace * mixed - by_square * state[1]
    return s, t, u + by_trace * other + by_whole + by_square * state[0]


def resist(
    e: int, root: float, g: float, o: float, h: float, wall: MembraneTable
) -> tuple[float, float, float]:
    """Return the viscous S11, S12 and S22 of a triangle [Pa].

    Args:
        e: Number of the triangle.
        root: The cube root of J.
        g, o, h: The rates of E11, E12 and E22 [1/s].
        wall: The triangles.
    """
    state, thin = wall.state, wall.thinning[e]
    c, d, k = state[0], state[1], state[2]
    near = max(c * k - d * d, LEAST_SQUARE)
    thick = 2.0 * wall.viscosity[e] * root * root * root / (near * near)
    # cof C times the rate, and its trace.
    b00, b01, b10, b11 = k * g - d * o, k * o - d * h, c * o - d * g, c * h - d * o
    part = (thin * thin - (1.0 + thin) * (1.0 + thin) / 3.0) * (b00 + b11)
    return (
        thick * (b00 * k - b01 * d + part * k),
        thick * (b01 * c - b00 * d - part * d),
        thick * (b11 * c - b10 * d + part * c),
    )
