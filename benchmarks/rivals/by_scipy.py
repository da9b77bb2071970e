"""SciPy's solvers on the engine's compiled forces."""

from typing import Any, ClassVar

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.rivals.driven import DrivenSolver, check_solution
from benchmarks.rivals.kernel import Kernel
from tissuec.analysis.bench_solvers import Deadline
from tissuec.model.network import Floats

EXPLICIT = ("RK23", "RK45", "DOP853")
IMPLICIT = ("Radau", "BDF", "LSODA")
# Unknown coordinates up to which matrices are kept; more would take minutes and gigabytes.
LARGEST = 20_000


class SciPySolver(DrivenSolver, frozen=True):
    """One of SciPy's methods, with the pattern or band of its Jacobian where it takes one."""

    library: ClassVar[str] = "SciPy"

    def integrate(
        self, kernel: Kernel, times: Floats, tolerance: float, deadline: Deadline
    ) -> tuple[Floats, Floats]:
        """Return the unknowns at times within an interval and at its end.

        Raises:
            SolverFailed: SciPy's solver cannot continue.
        """
        with np.errstate(all="ignore"):
            solve: Any = solve_ivp
            found = solve(
                kernel.function(deadline),
                (kernel.start, kernel.stop),
                kernel.initial,
                self.method,
                t_eval=np.append(times, kernel.stop),
                rtol=tolerance,
                atol=self.scales.allowed(tolerance, kernel),
                **self._matrix(kernel),
            )
        check_solution(found)
        return found.y.T[:-1], found.y[:, -1]

    def _matrix(self, kernel: Kernel) -> dict[str, Any]:
        """Return the options that describe the Jacobian to the method."""
        if self.method == "LSODA":
            return {"lband": kernel.half_band, "uband": kernel.half_band}
        return {"jac_sparsity": kernel.sparsity} if self.method in IMPLICIT else {}
