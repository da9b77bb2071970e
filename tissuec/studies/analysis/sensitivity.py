"""Which factors a measure depends on: Sobol indices, and effects of one factor at a time.

With f(A), f(B) and f(AB_i) the measure in runs with independent values A and B, and with those
of A but for factor i from B, and with the mean of f(A) and f(B) taken off:

    first order  S_i = mean(f(B) (f(AB_i) - f(A))) / V
    total        T_i = mean((f(A) - f(AB_i))²) / 2 V,   V the variance of f(A) and f(B)

(A. Saltelli et al., Computer Physics Communications 181, 2010, 259-270; these are the formulas
of ``scipy.stats.sobol_indices``, which accepts base numbers that are powers of two only, and so
no study with runs that failed.) Intervals are bias-corrected and accelerated bootstrap
intervals over the rows of A, B and all AB_i together.
"""

import threading
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.model.network import Floats
from tissuec.scene.study.entries import INDICES, ONE_AT_A_TIME
from tissuec.studies.analysis.completed import Answer, completed, lack_of, measure_of
from tissuec.studies.table import Column, StudyTable

CONFIDENCE = 0.95
RESAMPLES = 999
FEWEST = 4  # base runs
_FILTERS = threading.Lock()

Interval = tuple[float, float]


class SobolIndex(Struct, frozen=True):
    """The indices of a factor, dimensionless.

    Attributes:
        factor: Name of the factor.
        first: Part of the variance by this factor alone.
        total: The same with its interactions with other factors.
        first_interval, total_interval: Confidence intervals; None where all resamples have the
            same index, as that of a factor which changes nothing.
    """

    factor: str
    first: float
    first_interval: Interval | None
    total: float
    total_interval: Interval | None

    @property
    def has_intervals(self) -> bool:
        """Return whether both indices have an interval."""
        return self.first_interval is not None and self.total_interval is not None


class SobolIndices(Answer[SobolIndex], frozen=True, eq=False, kw_only=True):
    """The indices of all factors of a study, in the order of the table.

    Attributes:
        base: Base runs of the study.
        used: Base runs that the indices are computed from: those of which no run is left out.
        confidence: Level of the intervals, such as 0.95.
    """

    base: int
    used: int
    confidence: float = CONFIDENCE

    def lines(self) -> Sequence[str]:
        return [
            f"{one.factor}: first order {one.first:.3f} ({ends(one.first_interval)}), "
            f"total {one.total:.3f} ({ends(one.total_interval)})"
            for one in self.parts
        ]

    def remarks(self) -> Iterator[str]:
        if self.used < self.base:
            yield f"{self.used} of {self.base} base runs are used: those with all values"
        if bare := [one.factor for one in self.parts if not one.has_intervals]:
            yield (
                f"no interval for {', '.join(bare)}: all resamples are equal, because nothing "
                f"changes with the factor in these {self.used} base runs"
            )


def ends(interval: Interval | None) -> str:
    """Return an interval in words."""
    return "no interval" if interval is None else f"{interval[0]:.3f} to {interval[1]:.3f}"


def sobol_indices(table: StudyTable, measure: str) -> SobolIndices:
    """Return first-order and total indices of a study with the design "sobol indices".

    Args:
        measure: Name of the measure.

    Raises:
        ValueError: The study has another design, too few of its runs have a value, or the
            measure does not vary.
    """
    if table.head.design != INDICES:
        raise ValueError(
            f'Sobol indices need the design "{INDICES}"; this study has "{table.head.design}"'
        )
    column, base = measure_of(table, measure), table.head.base
    found = completed(table, column)
    values = _blocks(table, column, found.rows)
    known = values[:, np.isfinite(values).all(axis=0)]
    used = known.shape[1]
    if used < FEWEST:
        raise ValueError(
            f'only {used} of {base} base runs have all values of "{measure}"; at least '
            f"{FEWEST} are needed ({found.left_out})"
        )
    if not np.ptp(known[:2]) > 0.0:
        raise ValueError(f'"{measure}" has the same value in all runs')
    firsts, totals = _estimates(known)
    intervals = _intervals(known, table.head.seed)
    count = len(table.factors)
    parts = (
        SobolIndex(
            factor.name, float(firsts[n]), intervals[n], float(totals[n]), intervals[count + n]
        )
        for n, factor in enumerate(table.factors)
    )
    return SobolIndices(
        measure=column.name, unit="", parts=tuple(parts), left_out=found.left_out, base=base,
        used=used,
    )  # fmt: skip


def _blocks(table: StudyTable, column: Column, rows: Any) -> Floats:
    """Return the values of A, B and each AB_i, NaN where there is none, (factor + 2, base)."""
    values = np.full((len(table.factors) + 2) * table.head.base, np.nan)
    values[table.runs[rows]] = column.numbers[rows]
    return values.reshape(-1, table.head.base)


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


def _intervals(values: Floats, seed: int) -> list[Interval | None]:
    """Return the intervals of all first-order, then of all total indices.

    Args:
        values: As in ``_estimates``, shape (factor + 2, base).
        seed: Of the resampling.
    """
    from scipy import stats

    def statistic(rows: Any, axis: int = -1) -> Floats:
        return np.concatenate(_estimates(values[:, rows]))

    rows: Any = (np.arange(values.shape[1]),)
    # Where all resamples are equal, which is reported below. Filters belong to the process: two
    # threads that restore them in the wrong order would leave them changed.
    with _FILTERS, warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        # One resample at a time in memory for 1e6 values; SciPy 1.15 has renamed the seed.
        bootstrap: Any = stats.bootstrap
        found = bootstrap(
            rows,
            statistic,
            vectorized=True,
            n_resamples=RESAMPLES,
            confidence_level=CONFIDENCE,
            batch=max(1, 4_000_000 // values.size),
            method="BCa",
            random_state=np.random.default_rng(seed),
        )
    low, high = found.confidence_interval
    return list(map(_interval, low.tolist(), high.tolist(), found.bootstrap_distribution))


def _interval(low: float, high: float, resampled: Floats) -> Interval | None:
    """Return an interval; that of the percentiles where there is no better one.

    Args:
        low, high: Its ends; NaN where they cannot be corrected.
        resampled: The index of each resample, shape (resample,).
    """
    if not np.ptp(resampled) > 0.0:
        return None
    if not np.isfinite([low, high]).all():
        rest = 0.5 * (1.0 - CONFIDENCE)
        low, high = np.quantile(resampled, [rest, 1.0 - rest])
    return float(low), float(high)


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
