"""What a bench measures: positions of a plan at its output times, and the solvers for them."""

import time as clock
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from msgspec import Struct

from tissuec.compiled.loading import time_of_translating
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import TissueError
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.method import Samples
from tissuec.model.network import Floats, Network
from tissuec.script.plan import AUTOMATIC, Plan, without_outputs
from tissuec.validate.engine_run import output_times, thinned
from tissuec.validate.uncertainty import relative_positions


class BenchProblem(Struct, frozen=True, eq=False):
    """A scene without outputs and expectations.

    Attributes:
        times: When positions are compared [s], ascending, shape (row,).
    """

    network: Network
    plan: Plan
    times: Floats

    @classmethod
    def of(cls, compiled: Compiled) -> "BenchProblem":
        """Return the problem of a compiled scene."""
        network, plan = compiled.network, compiled.plan
        bare = without_outputs(plan)
        return cls(network, bare, thinned(output_times(network, plan), network.node_count))

    def by(self, method: str, tolerance: float) -> Plan:
        """Return the plan with a method and a tolerance in place of its own."""
        asked = replace(self.plan.simulation, integrator=method, tolerance=tolerance, step=None)
        return replace(self.plan, simulation=asked)

    def displacement(self, position: Floats) -> Floats:
        """Return the largest displacement of a node so far [m], shape (row,).

        Args:
            position: At every time [m], shape (row, node, 3).
        """
        moved = np.sqrt(((position - self.network.position) ** 2).sum(axis=2))
        return np.maximum.accumulate(moved.max(axis=1, initial=0.0))

    def error(self, position: Floats, truth: Floats) -> float:
        """Return the largest error of a position, by definition of the tolerance.

        Args:
            position, truth: At every time [m], shape (row, node, 3).
        """
        apart = np.sqrt(((position - truth) ** 2).sum(axis=2)).max(axis=1, initial=0.0)
        if not np.isfinite(apart).all():
            return float("inf")
        errors = relative_positions(apart, self.displacement(truth), self.network)
        return float(errors.max(initial=0.0))


class PositionRecorder(Recorder):
    """Keeps the positions at the times of a problem."""

    takes_notes = False

    def __init__(self, problem: BenchProblem):
        super().__init__(problem.network, problem.plan, MemoryRecording())
        self.times = problem.times
        self._rows: list[Floats] = []

    def record(self, samples: Samples) -> None:
        self._rows.append(samples.position)

    def checkpoint(self, saved: Mapping[str, Any]) -> None:
        """Keep nothing: a bench is never resumed."""

    @property
    def position(self) -> Floats:
        """Return the recorded positions [m], shape (row, node, 3)."""
        none = np.zeros((0, self.network.node_count, 3))
        return np.concatenate([none, *self._rows])


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
