"""The twin of a run: the same plan once more, stepped more finely, in a process beside it.

Estimates of single steps cannot tell what a motion makes of their errors later on: a tear, a
buckling or a tumbling chain can amplify them beyond measure. The twin has other errors, so that
where both agree, both are right to about their difference; and where the motion is chaotic they
part, however small the steps. It runs on another core and writes nothing.
"""

import mmap
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from tissuec.network import Floats, Network
from tissuec.plan import Output, Plan
from tissuec.running.memory import MemoryRecording
from tissuec.running.recording import Recorder, Samples, sample_times

FINER = 4.0  # times; the difference is then about the error itself, or a third more
MOST_ROWS = 200
MOST_BYTES = 2e8
SMALLEST = 1e-6  # displacement by which differences are measured, relative to the drawing
USUAL, FINEST = 1e-4, 1e-13  # tolerance, where none is written and at the least


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """How far a run and its twin came apart.

    Attributes:
        times: When both were compared [s], shape (row,).
        apart: Largest distance of a node from its twin until then [m], shape (row,).
        relative: The same over the largest displacement until then, shape (row,).
        allowed: What the tolerance allows.
        complete: Whether the twin came to the end.
    """

    times: Floats
    apart: Floats
    relative: Floats
    allowed: float
    complete: bool

    @property
    def verdict(self) -> Literal["alike", "apart", "unknown"]:
        """Return whether the tolerance is kept as far as one can tell."""
        if self.parting is not None:
            return "apart"
        return "alike" if self.complete else "unknown"

    def as_dict(self) -> dict[str, Any]:
        """Return it for a manifest."""
        return {
            "verdict": self.verdict,
            "error": float(self.relative.max(initial=0.0)),
            "tolerance": self.allowed,
            "parting": self.parting,
        }

    @property
    def parting(self) -> float | None:
        """Return the first time at which the difference is more than allowed [s]."""
        beyond = np.flatnonzero(self.relative > self.allowed)
        return float(self.times[beyond[0]]) if len(beyond) else None


@contextmanager
def accompanied(network: Network, plan: Plan, *, wanted: bool) -> Iterator["Twin | None"]:
    """Yield a twin that has begun to run, or None; it does not outlive the block.

    Where nothing is looked at but the start, there is nothing to compare either.
    """
    times = sample_times(plan)
    if not wanted or not (times > 0.0).any():
        yield None
        return
    twin = Twin(network, plan, times)
    twin.begin()
    try:
        yield twin
    finally:
        twin.end()


class Twin:
    """One twin, from its birth to the comparison.

    Args:
        network, plan: Of the run.
        times: When the run takes samples [s]; some of them are compared.
    """

    def __init__(self, network: Network, plan: Plan, times: Floats):
        self.network, self.plan = network, plan
        most = max(2, min(MOST_ROWS, int(MOST_BYTES / (48 * max(network.node_count, 1)))))
        chosen = np.linspace(0, len(times) - 1, min(most, len(times))).round().astype(int)
        self.times = times[np.unique(chosen)]
        shape = (len(self.times), network.node_count, 3)
        self._own = np.full(shape, np.nan)
        self._memory = mmap.mmap(-1, max(8 * self._own.size, 8))
        self._other = np.frombuffer(self._memory, count=self._own.size).reshape(shape)
        self._other[:] = np.nan
        self._process = 0

    @staticmethod
    def is_possible() -> bool:
        """Tell whether there is another core, and a system that can split a process."""
        return hasattr(os, "fork") and (os.cpu_count() or 1) > 1

    def begin(self) -> None:
        """Split off the process; call this before any file is open for writing."""
        parent = os.getpid()
        self._process = os.fork()
        if self._process:
            return
        code = 1
        try:  # Nothing of the parent's may be cleaned up here, hence no ordinary exit.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            code = self._run(parent)
        finally:
            os._exit(code)

    def take(self, samples: Samples) -> None:
        """Keep the run's own positions at the times of comparison."""
        _keep(samples, self.times, self._own)

    def compare(self) -> Likeness:
        """Wait for the twin and compare."""
        _, status = os.waitpid(self._process, 0)
        self._process = 0
        known = np.isfinite(self._own).all(axis=(1, 2)) & np.isfinite(self._other).all(
            axis=(1, 2)
        )
        own, other = self._own[known], self._other[known]
        moved, floor = _largest(own - own[:1]), SMALLEST * (self.network.extent or 1.0)
        scale = np.maximum.accumulate(np.maximum(moved, floor))
        apart = np.maximum.accumulate(_largest(own - other))
        relative = np.maximum.accumulate(_largest(own - other) / scale)
        simulation = self.plan.simulation
        allowed = simulation.tolerance or (USUAL if simulation.step is None else np.inf)
        complete = status == 0 and bool(known.all())
        return Likeness(self.times[known], apart, relative, allowed, complete)

    def end(self) -> None:
        """End the twin where nobody waits for it any more."""
        if self._process:
            os.kill(self._process, signal.SIGKILL)
            os.waitpid(self._process, 0)
            self._process = 0

    def _run(self, parent: int) -> int:
        """Run the plan more finely; return 0 if that came to the end."""
        from tissuec.running.run import run

        simulation = self.plan.simulation
        if simulation.step is None:
            finer = max((simulation.tolerance or USUAL) / FINER, FINEST)
            simulation = replace(simulation, tolerance=finer)
        else:
            simulation = replace(simulation, step=0.5 * simulation.step)
        plan = replace(
            self.plan,
            simulation=simulation,
            expectations=(),
            output=Output(np.zeros(0, dtype=np.int64), np.inf, False, (), np.inf),
        )
        recorder = _Silent(self.network, plan, self.times, self._other)
        outcome = run(self.network, plan, recorder, interrupt=lambda: os.getppid() != parent)
        return 0 if outcome.kind == "done" else 1


class _Silent(Recorder):
    """A recorder that keeps positions in shared memory and writes nothing."""

    def __init__(self, network: Network, plan: Plan, times: Floats, rows: Floats):
        super().__init__(network, plan, MemoryRecording())
        self._kept = rows
        self.times = times

    def record(self, samples: Samples) -> None:
        _keep(samples, self.times, self._kept)


def _keep(samples: Samples, times: Floats, rows: Floats) -> None:
    """Enter the samples that are due into rows."""
    places = np.searchsorted(times, samples.time)
    due = (places < len(times)) & (times[np.minimum(places, len(times) - 1)] == samples.time)
    rows[places[due]] = samples.position[due]


def _largest(vectors: Floats) -> Floats:
    """Return the length of the longest vector of each row, shape (row,)."""
    return np.sqrt(np.einsum("rnk,rnk->rn", vectors, vectors).max(axis=1, initial=0.0))
