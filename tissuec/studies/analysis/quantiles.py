"""Quantiles of a measure over the runs of a random design, with their intervals.

The interval of a quantile is free of assumptions about the distribution: it runs between two
order statistics, whose ranks follow from the binomial distribution (W. J. Conover, Practical
Nonparametric Statistics, 1999, 3.2; computed by ``scipy.stats.quantile_test``). It holds for
independent runs; runs of a latin hypercube or a Sobol sequence are spread more evenly.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.scene.study_entries import GRID, ONE_AT_A_TIME
from tissuec.studies.analysis.samples import measure_of, usable
from tissuec.studies.table import StudyTable

PARTS = (0.05, 0.25, 0.5, 0.75, 0.95)
CONFIDENCE = 0.95


class Quantile(Struct, frozen=True):
    """A quantile.

    Attributes:
        part: Part of the runs below it, between 0 and 1.
        value: In the unit of the measure.
        low, high: Ends of its 95 % confidence interval; NaN where there are too few runs.
    """

    part: float
    value: float
    low: float
    high: float


def quantiles(
    table: StudyTable, measure: str, parts: Sequence[float] = PARTS
) -> tuple[Quantile, ...]:
    """Return quantiles of a measure over the runs that came to an end.

    Args:
        table: The table.
        measure: Name of the measure.
        parts: Of the runs below each quantile, between 0 and 1.

    Raises:
        ValueError: The runs are no sample of a distribution, or none has a value.
    """
    from scipy.stats import quantile_test

    if table.head.design in (GRID, ONE_AT_A_TIME):
        raise ValueError(
            f'quantiles need a random design; the runs of "{table.head.design}" are no sample'
        )
    column = measure_of(table, measure)
    values = column.numbers[usable(table, column)]
    if not len(values):
        raise ValueError(f'no run has a value of "{measure}"')
    found: list[Quantile] = []
    for part in parts:
        test: Any = quantile_test(values, q=float(values[0]), p=part)
        low, high = test.confidence_interval(CONFIDENCE)
        found.append(Quantile(part, float(np.quantile(values, part)), float(low), float(high)))
    return tuple(found)
