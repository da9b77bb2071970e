"""Forces of springs with their derivatives.

A spring from node i to node j has r = x_j - x_i, L = |r|, n = r/L, e = L - L0, w = n·(v_j -
v_i) and the tension T = f(e) + g(e, w); it acts with T n on i and with -T n on j. A change of
the state changes it by

    δT = T' (n·δr - δL0) + ∂g/∂w (n·δv + v·δn) + ∂f/∂c δc + ∂g/∂d δd,   δn = (δr - n n·δr) / L,

where T' = ∂(f + g)/∂e. ``push_forward_springs`` does that for many changes at once,
``pull_back_springs`` is its transpose, and ``blocks`` are the matrices of single springs.

Laws that are not linear are called by their addresses, with the number of a law as the first
argument, and of the constant as well for ``by_constant``. ``branches_derivatives_kernel`` adds
what springs remember.

Shared arguments:
    s: Index of the spring in ``forces.links``.
    k: Number of the spring in the network.
    law: Number of its law.
    e, w: Elongation [m] and its rate [m/s].
    forces: Everything that accelerations follow from, beside the state.
    at: A state with the shapes and units of ``NodeState``.
    due: Derivatives by the state, added to.
    by: Derivatives by the numbers of springs and nodes, added to.
    seeds: Changes of the numbers.
    change: Changes of the state, shape (3 node change,).
    r: Response of the spring at this state, see ``response``.
"""

from math import sqrt

from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    Reach,
    Response,
    Seeds,
    Slopes,
    Sparse,
    Values,
    brake,
    brake_by_d,
    brake_by_e,
    brake_by_rest,
    brake_slope,
    by_constant,
    pull,
    pull_by_c,
    pull_by_rest,
    slope,
)
from tissuec.kernels.records import Floats, Stack


def add_springs(forces: Forces, at: NodeState) -> None:
    """Add the forces of springs to ``at.a`` [N]."""
    links, rest = forces.links, forces.values.rest
    for s in range(links.low.size):
        k, law = int(links.spring[s]), links.law[s]
        z = reach(int(links.low[s]), int(links.high[s]), at)
        force, braking = pulls(law, k, z.length - rest[k], z.w, forces)
        pull_ends(int(links.low[s]), int(links.high[s]), force + braking, z, at.a)


def reach(low: int, high: int, at: NodeState) -> Reach:
    """Return the direction from one node to another, with length and relative velocity.

    Args:
        low, high: The nodes.
    """
    x, v, i, j = at.x, at.v, 3 * low, 3 * high
    r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
    u0, u1, u2 = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
    length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    return Reach(length, inverse, n0, n1, n2, u0, u1, u2, n0 * u0 + n1 * u1 + n2 * u2)


def pulls(law: int, k: int, e: float, w: float, forces: Forces) -> tuple[float, float]:
    """Return f(e) and g(e, w) of a spring [N]."""
    laws, values = forces.laws, forces.values
    c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
    force, braking = c * e, d * w
    if laws.curved:
        force = pull(law, e, c, rest, laws, values)
        braking = brake(law, e, w, d, rest, laws, values)
    return force, braking


def slopes(law: int, k: int, e: float, w: float, forces: Forces) -> Slopes:
    """Return the derivatives of f(e) and g(e, w) of a spring."""
    laws, values = forces.laws, forces.values
    c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
    steep, thick, brisk = c, 0.0, d
    by_c, by_rest, by_d, braked = e, 0.0, w, 0.0
    if laws.curved:
        steep = slope(law, e, c, rest, laws, values)
        thick = brake_by_e(law, e, w, d, rest, laws, values)
        brisk = brake_slope(law, e, w, d, rest, laws, values)
        by_c = pull_by_c(law, e, c, rest, laws, values)
        by_rest = pull_by_rest(law, e, c, rest, laws, values)
        by_d = brake_by_d(law, e, w, d, rest, laws, values)
        braked = brake_by_rest(law, e, w, d, rest, laws, values)
    return Slopes(steep, thick, brisk, by_c, by_rest, by_d, braked)


def by_constant_of(number: int, law: int, k: int, e: float, w: float, forces: Forces) -> float:
    """Return the derivative of f + g of a spring by a constant of laws [N per unit].

    Args:
        number: Index of the constant.
    """
    laws, values = forces.laws, forces.values
    c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
    return by_constant(law, number, e, w, c, d, rest, laws, values)


def pull_ends(low: int, high: int, tension: float, z: Reach, a: Floats) -> None:
    """Add the force of a spring to both of its ends.

    Args:
        low, high: Its nodes.
        tension: T [N].
        z: What leads from one to the other.
        a: Forces on all nodes [N], added to, shape (3 node,).
    """
    # A loop over the three components would keep them in memory.
    i, j = 3 * low, 3 * high
    f0, f1, f2 = tension * z.n0, tension * z.n1, tension * z.n2
    a[i] += f0
    a[i + 1] += f1
    a[i + 2] += f2
    a[j] -= f0
    a[j + 1] -= f1
    a[j + 2] -= f2


def response(s: int, forces: Forces, at: NodeState) -> Response:
    """Return the derivatives of a spring's force by positions, velocities and its numbers."""
    links, k, law = forces.links, int(forces.links.spring[s]), forces.links.law[s]
    z, rest = reach(int(links.low[s]), int(links.high[s]), at), forces.values.rest[k]
    e = z.length - rest
    force, braking = pulls(law, k, e, z.w, forces)
    t = slopes(law, k, e, z.w, forces)
    steep = t.steep + t.thick
    across = (force + braking) * z.inverse
    if z.length == 0.0 and rest == 0.0:
        across = steep  # in all directions alike
    by_rest = t.by_rest + t.braked - steep
    return Response(z, e, across, steep, t.brisk, t.by_c, t.by_d, by_rest)


def pull_back_springs(forces: Forces, at: NodeState, due: NodeState, by: Values) -> None:
    """Add to ``due.x``, ``due.v`` and ``by`` what comes from springs."""
    links, weight = forces.links, due.a
    for s in range(links.low.size):
        p, q = int(links.low[s]), int(links.high[s])
        mi, mj = links.inverse[p], links.inverse[q]
        if mi == 0.0 and mj == 0.0:
            continue
        i, j, k, r = 3 * p, 3 * q, int(links.spring[s]), response(s, forces, at)
        g0 = mi * weight[i] - mj * weight[j]
        g1 = mi * weight[i + 1] - mj * weight[j + 1]
        g2 = mi * weight[i + 2] - mj * weight[j + 2]
        along = r.z.n0 * g0 + r.z.n1 * g1 + r.z.n2 * g2
        by.stiffness[k] += along * r.by_c
        by.damping[k] += along * r.by_d
        by.rest[k] += along * r.by_rest
        if forces.laws.curved:
            for m in range(by.constants.size):
                by.constants[m] += along * by_constant_of(
                    m, links.law[s], k, r.e, r.z.w, forces
                )
        of_e, of_w = along * r.steep, along * r.brisk
        pull_from_ends(p, q, (g0, g1, g2), along, of_e, of_w, r.across, r.z, due)


def pull_from_ends(
    low: int,
    high: int,
    weights: tuple[float, float, float],
    along: float,
    of_e: float,
    of_w: float,
    across: float,
    z: Reach,
    due: NodeState,
) -> None:
    """Add to ``due.x`` and ``due.v`` of the nodes of a spring.

    Args:
        low, high: The nodes.
        weights: The difference of the weights of the forces on them [1/kg].
        along: Its part along the spring.
        of_e, of_w: Derivatives by elongation and its rate.
        across: T / L [N/m], see ``Response``.
        z: What leads from one node to the other.
    """
    i, j, turned = 3 * low, 3 * high, of_w * z.inverse
    n0, n1, n2 = z.n0, z.n1, z.n2
    h0 = of_e * n0 + turned * (z.u0 - z.w * n0) + across * (weights[0] - along * n0)
    h1 = of_e * n1 + turned * (z.u1 - z.w * n1) + across * (weights[1] - along * n1)
    h2 = of_e * n2 + turned * (z.u2 - z.w * n2) + across * (weights[2] - along * n2)
    due.x[i] -= h0
    due.x[i + 1] -= h1
    due.x[i + 2] -= h2
    due.x[j] += h0
    due.x[j + 1] += h1
    due.x[j + 2] += h2
    due.v[i] -= of_w * n0
    due.v[i + 1] -= of_w * n1
    due.v[i + 2] -= of_w * n2
    due.v[j] += of_w * n0
    due.v[j + 1] += of_w * n1
    due.v[j + 2] += of_w * n2


def push_forward_springs(
    forces: Forces, at: NodeState, seeds: Seeds, change: NodeState
) -> None:
    """Add to ``change.a`` what comes from springs [N]."""
    links, total = forces.links, seeds.total
    count, own = total.size, 3 * total.size
    for s in range(links.low.size):
        p, q = links.low[s], links.high[s]
        if links.inverse[p] == 0.0 and links.inverse[q] == 0.0:
            continue
        r = response(s, forces, at)
        sow_numbers(s, r, forces, seeds)
        k00, k01, k02 = by_place(r.z.n0, 1.0, 0.0, 0.0, r)
        k10, k11, k12 = by_place(r.z.n1, 0.0, 1.0, 0.0, r)
        k20, k21, k22 = by_place(r.z.n2, 0.0, 0.0, 1.0, r)
        b0, b1, b2 = r.brisk * r.z.n0, r.brisk * r.z.n1, r.brisk * r.z.n2
        # Views that are indexed from 0 need no test of whether an index is negative.
        low, high = slice(own * p, own * p + own), slice(own * q, own * q + own)
        x0, v0, a0 = change.x[low], change.v[low], change.a[low]
        x1, v1, a1 = change.x[high], change.v[high], change.a[high]
        for m in range(count):
            y, z = m + count, m + 2 * count
            d0, d1, d2 = x1[m] - x0[m], x1[y] - x0[y], x1[z] - x0[z]
            more = total[m]
            more += b0 * (v1[m] - v0[m]) + b1 * (v1[y] - v0[y]) + b2 * (v1[z] - v0[z])
            f0 = k00 * d0 + k01 * d1 + k02 * d2 + r.z.n0 * more
            f1 = k10 * d0 + k11 * d1 + k12 * d2 + r.z.n1 * more
            f2 = k20 * d0 + k21 * d1 + k22 * d2 + r.z.n2 * more
            a0[m] += f0
            a0[y] += f1
            a0[z] += f2
            a1[m] -= f0
            a1[y] -= f1
            a1[z] -= f2


def sow_numbers(s: int, r: Response, forces: Forces, seeds: Seeds) -> None:
    """Set ``seeds.total`` to what numbers alone change the tension of a spring by [N]."""
    k, total = int(forces.links.spring[s]), seeds.total
    for m in range(total.size):
        total[m] = 0.0
    sow(r.by_c, k, seeds.stiffness, total)
    sow(r.by_d, k, seeds.damping, total)
    sow(r.by_rest, k, seeds.rest, total)
    if forces.laws.curved:
        for b in range(forces.values.constants.size):
            by = by_constant_of(b, forces.links.law[s], k, r.e, r.z.w, forces)
            sow(by, b, seeds.constants, total)


def by_place(
    n: float, one: float, two: float, three: float, r: Response
) -> tuple[float, float, float]:
    """Return the derivative of a component of a spring's force by the upper node's position.

    The result is in [N/m].

    Args:
        n: That component of the direction.
        one, two, three: The unit vector of the component.
    """
    # δT = T' n·δr + g' (n·δv + u·δn) with g' = ∂g/∂w and δn = (δr - n n·δr) / L
    z, turned = r.z, r.brisk * r.z.inverse
    l0 = r.steep * z.n0 + turned * (z.u0 - z.w * z.n0)
    l1 = r.steep * z.n1 + turned * (z.u1 - z.w * z.n1)
    l2 = r.steep * z.n2 + turned * (z.u2 - z.w * z.n2)
    return (
        n * l0 + r.across * (one - n * z.n0),
        n * l1 + r.across * (two - n * z.n1),
        n * l2 + r.across * (three - n * z.n2),
    )


def blocks(forces: Forces, at: NodeState, of_x: Stack, of_v: Stack) -> None:
    """Set the derivatives of the forces of springs on their lower nodes.

    Args:
        of_x, of_v: By positions [N/m] and velocities [N s/m] of upper nodes, shape (spring, 3,
            3).
    """
    for s in range(forces.links.low.size):
        r = response(s, forces, at)
        of_x[s, 0, 0], of_x[s, 0, 1], of_x[s, 0, 2] = by_place(r.z.n0, 1.0, 0.0, 0.0, r)
        of_x[s, 1, 0], of_x[s, 1, 1], of_x[s, 1, 2] = by_place(r.z.n1, 0.0, 1.0, 0.0, r)
        of_x[s, 2, 0], of_x[s, 2, 1], of_x[s, 2, 2] = by_place(r.z.n2, 0.0, 0.0, 1.0, r)
        for i, n in enumerate((r.z.n0, r.z.n1, r.z.n2)):
            of_v[s, i, 0] = r.brisk * n * r.z.n0
            of_v[s, i, 1] = r.brisk * n * r.z.n1
            of_v[s, i, 2] = r.brisk * n * r.z.n2


def sow(factor: float, row: int, matrix: Sparse, out: Floats) -> None:
    """Add a multiple of a row of a matrix to a vector.

    Args:
        row: Index of the row.
        out: Vector of the row's unit times that of ``factor``, shape (column,).
    """
    for z in range(matrix.rows[row], matrix.rows[row + 1]):
        out[matrix.columns[z]] += factor * matrix.entries[z]
