"""Runs a script from event to event for solvers that do not handle events."""

import time as clock
from collections.abc import Callable

import numpy as np
from msgspec import Struct

from benchmarks.rivals.kernel import Kernel
from tissuec.analysis.bench_solvers import BenchProblem, PositionRecorder, SolverRun
from tissuec.engine.execution.event_handler import EventHandler
from tissuec.engine.execution.run_state import RunState
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.mechanics.state import State
from tissuec.model.network import Floats

# From a kernel and times within its stretch, shape (row,), to the unknowns at these times,
# shape (row, 6 free), and at its stop, shape (6 free,).
Integrate = Callable[[Kernel, Floats], tuple[Floats, Floats]]


class _Leg(Struct, frozen=True, eq=False):
    """A stretch that was solved: its kernel, what was held, first row and unknowns."""

    kernel: Kernel
    held: Floats  # places of all nodes at its rows [m], free ones not up to date
    first: int
    unknowns: Floats


def walk(problem: BenchProblem, integrate: Integrate) -> SolverRun:
    """Return the run of a problem whose stretches something else integrates."""
    started = clock.process_time()
    run_state, handler = _begun(problem)
    layout = KernelInputs(problem.network, watched=False, ledger=False)
    state, row = run_state.state, 0
    legs: list[_Leg] = []
    duration = problem.plan.simulation.duration
    while state.time < duration:
        kernel = Kernel(layout, state, min(run_state.queue.next, duration))
        stop = int(np.searchsorted(problem.times, kernel.stop))
        times = problem.times[row:stop]
        held = _held(state, times)
        rows, end = integrate(kernel, times)
        legs.append(_Leg(kernel, held, row, rows))
        kernel.leave(state, end)
        handler.handle()
        row = stop
    seconds = clock.process_time() - started
    position = np.empty((len(problem.times), problem.network.node_count, 3))
    for leg in legs:
        part = position[leg.first : leg.first + len(leg.unknowns)]
        part[:] = leg.held
        leg.kernel.positions(leg.unknowns, part)
    position[row:] = state.position
    return SolverRun(seconds, sum(leg.kernel.evaluations for leg in legs), position)


def state_at_start(problem: BenchProblem) -> State:
    """Return the state after the events of 0 s."""
    return _begun(problem)[0].state


def _begun(problem: BenchProblem) -> tuple[RunState, EventHandler]:
    """Return the state of a run after the events of 0 s, and the handler of later events."""
    frames = PositionRecorder(problem)
    run_state = RunState.begin(problem.network, problem.plan, frames.memory)
    handler = EventHandler(problem.network, problem.plan, frames, run_state)
    handler.begin()
    return run_state, handler


def _held(state: State, times: Floats) -> Floats:
    """Return where held and driven nodes are at times within a stretch, (row, node, 3)."""
    position = np.repeat(state.position[None], len(times), axis=0)
    for motion in state.motions.values():
        position[:, motion.nodes] = motion.at(times)[0]
    return position
