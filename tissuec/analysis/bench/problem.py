"""The problem of a bench: the positions of a plan at its output times."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.compile import Compiled
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.method import Samples
from tissuec.model.network import Floats, Network
from tissuec.script.plan import Plan, without_outputs
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
