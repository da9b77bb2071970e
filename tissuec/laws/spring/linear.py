"""The linear spring, which every spring is unless its tissue says otherwise.

(R. Hooke, Lectures de Potentia Restitutiva, 1678.)
"""

from msgspec import Struct

from tissuec.laws import LINEAR, SPRING_LAWS
from tissuec.laws.formula import Formula


@SPRING_LAWS.member("linear")
class Linear(Struct, frozen=True):
    """The force c e: in proportion to the elongation."""

    def force(self) -> Formula:
        """Return c e."""
        return LINEAR.elastic
