"""Tools that press: a sphere or rounded rod, a hook, and a plane."""

from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Length, Point, Points, PointsIfAny, Position, PositionIfAny
from tissuec.model.network import Floats
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


@TOOLS.member("hook")
class Hook(Struct, frozen=True, eq=False):
    """A round shaft with a bend at its end, which leads to a tip and may bend once more.

    Attributes:
        radius: radius of shaft, bend and tip
        shaft: line from the handle to the bend
        bend: end of the part beyond the bend
        tip: end of the tip, if the hook bends back
    """

    radius: Length
    shaft: Points
    bend: Position
    tip: PositionIfAny = None

    def shapes(self) -> tuple[Shape, ...]:
        handle, corner = self.shaft
        parts = [
            capsule(handle, corner, self.radius, "shaft"),
            capsule(corner, self.bend, self.radius, "bend"),
        ]
        if self.tip is not None:
            parts.append(capsule(self.bend, self.tip, self.radius, "tip"))
        return tuple(parts)


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
