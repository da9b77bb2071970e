"""Tables of studies as CSV, which is also the journal of a study under way.

The first line is a comment with all facts of the study as JSON, the second the names of the
columns. Lines of runs follow in any order during the study, in that of its design at the
end. Numbers have all their digits, and nothing depends on time or machine: the same study gives
the same bytes. A last line that is cut short is left out.
"""

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import msgspec

from tissuec.core.files import write_file
from tissuec.results import ResultError
from tissuec.scene.study.model import Cell
from tissuec.studies.table import MeasureHead, Row, StudyHead, StudyTable, rows_of, title

FORMAT = 3
LATER = {1: 2, 2: 1, FORMAT: 0}  # columns that formats lack: doubts, end
MARK = "# tissuec study "
_LONGEST = (1 << 31) - 1  # characters of a cell that every system allows
_LAST = ("outcome", "reason", "promise", "error", "digest", "doubts", "end [s]")


def write_csv(table: StudyTable, path: Path) -> None:
    """Write a table, in place of a file of that name.

    Raises:
        ResultError: It cannot be written.
    """
    try:
        write_file(path, as_csv(table.head, rows_of(table)))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ResultError(f'cannot write "{path}": {reason}') from error


def as_csv(head: StudyHead, rows: Iterable[Row]) -> str:
    """Return a whole table as text."""
    return head_lines(head) + "".join(map(row_line, rows))


def head_lines(head: StudyHead) -> str:
    """Return the first two lines."""
    facts = {"format": FORMAT, **msgspec.to_builtins(head)}
    columns = ["run"]
    columns += [title(one.name, one.unit) for one in (*head.factors, *head.measures)]
    return f"{MARK}{json.dumps(facts, ensure_ascii=False)}\n{_line([*columns, *_LAST])}"


def row_line(row: Row) -> str:
    """Return the line of a run."""
    values = map(_written, (*row.values, *row.measures))
    last = (row.outcome, row.reason, row.promise, _written(row.error), row.digest, row.doubts)
    return _line([str(row.run), *values, *last, _written(row.end)])


def read_csv(path: Path) -> StudyTable:
    """Return a table.

    Raises:
        ResultError: It cannot be read, or is not a table of a study.
    """
    return StudyTable.of(*read_rows(path))


def read_rows(path: Path) -> tuple[StudyHead, list[Row]]:
    """Return the content of a file, rows in its order.

    Raises:
        ResultError: It cannot be read, or is not a table of a study.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise ResultError(f'cannot read "{path}": {reason}') from error
    return parse_rows(data, path)


def parse_rows(data: bytes, path: Path) -> tuple[StudyHead, list[Row]]:
    """Return the content of the bytes of a file, rows in their order.

    Args:
        path: What messages call the file.

    Raises:
        ResultError: They are no table of a study.
    """
    try:
        text = data[: data.rfind(b"\n") + 1].decode(
            "utf-8"
        )  # without a line that was cut short
    except UnicodeDecodeError as error:
        raise ResultError(f'"{path}" is not a table of a study') from error
    first, _, rest = text.partition("\n")
    if not first.startswith(MARK):
        raise ResultError(
            f'"{path}" is not a table of a study: its first line is not "{MARK}…"'
        )
    try:
        facts: dict[str, Any] = json.loads(first.removeprefix(MARK))
        written = facts.pop("format", None)
        if written not in LATER:
            raise ResultError(f'"{path}" was written by another version of tissuec')
        head = msgspec.convert(facts, StudyHead)
    except Exception as error:  # whatever damaged data make of JSON
        raise ResultError(f'"{path}" is a damaged table: line 1: {error}') from error
    # A curve is one cell, however many samples it has.
    csv.field_size_limit(max(csv.field_size_limit(), min(len(rest), _LONGEST)))
    lines = csv.reader(io.StringIO(rest, newline=""))
    try:
        next(lines, None)
        more = [""] * LATER[written]
        return head, [_row(head, [*cells, *more]) for cells in lines]
    except Exception as error:
        raise ResultError(
            f'"{path}" is a damaged table: line {lines.line_num + 1}: {error}; without that '
            "line, the study does its run again"
        ) from error


def _row(head: StudyHead, cells: Sequence[str]) -> Row:
    factors, measures = len(head.factors), len(head.measures)
    if len(cells) != 1 + factors + measures + len(_LAST):
        raise ValueError(f"the row of run {cells[0] if cells else ''} has {len(cells)} cells")
    if not 0 <= int(cells[0]) < head.planned:
        raise ValueError(f"there is no run {cells[0]} of {head.planned}")
    values = zip(head.factors, cells[1:], strict=False)
    measured = zip(head.measures, cells[1 + factors :], strict=False)
    outcome, reason, promise, error, digest, doubts, end = cells[1 + factors + measures :]
    return Row(
        int(cells[0]),
        tuple(cell if factor.is_text else _number(cell) for factor, cell in values),
        tuple(_measured(measure, cell) for measure, cell in measured),
        outcome,
        reason,
        promise,
        _number(error),
        digest,
        doubts,
        _number(end),
    )


def _measured(head: MeasureHead, cell: str) -> float | tuple[float, ...]:
    if head.every is None:
        return _number(cell)
    return tuple(map(float, cell.split()))


def _number(cell: str) -> float:
    return float(cell) if cell else math.nan


def _written(cell: Cell | tuple[float, ...]) -> str:
    """Return a cell as text: numbers with all digits, of a curve with blanks between them."""
    match cell:
        case str():
            return cell
        case tuple():
            return " ".join(map(_digits, cell))
        case _:
            return "" if math.isnan(cell) else _digits(cell)


def _digits(number: float) -> str:
    return repr(float(number)).removesuffix(".0")


def _line(cells: Sequence[str]) -> str:
    line = io.StringIO(newline="")
    csv.writer(line, lineterminator="\n").writerow([re.sub(r"\s+", " ", c) for c in cells])
    return line.getvalue()
