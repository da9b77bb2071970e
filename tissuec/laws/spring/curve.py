"""A measured curve: points of elongation and force, joined without overshoot."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Several
from tissuec.core.interpolation import monotone_slopes
from tissuec.laws import SPRING_LAWS, E
from tissuec.laws.formula import Formula, Spline


@SPRING_LAWS.member("curve")
@dataclass(frozen=True, slots=True)
class Curve:
    """A curve through points: cubic pieces that rise and fall only where the points do.

    F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5:300 (1984). Beyond the points it
    goes on straight. The spring constant has no part in it.

    Attributes:
        elongations: At the points, ascending.
        forces: At the points.
    """

    elongations: Annotated[tuple[float, ...], Several(units.LENGTH, at_least=2)]
    forces: Annotated[tuple[float, ...], Several(units.FORCE, at_least=2)]

    def __post_init__(self) -> None:
        if len(self.elongations) != len(self.forces):
            raise ValueError(
                f'"forces" has {len(self.forces)} numbers, "elongations" '
                f"{len(self.elongations)}: each point needs both"
            )
        if np.any(np.diff(self.elongations) <= 0.0):
            raise ValueError('"elongations" must ascend')

    def force(self) -> Formula:
        """Return the curve, straight behind both of its ends."""
        places, values = np.array(self.elongations), np.array(self.forces)
        slope = monotone_slopes(places, values)
        width = np.diff(places)
        secant = np.diff(values) / width
        bend = (3.0 * secant - 2.0 * slope[:-1] - slope[1:]) / width
        twist = (slope[:-1] + slope[1:] - 2.0 * secant) / width**2
        pieces = np.column_stack([values[:-1], slope[:-1], bend, twist])
        last = (values[-1], slope[-1], 0.0, 0.0)
        rows = tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in (*pieces, last))
        return Spline(E, tuple(map(float, places)), rows, float(slope[0]))
