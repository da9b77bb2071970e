"""The factors of a study: ``vary`` lines, and the columns of a file of rows."""

import math
import re
from collections.abc import Sequence
from typing import NoReturn

from tissuec.core.files import read_bytes
from tissuec.core.hints import proposal
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.text_tables.dialect import as_number, decoded
from tissuec.core.text_tables.table import TextTable
from tissuec.core.units import (
    NUMBER,
    Dimension,
    UnitError,
    parse_unit,
    si_unit,
    suggested_unit,
)
from tissuec.lang import syntax as s
from tissuec.lang.words import STEPS
from tissuec.scene.learning.data import DataReader
from tissuec.scene.overrides.entries import read_override, written_entry
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceReader
from tissuec.scene.reading.findings import Findings, Rejected
from tissuec.scene.reading.values import Value
from tissuec.scene.settings import SimulateEntries
from tissuec.scene.study.entries import DISTRIBUTIONS, ROWS, SENTENCES, VARY, VariedRange
from tissuec.scene.study.model import Cell, Distribution, Factor, Levels, plain

MOST_VALUES = 1_000_000
LARGEST_ROWS = 100_000_000  # [bytes]
DIGITS = 14  # of the values of a range, so that 3 steps of 0.1 are 0.3
#: Numbers of a distribution: how many, and which are lengths of time or others, not shares.
_PARAMETERS = {"uniform": 2, "normal": 2, "lognormal": 2, "triangular": 3}
_SEPARATORS = ("\t", ";", ",")  # of files of rows; words such as "slightly hard" have blanks
_HEAD = re.compile(r"^(.*?)\s*(?:\[([^\]]*)\])?$")


class FactorReader:
    """Reads the factors of one study."""

    def __init__(self, block: s.Block, declarations: Declarations, scope: Constants):
        self.block, self.declarations, self.scope = block, declarations, scope
        self.findings = scope.findings

    # --- vary ---------------------------------------------------------------------------------

    def vary(self, item: s.Assign | s.Sentence | s.Function) -> Factor:
        """Return the factor of a ``vary`` line, or reject it."""
        said = SentenceReader(VARY, SENTENCES[VARY], item, self.scope).get()
        name = said.target
        own, dimension = self._own(name, item.name.span)
        if isinstance(item, s.Sentence):
            return self._within_limits(name, item, own)
        written = item.value.span.to(item.span).one_line
        if isinstance(said, VariedRange):
            spread, unit = self._range(said, dimension)
            return self._factor(name, unit, spread, written, own, item.span)
        value, limits = said.values, said.limits
        if isinstance(value, s.Call) and value.function.key in DISTRIBUTIONS:
            spread, unit = self._distribution(value, limits, dimension)
            return self._factor(name, unit, spread, written, own, item.span)
        if limits is not None:
            hint = "only a distribution is cut off between limits"
            self.findings.reject("TIS312", "unexpected limits", limits.span, hint=hint)
        nodes = value.items if isinstance(value, s.Listing) else (value,)
        if not nodes:
            hint = f"for example: {SENTENCES[VARY].examples[2]}"
            self.findings.reject("TIS304", "the values are missing", value.span, hint=hint)
        return self._listed(name, nodes, dimension, written, own, item.span)

    def _own(
        self, target: str, span: Span, where: str = ""
    ) -> tuple[Value | str | None, Dimension | None]:
        """Return what the scene itself has, and its dimension as far as that is known.

        Args:
            target: The param or entry.
            span: Place of errors.
            where: Beginning of their messages.
        """
        declared = self.declarations.of("param").get(key_of(target))
        if declared is not None:
            value = self.scope.look_up(declared.name)
            if value.is_vector:
                assert isinstance(declared.item, s.Assign)
                return declared.item.value.span.one_line, value.dimension
            return value, value.dimension
        elsewhere = Findings()
        try:
            override = read_override(f"{target} = 0", elsewhere)
            item = written_entry(override, self.declarations, elsewhere)
        except Rejected:
            for found in elsewhere.errors:
                message = f"{where}{found.message}"
                self.findings.add(found.code, message, span, hint=found.hint)
            self.findings.stop()
        match item:
            case s.Assign(value=s.Number() | s.Quantity() | s.Name() | s.Sum() | s.Product()):
                value = self.scope.evaluate(item.value)
                return (item.value.span.one_line if value.is_vector else value), value.dimension
            case s.Assign():
                return item.value.span.one_line, None
            case s.Sentence() | s.Block() if item.phrase is not None:
                return item.phrase.span.one_line, None
            case _:
                entry = schema.entries_of(SimulateEntries).get(key_of(target))
                found = None if entry is None or entry.is_required else entry.default
                return (Value.number(found) if isinstance(found, float) else found), None

    def _factor(
        self, name: str, unit: str, spread: Levels | Distribution | None, written: str,
        own: Value | str | None, span: Span,
    ) -> Factor:  # fmt: skip
        """Return a factor of numbers in a unit."""
        shown = None
        if isinstance(own, Value):
            shown = rounded(float(own.amount) / _factor_of(unit))
        return Factor(name, "=", unit, False, spread, written, shown, span)

    # --- ranges, lists, distributions ---------------------------------------------------------

    def _number(self, node: s.Expression, dimension: Dimension | None, what: str) -> Value:
        value = self.scope.number(node)
        if dimension is not None:
            self.scope.expect(value, dimension, node.span, what=what)
        return value

    def _range(
        self, said: VariedRange, dimension: Dimension | None
    ) -> tuple[Levels | Distribution, str]:
        low = self._number(said.low, dimension, "the start of the range")
        high = self._number(said.high, low.dimension, "the end of the range")
        unit = _unit_of(said.low, low)
        a, b = in_unit(said.low, low, unit), in_unit(said.high, high, unit)
        values: tuple[float, ...]
        if said.steps is not None:
            values = self._steps(a, b, said.steps)
        elif said.by is not None:
            values = self._by(a, b, said.by, low, unit)
        elif a < b:
            return Distribution("uniform", (a, b)), unit
        else:
            ends = said.low.span, said.high.span
            hint = proposal(f"{ends[1].text} to {ends[0].text}")
            whole = ends[0].to(ends[1])
            self.findings.reject("TIS308", "the range ends before it begins", whole, hint=hint)
        return Levels(values, (said.low.span.to(said.span),) * len(values)), unit

    def _steps(self, a: float, b: float, node: s.Expression) -> tuple[float, ...]:
        """Return so many values from one number to another."""
        count = node.value if isinstance(node, s.Quantity) and node.unit == STEPS else None
        if count is None or count != int(count) or not 2 <= count <= MOST_VALUES:
            self.findings.reject(
                "TIS312", '"in" needs a whole number of steps, 2 at the least', node.span,
                hint="for example: in 9 steps",
            )  # fmt: skip
        last = int(count) - 1
        return tuple(rounded(a + (b - a) * n / last) for n in range(last + 1))

    def _by(
        self, a: float, b: float, node: s.Expression, low: Value, unit: str
    ) -> tuple[float, ...]:
        """Return values from one number on, up to another."""
        value = self._number(node, low.dimension, "the distance of values")
        by = in_unit(node, value, unit)
        if by == 0.0 or (b - a) / by < 0.0:
            self.findings.reject(
                "TIS308", f"steps of {node.span.text} do not lead to the end of the range",
                node.span,
            )  # fmt: skip
        count = math.floor((b - a) / by * (1 + 1e-12) + 1e-12) + 1
        if count > MOST_VALUES:
            self.findings.reject("TIS308", f"the range has {count} values", node.span)
        return tuple(rounded(a + by * n) for n in range(count))

    def _listed(
        self, name: str, nodes: Sequence[s.Expression], dimension: Dimension | None,
        written: str, own: Value | str | None, span: Span,
    ) -> Factor:  # fmt: skip
        """Return a factor whose values are listed: words, numbers, or vectors."""
        words = [isinstance(node, s.Name) and not self.scope.has(node) for node in nodes]
        places = tuple(node.span for node in nodes)
        if all(words):
            return _worded(name, "is", _texts(places), written, own, span)
        if any(words):
            mixed = nodes[words.index(True)]
            self.findings.reject(
                "TIS312", f'"{mixed.span.text}" is a word among numbers', mixed.span,
                hint="a list holds words or numbers",
            )  # fmt: skip
        values = [self.scope.evaluate(node) for node in nodes]
        if any(value.is_vector for value in values):
            return _worded(name, "=", _texts(places), written, own, span)
        for value, node in zip(values, nodes, strict=True):
            self.scope.expect(value, dimension or values[0].dimension, node.span, what=name)
        unit = _unit_of(nodes[0], values[0])
        numbers = tuple(
            in_unit(node, value, unit) for node, value in zip(nodes, values, strict=True)
        )
        return self._factor(name, unit, Levels(numbers, places), written, own, span)

    def _distribution(
        self, call: s.Call, limits: s.Bounds | None, dimension: Dimension | None
    ) -> tuple[Distribution, str]:
        kind = call.function.key
        arguments = [argument.value for argument in call.arguments]
        if len(arguments) != _PARAMETERS[kind] or any(a.clauses for a in call.arguments):
            hint = f"the form is {DISTRIBUTIONS[kind]}"
            self.findings.reject("TIS312", f"wrong form of {kind}", call.span, hint=hint)
        first = self._number(arguments[0], dimension, "the first number")
        unit = _unit_of(arguments[0], first)
        numbers: list[float] = []
        for n, node in enumerate(arguments):
            is_factor = kind == "lognormal" and n == 1
            value = self._number(
                node, NUMBER if is_factor else first.dimension, f"a number of {kind}"
            )
            numbers.append(float(value.amount) if is_factor else in_unit(node, value, unit))
        if flaw := _flaw(kind, numbers):
            self.findings.reject("TIS308", flaw, call.span)
        low = high = None
        if limits is not None:
            low, high = (
                in_unit(end, self._number(end, first.dimension, "a limit"), unit)
                for end in (limits.low, limits.high)
            )
            if not low < high:
                message = "the lower limit is not below the upper limit"
                if low > high:
                    self.scope.refuse_reversed(limits.low.span, limits.high.span)
                self.findings.reject("TIS308", message, limits.span)
        return Distribution(kind, tuple(numbers), low, high), unit

    def _within_limits(self, name: str, item: s.Sentence, own: Value | str | None) -> Factor:
        """Return a param that varies within its limits."""
        declared = self.declarations.of("param").get(key_of(name))
        bounds = getattr(declared.item, "bounds", None) if declared is not None else None
        if bounds is None or isinstance(own, str):
            what = (
                "the param has no limits" if declared is not None else "its values are missing"
            )
            self.findings.reject(
                "TIS304", f'"{name}" cannot vary: {what}', item.span,
                hint=f"for example: {SENTENCES[VARY].examples[0]}",
            )  # fmt: skip
        ends = [(node, self.scope.number(node)) for node in (bounds.low, bounds.high)]
        unit = _unit_of(*ends[1])
        low, high = (in_unit(node, value, unit) for node, value in ends)
        spread = Distribution("uniform", (low, high))
        written = f"{plain(low)} to {plain(high)} {unit}".rstrip()
        return self._factor(name, unit, spread, written, own, item.span)

    # --- a file of rows -----------------------------------------------------------------------

    def rows(self, item: s.Sentence) -> tuple[list[Factor], list[tuple[Cell, ...]]] | None:
        """Return the factors and rows of a file; None if only its text is kept elsewhere."""
        (name,) = SentenceReader(ROWS, SENTENCES[ROWS], item, self.scope).get().files
        place = DataReader(self.block, self.scope).find(name)
        library = self.scope.library
        if library is not None and library.kept is not None:
            return None
        try:
            text = decoded(read_bytes(place, LARGEST_ROWS))
        except OSError as error:
            message = f'cannot read "{name.quoted}": {error.strerror or error}'
            self.findings.reject("TIS604", message.lower(), item.span)
        quoted = f'"{name.quoted}"'
        table = None if text is None else TextTable.of(quoted, text, _SEPARATORS)
        if table is None:
            self.findings.reject("TIS604", f"{quoted} is not text, or empty", item.span)
        head, body = table.names, table.cells()
        if not body:
            hint = "the first line names the factors: lift [mm],hardness of liver"
            self.findings.reject("TIS604", f"{quoted} has no rows", item.span, hint=hint)
        for row, line in enumerate(body):
            if len(line) != len(head):
                what = f"has {len(line)} cells instead of {len(head)}"
                self._bad_row(table, row, what, item)
        columns = [[line[n] for line in body] for n in range(len(head))]
        factors = [
            self._column(title.strip(), cells, name, item)
            for title, cells in zip(head, columns, strict=True)
        ]
        values = [
            self._cells(factor, cells, table, item)
            for factor, cells in zip(factors, columns, strict=True)
        ]
        return factors, list(zip(*values, strict=True))

    def _column(
        self, head: str, cells: Sequence[str], file: s.Name, item: s.Sentence
    ) -> Factor:
        """Return the factor of a column."""
        found = _HEAD.match(head)
        assert found is not None
        name, unit = " ".join(found[1].split()), found[2] or ""
        where = f'column "{head}" of "{file.quoted}"'
        if not self._can_vary(found[1]):
            self.findings.reject(
                "TIS312", f"wrong name of {where}", item.span,
                hint="a column has the name of a factor, and its unit in square brackets: "
                "lift [mm]; commas, semicolons or tabs separate columns",
            )  # fmt: skip
        own, dimension = self._own(name, item.name.span, f"{where}: ")
        is_text = not unit and not all(map(_is_number, cells))
        if is_text:
            verb = "is" if all(re.fullmatch(r"[^\W\d][^(]*", cell) for cell in cells) else "="
            return _worded(name, verb, None, "", own, item.span)
        try:
            found_unit = parse_unit(unit).dimension if unit else NUMBER
        except UnitError as error:
            self.findings.reject("TIS104", f"{where}: {error}", item.span)
        if dimension is not None and found_unit != dimension:
            wanted = suggested_unit(dimension)
            self.findings.reject(
                "TIS502", f"{where} has the wrong unit", item.span,
                hint=f'call it "{name} [{wanted}]"' if wanted else f'call it "{name}"',
            )  # fmt: skip
        return self._factor(name, unit, None, "", own, item.span)

    def _can_vary(self, name: str) -> bool:
        """Return whether a text has the form of a factor."""
        if key_of(name) in self.declarations.of("param"):
            return True
        if set(";\t") & set(name):  # columns that something else separates
            return False
        try:
            read_override(f"{name} = 0", Findings())
        except Rejected:
            return False
        return True

    def _cells(
        self, factor: Factor, cells: Sequence[str], table: TextTable, item: s.Sentence
    ) -> list[Cell]:
        if factor.is_text:
            return list(cells)
        values: list[Cell] = []
        for row, cell in enumerate(cells):
            value = as_number(cell)
            if value is None or math.isnan(value):
                self._bad_row(table, row, f'"{cell}" is not a number of {factor.name}', item)
            values.append(value)
        return values

    def _bad_row(self, table: TextTable, row: int, what: str, item: s.Sentence) -> NoReturn:
        self.findings.reject("TIS121", f"{table.place(row)}: {what}", item.span)


def _texts(places: tuple[Span, ...]) -> Levels:
    """Return values as they are written."""
    return Levels(tuple(place.one_line for place in places), places)


def _worded(
    name: str, verb: str, levels: Levels | None, written: str, own: Value | str | None,
    span: Span,
) -> Factor:  # fmt: skip
    """Return a factor whose values are texts."""
    shown = own if isinstance(own, str) else None
    return Factor(name, verb, "", True, levels, written, shown, span)


def _is_number(cell: str) -> bool:
    value = as_number(cell)
    return value is not None and not math.isnan(value)


def _flaw(kind: str, numbers: Sequence[float]) -> str:
    """Return what is wrong with the numbers of a distribution; "" if nothing is."""
    if kind == "uniform" and not numbers[0] < numbers[1]:
        return "the first number of uniform must be below the second one"
    if kind == "triangular" and not numbers[0] <= numbers[1] <= numbers[2] > numbers[0]:
        return "the numbers of triangular must ascend"
    if kind == "normal" and not numbers[1] > 0.0:
        return "the standard deviation must be above 0"
    if kind == "lognormal" and not (numbers[0] > 0.0 and numbers[1] > 1.0):
        return "the median must be above 0, and the factor above 1"
    return ""


def _unit_of(node: s.Expression, value: Value) -> str:
    """Return the unit in which a number is written, or that of SI."""
    inner = node.operand if isinstance(node, s.Signed) else node
    if isinstance(inner, s.Quantity):
        return inner.unit
    return "" if isinstance(inner, s.Number) else si_unit(value.dimension)


def _factor_of(unit: str) -> float:
    return parse_unit(unit).factor if unit else 1.0


def in_unit(node: s.Expression, value: Value, unit: str) -> float:
    """Return a number in a unit: as written if it is written in that.

    Args:
        node: How it is written.
    """
    inner = node.operand if isinstance(node, s.Signed) else node
    if isinstance(inner, s.Quantity | s.Number) and getattr(inner, "unit", "") == unit:
        return -inner.value if inner is not node else inner.value
    return rounded(float(value.amount) / _factor_of(unit))


def rounded(number: float) -> float:
    """Return a number without the rounding errors of its arithmetic."""
    return float(f"{number:.{DIGITS}g}")
