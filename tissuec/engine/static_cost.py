"""The predicted time of equilibria, counted from array sizes so that it is reproducible.

Newton's method makes a matrix in each of its steps and solves with it, which takes nearly all
of the time. The number of steps of an equilibrium was measured: ``NEAR`` where a run continues
from the one before, and ``FIRST`` where ``settle`` comes from further away in a firm block. A
body that bends far takes up to ``MOST`` times as many, by its slenderness (``_slenderness``).
Friction took 24 times the time, and a net of springs that folds freely 36 times. Constants are
processor time on one core.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.engine.execution.event_queue import join_times
from tissuec.engine.execution.recorder import sample_times
from tissuec.engine.unknowns import joined_nodes
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.script.plan import EQUILIBRIUM, LOAD_STEPS, Plan
from tissuec.script.verbs.settle import Settle, StaticInterval

# Matrices: of each equilibrium near the one before, with that which shows stability, and of one
# that begins further away in a firm block; times as many where they are solved by iterations.
NEAR, FIRST, INEXACT = 2.2, 4.0, 1.9
# Of nets of springs, whose slenderness is not known, times as many first steps; of slender
# bodies at most, and the slenderness from which there are twice as many.
NET, MOST, SLENDER = 2.5, 5.0, 5.0
TOUCHING = 3.0  # times as many equilibria where contact begins and ends, which halves steps
# Of a matrix [s]: a fixed part, one for each field and for each spring.
MATRIX, FIELD, SPRING = 2e-4, 5e-4, 6e-7
TOUCHES = 1.6  # of that of contact, over the estimate for implicit steps: the search for pairs
# Of what else a step does [s], for each field: forces and energies along it, and its checks.
BESIDE = 1e-2
# Of a factor [s]: a fixed part, and by unknown and by multiplication. Of iterations, by node.
FACTOR, UNKNOWN, MULTIPLICATION, ITERATED = 4e-4, 5e-6, 5e-10, 1.6e-5
OF_MATRIX = 85.0  # bytes of a number of K, with what multigrid makes of it


class StaticCost(NamedTuple):
    """The equilibria of a run, the steps of Newton's method, and the time of all [s].

    Attributes:
        bytes: Of memory for matrices.
    """

    equilibria: int
    steps: float
    seconds: float
    bytes: float = 0.0


class Solving(NamedTuple):
    """What it takes to solve with K: time [s], memory [bytes], and times as many steps."""

    seconds: float
    bytes: float
    more: float


def static_cost(state: State, plan: Plan) -> StaticCost:
    """Return the predicted cost of all equilibria of a run.

    Args:
        state: After the events at 0 s.
    """
    first = sum(isinstance(event.action, Settle) for event in plan.every_event)
    near = sum(_count(plan, *one) for one in _intervals(plan))
    if not first and not near:
        return StaticCost(0, 0.0, 0.0)
    again = 1.0 if state.network.contact is None else TOUCHING
    solving = _solving(state)
    steps = (FIRST * _far(state) * first + NEAR * near) * again * solving.more
    beside = BESIDE * max(1, len(state.fields))
    seconds = steps * (_matrix_seconds(state) + solving.seconds + beside)
    return StaticCost(first + near, steps, seconds, solving.bytes)


def _intervals(plan: Plan) -> Iterator[tuple[float, float, float]]:
    """Yield start and end of each static part of a run, and its longest step [s]."""
    simulation = plan.simulation
    if simulation.integrator == EQUILIBRIUM:
        assert simulation.step is not None, "a static run has one"
        yield 0.0, simulation.duration, simulation.step
        return
    for event in plan.every_event:
        if isinstance(event.action, StaticInterval):
            span = event.action.duration
            stop = min(event.time + span, simulation.duration)
            yield event.time, stop, span / LOAD_STEPS


def _count(plan: Plan, start: float, stop: float, step: float) -> int:
    """Return how many equilibria there are from one time to another [s].

    They are at samples, at events, once more after each event, and between events at most a
    step [s] apart.
    """
    if not stop > start:
        return 0
    near = 1e-9 * (stop - start)
    ends = [
        event.time + (getattr(event.action, "duration", None) or 0.0) for event in plan.events
    ]
    found = np.array([start, stop, *(event.time for event in plan.events), *ends])
    stops = join_times(found[(found >= start) & (found <= stop)], np.zeros(0), near)
    grids: list[Floats] = [
        np.linspace(a, b, int(np.ceil((b - a) / step * (1.0 - 1e-12))) + 1)
        for a, b in pairwise(stops)
    ]
    samples = sample_times(plan)
    samples = samples[(samples >= start) & (samples <= stop)]
    times = join_times(np.concatenate([*grids, samples]), np.zeros(0), near)
    return len(times) + len(stops) - 1


def _far(state: State) -> float:
    """Return how many times the steps of a firm block a first equilibrium takes."""
    elements, held = state.elements, state.held
    if not elements:
        return NET
    most = 0.0
    for body in {each.name for each in elements}:
        own = [each for each in elements if each.name == body]
        nodes = np.unique(np.concatenate([each.nodes.ravel() for each in own]))
        volume = sum(float(each.node_volumes.sum()) for each in own)
        most = max(most, _slenderness(state.position[nodes], held[nodes], volume))
    return min(1.0 + (most / SLENDER) ** 2, MOST)


def _slenderness(position: Floats, held: NDArray[np.bool_], volume: float) -> float:
    """Return how far a body reaches from where it is held, over its thickness there.

    The thickness is the root of its volume over that reach; 0 for a body that is not held.

    Args:
        position: Of its nodes [m], shape (node, 3).
        held: Which of them are held, shape (node,).
        volume: [m³].
    """
    if not held.any():
        return 0.0
    reach = norm(position - position[held].mean(axis=0)).max()
    return float(np.sqrt(reach**3 / volume))


def _matrix_seconds(state: State) -> float:
    """Return the predicted time of a matrix [s]."""
    items = sum(
        (TOUCHES if name == "contact" else 1.0) * field.matrix_seconds
        for name, field in state.named_fields.items()
    )
    return MATRIX + FIELD * len(state.fields) + SPRING * len(_acting_ends(state)) + items


def _acting_ends(state: State) -> Indices:
    """Return the ends of springs that act on free nodes, shape (spring, 2)."""
    ends = state.springs.ends
    acts = state.alive_springs & ~state.held[ends].all(axis=1)
    return ends[acts].astype(np.int64)


def _solving(state: State) -> Solving:
    """Return the cost of solving with K."""
    from tissuec.mechanics.dissection import dissected
    from tissuec.mechanics.inverses import BYTES, is_iterated

    free = state.free
    joined = joined_nodes(free, _acting_ends(state), state.fields)
    order = dissected(state.position[free], joined.tocsr())
    unknowns, entries = joined.shape[0] * 3, 9.0 * joined.nnz
    if is_iterated(unknowns, order.work):
        return Solving(ITERATED * unknowns / 3.0, OF_MATRIX * entries, INEXACT)
    seconds = FACTOR + UNKNOWN * unknowns + MULTIPLICATION * order.work
    return Solving(seconds, BYTES * (order.numbers + entries), 1.0)
