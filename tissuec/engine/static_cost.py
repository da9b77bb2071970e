"""The predicted time of equilibria, counted from array sizes so that it is reproducible.

Newton's method makes and factorises a matrix in each of its steps, which takes nearly all of
the time. How many steps an equilibrium takes was measured: ``NEAR`` where a run goes on from
the one before, and ``FIRST`` where ``settle`` comes from further away in a firm block. A body
that bends far takes up to ``MOST`` times as many, by its slenderness (``_slenderness``).
Beams one element thick took 3 times as many (134 factors, 44 steps were predicted), friction 24
times the time, and a net of springs that folds freely 36 times. Constants are processor time on
one core.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.engine.execution.event_queue import join_times
from tissuec.engine.execution.recorder import sample_times
from tissuec.engine.unknowns import Fill
from tissuec.mechanics.state import State
from tissuec.model.network import Floats
from tissuec.script.plan import EQUILIBRIUM, LOAD_STEPS, Plan
from tissuec.script.verbs.settle import Settle, StaticInterval

# Matrices: of each step, of the one that polishes, and of the one that shows stability.
NEAR, FIRST = 4.8, 6.0
# Of nets of springs, whose slenderness is not known, times as many first steps; of slender
# bodies at most, and the slenderness from which there are twice as many.
NET, MOST, SLENDER = 2.5, 5.0, 5.0
TOUCHING = 3.0  # times as many equilibria where contact begins and ends, which halves steps
# Of a matrix [s]: a fixed part, one for each field and for each spring; and what making that of
# items takes, over the estimate for implicit steps.
MATRIX, FIELD, SPRING, ITEMS = 2e-4, 1.8e-3, 6e-7, 0.8
TOUCHES = 0.4  # the same for contact, with the search for pairs
# Of a factor [s]: a fixed part, and by number and by multiplication.
FACTOR, NUMBER, MULTIPLICATION = 4e-4, 3e-8, 2.5e-10
# Free nodes from which the fill is that of solids, by powers: to find it would take seconds.
LARGE, NUMBERS, MULTIPLICATIONS = 15_000, 150.0, 200.0


class StaticCost(NamedTuple):
    """The equilibria of a run, the steps of Newton's method, and the time of all [s]."""

    equilibria: int
    steps: float
    seconds: float


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
    steps = (FIRST * _far(state) * first + NEAR * near) * again
    return StaticCost(first + near, steps, steps * _step_seconds(state))


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


def _step_seconds(state: State) -> float:
    """Return the predicted time of a step of Newton's method [s]."""
    free = ~state.held
    acts = state.alive & free[state.springs.ends].any(axis=1)
    springs = int(acts.sum())
    items = sum(
        (TOUCHES if name == "contact" else ITEMS) * field.matrix_seconds
        for name, field in state.named_fields.items()
    )
    matrix = MATRIX + FIELD * len(state.fields) + SPRING * springs + items
    count = int(np.count_nonzero(free))
    if count > LARGE:
        fill = Fill(NUMBERS * count ** (4 / 3), MULTIPLICATIONS * float(count) ** 2)
    else:
        fill = Fill.of(free, state.springs.ends[acts], state.fields)
    factor = FACTOR + NUMBER * fill.numbers + MULTIPLICATION * fill.multiplications
    return matrix + factor
