"""Fields with a potential whose items are triangles of the skin."""

from typing import Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.forces.potential_fields import PotentialField
from tissuec.forces.surfaces.triangles import SkinTriangles
from tissuec.model.network import Floats, Indices


class TriangleField(PotentialField, frozen=True):
    """A field with a potential on triangles of the skin; torn ones do not act.

    Attributes:
        skin: The triangles.
    """

    skin: SkinTriangles

    @classmethod
    def on(cls, skin: SkinTriangles, **columns: Floats | float) -> Self:
        """Return the field on some triangles.

        Args:
            columns: As the attributes of the class, in SI units, shape (triangle, …) or ().
        """
        none = np.zeros(0, dtype=np.int64)
        return cls(walls=none, walled=none, nodes=skin.corners, skin=skin, **columns)

    def only(self, items: Indices) -> Self:
        """Return some triangles, by indices of shape (n,)."""
        return replace(super().only(items), skin=self.skin.some(items))

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the triangles that are torn, ascending; ``alive`` as in ``Field``."""
        return self.skin.torn(alive)
