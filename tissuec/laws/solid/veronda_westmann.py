"""The exponential law of skin, with a second invariant."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import Formula, exp
from tissuec.laws.solid import I1, I2, SOLID_LAWS


@SOLID_LAWS.member("veronda westmann")
class VerondaWestmann(Struct, frozen=True):
    """The energy μ ((exp(k (I1 - 3)) - 1)/k - (I2 - 3)/2).

    (D. R. Veronda, R. A. Westmann, J. Biomech. 3:111, 1970, of the skin of cats.)

    Attributes:
        stiffening: The number k.
    """

    stiffening: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return (exp(k (I1 - 3)) - 1)/k - (I2 - 3)/2."""
        k = self.stiffening
        return (exp(k * (I1 - 3.0)) - 1.0) * (1.0 / k) - 0.5 * (I2 - 3.0)
