"""Rules as written: conditions on properties, conclusions on quantities."""

from msgspec import Struct

from tissuec.fuzzy.axis import Axis
from tissuec.fuzzy.conditions import Condition
from tissuec.fuzzy.sets import Word


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
