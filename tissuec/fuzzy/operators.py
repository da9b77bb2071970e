"""The operators a rule base chooses by name.

(E. H. Mamdani, S. Assilian, Int. J. Man-Mach. Stud. 7:1, 1975: smallest and largest degree;
P. M. Larsen, Int. J. Man-Mach. Stud. 12:3, 1980: the product.)
"""

from typing import Literal, get_args

from msgspec import Struct

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
