"""Effects of factors that vary one at a time, as a tornado plot shows them."""

import numpy as np
from msgspec import Struct

from tissuec.scene.study_entries import ONE_AT_A_TIME
from tissuec.studies.analysis.convergence import label
from tissuec.studies.analysis.samples import measure_of, usable
from tissuec.studies.table import StudyTable


class Effect(Struct, frozen=True):
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


def effects(table: StudyTable, measure: str) -> tuple[float, tuple[Effect, ...]]:
    """Return the value in the scene as written, and the effects, the largest first.

    Factors of which no run has a value are left out.

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
    there = usable(table, column)
    base = np.flatnonzero((table.runs == 0) & there)
    if not len(base):
        raise ValueError(f'the run of the scene as written has no value of "{measure}"')
    found: list[Effect] = []
    own, values = int(base[0]), column.numbers
    for factor in table.factors:
        at = factor.values
        varied = [row for row in np.flatnonzero(there).tolist() if at[row] != at[own]]
        if not varied:
            continue
        rows = [own, *varied]
        low, high = min(rows, key=values.__getitem__), max(rows, key=values.__getitem__)
        found.append(
            Effect(
                factor.name,
                float(values[low]),
                float(values[high]),
                label(factor, low),
                label(factor, high),
            )
        )
    found.sort(key=lambda effect: -effect.range)
    return float(values[own]), tuple(found)
