"""Laws of the force of a spring: polynomials, exponential ones, and curves through points.

Points are joined without overshoot; see ``core.arrays``. The nominal stress is by definition
the force per area as drawn.

The linear spring is that of R. Hooke (Lectures de Potentia Restitutiva, 1678), and every spring
is linear unless its tissue says otherwise. Polynomials are the oscillators of Helmholtz and
Duffing (H. Helmholtz, Die Lehre von den Tonempfindungen, 1863, appendix; G. Duffing, Erzwungene
Schwingungen bei veränderlicher Eigenfrequenz, 1918). In the toe of tendons, crimped fibres are
straightened before they resist (L. Blankevoort, R. Huiskes, J. Biomech. Eng. 113:263, 1991: a
parabola that becomes a line, with e* twice the strain of reference there).
"""

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.arrays import monotone_slopes
from tissuec.core.fields import Real, Several
from tissuec.laws import LINEAR, REST, SPRING_LAWS, STRAIN, C, E, of_stress
from tissuec.laws.formula import ZERO, Choice, Formula, Spline, exp


@SPRING_LAWS.member("curve")
class Curve(Struct, frozen=True):
    """A curve through points: cubic pieces that rise and fall only where the points do.

    F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5:300 (1984). Beyond the points,
    the curve is a straight line. The spring constant has no effect.

    Attributes:
        elongations: At the points, ascending.
        forces: At the points.
    """

    elongations: Annotated[tuple[float, ...], Several(units.LENGTH, at_least=2)]
    forces: Annotated[tuple[float, ...], Several(units.FORCE, at_least=2)]

    def __post_init__(self) -> None:
        check_points(self.elongations, "elongations", self.forces, "forces")

    def force(self) -> Formula:
        """Return the curve, straight beyond both of its ends."""
        return through(E, self.elongations, self.forces)


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


@SPRING_LAWS.member("stress curve")
class StressCurve(Struct, frozen=True):
    """A curve of nominal stress against strain, interpolated like ``curve``.

    Young's modulus has no effect on it.

    Attributes:
        strains: At the points, ascending.
        stresses: At the points.
    """

    strains: Annotated[tuple[float, ...], Several(units.NUMBER, at_least=2)]
    stresses: Annotated[tuple[float, ...], Several(units.PRESSURE, at_least=2)]

    def __post_init__(self) -> None:
        check_points(self.strains, "strains", self.stresses, "stresses")

    def force(self) -> Formula:
        """Return the force of a bar under that stress."""
        return of_stress(through(STRAIN, self.strains, self.stresses))


def check_points(
    places: Sequence[float], of_places: str, values: Sequence[float], of_values: str
) -> None:
    """Refuse points that no curve passes through; the message names the entries.

    Args:
        places: Arguments of the points.
        of_places: Name of their entry.
        values: Values of the points.
        of_values: Name of their entry.

    Raises:
        ValueError: Numbers of places and values differ, or places do not ascend.
    """
    if len(places) != len(values):
        raise ValueError(
            f'"{of_values}" has {len(values)} numbers, "{of_places}" {len(places)}: '
            "each point needs one of both"
        )
    if np.any(np.diff(places) <= 0.0):
        raise ValueError(f'"{of_places}" must ascend')


def through(argument: Formula, places: Sequence[float], values: Sequence[float]) -> Formula:
    """Return a piecewise cubic that is monotone where the points are, with straight ends.

    F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5:300 (1984).

    Args:
        argument: Argument of the curve.
        places: Arguments of the points, ascending.
        values: Values of the points.
    """
    x, y = np.array(places), np.array(values)
    slope = monotone_slopes(x, y)
    width = np.diff(x)
    secant = np.diff(y) / width
    bend = (3.0 * secant - 2.0 * slope[:-1] - slope[1:]) / width
    twist = (slope[:-1] + slope[1:] - 2.0 * secant) / width**2
    pieces = np.column_stack([y[:-1], slope[:-1], bend, twist])
    last = (y[-1], slope[-1], 0.0, 0.0)
    rows = tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in (*pieces, last))
    return Spline(argument, tuple(map(float, x)), rows, float(slope[0]))


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
