"""Rules as written: trees of conditions, conclusions, and rules that contradict each other.

A tree is evaluated in two steps: the degree of each ``is`` in written order, then the tree over
those degrees. Explanations show the first step, and coverage analysis replaces it.

Rule bases name their operators (E. H. Mamdani, S. Assilian, Int. J. Man-Mach. Stud. 7:1, 1975:
smallest and largest degree; P. M. Larsen, Int. J. Man-Mach. Stud. 12:3, 1980: the product).
"""

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from functools import reduce
from typing import Literal, TypeAlias, get_args

from msgspec import Struct

from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import AnyShape, Word

Conjunction = Literal["minimum", "product"]
Disjunction = Literal["maximum", "probabilistic sum"]
Implication = Literal["minimum", "product"]
Result = Literal["centre of gravity", "weighted mean", "gradual mean"]


class Operators(Struct, frozen=True):
    """Operators on degrees, and defuzzification (default: Mamdani's choice).

    Attributes:
        conjunction: What ``and`` does: the smaller degree, or a b.
        disjunction: What ``or`` does: the larger degree, or a + b - a b.
        implication: What a firing degree does to the concluded set: clips it, or scales it.
        result: How the joined sets become one number.
    """

    conjunction: Conjunction = "minimum"
    disjunction: Disjunction = "maximum"
    implication: Implication = "minimum"
    result: Result = "centre of gravity"

    def __post_init__(self) -> None:
        for entry, names in CHOICES.items():
            if getattr(self, entry) not in names:
                raise ValueError(f"{entry} must be one of: {', '.join(names)}")

    def all_of(self, a: float, b: float) -> float:
        """Return the degree of ``a and b``."""
        return min(a, b) if self.conjunction == "minimum" else a * b

    def any_of(self, a: float, b: float) -> float:
        """Return the degree of ``a or b``."""
        return max(a, b) if self.disjunction == "maximum" else a + (1.0 - a) * b


#: The names an entry of the language may choose from.
CHOICES: dict[str, tuple[str, ...]] = {
    "conjunction": get_args(Conjunction),
    "disjunction": get_args(Disjunction),
    "implication": get_args(Implication),
    "result": get_args(Result),
}


class Is(Struct, frozen=True):
    """``hardness is very soft``"""

    property: str
    word: Word


class Not(Struct, frozen=True):
    """``not (…)``, and ``… is not …``"""

    operand: "Condition"


class And(Struct, frozen=True):
    """``… and … and …``"""

    operands: "tuple[Condition, ...]"

    def __post_init__(self) -> None:
        _need_operands(self.operands)


class Or(Struct, frozen=True):
    """``… or … or …``"""

    operands: "tuple[Condition, ...]"

    def __post_init__(self) -> None:
        _need_operands(self.operands)


Condition: TypeAlias = Is | Not | And | Or


def atoms(condition: Condition) -> Iterator[Is]:
    """Yield every ``is`` of a condition in written order."""
    match condition:
        case Is():
            yield condition
        case Not(operand):
            yield from atoms(operand)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from atoms(operand)


def negations(condition: Condition, *, negated: bool = False) -> Iterator[bool]:
    """Yield for each of the :func:`atoms` whether an odd number of ``not`` precedes it."""
    match condition:
        case Is():
            yield negated
        case Not(operand):
            yield from negations(operand, negated=not negated)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from negations(operand, negated=negated)


def degree(condition: Condition, degrees: Iterator[float], operators: Operators) -> float:
    """Return how true a condition is.

    Args:
        condition: The tree.
        degrees: The degree of each of its :func:`atoms`, in the same order.
        operators: What ``and`` and ``or`` do.
    """
    if isinstance(condition, Is):
        return next(degrees)
    if isinstance(condition, Not):
        return 1.0 - degree(condition.operand, degrees, operators)
    join = operators.all_of if isinstance(condition, And) else operators.any_of
    return reduce(join, [degree(part, degrees, operators) for part in condition.operands])


def canonical(condition: Condition) -> Hashable:
    """Return a key that is equal for conditions that differ in order, brackets or spelling."""
    match condition:
        case Is(property, word):
            return property, word.shape
        case Not(Not(inner)):
            return canonical(inner)
        case Not(operand):
            return "not", canonical(operand)
        case And() | Or():
            parts = [canonical(part) for part in _flat(condition, type(condition))]
            # How often an operand appears counts: a product of a with itself is not a.
            joined = frozenset(Counter(parts).items())
            return parts[0] if len(parts) == 1 else (type(condition).__name__, joined)


def _flat(condition: Condition, kind: type[And] | type[Or]) -> Iterator[Condition]:
    match condition:
        case Not(Not(inner)):
            yield from _flat(inner, kind)
        case And(operands) | Or(operands) if isinstance(condition, kind) or len(operands) == 1:
            for operand in operands:
                yield from _flat(operand, kind)
        case _:
            yield condition


def _need_operands(operands: tuple[Condition, ...]) -> None:
    if not operands:
        raise ValueError('"and" and "or" need something to join')


class Conclusion(Struct, frozen=True):
    """``spring constant is low``"""

    quantity: str
    word: Word


class Rule(Struct, frozen=True):
    """``if condition then conclusions weighing weight``"""

    condition: Condition
    conclusions: tuple[Conclusion, ...]
    weight: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.weight <= 1.0:
            raise ValueError("the weight of a rule must be above 0 and at most 1")
        if not self.conclusions:
            raise ValueError("a rule needs a conclusion")


class ConcludedQuantity(Struct, frozen=True):
    """A concluded quantity: its range, and the word used where no rule fires."""

    axis: Axis
    otherwise: Word | None = None


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
