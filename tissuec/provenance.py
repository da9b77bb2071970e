"""Where the physical numbers of a scene come from: the written word, rule, line and degree."""

from collections.abc import Iterator
from dataclasses import dataclass

from tissuec.core.units import LENGTH, show
from tissuec.scene.model import Given, Tissue
from tissuec.scene.quantities import Spread


@dataclass(frozen=True, slots=True)
class Reason:
    """One line of an explanation.

    Attributes:
        degree: Of the rule; None where a number was written.
        place: ``file:line``.
        facts: What the rule was told, such as "hardness soft 1.00".
    """

    word: str
    degree: float | None
    place: str
    facts: str


@dataclass(frozen=True, slots=True)
class Explained:
    """A quantity of a tissue, its value and its reasons, strongest first."""

    quantity: str
    value: float  # SI
    shown: str  # "8.79 N/m", "1 mg/node"
    how: str  # "written", "rules", "otherwise"
    reasons: tuple[Reason, ...]


def explain_tissue(tissue: Tissue) -> tuple[Explained, ...]:
    """Return every quantity of a tissue with the lines that gave it."""
    return tuple(_explained(given) for given in tissue.given.values())


def _explained(given: Given) -> Explained:
    quantity = given.quantity
    return Explained(
        quantity.name, given.value, shown_value(given), given.how, tuple(_reasons(given))
    )


def shown_value(given: Given) -> str:
    """Return a value with its unit and what it belongs to."""
    quantity = given.quantity
    if quantity.name == "prestress":
        return f"{100.0 * given.value:.3g} %"
    if given.value == quantity.none:
        return "none"
    return show(given.value, quantity.dimension) + belonging(given.spread, given.length)


def belonging(spread: Spread, length: float | None) -> str:
    """Return what stands behind a value to say what it belongs to: "/node", " per 1 mm"."""
    if spread == "each spring":
        return "" if length is None else f" per {show(length, LENGTH)}"
    return "/node" if spread == "each node" else "/body"


def _reasons(given: Given) -> Iterator[Reason]:
    if not given.fired:
        yield Reason("", None, given.span.place, "")
    for fired in given.fired:
        yield Reason(fired.word, fired.degree, fired.span.place, fired.facts)
