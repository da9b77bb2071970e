"""Which columns of a table are read."""

import re
from collections.abc import Mapping, Sequence
from math import isclose
from typing import NoReturn

from msgspec import Struct

from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.source import Span
from tissuec.core.text_tables.column_units import is_count
from tissuec.core.text_tables.dialect import Dialect
from tissuec.core.units import LENGTH, TIME, Dimension, UnitError, describe, si_unit
from tissuec.learn.data.complaints import TWO_MACHINES, Complaints, first_few
from tissuec.learn.data.long import is_long
from tissuec.script.fit_problem import DataAxis, DataColumn, Fit

_LETTER = re.compile(r"(?:^|[\s_/])[^\W\d_]$")


class Wanted(Struct, frozen=True, eq=False):
    """The columns that are read; the first of them is the axis.

    Attributes:
        numbers: Of them in the table, from 0, each once.
        spans: Where each is asked for.
        factor: What one of the unit of the axis is in SI.
        places: Of the columns of fits among these.
    """

    numbers: Sequence[int]
    spans: Sequence[Span]
    factor: float
    places: Mapping[DataColumn, int]


def find_columns(
    dialect: Dialect, axis: DataAxis, fits: Sequence[Fit], complaints: Complaints
) -> Wanted:
    """Return the columns that an axis and fits name.

    Raises:
        CompileError: The table has not all of them; every one that is missing is told.
    """
    header = _Header(dialect, complaints)
    numbers, spans, factor = [dialect.clock], [complaints.data.span], 1.0
    places: dict[DataColumn, int] = {}
    with complaints.part():
        if axis.column is None:
            factor = header.first_unit(axis)
        else:
            numbers[0], spans[0] = header.find(axis.column), axis.column.span
            factor = axis.column.unit
            header.check_unit(axis.column, numbers[0], TIME if axis.nodes is None else LENGTH)
    for fit in fits:
        with complaints.part():
            if not fit.columns:
                header.reject_unnamed(fit)
        for column in fit.columns:
            with complaints.part():
                number = header.find(column)
                if not (is_long(fit) and column is fit.columns[0]):  # ids have no unit
                    header.check_unit(column, number, fit.dimension)
                if number not in numbers:
                    numbers.append(number)
                    spans.append(column.span)
                places[column] = numbers.index(number)
    complaints.settle()
    return Wanted(numbers, spans, factor, places)


class _Header:
    """The names of the columns of a table."""

    def __init__(self, dialect: Dialect, complaints: Complaints):
        self.names, self.is_named, self.dialect = dialect.names, dialect.named, dialect
        self.complaints = complaints

    @property
    def begin(self) -> str:
        """Return the end of a hint that says where the table begins, if text stands above."""
        if not self.dialect.above:
            return ""
        return (
            f"  (the table begins in line {self.dialect.above + 1}; the lines above are text)"
        )

    def find(self, column: DataColumn) -> int:
        """Return the number of a column; one that no name is may be its number from 1."""
        name = column.name.strip()
        count = self.names.count(name)
        if count > 1:
            self._reject_several(column, name, count)
        if count:
            return self.names.index(name)
        if name.isdecimal() and 1 <= int(name) <= len(self.names):
            return int(name) - 1
        listed = first_few([one for one in self.names if one])
        what = "columns" if self.is_named else "there is no header; columns are numbered"
        hint = alternatives(name, listed, what=what)
        is_alone = self.complaints.is_alone or hint.edits
        other = "" if is_alone else f"  ({TWO_MACHINES})"
        self.complaints.reject(
            "TIS301",
            f'{self.complaints.file} has no column "{name}"',
            column.span,
            hint=Hint(f"{hint}{self.begin}{other}", *hint.edits),
        )

    def _reject_several(self, column: DataColumn, name: str, count: int) -> NoReturn:
        """Reject a name that several columns have."""
        places = [f'"{n}"' for n, one in enumerate(self.names, 1) if one == name]
        known = [place for place in places if place.strip('"') not in self.names]
        hint = Hint(
            f"name one by its number: {' or '.join(first_few(places))}"
            if known
            else "give the columns different names in the file",
            *(
                Edit(place, old=f'"{name}"')
                for place in known
                if f'"{name}"' in column.span.text
            ),
        )
        message = f'{self.complaints.file} has {count} columns "{name}"'
        self.complaints.reject("TIS307", message, column.span, hint)

    def check_unit(self, column: DataColumn, number: int, dimension: Dimension) -> None:
        """Reject a name, or a row of units, that contradicts the unit in the sentence.

        A factor before the unit is taken as written, so it never contradicts the file.

        Args:
            column: As it is asked for; by its number, whatever its name says holds.
            number: Its place in the table, from 0.
            dimension: Of what it holds.
        """
        try:
            unit = self.dialect.unit(number)
        except UnitError:
            return  # brackets hold many things, such as (filtered)
        name = self.names[number]
        if unit is None or column.name.strip() != name:
            return
        is_same = isclose(unit.factor * column.factor, column.unit, rel_tol=1e-12)
        if is_same and unit.dimension == dimension:
            return
        is_letter = not any(self.dialect.units) and _LETTER.search(name) is not None
        if is_letter and (len(name) == 1 or unit.dimension != dimension):
            return  # a symbol, or a label as in "specimen A"
        self.complaints.reject(
            "TIS502",
            f'column "{column.name}" of {self.complaints.file} has another unit than the '
            "one after in",
            column.span,
            hint="write the unit of the column after in; if that is wrong in the file, name "
            f'the column by its number, "{number + 1}"',
        )

    def first_unit(self, axis: DataAxis) -> float:
        """Return what one of the unit of the first column is in SI, as its name says."""
        wanted = TIME if axis.nodes is None else LENGTH
        name = self.names[self.dialect.clock]
        entry = "time" if axis.nodes is None else "displacement of …"
        if wanted == TIME and self.is_named and is_count(name):
            self._reject_count(name)
        hint = f'write, with its own unit: {entry} using column "NAME" in {si_unit(wanted)}'
        first = f'the first column of {self.complaints.file}, "{name}",'
        try:
            unit = self.dialect.unit(self.dialect.clock)
        except UnitError as error:
            message = f"{first} has an unknown unit: {error}"
            self.complaints.reject("TIS104", message, hint=hint)
        if unit is None:
            return 1.0
        if unit.dimension != wanted:
            message = f"{first} ends with the unit of {describe(unit.dimension)}"
            problem = f"{message}; {describe(wanted)} is needed"
            self.complaints.reject("TIS502", problem, hint=hint)
        return unit.factor

    def _reject_count(self, name: str) -> NoReturn:
        """Reject the first column, which counts rows, as the column of times."""
        what = f', "{name}",' if name else ""
        known = name if name and self.names.count(name) == 1 else f"{self.dialect.clock + 1}"
        self.complaints.reject(
            "TIS304",
            f"the first column of {self.complaints.file}{what} counts rows; the time between "
            "them is missing",
            hint=f'write, with the time from one row to the next: time using column "{known}" '
            f"in 10 ms; or name the column of times  columns: "
            f"{', '.join(first_few([one for one in self.names if one]))}",
        )

    def reject_unnamed(self, fit: Fit) -> NoReturn:
        listed = ", ".join(first_few([one for one in self.names if one]))
        self.complaints.reject(
            "TIS304",
            f"{self.complaints.file} is a table; the column of {fit.text} is not given",
            fit.span,
            hint=f'write after it: using column "NAME" in UNIT  columns: {listed}{self.begin}',
        )
