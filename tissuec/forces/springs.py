"""Springs and dashpots with their laws and internal variables.

A spring between a and b with r = x_b - x_a, L = |r|, u = r / L, elongation e = L - L0 and
closing speed w = u · (v_b - v_a) has the tension T = f(e) + g(e, w) of its law, and what
branches add (``branches``); it pulls a with T u and b with -T u. One of zero length has no
direction and thus no tension. What a run evaluates in each step is in ``runs_kernel``,
``pairs_kernel`` and, for springs with laws, ``springs_kernel``.
"""

from collections.abc import Callable
from functools import cache
from math import inf, prod
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.vectors import dot, norm
from tissuec.forces import Resisting
from tissuec.forces.branches import elongated, flat, pulled, tightened
from tissuec.kernels.spring_geometry import add_pulls, add_resistance, measure
from tissuec.model.network import Floats
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
    """Return lengths and tensions of springs that all act, as laws say at zero length, too.

    Args:
        springs: The springs.
        position: Of all nodes [m], shape (…, node, 3).
        velocity: Of all nodes [m/s], shape as ``position``.
    """
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
        position: Of all nodes [m], shape (…, node, 3).
        velocity: Of all nodes [m/s], shape as ``position``; rates are None without it.
    """
    each, shape = position.shape[-2:], (*position.shape[:-2], len(ends))
    x = _states(position, each)
    v = x if velocity is None else _states(velocity, each)
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
