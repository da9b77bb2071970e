"""Prescribed motions and time-dependent loads, evaluated from tables inside kernels.

The same courses and motions as ``tissuec.courses`` and ``tissuec.situation`` describe; their
formulas stand there.
"""

from math import cos, pi, sin

from tissuec.kernels.records import Acts, Floats

CONSTANT, RAMP, SMOOTH, SINE, TABLE = range(5)


def inside(time: float, window: Floats) -> float:
    """Return the time, kept off the ends of the stretch between two events.

    A motion that ends or begins at such an end jumps in velocity there; the side from which it
    is seen must be the one that is being stepped through.
    """
    return min(max(time, window[0]), window[1])


def course(which: int, time: float, acts: Acts) -> tuple[float, float]:
    """Return factor and rate [1/s] of a course."""
    kind, start, stop = (
        acts.course_kind[which],
        acts.course_start[which],
        acts.course_stop[which],
    )
    since = min(max(time, start), stop) - start
    moving = 1.0 if start <= time <= stop else 0.0
    if kind == CONSTANT:
        return 1.0, 0.0
    if kind == SINE:
        angular = 2.0 * pi * acts.course_frequency[which]
        return sin(angular * since), moving * angular * cos(angular * since)
    if kind == TABLE:
        return hermite(acts.knot_first[which], acts.knot_first[which + 1], since, moving, acts)
    length = stop - start
    p = since / length
    if kind == RAMP:
        return p, moving / length
    rate = 30.0 * p * p * (1.0 - p) * (1.0 - p) / length
    return p * p * p * (10.0 + p * (6.0 * p - 15.0)), rate


def hermite(low: int, high: int, t: float, moving: float, acts: Acts) -> tuple[float, float]:
    """Return a piecewise cubic and its derivative between the knots ``low`` to ``high``."""
    i, last = low, high - 2
    while last > i:
        middle = (i + last + 1) // 2
        if acts.knot_time[middle] <= t:
            i = middle
        else:
            last = middle - 1
    h = acts.knot_time[i + 1] - acts.knot_time[i]
    p = min(max((t - acts.knot_time[i]) / h, 0.0), 1.0)
    a, b = acts.knot_value[i], acts.knot_value[i + 1]
    ma, mb = acts.knot_slope[i] * h, acts.knot_slope[i + 1] * h
    c2, c3 = 3.0 * (b - a) - 2.0 * ma - mb, 2.0 * (a - b) + ma + mb
    rate = moving * (ma + p * (2.0 * c2 + 3.0 * p * c3)) / h
    return a + p * (ma + p * (c2 + p * c3)), rate


def total(act: int, time: float, acts: Acts) -> tuple[float, float, float, float, float, float]:
    """Return the sum of an act's terms and of their rates, three components each."""
    s0 = s1 = s2 = u0 = u1 = u2 = 0.0
    for term in range(acts.term_first[act], acts.term_first[act + 1]):
        factor, rate = course(acts.term_course[term], time, acts)
        t0, t1, t2 = (
            acts.term_vector[term, 0],
            acts.term_vector[term, 1],
            acts.term_vector[term, 2],
        )
        s0 += factor * t0
        s1 += factor * t1
        s2 += factor * t2
        u0 += rate * t0
        u1 += rate * t1
        u2 += rate * t2
    return s0, s1, s2, u0, u1, u2


def put_driven(time: float, x: Floats, v: Floats, acts: Acts) -> None:
    """Put driven nodes where their motions have them."""
    time = inside(time, acts.window)
    for act in range(acts.motions):
        s0, s1, s2, u0, u1, u2 = total(act, time, acts)
        turns = acts.turn_course[act] >= 0
        cosine, sine, spin = 1.0, 0.0, 0.0
        if turns:
            factor, rate = course(acts.turn_course[act], time, acts)
            cosine, sine = (
                cos(acts.turn_angle[act] * factor),
                sin(acts.turn_angle[act] * factor),
            )
            spin = acts.turn_angle[act] * rate
        n0, n1, n2 = acts.turn_axis[act, 0], acts.turn_axis[act, 1], acts.turn_axis[act, 2]
        c0, c1, c2 = (
            acts.turn_centre[act, 0],
            acts.turn_centre[act, 1],
            acts.turn_centre[act, 2],
        )
        for entry in range(acts.first[act], acts.first[act + 1]):
            i = 3 * acts.nodes[entry]
            b0, b1, b2 = acts.base[entry, 0], acts.base[entry, 1], acts.base[entry, 2]
            if turns:
                # Rodrigues' formula, split into the parts along and across the axis.
                r0, r1, r2 = b0 - c0, b1 - c1, b2 - c2
                along = n0 * r0 + n1 * r1 + n2 * r2
                a0, a1, a2 = along * n0, along * n1, along * n2
                k0, k1, k2 = n1 * r2 - n2 * r1, n2 * r0 - n0 * r2, n0 * r1 - n1 * r0
                r0 = a0 + (r0 - a0) * cosine + k0 * sine
                r1 = a1 + (r1 - a1) * cosine + k1 * sine
                r2 = a2 + (r2 - a2) * cosine + k2 * sine
                x[i], x[i + 1], x[i + 2] = c0 + r0 + s0, c1 + r1 + s1, c2 + r2 + s2
                v[i] = u0 + spin * (n1 * r2 - n2 * r1)
                v[i + 1] = u1 + spin * (n2 * r0 - n0 * r2)
                v[i + 2] = u2 + spin * (n0 * r1 - n1 * r0)
            else:
                x[i], x[i + 1], x[i + 2] = b0 + s0, b1 + s1, b2 + s2
                v[i], v[i + 1], v[i + 2] = u0, u1, u2


def pull_free(time: float, v: Floats, f: Floats, inverse_mass: Floats, acts: Acts) -> float:
    """Add time-dependent loads to the forces of free nodes; return their power [W]."""
    time = inside(time, acts.window)
    power = 0.0
    for act in range(acts.motions, acts.first.size - 1):
        s0, s1, s2, _, _, _ = total(act, time, acts)
        for entry in range(acts.first[act], acts.first[act + 1]):
            node = acts.nodes[entry]
            if inverse_mass[node] > 0.0:
                i = 3 * node
                f[i] += s0
                f[i + 1] += s1
                f[i + 2] += s2
                power += s0 * v[i] + s1 * v[i + 1] + s2 * v[i + 2]
    return power
