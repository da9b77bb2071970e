"""Common code of solvers of other libraries, which are driven from event to event."""

from typing import Any, ClassVar

import numpy as np
from msgspec import Struct

from benchmarks.rivals.kernel import Kernel
from benchmarks.rivals.scales import MotionScales
from benchmarks.rivals.walk import walk
from tissuec.analysis.bench_solvers import BenchProblem, Deadline, SolverFailed, SolverRun
from tissuec.model.network import Floats

FINEST = 1e-13


class DrivenSolver(Struct, frozen=True, eq=False):
    """A method of a library on the engine's compiled forces.

    Attributes:
        library: As the tables show it.
    """

    library: ClassVar[str]

    problem: BenchProblem
    method: str
    scales: MotionScales
    ours: bool = False

    @property
    def name(self) -> str:
        return f"{self.library} {self.method}"

    def solve(self, tolerance: float, deadline: Deadline) -> SolverRun:
        """Return a run at a tolerance; see ``BenchSolver``."""

        def integrate(kernel: Kernel, times: Floats) -> tuple[Floats, Floats]:
            return self.integrate(kernel, times, max(tolerance, FINEST), deadline)

        return walk(self.problem, integrate)

    def integrate(
        self, kernel: Kernel, times: Floats, tolerance: float, deadline: Deadline
    ) -> tuple[Floats, Floats]:
        """Return the unknowns at times within an interval and at its end; see ``Integrate``.

        Raises:
            SolverFailed: It cannot continue.
            OutOfTime: The deadline has passed.
        """
        raise NotImplementedError


def check_solution(found: Any) -> None:
    """Check that a solver came to the end with finite numbers.

    Args:
        found: A result with ``success``, ``message`` and ``y``, as SciPy and CVODE return it.

    Raises:
        SolverFailed: It did not.
    """
    if not found.success or not np.isfinite(found.y).all():
        raise SolverFailed(str(found.message))
