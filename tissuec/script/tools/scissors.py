"""Scissors: what cuts is said with each cut."""

from msgspec import Struct

from tissuec.script.tools import TOOLS, Shape


@TOOLS.member("scissors")
class Scissors(Struct, frozen=True, eq=False):
    """Blades without a shape; the sentence ``cut … with`` says where they cut."""

    def shapes(self) -> tuple[Shape, ...]:
        return ()
