"""CVODE of SUNDIALS on the engine's compiled forces, where scikit-sundae is installed."""

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from benchmarks.rivals.driven import DrivenSolver, check_solution
from benchmarks.rivals.kernel import Kernel
from tissuec.analysis.bench_solvers import Deadline
from tissuec.model.network import Floats

METHODS = ("BDF", "Adams")
LARGEST_BAND = 2e7  # numbers in a band up to which it is kept; above, solving iterates
KRYLOV = 30


class CvodeSolver(DrivenSolver, frozen=True):
    """CVODE with a banded Jacobian by differences, or with GMRES for wide nets."""

    library: ClassVar[str] = "CVODE"

    def integrate(
        self, kernel: Kernel, times: Floats, tolerance: float, deadline: Deadline
    ) -> tuple[Floats, Floats]:
        """Return the unknowns at times within an interval and at its end.

        Raises:
            SolverFailed: CVODE cannot continue.
        """
        cvode: Any = import_module("sksundae.cvode")

        def fill(time: float, y: Floats, out: Floats) -> None:
            deadline.check()
            kernel.fill(time, y, out)

        band = kernel.half_band
        narrow = len(kernel.initial) * (3.0 * band + 1.0) <= LARGEST_BAND
        matrix = (
            {"linsolver": "lapackband", "lband": band, "uband": band}
            if narrow
            else {"linsolver": "gmres", "krylov_dim": KRYLOV}
        )
        solver = cvode.CVODE(
            fill,
            method=self.method,
            rtol=tolerance,
            atol=self.scales.allowed(tolerance, kernel),
            max_num_steps=100_000_000,
            **matrix,
        )
        first, last = np.array([kernel.start]), np.array([kernel.stop])
        inner = times[times > kernel.start]
        # With two times only, it would return all of its steps.
        inner = inner if len(inner) else 0.5 * (first + last)
        with _silence():
            found = solver.solve(np.concatenate([first, inner, last]), kernel.initial)
        check_solution(found)
        return found.y[np.searchsorted(found.t, times)], found.y[-1]


@contextmanager
def _silence() -> Generator[None]:
    """Keep what the library prints by itself away from the tables and the JSON document."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)
