"""Tools that grasp or cut: forceps with two jaws, clamps, needles and scissors."""

from typing import ClassVar

import numpy as np

from tissuec.core.fields import LengthIfAny, PointsIfAny
from tissuec.script.tools import TOOLS, NamedTool, Shape, capsule


@TOOLS.member("forceps")
class Forceps(NamedTool, frozen=True, eq=False):
    """Two jaws that close and hold tissue between them by friction.

    Without entries, forceps have no shape; ``grasp`` then names the nodes that they hold.

    Attributes:
        radius: radius of both jaws, which are rods with round ends
        upper: line through the upper jaw
        lower: line through the lower jaw
    """

    grasps: ClassVar[bool] = True

    radius: LengthIfAny = None
    upper: PointsIfAny = None
    lower: PointsIfAny = None

    def shapes(self) -> tuple[Shape, ...]:
        """Return both jaws, or nothing without entries.

        Raises:
            ValueError: An entry is missing or has no effect, or the jaws overlap.
        """
        self.check_shaft()
        if self.radius is None and self.upper is None and self.lower is None:
            return ()
        if self.radius is None or self.upper is None or self.lower is None:
            raise ValueError('jaws need "radius", "upper" and "lower"')
        if self.size is not None or self.shaft is not None:
            name = "shaft" if self.size is None else "size"
            raise ValueError(
                f'"{name}" is for forceps without jaws; jaws are drawn as they are'
            )
        jaws = np.array([self.upper, self.lower])
        if float(np.linalg.norm(np.subtract(*jaws.mean(axis=1)))) <= 2.0 * self.radius:
            raise ValueError('the "upper" and the "lower" jaw overlap as drawn')
        return (
            capsule(*self.upper, self.radius, "upper jaw"),
            capsule(*self.lower, self.radius, "lower jaw"),
        )


@TOOLS.member("clamp")
class Clamp(NamedTool, frozen=True, eq=False):
    """A clamp that locks, such as a haemostat; ``grasp`` names the nodes that it holds."""

    grasps: ClassVar[bool] = True


@TOOLS.member("needle")
class Needle(NamedTool, frozen=True, eq=False):
    """A curved needle; ``grasp`` names the end of the thread that it pulls.

    It has no shape and pierces nothing: it moves the nodes that it holds.
    """

    grasps: ClassVar[bool] = True


@TOOLS.member("scissors")
class Scissors(NamedTool, frozen=True, eq=False):
    """Blades without a shape; the sentence ``cut … with`` says where they cut."""
