"""Springs whose force is a polynomial of the elongation, at least piece by piece.

The linear spring is that of R. Hooke (Lectures de Potentia Restitutiva, 1678), and every spring
is linear unless its tissue says otherwise. Polynomials are the oscillators of Helmholtz and
Duffing (H. Helmholtz, Die Lehre von den Tonempfindungen, 1863, appendix; G. Duffing, Erzwungene
Schwingungen bei veränderlicher Eigenfrequenz, 1918). In the toe of tendons, crimped fibres are
straightened before they resist (L. Blankevoort, R. Huiskes, J. Biomech. Eng. 113:263, 1991: a
parabola that becomes a line, with e* twice the strain of reference there).
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.laws import LINEAR, REST, SPRING_LAWS, C, E
from tissuec.laws.formula import ZERO, Choice, Formula


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


@SPRING_LAWS.member("linear")
class Linear(Struct, frozen=True):
    """The force c e: in proportion to the elongation."""

    def force(self) -> Formula:
        """Return c e."""
        return LINEAR.elastic


@SPRING_LAWS.member("tension only")
class TensionOnly(Struct, frozen=True):
    """The force c e under tension; none in compression."""

    def force(self) -> Formula:
        """Return c e where e is positive."""
        return Choice(E, C * E, ZERO)


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
