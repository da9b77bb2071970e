"""Learnt numbers: one by one, or statistics of many."""

from collections.abc import Iterator, Sequence

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.report import Fact, FactSection, FactTable, Part
from tissuec.learn.fit.outcome import Estimates
from tissuec.learn.fit.shown import interval, percent, shown
from tissuec.model.network import Floats
from tissuec.script.fit_problem import START_POSITION, START_VELOCITY

HEADINGS = ("parameter", "before", "learned", "95 % interval", "change")
MANY = 12  # numbers of one entry, from which on only a summary is shown
WORST = 3  # of these, those that are known least


def numbers_of(estimates: Sequence[Estimates]) -> list[Part]:
    """Return a table of single numbers, followed by statistics of large groups."""
    rows = [row for one in estimates if len(one.names) < MANY for row in _rows(one)]
    many = [_summary(one) for one in estimates if len(one.names) >= MANY]
    return [*([FactTable(HEADINGS, rows)] if rows else []), *many]


def _rows(estimates: Estimates) -> Iterator[tuple[str, ...]]:
    for number, name in enumerate(estimates.names):
        yield (
            name,
            _shown(estimates, estimates.start[number]),
            _shown(estimates, estimates.value[number]),
            _interval(estimates, number),
            _change(estimates, number),
        )


def _shown(estimates: Estimates, value: float) -> str:
    adjust = estimates.adjust
    return shown(float(value), adjust.dimension, adjust.what)


def _interval(estimates: Estimates, number: int) -> str:
    """Return the interval of a number, or the remark that the data does not determine it."""
    if not estimates.identified[number]:
        return "not identified"
    adjust = estimates.adjust
    low, high = float(estimates.low[number]), float(estimates.high[number])
    return interval(low, high, adjust.dimension, adjust.what)


def _change(estimates: Estimates, number: int) -> str:
    """Return by which part a number changed; of places, velocities and what was 0, how far."""
    start, value = float(estimates.start[number]), float(estimates.value[number])
    what = estimates.adjust.what
    if start == 0.0 or what in (START_POSITION, START_VELOCITY):
        sign = "+" if value >= start else ""
        return sign + shown(value - start, estimates.adjust.dimension, what)
    return f"{100.0 * (value - start) / abs(start):+.3g} %"


# --- many numbers -----------------------------------------------------------------------------


def _summary(estimates: Estimates) -> FactSection:
    """Return statistics of many numbers, and those that are known least."""
    adjust, known = estimates.adjust, estimates.identified
    rows = [
        ("before", *_spread(estimates, estimates.start)),
        ("learnt", *_spread(estimates, estimates.value)),
    ]
    parts: list[Part] = [FactTable(("", "median", "quartiles", "range"), rows)]
    half = uncertainty(estimates)[known]
    if len(half):
        typical, most = float(np.median(half)), float(half.max())
        parts.append(f"accurate to {percent(typical)} (median), {percent(most)} (worst)")
    if not known.all():
        parts.append(f"not identified: {int((~known).sum())} of them")
    for number in _worst(estimates):
        value = _shown(estimates, estimates.value[number])
        name, interval = estimates.names[number], _interval(estimates, number)
        parts.append(Fact("least accurate", f"{name}: {value} ({interval})"))
    count = counted(len(known), "parameter")
    title = f"{adjust.what} per {adjust.per} of {adjust.of}: {count}"
    return FactSection(title, parts, apart=False)


def _spread(estimates: Estimates, values: Floats) -> tuple[str, str, str]:
    low, first, middle, last, high = np.quantile(values, [0.0, 0.25, 0.5, 0.75, 1.0])
    return (
        _shown(estimates, middle),
        f"{_shown(estimates, first)} to {_shown(estimates, last)}",
        f"{_shown(estimates, low)} to {_shown(estimates, high)}",
    )


def uncertainty(estimates: Estimates) -> Floats:
    """Return half the width of each interval divided by its value, dimensionless.

    It is infinite where the data does not identify a number, or where it is 0; shape (number,).
    """
    size = np.abs(estimates.value)
    width = (estimates.high - estimates.low) / 2.0
    found = np.full(len(size), np.inf)
    told = estimates.identified & (size > 0.0) & np.isfinite(width)
    found[told] = width[told] / size[told]
    return found


def _worst(estimates: Estimates) -> list[int]:
    order = np.argsort(-uncertainty(estimates), kind="stable")
    return order[:WORST].tolist()
