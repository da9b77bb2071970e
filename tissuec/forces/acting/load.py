"""Loads: weight, ambient damping, and external forces that the script applies to nodes."""

from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.forces.effects import Effect, Resisting
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


class Nodal(Effect, frozen=True):
    """An effect on each node that does not depend on the positions of other nodes.

    The engine evaluates these effects in its own loop over nodes. They count as applied from
    outside: what holds a node does not feel them.
    """

    @property
    def steady(self) -> Floats | None:
        """Return accelerations of free nodes that are always the same [m/s²], shape (3,)."""
        return None

    @property
    def drag(self) -> Floats | None:
        """Return forces against velocities [N s/m], shape (node,)."""
        return None

    @property
    def loads(self) -> "tuple[Load, ...]":
        """Return the forces that do work on nodes."""
        return ()

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return minus the derivative of the forces [N/m]: none."""
        from scipy.sparse import csc_matrix

        return csc_matrix((3 * size, 3 * size))

    def stiffening(self, time: float, position: Floats) -> Resisting | None:
        """Return None: this force does not depend on displacements."""
        return None

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2): none."""
        return np.zeros((*position.shape[:-2], 2))


class LoadTerm(Struct, frozen=True, eq=False):
    """One vector times one profile: a displacement [m] or a force [N]."""

    vector: Floats  # shape (3,)
    profile: TimeProfile


class Load(Nodal, frozen=True):
    """An external force on each of some nodes: share · Σ vectorᵢ sᵢ(t) [N].

    Attributes:
        nodes: Shape (n,); one may be named more than once.
        terms: What the force is the sum of.
        span: The sentence that ordered it.
        shares: Factor of each node, shape (n,); None if all are 1.
    """

    nodes: Indices
    terms: tuple[LoadTerm, ...]
    span: Span
    shares: Floats | None = None

    @property
    def factors(self) -> Floats:
        """Return the factor of each node, dimensionless, shape (n,)."""
        return np.ones(len(self.nodes)) if self.shares is None else self.shares

    def at(self, time: Floats | float) -> Floats:
        """Return the force on each of the nodes [N], shape (…, n, 3)."""
        return total(self.terms, time)[0][..., None, :] * self.factors[:, None]

    @property
    def is_constant(self) -> bool:
        """Return whether it does not change in time."""
        return all(term.profile.kind == "constant" for term in self.terms)

    @property
    def loads(self) -> "tuple[Load, ...]":
        """Return itself."""
        return (self,)

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        place: Any = (..., self.nodes, slice(None))
        np.add.at(to, place, self.at(time))

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return F·v, put in from outside, and nothing lost [W], shape (…, 2)."""
        done = (velocity[..., self.nodes, :] * self.at(time)).sum(axis=(-2, -1))
        return np.stack([done, np.zeros_like(done)], axis=-1)


def total(terms: tuple[LoadTerm, ...], time: Floats | float) -> tuple[Floats, Floats]:
    """Return the sum of terms [N] and its rate [N/s], each of shape (…, 3)."""
    value, rate = np.zeros((2, *np.shape(time), 3))
    for term in terms:
        factor, slope = term.profile.at(time)
        value += np.multiply.outer(factor, term.vector)
        rate += np.multiply.outer(slope, term.vector)
    return value, rate


class Weight(Nodal, frozen=True):
    """Gravity on masses.

    Weights of elements are distributed to nodes by the shape functions, which is consistent.
    Their masses differ from these, so that the moments of inertia are those of the body.

    Attributes:
        mass: [kg], shape (node,); zero where a node is held.
        gravity: g [m/s²], shape (3,).
        weighing: Ratios of weights to those of the masses, dimensionless, shape (node,).
    """

    mass: Floats
    gravity: Floats
    weighing: Floats

    @property
    def steady(self) -> Floats:
        """Return the acceleration of free nodes [m/s²], shape (node, 3)."""
        return self.weighing[:, None] * self.gravity

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the potential energy [J], shape (…); zero at the origin."""
        # Each sum is the same whatever the other axes hold.
        heavy = self.mass * self.weighing
        each = np.ascontiguousarray(heavy * (position @ self.gravity))
        return -np.add.reduce(each, axis=-1)

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the weights of all nodes [N], shape (…, node, 3)."""
        to += (self.mass * self.weighing)[:, None] * self.gravity


class Drag(Nodal, frozen=True):
    """Ambient damping of each node.

    Attributes:
        damping: d [N s/m], shape (node,); zero where a node is held.
    """

    damping: Floats

    @property
    def drag(self) -> Floats:
        """Return d [N s/m], shape (node,)."""
        return self.damping

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        to -= self.damping[:, None] * velocity

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the supplied power, zero, and the dissipated one, d v² [W], shape (…, 2)."""
        lost = (velocity**2).sum(axis=-1) @ self.damping
        return np.stack([np.zeros_like(lost), lost], axis=-1)

    def braking(self, position: Floats) -> Resisting:
        """Return the damping as a function that adds its product with velocities [N s/m]."""

        def resist(moved: Floats, to: Floats) -> None:
            to += self.damping[:, None] * moved

        return resist
