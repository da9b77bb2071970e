"""Springs with play, by definition: nothing resists until the play is used up."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import SPRING_LAWS, C, E
from tissuec.laws.formula import ZERO, Choice, Formula


@SPRING_LAWS.member("dead band")
class DeadBand(Struct, frozen=True):
    """No force up to the slack in both directions; beyond it, c times the rest of e.

    Attributes:
        slack: Elongation and compression without resistance.
    """

    slack: Annotated[float, Real(units.LENGTH, at_least=0.0)]

    def force(self) -> Formula:
        """Return c (e ∓ slack) outside of the band."""
        pressed = Choice(-E - self.slack, C * (E + self.slack), ZERO)
        return Choice(E - self.slack, C * (E - self.slack), pressed)
