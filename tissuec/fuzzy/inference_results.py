"""Results of inference: a number with its reasons, or why there is none."""

from typing import Literal

from msgspec import Struct


class AtomDegree(Struct, frozen=True):
    """Degree of one ``is`` of a condition; None where its property has no fact.

    Attributes:
        negated: Whether the condition tests the opposite, of degree 1 less this one.
    """

    property: str
    word: str
    degree: float | None
    negated: bool = False


class Firing(Struct, frozen=True):
    """One rule as it bears on one quantity.

    Attributes:
        rule: Index of the rule in its rule base.
        degree: Degree of the condition times the weight of the rule; 0 if facts are missing.
        word: The word the rule concludes.
        atoms: Every ``is`` of the condition in written order.
        missing: Properties of the condition without a fact, in written order.
        progress: In a gradual mean, how far its facts have gone beyond where outer words are
            fully true, 0 to 1; otherwise 0.
    """

    rule: int
    degree: float
    word: str
    atoms: tuple[AtomDegree, ...]
    missing: tuple[str, ...] = ()
    progress: float = 0.0


class Inference(Struct, frozen=True):
    """The number found for a quantity.

    Attributes:
        value: The number, in the unit of the quantity (on a log scale: not its logarithm).
        source: "rules", or "otherwise" where no rule fired.
        fired: The rules that fired, in written order.
        silent: The rules on this quantity that did not fire.
    """

    value: float
    source: Literal["rules", "otherwise"]
    fired: tuple[Firing, ...]
    silent: tuple[Firing, ...]


class NoRule(Struct, frozen=True):
    """No rule fired for a quantity that declares no ``otherwise``.

    Attributes:
        silent: Every rule on this quantity, with the degrees that kept it from firing.
    """

    silent: tuple[Firing, ...]

    @property
    def missing(self) -> tuple[str, ...]:
        """Return the properties without a fact that kept rules from firing."""
        return tuple(dict.fromkeys(name for firing in self.silent for name in firing.missing))
