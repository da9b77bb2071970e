"""Scales of a motion, by which the tolerances of other solvers are multiplied."""

import numpy as np
from msgspec import Struct

from benchmarks.rivals.kernel import Kernel
from tissuec.analysis.bench_solvers import BenchProblem
from tissuec.model.network import Floats


class MotionScales(Struct, frozen=True):
    """Largest displacement [m] and speed [m/s] of a motion."""

    displacement: float
    speed: float

    @classmethod
    def of(cls, problem: BenchProblem, position: Floats) -> "MotionScales":
        """Return the scales of a solution, its speeds by differences of positions.

        Args:
            position: At the times of the problem [m], shape (row, node, 3).
        """
        moved = float(problem.displacement(position)[-1])
        least = 1e-6 * (
            problem.network.extent or float(problem.network.springs.rest.max(initial=1.0))
        )
        rise = np.sqrt((np.diff(position, axis=0) ** 2).sum(axis=2)).max(axis=1, initial=0.0)
        speed = float((rise / np.diff(problem.times)).max(initial=0.0))
        size = max(moved, least)
        return cls(size, max(speed, size / problem.plan.simulation.duration))

    def allowed(self, tolerance: float, kernel: Kernel) -> Floats:
        """Return the error allowed in each unknown [m], [m/s], shape (6 free,)."""
        pair = np.array([self.displacement, self.speed])
        return tolerance * np.tile(pair, 3 * len(kernel.nodes))
