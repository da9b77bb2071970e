"""The solution that errors are measured against, and its uncertainty."""

from collections.abc import Callable, Iterable, Sequence
from math import inf

from msgspec import Struct
from msgspec.structs import replace

from tissuec.analysis.bench.points import MeasuredPoint, Tell
from tissuec.analysis.bench.problem import BenchProblem
from tissuec.analysis.bench.solver import (
    BenchSolver,
    Deadline,
    EngineSolver,
    OutOfTime,
    SolverFailed,
    SolverRun,
)
from tissuec.core.errors import TissueError
from tissuec.model.network import Floats
from tissuec.script.plan import AUTOMATIC

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
        problem: The scene of the bench.
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
