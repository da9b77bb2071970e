"""Forces of springs that remember, with their derivatives.

A spring of elongation e = L - L0 - p, with the rate w of its length, has the tension

    T = S + g(e, w),    S = f(e) + Σ c1 (e - q),
    q' = (e - q) / τ,    p' = max(0, |S| - F) sign(S) / η;

see ``branches``. The variables q and p are velocities of hidden nodes, each divided by a
``rate``; these count as free nodes of 1 kg, whose forces are the rates of these velocities.
Numbers are c1, 1/τ, F and 1/η, 0 where there is none. A change of the state changes the tension
by what it is in ``springs_derivatives_kernel``, with n·δr - δL0 - δp in place of n·δr - δL0.
Where a spring begins to yield, derivatives jump; p' does not.

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

from math import copysign
from typing import NamedTuple

from tissuec.forces.springs.springs_derivatives_kernel import (
    by_constant_of,
    pull_ends,
    pull_from_ends,
    pulls,
    reach,
    slopes,
    sow,
)
from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    Reach,
    Seeds,
    Slopes,
    SpringMemory,
    Values,
)
from tissuec.kernels.records import Floats


class Stretch(NamedTuple):
    """A spring that remembers in a state.

    Attributes:
        z: What leads from its lower node to the upper one.
        e: Elongation [m].
        tie: Σ c1 [N/m].
        force: S [N].
        tension: T [N].
    """

    z: Reach
    e: float
    tie: float
    force: float
    tension: float


def stretch(n: int, forces: Forces, at: NodeState) -> Stretch:
    """Return a spring in a state."""
    memory, values, v = forces.memory, forces.values, at.v
    s, last = int(memory.spring[n]), memory.slot.shape[1] - 1
    z = reach(int(memory.low[n]), int(memory.high[n]), at)
    e = z.length - values.rest[s]
    if memory.slot[n, last] >= 0:
        e -= v[memory.slot[n, last]] / memory.rate[n, last]
    force, braking = pulls(memory.law[n], s, e, z.w, forces)
    tie = 0.0
    for k in range(last):
        if memory.slot[n, k] >= 0:
            c = values.memory[number_of(k, n, memory)]
            tie += c
            force += c * (e - v[memory.slot[n, k]] / memory.rate[n, k])
    return Stretch(z, e, tie, force, force + braking)


def number_of(row: int, n: int, memory: SpringMemory) -> int:
    """Return the place of a number of a spring among all.

    Args:
        row: c1 of each branch comes first, then 1/τ of each, then F and 1/η.
    """
    return row * memory.springs + memory.spring[n]


def yielding(force: float, limit: float) -> float:
    """Return max(0, |S| - F) sign(S) [N]."""
    return copysign(max(abs(force) - limit, 0.0), force)


def add_memory(forces: Forces, at: NodeState) -> None:
    """Add the forces of springs that remember, and the rates of what they remember."""
    memory, numbers, a = forces.memory, forces.values.memory, at.a
    last = memory.slot.shape[1] - 1
    for n in range(memory.low.size):
        t = stretch(n, forces, at)
        pull_ends(int(memory.low[n]), int(memory.high[n]), t.tension, t.z, a)
        for k in range(last):
            place = memory.slot[n, k]
            if place >= 0:
                q = at.v[place] / memory.rate[n, k]
                a[place] += (
                    memory.rate[n, k] * (t.e - q) * numbers[number_of(last + k, n, memory)]
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
        t = stretch(n, forces, at)
        z, own = t.z, slopes(memory.law[n], s, t.e, t.z.w, forces)
        g0 = inverse[p] * weight[i] - inverse[o] * weight[j]
        g1 = inverse[p] * weight[i + 1] - inverse[o] * weight[j + 1]
        g2 = inverse[p] * weight[i + 2] - inverse[o] * weight[j + 2]
        along = z.n0 * g0 + z.n1 * g1 + z.n2 * g2
        of_force, of_e, of_w = along, along * own.thick, along * own.brisk
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
        of_e += of_force * (own.steep + t.tie)
        for k in range(last):
            place = memory.slot[n, k]
            if place >= 0:
                constant, pace = number_of(k, n, memory), number_of(last + k, n, memory)
                gap = t.e - at.v[place] / memory.rate[n, k]
                h = inverse[place // 3] * weight[place] * memory.rate[n, k]
                by.memory[constant] += of_force * gap
                by.memory[pace] += h * gap
                of_e += h * numbers[pace]
                less = of_force * numbers[constant] + h * numbers[pace]
                due.v[place] -= less / memory.rate[n, k]
        place = memory.slot[n, last]
        if place >= 0:
            due.v[place] -= of_e / memory.rate[n, last]
        by.stiffness[s] += of_force * own.by_c
        by.damping[s] += along * own.by_d
        by.rest[s] += of_force * own.by_rest + along * own.braked - of_e
        if forces.laws.curved:
            for m in range(by.constants.size):
                by.constants[m] += along * by_constant_of(m, memory.law[n], s, t.e, z.w, forces)
        across = t.tension * z.inverse
        pull_from_ends(p, o, (g0, g1, g2), along, of_e, of_w, across, z, due)


def push_forward_memory(forces: Forces, at: NodeState, seeds: Seeds, change: NodeState) -> None:
    """Add to ``change.a`` what comes from springs that remember."""
    memory, numbers = forces.memory, forces.values.memory
    count, last = seeds.total.size, memory.slot.shape[1] - 1
    of_force, of_tension, of_rest = seeds.room[0], seeds.room[1], seeds.room[2]
    for n in range(memory.low.size):
        s = int(memory.spring[n])
        i, j = 3 * int(memory.low[n]), 3 * int(memory.high[n])
        t = stretch(n, forces, at)
        z, own = t.z, slopes(memory.law[n], s, t.e, t.z.w, forces)
        sow_numbers(n, t, own, forces, seeds)
        place, flowing = int(memory.slot[n, last]), 0.0
        if place >= 0:
            flowing = yielding(t.force, numbers[number_of(2 * last, n, memory)])
        for m in range(count):
            d0, d1, d2 = difference(i, j, m, count, change.x)
            along = z.n0 * d0 + z.n1 * d1 + z.n2 * d2
            c0, c1, c2 = (
                (d0 - along * z.n0) * z.inverse,
                (d1 - along * z.n1) * z.inverse,
                (d2 - along * z.n2) * z.inverse,
            )
            e = along - of_rest[m]
            if place >= 0:
                e -= change.v[count * place + m] / memory.rate[n, last]
            w = z.u0 * c0 + z.u1 * c1 + z.u2 * c2
            w0, w1, w2 = difference(i, j, m, count, change.v)
            w += z.n0 * w0 + z.n1 * w1 + z.n2 * w2
            force = of_force[m] + (own.steep + t.tie) * e
            for k in range(last):
                slot = int(memory.slot[n, k])
                if slot >= 0:
                    constant, pace = number_of(k, n, memory), number_of(last + k, n, memory)
                    q = change.v[count * slot + m] / memory.rate[n, k]
                    gap = t.e - at.v[slot] / memory.rate[n, k]
                    force += seeds.memory[count * constant + m] * gap - numbers[constant] * q
                    giving = numbers[pace] * (e - q) + seeds.memory[count * pace + m] * gap
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
            tension = force + of_tension[m] + own.thick * e + own.brisk * w
            f0 = tension * z.n0 + t.tension * c0
            f1 = tension * z.n1 + t.tension * c1
            f2 = tension * z.n2 + t.tension * c2
            for axis, part in enumerate((f0, f1, f2)):
                change.a[count * (i + axis) + m] += part
                change.a[count * (j + axis) + m] -= part


def difference(i: int, j: int, m: int, count: int, of: Floats) -> tuple[float, float, float]:
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


def sow_numbers(n: int, t: Stretch, own: Slopes, forces: Forces, seeds: Seeds) -> None:
    """Set the rows of ``seeds.room`` to what numbers change S, T - S and L0 by.

    Args:
        t: The spring in a state.
        own: Its derivatives without branches.
    """
    of_force, of_tension, of_rest = seeds.room[0], seeds.room[1], seeds.room[2]
    s, law = int(forces.memory.spring[n]), forces.memory.law[n]
    for m in range(of_force.size):
        of_force[m] = of_tension[m] = of_rest[m] = 0.0
    sow(own.by_c, s, seeds.stiffness, of_force)
    sow(own.by_rest, s, seeds.rest, of_force)
    sow(own.by_d, s, seeds.damping, of_tension)
    sow(own.braked, s, seeds.rest, of_tension)
    sow(1.0, s, seeds.rest, of_rest)
    if forces.laws.curved:
        for b in range(forces.values.constants.size):
            by = by_constant_of(b, law, s, t.e, t.z.w, forces)
            sow(by, b, seeds.constants, of_tension)
