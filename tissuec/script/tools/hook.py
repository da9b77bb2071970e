"""A hook: a shaft with a bend."""

from msgspec import Struct

from tissuec.core.fields import Length, Points, Position, PositionIfAny
from tissuec.script.tools import TOOLS, Shape, capsule


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
