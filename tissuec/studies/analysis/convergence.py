"""Observed orders of convergence: how fast a measure settles while a study refines something.

Of three levels h₁ > h₂ > h₃ with the values f₁, f₂, f₃, the order p is that of f = f₀ + C hᵖ:

    (h₁ᵖ - h₂ᵖ) / (h₂ᵖ - h₃ᵖ) = (f₁ - f₂) / (f₂ - f₃),   f₀ = f₃ + (f₃ - f₂) / ((h₂/h₃)ᵖ - 1)

(L. F. Richardson, Philosophical Transactions of the Royal Society A 210, 1911, 307-357; P. J.
Roache, Verification and Validation in Computational Science and Engineering, 1998.)
"""

from collections.abc import Sequence
from math import inf, log, nan

import numpy as np
from msgspec import Struct

from tissuec.core.errors import alternatives
from tissuec.core.names import key_of
from tissuec.model.network import Floats
from tissuec.studies.analysis.samples import measure_of, usable
from tissuec.studies.table import Column, StudyTable

SMALLEST, LARGEST = 1e-3, 30.0  # orders that are looked for
ROUNDING = 100 * float(np.finfo(float).eps)  # differences that say nothing, relative
REFINED = ("tolerance", "step", "cell")  # factors that are refined, if there are several


class ObservedOrder(Struct, frozen=True, eq=False):
    """How a measure converges while a factor is refined and all others stay.

    Attributes:
        fixed: The values of the other factors, as texts with units.
        levels: Values of the refined factor from coarse to fine, shape (level,).
        values: Of the measure, in its unit, shape (level,).
        orders: Of every three successive levels, shape (level - 2,); NaN where differences do
            not shrink, change their sign or are rounding errors.
        limit: Value at perfect resolution by the three finest levels, in the unit of the
            measure; NaN if they have no order.
    """

    fixed: tuple[str, ...]
    levels: Floats
    values: Floats
    orders: Floats
    limit: float

    @property
    def order(self) -> float:
        """Return the order of the three finest levels that have one; NaN if there are none."""
        known = self.orders[np.isfinite(self.orders)]
        return float(known[-1]) if len(known) else nan


def orders(
    table: StudyTable, measure: str, along: str | None = None
) -> tuple[ObservedOrder, ...]:
    """Return the observed order for each combination of the other factors.

    Args:
        table: The table.
        measure: Name of the measure.
        along: Name of the refined factor; by default the only one with numbers, or the only
            one called tolerance, step or cell. Numbers without a unit from 1 on count
            divisions, and are refined upwards; all others downwards.

    Raises:
        ValueError: There is no such factor, or no combination has three levels.
    """
    column, refined = measure_of(table, measure), refined_factor(table, along)
    others = [factor for factor in table.factors if factor is not refined]
    there = usable(table, column)
    groups: dict[tuple[str, ...], list[int]] = {}
    for row in np.flatnonzero(there).tolist():
        groups.setdefault(tuple(label(factor, row) for factor in others), []).append(row)
    found = [
        _observed(fixed, refined, rows, column.numbers[rows])
        for fixed, rows in groups.items()
        if len(set(refined.numbers[rows])) >= 3
    ]
    if not found:
        raise ValueError(
            f'an order needs three values of "{refined.name}" with all other factors the same'
        )
    return tuple(found)


def refined_factor(table: StudyTable, along: str | None = None) -> Column:
    """Return the factor that a study refines.

    Args:
        table: The table.
        along: Its name, if it is given.

    Raises:
        ValueError: There is none, or there are several.
    """
    numeric = [one for one in table.factors if not isinstance(one.values, tuple)]
    names = [factor.name for factor in numeric]
    if along is not None:
        for factor in numeric:
            if key_of(factor.name) == key_of(along):
                return factor
        hint = alternatives(along, names, what="there are") or "there are none"
        raise ValueError(f'the table has no factor "{along}" with numbers; {hint}')
    named = [one for one in numeric if key_of(one.name).split(" of ")[0] in REFINED]
    chosen = named if len(named) == 1 else numeric
    if len(chosen) != 1:
        raise ValueError(f"name the factor that is refined, one of: {', '.join(names)}")
    return chosen[0]


def label(factor: Column, row: int) -> str:
    """Return a value of a factor with its unit."""
    value = factor.values[row]
    return value if isinstance(value, str) else f"{value:g} {factor.unit}".rstrip()


def _observed(
    fixed: tuple[str, ...], refined: Column, rows: list[int], values: Floats
) -> ObservedOrder:
    levels = refined.numbers[rows]
    counts_divisions = not refined.unit and bool((levels >= 1.0).all())
    sizes = 1.0 / levels if counts_divisions else levels
    order = np.argsort(-sizes, kind="stable")
    sizes, values = sizes[order], values[order]
    found = np.array(
        [order_of(sizes[n : n + 3], values[n : n + 3]) for n in range(len(sizes) - 2)]
    )
    return ObservedOrder(fixed, levels[order], values, found, _limit(sizes, values, found[-1]))


def order_of(sizes: Sequence[float] | Floats, values: Sequence[float] | Floats) -> float:
    """Return the order of three values from coarse to fine; NaN if they have none.

    Args:
        sizes: h of each, shape (3,), in the same unit.
        values: f of each, shape (3,), in the same unit.
    """
    from scipy.optimize import brentq

    h = [float(size) / float(sizes[0]) for size in sizes]
    coarse, fine = float(values[0] - values[1]), float(values[1] - values[2])
    ratio = coarse / fine if fine else inf
    if not (0.0 < ratio < inf) or not h[0] > h[1] > h[2] > 0.0:
        return nan
    if abs(fine) < ROUNDING * abs(values[2]):
        return nan

    def excess(p: float) -> float:
        return log((h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p)) - log(ratio)

    if excess(SMALLEST) > 0.0 or excess(LARGEST) < 0.0:
        return nan
    return float(brentq(excess, SMALLEST, LARGEST, xtol=1e-10))


def _limit(sizes: Floats, values: Floats, order: float) -> float:
    gain = (sizes[-2] / sizes[-1]) ** order - 1.0
    return float(values[-1] + (values[-1] - values[-2]) / gain)
