"""Grammar rules to syntax nodes: one method for each rule, called when the rule is complete.

Lark calls a method with the list of what the rule is made of: nodes, and those tokens that the
grammar refers to by name.
"""

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Source, Span
from tissuec.core.structs import replace
from tissuec.core.units import canonical_unit, parse_unit
from tissuec.lang import syntax as s
from tissuec.lang.double_signs import signs_meet, two_signs
from tissuec.lang.rows import Rows, canonical_rows
from tissuec.lang.token_names import shown
from tissuec.lang.tokens import Token, number_and_unit
from tissuec.lang.words import STEPS


@lru_cache(maxsize=4096)
def _is_reckonable(unit: str) -> bool:
    """Return whether the size of a unit is a number: ``m^-99999`` has none."""
    try:
        return 0.0 < parse_unit(unit).factor < math.inf
    except (ValueError, OverflowError, ZeroDivisionError):
        return False


class Builder:
    """Builds the nodes of one text at a time."""

    source: Source
    problems: list[Diagnostic]
    unknown: set[int]

    def begin(self, source: Source, *, unknown: Iterable[int] = ()) -> None:
        """Make ready for a statement, and forget the last one.

        Args:
            unknown: Where numbers and vectors end whose units were taken out of the statement.
        """
        self.source = source
        self.problems = []
        self.unknown = set(unknown)

    # --- places and problems ------------------------------------------------------------------

    def _span(self, first: Any, last: Any) -> Span:
        """Return the span from one node or token to another."""
        start = first.span.start if hasattr(first, "span") else first.start
        end = last.span.end if hasattr(last, "span") else last.stop
        return Span(self.source, start, end)

    def _report(self, code: str, message: str, token: Token, hint: str) -> None:
        span = Span(self.source, token.start, token.stop)
        self.problems.append(Diagnostic(code, message, span, hint))

    def _unit(self, unit: str, token: Token) -> str:
        """Return the unit that ends with a token; an empty text if it is wrong."""
        if token.stop in self.unknown:
            self.unknown.discard(token.stop)
            return ""
        if _is_reckonable(unit):
            return unit
        message = f"{shown(unit)} is not a usable unit: it is too large or too small"
        self._report("TIS104", message, token, "use small whole numbers as exponents of units")
        return ""

    # --- numbers ------------------------------------------------------------------------------

    def _value(self, text: str, token: Token) -> float:
        value = float(text)
        if math.isinf(value):
            shown = text if len(text) <= 20 else f"{text[:17]}..."
            hint = "the largest number is about 1.8e308"
            self._report("TIS119", f'"{shown}" is too large', token, hint)
        return value

    def number(self, children: list[Token]) -> s.Number | s.Quantity:
        """Return a number, or a quantity without a unit if its unit is unknown."""
        (token,) = children
        value, span = self._value(token.text, token), self._span(token, token)
        if token.stop in self.unknown or math.isinf(value):
            self.unknown.discard(token.stop)
            return s.Quantity(value, "", span)
        return s.Number(value, span)

    def quantity(self, children: list[Token]) -> s.Quantity:
        """Return a number with its unit."""
        (token,) = children
        number, unit = number_and_unit(token.text)
        unit = self._unit(canonical_unit(unit), token)
        value = self._value(number, token)
        unit = "" if math.isinf(value) else unit
        return s.Quantity(value, unit, self._span(token, token))

    def steps(self, children: list[Token]) -> s.Quantity:
        """Return a number of steps."""
        (token,) = children
        number, _ = number_and_unit(token.text)
        return s.Quantity(self._value(number, token), STEPS, self._span(token, token))

    # --- expressions --------------------------------------------------------------------------

    def name(self, children: list[Any]) -> s.Name:
        """Return a name of one or several words, or in quotes."""
        quoted = None
        if children[-1] is None:
            children.pop()
        elif children[-1].type == "STRING":
            quoted = children[-1].text[1:-1]
        words = children if quoted is None else children[:-1]
        return s.Name(
            " ".join(word.text for word in words), quoted, self._span(children[0], children[-1])
        )

    def listed(self, children: list[Any]) -> s.Name:
        """Return the words before a union, with the names in it."""
        name, _open, *names, _close = children
        return replace(name, span=self._span(name, children[-1]), listed=tuple(names))

    def listing(self, children: list[Any]) -> s.Listing:
        """Return a list of expressions."""
        return s.Listing(tuple(children[1:-1]), self._span(children[0], children[-1]))

    def vector(self, children: list[Any]) -> s.Vector:
        """Return a vector with its unit, if it has one."""
        first, *items, last = children
        unit = None
        if last.type == "RPAR_UNIT" or last.stop in self.unknown:
            unit = self._unit(canonical_unit(last.text[1:].strip()), last)
        return s.Vector(tuple(items), unit, self._span(first, last))

    def call(self, children: list[Any]) -> s.Call:
        """Return the call of a function."""
        function, *arguments, last = children
        return s.Call(function, tuple(arguments), self._span(function, last))

    def argument(self, children: list[Any]) -> s.Argument:
        """Return an argument of a call, with its clauses."""
        value, *clauses = children
        return s.Argument(value, tuple(clauses), self._span(value, children[-1]))

    def group(self, children: list[Any]) -> s.Expression:
        """Return the expression in parentheses."""
        first, inner, last = children
        return replace(inner, span=self._span(first, last))

    def sign(self, children: list[Any]) -> s.Expression:
        """Return an expression with its sign."""
        *signs, operand = children
        span = self._span(signs[0], operand)
        if len(signs) > 1:
            self.problems.append(two_signs(span))
        if sum(sign.type == "MINUS" for sign in signs) % 2:
            return s.Signed(operand, span)
        return replace(operand, span=span)

    def power(self, children: list[Any]) -> s.Power:
        """Return a power."""
        base, exponent = children
        return s.Power(base, exponent, self._span(base, exponent))

    def product(self, children: list[Any]) -> s.Product:
        """Return a product or quotient."""
        return s.Product(*self._chain(children), self._span(children[0], children[-1]))

    def sum(self, children: list[Any]) -> s.Sum:
        """Return a sum or difference."""
        for left, right in zip(children[::2], children[2::2], strict=False):
            problem = signs_meet(left.span, right.span)
            if problem is not None:
                self.problems.append(problem)
        return s.Sum(*self._chain(children), self._span(children[0], children[-1]))

    def _chain(self, children: list[Any]) -> tuple[Any, Any]:
        signs = (token.text for token in children[1::2])
        return children[0], tuple(zip(signs, children[2::2], strict=True))

    # --- conditions ---------------------------------------------------------------------------

    def compare(self, children: list[Any]) -> s.Compare:
        """Return a comparison."""
        left, sign, right = children
        return s.Compare(left, sign.text, right, self._span(left, right))

    def is_test(self, children: list[Any]) -> s.Is:
        """Return a test with ``is``."""
        subject, phrase = children
        return s.Is(subject, phrase, self._span(subject, phrase))

    def inside(self, children: list[Any]) -> s.Between:
        """Return a test with ``between``."""
        subject, low, high = children
        return s.Between(subject, low, high, self._span(subject, high))

    def near(self, children: list[Any]) -> s.Within:
        """Return a test with ``within`` of a subject."""
        subject, radius, centre = children
        return s.Within(subject, radius, centre, self._span(subject, centre))

    def ball(self, children: list[Any]) -> s.Within:
        """Return a test with ``within`` of the node itself."""
        within, radius, centre = children
        return s.Within(None, radius, centre, self._span(within, centre))

    def negated(self, children: list[Any]) -> s.Expression:
        """Return a condition after any number of ``not``."""
        *nots, operand = children
        span = self._span(nots[0], operand)
        return s.Not(operand, span) if len(nots) % 2 else replace(operand, span=span)

    def conjunction(self, children: list[Any]) -> s.And:
        """Return conditions joined by ``and``."""
        return s.And(tuple(children), self._span(children[0], children[-1]))

    def disjunction(self, children: list[Any]) -> s.Or:
        """Return conditions joined by ``or``."""
        return s.Or(tuple(children), self._span(children[0], children[-1]))

    def phrase(self, children: list[Any]) -> s.Predicate:
        """Return a phrase: a word, ``not`` a word, or ``between`` words."""
        span = self._span(children[0], children[-1])
        if isinstance(children[0], Token) and children[0].type == "ON":
            # No entry takes it: the reader of the entry says what it takes.
            return s.Predicate("word", (s.Name("on", None, span),), span)
        if len(children) == 1:
            return s.Predicate("word", tuple(children), span)
        return s.Predicate(
            "not" if len(children) == 2 else "between", tuple(children[1:]), span
        )

    # --- sentences ----------------------------------------------------------------------------

    def clause(self, children: list[Any]) -> s.Clause:
        """Return a word with its value."""
        word, value = children
        return s.Clause(word.text, value, self._span(word, value))

    def bounds(self, children: list[Any]) -> s.Bounds:
        """Return the two ends of a range."""
        between, low, high = children
        return s.Bounds(low, high, self._span(between, high))

    def assign(self, children: list[Any]) -> s.Assign:
        """Return an assignment with its bounds and clauses."""
        keyword, name, value, bounds, *clauses = children
        span = self._span(keyword or name, clauses[-1] if clauses else bounds or value)
        word = keyword.text if keyword else ""
        return s.Assign(word, name, value, bounds, tuple(clauses), span)

    def definition(self, children: list[Any]) -> s.Definition:
        """Return the definition of a function of numbers."""
        let, name, _, *parameters, _, value = children
        return s.Definition(name, tuple(parameters), value, self._span(let, value))

    def recording(self, children: list[Any]) -> s.RecordedCall:
        """Return the recorded measure, with its clauses."""
        clauses = tuple(one for one in children if isinstance(one, s.Clause))
        name, *rest = children[: len(children) - len(clauses)]
        arguments = tuple(one for one in rest if isinstance(one, s.Argument))
        call = s.Call(name, arguments, self._span(name, rest[-1]))
        return s.RecordedCall(call, clauses, self._span(name, children[-1]))

    def function(self, children: list[Any]) -> s.Function:
        """Return a formula of quantities."""
        name, word, first, second, value, *clauses = children
        arguments = [s.Clause(word.text, first, self._span(word, first))]
        if second is not None:
            arguments.append(s.Clause("and", second, second.span))
        span = self._span(name, clauses[-1] if clauses else value)
        return s.Function(name, tuple(arguments), value, tuple(clauses), span)

    def sentence(self, children: list[Any]) -> s.Sentence:
        """Return a sentence."""
        name, phrase, *clauses = children
        last = clauses[-1] if clauses else phrase or name
        return s.Sentence(name, phrase, tuple(clauses), self._span(name, last))

    def block(self, children: list[Any]) -> s.Block:
        """Return the head of a block, whose items are still to come."""
        name, phrase, *clauses = children
        head = self._span(name, clauses[-1] if clauses else phrase or name)
        return s.Block(name, phrase, tuple(clauses), (), head, head)

    def table(self, children: list[Any]) -> s.Table:
        """Return the head of a table that begins with ``table``."""
        first, name, *clauses = children
        return self._table(first, name, clauses)

    def table_of(self, children: list[Any]) -> s.Table:
        """Return the head of a table that begins with the name of its kind."""
        name, _table, *clauses = children
        return self._table(name, name, clauses)

    def _table(self, first: Any, name: s.Name, clauses: list[s.Clause]) -> s.Table:
        span = self._span(first, clauses[-1] if clauses else name)
        return s.Table(name, tuple(clauses), "", span, span)

    def rule(self, children: list[Any]) -> s.Rule:
        """Return a fuzzy rule."""
        first, condition, *rest = children
        conclusions = tuple(part for part in rest if isinstance(part, s.Conclusion))
        clauses = tuple(rest[len(conclusions) :])
        return s.Rule(condition, conclusions, clauses, self._span(first, children[-1]))

    def conclusion(self, children: list[Any]) -> s.Conclusion:
        """Return a conclusion of a rule."""
        quantity, phrase = children
        return s.Conclusion(quantity, phrase, self._span(quantity, phrase))

    def trigger(self, children: list[Any]) -> list[Any]:
        """Return the words and the condition of a trigger."""
        return children

    def timed(self, children: list[Any]) -> s.Timed:
        """Return orders with the times or the trigger at which they happen."""
        body = () if isinstance(children[-1], Token) else (children.pop(),)
        *when, colon = children
        triggered = isinstance(when[0], list)
        first = when[0][0] if triggered else when[0]
        head = self._span(first, colon)
        times = () if triggered else tuple(when)
        trigger = when[0][1] if triggered else None
        span = self._span(first, body[0] if body else colon)
        return s.Timed(times, trigger, body, span, head)

    def expect(self, children: list[Any]) -> s.Expect:
        """Return an expectation."""
        first, condition, *clauses = children
        return s.Expect(condition, tuple(clauses), self._span(first, children[-1]))


# --- contents of a block ----------------------------------------------------------------------


def with_items(head: Any, items: tuple[s.Item, ...], close: int) -> s.Item:
    """Return a block, or the orders of a time, with its items.

    Args:
        head: The node of the head.
        items: The items of the block.
        close: Offset after its closing brace.
    """
    span = Span(head.span.source, head.span.start, close)
    if isinstance(head, s.Timed):
        body = tuple(with_items(inner, items, close) for inner in head.body) or items
        return replace(head, body=body, span=span)
    return replace(head, items=items, span=span)


def with_rows(head: s.Table, rows: Rows, close: int) -> s.Table:
    """Return a table with its rows.

    Args:
        head: The node of the head.
        close: Offset after its closing brace.
    """
    place = Span(head.span.source, rows.start, rows.end)
    span = Span(head.span.source, head.span.start, close)
    return replace(head, rows=canonical_rows(place.text), span=span, rows_span=place)
