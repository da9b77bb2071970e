"""A recorder that keeps positions and nothing else."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tissuec.bench.problem import BenchProblem
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.method import Samples
from tissuec.model.network import Floats


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
        """Return what was recorded [m], shape (row, node, 3)."""
        none = np.zeros((0, self.network.node_count, 3))
        return np.concatenate([none, *self._rows])
