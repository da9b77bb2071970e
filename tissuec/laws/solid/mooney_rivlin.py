"""Solids with a second invariant: stiffer in equibiaxial than in uniaxial tension."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import Formula
from tissuec.laws.solid import I1, I2, SOLID_LAWS


@SOLID_LAWS.member("mooney rivlin")
class MooneyRivlin(Struct, frozen=True):
    """The energy μ ((1 - s) (I1 - 3) + s (I2 - 3))/2. (M. Mooney, J. Appl. Phys. 11:582, 1940.)

    Attributes:
        share: The part s of the shear modulus that belongs to the second invariant.
    """

    share: Annotated[float, Real(units.NUMBER, at_least=0.0, at_most=1.0)]

    def energy(self) -> Formula:
        """Return ((1 - s) (I1 - 3) + s (I2 - 3))/2."""
        return 0.5 * ((1.0 - self.share) * (I1 - 3.0) + self.share * (I2 - 3.0))
