"""Ratios of speed at equal error, interpolated between points on logarithmic axes."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import exp, log

from msgspec import Struct

from tissuec.analysis.bench import BenchResult, MeasuredPoint, seconds
from tissuec.core.report import FactTable, Part, Report
from tissuec.core.structs import replace
from tissuec.script.plan import AUTOMATIC

LEVELS = tuple(10.0**power for power in range(-2, -12, -1))
HEADS = ("error", "best other", "time", "automatic", "ratio", "best of ours", "time", "ratio")


class Ratio(Struct, frozen=True):
    """Times at one error [s]; None where no solver was measured to be that accurate.

    Attributes:
        ours: A method of the engine and its time.
        best_ours, best_other: The fastest of the engine's and of the others.
    """

    error: float
    ours: float | None
    best_ours: tuple[str, float] | None
    best_other: tuple[str, float] | None

    @property
    def gain(self) -> float | None:
        """Return the time of the best other solver over ours."""
        if self.ours is None or self.best_other is None:
            return None
        return self.best_other[1] / self.ours


def ratios(
    points: Sequence[MeasuredPoint], name: str, errors: Iterable[float], floor: float
) -> list[Ratio]:
    """Return how a method of the engine compares at some errors.

    Args:
        name: The method.
        floor: Error below which nothing is known.
    """
    ours = {p.name for p in points if p.ours}
    others = {p.name for p in points} - ours
    return [
        Ratio(
            error,
            time_at(points, name, error, floor),
            fastest(points, ours, error, floor),
            fastest(points, others, error, floor),
        )
        for error in errors
        if error >= floor
    ]


def fastest(
    points: Sequence[MeasuredPoint], names: Iterable[str], error: float, floor: float
) -> tuple[str, float] | None:
    """Return the solver that needs the least time for an error, and that time [s]."""
    times = {name: time_at(points, name, error, floor) for name in sorted(names)}
    known = {name: time for name, time in times.items() if time is not None}
    return min(known.items(), key=lambda item: item[1]) if known else None


def time_at(
    points: Sequence[MeasuredPoint], name: str, error: float, floor: float
) -> float | None:
    """Return the time that a solver needs for an error [s], None if it was never that accurate.

    Points that another point of the same solver beats in both time and error are ignored.
    """
    known = sorted((max(p.error, floor), p.seconds) for p in points if p.name == name)
    if not known or known[0][0] > error:
        return None
    edge: list[tuple[float, float]] = []
    for wrong, time in known:
        if not edge or time < edge[-1][1]:
            edge.append((wrong, time))
    for (fine, slow), (coarse, quick) in pairwise(edge):
        if fine <= error <= coarse:
            part = log(error / fine) / log(coarse / fine) if coarse > fine else 1.0
            return exp(log(slow) + part * log(quick / slow))
    return edge[-1][1]


def with_ratios(report: Report, found: BenchResult) -> Report:
    """Return the report on a bench with the ratios of ``automatic`` to the best others.

    Args:
        report: Without ratios.
        found: The bench.
    """
    known = ratios(found.points, AUTOMATIC, LEVELS, found.floor)
    known = [ratio for ratio in known if ratio.best_ours or ratio.best_other]
    document = [
        {
            "error": ratio.error,
            "automatic": ratio.ours,
            "best_ours": ratio.best_ours,
            "best_other": ratio.best_other,
            "ratio": ratio.gain,
        }
        for ratio in known
    ]
    text = (
        "times at the same error, and their ratio (time of the other solver / time of tissuec):"
    )
    parts: list[Part] = ["", text, FactTable(HEADS, [*map(_row, known)])] if known else []
    return replace(
        report, parts=[*report.parts, *parts], document=report.document | {"ratios": document}
    )


def _row(ratio: Ratio) -> tuple[str, ...]:
    other = ratio.best_other
    return (
        f"{ratio.error:g}",
        *(_named(other)),
        "-" if ratio.ours is None else seconds(ratio.ours),
        "-" if ratio.gain is None else f"{ratio.gain:.2g}",
        *(_named(ratio.best_ours)),
        _over(other, ratio.best_ours),
    )


def _named(found: tuple[str, float] | None) -> tuple[str, str]:
    return ("-", "-") if found is None else (found[0], seconds(found[1]))


def _over(other: tuple[str, float] | None, ours: tuple[str, float] | None) -> str:
    return "-" if other is None or ours is None else f"{other[1] / ours[1]:.2g}"
