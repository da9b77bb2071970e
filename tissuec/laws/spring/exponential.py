"""The exponential law of soft tissue: compliant at first, then stiffer and stiffer."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import REST, SPRING_LAWS, C, E
from tissuec.laws.formula import Formula, exp


@SPRING_LAWS.member("exponential")
class Exponential(Struct, frozen=True):
    """The force c L0/k (exp(k e/L0) - 1): c at rest, and stiffer with the strain e/L0.

    The one-dimensional form of Y. C. Fung, Am. J. Physiol. 213:1532 (1967): the stiffness grows
    linearly with the force. With a negative k, springs stiffen in compression instead; a chain
    of them is a Toda lattice.

    Attributes:
        stiffening: The number k; at the strain 1/k, the stiffness is 2.718 times the initial
            one.
    """

    stiffening: Annotated[float, Real(units.NUMBER)]

    def __post_init__(self) -> None:
        if self.stiffening == 0.0:
            raise ValueError('"stiffening" must not be 0; use a linear law instead')

    def force(self) -> Formula:
        """Return c L0/k (exp(k e/L0) - 1)."""
        return C * REST / self.stiffening * (exp(self.stiffening * E / REST) - 1.0)
