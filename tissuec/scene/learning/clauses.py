"""How the sentences of a learn block are read: columns, and numbers of its own dimension."""

import re
from typing import Any, cast

from tissuec.core.hints import Edit, Hint
from tissuec.core.units import (
    NUMBER,
    Dimension,
    UnitError,
    describe,
    parse_unit,
    si_unit,
)
from tissuec.lang import syntax as s
from tissuec.scene.learning.sentences import SENTENCES
from tissuec.scene.reading.block_sentences import SentenceReader
from tissuec.scene.reading.clauses import Written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.fit_problem import DataColumn
from tissuec.script.parts import OWN, ColumnsClause, Part

COLUMN, COLUMNS = "column", "columns"
_FACTOR = re.compile(r"(.+?)\s*([*/·])\s*(\d+\.?\d*)\s*")


class LearnReader(SentenceReader):
    """Reads one sentence of a learn block.

    Args:
        entry: One of ``SENTENCES``.
        item: The sentence.
        scope: Names and findings of the scene.

    Attributes:
        own: Dimension of what the sentence is about.
        about: That, in messages.
    """

    def __init__(self, entry: str, item: Written, scope: Scope):
        super().__init__(entry, SENTENCES[entry], item, scope)
        self.findings = scope.findings
        self.own, self.about = NUMBER, ""

    def dimension_of(self, word: str) -> Dimension:
        part = self.form.of_word(word)
        return (
            self.own if getattr(part, "dimension", None) is OWN else super().dimension_of(word)
        )

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        if isinstance(part, ColumnsClause):
            return self._columns(part)
        return super().read_other(part, is_optional=is_optional)

    # --- columns ------------------------------------------------------------------------------

    def _columns(self, part: ColumnsClause) -> tuple[DataColumn, ...]:
        """Return the columns that are named, with the unit after ``in``."""
        self.asked.add("in")
        name = (
            self.name_in(part.word)
            if part.word
            else s.Name(COLUMN, self.object.quoted, self.object.span)
        )
        kind = s.key_of(name.words)
        if kind not in (COLUMN, COLUMNS) or not (name.quoted or "").strip():
            self.reject_at(name.span, "TIS312", "wrong form of a column")
        dimension = self.own if part.dimension is OWN else cast(Dimension, part.dimension)
        factor, unit = self._unit(dimension)
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

    def _unit(self, dimension: Dimension) -> tuple[float, float]:
        """Return the number after ``in``, 1 without one, and its unit in SI units."""
        clause, what = self.clauses.get("in"), self.about or "the column"
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
    """Return a unit with the factor that follows it in front: "mm/2" is 0.5 mm."""
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
