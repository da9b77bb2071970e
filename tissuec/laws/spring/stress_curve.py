"""A measured curve of matter: points of strain and stress, joined without overshoot.

The interpolation is that of ``laws.points``; the nominal stress is by definition the force per
area as drawn.
"""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Several
from tissuec.laws import SPRING_LAWS, STRAIN, of_stress
from tissuec.laws.formula import Formula
from tissuec.laws.points import check_points, through


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
