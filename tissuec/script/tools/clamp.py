"""A clamp: what stays closed on tissue by itself."""

from typing import ClassVar

from tissuec.script.tools import TOOLS, NamedTool


@TOOLS.member("clamp")
class Clamp(NamedTool, frozen=True, eq=False):
    """A clamp that locks, such as a haemostat; ``grasp`` names the nodes that it holds."""

    grasps: ClassVar[bool] = True
