"""Clauses of the sentences of a learn block: each word once, columns with their units."""

import re
from collections.abc import Sequence
from typing import NoReturn

from tissuec.core.hints import Edit, Hint, one_left
from tissuec.core.source import Span
from tissuec.core.units import (
    NUMBER,
    Dimension,
    UnitError,
    describe,
    parse_unit,
    si_unit,
)
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.expressions import Scope
from tissuec.scene.learn_entries import SENTENCES
from tissuec.scene.values import unit_vector
from tissuec.script.fit_problem import DataColumn

COLUMN, COLUMNS = "column", "columns"
_FACTOR = re.compile(r"(.+?)\s*([*/·])\s*(\d+\.?\d*)\s*")


class Clauses:
    """The clauses of one sentence, by their words.

    Args:
        entry: One of ``SENTENCES``, whose first form is the example in hints.
        allowed: Words that can stand; those twice in it can stand twice.
        where: The sentence.

    Shared arguments:
        word: Word of the clause.
        code: Code of the diagnostic.
        message: What is wrong.
        span: Place in the text; the whole sentence if None.
        dimension: Dimension of the number.
        what: Name of the number in messages.

    Raises:
        Rejected: Another word stands there, or one too often.
    """

    def __init__(
        self,
        entry: str,
        clauses: Sequence[s.Clause],
        scope: Scope,
        *,
        allowed: Sequence[str],
        where: Span,
    ):
        self.entry, self.scope, self.where = entry, scope, where
        self.findings = scope.findings
        self.all = tuple(clauses)
        self.example = f"for example: {SENTENCES[entry].forms[0]}"
        for place, clause in enumerate(clauses):
            earlier = [one for one in clauses[:place] if one.word == clause.word]
            if clause.word not in allowed:
                self.reject("TIS303", f'unexpected "{clause.word}"', clause.span)
            if len(earlier) >= allowed.count(clause.word):
                first, what = earlier[0].span, f'"{clause.word}"'
                self.findings.refuse_second(
                    what, clause.span, first, hint=one_left(clause.span, first)
                )

    def reject(self, code: str, message: str, span: Span | None = None) -> NoReturn:
        """Reject the sentence with an example of its form as the hint."""
        self.findings.reject(code, message, span or self.where, hint=self.example)

    def get(self, word: str) -> s.Clause | None:
        """Return the first clause with a word, if there is one."""
        return next(iter(self.named(word)), None)

    def named(self, word: str) -> list[s.Clause]:
        """Return all clauses with a word."""
        return [clause for clause in self.all if clause.word == word]

    def names(self, word: str) -> list[s.Name]:
        """Return the names behind a word, or reject what is none."""
        found: list[s.Name] = []
        for clause in self.named(word):
            if not isinstance(clause.value, s.Name):
                self.reject("TIS312", f'"{word}" needs a name', clause.value.span)
            found.append(clause.value)
        return found

    def number(self, word: str, dimension: Dimension, *, what: str) -> float | None:
        """Return the number of a clause; None without the clause."""
        clause = self.get(word)
        if clause is None:
            return None
        value = self.scope.number(clause.value)
        self.scope.expect(value, dimension, clause.value.span, what=what)
        return float(value.amount)

    def above_zero(self, word: str, dimension: Dimension, *, what: str) -> float | None:
        """Return the number of a clause, which must be positive; None without the clause."""
        number, clause = self.number(word, dimension, what=what), self.get(word)
        if number is not None and clause is not None and number <= 0.0:
            self.findings.reject(
                "TIS308", f"{what} must be above 0, not {clause.value.span.one_line}",
                clause.value.span,
            )  # fmt: skip
        return number

    def direction(self, word: str = "along") -> Floats | None:
        """Return the unit vector behind a word, shape (3,); None without it."""
        clause = self.get(word)
        if clause is None:
            return None
        value = self.scope.evaluate(clause.value)
        found = None
        if value.is_vector and value.dimension == NUMBER:
            found = unit_vector(value.amount)
        if found is None:
            self.findings.reject(
                "TIS312", f'"{word}" needs a direction', clause.value.span,
                hint=Hint(f"for example: {word} (0, 0, 1)", Edit("(0, 0, 1)")),
            )  # fmt: skip
        return found

    # --- columns ------------------------------------------------------------------------------

    def columns(
        self, names: Sequence[s.Name], dimension: Dimension, *, what: str
    ) -> tuple[DataColumn, ...]:
        """Return the columns that were named, with the unit behind ``in``.

        Args:
            names: ``column "force_N"``, or ``columns "x y z"``; none, or one.
            dimension: Of what they hold.
            what: That, in messages.
        """
        if not names:
            if (unit := self.get("in")) is not None:
                self.reject("TIS304", "a unit without a column", unit.span)
            return ()
        name = names[0]
        kind = s.key_of(name.words)
        if kind not in (COLUMN, COLUMNS) or not (name.quoted or "").strip():
            self.reject("TIS312", "wrong form of a column", name.span)
        factor, unit = self._unit(dimension, what)
        texts = [name.quoted or ""]
        if kind == COLUMNS:
            texts = texts[0].split()
        for text in texts:
            if texts.count(text) > 1:
                self.findings.reject("TIS307", f'duplicate column "{text}"', name.span)
        # What comes before x, y and z is the number of a node.
        first_id = len(texts) == 4
        return tuple(
            DataColumn(text, 1.0, name.span)
            if first_id and not place
            else DataColumn(text, factor * unit, name.span, factor)
            for place, text in enumerate(texts)
        )

    def _unit(self, dimension: Dimension, what: str) -> tuple[float, float]:
        """Return the number behind ``in``, 1 without one, and its unit in SI units."""
        clause = self.get("in")
        if clause is None:
            if dimension == NUMBER:
                return 1.0, 1.0
            self.reject("TIS304", "the unit of the column is missing")
        span = clause.value.span
        if isinstance(clause.value, s.Quantity):  # in 1 %, for no unit stands alone there
            value = self.scope.number(clause.value)
            self.scope.expect(value, dimension, span, what=what)
            return clause.value.value, float(value.amount) / (clause.value.value or 1.0)
        try:
            unit = parse_unit(span.text)
        except UnitError as error:
            hint = _factor_before(span.text) or (
                "write a unit, or a number and a unit: in "
                f"{f'0.97 {si_unit(dimension)}' if dimension != NUMBER else '0.97'}"
            )
            self.findings.reject("TIS104", str(error), span, hint=hint)
        if unit.dimension != dimension:
            wanted, found = describe(dimension), describe(unit.dimension)
            self.findings.reject("TIS502", f"{what} is {wanted}; {span.text} is {found}", span)
        return 1.0, unit.factor


def _factor_before(text: str) -> Hint | None:
    """Return a unit with the factor that stands behind it in front: "mm/2" is 0.5 mm."""
    found = _FACTOR.fullmatch(text)
    number = float(found[3]) if found else 0.0
    if found is None or not number:
        return None
    try:
        parse_unit(found[1])
    except UnitError:
        return None
    written = f"{1.0 / number if found[2] == '/' else number:.6g} {found[1]}"
    return Hint(f"write a factor before the unit: in {written}", Edit(written))
