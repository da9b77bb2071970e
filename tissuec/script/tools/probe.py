"""A probe: a sphere or a rounded rod."""

import numpy as np

from tissuec.core.fields import Length, PointsIfAny, PositionIfAny
from tissuec.script.tools import TOOLS, HandTool, Shape, capsule


@TOOLS.member("probe")
class Probe(HandTool, frozen=True, eq=False):
    """A sphere at a point, or a rod with round ends along an axis.

    Attributes:
        radius: radius of the sphere or rod
        centre: centre of a sphere
        axis: line between the centres of the round ends of a rod
    """

    radius: Length
    centre: PositionIfAny = None
    axis: PointsIfAny = None

    def shapes(self) -> tuple[Shape, ...]:
        """Return the sphere or the rod.

        Raises:
            ValueError: There are both a centre and an axis, or neither, or the axis or the
                shaft has no length.
        """
        self.check_shaft()
        if (self.centre is None) == (self.axis is None):
            raise ValueError('it needs either a "centre" (a sphere) or an "axis" (a rod)')
        if self.axis is not None:
            if self.shaft is not None:
                raise ValueError('"shaft" is for spheres; a rod is drawn along its "axis"')
            if not np.any(np.subtract(*self.axis)):
                raise ValueError('"axis" has no length; for a sphere, use "centre"')
            return (capsule(*self.axis, self.radius),)
        assert self.centre is not None
        return (capsule(self.centre, self.centre, self.radius),)
