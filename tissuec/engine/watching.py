"""What interrupts within steps: ruptures, elements that break, and watched conditions.

Their loads (``solids.element_limits``) are no part of the forces of a step. They are found at
states within it that are interpolated without evaluating forces, and only where one of them
comes close to a limit, on its dense output.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.backends import bound_inside
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.method import Interruption
from tissuec.engine.run_arrays import arrays_of
from tissuec.engine.step_events import (
    RESOLUTION,
    AcceptedStep,
    Limits,
    Survey,
    Watch,
    bisect,
    parabola_tops,
)
from tissuec.engine.stepper import Stepper
from tissuec.kernels.records import GLANCES, Progress
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.forces.solids.element_limits import BreakableElements

FINE_LOOKS = 8  # of methods whose steps are long
MARGIN = 0.999  # of a limit: loads above which a step is examined closely


class Loads:
    """The loads of the elements of a state that can break, divided by their limits.

    Args:
        shapes: Intact elements, shape by shape.
        place: Index of each node in flat arrays, shape (node,).
    """

    def __init__(self, shapes: "Sequence[BreakableElements]", place: Indices):
        self._shapes, self._place = shapes, place
        self._loads = [each.loading(place) for each in shapes]
        entities = [each.entities for each in shapes]
        self.entities: Indices = np.concatenate([np.zeros(0, dtype=np.int64), *entities])

    @classmethod
    def of(cls, inputs: KernelInputs) -> "Loads | None":
        """Return those of the present state; None where no element can break."""
        shapes = (field.breakable for field in inputs.state.fields)
        able = [each for each in shapes if each is not None]
        return cls(able, inputs.layout.place) if able else None

    def at(self, x: Floats) -> Floats:
        """Return the loads, shape (element,); ``x`` are flat positions [m], shape (3 node,)."""
        return np.concatenate([loads(x) for loads in self._loads])

    def some(self, chosen: Indices) -> "Loads":
        """Return some of them, by ascending indices of shape (n,)."""
        found: list[BreakableElements] = []
        first = 0
        for each in self._shapes:
            count = len(each.entities)
            own = chosen[(chosen >= first) & (chosen < first + count)] - first
            if len(own):
                found.append(each.some(own))
            first += count
        return Loads(found, self._place)


class LoadedElements:
    """Limits of elements within an accepted step; the interface is that of ``Limits``.

    Attributes:
        force: What loads are compared with: 1, shape (element,).
    """

    def __init__(self, loads: Loads):
        self._loads = loads
        self.force = np.ones(len(loads.entities))

    def __len__(self) -> int:
        return len(self.force)

    @property
    def springs(self) -> Indices:
        """Return their numbers as entities, shape (element,)."""
        return self._loads.entities

    def loads(self, within: AcceptedStep, when: float) -> Floats:
        """Return the loads at a time in a step [s], shape (element,)."""
        return self._loads.at(within.state(when)[0])

    def some(self, chosen: NDArray[np.bool_] | list[int]) -> "LoadedElements":
        """Return a selection, by a mask of shape (element,) or by indices."""
        return LoadedElements(self._loads.some(np.arange(len(self.force))[chosen]))


def may_break(loads: Loads, stepper: Stepper, start: Floats, steps: int) -> bool:
    """Return whether an element may break in the last steps that were glanced at.

    Args:
        stepper: It has computed states within the steps.
        start: Positions at the start of the first of them [m], flat, shape (3 node,).
        steps: How many of the last ones.
    """
    glanced: Any = stepper.buffer.buffer.glance_position
    last = stepper.progress.glanced
    # Shorter steps are examined in their middle and at their end.
    every = 2 if stepper.integrator.looks < FINE_LOOKS else 1
    rows = range(last - GLANCES * steps + every - 1, last, every)
    seen = np.array([loads.at(x) for x in (start, *(glanced[row] for row in rows))])
    return bool((parabola_tops(seen[:-2], seen[1:-1], seen[2:]) > MARGIN).any())


# Steps that are examined together for conditions: at first and after one was found to hold, and
# at most where none does; and coordinates of states in them.
FIRST_TOGETHER, MOST_TOGETHER, GLANCED = 16, 64, 200_000


def steps_together(stepper: Stepper) -> int:
    """Return how many steps can be examined together.

    Only one with contact, threads or springs that relax or flow: they keep state outside of
    ``Work``, with which the run could not go back.
    """
    needed = stepper.inputs.features
    if needed.touched or needed.reeled or needed.inelastic:
        return 1
    return min(MOST_TOGETHER, 1 + GLANCED // (GLANCES * stepper.work.zero.size))


def may_happen(
    stepper: Stepper, survey: Survey | None, loads: Loads | None, kept: "Standpoint"
) -> bool:
    """Return whether something may interrupt in the steps of the last call.

    Args:
        stepper: It has made the steps.
        survey: Tells whether a condition may hold.
        loads: Of elements that may break.
        kept: Where the call began.
    """
    if survey is not None and _may_hold(stepper, survey):
        return True
    steps = stepper.progress.glanced // GLANCES
    return loads is not None and steps > 0 and may_break(loads, stepper, kept.position, steps)


def _may_hold(stepper: Stepper, survey: Survey) -> bool:
    """Return whether a condition may hold in the steps of the last call."""
    buffer, inputs = stepper.buffer.buffer, stepper.inputs
    found = slice(stepper.progress.glanced)
    if not stepper.progress.glanced:
        return False
    position = inputs.positions(buffer.glance_position[found])
    velocity = inputs.outwards(buffer.glance_velocity[found])
    return survey(buffer.glance_time[found], position, velocity)


class Standpoint:
    """A state of a stepper, to which it can return.

    Attributes:
        work: The arrays that it copies.
    """

    def __init__(self, stepper: Stepper):
        self.work = stepper.work
        arrays = (array for array in arrays_of(self.work) if array.size)
        self._arrays = [(array, np.empty_like(array)) for array in arrays]
        self.take(stepper)

    def take(self, stepper: Stepper) -> None:
        """Take the present state."""
        self._progress: Progress = stepper.progress
        for array, kept in self._arrays:
            kept[...] = array

    @property
    def position(self) -> NDArray[Any]:
        """Return the positions there [m], flat, shape (3 node,)."""
        kept = next(kept for array, kept in self._arrays if array is self.work.x)
        return kept[self._progress.current]

    def bring_back(self, stepper: Stepper) -> None:
        """Go back."""
        stepper.progress = self._progress
        for array, kept in self._arrays:
            array[...] = kept
        made = stepper.work.solver.made
        if made[4] == 1.0:
            made[2] = 1.0  # its factor is outside of these arrays, and of a state that is left


def first_interruption(
    stepper: Stepper, watch: Watch | None, loads: Loads | None, *, surpassed: bool
) -> tuple[AcceptedStep, Interruption | None]:
    """Return the accepted step, and the first rupture or trigger in it.

    Args:
        stepper: It has made the step, and not taken it over.
        watch: Condition that is watched.
        loads: Of elements that may break.
        surpassed: Whether springs may rupture in the step.
    """
    inside, work = bound_inside(stepper.integrator), stepper.table(stepper.work)
    within = AcceptedStep(inside, stepper.progress, work, stepper.acting(), stepper.inputs)
    looks, ruptures = stepper.integrator.looks, list[tuple[float, Indices] | None]()
    if surpassed:
        ruptures.append(within.first_rupture(Limits.of(stepper.inputs), looks))
    start = stepper.work.x[stepper.progress.current]
    if loads is not None and may_break(loads, stepper, start, 1):
        ruptures.append(within.first_rupture(LoadedElements(loads), looks))
    # What breaks at the same time as the first does so as the run continues from there.
    found = (one for one in ruptures if one is not None)
    rupture = min(found, key=lambda one: one[0], default=None)
    if watch is None:
        stepper.update(glanced=0)
    stop = within.end if rupture is None else rupture[0]
    triggered = None if watch is None else _trigger(stepper, within, watch, stop)
    if triggered is not None and (rupture is None or triggered < stop):
        return within, Interruption("triggered", triggered)
    if rupture is None:
        return within, None
    return within, Interruption("ruptured", stop, springs=rupture[1])


def _trigger(stepper: Stepper, within: AcceptedStep, watch: Watch, stop: float) -> float | None:
    """Return the first time up to ``stop`` at which the condition is seen to hold [s].

    Args:
        stepper: It has computed states within the step.
        watch: The condition.
        stop: Time in the step [s].
    """
    positions, outwards = stepper.inputs.positions, stepper.inputs.outwards

    def holds(when: float) -> bool:
        x, v, _ = within.state(when)
        return watch(when, positions(x), outwards(v))

    before, buffer = within.start, stepper.buffer.buffer
    resolution = max(RESOLUTION * (stop - before), 1e-15 * stepper.method.duration)
    times: Floats = buffer.glance_time[: stepper.progress.glanced]
    stepper.update(glanced=0)
    # Of many short steps, others have states here, and this one may have none.
    for row in np.flatnonzero((times > before) & (times < stop)):
        when, x, v = float(times[row]), buffer.glance_position[row], buffer.glance_velocity[row]
        # A glance is cheap and a little wrong; what it finds is examined closely.
        if watch(when, positions(x), outwards(v)) and holds(when):
            return bisect(holds, before, when, resolution)
        before = when
    return bisect(holds, before, stop, resolution) if holds(stop) else None


def cut_step(stepper: Stepper, within: AcceptedStep, stop: float) -> None:
    """Take over the accepted step up to a time within it, with its samples before that.

    Args:
        stepper: It has made the step.
        stop: Time in the step [s].
    """
    while stepper.buffer.is_due(stepper.progress, stop):
        when = float(stepper.buffer.buffer.times[stepper.progress.sample])
        stepper.progress = stepper.buffer.enter(stepper.progress, *within.state(when))
    x, v, ledger = within.state(stop)
    work, now = stepper.work, stepper.progress.current
    work.x[now], work.v[now], work.ledger[now] = x, v, ledger
    stepper.update(time=stop, pending=0, fresh=1)
