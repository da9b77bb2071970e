"""A run of a plan with finer steps, of which positions are kept and nothing is written."""

from collections.abc import Callable
from math import inf

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.method import Samples, Statistics
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import Plan, without_outputs
from tissuec.script.verbs.end import without_end

USUAL, FINEST = 1e-4, 1e-13  # tolerance, where none is written and at the least


class Allowance:
    """What a companion run may cost, by counts of operations and not by a clock.

    Args:
        most: Returns the predicted cost at which it ends [s].
    """

    def __init__(self, most: Callable[[], float]):
        self._most, self._spent = most, 0.0

    def watch(self, time: float, ran: Statistics) -> None:
        """Measure what a run has cost until a time [s]."""
        self._spent = ran.cost

    @property
    def is_spent(self) -> bool:
        """Return whether the run is to end."""
        return self._spent > self._most()


def finer(plan: Plan, factor: float, method: str = "") -> Plan:
    """Return a plan with finer steps and without outputs of its own.

    Args:
        plan: The plan.
        factor: Factor that its tolerance is divided by; a fixed step is divided by half of it.
        method: Another one than that of the plan, if any.
    """
    simulation = replace(plan.simulation, integrator=method or plan.simulation.integrator)
    if simulation.step is None:
        tolerance = max((simulation.tolerance or USUAL) / factor, FINEST)
        simulation = replace(simulation, tolerance=tolerance)
    else:
        simulation = replace(simulation, step=2.0 * simulation.step / factor)
    return replace(without_outputs(without_end(plan)), simulation=simulation)


def stepped(
    network: Network,
    plan: Plan,
    times: Floats,
    factor: float,
    *,
    method: str = "",
    rows: Floats | None = None,
    interrupt: Callable[[], bool] | None = None,
    allowance: Allowance | None = None,
    threads: int = 1,
) -> Floats:
    """Return positions at times with smaller steps [m], shape (time, node, 3).

    They are NaN at times that the run did not reach.

    Args:
        network: The network.
        plan: The plan of the run.
        times: Times of interest [s], ascending, shape (time,).
        factor: See ``finer``.
        method: See ``finer``; with one, what is near is searched for otherwise, too.
        rows: Array to be filled; a new one by default.
        interrupt: Returns whether to stop.
        allowance: What it may cost.
        threads: See ``Method``.
    """
    from tissuec.engine.execution.run import run

    rows = np.full((len(times), network.node_count, 3), np.nan) if rows is None else rows
    plan = finer(plan, factor, method)
    contact = network.contact
    if method and contact is not None:
        network = network.with_blocks(replace(contact, exhaustive=True).block)
    silent = _Silent(network, plan, times, rows)
    may_cost = allowance or Allowance(lambda: inf)
    run(
        network, plan, silent, watch=may_cost.watch, threads=threads,
        interrupt=lambda: may_cost.is_spent or (interrupt is not None and interrupt()),
    )  # fmt: skip
    return rows


class _Silent(Recorder):
    """A recorder that keeps positions and writes nothing."""

    takes_notes = False

    def __init__(self, network: Network, plan: Plan, times: Floats, rows: Floats):
        super().__init__(network, plan, MemoryRecording())
        self._kept = rows
        self.times = times

    def record(self, samples: Samples) -> None:
        keep(samples, self.times, self._kept)


def keep(samples: Samples, times: Floats, rows: Floats) -> tuple[Indices, NDArray[np.bool_]]:
    """Copy the positions of samples at given times into rows.

    Args:
        samples: A batch of samples.
        times: Times of interest [s], ascending, shape (time,).
        rows: Positions [m], shape (time, node, 3), changed in place.

    Returns:
        Which rows were set, shape (n,), and whether each sample is one of them, shape
        (sample,).
    """
    places = np.searchsorted(times, samples.time)
    due = (places < len(times)) & (times[np.minimum(places, len(times) - 1)] == samples.time)
    rows[places[due]] = samples.position[due]
    return places[due], due


def largest(vectors: Floats) -> Floats:
    """Return the length of the longest vector of each row, in their unit, shape (row,).

    Args:
        vectors: In any unit, shape (row, node, 3).
    """
    return np.sqrt(np.einsum("rnk,rnk->rn", vectors, vectors).max(axis=1, initial=0.0))
