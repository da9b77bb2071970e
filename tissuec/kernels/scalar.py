"""The operations as scalar loops, to be translated; they also run, slowly, as plain Python.

Force on a spring's lower node i from its upper node j, r = x_j - x_i, L = |r|:
T = c e + d w with e = L - L0 and w = r·(v_j - v_i) / L, or what laws say instead, and what
branches add; force T r / L. Flags in capitals are constants of a variant. What other modules
do, and laws, is compiled by itself and called by its address: ``tissuec.compiled``.
"""

from math import inf, sqrt

import numpy as np

from tissuec.kernels.acts import pull_free, put_driven
from tissuec.kernels.records import Buffer, Floats, Net, Rows, Team
from tissuec.kernels.reeling import reel, reel_rate
from tissuec.kernels.remembering import flowed, give_way, pull_of_branches, put_home, remember
from tissuec.kernels.teams import PIECE, part_of, pieces_of, share
from tissuec.laws import LINEAR
from tissuec.laws.code import functions

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
OF_LAWS = True  # springs may have laws, relax or flow
pull, slope, side, *_viscous = functions((LINEAR,)).values()
brake, brake_slope, brake_by_e, brake_side = _viscous

# Added to a length before dividing: a spring of no length then has no direction and no force,
# while any length that is not squared to zero stays what it is.
TINY = 1e-200
# Part of a spring's length, along where it pointed, that a step must leave of it (and have
# begun with) for stages on the way not to see it turned over.
LEFT = 0.1
STIFFEST = 1e30  # viscosity in a matrix [N s/m]
UNSIGNED = 0x7FFF_FFFF_FFFF_FFFF  # all bits of a number but its sign
# Unsigned, so that no index has to be tested for being negative.
ONE, TWO = np.uint64(1), np.uint64(2)


def force(time: float, x: Floats, v: Floats, a: Floats, power: Floats, net: Net) -> bool:
    """Set ``a`` to the accelerations; return whether a spring is near to breaking.

    With a ledger, sets ``power`` to the work done from outside and to what is dissipated [W].
    """
    power[0] = power[1] = 0.0
    if net.reeled:
        reel(time, net.rest, net.reels, net.acts)
        if net.ledger:
            power[0] -= reeled(time, x, v, net)
    share(net.team, clear_part, (a,))
    near = springs(x, v, a, power, net)
    for k in range(net.fields.address.size):
        add_field(net.fields.address[k], net.fields.table[k], time, x, v, a, power)
    if net.ledger:
        for node in net.driven:
            for i in range(3 * node, 3 * node + 3):
                power[0] -= a[i] * v[i]
    power[0] += pull_free(time, v, a, net.inverse_mass, net.acts)
    if net.ledger:
        share(net.team, count_powers, (v, net))
        for piece in range(pieces_of(net.inverse_mass.size)):
            power[0] += net.team.work[piece]
            power[1] += net.team.lost[piece]
    share(net.team, accelerate, (v, a, net))
    if net.touched:
        for k in range(net.touches.memory.size):
            i = 3 * net.touches.memory[k]
            for c in range(3):
                a[i + c] = net.touches.bent[k, c]
    if net.inelastic:
        remember(a, net.internal)
    return near


def clear_part(part: int, parts: int, vector: Floats) -> None:
    """Set a part of a vector of all nodes to zero."""
    first, last = part_of(part, parts, vector.size // 3)
    own = vector[3 * first : 3 * last]
    for i in range(own.size):
        own[i] = 0.0


def count_powers(part: int, parts: int, v: Floats, net: Net) -> None:
    """Sum what pushes do and what drag dissipates, for each piece of a part of the nodes."""
    first, last = part_of(part, parts, net.inverse_mass.size)
    for start in range(first, last, PIECE):
        stop = min(start + PIECE, last)
        # Views that are indexed from 0 need no test of whether an index is negative.
        own_v, push = v[3 * start : 3 * stop], net.push[3 * start : 3 * stop]
        mass, drags = net.inverse_mass[start:stop], net.drag[start:stop]
        work = dissipated = 0.0
        for node in range(mass.size):
            for i in range(3 * node, 3 * node + 3):
                work += push[i] * own_v[i]
                if mass[node] > 0.0:
                    dissipated += drags[node] * own_v[i] * own_v[i]
        net.team.work[start // PIECE] = work
        net.team.lost[start // PIECE] = dissipated


def accelerate(part: int, parts: int, v: Floats, a: Floats, net: Net) -> None:
    """Turn forces on a part of the nodes into accelerations, with drag and what is steady."""
    first, last = part_of(part, parts, net.inverse_mass.size)
    # Views that are indexed from 0 need no test of whether an index is negative.
    own_v, own_a = v[3 * first : 3 * last], a[3 * first : 3 * last]
    steady = net.steady[3 * first : 3 * last]
    mass, drags = net.inverse_mass[first:last], net.drag[first:last]
    for node in range(mass.size):
        inverse, drag = mass[node], drags[node]
        for i in range(3 * node, 3 * node + 3):
            own_a[i] = steady[i] + inverse * (own_a[i] - drag * own_v[i])


def add_field(
    address: int, table: int, time: float, x: Floats, v: Floats, f: Floats, power: Floats
) -> None:
    """Call the kernel of a field with its table; see ``tissuec.forces``.

    In compiled code a call of the address stands in its place; as Python it cannot be called.
    """
    raise NotImplementedError


def springs(x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> bool:
    """Add the forces of springs; return whether one is near to breaking."""
    first, other, law = net.first, net.other, net.law
    stiffness, damping, rest = net.stiffness, net.damping, net.rest
    limit, limit_pressed = net.near, net.near_crush
    near = False
    dissipated = 0.0
    for node in range(first.size - 1):
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
            if OF_LAWS and net.inelastic:
                e -= flowed(s, v, net.internal)
            tension = stiffness[s] * e
            if OF_LAWS and law[s] > 0:
                tension = pull(law[s], e, stiffness[s], rest[s], net)
            if OF_LAWS and net.inelastic:
                tension += pull_of_branches(s, e, v, net.internal)
                dissipated += give_way(s, e, tension, v, net.internal)
            if VISCOUS:
                closing = (
                    r0 * (v[j] - v0) + r1 * (v[j + ONE] - v1) + r2 * (v[j + TWO] - v2)
                ) * inverse
                braking = damping[s] * closing
                if OF_LAWS and law[s] > 0:
                    braking = brake(law[s], e, closing, damping[s], rest[s], net)
                tension += braking
                dissipated += braking * closing
            if WATCHED:
                near |= tension > limit[s] or tension < -limit_pressed[s]
            tension *= inverse
            f0 += tension * r0
            f1 += tension * r1
            f2 += tension * r2
            f[j] -= tension * r0
            f[j + ONE] -= tension * r1
            f[j + TWO] -= tension * r2
        f[i] += f0
        f[i + ONE] += f1
        f[i + TWO] += f2
    power[1] += dissipated
    return near


def find_sides(time: float, x: Floats, v: Floats, out: Rows, net: Net) -> None:
    """Set ``out``, shape (3, spring), to the sides of corners that springs are on.

    Of springs and of dashpots, and whether springs yield.
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


def stretching(s: int, i: int, j: int, x: Floats, v: Floats, net: Net) -> tuple[float, float]:
    """Return the elongation [m] of a spring between two nodes, and its rate [m/s]."""
    r0, r1, r2 = x[j] - x[i], x[j + ONE] - x[i + ONE], x[j + TWO] - x[i + TWO]
    w0, w1, w2 = v[j] - v[i], v[j + ONE] - v[i + ONE], v[j + TWO] - v[i + TWO]
    length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
    e = length - net.rest[s]
    if net.inelastic:
        e -= flowed(s, v, net.internal)
    return e, (r0 * w0 + r1 * w1 + r2 * w2) / (length + TINY)


def is_passed(before: Rows, after: Rows) -> bool:
    """Return whether any spring has passed a corner between two looks."""
    for row in range(3):
        for s in range(before.shape[1]):
            if before[row, s] != after[row, s]:
                return True
    return False


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
    """Return how suddenly corners change the rates of accelerations [m/s³].

    The largest f' |w| (1/m + 1/m') of springs, and (∂g/∂w |Δw| / Δt + ∂g/∂e |w|) (1/m + 1/m')
    of dashpots, that pass. Where
    one begins or ceases to yield, its lasting elongation bends: |ΔS| / η Δt, a rate of m/s²
    that positions follow, hence over Δt once more.

    Args:
        span: Time between both looks [s].
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
    """Return the power that springs do on what changes their rest lengths [W]."""
    power, reels = 0.0, net.reels
    for k in range(reels.spring.size):
        s, i, j = int(reels.spring[k]), 3 * reels.low[k], 3 * reels.high[k]
        r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        power += pull_at(s, length, v, net) * reel_rate(k, time, reels, net.acts)
    return float(power)


def pull_at(s: int, length: float, v: Floats, net: Net) -> float:
    """Return the force of a spring and its branches at a length, without viscosity [N]."""
    e = length - net.rest[s]
    if net.inelastic:
        e -= flowed(s, v, net.internal)
    return pull_of(s, e, v, net)


def pull_of(s: int, e: float, v: Floats, net: Net) -> float:
    """Return the force of a spring and its branches at an elongation [N]."""
    force = net.stiffness[s] * e
    if net.law[s] > 0:
        force = pull(net.law[s], e, net.stiffness[s], net.rest[s], net)
    if net.inelastic:
        force += pull_of_branches(s, e, v, net.internal)
    return float(force)


def tension(x: Floats, v: Floats, out: Floats, net: Net) -> None:
    """Set ``out`` to the tension of each spring [N]."""
    first, other = net.first, net.other
    for node in range(first.size - 1):
        i = 3 * node
        for s in range(first[node], first[node + 1]):
            j = other[s]
            r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
            length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
            e = length - net.rest[s]
            if net.inelastic:
                e -= flowed(s, v, net.internal)
            closing = (
                r0 * (v[j] - v[i]) + r1 * (v[j + 1] - v[i + 1]) + r2 * (v[j + 2] - v[i + 2])
            ) / (length + TINY)
            braking = net.damping[s] * closing
            if net.law[s] > 0:
                braking = brake(net.law[s], e, closing, net.damping[s], net.rest[s], net)
            out[s] = pull_of(s, e, v, net) + braking


def resistance(
    q: float, s: int, i: int, j: int, length: float, x: Floats, v: Floats, net: Net
) -> tuple[float, float]:
    """Return q ∂g/∂w + q² ∂(f + g)/∂e and q² f/L of a spring, neither of them negative [kg].

    Args:
        s: Its number; ``i`` and ``j`` are where its nodes begin in ``x`` and ``v``.
    """
    law, rest, inverse = net.law[s], net.rest[s], 1.0 / (length + TINY)
    closing = 0.0
    for k in range(3):
        closing += (x[j + k] - x[i + k]) * (v[j + k] - v[i + k]) * inverse
    e, damping = length - rest, net.damping[s]
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
    """Tell whether a parabola through three looks rises above ``margin`` times a limit."""
    for s in range(here.size):
        if parabola_top(before[s], here[s], after[s]) > margin * net.strength[s]:
            return True
        top = parabola_top(-before[s], -here[s], -after[s]) if net.crushed else 0.0
        if top > margin * net.crush[s]:
            return True
    return False


def parabola_top(low: float, mid: float, high: float) -> float:
    """Return the highest value of a parabola through three equidistant looks."""
    top = max(low, mid, high)
    if mid >= low and mid >= high and mid + mid > low + high:
        top += (high - low) * (high - low) / (8.0 * (mid + mid - low - high))
    return top


def slack(x: Floats, x_end: Floats, net: Net) -> float:
    """Return how far nodes may move before a spring can turn over; -1 if one has already [m].

    To turn over is to keep, along where it pointed before, less than the part ``LEFT`` of the
    longer of both lengths. Springs without length at rest, whose forces do not jump then, do
    not count.
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


def place(time: float, x: Floats, v: Floats, net: Net) -> None:
    """Put driven nodes and lengths of threads where their courses have them at a time."""
    put_driven(time, x, v, net.acts)
    if net.reeled:
        reel(time, net.rest, net.reels, net.acts)
    if net.touched:
        put_home(x, net.touches.memory, net.touches.home)
    if net.inelastic:
        put_home(x, net.internal.nodes, net.internal.home)


def combine(
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Rows,
    out_x: Floats,
    out_v: Floats,
    team: Team,
) -> None:
    """Set out_x = x + to Σ weights_j rows_j and out_v = v + at Σ further_j rows_j.

    Both at once, because large nets are read from memory. Rows without weight are not touched.
    """
    share(team, combine_part, (x, to, weights, v, at, further, rows, out_x, out_v))


def combine_part(
    part: int,
    parts: int,
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Rows,
    out_x: Floats,
    out_v: Floats,
) -> None:
    """Do a part of ``combine``."""
    first, last = part_of(part, parts, out_x.size // 3)
    # Blocks that stay in the cache while all rows are added to them.
    for start in range(3 * first, 3 * last, PIECE):
        stop = min(start + PIECE, 3 * last)
        add_rows(x, to, weights, rows, start, stop, out_x)
        add_rows(v, at, further, rows, start, stop, out_v)


def add_rows(
    base: Floats,
    factor: float,
    weights: Floats,
    rows: Rows,
    start: int,
    stop: int,
    out: Floats,
) -> None:
    """Set a part of out = base + factor Σ weights_j rows_j."""
    count, last, part = rows.shape[0], rows.shape[0] - 1, slice(start, stop)
    total, first = out[part], base[part]
    j, begun = following(weights, -1), False
    while j < count or not begun:
        # Four rows at a time, for less traffic; those past the last have no weight.
        k = following(weights, j)
        m = following(weights, k)
        n = following(weights, m)
        a = factor * weights[j] if j < count else 0.0
        b = factor * weights[k] if k < count else 0.0
        c = factor * weights[m] if m < count else 0.0
        d = factor * weights[n] if n < count else 0.0
        # Views that are indexed from 0 let the compiler use vector instructions, and so does
        # one loop for each of both bases.
        one, two = rows[min(j, last), part], rows[min(k, last), part]
        three, four = rows[min(m, last), part], rows[min(n, last), part]
        if begun:
            for i in range(total.size):
                total[i] += (a * one[i] + b * two[i]) + (c * three[i] + d * four[i])
        else:
            for i in range(total.size):
                total[i] = first[i] + ((a * one[i] + b * two[i]) + (c * three[i] + d * four[i]))
        j, begun = following(weights, n), True


def following(weights: Floats, row: int) -> int:
    """Return the next row of some weight; their number where there is none."""
    row += 1
    while row < weights.size and weights[row] == 0.0:
        row += 1
    return row


def scale(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = factor vector."""
    for i in range(out.size):
        out[i] = factor * vector[i]


def polynomials(table: Rows, part: float, out: Floats) -> None:
    """Set out_j = Σ_k table[k, j] part^(k + 1)."""
    for j in range(out.size):
        value = 0.0
        for k in range(table.shape[0] - 1, -1, -1):
            value = (value + table[k, j]) * part
        out[j] = value


def kinetic(v: Floats, net: Net) -> float:
    """Return the kinetic energy of the free nodes [J]."""
    total = 0.0
    for node in range(net.inverse_mass.size):
        if net.inverse_mass[node] > 0.0:
            i = 3 * node
            total += (v[i] ** 2 + v[i + 1] ** 2 + v[i + 2] ** 2) / net.inverse_mass[node]
    return 0.5 * total


def quadrature(base: Floats, factor: float, weights: Floats, power: Rows, out: Floats) -> None:
    """Set out = base + factor Σ weights_j power_j for the two columns of the ledger."""
    for k in range(2):
        total = 0.0
        for j in range(power.shape[0]):
            total += weights[j] * power[j, k]
        out[k] = base[k] + factor * total


def drift(
    x: Floats, v: Floats, a: Floats, h: float, x_end: Floats, v_end: Floats, team: Team
) -> None:
    """Set x_end = x + h v + h²/2 a and v_end = v + h a."""
    share(team, drift_part, (x, v, a, h, x_end, v_end))


def drift_part(
    part: int,
    parts: int,
    x: Floats,
    v: Floats,
    a: Floats,
    h: float,
    x_end: Floats,
    v_end: Floats,
) -> None:
    """Do a part of ``drift``."""
    first, last = part_of(part, parts, x.size // 3)
    own, half = slice(3 * first, 3 * last), 0.5 * h * h
    x, v, a, x_end, v_end = x[own], v[own], a[own], x_end[own], v_end[own]
    for i in range(x.size):
        x_end[i] = x[i] + h * v[i] + half * a[i]
        v_end[i] = v[i] + h * a[i]


def kick(v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats, team: Team) -> None:
    """Set v_end = v + h/2 (a + a_end)."""
    share(team, kick_part, (v, a, a_end, h, v_end))


def kick_part(
    part: int, parts: int, v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats
) -> None:
    """Do a part of ``kick``."""
    first, last = part_of(part, parts, v.size // 3)
    own, half = slice(3 * first, 3 * last), 0.5 * h
    v, a, a_end, v_end = v[own], a[own], a_end[own], v_end[own]
    for i in range(v.size):
        v_end[i] = v[i] + half * (a[i] + a_end[i])


def accumulate(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = out + factor vector."""
    for i in range(out.size):
        out[i] += factor * vector[i]


def subtract(one: Floats, two: Floats, out: Floats) -> None:
    """Set out = one - two."""
    for i in range(out.size):
        out[i] = one[i] - two[i]


def between(one: Floats, two: Floats, factor: float, less: Floats, out: Floats) -> None:
    """Set out = factor (two - one) - less."""
    for i in range(out.size):
        out[i] = factor * (two[i] - one[i]) - less[i]


def distance(one: Floats, two: Floats, squares: Floats, team: Team) -> float:
    """Return the largest distance between the nodes of two vectors; NaN where one is none.

    Args:
        one, two: Shape (3 node,), or longer.
        squares: Scratch, shape (node,).
    """
    share(team, distance_part, (one, two, squares, team))
    return sqrt(greatest(team.found))


def distance_part(
    part: int, parts: int, one: Floats, two: Floats, squares: Floats, team: Team
) -> None:
    """Find the largest square of a distance in a part of the nodes."""
    first, last = part_of(part, parts, squares.size)
    one, two = one[3 * first : 3 * last], two[3 * first : 3 * last]
    squares = squares[first:last]
    for node in range(squares.size):
        i = 3 * node
        d0, d1, d2 = one[i] - two[i], one[i + 1] - two[i + 1], one[i + 2] - two[i + 2]
        squares[node] = d0 * d0 + d1 * d1 + d2 * d2
    team.found[part] = greatest(squares)


def greatest(values: Floats) -> float:
    """Return the largest of values not below zero; NaN where one is none. Spoils the first.

    Numbers without a sign are ordered as their bits are, above all of them infinity and what is
    no number; integers have a maximum that four times as many instructions a second reach.
    """
    bits = values.view(np.int64)
    most = 0
    for i in range(bits.size):
        most = max(most, bits[i] & UNSIGNED)
    if bits.size:
        bits[0] = most
        return values[0]
    return 0.0


def greatest_force(a: Floats, net: Net) -> float:
    """Return the greatest force on a free node, from the accelerations [N]; NaN if none."""
    greatest = check = 0.0
    for node in range(net.inverse_mass.size):
        inverse, i = net.inverse_mass[node], 3 * node
        if inverse > 0.0:
            force = (a[i] * a[i] + a[i + 1] * a[i + 1] + a[i + 2] * a[i + 2]) / inverse**2
            greatest = max(greatest, force)
            check += 0.0 * force  # what is not finite must not get lost in a maximum
    return sqrt(greatest) + check


def greatest_inner_force(time: float, v: Floats, a: Floats, out: Floats, net: Net) -> float:
    """Return the greatest force on a free node without weight, loads and drag [N].

    Args:
        out: Scratch, shape (3 node,).
    """
    for i in range(out.size):
        out[i] = 0.0
    pull_free(time, v, out, net.inverse_mass, net.acts)
    for node in range(net.inverse_mass.size):
        inverse = net.inverse_mass[node]
        for i in range(3 * node, 3 * node + 3):
            out[i] = a[i] - net.steady[i] + inverse * (net.drag[node] * v[i] - out[i])
    return greatest_force(out, net)


def blended_error(fifth: Floats, third: Floats, blend: Floats, team: Team) -> float:
    """Return the largest e5² / √(e5² + 0.01 e3²) over the nodes; NaN where it is none.

    Args:
        fifth, third: Shape (3 node,).
        blend: Scratch, shape (node,).
    """
    share(team, blended_part, (fifth, third, blend, team))
    return greatest(team.found)


def blended_part(
    part: int, parts: int, fifth: Floats, third: Floats, blend: Floats, team: Team
) -> None:
    """Find the largest blended error of a part of the nodes."""
    first, last = part_of(part, parts, blend.size)
    fifth, third = fifth[3 * first : 3 * last], third[3 * first : 3 * last]
    blend = blend[first:last]
    for node in range(blend.size):
        i = 3 * node
        five = fifth[i] ** 2 + fifth[i + 1] ** 2 + fifth[i + 2] ** 2
        three = third[i] ** 2 + third[i + 1] ** 2 + third[i + 2] ** 2
        blend[node] = five / (sqrt(five + 0.01 * three) + TINY)
    team.found[part] = greatest(blend)


def copy_sample(
    x: Floats, v: Floats, ledger: Floats, error: float, index: int, buffer: Buffer
) -> None:
    """Enter a state into the buffer as sample ``index``."""
    for i in range(x.size):
        buffer.position[index, i] = x[i]
        buffer.velocity[index, i] = v[i]
    buffer.ledger[index, 0] = ledger[0]
    buffer.ledger[index, 1] = ledger[1]
    buffer.error[index] = error
