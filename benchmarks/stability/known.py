"""What is known of a stress scene before any method is judged on it."""

from math import inf

import numpy as np
from msgspec import Struct

from benchmarks.rivals.offers import judges_of
from benchmarks.stability.cells import TOLERANCE
from benchmarks.stability.looking import shaken
from tissuec.analysis.bench import BestSolution, Unknown, find_truth
from tissuec.analysis.bench_solvers import (
    BenchProblem,
    Deadline,
    EngineSolver,
    OutOfTime,
    SolverFailed,
)

FINEST = 1e-6  # the reference is made for this tolerance
SHAKEN = 1e-10  # of the largest displacement: how far a twin begins from the reference
AMPLIFIED = 1e4  # times this difference that the twin may come away; beyond, it is chaos


class Known(Struct, frozen=True, eq=False):
    """The reference of a scene.

    Attributes:
        truth: None where none came out in time.
        is_chaotic: Whether a twin that differs by a little is soon elsewhere.
    """

    truth: BestSolution | None
    is_chaotic: bool

    @property
    def judges(self) -> bool:
        """Return whether positions can be held against it."""
        truth = self.truth
        return truth is not None and not self.is_chaotic and truth.apart <= TOLERANCE


def find_known(problem: BenchProblem, budget: float) -> Known:
    """Return what two solvers and a twin tell of a scene.

    Args:
        budget: Time of the processor for a run [s].
    """
    try:
        truth = find_truth(problem, FINEST, budget, patience=3.0, judges=judges_of)
    except Unknown:
        return Known(None, False)
    return Known(truth, _twin_apart(problem, truth, budget) > AMPLIFIED * SHAKEN)


def _twin_apart(problem: BenchProblem, truth: BestSolution, budget: float) -> float:
    """Return how far a twin comes away from the reference, over the largest displacement."""
    size = float(problem.displacement(truth.position)[-1])
    solver = EngineSolver(shaken(problem, SHAKEN * size), truth.method)
    try:
        twin = solver.solve(truth.tolerance, Deadline(3.0 * budget))
    except SolverFailed:
        return inf
    except OutOfTime:
        return 0.0
    return float(np.abs(twin.position - truth.position).max()) / size if size else 0.0
