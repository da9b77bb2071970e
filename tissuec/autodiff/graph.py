"""Numbers that write down what is done with them, in a graph of operations.

A function that gets such numbers in place of floats is traced: the graph then has all that it
does. Equal operations are one, and what is constant is computed at once. Arguments of an
operation come before it, so that a sweep over a graph needs no sorting.
"""

import math
import operator
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from numbers import Real
from typing import Any, NamedTuple, TypeAlias, Union

#: What operations take: a number of a graph, or any other one, which is constant.
Operand: TypeAlias = Union["Number", float]
#: Derivatives of a number by its arguments; it takes the number, and then these.
Rule: TypeAlias = Callable[..., Sequence[Operand]]


class TracingError(ValueError):
    """A traced function does what cannot be written down; the message is a sentence."""


#: Functions of NumPy that are operators.
_OPERATORS: "Mapping[str, Callable[[Any, Any], Any]]" = {
    "add": operator.add, "subtract": operator.sub, "multiply": operator.mul,
    "divide": operator.truediv, "power": operator.pow, "greater": operator.gt,
    "less": operator.lt,
}  # fmt: skip


class Operation(NamedTuple):
    """An operation of a graph.

    Attributes:
        name: "constant" and "input" have no arguments, "ruled" is its first one, with
            derivatives of its own, "unknown" is found by an iteration; others are those of
            ``evaluation`` and ``emission``.
        arguments: Places of these in the graph.
        detail: The value of a constant, the name of an input, the ``Rule`` of a ruled one, the
            ``Iteration`` of an unknown, or the function of an "array" that only NumPy computes.
    """

    name: str
    arguments: tuple[int, ...] = ()
    detail: "float | str | Rule | Iteration | Callable[..., Any] | None" = None


class Iteration(NamedTuple):
    """How an unknown is found: in rounds, until its steps are small.

    Attributes:
        variables: What changes in a round, inputs of the graph; the first is the unknown.
        start: Their first values. An operation has these as arguments, and then what else the
            following are made of.
        step: Of a round; there is no further one when it is less than ``close``.
        following: The variables after the round.
        close: A size of steps.
        rounds: As many are enough.
    """

    variables: "tuple[Number, ...]"
    start: "tuple[Number, ...]"
    step: "Number"
    following: "tuple[Number, ...]"
    close: float
    rounds: int


class Graph:
    """Operations in the order in which they were written down.

    Attributes:
        operations: All of them.
    """

    def __init__(self) -> None:
        self.operations: list[Operation] = []
        self._places: dict[Operation, int] = {}

    def number(self, value: Operand) -> "Number":
        """Return a number of this graph.

        Raises:
            TracingError: It is no number.
        """
        if isinstance(value, Number):
            return value
        try:
            return self.record(Operation("constant", (), float(value)))
        except TypeError:
            kind = type(value).__name__
            raise TracingError(f"it computes with a {kind} as if it were a number") from None

    def input(self, name: str) -> "Number":
        """Return the input of a name."""
        return self.record(Operation("input", (), name))

    def record(self, operation: Operation) -> "Number":
        """Return the result of an operation, which is written down unless it is there."""
        place = self._places.get(operation)
        if place is None:
            place = self._places[operation] = len(self.operations)
            self.operations.append(operation)
        return Number(self, place)

    def apply(self, name: str, *values: Operand) -> "Number":
        """Return the result of an operation by its name.

        Raises:
            TracingError: It computes with conditions.
        """
        if name != "where" and any(isinstance(value, Inequality) for value in values):
            raise TracingError(
                "it computes with a condition: write where(condition, 1.0, 0.0) for a number"
            )
        places = tuple(self.number(value).place for value in values)
        return self.record(Operation(name, places))

    def reached(
        self, outputs: "Iterable[Number]", *, by_rules: bool = False, known: Container[int] = ()
    ) -> list[int]:
        """Return the places of outputs and of all that they are made of, ascending.

        Args:
            by_rules: Follow the arguments of ruled numbers instead of their formulas.
            known: Places of what is left out, with what it is made of.
        """
        found: set[int] = set()
        left = [output.place for output in outputs]
        while left:
            place = left.pop()
            if place not in found and place not in known:
                found.add(place)
                left += self.arguments_of(place, by_rules=by_rules)
        return sorted(found)

    def arguments_of(self, place: int, *, by_rules: bool) -> tuple[int, ...]:
        """Return the arguments of an operation; ``by_rules`` as in ``reached``."""
        name, arguments, _ = self.operations[place]
        if name == "ruled":
            return arguments[1:] if by_rules else arguments[:1]
        return arguments

    def apart_from(
        self, outputs: "Iterable[Number]", changing: "Iterable[Number]", *,
        by_rules: bool = False,
    ) -> "list[Number]":  # fmt: skip
        """Return the arguments of outputs that do not depend on some numbers; no constants.

        Args:
            by_rules: As for ``reached``.
        """
        varies = {each.place for each in changing}
        needed: set[int] = set()
        for place in self.reached(outputs, by_rules=by_rules):
            arguments = self.arguments_of(place, by_rules=by_rules)
            if not varies.isdisjoint(arguments):
                varies.add(place)
                needed.update(arguments)
        apart = sorted(needed - varies)
        return [Number(self, k) for k in apart if self.operations[k].name != "constant"]

    def inputs_of(self, outputs: "Iterable[Number]") -> set[str]:
        """Return the names of the inputs that outputs depend on."""
        found = (self.operations[place] for place in self.reached(outputs))
        return {str(each.detail) for each in found if each.name == "input"}

    def has(self, name: str, outputs: "Iterable[Number]") -> bool:
        """Return whether outputs are made of any operation of a name."""
        return any(self.operations[place].name == name for place in self.reached(outputs))


class Number:
    """The result of an operation, with which one computes as with a float.

    Attributes:
        graph: What writes down the operations.
        place: That of its operation.
    """

    __slots__ = ("graph", "place")

    def __init__(self, graph: Graph, place: int):
        self.graph, self.place = graph, place

    @property
    def operation(self) -> Operation:
        """Return the operation of which it is the result."""
        return self.graph.operations[self.place]

    @property
    def value(self) -> float | None:
        """Return the value of a constant; None of what is none."""
        name, _, detail = self.operation
        return detail if name == "constant" and isinstance(detail, float) else None

    @property
    def is_condition(self) -> bool:
        """Return whether this is a ``Inequality``, which is true or false."""
        return self.operation.name == "greater"

    @property
    def _opposite(self) -> "Number | None":
        """Return the number of which this is the negative, where that is written down."""
        name, arguments, _ = self.operation
        return Number(self.graph, arguments[0]) if name == "negative" else None

    def __add__(self, other: Operand) -> "Number":
        return _sum(self, self.graph.number(other))

    def __radd__(self, other: Operand) -> "Number":
        return _sum(self.graph.number(other), self)

    def __sub__(self, other: Operand) -> "Number":
        return _difference(self, self.graph.number(other))

    def __rsub__(self, other: Operand) -> "Number":
        return _difference(self.graph.number(other), self)

    def __mul__(self, other: Operand) -> "Number":
        if not isinstance(other, Number | Real):
            return NotImplemented  # of what scales itself by numbers, such as a vector
        return _product(self, self.graph.number(other))

    def __rmul__(self, other: Operand) -> "Number":
        return _product(self.graph.number(other), self)

    def __truediv__(self, other: Operand) -> "Number":
        return _quotient(self, self.graph.number(other))

    def __rtruediv__(self, other: Operand) -> "Number":
        return _quotient(self.graph.number(other), self)

    def __neg__(self) -> "Number":
        return _negative(self)

    def __pow__(self, exponent: Operand) -> "Number":
        return _power(self, self.graph.number(exponent))

    def __rpow__(self, base: Operand) -> "Number":
        return _power(self.graph.number(base), self)

    def __gt__(self, other: Operand) -> "Inequality":
        return Inequality(self.graph, self.graph.apply("greater", self, other).place)

    def __lt__(self, other: Operand) -> "Inequality":
        return Inequality(self.graph, self.graph.apply("greater", other, self).place)

    def __ge__(self, other: Operand) -> "Inequality":
        raise TracingError(
            "it compares numbers by >= or <=: write > or <, as both sides of where(…) have to "
            "meet where numbers are equal"
        )

    __le__ = __ge__

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Real):
            raise TracingError(
                "it compares a number by == or !=: write where(a > b, …), whose sides have to "
                "meet where numbers are equal"
            )
        return isinstance(other, Number) and (self.graph, self.place) == (
            other.graph,
            other.place,
        )

    def __hash__(self) -> int:
        return self.place

    def __abs__(self) -> "Number":
        return self.graph.apply("maximum", self, -self)

    def __bool__(self) -> bool:
        raise TracingError("it branches on a number: write where(condition, one, other)")

    def __float__(self) -> float:
        raise TracingError(
            "it needs the value of a number: write functions of tissuec.autodiff, such as sqrt "
            "and maximum, in place of those of math and numpy"
        )

    __int__ = __index__ = __float__  # pyright: ignore[reportAssignmentType]

    def __array_ufunc__(self, function: Any, method: str, *values: Any, **options: Any) -> Any:
        """Do what operators of numbers of NumPy do; raises TracingError of other functions."""
        known = _OPERATORS.get(function.__name__)
        if known is None:
            raise TracingError(
                f"it takes {function.__name__} of numpy: write functions of tissuec.autodiff, "
                "such as sqrt and maximum"
            )
        one, other = (each if isinstance(each, Number) else float(each) for each in values)
        return known(one, other)


class Inequality(Number):
    """Whether one number is greater than another one; see ``functions.where``."""

    __slots__ = ()


# --- arithmetic: what is constant, and the shortest form of signs -----------------------


def _negative(a: Number) -> Number:
    if a.value is not None:
        return a.graph.number(-a.value)
    if a._opposite is not None:
        return a._opposite
    name, arguments, _ = a.operation
    if name == "difference":
        return a.graph.record(Operation(name, arguments[::-1]))
    return a.graph.apply("negative", a)


def _sum(a: Number, b: Number) -> Number:
    p, q = a.value, b.value
    if p is not None and q is not None:
        return a.graph.number(p + q)
    if p == 0.0:
        return b
    if q == 0.0:
        return a
    if a == b:
        return 2.0 * a
    if b._opposite is not None:
        return a - b._opposite
    if a._opposite is not None:
        return b - a._opposite
    return a.graph.apply("sum", *sorted((a, b), key=_by_place))


def _difference(a: Number, b: Number) -> Number:
    p, q = a.value, b.value
    if p is not None and q is not None:
        return a.graph.number(p - q)
    if p == 0.0:
        return -b
    if q == 0.0:
        return a
    if a == b:
        return a.graph.number(0.0)
    if b._opposite is not None:
        return a + b._opposite
    if a._opposite is not None:
        return -(a._opposite + b)
    return a.graph.apply("difference", a, b)


def _product(a: Number, b: Number) -> Number:
    if b.value is not None:
        a, b = b, a
    p = a.value
    if p is not None:
        return _multiple(p, b)
    for one, other in ((a, b), (b, a)):
        if one._opposite is not None:
            return -(one._opposite * other)
        if (chosen := _only_where(one)) is not None:
            condition, is_if_true = chosen
            sides = (other, 0.0) if is_if_true else (0.0, other)
            return a.graph.apply("where", condition, *sides)
    return a.graph.apply("product", *sorted((a, b), key=_by_place))


def _multiple(p: float, b: Number) -> Number:
    """Return p b, where constants come first, and those of products of products are one."""
    if b.value is not None:
        return b.graph.number(p * b.value)
    if p == 0.0:
        return b.graph.number(0.0)
    if p == 1.0:
        return b
    if p == -1.0:
        return -b
    if b._opposite is not None:
        return -p * b._opposite
    name, arguments, _ = b.operation
    if name == "product":
        first, second = (Number(b.graph, place) for place in arguments)
        if first.value is not None:
            return p * first.value * second
    return b.graph.apply("product", p, b)


def _only_where(a: Number) -> tuple[Number, bool] | None:
    """Return the condition under which a number is 1, and whether it is 1 if that is true.

    None of numbers that are not 1 in one case, and 0 in the other one.
    """
    name, arguments, _ = a.operation
    if name != "where":
        return None
    condition, one, other = (Number(a.graph, place) for place in arguments)
    if (one.value, other.value) in ((1.0, 0.0), (0.0, 1.0)):
        return condition, one.value == 1.0
    return None


def _quotient(a: Number, b: Number) -> Number:
    p, q = a.value, b.value
    if p is not None and q is not None and q != 0.0:
        return a.graph.number(p / q)
    if p == 0.0 or q == 1.0:
        return a
    if a._opposite is not None:
        return -(a._opposite / b)
    if b._opposite is not None:
        return -(a / b._opposite)
    if q is not None and abs(math.frexp(q)[0]) == 0.5:  # a power of two, whose inverse is exact
        return (1.0 / q) * a
    return a.graph.apply("quotient", a, b)


def _power(a: Number, b: Number) -> Number:
    """Return aᵇ, as products where b is a small whole number."""
    exponent = b.value
    if exponent is None or exponent != int(exponent) or abs(exponent) > _MOST_FACTORS:
        if exponent == 0.5:
            return a.graph.apply("sqrt", a)
        return a.graph.apply("power", a, b)
    if exponent < 0.0:
        return 1.0 / _power(a, -b)
    found, square, left = a.graph.number(1.0), a, int(exponent)
    while left:
        if left & 1:
            found = found * square
        left >>= 1
        square = square * square if left else square
    return found


_MOST_FACTORS = 64


def _by_place(number: Number) -> int:
    return number.place
