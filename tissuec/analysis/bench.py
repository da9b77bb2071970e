"""The bench of a scene: run time against error, for every method, and the report on it.

Shared arguments:
    problem: The scene of the bench.
    points: Measured points.
    tolerance: Relative error that a solver is to keep, dimensionless.
    deadline: Time limit.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import inf
from statistics import median
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.analysis.bench_solvers import (
    BenchProblem,
    BenchSolver,
    Deadline,
    EngineSolver,
    OutOfTime,
    SolverFailed,
    SolverRun,
)
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError, counted
from tissuec.core.hints import alternatives
from tissuec.core.report import FactTable, Part, Report
from tissuec.core.structs import replace
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.network import Floats
from tissuec.script.plan import AUTOMATIC

Tell = Callable[[str], None]


class MeasuredPoint(Struct, frozen=True, eq=False):
    """A solver at a tolerance.

    Attributes:
        error: Largest error of a position, as a tolerance counts it.
        seconds: Median time of the processor [s].
        evaluations: Of the forces.
        position: [m], shape (row, node, 3).
    """

    name: str
    ours: bool
    tolerance: float
    error: float
    seconds: float
    evaluations: int
    position: Floats


class MissingPoint(Struct, frozen=True):
    """A solver without a point at a tolerance, and why."""

    name: str
    tolerance: float
    why: str


def measure(
    problem: BenchProblem,
    solvers: Sequence[BenchSolver],
    tolerances: Sequence[float],
    truth: Floats,
    *,
    repeat: int,
    budget: float,
    tell: Tell,
) -> tuple[list[MeasuredPoint], list[MissingPoint]]:
    """Return the points that could be measured, and why others could not.

    Each point is run once untimed, so that no time includes a compilation; then all points take
    turns, so that a slow phase of the machine affects all alike.

    Args:
        tolerances: Coarse to fine.
        truth: Positions that errors are measured against [m], shape (row, node, 3).
        repeat: Timed runs of each point.
        budget: Processor time that a run may take [s].
        tell: Called with a text about each task that begins.
    """
    found: dict[tuple[int, float], SolverRun] = {}
    gaps: list[MissingPoint] = []
    for number, solver in enumerate(solvers):
        tell(f"{solver.name} …")
        for tolerance, outcome in _explore(solver, tolerances, budget):
            tell(f"  {tolerance:g}: {_brief(outcome)}")
            if isinstance(outcome, SolverRun):
                found[number, tolerance] = outcome
            elif (outcome.name, outcome.why) not in {(gap.name, gap.why) for gap in gaps}:
                gaps.append(outcome)
    seconds: dict[tuple[int, float], list[float]] = {key: [] for key in found}
    for turn in range(repeat):
        for number, tolerance in found:
            name = solvers[number].name
            tell(f"timing {turn + 1} of {repeat}: {name} at {tolerance:g} …")
            # What took its time once may take it again, also in a slow moment.
            trial = solvers[number].solve(tolerance, Deadline(inf))
            seconds[number, tolerance].append(trial.seconds)
    points = [
        MeasuredPoint(
            name=solvers[number].name,
            ours=solvers[number].ours,
            tolerance=tolerance,
            error=problem.error(trial.position, truth),
            seconds=median(seconds[number, tolerance]),
            evaluations=trial.evaluations,
            position=trial.position,
        )
        for (number, tolerance), trial in found.items()
    ]
    return points, gaps


def _explore(
    solver: BenchSolver, tolerances: Sequence[float], budget: float
) -> Iterator[tuple[float, SolverRun | MissingPoint]]:
    """Run a solver from coarse to fine until it takes too long; yield what came of it."""
    for tolerance in tolerances:
        try:
            yield tolerance, _twice(solver, tolerance, budget)
        except OutOfTime:
            why = f"takes more than {budget:g} s; finer tolerances would take longer"
            yield tolerance, MissingPoint(solver.name, tolerance, why)
            return
        except SolverFailed as failure:
            yield tolerance, MissingPoint(solver.name, tolerance, str(failure))


def _brief(outcome: SolverRun | MissingPoint) -> str:
    """Return the outcome of a run, in a few words."""
    if isinstance(outcome, MissingPoint):
        return outcome.why
    return f"{outcome.seconds:.3g} s, {counted(outcome.evaluations, 'evaluation')}"


def _twice(solver: BenchSolver, tolerance: float, budget: float) -> SolverRun:
    """Return a run; tried again if it took too long, perhaps by compiling."""
    try:
        return solver.solve(tolerance, Deadline(budget))
    except OutOfTime:
        return solver.solve(tolerance, Deadline(budget))


METHODS = ("dop853", "esdirk43")
FINER = 100.0  # times as fine as the finest requested tolerance
PATIENCE = 30.0  # budgets of a point that the reference may take
SECOND = 3.0  # the same for each solver that may give a second opinion
FIRST = 0.03  # of the time that a solver may take, it gets for its first attempt
MORE = 6.0  # times as much for the next one
FINEST = 1e-12

#: Return other solvers that can give a second opinion on a problem with these positions.
Judges = Callable[[BenchProblem, Floats], Sequence[BenchSolver]]


def no_judges(_: BenchProblem, __: Floats) -> tuple[()]:
    """Return no solvers."""
    return ()


class Unknown(TissueError):
    """No solution came out that anything could be measured against."""


class BestSolution(Struct, frozen=True, eq=False):
    """A solution.

    Attributes:
        method, tolerance: How it was found.
        position: [m], shape (row, node, 3).
        second: Name of another solver that came to the end as well; empty if none did.
        apart: Largest difference between both, as a tolerance counts errors.
    """

    method: str
    tolerance: float
    position: Floats
    second: str = ""
    apart: float = inf

    def uncertainty(self, points: Iterable[MeasuredPoint]) -> float:
        """Return how far the nearest solution by any other solver is from this one."""
        others = (p for p in points if p.name not in (self.method, AUTOMATIC))
        return min([self.apart, *(point.error for point in others)])


def find_truth(
    problem: BenchProblem,
    finest: float,
    budget: float,
    patience: float = PATIENCE,
    tell: Tell = lambda text: None,
    judges: Judges = no_judges,
) -> BestSolution:
    """Return the solution of the first method that reaches the end, and a second solution.

    The second is by another solver, or by the other method where there is no such solver.

    Args:
        finest: Finest tolerance of the bench.
        budget: Processor time for one point [s].
        patience: How many of these times a solution may take.
        tell: Called with a text about each task that begins.
        judges: Other solvers.

    Raises:
        Unknown: No method reached the end.
    """
    tolerance = max(finest / FINER, FINEST)
    second_budget, budget = min(SECOND, patience) * budget, patience * budget
    ours = [EngineSolver(problem, method) for method in METHODS]
    solver, trial = _first(ours, tolerance, budget, tell)
    if solver is None or trial is None:
        raise Unknown(
            f"no reference with a tolerance of {tolerance:g} could be computed in time"
        )
    truth = BestSolution(solver.name, tolerance, trial.position)
    if others := judges(problem, trial.position):
        tolerance /= FINER
    others = others or [other for other in ours if other is not solver]
    judge, second = _first(others, tolerance, second_budget, tell)
    if judge is None or second is None:
        return truth
    apart = problem.error(second.position, trial.position)
    return replace(truth, second=judge.name, apart=apart)


def _first(
    solvers: Sequence[BenchSolver], tolerance: float, budget: float, tell: Tell
) -> tuple[BenchSolver | None, SolverRun | None]:
    """Return the first solver that comes to the end, with its run.

    They take turns with more and more time, because on stiff scenes the one that is quick
    elsewhere would use up all of it.
    """
    left, share = list(solvers), FIRST
    while left:
        share = min(share, 1.0)
        for solver in tuple(left):
            seconds = share * budget
            tell(f"reference: {solver.name} at {tolerance:g}, for up to {seconds:.3g} s …")
            try:
                return solver, solver.solve(tolerance, Deadline(seconds))
            except SolverFailed:
                left.remove(solver)
            except OutOfTime:
                if share == 1.0:
                    left.remove(solver)
        share *= MORE
    return None, None


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
