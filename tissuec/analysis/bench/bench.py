"""The bench of a scene: time and error of every method, and the report on it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.analysis.bench.points import MeasuredPoint, MissingPoint, Tell, measure
from tissuec.analysis.bench.problem import BenchProblem
from tissuec.analysis.bench.solver import BenchSolver, EngineSolver
from tissuec.analysis.bench.truth import BestSolution, Judges, find_truth, no_judges
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.report import FactTable, Part, Report
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.network import Floats
from tissuec.script.plan import AUTOMATIC


class Rivals(NamedTuple):
    """Solvers of other libraries.

    Attributes:
        solvers: Return those that can solve a problem, and sentences about those that cannot.
        judges: Return those that can give a second opinion on the reference.
    """

    solvers: Callable[[BenchProblem, Floats], tuple[Sequence[BenchSolver], Sequence[str]]]
    judges: Judges


def _no_solvers(_: BenchProblem, __: Floats) -> tuple[tuple[()], tuple[()]]:
    return (), ()


NONE = Rivals(_no_solvers, no_judges)


class BenchResult(Struct, frozen=True, eq=False):
    """Results of a bench.

    Attributes:
        floor: How well the reference is known; errors below it mean nothing.
        points: Of all solvers.
        gaps: Missing points, each with the reason.
        left_out: Sentences on solvers that were left out.
    """

    problem: BenchProblem
    truth: BestSolution
    floor: float
    points: tuple[MeasuredPoint, ...]
    gaps: tuple[MissingPoint, ...]
    left_out: tuple[str, ...]


def bench(
    compiled: Compiled,
    *,
    methods: Sequence[str],
    tolerances: Sequence[float],
    repeat: int,
    budget: float,
    tell: Tell,
    rivals: Rivals = NONE,
) -> BenchResult:
    """Return the points of a scene.

    Args:
        compiled: The scene.
        methods: Names of solvers; all if empty.
        tolerances: In any order.
        repeat: Timed runs of each point.
        budget: Processor time that a run may take [s].
        tell: Called with a text about each task that begins.
        rivals: Solvers of other libraries.

    Raises:
        TissueError: A name is unknown, or there is no reference.
    """
    problem = BenchProblem.of(compiled)
    ordered = sorted(set(tolerances), reverse=True)
    ours: list[BenchSolver] = [
        EngineSolver(problem, name) for name in (AUTOMATIC, *INTEGRATORS)
    ]
    drawn = np.repeat(problem.network.position[None], len(problem.times), axis=0)
    # An unknown name is reported before the long work of a reference.
    chosen([*ours, *rivals.solvers(problem, drawn)[0]], methods)
    truth = find_truth(problem, ordered[-1], budget, tell=tell, judges=rivals.judges)
    others, left_out = rivals.solvers(problem, truth.position)
    solvers = chosen([*ours, *others], methods)
    points, gaps = measure(
        problem, solvers, ordered, truth.position, repeat=repeat, budget=budget, tell=tell
    )
    return BenchResult(
        problem, truth, truth.uncertainty(points), tuple(points), tuple(gaps), tuple(left_out)
    )


def chosen(solvers: Sequence[BenchSolver], names: Sequence[str]) -> list[BenchSolver]:
    """Return the solvers of some names, ignoring case; all of them without names.

    Raises:
        TissueError: A name is unknown.
    """
    known = {solver.name.lower(): solver for solver in solvers}
    for name in names:
        if name.lower() not in known:
            hint = alternatives(name, [solver.name for solver in solvers], what="solvers")
            raise TissueError(f'there is no solver "{name}" for this scene; {hint}')
    return [known[name.lower()] for name in names] if names else list(solvers)


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
    return Report([*parts, *([""] if remarks else []), *remarks], {**facts, **_document(bench)})


def _document(bench: BenchResult) -> dict[str, Any]:
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
