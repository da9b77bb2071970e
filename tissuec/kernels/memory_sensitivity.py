"""Forces of springs that remember, with their derivatives.

A spring of elongation e = L - L0 - p, with the rate w of its length, has the tension

    T = S + g(e, w),    S = f(e) + Σ c1 (e - q),
    q' = (e - q) / τ,    p' = max(0, |S| - F) sign(S) / η;

see ``forces.branches``. The variables q and p are velocities of hidden nodes, each divided by a
``rate``; these count as free nodes of 1 kg, whose forces are the rates of these velocities.
Numbers are c1, 1/τ, F and 1/η, 0 where there is none. A change of the state changes the tension
by what it is in ``kernels.sensitivity``, with n·δr - δL0 - δp in place of n·δr - δL0. Where a
spring begins to yield, derivatives jump; p' does not.

Shared arguments:
    n: Index of the spring in ``SpringMemory``.
    memory: The springs that remember.
    due: Derivatives by the state, added to.
    by: Derivatives by the numbers, added to.
    seeds: Changes of the numbers.
    change: Changes of the state, shape (3 node change,).
    forces: Everything that accelerations follow from, beside the state.
    at: A state with the shapes and units of ``NodeState``.
"""

from math import copysign, sqrt
from typing import NamedTuple

from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    Seeds,
    Sparse,
    SpringMemory,
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
from tissuec.kernels.records import Floats


class Stretch(NamedTuple):
    """A spring that remembers in a state.

    Attributes:
        length: [m].
        n0, n1, n2: Direction from the lower node to the upper one.
        u0, u1, u2: Velocity of the upper node less that of the lower one [m/s].
        e, w: Elongation [m], and the rate of the length [m/s].
        tie: Σ c1 [N/m].
        pull: Σ c1 (e - q) [N].
    """

    length: float
    n0: float
    n1: float
    n2: float
    u0: float
    u1: float
    u2: float
    e: float
    w: float
    tie: float
    pull: float


def stretch(
    n: int, memory: SpringMemory, rest: float, numbers: Floats, x: Floats, v: Floats
) -> Stretch:
    """Return a spring in a state.

    Args:
        rest: L0 [m].
        numbers: See ``number_of``.
        x, v: Positions and velocities of all nodes, shape (3 node,).
    """
    i, j = int(3 * memory.low[n]), int(3 * memory.high[n])
    r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
    u0, u1, u2 = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
    length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
    inverse = 1.0 / length if length > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    e, last = length - rest, memory.slot.shape[1] - 1
    if memory.slot[n, last] >= 0:
        e -= v[memory.slot[n, last]] / memory.rate[n, last]
    tie = pull = 0.0
    for k in range(last):
        if memory.slot[n, k] >= 0:
            c = numbers[number_of(k, n, memory)]
            tie += c
            pull += c * (e - v[memory.slot[n, k]] / memory.rate[n, k])
    return Stretch(length, n0, n1, n2, u0, u1, u2, e, n0 * u0 + n1 * u1 + n2 * u2, tie, pull)


def number_of(row: int, n: int, memory: SpringMemory) -> int:
    """Return the place of a number of a spring among all.

    Args:
        row: c1 of each branch comes first, then 1/τ of each, then F and 1/η.
    """
    return row * memory.springs + memory.spring[n]


def yielding(force: float, limit: float) -> float:
    """Return max(0, |S| - F) sign(S) [N]."""
    return copysign(max(abs(force) - limit, 0.0), force)


class Terms(NamedTuple):
    """Tensions of a spring that remembers, and their derivatives.

    Attributes:
        force: S [N].
        tension: T [N].
        steep, thick: f' [N/m], and ∂g/∂e [N/m].
        brisk: ∂g/∂w [N s/m].
        by_c, by_rest: Of f, by c and L0.
        by_d, braked: Of g, by d and L0.
    """

    force: float
    tension: float
    steep: float
    thick: float
    brisk: float
    by_c: float
    by_rest: float
    by_d: float
    braked: float


def terms(n: int, forces: Forces, z: Stretch) -> Terms:
    """Return the tensions of a spring.

    Args:
        z: The spring in a state.
    """
    laws, values, law = forces.laws, forces.values, forces.memory.law[n]
    s = int(forces.memory.spring[n])
    c, d, rest = values.stiffness[s], values.damping[s], values.rest[s]
    force, braking, steep, thick, brisk = c * z.e, d * z.w, c, 0.0, d
    by_c, by_rest, by_d, braked = z.e, 0.0, z.w, 0.0
    if laws.curved:
        force = pull(law, z.e, c, rest, laws, values)
        braking = brake(law, z.e, z.w, d, rest, laws, values)
        steep = slope(law, z.e, c, rest, laws, values)
        thick = brake_by_e(law, z.e, z.w, d, rest, laws, values)
        brisk = brake_slope(law, z.e, z.w, d, rest, laws, values)
        by_c = pull_by_c(law, z.e, c, rest, laws, values)
        by_rest = pull_by_rest(law, z.e, c, rest, laws, values)
        by_d = brake_by_d(law, z.e, z.w, d, rest, laws, values)
        braked = brake_by_rest(law, z.e, z.w, d, rest, laws, values)
    force += z.pull
    return Terms(force, force + braking, steep, thick, brisk, by_c, by_rest, by_d, braked)


def by_constant_at(number: int, n: int, z: Stretch, forces: Forces) -> float:
    """Return the derivative of f + g of a spring by a constant of laws [N per unit].

    Args:
        number: Index of the constant.
        z: The spring in a state.
    """
    laws, values, s = forces.laws, forces.values, int(forces.memory.spring[n])
    c, d, rest = values.stiffness[s], values.damping[s], values.rest[s]
    return by_constant(forces.memory.law[n], number, z.e, z.w, c, d, rest, laws, values)


def accelerate_memory(forces: Forces, at: NodeState) -> None:
    """Add the forces of springs that remember, and the rates of what they remember."""
    memory, numbers, a = forces.memory, forces.values.memory, at.a
    last = memory.slot.shape[1] - 1
    for n in range(memory.low.size):
        i, j = int(3 * memory.low[n]), int(3 * memory.high[n])
        z = stretch(n, memory, forces.values.rest[int(memory.spring[n])], numbers, at.x, at.v)
        t = terms(n, forces, z)
        for axis, direction in enumerate((z.n0, z.n1, z.n2)):
            a[i + axis] += t.tension * direction
            a[j + axis] -= t.tension * direction
        for k in range(last):
            place = memory.slot[n, k]
            if place >= 0:
                q = at.v[place] / memory.rate[n, k]
                a[place] += (
                    memory.rate[n, k] * (z.e - q) * numbers[number_of(last + k, n, memory)]
                )
        place = memory.slot[n, last]
        if place >= 0:
            flow = yielding(t.force, numbers[number_of(2 * last, n, memory)])
            a[place] += (
                memory.rate[n, last] * flow * numbers[number_of(2 * last + 1, n, memory)]
            )


def pull_back_memory(forces: Forces, at: NodeState, due: NodeState, by: Values) -> None:
    """Add to ``due.x``, ``due.v`` and ``by`` what comes from springs that remember.

    With g the difference of the weights at both ends, h those of the rates of variables, and
    φ = max(0, |S| - F) sign(S), the sum is T n·g + Σ h rate (e - q)/τ + h rate φ/η. Its
    derivatives by S, e and w, all else being given, are ``of_force``, ``of_e`` and ``of_w``.
    """
    memory, values, weight = forces.memory, forces.values, due.a
    numbers, inverse = values.memory, forces.links.inverse
    last = memory.slot.shape[1] - 1
    for n in range(memory.low.size):
        p, o, s = int(memory.low[n]), int(memory.high[n]), int(memory.spring[n])
        i, j = 3 * p, 3 * o
        z = stretch(n, memory, values.rest[s], numbers, at.x, at.v)
        t = terms(n, forces, z)
        g0 = inverse[p] * weight[i] - inverse[o] * weight[j]
        g1 = inverse[p] * weight[i + 1] - inverse[o] * weight[j + 1]
        g2 = inverse[p] * weight[i + 2] - inverse[o] * weight[j + 2]
        along = z.n0 * g0 + z.n1 * g1 + z.n2 * g2
        of_force, of_e, of_w = along, along * t.thick, along * t.brisk
        flows, place = False, memory.slot[n, last]
        if place >= 0:
            limit, fluid = number_of(2 * last, n, memory), number_of(2 * last + 1, n, memory)
            h = inverse[place // 3] * weight[place] * memory.rate[n, last]
            flow = yielding(t.force, numbers[limit])
            by.memory[fluid] += h * flow
            flows = flow != 0.0
            if flows:
                of_force += h * numbers[fluid]
                by.memory[limit] -= h * numbers[fluid] * copysign(1.0, t.force)
        of_e += of_force * (t.steep + z.tie)
        for k in range(last):
            place = memory.slot[n, k]
            if place >= 0:
                constant, pace = number_of(k, n, memory), number_of(last + k, n, memory)
                own = z.e - at.v[place] / memory.rate[n, k]
                h = inverse[place // 3] * weight[place] * memory.rate[n, k]
                by.memory[constant] += of_force * own
                by.memory[pace] += h * own
                of_e += h * numbers[pace]
                less = of_force * numbers[constant] + h * numbers[pace]
                due.v[place] -= less / memory.rate[n, k]
        place = memory.slot[n, last]
        if place >= 0:
            due.v[place] -= of_e / memory.rate[n, last]
        by.stiffness[s] += of_force * t.by_c
        by.damping[s] += along * t.by_d
        by.rest[s] += of_force * t.by_rest + along * t.braked - of_e
        if forces.laws.curved:
            for m in range(by.constants.size):
                by.constants[m] += along * by_constant_at(m, n, z, forces)
        weights = g0, g1, g2
        pull_back_ends(i, j, weights, along, of_e, of_w, t.tension, z, due)


def pull_back_ends(
    i: int,
    j: int,
    weights: tuple[float, float, float],
    along: float,
    of_e: float,
    of_w: float,
    tension: float,
    z: Stretch,
    due: NodeState,
) -> None:
    """Add to ``due.x`` and ``due.v`` of the nodes of a spring.

    Args:
        i, j: Indices of their first components.
        weights: The difference of the weights of the forces on them [1/kg].
        along: Its part along the spring.
        of_e, of_w: Derivatives by elongation and its rate.
        tension: T [N].
        z: The spring in a state.
    """
    inverse = 1.0 / z.length if z.length > 0.0 else 0.0
    across, turned = tension * inverse, of_w * inverse
    n0, n1, n2 = z.n0, z.n1, z.n2
    h0 = of_e * n0 + turned * (z.u0 - z.w * n0) + across * (weights[0] - along * n0)
    h1 = of_e * n1 + turned * (z.u1 - z.w * n1) + across * (weights[1] - along * n1)
    h2 = of_e * n2 + turned * (z.u2 - z.w * n2) + across * (weights[2] - along * n2)
    for axis, place in enumerate((h0, h1, h2)):
        due.x[i + axis] -= place
        due.x[j + axis] += place
    for axis, direction in enumerate((n0, n1, n2)):
        due.v[i + axis] -= of_w * direction
        due.v[j + axis] += of_w * direction


def push_forward_memory(forces: Forces, at: NodeState, seeds: Seeds, change: NodeState) -> None:
    """Add to ``change.a`` what comes from springs that remember."""
    memory, values, numbers = forces.memory, forces.values, forces.values.memory
    count, last = seeds.total.size, memory.slot.shape[1] - 1
    of_force, of_tension, of_rest = seeds.room[0], seeds.room[1], seeds.room[2]
    for n in range(memory.low.size):
        s = int(memory.spring[n])
        i, j = 3 * int(memory.low[n]), 3 * int(memory.high[n])
        z = stretch(n, memory, values.rest[s], numbers, at.x, at.v)
        t = terms(n, forces, z)
        sow_terms(n, t, z, forces, seeds)
        place, flowing = int(memory.slot[n, last]), 0.0
        if place >= 0:
            flowing = yielding(t.force, numbers[number_of(2 * last, n, memory)])
        inverse = 1.0 / z.length if z.length > 0.0 else 0.0
        for m in range(count):
            d0, d1, d2 = between(i, j, m, count, change.x)
            along = z.n0 * d0 + z.n1 * d1 + z.n2 * d2
            c0, c1, c2 = (
                (d0 - along * z.n0) * inverse,
                (d1 - along * z.n1) * inverse,
                (d2 - along * z.n2) * inverse,
            )
            e = along - of_rest[m]
            if place >= 0:
                e -= change.v[count * place + m] / memory.rate[n, last]
            w = z.u0 * c0 + z.u1 * c1 + z.u2 * c2
            w0, w1, w2 = between(i, j, m, count, change.v)
            w += z.n0 * w0 + z.n1 * w1 + z.n2 * w2
            force = of_force[m] + (t.steep + z.tie) * e
            for k in range(last):
                slot = int(memory.slot[n, k])
                if slot >= 0:
                    constant, pace = number_of(k, n, memory), number_of(last + k, n, memory)
                    q = change.v[count * slot + m] / memory.rate[n, k]
                    own = z.e - at.v[slot] / memory.rate[n, k]
                    force += seeds.memory[count * constant + m] * own - numbers[constant] * q
                    giving = numbers[pace] * (e - q) + seeds.memory[count * pace + m] * own
                    change.a[count * slot + m] += memory.rate[n, k] * giving
            if place >= 0:
                limit, fluid = (
                    number_of(2 * last, n, memory),
                    number_of(2 * last + 1, n, memory),
                )
                flow = flowing * seeds.memory[count * fluid + m]
                if flowing != 0.0:
                    less = copysign(1.0, t.force) * seeds.memory[count * limit + m]
                    flow += numbers[fluid] * (force - less)
                change.a[count * place + m] += memory.rate[n, last] * flow
            tension = force + of_tension[m] + t.thick * e + t.brisk * w
            f0 = tension * z.n0 + t.tension * c0
            f1 = tension * z.n1 + t.tension * c1
            f2 = tension * z.n2 + t.tension * c2
            for axis, part in enumerate((f0, f1, f2)):
                change.a[count * (i + axis) + m] += part
                change.a[count * (j + axis) + m] -= part


def between(i: int, j: int, m: int, count: int, of: Floats) -> tuple[float, float, float]:
    """Return the difference of one change of two nodes.

    Args:
        i, j: Indices of their first components.
        m: Index of the change.
        count: How many there are.
        of: Changes in any unit, shape (3 node change,).
    """
    low, high = count * i + m, count * j + m
    return (
        of[high] - of[low],
        of[high + count] - of[low + count],
        of[high + 2 * count] - of[low + 2 * count],
    )


def sow_terms(n: int, t: Terms, z: Stretch, forces: Forces, seeds: Seeds) -> None:
    """Set the rows of ``seeds.room`` to what numbers change S, T - S and L0 by.

    Args:
        t: Tensions of the spring.
        z: The spring in a state.
        seeds: Changes of the numbers.
    """
    of_force, of_tension, of_rest = seeds.room[0], seeds.room[1], seeds.room[2]
    s = int(forces.memory.spring[n])
    for m in range(of_force.size):
        of_force[m] = of_tension[m] = of_rest[m] = 0.0
    sow(t.by_c, s, seeds.stiffness, of_force)
    sow(t.by_rest, s, seeds.rest, of_force)
    sow(t.by_d, s, seeds.damping, of_tension)
    sow(t.braked, s, seeds.rest, of_tension)
    sow(1.0, s, seeds.rest, of_rest)
    if forces.laws.curved:
        for b in range(forces.values.constants.size):
            sow(by_constant_at(b, n, z, forces), b, seeds.constants, of_tension)


def sow(factor: float, row: int, matrix: Sparse, out: Floats) -> None:
    """Add a multiple of a row of a matrix to a vector.

    Args:
        factor: Any factor.
        row: Index of the row.
        matrix: The matrix.
        out: Vector of the row's unit times that of ``factor``, shape (column,).
    """
    for z in range(matrix.rows[row], matrix.rows[row + 1]):
        out[matrix.columns[z]] += factor * matrix.entries[z]
