"""A polynomial of the elongation: the oscillators of Helmholtz and Duffing.

(H. Helmholtz, Die Lehre von den Tonempfindungen, 1863, appendix; G. Duffing, Erzwungene
Schwingungen bei veränderlicher Eigenfrequenz, 1918.)
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import SPRING_LAWS, C, E
from tissuec.laws.formula import Formula


@SPRING_LAWS.member("polynomial")
class Polynomial(Struct, frozen=True):
    """The force c e + a e² + b e³.

    Attributes:
        square: The factor a of e².
        cube: The factor b of e³; Pa/m is N/m^3.
    """

    square: Annotated[float, Real(units.STIFFNESS / units.LENGTH)] = 0.0
    cube: Annotated[float, Real(units.STIFFNESS / units.LENGTH**2)] = 0.0

    def force(self) -> Formula:
        """Return c e + a e² + b e³."""
        return E * (C + E * (self.square + self.cube * E))
