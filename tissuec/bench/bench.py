"""The bench of a scene: points of every solver, and comparisons of them."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from tissuec.bench.ours import EngineSolver
from tissuec.bench.points import MeasuredPoint, MissingPoint, Tell, measure
from tissuec.bench.problem import BenchProblem
from tissuec.bench.ratios import Ratio, ratios
from tissuec.bench.rivals import rivals
from tissuec.bench.scales import MotionScales
from tissuec.bench.trial import BenchSolver
from tissuec.bench.truth import BestSolution, find_truth
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.engine.integrators import INTEGRATORS
from tissuec.script.plan import AUTOMATIC

LEVELS = tuple(10.0**power for power in range(-2, -12, -1))


class BenchResult(Struct, frozen=True, eq=False):
    """Results of a bench.

    Attributes:
        floor: How well the reference is known; errors below it mean nothing.
        points: Of all solvers.
        gaps: Who came to no point where, and why.
        left_out: Sentences on solvers that were not asked.
    """

    problem: BenchProblem
    truth: BestSolution
    floor: float
    points: tuple[MeasuredPoint, ...]
    gaps: tuple[MissingPoint, ...]
    left_out: tuple[str, ...]

    def ratios(self, name: str = AUTOMATIC) -> list[Ratio]:
        """Return how a method of the engine compares with the best of the others."""
        known = ratios(self.points, name, LEVELS, self.floor)
        return [ratio for ratio in known if ratio.best_ours or ratio.best_other]


def bench(
    compiled: Compiled,
    *,
    methods: Sequence[str],
    tolerances: Sequence[float],
    repeat: int,
    budget: float,
    tell: Tell,
) -> BenchResult:
    """Return the points of a scene.

    Args:
        compiled: The scene.
        methods: Names of solvers; all if empty.
        tolerances: In any order.
        repeat: Timed runs of each point.
        budget: Processor time that a run may take [s].
        tell: Called with what is being done.

    Raises:
        TissueError: A name is unknown, or there is no reference.
    """
    problem = BenchProblem.of(compiled)
    ordered = sorted(set(tolerances), reverse=True)
    ours: list[BenchSolver] = [
        EngineSolver(problem, name) for name in (AUTOMATIC, *INTEGRATORS)
    ]
    drawn = np.repeat(problem.network.position[None], len(problem.times), axis=0)
    # A name that is unknown is told before the long work of a reference.
    chosen([*ours, *rivals(problem, MotionScales.of(problem, drawn))[0]], methods)
    truth = find_truth(problem, ordered[-1], budget, tell=tell)
    others, left_out = rivals(problem, MotionScales.of(problem, truth.position))
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
