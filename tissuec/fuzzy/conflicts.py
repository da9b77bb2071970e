"""Rules that contradict each other: one condition, two conclusions."""

from collections.abc import Sequence

from msgspec import Struct

from tissuec.fuzzy.conditions import canonical
from tissuec.fuzzy.rules import Rule
from tissuec.fuzzy.sets import AnyShape


class Conflict(Struct, frozen=True):
    """Two rules with one condition that conclude different words for one quantity."""

    first: int
    second: int
    quantity: str


def conflicts(rules: Sequence[Rule]) -> list[Conflict]:
    """Return the rules that contradict an earlier one (or themselves)."""
    known: dict[object, tuple[int, AnyShape]] = {}
    found: list[Conflict] = []
    for number, rule in enumerate(rules):
        condition = canonical(rule.condition)
        for conclusion in rule.conclusions:
            key = condition, conclusion.quantity
            shape = conclusion.word.shape
            earlier, said = known.setdefault(key, (number, shape))
            if said != shape:
                found.append(Conflict(earlier, number, conclusion.quantity))
    return found
