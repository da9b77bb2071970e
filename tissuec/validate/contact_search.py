"""Contact during one interval, with a search that skips pairs that stay apart.

To find what touches takes most of the time of a force. So pairs that are near are listed, for
as long as no node has gone far, and what the force, its power and the bristles need of a state
is looked up once.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.structs import replace
from tissuec.forces.contact.contact import Contact, ContactPairs
from tissuec.model.network import Floats, Indices
from tissuec.validate.forces import ForceFormula
from tissuec.validate.forces.contact import ContactForce, Touching

FAR = 1e100  # [m]


class NearbyContact(ForceFormula):
    """Contact as a field of forces."""

    def __init__(self, contact: Contact):
        self._contact, self._force = contact, ContactForce(contact, is_located=True)
        self._where = np.zeros((0, 3))
        self._pairs: ContactPairs
        self._seen = np.zeros((0, 3)), np.zeros((0, 3))
        self._touching: Touching | None = None

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        to += self._look(position, velocity).force

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that damping and friction take out [W]."""
        return self._look(position, velocity).lost

    def bristle_rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the velocities that are bristles [m/s²], shape (m, 3)."""
        return self._look(position, velocity).bristle_rates

    @property
    def is_cut(self) -> bool:
        """Return whether there are bristles that either stick or slip."""
        return self._contact.between is not None and self._contact.rubs

    @property
    def slides(self) -> NDArray[np.bool_]:
        """Return which bristles slip, shape (m,)."""
        return self._force.slides

    @slides.setter
    def slides(self, slides: NDArray[np.bool_]) -> None:
        self._force.slides, self._touching = slides, None

    def lengths(self, position: Floats, velocity: Floats) -> tuple[Floats, Floats, Floats]:
        """Return lengths of bristles [m], those at which they slip [m], and growth [m/s].

        The growth is that without slipping; all are of shape (m,).
        """
        of, found = self._contact, self._look(position, velocity)
        size = np.sqrt((velocity[of.memory] ** 2).sum(axis=1)) / of.rate
        return size, found.grip / of.stiffness, found.ahead

    def slip(
        self, position: Floats, velocity: Floats, changed: NDArray[np.bool_] | None = None
    ) -> None:
        """Cut bristles.

        Args:
            position: Of all nodes [m], shape (node, 3).
            velocity: Of all nodes with bristles [m/s], changed in place, shape (node, 3).
            changed: Which slip or stick from now on, shape (m,); None to see which slip.
        """
        pairs = self._near(position)
        if changed is None:
            self._force.slip(position, velocity, pairs)
        else:
            self._force.change(position, velocity, pairs, changed)
        self._touching = None

    def energy(self, time: float, position: Floats) -> float:
        """Return the energy of pressed contacts [J]."""
        return self._force.energy(position, self._near(position))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy, which only has to lead to where forces
        balance; see ``Contact.matrix``.
        """
        near = replace(self._contact, pairs=self._near(position))
        return sparse.coo_matrix(near.matrix(time, position, number, size))

    def _look(self, position: Floats, velocity: Floats) -> Touching:
        """Return the touching pairs of a state."""
        before = zip(self._seen, (position, velocity), strict=True)
        if self._touching is None or not all(np.array_equal(*pair) for pair in before):
            self._touching = self._force.at(position, velocity, self._near(position))
            self._seen = position.copy(), velocity.copy()
        return self._touching

    def _near(self, position: Floats) -> ContactPairs:
        """Return the pairs that may touch."""
        reach = self._contact.stride
        gone = np.inf
        if len(self._where):
            gone = np.sqrt(((position - self._where) ** 2).sum(axis=1).max())
        if not gone <= reach:
            # Steps of solvers that are taken back can lead further than squares of distances.
            self._pairs = self._contact.near(np.clip(position, -FAR, FAR), 2.0 * reach)
            self._where = position.copy()
        return self._pairs
