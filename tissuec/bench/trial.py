"""One run of one solver, and what a solver is to a bench."""

import time as clock
from typing import Protocol

from msgspec import Struct

from tissuec.compiled.loading import time_of_translating
from tissuec.core.errors import TissueError
from tissuec.model.network import Floats


class SolverFailed(TissueError):
    """A solver could not go on; the message says why."""


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
            Failed: It could not go on.
            OutOfTime: The deadline has passed.
        """
        ...
