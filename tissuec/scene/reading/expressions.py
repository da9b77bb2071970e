"""Expressions and conditions: names looked up, dimensions checked, numbers in SI units."""

import re
from collections.abc import Callable, Sequence
from copy import copy
from functools import reduce
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean, proposal
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import (
    ACCELERATION,
    ALL_UNITS,
    DIMENSION_NAMES,
    FREQUENCY,
    LENGTH,
    NUMBER,
    STANDARD_GRAVITY,
    SYMBOLS,
    VOLUME,
    Dimension,
    Unit,
    UnitError,
    converted,
    describe,
    keeping_prefix,
    parse_unit,
    suggested_unit,
)
from tissuec.lang import syntax as s
from tissuec.lang.ranges import MESSAGE
from tissuec.lang.tokens import NUMBER_PATTERN
from tissuec.lang.words import STEPS
from tissuec.scene.program.functions import FUNCTIONS
from tissuec.scene.program.library import Library
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.ranges import difference
from tissuec.scene.reading.values import LARGEST_NUMBER, Value

Truth = NDArray[np.bool_]

_COMPARE: dict[str, Callable[..., Truth]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}
#: The sign with the same meaning after both sides are exchanged.
_EXCHANGED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
_EXTREMES = {"min": np.minimum, "max": np.maximum}
TURN = 2.0 * np.pi  # [rad]
_OF_ANGLES = ("sin", "cos")
_NUMERIC = {"sin": np.sin, "cos": np.cos, "exp": np.exp, "log": np.log}

_RANGES: dict[str, str] = dict.fromkeys(
    ("linspace", "arange", "range", "seq", "logspace"),
    "a range is for a study: vary NAME = 2 mm to 10 mm in 5 steps",
)

# Patterns of what is wrong, which ``re`` compiles when it first needs them.
#: A number or a vector with a unit, up to that.
_AMOUNT = r"(-?[0-9.]+([eE][+-]?[0-9]+)?|\([^()]*\))(?=\s*[^\W\d][^\s()]*\Z)"

#: A number with a unit of which a part was read as a name.
_MULTIPLIED = rf"({NUMBER_PATTERN})\s*(\*?)\s*((?:[^\W\d][\w^]*[*/])*[^\W\d]\w*)\Z"

#: A number with a unit whose power lacks its sign: N/mm2.
_POWER = rf"({NUMBER_PATTERN})\s*((?:[^\W\d]+[0-9]?[*/])*[^\W\d]+[23])\Z"

#: What follows the lower end of a range, up to the unit of its upper end.
_OTHER_END = rf"[ \t]*(?:to|and)[ \t]+-?{NUMBER_PATTERN}[ \t]*([^\W\d][\w*/^·-]*)"

#: What overflows or has no value is found in the result.
_quietly = np.errstate(all="ignore")

_ENDS = ("end", "the end", "start", "the start")  # of the run, which have no names
#: What else may be meant by letters that name axes only in conditions of sets.
_AXES = {
    name: f"; a direction is a vector, such as {vector}"
    for name, vector in (("x", "(1, 0, 0)"), ("y", "(0, 1, 0)"), ("z", "(0, 0, 1)"))
}


class Scope:
    """Scope of names and calls; subclasses add points or measures."""

    #: Whether values are known now; if they are measured in a run, none can be refused.
    is_known = True
    #: Where files are found besides the folder of the text that names them.
    library: Library | None = None
    #: The values of parameters, in the value of a function.
    bound: tuple[Value, ...] = ()

    def __init__(self, findings: Findings):
        self.findings = findings

    @property
    def outermost(self) -> "Scope":
        """The scope of params and lets, in which names in values of functions are looked up."""
        return self

    @property
    def functions(self) -> Sequence[str]:
        """Return the names of functions that the scene declares."""
        return () if self.outermost is self else self.outermost.functions

    def name(self, name: s.Name) -> Value:
        """Return the value of a name, or reject it."""
        raise NotImplementedError

    def has(self, name: s.Name) -> bool:
        """Return whether a name has a value here."""
        raise NotImplementedError

    def names(self) -> Sequence[str]:
        """Return the names that have values here, as they were declared."""
        raise NotImplementedError

    def unknown(self, name: s.Name) -> NoReturn:
        """Reject a name that has no value here."""
        self.findings.pass_over_doubtful(name.key)
        _refuse_unit(name, self.findings)
        self.findings.reject(
            "TIS301",
            f'there is no number called "{name.text}"',
            name.span,
            hint=Hint(
                "text in quotes is a name; write numbers without quotes", *_unquoted(name)
            )
            if not name.words
            else self._otherwise(name),
        )

    def _otherwise(self, name: s.Name) -> Hint:
        """Return the number meant by a name that has no value, or how to declare it."""
        if name.key in _ENDS:
            return Hint(
                "a time is a number, such as 0.5 s, or one with a name: "
                "let end = 0.5 s (of expectations also: over run)"
            )
        if name.text in SYMBOLS:
            text = f"1 {name.text}"
            return Hint(f'a unit follows a number: write "{text}"', Edit(text))
        declared = f'declare it: "param {name.text} = …" or "let {name.text} = …"'
        found = alternatives(name.text, self.names(), what="numbers") or Hint(declared)
        return Hint(found + _AXES.get(name.key, ""), *found.edits)

    def call(self, call: s.Call) -> Value:
        """Return the value of a call that is no function, or reject it."""
        self.findings.pass_over_doubtful(call.function.key)
        known = (*self.functions, *FUNCTIONS)
        return self.findings.reject(
            "TIS301",
            f'there is no function called "{call.function.text}"',
            call.function.span,
            hint=_RANGES.get(call.function.key)
            or did_you_mean(call.function.key, known)
            or f"functions: {', '.join(known)}",
        )

    def test(self, node: s.Expression) -> Truth:
        """Return the truth of a test, shape (item,) or a scalar; most scopes reject it."""
        self.findings.reject(
            "TIS312",
            f'"{node.span.text}" is not a condition',
            node.span,
            hint='a condition compares numbers: "a < b" or "a between b and c"',
        )

    # --- values -------------------------------------------------------------------------------

    def evaluate(self, node: s.Expression) -> Value:
        """Return the value of an expression; rejects others and mixed dimensions."""
        match node:
            case s.Number():
                value = Value(np.asarray(node.value), NUMBER, is_literal=True)
                return self._finite(value, node.span)
            case s.Quantity():
                if node.unit == STEPS:
                    message = f'"{STEPS}" is not a unit'
                    self.findings.reject("TIS104", message, node.span, hint=ALL_UNITS)
                unit = self._unit(node.unit)
                return self._finite(
                    Value(np.asarray(node.value * unit.factor), unit.dimension), node.span
                )
            case s.Name():
                return self.name(node)
            case s.Vector():
                return self._vector(node)
            case s.Signed():
                value = self.evaluate(node.operand)
                return Value(-value.amount, value.dimension, value.is_vector, value.is_literal)
            case s.Sum():
                return self._sum(node)
            case s.Product():
                return self._product(node)
            case s.Power():
                return self._power(node)
            case s.Call():
                return self._call(node)
            case s.Applied():
                return self._applied(node)
            case s.FormalParameter():
                return self.bound[node.number]
            case s.Listing(items=(_, _, _)):
                hint = proposal(f"({node.span.text[1:-1]})")
                self.findings.reject(
                    "TIS312", "a vector has round brackets", node.span, hint=hint
                )
            case _:
                self.findings.reject(
                    "TIS312", "a number is needed here, not a condition or a list", node.span
                )

    def _unit(self, text: str) -> Unit:
        """Return a unit; rejects silently those reported by the parser."""
        return parse_unit(text) if text else self.findings.stop()

    def number(self, node: s.Expression) -> Value:
        """Return the value of an expression that must not be a vector."""
        value = self.evaluate(node)
        if value.is_vector:
            self.findings.reject("TIS312", "one number is needed here, not a vector", node.span)
        return value

    @_quietly
    def _vector(self, node: s.Vector) -> Value:
        items = [self.number(item) for item in node.items]
        if len(items) != 3:
            is_long = len(items) > 3
            self.findings.reject(
                "TIS312",
                f"a vector has three components, not {len(items)}",
                node.span,
                hint=Hint(
                    "write decimals with a point", *_pointed(node.span.text, len(items) - 3)
                )
                if is_long
                else "write 0 for an unused component",
            )
        if node.unit is not None:
            unit = self._unit(node.unit)
            items = [
                Value(item.amount * unit.factor, unit.dimension)
                if item.dimension == NUMBER and not _has_unit(part)
                else item
                for item, part in zip(items, node.items, strict=True)
            ]
        # A bare 0 among components with units could only mean none of them: it is let through.
        given = [
            (item, part.span)
            for item, part in zip(items, node.items, strict=True)
            if not item.is_literal or np.any(item.amount)
        ]
        dimension = given[0][0].dimension if given else NUMBER
        for item, span in given:
            if item.dimension != dimension:
                self._mismatch("this vector mixes", dimension, item.dimension, span)
        literal = all(item.is_literal for item in items)
        stacked = np.stack(np.broadcast_arrays(*(item.amount for item in items)), axis=-1)
        vector = Value(stacked, dimension, is_vector=True, is_literal=literal)
        return self._finite(vector, node.span)

    @_quietly
    def _sum(self, node: s.Sum) -> Value:
        total = self.evaluate(node.first)
        for sign, part in node.rest:
            term = self.evaluate(part)
            if total.is_literal and term.dimension != NUMBER and (hint := difference(node)):
                self.findings.reject("TIS312", MESSAGE, node.span, hint=hint)
            self._same(
                "cannot add" if sign == "+" else "cannot subtract", total, term, part.span
            )
            if total.is_vector != term.is_vector:
                self.findings.reject(
                    "TIS312", "a vector and a number cannot be added", part.span
                )
            amount = total.amount + term.amount if sign == "+" else total.amount - term.amount
            total = Value(
                amount, total.dimension, total.is_vector, total.is_literal and term.is_literal
            )
        return self._finite(total, node.span)

    @_quietly
    def _product(self, node: s.Product) -> Value:
        total = self.evaluate(node.first)
        for sign, part in node.rest:
            term = self.evaluate(part)
            if term.is_vector and (sign == "/" or total.is_vector):
                what = "divide by" if sign == "/" else "multiply two"
                self.findings.reject("TIS312", f"cannot {what} vectors", part.span)
            if sign == "/" and self.is_known and not np.all(term.amount):
                message = f'division by zero: "{part.span.text}" is 0'
                self.findings.reject("TIS504", message, part.span)
            left, right = total.amount, term.amount
            if total.is_vector and right.ndim:
                right = right[..., None]
            if term.is_vector and left.ndim:
                left = left[..., None]
            total = Value(
                left * right if sign == "*" else left / right,
                total.dimension * term.dimension
                if sign == "*"
                else total.dimension / term.dimension,
                total.is_vector or term.is_vector,
                total.is_literal and term.is_literal,
            )
        return self._finite(total, node.span)

    @_quietly
    def _power(self, node: s.Power) -> Value:
        base, exponent = self.number(node.base), self.number(node.exponent)
        if exponent.dimension != NUMBER or exponent.amount.ndim:
            self.findings.reject(
                "TIS502", "an exponent must be a plain number", node.exponent.span
            )
        if self.is_known and exponent.amount < 0.0 and not np.all(base.amount):
            message = f'division by zero: "{node.base.span.text}" is 0'
            self.findings.reject("TIS504", message, node.base.span)
        amount = np.power(base.amount, exponent.amount)
        return self._finite(
            Value(amount, base.dimension ** float(exponent.amount), False, base.is_literal),
            node.span,
        )

    def angle(self, node: s.Expression, *, what: str) -> float:
        """Return an angle [rad]; a large one without a unit is probably meant in degrees."""
        value = self.number(node)
        self.expect(value, NUMBER, node.span, what=what)
        self._doubt_radians(value, node.span)
        return float(value.amount)

    def _doubt_radians(self, value: Value, span: Span) -> None:
        """Warn of a number without a unit that hardly anybody means in radians.

        That is more than a turn, and a whole number above half a turn: larger angles in radians
        are multiples of pi, or typed with decimals.
        """
        if not value.is_literal or value.is_many:
            return
        amount = float(value.amount)
        turns = abs(amount) / TURN
        if turns <= (0.5 if amount.is_integer() else 1.0):
            return
        hint: str = "write deg or rad after the number"
        if span.text.replace(".", "").isdigit():
            ways = f"{span.text} deg", f"{span.text} rad"
            hint = Hint("write {}; if radians are meant, {}".format(*ways), *map(Edit, ways))
        self.findings.add(
            "W504",
            f"without a unit, {amount:g} is an angle in radians: {turns:.3g} turns",
            span,
            hint=hint,
        )

    @_quietly
    def _call(self, node: s.Call) -> Value:
        name, function = node.function.text, node.function.key
        if function not in FUNCTIONS:
            return self.call(node)
        for argument in node.arguments:
            if argument.clauses:
                self.findings.reject(
                    "TIS312",
                    f"{name} takes plain numbers",
                    argument.span,
                    hint="for a limit at all times, write: expect force(NAME) < 10 N over run"
                    if function in _EXTREMES
                    else "",
                )
        values = [self.number(argument.value) for argument in node.arguments]
        if not values or (len(values) > 1 and function not in _EXTREMES):
            self.findings.reject("TIS312", f"{name} takes one number", node.span)
        spans = [argument.span for argument in node.arguments]
        return self._finite(self._value_of(function, values, spans), node.span)

    def _applied(self, node: s.Applied) -> Value:
        """Return the value of a function of the scene."""
        if node.value is None:
            self.findings.stop()
        given = tuple(self.evaluate(argument) for argument in node.arguments)
        inside = copy(self.outermost)
        inside.bound = tuple(replace(value, is_literal=False) for value in given)
        inside.is_known = self.is_known
        shown = ", ".join(str(value) for value in given if not value.is_many)
        called = f"called here with {shown}" if shown else "called here"
        with self.findings.noting(called, node.span):
            return inside.evaluate(node.value)

    def _value_of(self, function: str, values: Sequence[Value], spans: Sequence[Span]) -> Value:
        """Return a mathematical function of its arguments, whose places are ``spans``."""
        first = values[0]
        if function in _EXTREMES:
            for value, span in zip(values[1:], spans[1:], strict=True):
                self._same("cannot compare", first, value, span)
            amount = reduce(_EXTREMES[function], (value.amount for value in values))
            return Value(amount, first.dimension)
        if function == "sqrt":
            return Value(np.sqrt(first.amount), first.dimension**0.5)
        if function == "abs":
            return Value(np.abs(first.amount), first.dimension)
        self.expect(first, NUMBER, spans[0], what=f"the argument of {function}")
        if function in _OF_ANGLES:
            self._doubt_radians(first, spans[0])
        if function == "log" and self.is_known and not np.all(first.amount):
            self.findings.reject("TIS504", "the logarithm of 0 has no value", spans[0])
        return Value(_NUMERIC[function](first.amount))

    def _finite(self, value: Value, span: Span) -> Value:
        amount = value.amount
        if not self.is_known or (amount.ndim == 0 and abs(float(amount)) < LARGEST_NUMBER):
            return value
        if np.all(np.abs(amount) < LARGEST_NUMBER):
            return value
        if np.any(np.isnan(value.amount)):
            message, hint = "has no value", "check for roots and logarithms of negative numbers"
        else:
            message, hint = "is too large to compute with", "check the units and the exponents"
        self.findings.reject("TIS504", f'"{span.text}" {message}', span, hint=hint)

    def is_set(self, item: s.Item) -> bool:
        """Return whether an item depends on a number that is set from outside."""
        return False

    # --- conditions ---------------------------------------------------------------------------

    def decide(self, node: s.Expression) -> Truth:
        """Return the truth of a condition, shape () or (item,)."""
        match node:
            case s.And():
                return reduce(np.logical_and, map(self.decide, node.operands))
            case s.Or():
                return reduce(np.logical_or, map(self.decide, node.operands))
            case s.Not():
                return ~self.decide(node.operand)
            case s.Compare():
                left, right = self.number(node.left), self.number(node.right)
                self._same("cannot compare", left, right, node.right.span)
                return self._compared(left, node.sign, right)
            case s.Between():
                value, low, high = (
                    self.number(part) for part in (node.subject, node.low, node.high)
                )
                self._same("cannot compare", value, low, node.low.span)
                self._same("cannot compare", value, high, node.high.span)
                if self.is_known and np.any(low.amount > high.amount):
                    self.refuse_reversed(node.low.span, node.high.span)
                return self._compared(value, ">=", low) & self._compared(value, "<=", high)
            case _:
                return self.test(node)

    def _compared(self, left: Value, sign: str, right: Value) -> Truth:
        """Return the truth of a comparison, shape () or (item,).

        Numbers that are as near to each other as ``rounding`` are equal, so that of "<", "=="
        and ">" one alone is true of every item.
        """
        near = self.rounding(left, right)
        if near == 0.0:
            return np.asarray(_COMPARE[sign](left.amount, right.amount))
        if not left.is_many:  # the limit is widened, the same one whatever the sign
            left, sign, right = right, _EXCHANGED[sign], left
        value, limit = left.amount, right.amount
        if sign in ("==", "!="):
            is_equal = (limit - near <= value) & (value <= limit + near)
            return np.asarray(is_equal if sign == "==" else ~is_equal)
        widened = limit + near if sign in ("<=", ">") else limit - near
        return np.asarray(_COMPARE[sign](value, widened))

    def rounding(self, left: Value, right: Value) -> float:
        """Return the difference of two sides of a comparison that rounding alone may cause.

        It has their unit, and is 0 of numbers that are written or measured.
        """
        return 0.0

    def refuse_reversed(self, low: Span, high: Span) -> NoReturn:
        """Reject limits whose lower one is above the upper one."""
        limits = f"{high.text} and {low.text}"
        hint = Hint(f'write "between {limits}"', Edit(limits, low.to(high)))
        message = "the lower limit is above the upper limit"
        self.findings.reject("TIS308", message, low, hint=hint)

    # --- dimensions ---------------------------------------------------------------------------

    def expect(self, value: Value, dimension: Dimension, span: Span, *, what: str) -> None:
        """Reject a value of another dimension, with a hint."""
        if value.dimension == dimension:
            return
        wanted = describe(dimension)
        if value.is_literal:
            self.findings.reject(
                "TIS501",
                f"{what} must be {wanted}, but {span.text} has no unit",
                span,
                hint=proposal(f"{span.text} {_unit_for(dimension, span)}"),
            )
        self.findings.reject(
            "TIS502",
            f"{what} must be {wanted}, but {span.text} is {describe(value.dimension)}",
            span,
            hint=_with_unit_of(dimension, span),
        )

    def _same(self, problem: str, left: Value, right: Value, span: Span) -> None:
        if left.dimension != right.dimension:
            self._mismatch(
                problem, left.dimension, right.dimension, span, literal=right.is_literal
            )

    def _mismatch(
        self,
        problem: str,
        left: Dimension,
        right: Dimension,
        span: Span,
        *,
        literal: bool = False,
    ) -> None:
        unit = _unit_for(left, span)
        hint = (
            proposal(f"{span.text} {unit}")
            if literal
            else f"{describe(left)} is needed here, such as {f'1 {unit}'.rstrip()}"
        )
        code = "TIS501" if literal else "TIS502"
        self.findings.reject(
            code, f"{problem} {describe(left)} and {describe(right)}", span, hint=hint
        )


def _has_unit(node: s.Expression) -> bool:
    """Return whether an expression has a unit, such as that of an angle, outside of calls."""
    match node:
        case s.Quantity():
            return True
        case s.Signed(operand=part) | s.Power(base=part):
            return _has_unit(part)
        case s.Sum(first=first, rest=rest) | s.Product(first=first, rest=rest):
            return _has_unit(first) or any(_has_unit(part) for _, part in rest)
        case _:
            return False


class InnerScope(Scope):
    """A scope that adds names of its own to those of another one.

    Args:
        constants: The other scope: params and lets.
        findings: Its own; by default those of the other scope.
    """

    def __init__(self, constants: Scope, findings: Findings | None = None):
        super().__init__(constants.findings if findings is None else findings)
        self.constants = constants

    @property
    def outermost(self) -> Scope:
        return self.constants.outermost


def _refuse_unit(name: s.Name, findings: Findings) -> None:
    """Reject ``4*mm`` and ``1.06 g/cc``, where a unit was read as a name."""
    text, end = name.span.source.text, name.span.end
    begin = text.rfind("\n", 0, end) + 1
    if (power := re.compile(_POWER).search(text, begin, end)) is not None:
        unit = re.sub(r"([^\W\d])([23])(?![\w^])", r"\1^\2", power[2])
        if _is_unit(unit):
            place = Span(name.span.source, power.start(), end)
            amount = f"{power[1]} {unit}"
            hint = Hint(f'write "{amount}"', Edit(amount, place))
            findings.reject("TIS104", 'a power of a unit is written with "^"', place, hint=hint)
    before = re.compile(_MULTIPLIED).search(text, begin, end)
    if before is None or (amount := converted(before[1], before[3])) is None:
        return
    place = Span(name.span.source, before.start(), end)
    if _is_unit(before[3]):
        amount = f"{before[1]} {before[3]}"
    elif before[2]:
        return
    message = f'"{name.text}" is not a unit of the language, nor a number'
    if _is_unit(name.text):
        message = "a unit follows its number without a sign"
    hint = Hint(f'write "{amount}"', Edit(amount, place))
    findings.reject("TIS104", message, place, hint=hint)


def _unit_for(dimension: Dimension, span: Span) -> str:
    """Return the unit that a number lacks: that of the other end of its range, if any."""
    other = re.compile(_OTHER_END).match(span.source.text, span.end)
    if other and _is_unit(other[1]) and parse_unit(other[1]).dimension == dimension:
        return other[1]
    return suggested_unit(dimension)


def _with_unit_of(dimension: Dimension, span: Span) -> Hint:
    """Return a hint to write an amount in a unit of a dimension.

    There is an edit only where the prefix can stay, so that no number becomes another.
    """
    unit = suggested_unit(dimension)
    amount = re.compile(_AMOUNT).match(span.text)
    number = amount[0] if amount else "1"
    wanted = DIMENSION_NAMES.get(dimension, ("a number",))[0]
    wanted = wanted if wanted.startswith(("a ", "an ")) else f"a {wanted}"
    hint = f"write {wanted}, such as {number} {unit}".rstrip()
    if not unit:
        hint = "write a number without a unit"
        if span.text.startswith("(") and ")" in span.text:  # of a direction, any size is right
            vector = span.text[: span.text.rindex(")") + 1]
            return Hint(f'write "{vector}"', Edit(vector, span))
    if amount is None:
        return Hint(hint)
    written = span.text[amount.end() :].strip()
    if dimension == ACCELERATION and written == "g":
        text = re.sub(
            NUMBER_PATTERN, lambda one: f"{float(one[0]) * STANDARD_GRAVITY:.6g}", amount[0]
        )
        text = f"{text} {unit}"
        return Hint(f'1 g is {STANDARD_GRAVITY} {unit}: write "{text}"', Edit(text, span))
    if not _is_unit(written) or (kept := keeping_prefix(written, dimension)) is None:
        return Hint(hint)
    if dimension in (LENGTH, VOLUME, FREQUENCY) and kept != unit:
        return Hint(hint)  # nobody means metres or millihertz
    hint = f"write {wanted}, such as {number} {kept}" if unit else hint
    return Hint(hint, Edit(f"{amount[0]} {kept}".rstrip(), span))


def _unquoted(name: s.Name) -> list[Edit]:
    """Return the edit that takes the quotes off a number with its unit, if it is one."""
    text = name.quoted or ""
    number = re.fullmatch(r"-?[0-9.]+(?:[eE][+-]?[0-9]+)? *(\S*)", text)
    return [Edit(text)] if number and (not number[1] or _is_unit(number[1])) else []


def _is_unit(text: str) -> bool:
    try:
        parse_unit(text)
    except UnitError:
        return False
    return True


def _pointed(text: str, more: int) -> list[Edit]:
    """Return the edit that writes points for as many commas without a blank after them."""
    pointed, count = re.subn(r"(?<=[0-9]),(?=[0-9])", ".", text)
    return [Edit(pointed)] if count == more else []
