"""Fibres: what they add to the stiffness of a body.

Fibres along the unit vector f that bear β for each strain along them add β f f f f to the
tensor of stiffness. A body of Young's modulus E, stretched along f and free across, then has
the modulus E + β, whatever its Poisson's ratio.
"""

import numpy as np
from msgspec import Struct

from tissuec.matter.elasticity import IN_PLANE, VOIGT
from tissuec.model.network import Floats


class Fibres(Struct, frozen=True, eq=False):
    """Fibres of one direction.

    Attributes:
        direction: f, of as many components as the body has dimensions.
        added: β per Young's modulus of the body without them.
    """

    direction: Floats
    added: float

    @property
    def strain(self) -> Floats:
        """Return the factors of strains in the strain of fibres f · ε f, shape (3,) or (6,).

        They are dimensionless and in Voigt's order; shear strains are changes of angles.
        """
        f = self.direction
        pairs = IN_PLANE if len(f) == 2 else VOIGT
        return np.array([f[i] * f[j] for i, j in pairs])

    @property
    def stiffness(self) -> Floats:
        """Return the stiffness added per Young's modulus, shape (3, 3) or (6, 6).

        It is dimensionless and in Voigt's order.
        """
        return self.added * np.outer(self.strain, self.strain)
