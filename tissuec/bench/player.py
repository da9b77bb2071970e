"""A script carried out for solvers that know nothing of it: from event to event."""

import time as clock
from collections.abc import Callable

import numpy as np
from msgspec import Struct

from tissuec.bench.frames import Frames
from tissuec.bench.kernel import Kernel
from tissuec.bench.problem import Problem
from tissuec.bench.trial import Trial
from tissuec.engine.execution.actions import Stage
from tissuec.engine.execution.run_state import Standing
from tissuec.engine.kernel_inputs import Layout
from tissuec.mechanics.situation import Situation
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


def walk(problem: Problem, integrate: Integrate) -> Trial:
    """Return the run of a problem whose stretches something else integrates."""
    started = clock.process_time()
    frames = Frames(problem)
    standing = Standing.begin(problem.network, problem.plan, frames.memory)
    stage = Stage(problem.network, problem.plan, frames, standing)
    layout = Layout(problem.network, watched=False, ledger=False)
    situation, legs, row = standing.situation, [], 0
    duration = problem.plan.simulation.duration
    stage.begin()
    while situation.time < duration:
        kernel = Kernel(layout, situation, min(standing.agenda.next, duration))
        stop = int(np.searchsorted(problem.times, kernel.stop))
        times = problem.times[row:stop]
        held = _held(situation, times)
        rows, end = integrate(kernel, times)
        legs.append(_Leg(kernel, held, row, rows))
        kernel.leave(situation, end)
        stage.happen()
        row = stop
    seconds = clock.process_time() - started
    position = np.empty((len(problem.times), problem.network.node_count, 3))
    for leg in legs:
        part = position[leg.first : leg.first + len(leg.unknowns)]
        part[:] = leg.held
        leg.kernel.positions(leg.unknowns, part)
    position[row:] = situation.position
    return Trial(seconds, sum(leg.kernel.evaluations for leg in legs), position)


def _held(situation: Situation, times: Floats) -> Floats:
    """Return where held and driven nodes are at times within a stretch, (row, node, 3)."""
    position = np.repeat(situation.position[None], len(times), axis=0)
    for motion in situation.motions.values():
        position[:, motion.nodes] = motion.at(times)[0]
    return position
