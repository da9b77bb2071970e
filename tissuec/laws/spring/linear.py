"""The linear spring, which every spring is unless its tissue says otherwise."""

from dataclasses import dataclass

from tissuec.laws import LINEAR, SPRING_LAWS
from tissuec.laws.formula import Formula


@SPRING_LAWS.member("linear")
@dataclass(frozen=True, slots=True)
class Linear:
    """The force c e: in proportion to the elongation."""

    def force(self) -> Formula:
        """Return c e."""
        return LINEAR.elastic
