"""Events within an accepted step: ruptures and triggers, found on its dense output."""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.calls import first_of
from tissuec.compiled.record_tables import RecordTable
from tissuec.engine.backends import Inside
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.operations import OPERATIONS
from tissuec.kernels.records import Progress
from tissuec.model.network import Floats, Indices

FINE = 32  # pieces in which a suspect spring is followed
TOGETHER = 1e-11  # springs this near to a limit, relative to it, break together
CLOSE = 1.0 - 1e-4  # of the limit: loads that may exceed it between two states
# Springs are followed over the step whose load may come close to the limit: it is above this
# part of it, and not further away than it swings in the step, so many times.
SUSPECT, SWINGS = 0.99, 4.0
RESOLUTION = 1e-12  # of the step, to which times are located

Watch = Callable[[float, Floats, Floats], bool]
Survey = Callable[[Floats, Floats, Floats], bool]


class Breakable(Protocol):
    """What can break within a step, with a limit each."""

    @property
    def force(self) -> Floats:
        """Return the limits in the unit of the loads, shape (limit,)."""
        ...

    @property
    def springs(self) -> Indices:
        """Return the numbers of the springs that die at each limit, shape (limit,)."""
        ...

    def loads(self, within: "AcceptedStep", when: float) -> Floats:
        """Return the quantities to compare with the limits at a time [s], shape (limit,)."""
        ...

    def some(self, chosen: NDArray[np.bool_] | list[int]) -> Self:
        """Return a selection of limits, by a mask of shape (limit,) or by indices."""
        ...


class AcceptedStep:
    """The accepted step that has not been taken over yet.

    Args:
        inside: Code that evaluates the step inside.
        progress: With a pending step.
        work: The arrays of the run, as a table.
        net: What acts, as a table.
        inputs: The places of nodes and springs.
    """

    def __init__(
        self,
        inside: Inside,
        progress: Progress,
        work: RecordTable,
        net: RecordTable,
        inputs: KernelInputs,
    ):
        self._inside, self._work, self._net, self._inputs = inside, work, net, inputs
        self.start, self.end, self._current = progress.time, progress.end, progress.current
        self._prepared = bool(progress.prepared)

    def state(self, when: float) -> tuple[Floats, Floats, Floats]:
        """Return flat positions [m], velocities [m/s] and the ledger [J] at a time in the step.

        The shapes are (3 node,) twice, and (2,).
        """
        work, now = self._work, self._current
        if when == self.end:
            other = 1 - now
            return work.x[other].copy(), work.v[other].copy(), work.ledger[other].copy()
        x, v, ledger = np.empty_like(work.zero), np.empty_like(work.zero), np.zeros(2)
        self._look_into(x, v, ledger)(when)
        return x, v, ledger

    def _look_into(self, x: Floats, v: Floats, ledger: Floats) -> Callable[[float], object]:
        """Return a function that sets arrays to the state at a time before the end of the step.

        It does not look each time where these arrays are, which takes longer than the rest.

        Args:
            x, v: Positions [m] and velocities [m/s], flat, shape (3 node,).
            ledger: [J], shape (2,).
        """
        work, now = self._work, self._current
        if not self._prepared:
            self._inside.prepare(self.start, self.end, now, work, self._net)
            self._prepared = True
        look = first_of(self._inside.look, x, v, ledger, work, self._net)
        return lambda when: look(when, self.start, self.end, now)

    @cached_property
    def _tensions(self) -> Callable[[float], Floats]:
        """Return a function that returns the tensions at a time before the end of the step."""
        x, v = np.empty_like(self._work.zero), np.empty_like(self._work.zero)
        tension = np.empty(len(self._inputs.springs.ids))
        look = self._look_into(x, v, np.zeros(2))
        pull = first_of(OPERATIONS["tension"], x, v, tension, self._net)

        def tensions(when: float) -> Floats:
            look(when)
            pull()
            return tension

        return tensions

    def tensions(self, when: float) -> Floats:
        """Return the tensions of the springs that act at a time in the step [N].

        The shape is (spring,); the next call may overwrite them.
        """
        if when != self.end:
            return self._tensions(when)
        x, v, _ = self.state(when)
        OPERATIONS["place"](when, x, v, self._net)  # rest lengths of this time
        tension = np.empty(len(self._inputs.springs.ids))
        OPERATIONS["tension"](x, v, tension, self._net)
        return tension

    def first_rupture(self, limits: Breakable, looks: int) -> tuple[float, Indices] | None:
        """Return when the first limit is exceeded [s], and the springs that break then.

        Their indices have the shape (n,); None if no limit is exceeded.

        Args:
            limits: Of all that can break.
            looks: Number of states within the step that are tested first.
        """
        limits = self._suspects(limits, looks)
        if not len(limits.force):
            return None
        times = np.linspace(self.start, self.end, FINE + 1)
        loads = np.array([limits.loads(self, t) for t in times])
        first = np.inf
        for row in range(len(limits.force)):
            limit = limits.some([row])
            bracket = self._bracket(times, loads[:, row], limit)
            if bracket is None or bracket[0] >= first:
                continue
            below, above = bracket
            # A spring that is surpassed after the first rupture so far is of no interest.
            if above < first or self._exceeds(first, limit):
                first = self._crossing(below, min(above, first), limit)
        if first == np.inf:
            return None
        broken = limits.loads(self, first) >= limits.force * (1.0 - TOGETHER)
        return float(first), np.sort(limits.springs[broken]).astype(np.int64)

    def _suspects(self, limits: Breakable, looks: int) -> Breakable:
        """Return the limits that loads come close to at any look."""
        times = np.linspace(self.start, self.end, looks + 1)
        loads = np.array([limits.loads(self, t) for t in times])
        tops = parabola_tops(loads[:-2], loads[1:-1], loads[2:]).max(axis=0)
        highest, force = tops + SWINGS * np.ptp(loads, axis=0), limits.force
        return limits.some((tops > SUSPECT * force) & (highest > CLOSE * force))

    def _bracket(
        self, times: Floats, loads: Floats, limit: Breakable
    ) -> tuple[float, float] | None:
        """Return times below and above the first crossing of one limit, None without one."""
        above = np.flatnonzero(loads > limit.force)
        first = int(above[0]) if len(above) else len(times)
        if first == 0:
            return times[0], times[0]
        tops = parabola_tops(loads[:-2], loads[1:-1], loads[2:])
        for peak in np.flatnonzero(tops > limit.force * CLOSE) + 1:
            if peak >= first:
                break
            if loads[peak] < max(loads[peak - 1], loads[peak + 1]):
                continue
            summit = self._summit(times[peak - 1], times[peak + 1], limit)
            if self._exceeds(summit, limit):
                return times[peak - 1], summit
        return (times[first - 1], times[first]) if first < len(times) else None

    def _summit(self, low: float, high: float, limit: Breakable) -> float:
        """Return when the load of one limit is largest, by golden section."""
        ratio = 0.5 * (np.sqrt(5.0) - 1.0)
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        value_left, value_right = limit.loads(self, left)[0], limit.loads(self, right)[0]
        # Times in a very short step are only as fine as rounding lets them be.
        while high - low > max(1e-8 * (self.end - self.start), 4.0 * np.spacing(self.end)):
            if value_left > value_right:
                high, right, value_right = right, left, value_left
                left = high - ratio * (high - low)
                value_left = limit.loads(self, left)[0]
            else:
                low, left, value_left = left, right, value_right
                right = low + ratio * (high - low)
                value_right = limit.loads(self, right)[0]
        return left if value_left > value_right else right

    def _exceeds(self, when: float, limit: Breakable) -> bool:
        return bool(limit.loads(self, when)[0] > limit.force[0])

    def _crossing(self, below: float, above: float, limit: Breakable) -> float:
        """Return the first time with a load above its limit, by bisection."""
        resolution = RESOLUTION * (self.end - self.start)
        return bisect(lambda when: self._exceeds(when, limit), below, above, resolution)


class Limits(NamedTuple):
    """Forces at which springs break, by tension or by pressure.

    Attributes:
        spring: Places among the springs that act, shape (limit,).
        sign: 1 for tension, -1 for pressure.
        force: Limits of the tension times ``sign`` [N].
        ids: Numbers of all springs that act, shape (spring,).
    """

    spring: Indices
    sign: Floats
    force: Floats
    ids: Indices

    @classmethod
    def of(cls, inputs: KernelInputs) -> "Limits":
        """Return all limits of the springs that act."""
        springs = inputs.springs
        torn = np.flatnonzero(np.isfinite(springs.strength))
        crushed = np.flatnonzero(np.isfinite(springs.crush))
        sign = np.repeat([1.0, -1.0], [len(torn), len(crushed)])
        force = np.concatenate([springs.strength[torn], springs.crush[crushed]])
        return cls(np.concatenate([torn, crushed]), sign, force, springs.ids)

    @property
    def springs(self) -> Indices:
        """Return the numbers of the springs, shape (limit,)."""
        return self.ids[self.spring]

    def loads(self, within: AcceptedStep, when: float) -> Floats:
        """Return tensions or pressures at a time in a step [N], shape (limit,)."""
        return self.sign * within.tensions(when)[self.spring]

    def some(self, chosen: NDArray[np.bool_] | list[int]) -> "Limits":
        """Return a selection of limits, by a mask of shape (limit,) or by indices."""
        return Limits(self.spring[chosen], self.sign[chosen], self.force[chosen], self.ids)


def parabola_tops(before: Floats, here: Floats, after: Floats) -> Floats:
    """Return the largest values of parabolas through three equidistant values.

    Args:
        before, here, after: The values in any unit, all of the same shape.
    """
    bend = 2.0 * here - before - after
    inside_it = (here >= before) & (here >= after) & (bend > 0.0)
    rise = (after - before) ** 2 / (8.0 * np.where(inside_it, bend, 1.0))
    return np.maximum(np.maximum(before, after), here) + np.where(inside_it, rise, 0.0)


def bisect(
    holds: Callable[[float], bool], false_at: float, true_at: float, resolution: float
) -> float:
    """Return a time at which a condition holds, close to one at which it does not.

    Args:
        holds: Condition as a function of time [s].
        false_at: Time at which it fails [s].
        true_at: Time at which it holds [s].
        resolution: Largest distance of both times [s].
    """
    while true_at - false_at > resolution:
        middle = 0.5 * (false_at + true_at)
        if not false_at < middle < true_at:
            break
        if holds(middle):
            true_at = middle
        else:
            false_at = middle
    return true_at
