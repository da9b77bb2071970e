"""Formulas of laws: small trees that can be evaluated, differentiated and printed as code.

Numbers are in SI units; dimensions were checked where the formula was written. Derivatives are
formed node by node (A. Griewank, A. Walther, Evaluating Derivatives, 2008).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from tissuec.core.structs import replace

Values: TypeAlias = Mapping[str, Any]
#: Returns the value of a part of a formula.
PartValues: TypeAlias = "Callable[[Formula], Any]"

# A function of one argument: on arrays, in code, and its derivative as a formula.
_ARRAYS: dict[str, Any] = {
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
}


class Formula(Struct, frozen=True):
    """A node of a tree; operators build larger ones and drop what is zero or one."""

    @property
    def parts(self) -> "tuple[Formula, ...]":
        """Return the formulas that this one is made of."""
        return ()

    def at(self, values: Values) -> Any:
        """Return the value where variables have these values, broadcast."""
        return values_at((self,), values)[0]

    def from_parts(self, values: Values, of: "PartValues") -> Any:
        """Return the value; see ``at``.

        Args:
            values: Of variables.
            of: Returns the value of a part.
        """
        raise NotImplementedError

    def slope(self, name: str) -> "Formula":
        """Return the derivative by a variable; at kinks that of the side where it is larger."""
        raise NotImplementedError

    def code(self) -> str:
        """Return an expression of Python's ``math`` on plain numbers."""
        raise NotImplementedError

    def __add__(self, other: "Formula | float") -> "Formula":
        return _add(self, as_formula(other))

    def __radd__(self, other: float) -> "Formula":
        return _add(as_formula(other), self)

    def __sub__(self, other: "Formula | float") -> "Formula":
        return _add(self, as_formula(other), minus=True)

    def __rsub__(self, other: float) -> "Formula":
        return _add(as_formula(other), self, minus=True)

    def __mul__(self, other: "Formula | float") -> "Formula":
        return _multiply(self, as_formula(other))

    def __rmul__(self, other: float) -> "Formula":
        return _multiply(as_formula(other), self)

    def __truediv__(self, other: "Formula | float") -> "Formula":
        return _divide(self, as_formula(other))

    def __rtruediv__(self, other: float) -> "Formula":
        return _divide(as_formula(other), self)

    def __pow__(self, exponent: "Formula | float") -> "Formula":
        return _raise(self, as_formula(exponent))

    def __neg__(self) -> "Formula":
        return _multiply(Constant(-1.0), self)


class _Fixed(Formula, frozen=True):
    """A number."""

    value: float

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return self.value

    def slope(self, name: str) -> Formula:
        return ZERO

    def code(self) -> str:
        return f"({self.value!r})"


class Constant(_Fixed, frozen=True):
    """A number that operations are computed with at once."""


class Given(_Fixed, frozen=True):
    """A number of a law that learning may change, which no operation is computed with at once.

    So a formula has it in the same places whatever its value is.
    """


class Variable(Formula, frozen=True):
    name: str

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return values[self.name]

    def slope(self, name: str) -> Formula:
        return ONE if name == self.name else ZERO

    def code(self) -> str:
        return self.name


class Sum(Formula, frozen=True):
    left: Formula
    right: Formula
    minus: bool

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.left, self.right

    def from_parts(self, values: Values, of: PartValues) -> Any:
        left, right = of(self.left), of(self.right)
        return left - right if self.minus else left + right

    def slope(self, name: str) -> Formula:
        return _add(self.left.slope(name), self.right.slope(name), minus=self.minus)

    def code(self) -> str:
        return f"({self.left.code()} {'-' if self.minus else '+'} {self.right.code()})"


class Product(Formula, frozen=True):
    left: Formula
    right: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.left, self.right

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return of(self.left) * of(self.right)

    def slope(self, name: str) -> Formula:
        return self.left.slope(name) * self.right + self.left * self.right.slope(name)

    def code(self) -> str:
        return f"({self.left.code()} * {self.right.code()})"


class Quotient(Formula, frozen=True):
    above: Formula
    below: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.above, self.below

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return of(self.above) / of(self.below)

    def slope(self, name: str) -> Formula:
        inner = self.below.slope(name)
        outer = self.above.slope(name) / self.below
        return outer if inner == ZERO else outer - self * inner / self.below

    def code(self) -> str:
        return f"({self.above.code()} / {self.below.code()})"


class Power(Formula, frozen=True):
    """A formula to the power of a number."""

    base: Formula
    exponent: float

    @property
    def parts(self) -> tuple[Formula, ...]:
        return (self.base,)

    def from_parts(self, values: Values, of: PartValues) -> Any:
        # A plain number would raise where an array has no value.
        return np.asarray(of(self.base), dtype=float) ** self.exponent

    def slope(self, name: str) -> Formula:
        return self.exponent * self.base ** (self.exponent - 1.0) * self.base.slope(name)

    def code(self) -> str:
        whole = int(self.exponent)
        shown = repr(whole if whole == self.exponent else self.exponent)
        return f"({self.base.code()} ** {shown})"


class VariablePower(Formula, frozen=True):
    """A formula that is not negative to the power of another one: of what learning changes."""

    base: Formula
    exponent: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.base, self.exponent

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return np.asarray(of(self.base), dtype=float) ** of(self.exponent)

    def slope(self, name: str) -> Formula:
        outer = self.exponent * self.base ** (self.exponent - 1.0) * self.base.slope(name)
        inner = self.exponent.slope(name)
        if inner == ZERO:
            return outer
        # x^n log x goes to 0 with x, where the logarithm has no value.
        grown = self * Applied("log", self.base) * inner
        return outer + Choice(self.base - _SMALLEST, grown, ZERO)

    def code(self) -> str:
        return f"({self.base.code()} ** {self.exponent.code()})"


class Applied(Formula, frozen=True):
    """A smooth function of a formula."""

    function: str
    argument: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return (self.argument,)

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return _ARRAYS[self.function](of(self.argument))

    def slope(self, name: str) -> Formula:
        inner = self.argument.slope(name)
        if inner == ZERO:
            return ZERO
        match self.function:
            case "exp":
                return self * inner
            case "log":
                return inner / self.argument
            case "sqrt":
                return 0.5 * inner / self
            case "sin":
                return Applied("cos", self.argument) * inner
            case _:
                return -(Applied("sin", self.argument) * inner)

    def code(self) -> str:
        return f"{self.function}({self.argument.code()})"


def _chosen(test: NDArray[np.bool_], above: ArrayLike, below: ArrayLike) -> NDArray[Any]:
    return np.where(test, above, below)


class Choice(Formula, frozen=True):
    """One formula where a test is at least zero, another one elsewhere."""

    test: Formula
    above: Formula
    below: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        return self.test, self.above, self.below

    def from_parts(self, values: Values, of: PartValues) -> Any:
        # What is not chosen may have no value, such as the root of a negative number.
        with np.errstate(all="ignore"):
            above, below = of(self.above), of(self.below)
        return _chosen(of(self.test) >= 0.0, above, below)

    def slope(self, name: str) -> Formula:
        above, below = self.above.slope(name), self.below.slope(name)
        return above if above == below else Choice(self.test, above, below)

    def code(self) -> str:
        return f"({self.above.code()} if {self.test.code()} >= 0.0 else {self.below.code()})"


class Spline(Formula, frozen=True):
    """Cubic pieces between places, and straight lines before the first and after the last.

    Attributes:
        places: Where pieces begin and the last one ends, ascending.
        pieces: Value, slope and two further coefficients by powers of the distance from the
            beginning of a piece; the last entry is the line behind all places.
        before: Slope before the first place.
    """

    argument: Formula
    places: "tuple[float | Formula, ...]"
    pieces: "tuple[tuple[float | Formula, ...], ...]"
    before: "float | Formula"

    @property
    def parts(self) -> tuple[Formula, ...]:
        rows = (self.places, *self.pieces, (self.before,))
        numbers = (each for row in rows for each in row if isinstance(each, Formula))
        return self.argument, *numbers

    def from_parts(self, values: Values, of: PartValues) -> Any:
        return self.value(of, lambda x, place, below, above: _chosen(x < place, below, above))

    def value(self, of: PartValues, where: Callable[[Any, Any, Any, Any], Any]) -> Any:
        """Return the value of the piece that the argument is in.

        Args:
            of: Returns the value of a part.
            where: Takes a number, a limit, and what is chosen below it and from it on.
        """

        def number(each: float | Formula) -> Any:
            return of(each) if isinstance(each, Formula) else each

        x, first = of(self.argument), number(self.places[0])
        found = number(self.pieces[0][0]) + number(self.before) * (x - first)
        for place, piece in zip(map(number, self.places), self.pieces, strict=True):
            value, slope, bend, twist = map(number, piece)
            z = x - place
            found = where(x, place, found, value + z * (slope + z * (bend + z * twist)))
        return found

    def slope(self, name: str) -> Formula:
        steeper = tuple((b, 2.0 * c, 3.0 * d, 0.0) for _, b, c, d in self.pieces)
        level = (self.before, 0.0, 0.0, 0.0)
        lower = self.places[0] - 1.0  # any place before the first one
        derived = Spline(self.argument, (lower, *self.places), (level, *steeper), 0.0)
        return derived * self.argument.slope(name)

    def code(self) -> str:
        before = f"({self.pieces[0][0]!r}, {self.before!r}, 0.0, 0.0)"
        pieces = ", ".join(repr(piece) for piece in self.pieces)
        return f"spline({self.argument.code()}, {self.places!r}, ({before}, {pieces}))"


ZERO, ONE = Constant(0.0), Constant(1.0)
_SMALLEST = 1e-300  # whose logarithm is taken


def values_at(formulas: Sequence[Formula], values: Values) -> list[Any]:
    """Return the values of formulas; what several have a part in is evaluated once.

    Args:
        values: Of variables.
    """
    known: dict[int, Any] = {}  # by identity, as formulas keep their parts

    def of(formula: Formula) -> Any:
        if id(formula) not in known:
            known[id(formula)] = formula.from_parts(values, of)
        return known[id(formula)]

    return [of(formula) for formula in formulas]


def given(value: "Formula | float") -> Formula:
    """Return a number that learning may change as a formula."""
    return value if isinstance(value, Formula) else Given(float(value))


def as_formula(value: "Formula | float") -> Formula:
    """Return a number as a formula."""
    return value if isinstance(value, Formula) else Constant(float(value))


def apply(function: str, arguments: "tuple[Formula, ...]") -> Formula:
    """Return a smooth function, abs, min or max of arguments; only extremes take several."""
    first, *others = arguments
    match function:
        case "abs":
            return Choice(first, first, -first)
        case "max" | "min" if others:
            # Halves against one another: each choice writes both of its sides twice.
            half = len(arguments) // 2
            one, other = apply(function, arguments[:half]), apply(function, arguments[half:])
            return Choice(one - other if function == "max" else other - one, one, other)
        case "max" | "min":
            return first
        case _:
            return Applied(function, first)


def exp(argument: Formula) -> Formula:
    """Return the exponential of a formula."""
    return Applied("exp", argument)


def replaced(formula: Formula, variables: "Mapping[str, Formula]") -> Formula:
    """Return a formula with others in the places of some of its variables."""
    if isinstance(formula, Variable):
        return variables.get(formula.name, formula)
    parts = {
        name: replaced(part, variables)
        for name in formula.__struct_fields__
        if isinstance(part := getattr(formula, name), Formula)
    }
    return replace(formula, **parts) if parts else formula


def every(formula: Formula) -> Iterator[Formula]:
    """Yield a formula and all that it is made of."""
    yield formula
    for part in formula.parts:
        yield from every(part)


def extent(formula: Formula) -> tuple[int, int]:
    """Return the number of parts of the code of a formula, and the depth of their nesting."""
    known: dict[int, tuple[int, int]] = {}  # parts may be shared by many others

    def of(part: Formula) -> tuple[int, int]:
        if id(part) not in known:
            within = [of(inner) for inner in part.parts]
            count = 1 + sum(count for count, _ in within)
            known[id(part)] = count, 1 + max((depth for _, depth in within), default=0)
        return known[id(part)]

    return of(formula)


def variables(formula: Formula) -> frozenset[str]:
    """Return the names of all variables of a formula."""
    return frozenset(part.name for part in every(formula) if isinstance(part, Variable))


def kinks(formula: Formula, *names: str) -> tuple[Formula, ...]:
    """Return the tests at whose zeros a formula of some variables is not smooth."""
    tests: list[Formula] = []
    for part in every(formula):
        if isinstance(part, Choice):
            tests.append(part.test)
        elif isinstance(part, Spline):
            tests += (part.argument - place for place in part.places)
    return tuple(dict.fromkeys(test for test in tests if variables(test).intersection(names)))


def _add(left: Formula, right: Formula, *, minus: bool = False) -> Formula:
    if right == ZERO:
        return left
    if isinstance(left, Constant) and isinstance(right, Constant):
        return Constant(left.value - right.value if minus else left.value + right.value)
    if left == ZERO:
        return -right if minus else right
    return Sum(left, right, minus)


def _multiply(left: Formula, right: Formula) -> Formula:
    if isinstance(left, Constant) and isinstance(right, Constant):
        return Constant(left.value * right.value)
    if ZERO in (left, right):
        return ZERO
    if left == ONE:
        return right
    return left if right == ONE else Product(left, right)


def _divide(above: Formula, below: Formula) -> Formula:
    if above == ZERO:
        return ZERO
    if isinstance(below, Constant) and below.value != 0.0:
        if isinstance(above, Constant):
            return Constant(above.value / below.value)
        if below == ONE:
            return above
    return Quotient(above, below)


def _raise(base: Formula, exponent: Formula) -> Formula:
    if not isinstance(exponent, Constant):
        return VariablePower(base, exponent)
    if exponent == ZERO:
        return ONE
    return base if exponent == ONE else Power(base, exponent.value)
