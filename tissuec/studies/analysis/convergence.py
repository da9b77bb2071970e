"""Observed orders of convergence: how fast a measure settles while a study refines something.

Of three levels h₁ > h₂ > h₃ with the values f₁, f₂, f₃, the order p is that of f = f₀ + C hᵖ:

    (h₁ᵖ - h₂ᵖ) / (h₂ᵖ - h₃ᵖ) = (f₁ - f₂) / (f₂ - f₃),   f₀ = f₃ + (f₃ - f₂) / ((h₂/h₃)ᵖ - 1)

(L. F. Richardson, Philosophical Transactions of the Royal Society A 210, 1911, 307-357; P. J.
Roache, Verification and Validation in Computational Science and Engineering, 1998.)
"""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, isfinite, log, nan

import numpy as np
from msgspec import Struct

from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.model.network import Floats
from tissuec.scene.study.entries import GRID
from tissuec.studies.analysis.completed import Answer, completed, lack_of, measure_of
from tissuec.studies.table import Column, StudyTable

SMALLEST, LARGEST = 1e-3, 30.0  # orders that are looked for
ROUNDING = 100 * float(np.finfo(float).eps)  # differences that say nothing, relative
REFINED = ("tolerance", "step", "cell")  # factors that are refined, if there are several
_NUMBERS = ("level", "value")


class ObservedOrder(Struct, frozen=True, eq=False):
    """How a measure converges while a factor is refined and all others stay.

    Attributes:
        fixed: The values of the other factors, as texts with units.
        levels: Values of the refined factor from coarse to fine, shape (level,).
        values: Of the measure, in its unit, shape (level,); NaN where its run is left out.
        orders: Of every three successive levels, shape (level - 2,); NaN where one of them has
            no value, or differences do not shrink, change their sign or are rounding errors.
        limit: Value at perfect resolution by the finest three levels that have an order, in
            the unit of the measure; NaN if there are none.
        gaps: The levels without a value, with the reason.
    """

    fixed: tuple[str, ...]
    levels: Floats
    values: Floats
    orders: Floats
    limit: float
    gaps: tuple[str, ...] = ()

    @property
    def order(self) -> float:
        """Return the order of the three finest levels that have one; NaN if there are none."""
        known = self.orders[np.isfinite(self.orders)]
        return float(known[-1]) if len(known) else nan

    @property
    def name(self) -> str:
        """Return the values of the other factors; "" if there are none."""
        return ", ".join(self.fixed)

    def __str__(self) -> str:
        order = f"order {self.order:.2f}" if isfinite(self.order) else "no order"
        return f"{self.name}: {order}" if self.fixed else order


class ObservedOrders(Answer[ObservedOrder], frozen=True, eq=False, kw_only=True):
    """The observed order for each combination of the other factors.

    Attributes:
        refined: Name of the refined factor.
    """

    refined: str

    def lines(self) -> Iterator[str]:
        for one in self:
            limit = f"; limit {one.limit:.6g} {self.unit}" if isfinite(one.limit) else ""
            yield f"{one}{limit}".rstrip()

    def remarks(self) -> Iterator[str]:
        for one in self:
            yield from (f"{one.name}, {gap}" if one.fixed else gap for gap in one.gaps)


def orders(table: StudyTable, measure: str, along: str | None = None) -> ObservedOrders:
    """Return the observed order for each combination of the other factors.

    Args:
        measure: Name of the measure.
        along: Name of the refined factor; by default the only one with numbers, or the only
            one called tolerance, step or cell. Numbers without a unit from 1 on count
            divisions, and are refined upwards; all others downwards.

    Raises:
        ValueError: There is no such factor, or no combination has three levels.
    """
    column, refined = measure_of(table, measure), refined_factor(table, along)
    found = completed(table, column)
    values = dict(zip(found.rows.tolist(), column.numbers[found.rows].tolist(), strict=True))
    parts = [
        _observed(fixed, refined, [_Level.of(table, n, row, values) for n, row in rows.items()])
        for fixed, rows in _combinations(table, refined).items()
        if len(rows) >= 3
    ]
    if not parts:
        raise ValueError(
            f'an order needs three values of "{refined.name}" with all other factors the same'
        )
    return ObservedOrders(
        measure=column.name, unit=column.unit, parts=tuple(parts),
        left_out=found.left_out, refined=refined.name,
    )  # fmt: skip


def _combinations(
    table: StudyTable, refined: Column
) -> dict[tuple[str, ...], dict[float, int | None]]:
    """Return the rows of all levels for each combination of the other factors.

    A level of a grid that is not done yet has no row.
    """
    others = [factor for factor in table.factors if factor is not refined]
    is_grid = table.head.design == GRID
    known: list[float] = np.unique(refined.numbers).tolist() if is_grid else []
    found: dict[tuple[str, ...], dict[float, int | None]] = {}
    for row, level in enumerate(refined.numbers.tolist()):
        fixed = tuple(factor.text(row) for factor in others)
        rows = found.setdefault(fixed, dict.fromkeys(known))
        if isfinite(level):
            rows[level] = row
    return found


class _Level(Struct, frozen=True):
    """A level of a refinement: its size, the value there, or why there is none."""

    level: float
    value: float
    lack: str

    @classmethod
    def of(
        cls, table: StudyTable, level: float, row: int | None, values: Mapping[int, float]
    ) -> "_Level":
        """Return a level by its row, if there is one."""
        if row is None:
            return cls(level, nan, "not done yet")
        return cls(level, values.get(row, nan), "" if row in values else lack_of(table, row))


def refined_factor(table: StudyTable, along: str | None = None) -> Column:
    """Return the factor that a study refines.

    Args:
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


def _observed(
    fixed: tuple[str, ...], refined: Column, found: Sequence[_Level]
) -> ObservedOrder:
    """Return how a measure converges in one combination."""
    counts_divisions = not refined.unit and min(one.level for one in found) >= 1.0
    ordered = sorted(found, key=lambda one: one.level, reverse=not counts_divisions)
    levels, values = (np.array([getattr(one, name) for one in ordered]) for name in _NUMBERS)
    sizes = 1.0 / levels if counts_divisions else levels
    triples = [slice(n, n + 3) for n in range(len(sizes) - 2)]
    known = [order_of(sizes[three], values[three]) for three in triples]
    limits = [
        _limit(sizes[three], values[three], order)
        for three, order in zip(triples, known, strict=True)
        if isfinite(order)
    ]
    gaps = (f"{refined.name} {refined.written(o.level)}: {o.lack}" for o in ordered if o.lack)
    limit = limits[-1] if limits else nan
    return ObservedOrder(fixed, levels, values, np.array(known), limit, tuple(gaps))


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
