"""Contact over one stretch, looked at with as little work as that takes.

To find what touches takes most of the time of a force. So pairs that are near are listed, for
as long as no node has gone far, and what the force, its power and the bristles need of a state
is looked up once.
"""

from dataclasses import replace

import numpy as np
from scipy import sparse

from tissuec.contact import Contact, Touch
from tissuec.network import Floats, Indices


class Vicinity:
    """A field of forces, as ``Situation.fields`` has them, of contact."""

    def __init__(self, contact: Contact):
        self._contact, self._where = contact, np.zeros((0, 3))
        self._seen = np.zeros((0, 3)), np.zeros((0, 3))
        self._touch: Touch | None = None

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3)."""
        self._contact.push(self._look(position, velocity), to)

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that damping and friction take out [W]."""
        return self._contact.loss(self._look(position, velocity))

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is put in from outside, which is none [W]."""
        return 0.0

    def bristle_rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the velocities that are bristles [m/s²], shape (m, 3)."""
        return self._contact.bristle_rates(self._look(position, velocity))

    def energy(self, time: float, position: Floats) -> float:
        """Return the energy of pressed contacts [J]."""
        return float(self._near(position).energy(time, position))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy; see ``Contact.matrix``."""
        return self._near(position).matrix(time, position, number, size)

    def _look(self, position: Floats, velocity: Floats) -> Touch:
        """Return what touches in a state."""
        before = zip(self._seen, (position, velocity), strict=True)
        if self._touch is None or not all(np.array_equal(*pair) for pair in before):
            self._touch = self._near(position).touches(position, velocity)
            self._seen = position.copy(), velocity.copy()
        return self._touch

    def _near(self, position: Floats) -> Contact:
        """Return contact with the pairs that may touch."""
        reach = self._contact.stride
        gone = np.inf
        if len(self._where):
            gone = np.sqrt(((position - self._where) ** 2).sum(axis=1).max())
        if not gone <= reach:
            pairs = self._contact.near(position, 2.0 * reach)
            self._contact, self._where = replace(self._contact, pairs=pairs), position.copy()
        return self._contact
