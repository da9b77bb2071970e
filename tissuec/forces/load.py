"""External forces on nodes, applied by the script."""

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.forces import Nodal
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile


class LoadTerm(Struct, frozen=True, eq=False):
    """One vector times one profile: a displacement [m] or a force [N]."""

    vector: Floats  # shape (3,)
    profile: TimeProfile


class Load(Nodal, frozen=True):
    """An external force on each of some nodes: Σ vectorᵢ sᵢ(t) [N] per node.

    Attributes:
        nodes: Shape (n,); one may be named more than once.
        terms: What the force is the sum of.
        span: The sentence that ordered it.
    """

    nodes: Indices
    terms: tuple[LoadTerm, ...]
    span: Span

    def at(self, time: Floats | float) -> Floats:
        """Return the force on each of the nodes [N], shape (…, 3)."""
        return total(self.terms, time)[0]

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
        np.add.at(np.moveaxis(to, -2, 0), self.nodes, self.at(time))

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return F·v, put in from outside, and nothing lost [W], shape (…, 2)."""
        done = (velocity[..., self.nodes, :].sum(axis=-2) * self.at(time)).sum(axis=-1)
        return np.stack([done, np.zeros_like(done)], axis=-1)


def total(terms: tuple[LoadTerm, ...], time: Floats | float) -> tuple[Floats, Floats]:
    """Return the sum of terms [N] and its rate [N/s], each of shape (…, 3)."""
    value, rate = np.zeros((2, *np.shape(time), 3))
    for term in terms:
        factor, slope = term.profile.at(time)
        value += np.multiply.outer(factor, term.vector)
        rate += np.multiply.outer(slope, term.vector)
    return value, rate
