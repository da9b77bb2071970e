"""Effects of factors that vary one at a time, as a tornado plot shows them."""

from collections.abc import Iterator, Sequence

from msgspec import Struct

from tissuec.scene.study.entries import ONE_AT_A_TIME
from tissuec.studies.analysis.completed import Answer, completed, lack_of, measure_of
from tissuec.studies.table import Column, StudyTable


class FactorEffect(Struct, frozen=True):
    """The range of a measure over the values of one factor, the others as in the scene.

    Attributes:
        factor: Name of the factor.
        low, high: Smallest and largest value of the measure, in its unit.
        at_low, at_high: Values of the factor there, with their unit.
    """

    factor: str
    low: float
    high: float
    at_low: str
    at_high: str

    @property
    def range(self) -> float:
        """Return the difference of both values, in the unit of the measure."""
        return self.high - self.low


class Effects(Answer[FactorEffect], frozen=True, eq=False, kw_only=True):
    """The effects of all factors with a value, the largest first.

    Attributes:
        own: Value of the measure in the scene as written, in its unit.
        unknown: Values of factors whose runs are left out, with the reason.
    """

    own: float
    unknown: tuple[str, ...]

    def lines(self) -> Iterator[str]:
        for one in self:
            ends = f"{one.low:.4g} ({one.at_low}) to {one.high:.4g} ({one.at_high})"
            yield f"{one.factor}: {ends} {self.unit}".rstrip()

    def remarks(self) -> Sequence[str]:
        return self.unknown


def effects(table: StudyTable, measure: str) -> Effects:
    """Return the value in the scene as written, and the effects of the factors.

    Args:
        table: Of a study with the design "one at a time".
        measure: Name of the measure.

    Raises:
        ValueError: The study has another design, or the run of the scene as written has no
            value.
    """
    if table.head.design != ONE_AT_A_TIME:
        raise ValueError(
            f'effects need the design "{ONE_AT_A_TIME}"; this study has "{table.head.design}"'
        )
    column = measure_of(table, measure)
    found = completed(table, column)
    there = set(found.rows.tolist())
    own = next((row for row in there if table.runs[row] == 0), None)
    if own is None:
        raise ValueError(f'the run of the scene as written has no value of "{measure}"')
    varied = {
        factor.name: [row for row in range(len(table)) if _differ(factor, row, own)]
        for factor in table.factors
    }
    parts = [
        _effect(factor, column, [own, *(row for row in varied[factor.name] if row in there)])
        for factor in table.factors
        if there.intersection(varied[factor.name])
    ]
    return Effects(
        measure=column.name,
        unit=column.unit,
        parts=tuple(sorted(parts, key=lambda effect: -effect.range)),
        left_out=found.left_out,
        own=float(column.numbers[own]),
        unknown=tuple(
            f"{factor.name} = {factor.text(row)}: {lack_of(table, row)}"
            for factor in table.factors
            for row in varied[factor.name]
            if row not in there
        ),
    )


def _effect(factor: Column, column: Column, rows: Sequence[int]) -> FactorEffect:
    """Return the range of a measure over some rows."""
    values = column.numbers
    low, high = (choice(rows, key=values.__getitem__) for choice in (min, max))
    at_low, at_high = factor.text(low), factor.text(high)
    return FactorEffect(factor.name, float(values[low]), float(values[high]), at_low, at_high)


def _differ(factor: Column, row: int, other: int) -> bool:
    """Return whether a factor has two values; NaN in both rows is one."""
    pair = {factor.values[row], factor.values[other]}
    return len(pair) == 2 and any(value == value for value in pair)
