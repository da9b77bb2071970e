"""The report on a bench."""

from collections.abc import Mapping
from typing import Any

from tissuec.bench.bench import BenchResult
from tissuec.bench.points import MeasuredPoint
from tissuec.core.report import FactTable, Part, Report

POINTS = ("method", "tolerance", "error", "time", "evaluations")


def bench_report(bench: BenchResult, facts: Mapping[str, Any]) -> Report:
    """Return the report on a bench.

    Args:
        bench: The points.
        facts: Further facts for programs.
    """
    network, truth = bench.problem.network, bench.truth
    points = [_point(point, bench.floor) for point in bench.points]
    parts: list[Part] = [
        f"{network.size}; "
        f"errors relative to {truth.method} with tolerance {truth.tolerance:g}, "
        f"accurate to {bench.floor:.1e}",
        "",
        FactTable(POINTS, points),
    ]
    remarks = [f"{gap.name} at {gap.tolerance:g}: {gap.why}" for gap in bench.gaps]
    remarks += bench.left_out
    return Report([*parts, *([""] if remarks else []), *remarks], {**facts, **as_dict(bench)})


def as_dict(bench: BenchResult) -> dict[str, Any]:
    """Return all numbers, in SI units."""
    network, truth = bench.problem.network, bench.truth
    return {
        **network.size.facts,
        "reference": {
            "method": truth.method,
            "tolerance": truth.tolerance,
            "uncertainty": bench.floor,
        },
        "points": [
            {
                "method": p.name,
                "ours": p.ours,
                "tolerance": p.tolerance,
                "error": p.error,
                "seconds": p.seconds,
                "evaluations": p.evaluations,
            }
            for p in bench.points
        ],
        "gaps": [
            {"method": gap.name, "tolerance": gap.tolerance, "why": gap.why}
            for gap in bench.gaps
        ],
        "left_out": list(bench.left_out),
    }


def seconds(value: float) -> str:
    """Return a time with three digits and a unit that suits it."""
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def _point(point: MeasuredPoint, floor: float) -> tuple[str, ...]:
    error = f"{point.error:.1e}" if point.error > floor else f"< {floor:.1e}"
    time = seconds(point.seconds)
    return point.name, f"{point.tolerance:g}", error, time, str(point.evaluations)
