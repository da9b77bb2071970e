"""Springs that, by definition, pull and never push, such as threads and ligaments."""

from msgspec import Struct

from tissuec.laws import SPRING_LAWS, C, E
from tissuec.laws.formula import ZERO, Choice, Formula


@SPRING_LAWS.member("tension only")
class TensionOnly(Struct, frozen=True):
    """The force c e under tension; none in compression."""

    def force(self) -> Formula:
        """Return c e where e is positive."""
        return Choice(E, C * E, ZERO)
