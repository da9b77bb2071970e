"""Which runs of a table an answer uses, which it leaves out, and the parts of all answers.

Every analysis and every plot takes its rows from ``completed``, so that none leaves out runs
without a word.
"""

from collections.abc import Iterable, Iterator
from typing import Generic, TypeVar

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.model.network import Floats, Indices
from tissuec.studies.table import Column, MeasureCurve, StudyTable


class LeftOut(Struct, frozen=True):
    """Runs that an answer leaves out.

    Attributes:
        planned: Runs of the whole study.
        failed: Those that did not come to an end.
        empty: Those that finished, but lack the requested value.
        missing: Those that are not done yet.
    """

    planned: int
    failed: int = 0
    empty: int = 0
    missing: int = 0

    @property
    def count(self) -> int:
        """Return how many runs are left out."""
        return self.failed + self.empty + self.missing

    def __str__(self) -> str:
        kinds = (
            (self.failed, "failed"),
            (self.empty, "without a value"),
            (self.missing, "not done yet"),
        )
        parts = ", ".join(f"{count} {kind}" for count, kind in kinds if count)
        return f"left out of {self.planned} runs: {parts or 'none'}"


class Completed(Struct, frozen=True, eq=False):
    """Runs that finished and have a value.

    Attributes:
        rows: Their rows in the table, shape (run,).
        left_out: All other runs.
    """

    rows: Indices
    left_out: LeftOut


def completed(table: StudyTable, measure: Column | MeasureCurve | None = None) -> Completed:
    """Return the runs that finished, and have a value of a measure if one is given."""
    ended, known = table.finished, _has_value(table, measure)
    left_out = LeftOut(
        planned=table.head.planned,
        failed=int((~ended).sum()),
        empty=int((ended & ~known).sum()),
        missing=table.head.planned - len(table),
    )
    return Completed(np.flatnonzero(ended & known), left_out)


def _has_value(table: StudyTable, measure: Column | MeasureCurve | None) -> NDArray[np.bool_]:
    """Return which runs have a number, of a curve at any time, shape (row,)."""
    match measure:
        case None:
            return np.ones(len(table), dtype=np.bool_)
        case MeasureCurve():
            return np.asarray(np.isfinite(measure.values).any(axis=1))
        case _:
            return np.isfinite(measure.numbers)


def measure_of(table: StudyTable, name: str) -> Column:
    """Return a measure by its name.

    Raises:
        ValueError: The table has no such measure.
    """
    for column in table.measures:
        if key_of(column.name) == key_of(name):
            return column
    known = [column.name for column in table.measures]
    hint = alternatives(name, known, what="there are") or "it has none"
    raise ValueError(f'the table has no measure "{name}"; {hint}')


def values_of(table: StudyTable, measure: Column) -> tuple[Floats, LeftOut]:
    """Return all values of a measure, in its unit, shape (run,), and what is left out.

    Raises:
        ValueError: No run has a value.
    """
    found = completed(table, measure)
    if not len(found.rows):
        raise ValueError(f'no run has a value of "{measure.name}" ({found.left_out})')
    return measure.numbers[found.rows], found.left_out


def lack_of(table: StudyTable, row: int) -> str:
    """Return why a run has no value."""
    return table.reason[row] or "it has no value"


Part = TypeVar("Part")
MOST_NOTES = 8


class Answer(Struct, Generic[Part], frozen=True, eq=False, kw_only=True):
    """An answer about a measure; as a sequence, it holds its parts.

    Attributes:
        measure: Name of the measure.
        unit: Of the measure.
        parts: Such as quantiles, in their order.
        left_out: Runs that it leaves out.
    """

    measure: str
    unit: str
    parts: tuple[Part, ...]
    left_out: LeftOut

    def lines(self) -> Iterable[str]:
        """Return a line about each part."""
        return map(str, self.parts)

    def remarks(self) -> Iterable[str]:
        """Return remarks besides the runs that are left out."""
        return ()

    def notes(self) -> list[str]:
        """Return the runs that are left out, if there are any, and remarks."""
        found = [str(self.left_out)] if self.left_out.count else []
        remarks = list(self.remarks())
        more = len(remarks) - MOST_NOTES
        return [*found, *remarks[:MOST_NOTES], *([f"and {more} more"] if more > 0 else [])]

    def __iter__(self) -> Iterator[Part]:  # pyright: ignore[reportIncompatibleMethodOverride]  # Struct has none
        return iter(self.parts)

    def __len__(self) -> int:
        return len(self.parts)

    def __getitem__(self, place: int) -> Part:
        return self.parts[place]

    def __repr__(self) -> str:
        return "\n".join([*self.lines(), *self.notes()])
