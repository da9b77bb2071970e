"""The table of a study: one row for each run, with its values, measures and outcome."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.core.structs import replace
from tissuec.model.network import Floats, Indices
from tissuec.scene.study.model import Cell

#: What the outcome of a run can be: it came to its end, or its script ended it; the motion
#: could not be computed; the text was wrong; or its worker process died.
DONE, ENDED, DIVERGED, STUCK, REFUSED, DIED = (
    "done", "ended", "diverged", "stuck", "refused", "died",
)  # fmt: skip
OUTCOMES = (DONE, ENDED, DIVERGED, STUCK, REFUSED, DIED)


class FactorHead(Struct, frozen=True):
    """The head above the values of a factor.

    Attributes:
        name: Such as "lift" or "hardness of fallopian tube".
        unit: Of numbers, such as "mm"; "" for numbers without a unit and for words.
        is_text: Whether values are words.
        values: Its values as they were written, such as "normal(5 mm, 1 mm)".
    """

    name: str
    unit: str
    is_text: bool = False
    values: str = ""


class MeasureHead(Struct, frozen=True):
    """The head above a measure.

    Attributes:
        name: Such as "pull".
        unit: Such as "N".
        every: Time between the values of a curve [s]; None for a single number.
    """

    name: str
    unit: str
    every: float | None = None


class StudyHead(Struct, frozen=True):
    """All of a table except its rows.

    Attributes:
        name: Of the study.
        scene: Name of the scene.
        design: Such as "grid" or "sobol".
        seed: Of random designs.
        base: Base number of "sobol indices"; 0 for other designs.
        planned: Number of runs of the whole study.
        measures: Single numbers before curves.
    """

    name: str
    scene: str
    design: str
    seed: int
    base: int
    planned: int
    factors: tuple[FactorHead, ...]
    measures: tuple[MeasureHead, ...]


class Row(Struct, frozen=True):
    """One run.

    Attributes:
        run: Its number in the design, from 0.
        values: Of the factors.
        measures: Of single numbers one value, of curves all, NaN where there is none.
        outcome: One of ``OUTCOMES``.
        reason: One line; "" for a run that came to its end.
        promise: "kept", "broken from T", "unknown from T" or "not checked".
        error: Estimated error of positions, relative to displacements; NaN if not known.
        digest: Of all that the row follows from.
        doubts: Kinds of what makes its numbers doubtful, such as "inside out"; "" for none.
        end: When it ended [s]; NaN for a run that failed.
    """

    run: int
    values: tuple[Cell, ...]
    measures: tuple[float | tuple[float, ...], ...]
    outcome: str
    reason: str
    promise: str
    error: float
    digest: str = ""
    doubts: str = ""
    end: float = math.nan


def title(name: str, unit: str) -> str:
    """Return the head of a column: "lift [mm]"."""
    return f"{name} [{unit}]" if unit else name


def _exactly(values: Floats, scale: AxisUnit) -> Floats:
    """Return numbers in another unit without the digits of a product in binary."""
    exact = scale.exactly(values.ravel().tolist())
    return np.array(list(map(float, exact))).reshape(values.shape)


class Column(Struct, frozen=True, eq=False):
    """One column, of a factor or a measure.

    Attributes:
        name: Such as "lift" or "pull".
        unit: Such as "mm"; "" for numbers without a unit and for words.
        values: Numbers in this unit, shape (row,), NaN where there is none; or words.
    """

    name: str
    unit: str
    values: Floats | tuple[str, ...]

    @property
    def numbers(self) -> Floats:
        """Return the values as numbers in the column's unit, shape (row,).

        Raises:
            ValueError: They are words.
        """
        if isinstance(self.values, tuple):
            raise ValueError(f'the values of "{self.name}" are words, not numbers')
        return self.values

    @property
    def title(self) -> str:
        """Return the name with its unit: "lift [mm]"."""
        return title(self.name, self.unit)

    @property
    def shown(self) -> Self:
        """Return a measure in the unit that it has on axes."""
        scale = scale_of(self.unit, [self.numbers])
        return replace(self, unit=scale.spelled, values=_exactly(self.numbers, scale))

    def text(self, row: int) -> str:
        """Return the value of a row with its unit, such as "2 mm"."""
        return self.written(self.values[row])

    def written(self, value: Cell) -> str:
        """Return a value of the column with its unit."""
        return value if isinstance(value, str) else f"{value:g} {self.unit}".rstrip()


class MeasureCurve(Struct, frozen=True, eq=False):
    """A measure over time, of every run.

    Attributes:
        name: Such as "curve".
        unit: Such as "N".
        every: Time between the samples, of which the first is at 0 s [s].
        values: In this unit, shape (row, sample); NaN after the end of a run.
    """

    name: str
    unit: str
    every: float
    values: Floats

    @property
    def shown(self) -> Self:
        """Return it in the unit that it has on axes."""
        scale = scale_of(self.unit, [self.values])
        return replace(self, unit=scale.spelled, values=_exactly(self.values, scale))

    @property
    def times(self) -> Floats:
        """Return the times of the samples [s], shape (sample,)."""
        return np.arange(self.values.shape[1], dtype=float) * self.every


class StudyTable(Struct, frozen=True, eq=False):
    """All runs of a study that are known, in the order of its design.

    Attributes:
        head: All but the rows.
        runs: Number of each row's run in the design, ascending from 0, shape (row,).
        factors: What varies.
        measures: What was measured, as single numbers.
        curves: What was measured over time.
        outcome: One of ``OUTCOMES`` for each row.
        reason: One line for each row; "" for a run that came to its end.
        promise: "kept", "broken from T", "unknown from T" or "not checked", for each row.
        error: Estimated error of positions, relative to displacements, shape (row,); NaN
            if not known.
        digests: Of all that each row follows from.
        doubts: Kinds of what makes the numbers of each row doubtful, "" for none.
        end: When each run ended [s], shape (row,); NaN for one that failed.
    """

    head: StudyHead
    runs: Indices
    factors: tuple[Column, ...]
    measures: tuple[Column, ...]
    curves: tuple[MeasureCurve, ...]
    outcome: tuple[str, ...]
    reason: tuple[str, ...]
    promise: tuple[str, ...]
    error: NDArray[np.float64]
    digests: tuple[str, ...]
    doubts: tuple[str, ...]
    end: NDArray[np.float64]

    @property
    def shown(self) -> Self:
        """Return the table with measures in the units that they have on axes."""
        return replace(
            self,
            measures=tuple(one.shown for one in self.measures),
            curves=tuple(one.shown for one in self.curves),
        )

    @classmethod
    def of(cls, head: StudyHead, rows: Iterable[Row]) -> Self:
        """Return the table of rows in any order; of two rows of one run the later counts."""
        found = {row.run: row for row in rows}
        ordered = [found[run] for run in sorted(found)]
        singles = [n for n, one in enumerate(head.measures) if one.every is None]
        return cls(
            head=head,
            runs=np.array([row.run for row in ordered], dtype=np.int64),
            factors=tuple(
                _factor(one, [row.values[n] for row in ordered])
                for n, one in enumerate(head.factors)
            ),
            measures=tuple(_single(head.measures[n], n, ordered) for n in singles),
            curves=tuple(
                _curve(one, n, ordered)
                for n, one in enumerate(head.measures)
                if one.every is not None
            ),
            outcome=tuple(row.outcome for row in ordered),
            reason=tuple(row.reason for row in ordered),
            promise=tuple(row.promise for row in ordered),
            error=np.array([row.error for row in ordered], dtype=float),
            digests=tuple(row.digest for row in ordered),
            doubts=tuple(row.doubts for row in ordered),
            end=np.array([row.end for row in ordered], dtype=float),
        )

    def __len__(self) -> int:
        return len(self.outcome)

    def __repr__(self) -> str:
        count = f"{len(self)} of {self.head.planned} runs"
        return f'<StudyTable "{self.head.name}" of {self.head.scene}: {count}>'

    @property
    def is_complete(self) -> bool:
        """Return whether every run of the study has a row."""
        return len(self) == self.head.planned

    @property
    def finished(self) -> NDArray[np.bool_]:
        """Return which runs finished, at their own end or that of the script, shape (row,)."""
        return np.isin(self.outcome, (DONE, ENDED))

    @property
    def idle_factors(self) -> tuple[str, ...]:
        """Return the factors whose values make no difference to any measure, to the last bit.

        Only rows are compared that differ in one factor alone, and have finished.
        """
        rows = np.flatnonzero(self.finished)
        if not len(rows):
            return ()
        singles = np.array([one.numbers[rows] for one in self.measures]).T.reshape(
            len(rows), -1
        )
        curves = [one.values[rows] for one in self.curves]
        measured = [row.tobytes() for row in np.concatenate([singles, *curves], axis=1)]
        values = list(
            zip(*([one.values[n] for n in rows] for one in self.factors), strict=True)
        )
        found: list[str] = []
        for number, factor in enumerate(self.factors):
            alike: dict[object, dict[object, bytes]] = {}
            for row, result in zip(values, measured, strict=True):
                others = (*row[:number], *row[number + 1 :])
                alike.setdefault(others, {})[row[number]] = result
            compared = [group for group in alike.values() if len(group) > 1]
            if compared and all(len(set(group.values())) == 1 for group in compared):
                found.append(factor.name)
        return tuple(found)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Return all columns of factors and measures."""
        return (*self.factors, *self.measures)

    def column(self, name: str) -> Column:
        """Return a factor or measure by its name.

        Raises:
            ValueError: There is none of that name.
        """
        named = {key_of(column.name): column for column in self.columns}
        if key_of(name) not in named:
            hint = alternatives(name, [c.name for c in self.columns], what="there are")
            raise ValueError(f'the table has no column "{name}"; {hint}')
        return named[key_of(name)]


def rows_of(table: StudyTable) -> Iterator[Row]:
    """Yield the rows of a table."""
    factors = [_cells(factor) for factor in table.factors]
    for n in range(len(table)):
        curves = (curve.values[n][~_is_behind(curve.values[n])] for curve in table.curves)
        yield Row(
            int(table.runs[n]),
            tuple(cells[n] for cells in factors),
            (
                *(float(measure.numbers[n]) for measure in table.measures),
                *(tuple(curve.tolist()) for curve in curves),
            ),
            table.outcome[n],
            table.reason[n],
            table.promise[n],
            float(table.error[n]),
            table.digests[n],
            table.doubts[n],
            float(table.end[n]),
        )


def _factor(head: FactorHead, values: Sequence[Cell]) -> Column:
    texts = tuple(map(str, values))
    numbers = np.array([] if head.is_text else values, dtype=float)
    return Column(head.name, head.unit, texts if head.is_text else numbers)


def _single(head: MeasureHead, place: int, rows: Sequence[Row]) -> Column:
    values = np.array([row.measures[place] for row in rows], dtype=float)
    return Column(head.name, head.unit, values)


def _curve(head: MeasureHead, place: int, rows: Sequence[Row]) -> MeasureCurve:
    all_values = [np.atleast_1d(np.asarray(row.measures[place], dtype=float)) for row in rows]
    longest = max(map(len, all_values), default=0)
    values = np.full((len(rows), longest), np.nan)
    for row, one in zip(values, all_values, strict=True):
        row[: len(one)] = one
    assert head.every is not None
    return MeasureCurve(head.name, head.unit, head.every, values)


def _cells(column: Column) -> Sequence[Cell]:
    return column.values if isinstance(column.values, tuple) else column.values.tolist()


def _is_behind(values: Floats) -> NDArray[np.bool_]:
    """Return which samples come after the last one that there is, shape (sample,)."""
    there = np.flatnonzero(~np.isnan(values))
    return np.arange(len(values)) > (there[-1] if len(there) else -1)
