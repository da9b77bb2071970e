"""A needle: what a thread is pulled by."""

from typing import ClassVar

from tissuec.script.tools import TOOLS, NamedTool


@TOOLS.member("needle")
class Needle(NamedTool, frozen=True, eq=False):
    """A curved needle; ``grasp`` names the end of the thread that it pulls.

    It has no shape and pierces nothing: it moves the nodes that it holds.
    """

    grasps: ClassVar[bool] = True
