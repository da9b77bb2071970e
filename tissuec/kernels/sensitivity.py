"""Forces of springs with their derivatives.

A spring from node i to node j has r = x_j - x_i, L = |r|, n = r/L, e = L - L0, w = n·(v_j -
v_i) and the tension T = f(e) + g(e, w); it acts with T n on i and with -T n on j. A change of
the state changes it by

    δT = T' (n·δr - δL0) + ∂g/∂w (n·δv + v·δn) + ∂f/∂c δc + ∂g/∂d δd,   δn = (δr - n n·δr) / L,

where T' = ∂(f + g)/∂e. ``push_forward`` does that for many changes at once, ``pull_back`` is
its transpose, and ``blocks`` are the matrices of single springs.

Laws that are not linear are called by their addresses, with the number of a law as the first
argument, and of the constant as well for ``by_constant``.

Shared arguments:
    s: Index of the spring in ``forces.links``.
    forces: Everything that accelerations follow from, beside the state.
    time: [s], on which fields may depend.
    due: Derivatives by the state.
    by: Derivatives by the numbers of springs and nodes.
    at: A state with the shapes and units of ``NodeState``.
    r: Response of the spring at this state, see ``response``.
"""

from math import sqrt

from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    Response,
    Seeds,
    Values,
    brake,
    brake_by_d,
    brake_by_e,
    brake_by_rest,
    brake_slope,
    by_constant,
    call_force,
    call_pull_back,
    call_push_forward,
    pull,
    pull_by_c,
    pull_by_rest,
    slope,
)
from tissuec.kernels.memory_sensitivity import (
    accelerate_memory,
    pull_back_memory,
    push_forward_memory,
    sow,
)
from tissuec.kernels.records import Floats, Stack


def acceleration(forces: Forces, time: float, load: Floats, at: NodeState) -> None:
    """Set the accelerations of all nodes, ``at.a`` [m/s²].

    Args:
        load: Loads that change in time [N], shape (3 loaded,).
    """
    laws, links, values = forces.laws, forces.links, forces.values
    x, v, a = at.x, at.v, at.a
    for i in range(a.size):
        a[i] = 0.0
    for s in range(links.low.size):
        i, j, k, law = 3 * links.low[s], 3 * links.high[s], links.spring[s], links.law[s]
        r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        inverse = 1.0 / length if length > 0.0 else 0.0
        w = r0 * (v[j] - v[i]) + r1 * (v[j + 1] - v[i + 1]) + r2 * (v[j + 2] - v[i + 2])
        w *= inverse
        c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
        tension = c * (length - rest) + d * w
        if laws.curved:
            tension = pull(law, length - rest, c, rest, laws, values)
            tension += brake(law, length - rest, w, d, rest, laws, values)
        tension *= inverse
        a[i] += tension * r0
        a[i + 1] += tension * r1
        a[i + 2] += tension * r2
        a[j] -= tension * r0
        a[j + 1] -= tension * r1
        a[j + 2] -= tension * r2
    accelerate_memory(forces, at)
    fields = forces.fields
    for k in range(fields.table.size):
        call_force(fields.force[k], fields.table[k], time, x, v, a, fields.power)
    for k in range(links.loaded.size):
        i = 3 * links.loaded[k]
        for axis in range(3):
            a[i + axis] += load[3 * k + axis]
    for node in range(links.inverse.size):
        inverse, drag = links.inverse[node], links.drag[node]
        for i in range(3 * node, 3 * node + 3):
            a[i] = links.steady[i] + inverse * (a[i] - drag * v[i])


def response(s: int, forces: Forces, at: NodeState) -> Response:
    """Return the derivatives of a spring's force by positions, velocities and its numbers."""
    laws, links, values = forces.laws, forces.links, forces.values
    x, v, law = at.x, at.v, links.law[s]
    i, j, k = int(3 * links.low[s]), int(3 * links.high[s]), int(links.spring[s])
    r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
    length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    u0, u1, u2 = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
    w = n0 * u0 + n1 * u1 + n2 * u2
    c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
    e = length - rest
    tension, steep, brisk, by_c, by_d, by_rest = c * e + d * w, c, d, e, w, -c
    if laws.curved:
        tension = pull(law, e, c, rest, laws, values)
        tension += brake(law, e, w, d, rest, laws, values)
        steep = slope(law, e, c, rest, laws, values)
        steep += brake_by_e(law, e, w, d, rest, laws, values)
        brisk = brake_slope(law, e, w, d, rest, laws, values)
        by_c = pull_by_c(law, e, c, rest, laws, values)
        by_d = brake_by_d(law, e, w, d, rest, laws, values)
        by_rest = pull_by_rest(law, e, c, rest, laws, values) - steep
        by_rest += brake_by_rest(law, e, w, d, rest, laws, values)
    across = tension * inverse
    if length == 0.0 and rest == 0.0:
        across = steep  # in all directions alike
    # δT = T' n·δr + g' (n·δv + u·δn) with g' = ∂g/∂w and δn = (δr - n n·δr) / L
    turned = brisk * inverse
    l0 = steep * n0 + turned * (u0 - w * n0)
    l1 = steep * n1 + turned * (u1 - w * n1)
    l2 = steep * n2 + turned * (u2 - w * n2)
    return Response(e, w, n0, n1, n2, l0, l1, l2, across, brisk, by_c, by_d, by_rest)


def by_constant_of(number: int, s: int, r: Response, forces: Forces) -> float:
    """Return the derivative of a spring's tension by a constant of laws [N per unit].

    Args:
        number: Index of the constant.
    """
    laws, links, values, k = forces.laws, forces.links, forces.values, forces.links.spring[s]
    c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
    return by_constant(links.law[s], number, r.e, r.w, c, d, rest, laws, values)


def pull_back(forces: Forces, time: float, at: NodeState, due: NodeState, by: Values) -> None:
    """Add the derivatives of Σ due.a · a to ``due.x``, ``due.v`` and ``by``.

    Args:
        at: With the accelerations that ``acceleration`` gave.
        due: Derivatives by the state.
        by: Derivatives by the numbers of springs and nodes.
    """
    links, weight = forces.links, due.a
    for node in range(links.inverse.size):
        inverse, total, braked = links.inverse[node], 0.0, 0.0
        if inverse == 0.0:
            continue
        for i in range(3 * node, 3 * node + 3):
            total += weight[i] * (at.a[i] - links.steady[i])
            braked += weight[i] * at.v[i]
            due.v[i] -= links.drag[node] * inverse * weight[i]
        by.mass[node] -= inverse * total
        by.drag[node] -= inverse * braked
    pull_back_memory(forces, at, due, by)
    pull_back_fields(forces, time, at, due, by)
    for s in range(links.low.size):
        p, q = links.low[s], links.high[s]
        mi, mj = links.inverse[p], links.inverse[q]
        if mi == 0.0 and mj == 0.0:
            continue
        i, j, k, r = 3 * p, 3 * q, links.spring[s], response(s, forces, at)
        g0 = mi * weight[i] - mj * weight[j]
        g1 = mi * weight[i + 1] - mj * weight[j + 1]
        g2 = mi * weight[i + 2] - mj * weight[j + 2]
        along = r.n0 * g0 + r.n1 * g1 + r.n2 * g2
        by.stiffness[k] += along * r.by_c
        by.damping[k] += along * r.by_d
        by.rest[k] += along * r.by_rest
        if forces.laws.curved:
            for m in range(by.constants.size):
                by.constants[m] += along * by_constant_of(m, s, r, forces)
        h0 = along * r.l0 + r.across * (g0 - along * r.n0)
        h1 = along * r.l1 + r.across * (g1 - along * r.n1)
        h2 = along * r.l2 + r.across * (g2 - along * r.n2)
        due.x[i] -= h0
        due.x[i + 1] -= h1
        due.x[i + 2] -= h2
        due.x[j] += h0
        due.x[j + 1] += h1
        due.x[j + 2] += h2
        along *= r.brisk
        due.v[i] -= along * r.n0
        due.v[i + 1] -= along * r.n1
        due.v[i + 2] -= along * r.n2
        due.v[j] += along * r.n0
        due.v[j + 1] += along * r.n1
        due.v[j + 2] += along * r.n2


def pull_back_fields(
    forces: Forces, time: float, at: NodeState, due: NodeState, by: Values
) -> None:
    """Add to ``due.x``, ``due.v`` and ``by`` what comes from fields."""
    fields, inverse = forces.fields, forces.links.inverse
    if fields.table.size == 0:
        return
    for node in range(inverse.size):
        for i in range(3 * node, 3 * node + 3):
            fields.weight[i] = inverse[node] * due.a[i]
    for k in range(fields.table.size):
        table, own = fields.table[k], by.fields[fields.first[k] : fields.first[k + 1]]
        call_pull_back(
            fields.pull_back[k], table, time, at.x, at.v, fields.weight, due.x, due.v, own
        )


def push_forward(
    forces: Forces, time: float, at: NodeState, seeds: Seeds, change: NodeState
) -> None:
    """Set ``change.a`` for many changes of positions, velocities and numbers.

    Args:
        at: With the accelerations that ``acceleration`` gave.
        seeds: Changes of the numbers.
        change: Changes of the state, shape (3 node change,).
    """
    links, total = forces.links, seeds.total
    count, own = total.size, 3 * total.size
    for i in range(change.a.size):
        change.a[i] = 0.0
    for s in range(links.low.size):
        p, q = links.low[s], links.high[s]
        if links.inverse[p] == 0.0 and links.inverse[q] == 0.0:
            continue
        k, r = links.spring[s], response(s, forces, at)
        # What the tension changes by for numbers alone.
        for m in range(count):
            total[m] = 0.0
        sow(r.by_c, k, seeds.stiffness, total)
        sow(r.by_d, k, seeds.damping, total)
        sow(r.by_rest, k, seeds.rest, total)
        if forces.laws.curved:
            for b in range(forces.values.constants.size):
                sow(by_constant_of(b, s, r, forces), b, seeds.constants, total)
        k00, k01, k02 = by_place(r.n0, 1.0, 0.0, 0.0, r)
        k10, k11, k12 = by_place(r.n1, 0.0, 1.0, 0.0, r)
        k20, k21, k22 = by_place(r.n2, 0.0, 0.0, 1.0, r)
        b0, b1, b2 = r.brisk * r.n0, r.brisk * r.n1, r.brisk * r.n2
        # Views that are indexed from 0 need no test of whether an index is negative.
        low, high = slice(own * p, own * p + own), slice(own * q, own * q + own)
        x0, v0, a0 = change.x[low], change.v[low], change.a[low]
        x1, v1, a1 = change.x[high], change.v[high], change.a[high]
        for m in range(count):
            y, z = m + count, m + 2 * count
            d0, d1, d2 = x1[m] - x0[m], x1[y] - x0[y], x1[z] - x0[z]
            more = total[m]
            more += b0 * (v1[m] - v0[m]) + b1 * (v1[y] - v0[y]) + b2 * (v1[z] - v0[z])
            f0 = k00 * d0 + k01 * d1 + k02 * d2 + r.n0 * more
            f1 = k10 * d0 + k11 * d1 + k12 * d2 + r.n1 * more
            f2 = k20 * d0 + k21 * d1 + k22 * d2 + r.n2 * more
            a0[m] += f0
            a0[y] += f1
            a0[z] += f2
            a1[m] -= f0
            a1[y] -= f1
            a1[z] -= f2
    push_forward_memory(forces, at, seeds, change)
    push_forward_fields(forces, time, at, seeds, change)
    push_forward_nodes(forces, at, seeds, change)


def push_forward_nodes(forces: Forces, at: NodeState, seeds: Seeds, change: NodeState) -> None:
    """Turn changes of forces into those of accelerations, ``change.a``.

    Args:
        seeds: Changes of the numbers.
        change: Of the state, shape (3 node change,).
    """
    links, count = forces.links, seeds.total.size
    for node in range(links.inverse.size):
        inverse, drag = links.inverse[node], links.drag[node]
        for i in range(3 * node, 3 * node + 3):
            part = slice(count * i, count * (i + 1))
            a, v = change.a[part], change.v[part]
            for m in range(count):
                a[m] = inverse * (a[m] - drag * v[m])
            if inverse > 0.0:
                sow(inverse * (links.steady[i] - at.a[i]), node, seeds.mass, a)
                sow(-inverse * at.v[i], node, seeds.drag, a)


def push_forward_fields(
    forces: Forces, time: float, at: NodeState, seeds: Seeds, change: NodeState
) -> None:
    """Add the changes of the forces of fields to ``change.a``.

    Args:
        seeds: Changes of the numbers.
        change: Of the state, shape (3 node change,).
    """
    count, total = seeds.total.size, seeds.total
    fields = forces.fields
    for k in range(fields.table.size):
        numbers = seeds.fields[count * fields.first[k] : count * fields.first[k + 1]]
        call_push_forward(
            fields.push_forward[k], fields.table[k], time, at.x, at.v, change.x, change.v,
            numbers, change.a, total,
        )  # fmt: skip


def by_place(
    n: float, one: float, two: float, three: float, r: Response
) -> tuple[float, float, float]:
    """Return the derivative of a component of a spring's force by the upper node's position.

    The result is in [N/m].

    Args:
        n: That component of the direction.
        one, two, three: The unit vector of the component.
    """
    return (
        n * r.l0 + r.across * (one - n * r.n0),
        n * r.l1 + r.across * (two - n * r.n1),
        n * r.l2 + r.across * (three - n * r.n2),
    )


def blocks(forces: Forces, at: NodeState, of_x: Stack, of_v: Stack) -> None:
    """Set the derivatives of the forces of springs on their lower nodes.

    Args:
        of_x, of_v: By positions [N/m] and velocities [N s/m] of upper nodes, shape (spring, 3,
            3).
    """
    for s in range(forces.links.low.size):
        r = response(s, forces, at)
        of_x[s, 0, 0], of_x[s, 0, 1], of_x[s, 0, 2] = by_place(r.n0, 1.0, 0.0, 0.0, r)
        of_x[s, 1, 0], of_x[s, 1, 1], of_x[s, 1, 2] = by_place(r.n1, 0.0, 1.0, 0.0, r)
        of_x[s, 2, 0], of_x[s, 2, 1], of_x[s, 2, 2] = by_place(r.n2, 0.0, 0.0, 1.0, r)
        for i, n in enumerate((r.n0, r.n1, r.n2)):
            of_v[s, i, 0] = r.brisk * n * r.n0
            of_v[s, i, 1] = r.brisk * n * r.n1
            of_v[s, i, 2] = r.brisk * n * r.n2
