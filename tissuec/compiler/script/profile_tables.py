"""Tables of profiles: ``using table "file.csv"``, ``along table "path.csv" in mm``."""

from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import NoReturn

import numpy as np

from tissuec.core.arrays import monotone_slopes
from tissuec.core.errors import CompileError
from tissuec.core.hints import Edit, Hint, insertion
from tissuec.core.text_tables.columns import GAP, BadRow, gap_mark
from tissuec.core.text_tables.dialect import Dialect, is_count
from tissuec.core.text_tables.table import TextTable
from tissuec.core.units import LENGTH, TIME, Unit, UnitError, describe, parse_unit, show
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.model.network import Floats
from tissuec.model.profiles import TimeProfile
from tissuec.scene.program.imports import read_source
from tissuec.scene.program.library import LINK, LINKED, Library
from tissuec.scene.reading.clauses import ClauseReader

TABLE = "table"
_MOST_SHOWN = 60  # characters of the names of columns in a message


def read_table_profiles(
    clause: s.Clause, columns: int, stop: float, order: ClauseReader
) -> tuple[TimeProfile, ...]:
    """Return one profile per column of a table, beginning at 0 s.

    Args:
        clause: The clause that names the table.
        columns: Number of columns after the time: 1 for factors, 3 for a path.
        stop: End of the sentence, from its beginning [s].
        order: The sentence.
    """
    assert isinstance(clause.value, s.Name)
    unit = _length_unit(clause, order) if columns > 1 else None
    table = _ProfileTable(clause, clause.value, unit, order)
    times, values = table.read(1 + columns)
    if times[0] > 0.0:  # what comes before the first row is as in that row
        times, values = np.concatenate([[0.0], times]), np.concatenate([values[:1], values])
    end = min(stop, float(times[-1]))
    with np.errstate(all="ignore"):
        slopes = [monotone_slopes(times, column) for column in values.T.copy()]
    if not np.all(np.isfinite(slopes)):
        message = f"the numbers in {clause.value.quoted} change too rapidly"
        table.reject("TIS313", message, "check the times and the units")
    return tuple(
        TimeProfile("table", 0.0, end, 0.0, times, column, slope)
        for column, slope in zip(values.T.copy(), slopes, strict=True)
    )


def table_texts(items: Sequence[s.Item], library: Library) -> dict[str, str]:
    """Return the texts of the tables that a script names, by the names that it has for them.

    Args:
        items: Of a script that was read without a mistake.
        library: Of the scene.
    """
    found: dict[str, str] = {}
    for name in names_in(tuple(items)):
        if name.quoted is not None and name.words.lower() == TABLE:
            path, scene = str(PurePosixPath(name.quoted)), name.span.source.path
            text = library.kept_text(path)
            if text is None and scene is not None:
                text = read_source(scene.parent / path, path).text
            found |= {path: text} if text is not None else {}
    return found


def _length_unit(clause: s.Clause, order: ClauseReader) -> Unit:
    """Return the unit of ``in mm``."""
    if not order.has("in"):
        path = clause.span
        hint = Hint(f"for example: {path.text} in mm", insertion(" in mm", path))
        order.reject("TIS304", "the unit of the path is missing", hint=hint, word=clause.word)
    text = order.name_in("in").text
    example = Hint("for example: in mm", Edit("in mm"))
    try:
        unit = parse_unit(text)
    except UnitError as error:
        order.reject("TIS104", str(error), hint=example, word="in")
    if unit.dimension != LENGTH:
        message = f"a path needs a unit of length; {text} is not one"
        order.reject("TIS502", message, hint=example, word="in")
    return unit


class _ProfileTable:
    """A table beside the scene, as a sentence names it.

    Args:
        clause: The clause that names the table.
        name: The name of the table.
        unit: Unit of the displacements of a path; None if the values are factors.
        order: The sentence.
    """

    def __init__(self, clause: s.Clause, name: s.Name, unit: Unit | None, order: ClauseReader):
        self.name, self.unit, self.order, self.word = name, unit, order, clause.word
        self.path = PurePosixPath(name.quoted or "")
        self.form = "each row has a time and " + ("a factor" if unit is None else "x, y and z")

    def reject(self, code: str, message: str, hint: str = "") -> NoReturn:
        self.order.reject(code, message, hint=hint or self.form, word=self.word)

    def read(self, width: int) -> tuple[Floats, Floats]:
        """Return times [s], shape (row,), and factors or displacements [m], (row, column)."""
        table = TextTable.of(str(self.path), self._text())
        if table is None:
            self.reject("TIS313", f"{self.path} is empty")
        self._check_width(table.dialect, width)
        time_unit = self._time_unit(table.dialect)
        self._check_units(table.dialect)
        rows = self._rows(table)
        with np.errstate(over="ignore"):
            times = rows[:, 0] * time_unit
            values = rows[:, 1:] * (1.0 if self.unit is None else self.unit.factor)
        self._check_times(times, table)
        return times, values

    def _check_width(self, dialect: Dialect, width: int) -> None:
        found = len(dialect.names)
        if found == width:
            return
        listed = ", ".join(dialect.names) if dialect.named else ""
        if len(listed) > _MOST_SHOWN:
            listed = f"{listed[:_MOST_SHOWN]}…"
        columns = f"{found} column{'' if found == 1 else 's'}{f' ({listed})' if listed else ''}"
        message = f"{self.path} has {columns} instead of {width}"
        self.reject("TIS313", message, f"{self.form}; lines with other text begin with #")

    def _time_unit(self, dialect: Dialect) -> float:
        """Return the seconds in one of the unit that the first column is named with."""
        if not dialect.named:
            return 1.0
        column = f'the first column of {self.path}, "{dialect.names[0]}",'
        hint = "name it with a unit of time, such as t_ms, or without a unit for seconds"
        try:
            unit = dialect.unit(0)
        except UnitError as error:
            self.reject("TIS104", f"{column} has an unknown unit: {error}", hint)
        if unit is None and is_count(dialect.names[0]):
            message = f"{column} counts rows; a table begins with a column of times"
            self.reject("TIS313", message, "write the times there, in s, or name it t_ms")
        if unit is None:
            return 1.0
        if unit.dimension != TIME:
            message = f"{column} ends with the unit of {describe(unit.dimension)}"
            self.reject("TIS502", f"{message}; {describe(TIME)} is needed", hint)
        return unit.factor

    def _check_units(self, dialect: Dialect) -> None:
        """Reject names of columns that contradict the sentence, which gives their unit."""
        where = "in the sentence" if self.unit is None else "after in"
        hint = f"write the unit {where}; the name of the column needs none"
        for number, name in enumerate(dialect.names if dialect.named else ()):
            is_symbol = len(name) == 1 and name.islower() and not dialect.units
            if not number or is_symbol:  # m, s or g are symbols here
                continue
            column = f'the column "{name}" of {self.path}'
            try:
                unit = dialect.unit(number)
            except UnitError as error:
                if self.unit is None:  # such as factor (relative)
                    continue
                self.reject("TIS104", f"{column} has an unknown unit: {error}", hint)
            if unit is None or unit == self.unit:
                continue
            if self.unit is None:
                self.reject("TIS502", f"{column} has a unit, but a factor has none", hint)
            written = self.order.clauses["in"].span.text
            self.reject("TIS502", f'{column} has another unit than "{written}"', hint)

    def _rows(self, table: TextTable) -> Floats:
        """Return two rows of numbers or more, in the units of the text, shape (row, column)."""
        try:
            rows = table.numbers(range(len(table.names)))
        except BadRow as error:
            self._bad_row(table, error)
        gaps = np.argwhere(np.isnan(rows))
        if len(gaps):
            row, column = gaps[0].tolist()
            self._bad_row(table, BadRow(row, column, "the number is missing"))
        for column in range(1, rows.shape[1]):
            if (row := gap_mark(rows[:, column])) is not None:
                problem = f"{rows[row, column]:g} is far from all other numbers"
                remedy = "remove rows without a number; some programs mark them so"
                self._bad_row(table, BadRow(row, column, problem, remedy))
        if len(rows) < 2:
            self.reject("TIS313", f"{self.path} contains fewer than two rows of numbers")
        return rows

    def _bad_row(self, table: TextTable, error: BadRow) -> NoReturn:
        remedy = "" if error.remedy == GAP else error.remedy
        message = f"{table.place(error.row, error.column)}: {error.problem}"
        self.reject("TIS313", message, remedy)

    def _check_times(self, times: Floats, table: TextTable) -> None:
        hint = "sort the rows by time, each time once, from 0 s on"
        if times[0] < 0.0:
            message = f"{self.path} begins at {show(times[0], TIME)}, before its order does"
            self.reject("TIS313", message, hint)
        wrong = np.flatnonzero(np.diff(times) <= 0.0)
        if len(wrong):
            row = int(wrong[0])
            before, behind = (show(float(times[one]), TIME) for one in (row, row + 1))
            message = (
                f"{table.places(row, row + 1)} do not ascend: {behind} comes after {before}"
            )
            self.reject("TIS313", message, hint)

    def _text(self) -> str:
        """Return the text of the file, which lies beside the scene that names it."""
        path = self.path
        if path.is_absolute() or ".." in path.parts or set("\\:") & set(str(path)):
            message = f'"{path}" is outside the folder of the scene'
            self.reject("TIS603", message, "put the file beside the scene")
        library, scene = self.order.scope.library, self.name.span.source.path
        kept = None if library is None else library.kept_text(str(path))
        if kept is not None:
            return kept
        if scene is None:
            message = f'"{path}": a scene that is not saved in a file cannot read tables'
            self.reject("TIS604", message, "save the scene to a file")
        place = scene.parent / path
        if (library or Library.of(self.name.span.source)).leads_out(place):
            self.reject("TIS603", LINK.format(path), LINKED)
        try:
            return read_source(place, str(path)).text
        except CompileError as error:
            message = error.diagnostics[0].message
            self.reject("TIS604", message, "the path is relative to the scene")
