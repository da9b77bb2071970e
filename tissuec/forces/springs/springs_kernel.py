"""Forces of springs as scalar loops, to be compiled; they also run as slow Python.

Force on a spring's lower node i from its upper node j, r = x_j - x_i, L = |r|:
T = c e + d w with e = L - L0 and w = r·(v_j - v_i) / L, or what laws say instead, and what
branches add; force T r / L. Flags in capitals are constants of a variant. Laws are compiled by
themselves and called by their address: ``tissuec.kernels``.

Shared arguments:
    s: Index of the spring.
    i, j: Indices of the first components of its lower and upper node in ``x`` and ``v``.
    e: Elongation of the spring [m].
    length: Its length [m].
    start, stop: Range of lower nodes, ``stop`` excluded.
    x_end, v_end: Positions [m] and velocities [m/s] at the end of the step, shape (3 node,).
"""

from math import inf, sqrt

import numpy as np

from tissuec.forces.springs.branches_kernel import flow, flowed, relax
from tissuec.forces.springs.pairs_kernel import pad_states, pull_pairs
from tissuec.forces.springs.rest_length_kernel import reel, reel_rate
from tissuec.kernels.chunks import clear_sums, total_sums
from tissuec.kernels.records import Floats, Net, Rows
from tissuec.kernels.thread_loops import items_of, share
from tissuec.kernels.vectors import TINY
from tissuec.laws import LINEAR
from tissuec.laws.code import functions

OF_LAWS = True  # springs may have laws, relax or flow
pull, slope, side, *_viscous = functions((LINEAR,)).values()
brake, brake_slope, brake_by_e, brake_side = _viscous

# Part of a spring's length, along where it pointed, that a step must leave of it (and have
# begun with) for stages on the way not to see it turned over.
LEFT = 0.1
STIFFEST = 1e30  # viscosity in a matrix [N s/m]
# Unsigned, so that no index has to be tested for being negative.
ONE, TWO = np.uint64(1), np.uint64(2)


def springs(x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> bool:
    """Set the forces of springs; return whether one is near to breaking."""
    chunks = net.chunks
    if not OF_LAWS:
        share(net.team, pad_states, (x, v, chunks.states))
    share(net.team, pull_chunks, (x, v, net))
    share(net.team, total_sums, (f, chunks))
    near = False
    for chunk in range(chunks.node.size - 1):
        power[1] += net.team.lost[chunk]
        near |= net.team.near[chunk] > 0
    return near


def pull_chunks(part: int, parts: int, x: Floats, v: Floats, net: Net) -> None:
    """Add up the forces of the springs of some chunks.

    Args:
        part: Index of this thread's share.
        parts: Number of shares.
    """
    chunks = net.chunks
    begin, end = items_of(part, parts, chunks.node.size - 1)
    for chunk in range(begin, end):
        clear_sums(chunk, chunks)
        start, stop = chunks.node[chunk], chunks.node[chunk + 1]
        if OF_LAWS:
            lost, near = pull_of_laws(start, stop, x, v, net)
        else:
            one, other = np.uint64(net.first[start]), np.uint64(net.first[stop])
            lost, near = pull_pairs(one, other, net.team.each[part], net)
        net.team.lost[chunk], net.team.near[chunk] = lost, near


def pull_of_laws(start: int, stop: int, x: Floats, v: Floats, net: Net) -> tuple[float, bool]:
    """Add the forces of springs that may have laws, relax, flow or be linear.

    Returns:
        The power that they dissipate [W], and whether one is near to breaking.
    """
    first, other, law = net.first, net.other, net.law
    stiffness, damping, rest = net.stiffness, net.damping, net.rest
    sums, to = net.chunks.sums, net.chunks.to
    limit, limit_pressed = net.near, net.near_crush
    near = False
    dissipated = 0.0
    for node in range(start, stop):
        i = np.uint64(3 * node)
        x0, x1, x2 = x[i], x[i + ONE], x[i + TWO]
        v0, v1, v2 = v[i], v[i + ONE], v[i + TWO]
        f0 = f1 = f2 = 0.0
        for s in range(first[node], first[node + 1]):
            j = np.uint64(other[s])
            r0, r1, r2 = x[j] - x0, x[j + ONE] - x1, x[j + TWO] - x2
            length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
            inverse = 1.0 / (length + TINY)
            e = length - rest[s]
            if net.inelastic:
                e -= flowed(s, v, net.internal)
            tension = stiffness[s] * e
            if law[s] > 0:
                tension = pull(law[s], e, stiffness[s], rest[s], net)
            if net.inelastic:
                pull_of_branches, lost = relax(s, e, v, net.internal)
                tension += pull_of_branches
                dissipated += lost + flow(s, tension, net.internal)
            closing = (
                r0 * (v[j] - v0) + r1 * (v[j + ONE] - v1) + r2 * (v[j + TWO] - v2)
            ) * inverse
            braking = damping[s] * closing
            if law[s] > 0:
                braking = brake(law[s], e, closing, damping[s], rest[s], net)
            tension += braking
            dissipated += braking * closing
            near |= tension > limit[s] or tension < -limit_pressed[s]
            tension *= inverse
            f0 += tension * r0
            f1 += tension * r1
            f2 += tension * r2
            k = np.uint64(to[s])
            sums[k] -= tension * r0
            sums[k + ONE] -= tension * r1
            sums[k + TWO] -= tension * r2
        k = np.uint64(4 * node)
        sums[k] += f0
        sums[k + ONE] += f1
        sums[k + TWO] += f2
    return dissipated, near


def find_sides(time: float, x: Floats, v: Floats, out: Rows, net: Net) -> None:
    """Set ``out`` to the side of each corner of the law on which a spring is.

    Args:
        out: Sides for spring forces, for dashpot forces and for yielding, dimensionless, shape
            (3, spring).
    """
    first, other, law, rest = net.first, net.other, net.law, net.rest
    if net.reeled:
        reel(time, rest, net.reels, net.acts)
    for node in range(first.size - 1):
        i = np.uint64(3 * node)
        for s in range(first[node], first[node + 1]):
            if law[s] > 0 or net.inelastic:
                e, w = stretching(s, i, np.uint64(other[s]), x, v, net)
                out[0, s] = side(law[s], e, net.stiffness[s], rest[s], net)
                out[1, s] = brake_side(law[s], e, w, net.damping[s], rest[s], net)
                if net.inelastic:
                    out[2, s] = abs(pull_of(s, e, v, net)) > net.internal.limit[s]


def stretching(
    s: int, i: np.uint64, j: np.uint64, x: Floats, v: Floats, net: Net
) -> tuple[float, float]:
    """Return the elongation of a spring between two nodes [m], and its rate [m/s]."""
    r0, r1, r2 = x[j] - x[i], x[j + ONE] - x[i + ONE], x[j + TWO] - x[i + TWO]
    w0, w1, w2 = v[j] - v[i], v[j + ONE] - v[i + ONE], v[j + TWO] - v[i + TWO]
    length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
    e = length - net.rest[s]
    if net.inelastic:
        e -= flowed(s, v, net.internal)
    return e, (r0 * w0 + r1 * w1 + r2 * w2) / (length + TINY)


def bend_of_passed(
    x: Floats,
    v: Floats,
    x_end: Floats,
    v_end: Floats,
    span: float,
    before: Rows,
    after: Rows,
    net: Net,
) -> float:
    """Return the largest jump of the rates of accelerations at corners of laws [m/s³].

    For springs that pass a corner it is f' |w| (1/m + 1/m'), for dashpots (∂g/∂w |Δw| / Δt +
    ∂g/∂e |w|) (1/m + 1/m'). Where a spring begins or ceases to yield, the rate of its flow
    jumps by |ΔS| / η Δt [m/s²]; divided by Δt once more, it counts alike.

    Args:
        span: Time Δt between both states [s].
        before, after: Sides of corners at both states, see ``find_sides``, shape (3, spring).
    """
    first, other, law, rest = net.first, net.other, net.law, net.rest
    worst = 0.0
    for node in range(first.size - 1):
        i = np.uint64(3 * node)
        for s in range(first[node], first[node + 1]):
            pulls, brakes = before[0, s] != after[0, s], before[1, s] != after[1, s]
            yields = before[2, s] != after[2, s]
            if pulls or brakes or yields:
                j = np.uint64(other[s])
                e, w = stretching(s, i, j, x, v, net)
                e_end, w_end = stretching(s, i, j, x_end, v_end, net)
                c, d, k = net.stiffness[s], net.damping[s], law[s]
                light = net.inverse_mass[node] + net.inverse_mass[int(other[s]) // 3]
                bend = 0.0
                if pulls:
                    # The larger slope, not their difference: a dead band has the same one
                    # on both sides.
                    one, two = slope(k, e, c, rest[s], net), slope(k, e_end, c, rest[s], net)
                    bend += max(abs(one), abs(two)) * max(abs(w), abs(w_end))
                if brakes:
                    one, two = (
                        brake_slope(k, e, w, d, rest[s], net),
                        brake_slope(k, e_end, w_end, d, rest[s], net),
                    )
                    thick = min(max(abs(one), abs(two)), STIFFEST)
                    bend += thick * abs(w_end - w) / span
                    one, two = (
                        brake_by_e(k, e, w, d, rest[s], net),
                        brake_by_e(k, e_end, w_end, d, rest[s], net),
                    )
                    bend += max(abs(one), abs(two)) * max(abs(w), abs(w_end))
                bend *= light
                if net.inelastic and yields:
                    more = pull_of(s, e_end, v_end, net) - pull_of(s, e, v, net)
                    bend += abs(more) / (net.internal.viscosity[s] * span * span)
                worst = max(worst, bend)
    return worst


def reeled(time: float, x: Floats, v: Floats, net: Net) -> float:
    """Return the power of springs on the actuators that change their rest lengths [W]."""
    power, reels = 0.0, net.reels
    for k in range(reels.spring.size):
        s, low, high = int(reels.spring[k]), reels.low[k], reels.high[k]
        e, _ = stretching(s, np.uint64(3 * low), np.uint64(3 * high), x, v, net)
        power += pull_of(s, e, v, net) * reel_rate(k, time, reels, net.acts)
    return float(power)


def pull_of(s: int, e: float, v: Floats, net: Net) -> float:
    """Return the force of a spring and its branches at an elongation, without viscosity [N]."""
    force = net.stiffness[s] * e
    if net.law[s] > 0:
        force = pull(net.law[s], e, net.stiffness[s], net.rest[s], net)
    if net.inelastic:
        force += relax(s, e, v, net.internal)[0]
    return float(force)


def tension(x: Floats, v: Floats, out: Floats, net: Net) -> None:
    """Set ``out`` to the tension of each spring.

    Args:
        out: Tensions [N], shape (spring,).
    """
    first, other = net.first, net.other
    for node in range(first.size - 1):
        i = np.uint64(3 * node)
        for s in range(first[node], first[node + 1]):
            e, closing = stretching(s, i, np.uint64(other[s]), x, v, net)
            braking = net.damping[s] * closing
            if net.law[s] > 0:
                braking = brake(net.law[s], e, closing, net.damping[s], net.rest[s], net)
            out[s] = pull_of(s, e, v, net) + braking


def resistance(
    q: float, s: int, i: int, j: int, length: float, x: Floats, v: Floats, net: Net
) -> tuple[float, float]:
    """Return q ∂g/∂w + q² ∂(f + g)/∂e and q² f/L of a spring, neither of them negative [kg].

    Args:
        q: Step size times coefficient of the implicit method [s].
    """
    law, rest, inverse = net.law[s], net.rest[s], 1.0 / (length + TINY)
    e, closing = stretching(s, np.uint64(i), np.uint64(j), x, v, net)
    damping = net.damping[s]
    steep = slope(law, e, net.stiffness[s], rest, net)
    steep += brake_by_e(law, e, closing, damping, rest, net)
    steep = max(steep, 0.0)
    across = max(pull(law, e, net.stiffness[s], rest, net) * inverse, 0.0)
    if length == 0.0 and rest == 0.0:
        across = steep  # in all directions alike
    # At rest, a dashpot may be infinitely stiff.
    viscous = min(max(brake_slope(law, e, closing, damping, rest, net), 0.0), STIFFEST)
    return q * viscous + q * q * steep, q * q * across


def peaks(before: Floats, here: Floats, after: Floats, margin: float, net: Net) -> bool:
    """Return whether a parabola through three states rises above ``margin`` times a limit.

    Args:
        before, here, after: Tensions at the three states [N], shape (spring,).
        margin: Factor on the strength, dimensionless.
    """
    for s in range(here.size):
        if parabola_top(before[s], here[s], after[s]) > margin * net.strength[s]:
            return True
        top = parabola_top(-before[s], -here[s], -after[s]) if net.crushed else 0.0
        if top > margin * net.crush[s]:
            return True
    return False


def parabola_top(low: float, mid: float, high: float) -> float:
    """Return the largest value of a parabola through three equidistant values.

    Args:
        low: First value, in any unit.
        mid: Value in the middle.
        high: Last value.
    """
    top = max(low, mid, high)
    if mid >= low and mid >= high and mid + mid > low + high:
        top += (high - low) * (high - low) / (8.0 * (mid + mid - low - high))
    return top


def slack(x: Floats, x_end: Floats, net: Net) -> float:
    """Return how far nodes may move before a spring can turn over [m]; -1 if one has already.

    A spring turns over if its projection on its previous direction falls below the part
    ``LEFT`` of the longer of both lengths. Springs with zero rest length do not count, because
    their forces are continuous.
    """
    first, other = net.first, net.other
    shortest = inf
    for node in range(first.size - 1):
        i = np.uint64(3 * node)
        x0, x1, x2 = x[i], x[i + ONE], x[i + TWO]
        y0, y1, y2 = x_end[i], x_end[i + ONE], x_end[i + TWO]
        for s in range(first[node], first[node + 1]):
            j = np.uint64(other[s])
            r0, r1, r2 = x_end[j] - y0, x_end[j + ONE] - y1, x_end[j + TWO] - y2
            d0, d1, d2 = x[j] - x0, x[j + ONE] - x1, x[j + TWO] - x2
            if net.rest[s] > 0.0:
                before, after = d0 * d0 + d1 * d1 + d2 * d2, r0 * r0 + r1 * r1 + r2 * r2
                if r0 * d0 + r1 * d1 + r2 * d2 < LEFT * max(before, after):
                    return -1.0
                shortest = min(shortest, after)
    return 0.5 * (1.0 - LEFT) * sqrt(shortest)
