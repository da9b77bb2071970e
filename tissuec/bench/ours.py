"""The engine as a solver: the run of a plan with frames in memory only."""

import time as clock

from msgspec import Struct

from tissuec.bench.frames import PositionRecorder
from tissuec.bench.problem import BenchProblem
from tissuec.bench.trial import Deadline, OutOfTime, SolverFailed, SolverRun
from tissuec.engine.execution.run import run
from tissuec.script.plan import AUTOMATIC


class EngineSolver(Struct, frozen=True, eq=False):
    """A method of the engine, or its own choice.

    Attributes:
        method: "automatic" or a member of ``INTEGRATORS``.
    """

    problem: BenchProblem
    method: str
    ours: bool = True

    @property
    def name(self) -> str:
        return self.method

    def solve(self, tolerance: float, deadline: Deadline) -> SolverRun:
        """Return a run at a tolerance; see ``BenchSolver``.

        Raises:
            OutOfTime: The deadline has passed.
            SolverFailed: The run ended early, or another method took over.
        """
        problem, frames = self.problem, PositionRecorder(self.problem)
        started = clock.process_time()
        outcome = run(
            problem.network,
            problem.by(self.method, tolerance),
            frames,
            interrupt=lambda: deadline.is_over,
        )
        seconds, statistics = clock.process_time() - started, outcome.statistics
        if outcome.kind == "interrupted":
            raise OutOfTime("the time budget was used up")
        if outcome.kind != "done":
            raise SolverFailed(outcome.message)
        if self.method not in (AUTOMATIC, statistics.method):
            raise SolverFailed(f"{statistics.method} took over: {statistics.reason}")
        return SolverRun(seconds, statistics.evaluations, frames.position)
