"""A bench as text and as plain data."""

from typing import Any

from tissuec.bench.bench import BenchResult
from tissuec.bench.points import MeasuredPoint
from tissuec.bench.ratios import Ratio
from tissuec.core.columns import aligned

POINTS = ("method", "tolerance", "error", "time", "evaluations")
RATIOS = ("error", "best other", "time", "automatic", "ratio", "best of ours", "time", "ratio")


def as_text(bench: BenchResult) -> list[str]:
    """Return tables and remarks, line by line."""
    network, truth = bench.problem.network, bench.truth
    lines = [
        f"{network.size}; "
        f"errors relative to {truth.method} with tolerance {truth.tolerance:g}, "
        f"accurate to {bench.floor:.1e}",
        "",
        *aligned([POINTS, *(_point(point, bench.floor) for point in bench.points)]),
    ]
    if rows := [_ratio(ratio) for ratio in bench.ratios()]:
        lines += [
            "",
            "times at the same error, and their ratio (time of the other solver / time of "
            "tissuec):",
        ]
        lines += aligned([RATIOS, *rows])
    remarks = [f"{gap.name} at {gap.tolerance:g}: {gap.why}" for gap in bench.gaps]
    return [*lines, *([""] if remarks or bench.left_out else []), *remarks, *bench.left_out]


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
        "ratios": [
            {
                "error": ratio.error,
                "automatic": ratio.ours,
                "best_ours": ratio.best_ours,
                "best_other": ratio.best_other,
                "ratio": ratio.gain,
            }
            for ratio in bench.ratios()
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


def _ratio(ratio: Ratio) -> tuple[str, ...]:
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
