"""Solvers of a bench: their protocol, and the engine as one of them."""

import time as clock
from typing import Protocol

from msgspec import Struct

from tissuec.analysis.bench.problem import BenchProblem, PositionRecorder
from tissuec.compiled.loading import time_of_translating
from tissuec.core.errors import TissueError
from tissuec.engine.execution.run import run
from tissuec.model.network import Floats
from tissuec.script.plan import AUTOMATIC


class SolverFailed(TissueError):
    """A solver could not continue; the message gives the reason."""


class OutOfTime(TissueError):
    """A solver took longer than its budget."""


class Deadline:
    """Time limit of a solver.

    Args:
        budget: Time of the processor [s], from now, so that a busy machine changes nothing;
            what is spent on translating kernels, once for good, does not count.
    """

    def __init__(self, budget: float):
        self._until = clock.process_time() - time_of_translating() + budget

    @property
    def is_over(self) -> bool:
        """Return whether the time is up."""
        return clock.process_time() - time_of_translating() > self._until

    def check(self) -> None:
        """Stop a run that exceeds its time.

        Raises:
            OutOfTime: The time is up.
        """
        if self.is_over:
            raise OutOfTime("the time budget was used up")


class SolverRun(Struct, frozen=True, eq=False):
    """A finished run.

    Attributes:
        seconds: Time of the processor [s]; wall time on one thread of an idle machine.
        evaluations: Of the forces.
        position: At the times of the problem [m], shape (row, node, 3).
    """

    seconds: float
    evaluations: int
    position: Floats


class BenchSolver(Protocol):
    """A solver that solves a problem to a tolerance.

    Attributes:
        name: As the tables show it.
        ours: Whether it is a method of the engine.
    """

    @property
    def name(self) -> str: ...
    @property
    def ours(self) -> bool: ...

    def solve(self, tolerance: float, deadline: Deadline) -> SolverRun:
        """Return a run at a tolerance.

        Raises:
            SolverFailed: It could not continue.
            OutOfTime: The deadline has passed.
        """
        ...


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
