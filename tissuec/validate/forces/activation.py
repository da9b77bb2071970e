"""Active fibres: a potential of the lengths of lines, differentiated node by node.

A line has the vector b = Σ s_n x_n and the length λ = (b · b)^½. Its potential is w S Φ(λ), so
that node n is pulled by -w S φ(λ) s_n b/λ. Without limits φ = 1; between the limits l and h,
with u = (λ - l)/(h - l) from 0 to 1, it is 16 u² (1 - u)².
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.validate.forces import ForceFormula, assembled

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

    from tissuec.forces.solids.activation import Activation

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class ActiveFibres(ForceFormula):
    """Active fibres as a field of forces.

    Args:
        active: Read for its nodes, slopes, volumes, limits, stress and profile.
    """

    def __init__(self, active: "Activation"):
        self._nodes, self._slopes, self._weight = active.nodes, active.slopes, active.weight
        self._amount, self._profile = active.amount, active.profile
        self._low, self._width = active.low, active.high - active.low

    def _stress(self, time: float) -> float:
        return self._amount * float(self._profile.at(time)[0])

    def _lines(self, position: Floats) -> tuple[Floats, Floats]:
        """Return b/λ and λ, shapes (element, line, 3) and (element, line)."""
        b = np.einsum("eln,enx->elx", self._slopes, position[self._nodes])
        length = np.sqrt(np.einsum("elx,elx->el", b, b))
        return b / np.where(length > 0.0, length, 1.0)[..., None], length

    def _shares(self, length: Floats) -> tuple[Floats, Floats, Floats]:
        """Return Φ, φ and φ', shape (element, line) each."""
        if not self._width > 0.0:
            return length, np.ones_like(length), np.zeros_like(length)
        u = np.minimum(np.maximum((length - self._low) / self._width, 0.0), 1.0)
        whole = 16.0 * self._width * (u**3 / 3.0 - u**4 / 2.0 + u**5 / 5.0)
        share = 16.0 * u**2 * (1.0 - u) ** 2
        return whole, share, 32.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / self._width

    def _pulls(self, time: float, position: Floats) -> Floats:
        """Return the forces on all nodes [N], shape (node, 3)."""
        unit, length = self._lines(position)
        _, share, _ = self._shares(length)
        pull = -self._stress(time) * self._weight * share
        each = np.einsum("el,eln,elx->enx", pull, self._slopes, unit)
        found = np.zeros_like(position)
        np.add.at(found, self._nodes, each)
        return found

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        to += self._pulls(time, position)

    def potential(self, time: float, position: Floats) -> float:
        """Return the potential at the present stress [J]."""
        _, length = self._lines(position)
        whole, _, _ = self._shares(length)
        return self._stress(time) * float((self._weight * whole).sum())

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power of the fibres [W]."""
        return float(np.vdot(self._pulls(time, position), velocity))

    def matrix(self, time: float, position: Floats, number: Indices, size: int) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m]."""
        unit, length = self._lines(position)
        _, share, slope = self._shares(length)
        scale = self._stress(time) * self._weight
        side = np.divide(scale * share, length, where=length > 0.0, out=np.zeros_like(length))
        both = np.einsum("elx,ely->elxy", unit, unit)
        each = (scale * slope)[..., None, None] * both
        each += side[..., None, None] * (np.eye(3) - both)
        blocks = np.einsum("elm,elxy,eln->emxny", self._slopes, each, self._slopes)
        return assembled(blocks, number[self._nodes], size)
