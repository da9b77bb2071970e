"""The toe of tendons: crimped fibres are straightened before they resist.

(L. Blankevoort, R. Huiskes, J. Biomech. Eng. 113:263, 1991: a parabola that goes over into a
line, with e* twice the strain of reference there.)
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import REST, SPRING_LAWS, C, E
from tissuec.laws.formula import ZERO, Choice, Formula


@SPRING_LAWS.member("toe")
class Toe(Struct, frozen=True):
    """No force in compression, c e²/(2 e*) up to e* = strain times L0, then c (e - e*/2).

    The stiffness rises linearly from zero to c and then stays constant.

    Attributes:
        strain: Strain at which the toe ends and all fibres are straight.
    """

    strain: Annotated[float, Real(units.NUMBER, above=0.0)]

    def force(self) -> Formula:
        """Return the three pieces, which join with equal slopes."""
        end = self.strain * REST
        straight = Choice(E - end, C * (E - 0.5 * end), C * E * E / (2.0 * end))
        return Choice(E, straight, ZERO)
