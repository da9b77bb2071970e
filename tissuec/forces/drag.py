"""Ambient damping: F = -d v."""

import numpy as np

from tissuec.forces import Nodal, Resisting
from tissuec.model.network import Floats


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
