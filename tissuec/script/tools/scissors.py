"""Scissors: what cuts is said with each cut."""

from msgspec import Struct

from tissuec.script.tools import TOOLS, Shape


@TOOLS.member("scissors")
class Scissors(Struct, frozen=True, eq=False):
    """Blades that cut where a ``cut`` says; they have no shape of their own."""

    def shapes(self) -> tuple[Shape, ...]:
        return ()
