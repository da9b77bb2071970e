"""The exponential law of soft tissue as a solid."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws.formula import Formula, exp
from tissuec.laws.solid import I1, SOLID_LAWS


@SOLID_LAWS.member("exponential")
class SolidExponential(Struct, frozen=True):
    """The energy μ/2k (exp(k (I1 - 3)) - 1). (H. Demiray, J. Biomech. 5:309, 1972.)

    Attributes:
        stiffening: The number k.
    """

    stiffening: Annotated[float, Real(units.NUMBER, above=0.0)]

    def energy(self) -> Formula:
        """Return (exp(k (I1 - 3)) - 1)/2k."""
        return (exp(self.stiffening * (I1 - 3.0)) - 1.0) * (0.5 / self.stiffening)
