"""A measured curve: points of elongation and force, joined without overshoot."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Several
from tissuec.laws import SPRING_LAWS, E
from tissuec.laws.formula import Formula
from tissuec.laws.points import check_points, through


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
        """Return the curve, straight behind both of its ends."""
        return through(E, self.elongations, self.forces)
