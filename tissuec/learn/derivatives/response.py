"""The response of a net at rest: the change of an equilibrium by forces, exactly.

With a the accelerations and M the masses, K = -M ∂a/∂x is symmetric, and what changes the
forces on free nodes by F changes their places by K⁻¹ F. A net that could move somehow without
any force has no K⁻¹. Where forces do no work along such a motion, how it gives way to them is
known all the same, and nothing moves along it.
"""

import numpy as np
from scipy import sparse

from tissuec.mechanics.low_rank import LowRankFactor
from tissuec.mechanics.stiffness import Stiffness
from tissuec.model.network import Floats, Indices

SOUND = 1e-12  # of the largest pivot: what is smaller is rounding
SHIFT = 1e-8  # of the largest entry of K, where K is singular
TURNS = 8  # of refinement then
LEFT = 1e-6  # of the largest force: what may be left of those that a singular K bears
ROUNDING = 1e-12  # of the stiffest spring over the size of the net


class UnresistedMotion(Exception):
    """Forces act along a motion that nothing resists; the number of a free node is given."""


class StaticResponse:
    """K of the free nodes of a net, factorised.

    Args:
        by_x: ∂a/∂x of all nodes but for large volumes [1/s²], shape (3 node, 3 node).
        wide: What these add to K is this times its transpose [(N/m)^½], shape (3 node, column).
        mass: Of all nodes [kg], shape (node,).
        free: Nodes that move, shape (free,).
        size: Of the net [m].

    Attributes:
        sound: Whether every motion is resisted.
    """

    def __init__(
        self,
        by_x: sparse.csr_matrix,
        wide: Floats,
        mass: Floats,
        free: Indices,
        size: float,
    ):
        self.entries = (3 * free[:, None] + np.arange(3)).ravel()
        self.weights = np.repeat(mass[free], 3)
        inner = by_x[self.entries][:, self.entries]
        matrix = sparse.csc_matrix(-sparse.diags(self.weights) @ inner)
        self.matrix = Stiffness(matrix, wide[self.entries])
        wide = self.matrix.wide
        top = float(np.abs(self.matrix.diagonal()).max(initial=0.0))
        self._noise = ROUNDING * top * size
        self.sound = False
        try:
            self._factor = LowRankFactor(matrix, wide, wide)
            self.sound = self._factor.soundness > SOUND
        except RuntimeError:  # singular
            pass
        if not self.sound:
            one = sparse.identity(len(self.entries), format="csc")
            shifted = sparse.csc_matrix(matrix + (SHIFT * top or 1.0) * one)
            self._factor = LowRankFactor(shifted, wide, wide)

    def moved(self, force: Floats) -> Floats:
        """Return the displacements of free nodes [m] by forces [N], shape (3 free, change).

        Raises:
            UnresistedMotion: Nothing resists these forces.
        """
        found = self._factor.solve(force)
        if self.sound:
            return found
        for _ in range(TURNS):
            found += self._factor.solve(force - self.matrix(found))
        left = np.abs(force - self.matrix(found)).max(axis=1, initial=0.0)
        if left.max(initial=0.0) > LEFT * np.abs(force).max(initial=0.0) + self._noise:
            raise UnresistedMotion(int(np.argmax(left)) // 3)
        return found
