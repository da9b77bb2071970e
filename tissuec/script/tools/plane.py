"""A plane: a table, or a plate that presses."""

from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Point, Position
from tissuec.model.network import Floats
from tissuec.script.tools import TOOLS, Shape


@TOOLS.member("plane")
class Plane(Struct, frozen=True, eq=False):
    """An infinite plane; nodes stay on the side to which the normal points.

    Attributes:
        point: any point of the plane
        normal: direction at right angles to the plane, towards the side of the nodes
    """

    point: Position
    normal: Annotated[Floats, Point(units.NUMBER)]

    def shapes(self) -> tuple[Shape, ...]:
        """Return the plane.

        Raises:
            ValueError: The normal is zero.
        """
        length = float(np.linalg.norm(self.normal))
        if not length > 0.0:
            raise ValueError('"normal" cannot be (0, 0, 0)')
        # A step of one metre would lose digits in small scenes; its length does not matter.
        ahead = self.normal / length * max(float(np.abs(self.point).max()), 1e-3)
        return (Shape("plane", np.array([self.point, self.point + ahead])),)
