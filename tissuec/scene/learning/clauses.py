"""Sentences of a learn block, as the parts of their classes, and how they are read."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, TypeVar, cast

from tissuec.core.hints import Edit, Hint
from tissuec.core.units import (
    LENGTH,
    NUMBER,
    TIME,
    Dimension,
    UnitError,
    describe,
    parse_unit,
    si_unit,
)
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.learning.entries import SENTENCES
from tissuec.scene.reading.clauses import ClauseReader
from tissuec.scene.reading.expressions import Scope
from tissuec.script.fit_problem import DataColumn
from tissuec.script.forms import VerbSentence, form_of
from tissuec.script.parts import ClausePart, FlagPart, NumberClause, Part, direction

T = TypeVar("T", bound=VerbSentence)

COLUMN, COLUMNS = "column", "columns"
_FACTOR = re.compile(r"(.+?)\s*([*/·])\s*(\d+\.?\d*)\s*")
#: The dimension of what the sentence is about, which its reader is given.
OWN: Mapping[str, Dimension] = MappingProxyType({})


class NamesClause(ClausePart, frozen=True):
    """A name, and the name of what has it behind the same word: ``of scar of vessel``."""

    may_repeat = True


class NameClause(ClausePart, frozen=True):
    """A name that code of its own looks up."""


class ValueClause(ClausePart, frozen=True):
    """An expression that code of its own evaluates."""


class ColumnsClause(ClausePart, frozen=True):
    """``column "force_N"`` or ``columns "x y z"``, with a unit after ``in``.

    Attributes:
        dimension: Of what the columns contain.
    """

    dimension: Dimension | Mapping[str, Dimension]


Along = Annotated[Floats | None, direction("along")]  # unit vector, shape (3,)
Weight = Annotated[
    float | None, NumberClause("weighing", NUMBER, "positive", what="weight of a fit")
]


class TimeWords(VerbSentence, frozen=True):
    """The column of times."""

    columns: Annotated[
        tuple[DataColumn, ...], ColumnsClause("using", TIME, what="column of the time")
    ]


class DisplacementWords(VerbSentence, frozen=True):
    """The column of displacements of a set."""

    moved: Annotated[s.Name, NameClause("of", what="displaced set")]
    along: Along
    columns: Annotated[
        tuple[DataColumn, ...],
        ColumnsClause("using", LENGTH, what="column of the displacement"),
    ]


class ColumnOptions(VerbSentence, frozen=True):
    """What is known of measured values.

    Attributes:
        every: Least time between values [s].
        noise: Standard deviation, in the SI unit of the values.
    """

    every: Annotated[
        float | None, NumberClause("every", TIME, "positive", what="time between values")
    ]
    noise: Annotated[
        float | None, NumberClause("to", OWN, "positive", what="standard deviation")
    ]
    weight: Weight
    free_zero: Annotated[bool, FlagPart("with free zero")]


class FitWords(ColumnOptions, frozen=True):
    """A fit of a measure."""

    along: Along
    columns: Annotated[tuple[DataColumn, ...] | None, ColumnsClause("using", OWN)]


class AgainstWords(ColumnOptions, frozen=True):
    """The column of the fit on the line above."""

    columns: Annotated[tuple[DataColumn, ...], ColumnsClause("", OWN)]


class FitTissueWords(VerbSentence, frozen=True):
    """A fit of a number of tissues."""

    tissues: Annotated[s.Expression | None, ValueClause("of")]
    weight: Weight


class OwnerWords(VerbSentence, frozen=True):
    """What words or weights of rules belong to, or rules that may be revised."""

    owners: Annotated[s.Expression | None, ValueClause("of")]


class AdjustWords(VerbSentence, frozen=True):
    """To what a number belongs that is adjusted, and by what it is divided."""

    owners: Annotated[tuple[s.Name, ...] | None, NamesClause("of")]
    per: Annotated[s.Name | None, NameClause("per")]


class LimitWords(VerbSentence, frozen=True):
    """Limits of what is adjusted, and what is expected of it, in SI units."""

    along: Along
    low: Annotated[float | None, NumberClause("from", OWN, what="lower limit")]
    high: Annotated[float | None, NumberClause("to", OWN, what="upper limit")]
    around: Annotated[s.Expression | None, ValueClause("around", what="expected value")]
    by: Annotated[
        float | None,
        NumberClause("by", NUMBER, "positive", what="expected relative deviation"),
    ]


class LearnReader(ClauseReader):
    """Reads one sentence of a learn block.

    Args:
        entry: One of ``SENTENCES``.
        item: The sentence.
        scope: Names and findings of the scene.
        kinds: Classes of what it says, each with some of its parts.

    Attributes:
        own: Dimension of what the sentence is about.
        about: That, in messages.
    """

    lead = "for example"

    def __init__(
        self, entry: str, item: s.Assign | s.Sentence, scope: Scope, *kinds: type[VerbSentence]
    ):
        forms = tuple(map(form_of, kinds))
        super().__init__(item, entry, forms, scope, texts=SENTENCES[entry].forms)
        self.findings = scope.findings
        self.own, self.about = NUMBER, ""

    def get(self, kind: type[T], *, is_last: bool = True) -> T:
        """Return the content of the sentence in the parts of a class.

        Args:
            kind: The class, one of ``kinds``.
            is_last: Whether the sentence has no clauses that are still to be read.
        """
        said = self.read_form(form_of(kind))
        if is_last:
            self.finish()
        return cast(T, said)

    def called(self, word: str) -> str:
        part = self.form.of_word(word)
        return f"the {part.what}" if part is not None else super().called(word)

    def dimension_of(self, word: str) -> Dimension:
        part = self.form.of_word(word)
        return (
            self.own if getattr(part, "dimension", None) is OWN else super().dimension_of(word)
        )

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        match part:
            case NameClause(word=word):
                return self.name_in(word)
            case NamesClause(word=word):
                return (self.name_in(word), *self.repeated)
            case ValueClause(word=word):
                return self.clauses[word].value
            case ColumnsClause():
                return self._columns(part)
            case _:
                return super().read_other(part, is_optional=is_optional)

    # --- columns ------------------------------------------------------------------------------

    def _columns(self, part: ColumnsClause) -> tuple[DataColumn, ...]:
        """Return the columns that are named, with the unit behind ``in``."""
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
        """Return the number behind ``in``, 1 without one, and its unit in SI units."""
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
