"""Points of run time against error, for every solver and tolerance."""

from collections.abc import Callable, Iterator, Sequence
from math import inf
from statistics import median

from msgspec import Struct

from tissuec.analysis.bench.problem import BenchProblem
from tissuec.analysis.bench.solver import (
    BenchSolver,
    Deadline,
    OutOfTime,
    SolverFailed,
    SolverRun,
)
from tissuec.core.errors import counted
from tissuec.model.network import Floats

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
        problem: The scene of the bench.
        solvers: The solvers.
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
