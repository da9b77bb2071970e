"""The operations on NumPy: no compiler, ready at once, fast enough for small nets.

Springs work on component-major scratch, shape (3, spring), which NumPy reduces fastest;
``bincount`` over flat indices adds forces to nodes in the order of the springs, so that sums
are reproducible.
"""

from math import inf, sqrt
from typing import Any

import numpy as np

from tissuec.inelastic import Inelastic
from tissuec.kernels.acts import total, turning
from tissuec.kernels.records import (
    Acts,
    Buffer,
    Enclosures,
    Floats,
    Integers,
    Internal,
    Reels,
    Touches,
)
from tissuec.kernels.reeling import reel, reel_rate
from tissuec.kernels.scalar import LEFT, STIFFEST, TINY
from tissuec.kernels.touching import count
from tissuec.laws.evaluation import Behaviour


class VectorNet:
    """What acts on the nodes, for the interpreted tier, with scratch for its springs.

    Args:
        low, high: Lower and upper node of each spring, shape (spring,).
        behaviour: What each spring does at an elongation and a speed.
        strength, crush: Per spring [N], shape (spring,).
        near: Tension from which a closer look is needed [N], shape (spring,).
        near_crush: The same of pressure.
        inverse_mass: Zero for held nodes [1/kg], shape (node,).
        steady: Gravity and constant loads by mass [m/s²], shape (3 node,).
        push: Constant loads on free nodes [N], shape (3 node,).
        driven: Nodes on prescribed paths.
        drag: Ambient damping [N s/m], shape (node,).
        acts: Motions and loads of the present stretch; may be replaced.
        enclosures: Volumes that are kept by pressure.
        hinges: Of walls that resist bending, in the engine's numbers of nodes.
        reels: Springs whose rest lengths change.
        contact: What instruments and threads touch, if they do.
        touches: Where bristles stay, and how far nodes may move until pairs are listed anew.
        jets: Of fluid, in the engine's numbers of nodes.
        inelastic: What springs remember, if they do; slots are places in velocities here.
        internal: Where that is kept.
        watched: Whether springs may break.
        crushed: Whether they do so under pressure, too.
        ledger: Whether work and dissipation are integrated.
        touched: Whether there are instruments or threads that touch.
        cornered: Whether some laws have corners.
    """

    def __init__(
        self,
        *,
        low: Integers,
        high: Integers,
        behaviour: Behaviour,
        strength: Floats,
        crush: Floats,
        near: Floats,
        near_crush: Floats,
        inverse_mass: Floats,
        steady: Floats,
        push: Floats,
        driven: Integers,
        drag: Floats,
        acts: Acts,
        enclosures: Enclosures,
        hinges: Any,
        reels: Reels,
        contact: Any,
        touches: Touches,
        jets: tuple[Any, ...],
        inelastic: Inelastic | None,
        internal: Internal,
        watched: bool,
        crushed: bool,
        ledger: bool,
        touched: bool,
        cornered: bool,
    ):
        component = np.arange(3)[:, None]
        springs, nodes = len(low), len(inverse_mass)
        self.low, self.high = 3 * low + component, 3 * high + component
        self.both = np.concatenate([self.low.ravel(), self.high.ravel()])
        self.behaviour = behaviour
        self.stiffness, self.damping = behaviour.stiffness, behaviour.damping
        self.rest = behaviour.rest
        self.strength, self.near = strength, near
        self.crush, self.near_crush = crush, near_crush
        self.inverse_mass = np.repeat(inverse_mass, 3)
        is_free = self.inverse_mass > 0.0
        self.half_mass = np.where(is_free, 0.5 / np.where(is_free, self.inverse_mass, 1.0), 0.0)
        self.steady, self.push, self.driven = steady, push, driven
        self.drag, self.dragged = np.repeat(drag, 3), bool(drag.any())
        self.acts, self.enclosures, self.hinges = acts, enclosures, hinges
        self.reels, self.contact, self.touches = reels, contact, touches
        self.jets = jets
        self.inelastic, self.internal = inelastic, internal
        self.giving = np.zeros(0)  # how fast springs give way
        self.lost = 0.0  # the power of that [W]
        self.watched, self.crushed, self.ledger = watched, crushed, ledger
        self.touched, self.cornered = touched, cornered
        self.linear, self.viscous = behaviour.is_linear, behaviour.is_viscous
        self.r, self.w = np.empty((3, springs)), np.empty((3, springs))
        self.end = np.empty((3, springs))
        self.length, self.inverse = np.empty(springs), np.empty(springs)
        self.closing, self.tension = np.empty(springs), np.empty(springs)
        self.f = np.empty((2, 3, springs))
        self.node_scratch = np.empty(3 * nodes)
        self.matrix: Any = None  # of implicit steps, made by ``linear``


def _stretch(x: Floats, v: Floats, net: VectorNet) -> Floats:
    """Fill the scratch of ``net`` and return the tension of each spring."""
    r, length, inverse, tension = net.r, net.length, net.inverse, net.tension
    x.take(net.high, out=r, mode="clip")
    np.subtract(r, x.take(net.low, out=net.end, mode="clip"), out=r)
    np.sqrt(np.einsum("ij,ij->j", r, r, out=length), out=length)
    np.divide(1.0, np.add(length, TINY, out=inverse), out=inverse)
    np.subtract(length, net.rest, out=tension)
    e = tension if net.linear else tension.copy()  # dashpots ask for it, too
    if net.inelastic is not None:
        e = e - net.inelastic.variables(v)[-1]
        tension[:] = _remembering(e, v, net, net.inelastic)
    elif net.linear:
        np.multiply(tension, net.stiffness, out=tension)
    else:
        tension[:] = net.behaviour.pull(e)
    if net.viscous:
        v.take(net.high, out=net.w, mode="clip")
        np.subtract(net.w, v.take(net.low, out=net.end, mode="clip"), out=net.w)
        np.einsum("ij,ij->j", r, net.w, out=net.closing)
        np.multiply(net.closing, inverse, out=net.closing)
        if net.linear:
            np.multiply(net.closing, net.damping, out=length)
        else:
            length[:] = net.behaviour.brake(e, net.closing)
        np.add(tension, length, out=tension)
    return tension


def _remembering(e: Floats, v: Floats, net: VectorNet, inelastic: Inelastic) -> Floats:
    """Return the forces of springs and branches; keep how fast both give way."""
    variables = inelastic.variables(v)
    pull = net.behaviour.pull(e) + inelastic.pull(e, variables)
    rates, has = inelastic.rates(e, pull, variables), inelastic.slot >= 0
    net.giving = (inelastic.rate * rates)[has]
    net.lost = float(inelastic.lost(e, pull, variables).sum()) if net.ledger else 0.0
    return pull


def force(time: float, x: Floats, v: Floats, a: Floats, power: Floats, net: VectorNet) -> bool:
    """Set ``a`` to the accelerations; return whether a spring is near to breaking."""
    reel(time, net.rest, net.reels, net.acts)
    tension = _stretch(x, v, net)
    near = net.watched and bool((tension > net.near).any())
    if net.crushed:
        near = near or bool((tension < -net.near_crush).any())
    if net.ledger:
        power[1] = net.lost + (np.dot(net.length, net.closing) if net.viscous else 0.0)
        power[0] = np.dot(net.push, v) - _reeled(time, x, v, net)
    np.multiply(tension, net.inverse, out=tension)
    np.multiply(net.r, tension, out=net.f[0])
    np.negative(net.f[0], out=net.f[1])
    # Without springs NumPy counts in integers.
    f = np.bincount(net.both, net.f.ravel(), a.size).astype(float, copy=False)
    if net.enclosures.drawn.size:
        pumped = _press(time, x, f, net)
        if net.ledger:
            power[0] += pumped
    if net.hinges is not None:
        forces, lost = net.hinges.pulling(x.reshape(-1, 3), v.reshape(-1, 3))
        np.add.at(f.reshape(-1, 3), net.hinges.nodes, forces)
        if net.ledger:
            power[1] += lost.sum()
    touch = None
    if net.contact is not None:
        at, by, to = x.reshape(-1, 3), v.reshape(-1, 3), f.reshape(-1, 3)
        touch = net.contact.touches(at, by)
        count(net.contact.bends(touch), net.touches)
        net.contact.push(touch, to)
        if net.ledger:
            power[1] += net.contact.loss(touch)
    for jet in net.jets:
        at, by, to = x.reshape(-1, 3), v.reshape(-1, 3), f.reshape(-1, 3)
        pushed = np.zeros_like(to)
        jet.add_forces(time, at, by, pushed)
        to += pushed
        if net.ledger:
            power[0] += np.vdot(pushed, by)
    if net.ledger and net.driven.size:
        power[0] -= np.sum(f.reshape(-1, 3)[net.driven] * v.reshape(-1, 3)[net.driven])
    if net.acts.first.size - 1 > net.acts.motions:
        power[0] += _pull(time, v, f, net)
    if net.dragged:
        np.subtract(f, np.multiply(v, net.drag, out=net.node_scratch), out=f)
        if net.ledger:
            power[1] += np.dot(net.node_scratch, v * (net.inverse_mass > 0.0))
    np.multiply(f, net.inverse_mass, out=f)
    np.add(f, net.steady, out=a)
    if net.contact is not None and touch is not None and len(net.contact.memory):
        rates = net.contact.bristle_rates(touch)
        a.reshape(-1, 3)[net.contact.memory] = rates
    if net.inelastic is not None:
        a[net.inelastic.slot[net.inelastic.slot >= 0]] = net.giving
    return near


def _press(time: float, x: Floats, f: Floats, net: VectorNet) -> float:
    """Add the forces of enclosed volumes; return the power of pumps [W]."""
    corners, first, drawn, modulus, act = net.enclosures
    place = x.reshape(-1, 3)
    seen = place[corners] - place[np.repeat(corners[first[:-1], 0], np.diff(first))][:, None]
    s, p, q = seen.sum(axis=1), seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1]
    by_s, by_p, by_q = np.cross(p, q) / 24.0, np.cross(q, s) / 24.0, np.cross(s, p) / 24.0
    sides = np.stack([by_s - by_p, by_s - by_q, by_s + by_p, by_s + by_q], axis=1)
    volume = np.add.reduceat(np.einsum("fk,fk->f", s, by_s), first[:-1])
    swell, rate = np.array([total(which, time, net.acts) for which in act])[:, [0, 3]].T
    pressure = modulus * (drawn * (1.0 + swell) - volume) / drawn
    forces = np.repeat(pressure, np.diff(first))[:, None, None] * sides
    np.add.at(f.reshape(-1, 3), corners, forces)
    return float(pressure @ (drawn * rate))


def _pull(time: float, v: Floats, f: Floats, net: VectorNet) -> float:
    """Add time-dependent loads to the forces; return their power on free nodes [W]."""
    power, acts = 0.0, net.acts
    for act in range(acts.motions, acts.first.size - 1):
        nodes = acts.nodes[acts.first[act] : acts.first[act + 1]]
        free = nodes[net.inverse_mass[3 * nodes] > 0.0]
        vector = np.array(total(act, time, acts)[:3])
        f.reshape(-1, 3)[free] += vector
        power += float(np.sum(v.reshape(-1, 3)[free] @ vector))
    return power


def _reeled(time: float, x: Floats, v: Floats, net: VectorNet) -> float:
    """Return the power that springs do on what changes their rest lengths [W]."""
    reels = net.reels
    if not reels.spring.size:
        return 0.0
    r = x.reshape(-1, 3)[reels.high] - x.reshape(-1, 3)[reels.low]
    stretch = -net.rest
    stretch[reels.spring] += np.sqrt(np.einsum("sk,sk->s", r, r))
    if net.inelastic is not None:
        stretch -= net.inelastic.variables(v)[-1]
    tension = _pull_of(stretch, v, net)[reels.spring]
    rates = [reel_rate(k, time, reels, net.acts) for k in range(reels.spring.size)]
    return float(np.dot(tension, rates))


def find_sides(time: float, x: Floats, v: Floats, out: Floats, net: VectorNet) -> None:
    """Set ``out``, shape (3, spring), to the sides of corners that springs are on.

    Of springs and of dashpots, and whether springs yield.
    """
    reel(time, net.rest, net.reels, net.acts)
    e, w = _stretching(x, v, net)
    out[:2] = net.behaviour.sides(e, w)
    if net.inelastic is not None:
        out[2] = np.abs(_pull_of(e, v, net)) > net.inelastic.limit


def _stretching(x: Floats, v: Floats, net: VectorNet) -> tuple[Floats, Floats]:
    """Return the elongations [m] and their rates [m/s], shape (spring,) each."""
    r, w = x[net.high] - x[net.low], v[net.high] - v[net.low]
    length = np.sqrt((r * r).sum(axis=0))
    e = length - net.rest
    if net.inelastic is not None:
        e -= net.inelastic.variables(v)[-1]
    return e, (r * w).sum(axis=0) / (length + TINY)


def _pull_of(e: Floats, v: Floats, net: VectorNet) -> Floats:
    """Return the forces of springs and their branches at elongations [N], shape (spring,)."""
    pull = net.behaviour.pull(e)
    if net.inelastic is not None:
        pull = pull + net.inelastic.pull(e, net.inelastic.variables(v))
    return pull


def is_passed(before: Floats, after: Floats) -> bool:
    """Return whether any spring has passed a corner between two looks."""
    return not np.array_equal(before, after)


def bend_of_passed(
    x: Floats,
    v: Floats,
    x_end: Floats,
    v_end: Floats,
    span: float,
    before: Floats,
    after: Floats,
    net: VectorNet,
) -> float:
    """Return how suddenly corners change the rates of accelerations [m/s³].

    The largest f' |w| (1/m + 1/m') of springs, and (∂g/∂w |Δw| / Δt + ∂g/∂e |w|) (1/m + 1/m')
    of dashpots, that pass. Where
    one begins or ceases to yield, its lasting elongation bends: |ΔS| / η Δt, a rate of m/s²
    that positions follow, hence over Δt once more.

    Args:
        span: Time between both looks [s].
    """
    (e, w), (e_end, w_end) = _stretching(x, v, net), _stretching(x_end, v_end, net)
    light = net.inverse_mass[net.low[0]] + net.inverse_mass[net.high[0]]
    of = net.behaviour
    # The larger slope, not their difference: a dead band has the same one on both sides.
    fastest = np.maximum(np.abs(w), np.abs(w_end))
    steep = np.maximum(np.abs(of.slope(e)), np.abs(of.slope(e_end))) * fastest
    thick = np.maximum(np.abs(of.brake_slope(e, w)), np.abs(of.brake_slope(e_end, w_end)))
    thick = np.minimum(thick, STIFFEST) * np.abs(w_end - w) / span
    turned = np.maximum(np.abs(of.brake_by_e(e, w)), np.abs(of.brake_by_e(e_end, w_end)))
    thick += turned * fastest
    pulls, brakes, yields = before != after
    bend = (steep * pulls + thick * brakes) * light
    if net.inelastic is not None:
        more = _pull_of(e_end, v_end, net) - _pull_of(e, v, net)
        bend += yields * np.abs(more) / (net.inelastic.viscosity * span * span)
    return float(bend.max(initial=0.0))


def tension(x: Floats, v: Floats, out: Floats, net: VectorNet) -> None:
    """Set ``out`` to the tension of each spring [N]."""
    out[:] = _stretch(x, v, net)


def peaks(before: Floats, here: Floats, after: Floats, margin: float, net: VectorNet) -> bool:
    """Tell whether a parabola through three looks rises above ``margin`` times a limit."""
    tears = bool((parabola_tops(before, here, after) > margin * net.strength).any())
    if tears or not net.crushed:
        return tears
    return bool((parabola_tops(-before, -here, -after) > margin * net.crush).any())


def parabola_tops(before: Floats, here: Floats, after: Floats) -> Floats:
    """Return the highest values of parabolas through three equidistant looks."""
    bend = 2.0 * here - before - after
    inside_it = (here >= before) & (here >= after) & (bend > 0.0)
    rise = (after - before) ** 2 / (8.0 * np.where(inside_it, bend, 1.0))
    return np.maximum(np.maximum(before, after), here) + np.where(inside_it, rise, 0.0)


def slack(x: Floats, x_end: Floats, net: VectorNet) -> float:
    """Return how far nodes may move before a spring can turn over; -1 if one has [m]."""
    bent = net.rest > 0.0
    r, r_end = (y[net.high[:, bent]] - y[net.low[:, bent]] for y in (x, x_end))
    after = (r_end * r_end).sum(axis=0)
    if bool(((r * r_end).sum(axis=0) < LEFT * np.maximum((r * r).sum(axis=0), after)).any()):
        return -1.0
    return 0.5 * (1.0 - LEFT) * sqrt(float(after.min(initial=inf)))


def place(time: float, x: Floats, v: Floats, net: VectorNet) -> None:
    """Put driven nodes and lengths of threads where their courses have them at a time."""
    acts = net.acts
    reel(time, net.rest, net.reels, acts)
    for act in range(acts.motions):
        chosen = slice(acts.first[act], acts.first[act + 1])
        nodes, position = acts.nodes[chosen], acts.base[chosen]
        sums = total(act, time, acts)
        velocity = np.array(sums[3:])
        if acts.turn_curve[act] >= 0:
            cosine, sine, spin = turning(act, time, acts)
            axis, arm = acts.turn_axis[act], position - acts.turn_centre[act]
            along = np.outer(arm @ axis, axis)
            turned = along + (arm - along) * cosine + np.cross(axis, arm) * sine
            position = turned + acts.turn_centre[act]
            velocity = velocity + spin * np.cross(axis, turned)
        x.reshape(-1, 3)[nodes] = position + np.array(sums[:3])
        v.reshape(-1, 3)[nodes] = velocity
    if net.contact is not None:
        x.reshape(-1, 3)[net.contact.memory] = net.touches.home
    if net.inelastic is not None:
        x.reshape(-1, 3)[net.internal.nodes] = net.internal.home


def combine(
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Floats,
    out_x: Floats,
    out_v: Floats,
) -> None:
    """Set out_x = x + to Σ weights_j rows_j and out_v = v + at Σ further_j rows_j."""
    np.dot(to * weights, rows, out=out_x)
    np.add(out_x, x, out=out_x)
    np.dot(at * further, rows, out=out_v)
    np.add(out_v, v, out=out_v)


def scale(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = factor vector."""
    np.multiply(vector, factor, out=out)


def polynomials(table: Floats, part: float, out: Floats) -> None:
    """Set out_j = Σ_k table[k, j] part^(k + 1)."""
    np.dot(part ** np.arange(1, len(table) + 1), table, out=out)


def kinetic(v: Floats, net: VectorNet) -> float:
    """Return the kinetic energy of the free nodes [J]."""
    return float(np.dot(net.half_mass, v * v))


def quadrature(
    base: Floats, factor: float, weights: Floats, power: Floats, out: Floats
) -> None:
    """Set out = base + factor Σ weights_j power_j for the two columns of the ledger."""
    out[:] = base + factor * (weights @ power)


def drift(x: Floats, v: Floats, a: Floats, h: float, x_end: Floats, v_end: Floats) -> None:
    """Set x_end = x + h v + h²/2 a and v_end = v + h a."""
    np.multiply(a, h, out=v_end)
    np.multiply(v_end, 0.5, out=x_end)
    np.add(x_end, v, out=x_end)
    np.multiply(x_end, h, out=x_end)
    np.add(x_end, x, out=x_end)
    np.add(v_end, v, out=v_end)


def kick(v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats) -> None:
    """Set v_end = v + h/2 (a + a_end)."""
    np.add(a, a_end, out=v_end)
    np.multiply(v_end, 0.5 * h, out=v_end)
    np.add(v_end, v, out=v_end)


def accumulate(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = out + factor vector."""
    out += factor * vector


def subtract(one: Floats, two: Floats, out: Floats) -> None:
    """Set out = one - two."""
    np.subtract(one, two, out=out)


def between(one: Floats, two: Floats, factor: float, less: Floats, out: Floats) -> None:
    """Set out = factor (two - one) - less."""
    np.subtract((two - one) * factor, less, out=out)


def distance(one: Floats, two: Floats, squares: Floats) -> float:
    """Return the largest distance between the nodes of two vectors; NaN where one is none."""
    between = (one - two).reshape(-1, 3)[: squares.size]
    return sqrt(np.einsum("ij,ij->i", between, between).max(initial=0.0))


def greatest_force(a: Floats, net: VectorNet) -> float:
    """Return the greatest force on a free node, from the accelerations [N]; NaN if none."""
    mass_times = (2.0 * net.half_mass * a).reshape(-1, 3)
    return sqrt(np.einsum("ij,ij->i", mass_times, mass_times).max(initial=0.0))


def greatest_inner_force(
    time: float, v: Floats, a: Floats, out: Floats, net: VectorNet
) -> float:
    """Return the greatest force on a free node without weight, loads and drag [N]."""
    out[:] = 0.0
    _pull(time, v, out, net)
    out[:] = a - net.steady + net.inverse_mass * (net.drag * v - out)
    return greatest_force(out, net)


def blended_error(fifth: Floats, third: Floats, blend: Floats) -> float:
    """Return the largest e5² / √(e5² + 0.01 e3²) over the nodes; NaN where it is none."""
    fifth, third = (e.reshape(-1, 3)[: blend.size] for e in (fifth, third))
    five = np.einsum("ij,ij->i", fifth, fifth)
    three = np.einsum("ij,ij->i", third, third)
    below = np.sqrt(five + 0.01 * three)
    return float((five / np.where(below == 0.0, 1.0, below)).max(initial=0.0))


def copy_sample(
    x: Floats, v: Floats, ledger: Floats, error: float, index: int, buffer: Buffer
) -> None:
    """Enter a state into the buffer as sample ``index``."""
    buffer.position[index] = x
    buffer.velocity[index] = v
    buffer.ledger[index] = ledger
    buffer.error[index] = error
