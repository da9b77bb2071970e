"""Sobol indices: which part of the variance of a measure comes from which factor.

With f(A), f(B) and f(AB_i) the measure in runs with independent values A and B, and with those
of A but for factor i from B, and with the mean of f(A) and f(B) taken off:

    first order  S_i = mean(f(B) (f(AB_i) - f(A))) / V
    total        T_i = mean((f(A) - f(AB_i))²) / 2 V,   V the variance of f(A) and f(B)

(A. Saltelli et al., Computer Physics Communications 181, 2010, 259-270; these are the formulas
of ``scipy.stats.sobol_indices``, which accepts base numbers that are powers of two only, and so
no study with runs that failed.) Intervals are bias-corrected and accelerated bootstrap
intervals over the rows of A, B and all AB_i together.
"""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.model.network import Floats
from tissuec.scene.study_entries import INDICES
from tissuec.studies.analysis.samples import measure_of, usable
from tissuec.studies.table import StudyTable

CONFIDENCE = 0.95
RESAMPLES = 999
FEWEST = 4  # base runs

Interval = tuple[float, float]


class SobolIndex(Struct, frozen=True):
    """The indices of a factor, dimensionless.

    Attributes:
        factor: Name of the factor.
        first: Part of the variance by this factor alone.
        total: The same with its interactions with other factors.
        first_interval, total_interval: Confidence intervals.
    """

    factor: str
    first: float
    first_interval: Interval
    total: float
    total_interval: Interval


class SobolIndices(Struct, frozen=True):
    """The indices of all factors of a study for a measure.

    Attributes:
        measure: Name of the measure.
        factors: In the order of the table.
        used: Base runs that the indices are computed from.
        left_out: Base runs left out, because one of their runs failed or has no value.
        confidence: Level of the intervals, such as 0.95.
    """

    measure: str
    factors: tuple[SobolIndex, ...]
    used: int
    left_out: int
    confidence: float = CONFIDENCE

    def __iter__(self) -> Iterator[SobolIndex]:  # pyright: ignore[reportIncompatibleMethodOverride]  # Struct has none
        return iter(self.factors)


def sobol_indices(table: StudyTable, measure: str) -> SobolIndices:
    """Return first-order and total indices of a study with the design "sobol indices".

    Args:
        table: The table.
        measure: Name of the measure.

    Raises:
        ValueError: The study has another design, too few of its runs have a value, or the
            measure does not vary.
    """
    if table.head.design != INDICES:
        raise ValueError(
            f'Sobol indices need the design "{INDICES}"; this study has "{table.head.design}"'
        )
    values = _blocks(table, measure)
    complete = np.isfinite(values).all(axis=0)
    used = int(complete.sum())
    if used < FEWEST:
        raise ValueError(
            f'only {used} of {table.head.base} base runs have all values of "{measure}"; '
            f"at least {FEWEST} are needed"
        )
    known = values[:, complete]
    if not np.ptp(known[:2]) > 0.0:
        raise ValueError(f'"{measure}" has the same value in all runs')
    firsts, totals = _estimates(known)
    low, high = _intervals(known, table.head.seed)
    count = len(table.factors)
    factors = (
        SobolIndex(
            factor.name,
            float(firsts[n]),
            (float(low[n]), float(high[n])),
            float(totals[n]),
            (float(low[count + n]), float(high[count + n])),
        )
        for n, factor in enumerate(table.factors)
    )
    return SobolIndices(measure, tuple(factors), used, table.head.base - used)


def _blocks(table: StudyTable, measure: str) -> Floats:
    """Return the values of A, B and each AB_i, NaN where there is none, (factor + 2, base)."""
    column, base = measure_of(table, measure), table.head.base
    there = usable(table, column)
    values = np.full((len(table.factors) + 2) * base, np.nan)
    values[table.runs[there]] = column.numbers[there]
    return values.reshape(-1, base)


def _estimates(values: Floats) -> tuple[Floats, Floats]:
    """Return first-order and total indices, shape (factor, …).

    Args:
        values: Of A, B and each AB_i, shape (factor + 2, …, base).
    """
    both = np.concatenate([values[0], values[1]], axis=-1)
    variance = both.var(axis=-1)
    a, b, *mixed = values - both.mean(axis=-1)[..., None]
    firsts = [np.mean(b * (one - a), axis=-1) / variance for one in mixed]
    totals = [0.5 * np.mean((a - one) ** 2, axis=-1) / variance for one in mixed]
    return np.array(firsts), np.array(totals)


def _intervals(values: Floats, seed: int) -> tuple[Floats, Floats]:
    """Return the ends of the intervals of first-order, then total indices, shape (2 factor,).

    Args:
        values: As in ``_estimates``, shape (factor + 2, base).
        seed: Of the resampling.
    """
    from scipy import stats

    def statistic(rows: Any, axis: int = -1) -> Floats:
        return np.concatenate(_estimates(values[:, rows]))

    rows = (np.arange(values.shape[1]),)
    with warnings.catch_warnings():
        # A factor without any effect has the index 0 in every resample.
        warnings.simplefilter("ignore")
        # One resample at a time in memory for 1e6 values; SciPy 1.15 has renamed the seed.
        found: Any = stats.bootstrap(
            rows,
            statistic,
            vectorized=True,
            n_resamples=RESAMPLES,
            confidence_level=CONFIDENCE,
            batch=max(1, 4_000_000 // values.size),
            method="BCa",
            random_state=np.random.default_rng(seed),
        )
    ends = found.confidence_interval
    exact = np.concatenate(_estimates(values))
    low, high = (np.where(np.isnan(end), exact, end) for end in (ends.low, ends.high))
    return low, high
