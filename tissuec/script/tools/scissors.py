"""Scissors: what cuts is said with each cut."""

from tissuec.script.tools import TOOLS, NamedTool


@TOOLS.member("scissors")
class Scissors(NamedTool, frozen=True, eq=False):
    """Blades without a shape; the sentence ``cut … with`` says where they cut."""
