"""Weight: F = m g, E = -m g·x."""

import numpy as np

from tissuec.forces import Nodal
from tissuec.model.network import Floats


class Weight(Nodal, frozen=True):
    """Gravity on masses.

    Attributes:
        mass: [kg], shape (node,); zero where a node is held.
        gravity: g [m/s²], shape (3,).
    """

    mass: Floats
    gravity: Floats

    @property
    def steady(self) -> Floats:
        """Return the acceleration of free nodes [m/s²], shape (3,)."""
        return self.gravity

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the potential energy [J], shape (…); zero at the origin."""
        # Each sum is the same whatever the other axes hold.
        each = np.ascontiguousarray(self.mass * (position @ self.gravity))
        return -np.add.reduce(each, axis=-1)

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the weights of all nodes [N], shape (…, node, 3)."""
        to += self.mass[:, None] * self.gravity
