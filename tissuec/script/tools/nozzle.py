"""A nozzle: where a jet of fluid begins, and which way it goes."""

from math import log, sqrt, tan
from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Length, OneOf, Point, Position, Real
from tissuec.model.network import Floats
from tissuec.script.tools import TOOLS, Shape

SUBMERGED = 0.094  # half-width of a turbulent jet within its own fluid, for each distance
WIDEST = 0.5  # [rad]; beyond, what leaves is a spray and no jet


@TOOLS.member("nozzle")
class Nozzle(Struct, frozen=True, eq=False):
    """The round opening of an irrigation tube; it emits jets and has no contact.

    Attributes:
        diameter: diameter of the opening
        tip: centre of the opening
        direction: direction of the jet
        density: density of the fluid
        surroundings: what is around the jet: gas, in which a jet of liquid hardly spreads, or
            the same liquid, which the jet carries along
        spreading: angle of the cone on which the speed is half of that on the axis; none in
            gas, 5.4 deg in liquid
    """

    diameter: Length
    tip: Position
    direction: Annotated[Floats, Point(units.NUMBER)]
    density: Annotated[float, Real(units.DENSITY, above=0.0)] = 1000.0
    surroundings: Annotated[str, OneOf(("gas", "liquid"))] = "gas"
    spreading: Annotated[float | None, Real(units.NUMBER, at_least=0.0, at_most=WIDEST)] = None

    @property
    def growth(self) -> float:
        """Return by how much the width of the jet grows for each distance."""
        bare = SUBMERGED if self.surroundings == "liquid" else 0.0
        half = bare if self.spreading is None else tan(self.spreading)
        return half / sqrt(log(2.0))

    def shapes(self) -> tuple[Shape, ...]:
        """Return the opening.

        Raises:
            ValueError: The direction is zero.
        """
        length = float(np.linalg.norm(self.direction))
        if not length > 0.0:
            raise ValueError('"direction" cannot be (0, 0, 0)')
        # As for planes: far enough for the digits of the direction.
        ahead = self.direction / length * max(float(np.abs(self.tip).max()), self.diameter)
        return (Shape("opening", np.array([self.tip, self.tip + ahead]), self.diameter / 2.0),)
