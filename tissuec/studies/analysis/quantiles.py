"""Quantiles of a measure over the runs of a random design, with their intervals.

The interval of a quantile is free of assumptions about the distribution: it runs between two
order statistics, whose ranks follow from the binomial distribution (W. J. Conover, Practical
Nonparametric Statistics, 1999, 3.2; computed by ``scipy.stats.quantile_test``). It holds for
independent runs; runs of a latin hypercube or a Sobol sequence are spread more evenly.

Of the design "sobol indices", the blocks A and B are a sample of the factors; the other blocks
repeat their values and are not used.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.scene.study.entries import INDICES, LATIN, SOBOL
from tissuec.studies.analysis.completed import Answer, measure_of, values_of
from tissuec.studies.table import StudyTable, rows_of

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

    @property
    def has_interval(self) -> bool:
        """Return whether there are enough runs for both ends of the interval."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def fewest(self) -> int:
        """Return how many runs an interval needs at the least.

        Such that with enough confidence some run is on the rarer side of the quantile.
        """
        rare = min(self.part, 1.0 - self.part)
        return math.ceil(math.log(0.5 * (1.0 - CONFIDENCE)) / math.log1p(-rare))

    def __str__(self) -> str:
        interval = f"{self.low:.4g} to {self.high:.4g}" if self.has_interval else "no interval"
        return f"{self.value:.4g} ({interval})"


class Quantiles(Answer[Quantile], frozen=True, eq=False, kw_only=True):
    """Quantiles of a measure.

    Attributes:
        used: Number of runs that they are computed from.
    """

    used: int

    def lines(self) -> Iterator[str]:
        for one in self:
            yield f"{100 * one.part:g} % below {one} {self.unit}".rstrip()

    def remarks(self) -> Iterator[str]:
        lacking = [one for one in self if not one.has_interval]
        if lacking:
            few = ", ".join(f"{100 * one.part:g} % needs {one.fewest} runs" for one in lacking)
            yield f"no interval with {self.used} runs: {few}"


def quantiles(table: StudyTable, measure: str, parts: Sequence[float] = PARTS) -> Quantiles:
    """Return quantiles of a measure over the runs that finished.

    Args:
        measure: Name of the measure.
        parts: Of the runs below each quantile, between 0 and 1, both excluded.

    Raises:
        ValueError: The runs are no sample of a distribution, none has a value, or a part is not
            between 0 and 1.
    """
    from scipy.stats import quantile_test

    sample = sample_of(table)
    if wrong := [part for part in parts if not 0.0 < part < 1.0]:
        raise ValueError(
            f"a part of the runs is between 0 and 1, such as 0.5, not {wrong[0]:g}"
        )
    column = measure_of(sample, measure)
    values, left_out = values_of(sample, column)
    found: list[Quantile] = []
    for part in parts:
        test: Any = quantile_test(values, q=float(values[0]), p=part)
        low, high = test.confidence_interval(CONFIDENCE)
        found.append(Quantile(part, float(np.quantile(values, part)), float(low), float(high)))
    return Quantiles(
        measure=column.name, unit=column.unit, parts=tuple(found), left_out=left_out,
        used=len(values),
    )  # fmt: skip


def sample_of(table: StudyTable) -> StudyTable:
    """Return the runs of a table that are a sample of its factors.

    Raises:
        ValueError: Its values were chosen, not drawn.
    """
    design = table.head.design
    if design == INDICES:
        drawn = 2 * table.head.base
        rows = (row for row in rows_of(table) if row.run < drawn)
        return StudyTable.of(replace(table.head, planned=drawn), rows)
    if design in (LATIN, SOBOL):
        return table
    raise ValueError(
        f'quantiles need a random design ("{LATIN}", "{SOBOL}" or "{INDICES}"); the runs of '
        f'the design "{design}" are not a sample. For rows that were drawn elsewhere, use '
        "numpy.nanquantile on the numbers of the column"
    )
