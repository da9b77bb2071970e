"""Springs and dashpots: their laws, what they remember, and rest lengths that change in time.

A spring between a and b with r = x_b - x_a, L = |r|, u = r / L, elongation e = L - L0 and
closing speed w = u · (v_b - v_a) has the tension T = f(e) + g(e, w) of its law, and what
branches add (``branches``); it pulls a with T u and b with -T u. One of zero length has no
direction and thus no tension. What a run evaluates in each step is in ``runs_kernel``,
``pairs_kernel`` and, for springs with laws, ``springs_kernel``.

Springs with memory: branches that relax, and rest lengths that flow.

A spring of elongation e = L - L0 - p, whose rest length has flowed by p, pulls with

    T = S + g(w),    S = f(e) + Σ c1 (e - q),    w = L',
    q' = (e - q) / τ,    p' = max(0, |S| - F) sign(S) / η.

A branch is a spring c1 and a dashpot c1 τ in a row, beside the spring; q is what its dashpot
gave way by. One of them makes the standard linear solid, several a Prony series. Above the
yield force F the rest length flows with the viscosity η (E. C. Bingham, Fluidity and
Plasticity, 1922), under spring and branches together, and beside the dashpot g. A branch
stores ½ c1 (e - q)²; c1 (e - q) q' and S p' are lost, neither of them ever negative.

Rest lengths that change in time: threads and joints that are tightened or loosened.

Meanwhile the rest length of each spring follows a profile,

    L0(t) = base + change s(t),

and the work -∫ f(L - L0) dL0 is done on it from outside.
"""

from collections.abc import Callable, Sequence
from functools import cache
from math import inf, prod
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import dot, norm
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.effects import Resisting
from tissuec.kernels.records import InternalVariables, RestLengthActuators
from tissuec.kernels.spring_geometry import add_pulls, add_resistance, measure
from tissuec.laws.evaluation import Behaviour
from tissuec.model.inelastic import Inelastic
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.model.springs import Springs


class SpringPull(NamedTuple):
    """Lengths and tensions of some springs.

    Attributes:
        length: Present lengths [m], shape (…, spring).
        tension: [N], shape (…, spring); zero for dead springs and at zero length.
    """

    length: Floats
    tension: Floats


class SpringForce(Struct, frozen=True, eq=False):
    """The force of some springs of a net.

    Attributes:
        springs: With their present numbers.
        alive: Which of them act, shape (spring,).

    Shared arguments:
        position: Of all nodes [m], shape (…, node, 3), or (node, 3) where that is said.
        velocity: Of all nodes [m/s], shape as ``position``.
    """

    springs: Springs
    alive: NDArray[np.bool_]

    def pull(self, position: Floats, velocity: Floats) -> SpringPull:
        """Return lengths and tensions."""
        length, tension = stretched(self.springs, position, velocity)
        return SpringPull(length, np.where(self.alive & (length > 0.0), tension, 0.0))

    def add_forces(self, position: Floats, pull: SpringPull, to: Floats) -> None:
        """Add what the springs pull at their ends, in their order.

        Args:
            position: As for ``pull``.
            pull: What ``pull`` returned.
            to: Forces on all nodes [N], contiguous, shape (…, node, 3).
        """
        ends = np.ascontiguousarray(self.springs.ends)
        place, force = (_states(each, position.shape[-2:]) for each in (position, to))
        pulls = (_states(each, (len(ends),)) for each in pull)
        _compiled(add_pulls)(ends, place, *pulls, force)

    def vectors(self, position: Floats, velocity: Floats) -> Floats:
        """Return the force of each on its first end [N], shape (…, spring, 3)."""
        length, tension = self.pull(position, velocity)
        along = tension / np.where(length > 0.0, length, 1.0)
        return along[..., None] * reach(self.springs.ends, position)

    def energy(self, position: Floats, velocity: Floats) -> Floats:
        """Return the energy of springs with branches [J], dead or not, shape (…, spring)."""
        springs = self.springs
        length, _ = measured(springs.ends, position)
        stretch = length - springs.rest
        if springs.inelastic is None:
            return springs.behaviour.energy(stretch)
        variables = springs.inelastic.variables(flat(velocity))
        e = stretch - variables[..., -1, :]
        return springs.behaviour.energy(e) + springs.inelastic.energy(e, variables)

    # --- bounds, at positions and velocities of shape (node, 3) -----------------------------

    def stiffening(self, position: Floats, velocity: Floats) -> Resisting:
        """Return a bound of the stiffness, an operator on displacements [N/m].

        Springs under tension also resist sideways (T / L); the weakening by pressed springs is
        ignored. Branches count with their stiffness against a sudden pull.
        """
        length, direction, closing = self._geometry(position, velocity)
        behaviour, memory = self.springs.behaviour, self.springs.inelastic
        stretch, own = length - self.springs.rest, flat(velocity)
        tension = pulled(behaviour, memory, stretch, own)
        along = behaviour.steepness(elongated(memory, stretch, own), closing)
        if memory is not None:
            along = along + memory.sudden
        across = np.maximum(tension, 0.0) / np.where(length > 0.0, length, inf)
        return self._resisting(direction, along, across if across.any() else None)

    def braking(self, position: Floats, velocity: Floats) -> Resisting | None:
        """Return a bound of the damping, an operator on velocities [N s/m], or None."""
        length, direction, closing = self._geometry(position, velocity)
        stretch, memory = length - self.springs.rest, self.springs.inelastic
        stretch = elongated(memory, stretch, flat(velocity))
        damping = self.springs.behaviour.sluggishness(stretch, closing)
        return self._resisting(direction, damping) if damping.any() else None

    def giving(self, position: Floats) -> float:
        """Return a bound of the rates at which springs relax and yield [1/s]."""
        springs = self.springs
        if springs.inelastic is None:
            return 0.0
        stretch = norm(reach(springs.ends, position)) - springs.rest
        rates = springs.inelastic.fastest(springs.behaviour.steepness(stretch))
        return float(rates.max(initial=0.0))

    def _geometry(self, position: Floats, velocity: Floats) -> tuple[Floats, Floats, Floats]:
        """Return lengths [m], directions, and how fast springs lengthen [m/s]."""
        gap = reach(self.springs.ends, position)
        length = norm(gap)
        direction = gap / np.where(length > 0.0, length, 1.0)[:, None]
        return length, direction, dot(direction, reach(self.springs.ends, velocity))

    def _resisting(
        self, direction: Floats, along: Floats, across: Floats | None = None
    ) -> Resisting:
        """Return forces per displacement along and across springs, added up at their ends.

        Args:
            direction: Shape (spring, 3).
            along, across: [N/m] or [N s/m], shape (spring,); None if there is nothing.
        """
        ends = np.ascontiguousarray(self.springs.ends)
        beside = np.zeros(0) if across is None else across
        add = _compiled(add_resistance)

        def resist(moved: Floats, to: Floats) -> None:
            add(ends, direction, along, beside, moved, to)

        return resist


def stretched(springs: Springs, position: Floats, velocity: Floats) -> SpringPull:
    """Return lengths and tensions of springs that all act, as laws say at zero length, too."""
    behaviour, memory = springs.behaviour, springs.inelastic
    length, closing = measured(
        springs.ends, position, velocity if behaviour.is_viscous else None
    )
    stretch, own = length - springs.rest, flat(velocity)
    if closing is None:
        return SpringPull(length, pulled(behaviour, memory, stretch, own))
    return SpringPull(length, tightened(behaviour, memory, stretch, closing, own))


def measured(
    ends: NDArray[np.int32], position: Floats, velocity: Floats | None = None
) -> tuple[Floats, Floats | None]:
    """Return lengths of springs [m] and how fast they lengthen [m/s], shape (…, spring).

    Args:
        ends: Node pair of each spring, shape (spring, 2).
        velocity: Of all nodes, which internal variables may follow [m/s], shape (…, row, 3);
            rates are None without it.
    """
    shape, x = (*position.shape[:-2], len(ends)), _states(position, position.shape[-2:])
    v = x if velocity is None else _states(velocity, velocity.shape[-2:])
    length = np.empty((len(x), len(ends)))
    closing = np.empty((len(x), 0 if velocity is None else len(ends)))
    _compiled(measure)(np.ascontiguousarray(ends), x, v, length, closing)
    return length.reshape(shape), None if velocity is None else closing.reshape(shape)


def _states(values: Floats, each: tuple[int, ...]) -> Floats:
    """Return values in any unit, shape (…, *each), in the shape (state, values of each)."""
    states = values.shape[: values.ndim - len(each)]
    return np.ascontiguousarray(values, dtype=float).reshape(prod(states), prod(each))


@cache
def _compiled(function: Callable[..., None]) -> Callable[..., None]:
    """Return a function of ``kernels.spring_geometry`` as it is shipped."""
    from tissuec.compiled.calls import Shipped

    return Shipped(function, "spring_geometry")


def reach(ends: NDArray[np.integer], values: Floats) -> Floats:
    """Return the difference of a nodal vector along each spring, shape (…, spring, 3).

    Args:
        ends: Node pair of each spring, shape (spring, 2).
        values: Nodal vectors in any unit, shape (…, node, 3).
    """
    return values.take(ends[:, 1], axis=-2) - values.take(ends[:, 0], axis=-2)


def flat(velocity: Floats) -> Floats:
    """Return velocities of shape (…, node, 3) [m/s] as flat components, shape (…, 3 node)."""
    return velocity.reshape(*velocity.shape[:-2], -1)


def pulled(
    behaviour: Behaviour, inelastic: Inelastic | None, stretch: Floats, velocity: Floats
) -> Floats:
    """Return the force S of springs with or without memory [N], shape (…, spring).

    Args:
        behaviour: Laws and numbers of the springs.
        inelastic: Their branches and flow, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    if inelastic is None:
        return behaviour.pull(stretch)
    variables = inelastic.variables(velocity)
    e = stretch - variables[..., -1, :]
    return behaviour.pull(e) + inelastic.pull(e, variables)


def elongated(inelastic: Inelastic | None, stretch: Floats, velocity: Floats) -> Floats:
    """Return the elongation e = L - L0 - p, p being the flow [m], shape (…, spring).

    Args:
        inelastic: Branches and flow of the springs, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    return stretch if inelastic is None else stretch - inelastic.flowed(velocity)


def tightened(
    behaviour: Behaviour,
    inelastic: Inelastic | None,
    stretch: Floats,
    closing: Floats,
    velocity: Floats,
) -> Floats:
    """Return the tension S + g(e, w) of springs with or without memory [N], shape (…, spring).

    Args:
        behaviour: Laws and numbers of the springs.
        inelastic: Their branches and flow, None if there are none.
        stretch: L - L0 [m], shape (…, spring).
        closing: w, the rate of lengthening [m/s], shape (…, spring).
        velocity: Of all nodes [m/s], flat, shape (…, 3 node).
    """
    braking = behaviour.brake(elongated(inelastic, stretch, velocity), closing)
    return pulled(behaviour, inelastic, stretch, velocity) + braking


def table_of(inelastic: Inelastic, rows: Indices) -> InternalVariables:
    """Return the record that kernels read.

    Args:
        inelastic: Of the springs that act, with places of rows.
        rows: Places of the rows that variables are kept in, shape (m,).
    """
    has = inelastic.slot >= 0
    spring, branch = np.nonzero(has[:-1].T)
    flowing = np.flatnonzero(has[-1])
    flow = np.full(has.shape[1], -1)
    flow[flowing] = len(spring) + np.arange(len(flowing))
    chosen = np.append(branch, np.full(len(flowing), -1)), np.append(spring, flowing)
    return InternalVariables(
        first=np.concatenate([[0], np.cumsum(has[:-1].sum(axis=0))]).astype(np.int64),
        constant=inelastic.constant[branch, spring],
        pace=1.0 / inelastic.time[branch, spring],
        flow=flow,
        limit=inelastic.limit,
        viscosity=inelastic.viscosity,
        slot=inelastic.slot[chosen],
        rate=inelastic.rate[chosen],
        scale=1.0 / inelastic.rate[chosen],
        change=np.zeros(len(chosen[0])),
        rows=rows,
    )


class ChangingRestLengths(Struct, frozen=True, eq=False):
    """Springs that are drawn in or paid out.

    Attributes:
        springs: Shape (n,).
        base, change: What makes their rest lengths [m], shape (n,).
        span: The sentence.
    """

    springs: Indices
    base: Floats
    change: Floats
    profile: TimeProfile
    span: Span

    def rest(self, time: float) -> Floats:
        """Return the rest lengths at a time [m], shape (n,)."""
        return self.base + self.profile.at(time)[0] * self.change

    def rate(self, time: float) -> Floats:
        """Return the rates of the rest lengths [m/s], shape (n,)."""
        return self.profile.at(time)[1] * self.change

    def rate_of(self, spring: int, time: float) -> float:
        """Return the rate of one rest length [m/s], 0 for a spring that is none of these."""
        return float(self.rate(time)[self.springs == spring].sum())

    def lengthened(self, spring: int, by: float) -> "ChangingRestLengths":
        """Return the same with one spring longer by a length [m], if it is one of these."""
        return replace(self, base=self.base + by * (self.springs == spring))


def reels(
    parts: Sequence[ChangingRestLengths], row: Indices, ends: Indices, first_act: int
) -> RestLengthActuators:
    """Return springs whose rest lengths change as tables.

    Args:
        parts: What changes, in the order of the acts.
        row: Where the engine keeps each spring, -1 for those that do not act, shape (spring,).
        ends: Nodes of each spring as the engine keeps them, shape (spring, 2).
        first_act: Number of the profile of the first part among the acts.
    """
    springs = np.concatenate([*(part.springs for part in parts), np.zeros(0, dtype=np.int64)])
    acts = np.repeat(first_act + np.arange(len(parts)), [len(part.springs) for part in parts])
    acting = row[springs] >= 0
    return RestLengthActuators(
        spring=row[springs][acting],
        low=ends[springs, 0][acting],
        high=ends[springs, 1][acting],
        base=np.concatenate([*(part.base for part in parts), np.zeros(0)])[acting],
        change=np.concatenate([*(part.change for part in parts), np.zeros(0)])[acting],
        act=acts[acting].astype(np.int64),
    )
