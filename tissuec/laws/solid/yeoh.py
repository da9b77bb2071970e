"""Solids that stiffen with powers of the first invariant."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import Formula
from tissuec.laws.solid import I1, SOLID_LAWS


@SOLID_LAWS.member("yeoh")
class Yeoh(Struct, frozen=True):
    """The energy μ (z + c2 z² + c3 z³)/2 with z = I1 - 3.

    (O. H. Yeoh, Rubber Chem. Technol. 66:754, 1993.)

    Attributes:
        second: The number c2; a published C20 is μ c2/2.
        third: The number c3; a published C30 is μ c3/2.
    """

    second: Annotated[float, Real(units.NUMBER)]
    third: Annotated[float, Real(units.NUMBER, at_least=0.0)] = 0.0

    def energy(self) -> Formula:
        """Return (z + c2 z² + c3 z³)/2."""
        z = I1 - 3.0
        return 0.5 * (z + self.second * z**2 + self.third * z**3)
