"""Prescribed motions and time-dependent loads, evaluated from tables inside kernels.

Between two knots of all profiles every profile is one curve, a polynomial or a sine:
s(t) = Σ powerₖ uᵏ + amplitude sin(angular u), u = t - origin. ``engine.acting``
writes these tables again for each stretch between knots, so that kernels need no cases.
"""

from math import cos, sin

from tissuec.kernels.records import BoundaryConditions, Floats, GuideTable


def curve(which: int, time: float, acts: BoundaryConditions) -> tuple[float, float]:
    """Return the value of a curve, dimensionless, and its rate [1/s].

    Args:
        which: Index of the curve.
    """
    u = time - acts.origin[which]
    value = rate = 0.0
    for k in range(acts.power.shape[1] - 1, -1, -1):
        rate = rate * u + value
        value = value * u + acts.power[which, k]
    angular = acts.angular[which]
    if angular != 0.0:
        value += acts.amplitude[which] * sin(angular * u)
        rate += acts.amplitude[which] * angular * cos(angular * u)
    return value, rate


def total(
    act: int, time: float, acts: BoundaryConditions
) -> tuple[float, float, float, float, float, float]:
    """Return the sum of an act's terms and of their rates, three components each.

    Displacements in [m] and [m/s] for motions, forces in [N] and [N/s] for loads.
    """
    s0 = s1 = s2 = u0 = u1 = u2 = 0.0
    for term in range(acts.term_first[act], acts.term_first[act + 1]):
        factor, rate = curve(acts.term_curve[term], time, acts)
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


def turning(act: int, time: float, acts: BoundaryConditions) -> tuple[float, float, float]:
    """Return the cosine and sine of an act's angle, and the rate of the angle [rad/s]."""
    factor, rate = curve(acts.turn_curve[act], time, acts)
    angle = acts.turn_angle[act]
    return cos(angle * factor), sin(angle * factor), angle * rate


def put_driven(time: float, x: Floats, v: Floats, acts: BoundaryConditions) -> None:
    """Set positions and velocities of driven nodes to those that their motions prescribe."""
    for act in range(acts.motions):
        s0, s1, s2, u0, u1, u2 = total(act, time, acts)
        for entry in range(acts.first[act], acts.first[act + 1]):
            i = 3 * acts.nodes[entry]
            x0, x1, x2 = (
                acts.base[entry, 0] + s0,
                acts.base[entry, 1] + s1,
                acts.base[entry, 2] + s2,
            )
            if acts.partial[act] == 1:
                approach(x0, x1, x2, entry, i, x, acts)
                approach(u0, u1, u2, entry, i, v, acts)
            else:
                x[i], x[i + 1], x[i + 2] = x0, x1, x2
                v[i], v[i + 1], v[i + 2] = u0, u1, u2
        if acts.turn_curve[act] >= 0:
            turn(act, time, x, v, acts)


def approach(
    p0: float, p1: float, p2: float, entry: int, i: int, x: Floats, acts: BoundaryConditions
) -> None:
    """Set the part of a vector in the directions of a motion to that of another, p.

    Args:
        entry: Of the node in the motion.
        i: Number of its first component.
        x: Vectors of all nodes in any unit, shape (3 node,); changed in place.
    """
    d0, d1, d2 = p0 - x[i], p1 - x[i + 1], p2 - x[i + 2]
    for axis in range(3):
        x[i + axis] += (
            acts.along[entry, 3 * axis] * d0
            + acts.along[entry, 3 * axis + 1] * d1
            + acts.along[entry, 3 * axis + 2] * d2
        )


def turn(act: int, time: float, x: Floats, v: Floats, acts: BoundaryConditions) -> None:
    """Add the displacement and velocity of an act's rotation to its nodes.

    Rodrigues' formula: R r - r = (n × r) sin θ - (r - n n·r) (1 - cos θ).
    """
    cosine, sine, spin = turning(act, time, acts)
    n0, n1, n2 = acts.turn_axis[act, 0], acts.turn_axis[act, 1], acts.turn_axis[act, 2]
    c0, c1, c2 = acts.turn_centre[act, 0], acts.turn_centre[act, 1], acts.turn_centre[act, 2]
    for entry in range(acts.first[act], acts.first[act + 1]):
        i = 3 * acts.nodes[entry]
        r0, r1, r2 = (
            acts.base[entry, 0] - c0,
            acts.base[entry, 1] - c1,
            acts.base[entry, 2] - c2,
        )
        along = n0 * r0 + n1 * r1 + n2 * r2
        a0, a1, a2 = r0 - along * n0, r1 - along * n1, r2 - along * n2
        k0, k1, k2 = n1 * r2 - n2 * r1, n2 * r0 - n0 * r2, n0 * r1 - n1 * r0
        x[i] += k0 * sine - a0 * (1.0 - cosine)
        x[i + 1] += k1 * sine - a1 * (1.0 - cosine)
        x[i + 2] += k2 * sine - a2 * (1.0 - cosine)
        # The velocity n × R r lies across the axis: k cos θ - a sin θ.
        v[i] += spin * (k0 * cosine - a0 * sine)
        v[i + 1] += spin * (k1 * cosine - a1 * sine)
        v[i + 2] += spin * (k2 * cosine - a2 * sine)


def guide(a: Floats, v: Floats, inverse_mass: Floats, guides: GuideTable) -> float:
    """Leave of accelerations their part in the free directions of guided nodes.

    Returns:
        The power of what guides them [W].
    """
    power = 0.0
    for k in range(guides.nodes.size):
        node, i = guides.nodes[k], 3 * guides.nodes[k]
        a0, a1, a2 = a[i], a[i + 1], a[i + 2]
        for axis in range(3):
            j = i + axis
            before = a[j]
            a[j] = (
                guides.within[k, 3 * axis] * a0
                + guides.within[k, 3 * axis + 1] * a1
                + guides.within[k, 3 * axis + 2] * a2
            )
            if inverse_mass[node] > 0.0:
                power -= (before - a[j]) * v[j] / inverse_mass[node]
    return power


def prescribed(v: Floats, inverse_mass: Floats, guides: GuideTable) -> float:
    """Return Σ m v² of guided nodes in the directions in which they are held [J]."""
    total = 0.0
    for k in range(guides.nodes.size):
        node, i = guides.nodes[k], 3 * guides.nodes[k]
        if inverse_mass[node] > 0.0:
            for axis in range(3):
                free = (
                    guides.within[k, 3 * axis] * v[i]
                    + guides.within[k, 3 * axis + 1] * v[i + 1]
                    + guides.within[k, 3 * axis + 2] * v[i + 2]
                )
                total += (v[i + axis] - free) ** 2 / inverse_mass[node]
    return total


def pull_free(
    time: float, v: Floats, f: Floats, inverse_mass: Floats, acts: BoundaryConditions
) -> float:
    """Add time-dependent loads to the forces of free nodes; return their power [W]."""
    power = 0.0
    for act in range(acts.motions, acts.first.size - 1):
        s0, s1, s2, _, _, _ = total(act, time, acts)
        for entry in range(acts.first[act], acts.first[act + 1]):
            node, share = acts.nodes[entry], acts.share[entry]
            if inverse_mass[node] > 0.0:
                i = 3 * node
                f[i] += share * s0
                f[i + 1] += share * s1
                f[i + 2] += share * s2
                power += share * (s0 * v[i] + s1 * v[i + 1] + s2 * v[i + 2])
    return float(power)
