"""Dashpots whose force is a power of the speed, by default the first.

The linear dashpot is that of W. Voigt (Ann. Phys. 283:671, 1892); powers describe thinning and
thickening liquids (W. Ostwald, Kolloid-Z. 36:99, 1925).
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import LINEAR, VISCOSITY_LAWS, D, W
from tissuec.laws.formula import Choice, Formula


@VISCOSITY_LAWS.member("power")
class PowerLaw(Struct, frozen=True):
    """The force d v (|w|/v)ⁿ against the motion: that of d w at the speed v.

    If the exponent is below 1: the slower the motion, the larger the ratio of force to speed;
    near rest, explicit methods need small steps.

    Attributes:
        exponent: The number n.
        speed: The speed v at which the force is that of the linear dashpot.
    """

    exponent: Annotated[float, Real(units.NUMBER, at_least=0.1, at_most=10.0)]
    speed: Annotated[float, Real(units.VELOCITY, above=0.0)]

    def force(self) -> Formula:
        """Return ± d v (|w|/v)ⁿ."""
        part = W / self.speed
        size = D * self.speed
        return Choice(W, size * part**self.exponent, -(size * (-part) ** self.exponent))


@VISCOSITY_LAWS.member("linear")
class LinearDashpot(Struct, frozen=True):
    """The force d w: in proportion to the speed."""

    def force(self) -> Formula:
        """Return d w."""
        return LINEAR.viscous
