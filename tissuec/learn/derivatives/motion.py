"""The motion of a net as a function of its numbers, with derivatives in both directions.

Steps are those of a frozen schedule: equal ones on each leg, or, where a method takes large
ones, equal ones between the observed times. Between steps, places follow the cubic
through places and velocities at both ends. Backwards, only every √N-th state is kept; the rest
is stepped again, one stretch after the other, so that N steps need the memory of 2 √N.
(A. Griewank, A. Walther, Evaluating Derivatives, 2008, chapter 12.)
"""

from collections.abc import Callable, Iterator
from math import ceil, inf, sqrt
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from scipy import sparse

from tissuec.core.units import TIME, show
from tissuec.engine.integrators.derivatives_kernel import state as state_at
from tissuec.kernels.derivative_records import NodeState, NodeStates, Seeds
from tissuec.learn.derivatives.event_schedule import EventSchedule, Leg
from tissuec.learn.derivatives.stepping import LegForces, Stepping, StepStates, act_on
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.model.network import Floats, Indices

REACHED = 0.5  # of a reach, between steps: stages of a step may be further away


class Diverged(Exception):
    """The motion has no numbers any more; the time [s] is its argument."""

    def __str__(self) -> str:
        return f"the motion is not finite after {show(float(self.args[0]), TIME)}"


class SampledStates(NamedTuple):
    """States at the sample times, shape (sample, 3 node)."""

    x: Floats
    v: Floats


class Interpolation(NamedTuple):
    """Places of samples on an interval, and their weights of x, v, x and v at both ends.

    Attributes:
        samples: Their numbers, shape (sample,).
        rows: Rows of the trail before them, shape (sample,).
        of_x, of_v: Weights, shape (4, sample).
    """

    samples: Indices
    rows: Indices
    of_x: Floats
    of_v: Floats


Visit = Callable[[int, Floats, Floats], None]


class StepInterval(Struct, frozen=True, eq=False):
    """Steps of a leg between two stored states.

    Attributes:
        leg: Its number in the schedule.
        times: Of its rows [s], shape (row,).
        between: The samples on it.
        first: Whether its leg begins with it.
    """

    leg: int
    times: Floats
    between: Interpolation
    first: bool


class Motion:
    """The motion on a schedule.

    Args:
        step: Largest step [s].
        times: When the motion is observed [s], ascending, shape (sample,).

    Attributes:
        steps, longest: How many steps there are, and how long the longest is [s].
    """

    def __init__(
        self,
        schedule: EventSchedule,
        stepping: Stepping,
        order: NumberOrder,
        step: float,
        times: Floats,
    ):
        self.schedule, self.stepping, self.order, self.times = schedule, stepping, order, times
        self.leg_of = schedule.leg_at(times)
        grids = [self._grid(k, leg, step) for k, leg in enumerate(schedule.legs)]
        self.steps = sum(len(grid) - 1 for grid in grids)
        self.longest = max(float(np.diff(grid).max()) for grid in grids)
        length = max(1, ceil(sqrt(self.steps)))
        self.stretches = tuple(self._divide(grids, length))
        # Of the last motion: its numbers, the beginning of every stretch, and the last one.
        self._vector: Floats = np.zeros(0)
        self._kept: list[NodeState] = []
        self._last: tuple[LegForces, StepStates] | None = None

    def forward(self, vector: Floats) -> SampledStates:
        """Return the states at ``times``; stores what ``backward`` needs.

        Raises:
            Diverged: They are not finite.
        """
        count = 3 * self.order.sizes["mass"]
        found = SampledStates(*np.empty((2, len(self.times), count)))
        self._vector, self._kept = vector, []
        for stretch, act, trail in self._trails(vector, keep=True):
            end = state_at(-1, trail.states)
            if not (np.isfinite(end.x).all() and np.isfinite(end.v).all()):
                raise Diverged(_last_finite(trail))
            _look(trail, stretch.between, found)
            self._last = act, trail
        return found

    def backward(self, by_x: Floats, by_v: Floats) -> Floats:
        """Return derivatives by all numbers from those by the result of the last ``forward``.

        Args:
            by_x, by_v: By positions [1/m] and velocities [s/m], shape (sample, 3 node).

        Returns:
            Derivatives in the order of numbers, shape (number,).
        """
        order = self.order
        gradient = np.zeros(order.size)
        assert self._last is not None, "forward comes first"
        act, trail = self._last
        size = trail.states.x.shape[1]
        by_x, by_v = _with_rows(by_x, size), _with_rows(by_v, size)
        due = NodeState(*np.zeros((3, size)))
        by = act.leg.nothing
        for number in range(len(self.stretches) - 1, -1, -1):
            stretch = self.stretches[number]
            leg = self.schedule.legs[stretch.leg]
            if number < len(self.stretches) - 1:
                start = self._kept[number]
                if act.leg is not leg:
                    act = self._act(self._vector, leg, start.x)
                    by = act.leg.nothing
                act, trail = self._run(self._vector, act, stretch, start)
            entering = _enter(trail.states, stretch.between, by_x, by_v)
            self.stepping.back(act, trail, entering, due, by)
            due.x[:] += entering.x[0]
            due.v[:] += entering.v[0]
            if stretch.first:
                self.stepping.begin_back(act, state_at(0, trail.states), due, by)
                due.v[np.repeat(leg.stopped, 3)], due.a[:] = 0.0, 0.0
                gradient += leg.past(by)
        order.array(gradient, "position")[:] += due.x
        order.array(gradient, "velocity")[:] += due.v
        return gradient

    def forward_with(
        self,
        vector: Floats,
        change: sparse.csr_matrix,
        visit: Visit,
    ) -> None:
        """Report the derivatives of the states at ``times`` by parameters.

        Args:
            vector: Numbers in SI units, shape (number,).
            change: Of all numbers by each parameter, shape (number, parameter).
            visit: Called, for each sample, with its number and the changes of positions and
                velocities, shape (3 node, parameter), which it must not keep.
        """
        order = self.order
        tx, tv = (
            np.ascontiguousarray(change[order.places[name]].toarray())
            for name in ("position", "velocity")
        )
        moved = NodeState(*(part.ravel() for part in (tx, tv, np.zeros_like(tx))))
        seeds = None
        for stretch, act, trail in self._trails(vector, keep=False):
            leg = self.schedule.legs[stretch.leg]
            if stretch.first:
                seeds = order.seeds(change, leg.factors, leg.acting.numbers)
                tv[np.repeat(leg.stopped, 3)] = 0.0
                self.stepping.begin_change(act, state_at(0, trail.states), seeds, moved)
            assert seeds is not None
            self._change(act, trail, seeds, moved, stretch.between, visit)

    # --- parts --------------------------------------------------------------------------------

    def _divide(self, grids: list[Floats], length: int) -> Iterator[StepInterval]:
        """Yield stretches of at most some steps, with the samples on each."""
        for number, (leg, grid) in enumerate(zip(self.schedule.legs, grids, strict=True)):
            count = len(grid) - 1
            mine = np.flatnonzero(self.leg_of == number)
            times = np.clip(self.times[mine], leg.start, leg.stop)
            row = np.clip(np.searchsorted(grid, times, side="right") - 1, 0, count - 1)
            part = (times - grid[row]) / (grid[row + 1] - grid[row])
            part = np.where(np.abs(part - np.round(part)) < 1e-9, np.round(part), part)
            for first in range(0, count, length):
                last = min(first + length, count)
                chosen = (row >= first) & (row < last)
                step = (grid[row + 1] - grid[row])[chosen]
                between = _between(mine[chosen], row[chosen] - first, part[chosen], step)
                yield StepInterval(number, grid[first : last + 1], between, first == 0)

    def _grid(self, number: int, leg: Leg, step: float) -> Floats:
        """Return the ends of all steps of a leg [s]; on samples, if the method needs that."""
        anchors = np.array([leg.start, leg.stop])
        if self.stepping.lands:
            mine = self.times[self.leg_of == number]
            near = 1e-9 * step
            inner = mine[(mine > leg.start + near) & (mine < leg.stop - near)]
            anchors = np.concatenate([anchors[:1], np.unique(inner), anchors[1:]])
        counts = np.maximum(1, np.ceil(np.diff(anchors) / step * (1.0 - 1e-12))).astype(int)
        parts: list[Floats] = [
            np.linspace(a, b, n + 1)[:-1]
            for a, b, n in zip(anchors, anchors[1:], counts, strict=False)
        ]
        return np.concatenate([*parts, anchors[-1:]])

    def _trails(
        self, vector: Floats, *, keep: bool
    ) -> Iterator[tuple[StepInterval, LegForces, StepStates]]:
        """Yield all stretches, what acts and their states, from the first to the last."""
        order, act = self.order, None
        x, v = order.array(vector, "position").copy(), order.array(vector, "velocity").copy()
        state = NodeState(x, v, np.zeros_like(x))
        for stretch in self.stretches:
            leg = self.schedule.legs[stretch.leg]
            if stretch.first:
                act = self._act(vector, leg, state.x)
                begun = np.where(np.repeat(leg.stopped, 3), leg.given.ravel(), state.v)
                state = NodeState(state.x, begun, self.stepping.begin(act, state.x, begun))
            assert act is not None
            if keep:
                self._kept.append(state)
            act, trail = self._run(vector, act, stretch, state)
            yield stretch, act, trail
            state = trail.last

    def _run(
        self, vector: Floats, act: LegForces, stretch: StepInterval, start: NodeState
    ) -> tuple[LegForces, StepStates]:
        """Return the acting springs near the states of a stretch, and these states.

        Fields that look for what is near look as far as nodes move on the stretch.

        Args:
            vector: Numbers in SI units, shape (number,).
            act: What acts on the leg.
            start: Its first state.
        """
        reach = act.reach
        while True:
            if reach < inf:
                act = self._act(vector, act.leg, start.x, reach)
            trail = self.stepping.run(act, stretch.times, start)
            act.raise_failures()
            if reach == inf or not REACHED * reach < (way := _farthest(trail)) < inf:
                return act, trail
            reach = 2.0 * way / REACHED

    def _act(
        self, vector: Floats, leg: Leg, x: Floats, reach: float | None = None
    ) -> LegForces:
        return act_on(leg, leg.present(vector), x, reach)

    def _change(
        self,
        act: LegForces,
        trail: StepStates,
        seeds: Seeds,
        moved: NodeState,
        between: Interpolation,
        visit: Visit,
    ) -> None:
        """Carry changes to the end of a stretch; yield those of the samples on it."""
        rows = np.unique([*between.rows, *(between.rows + 1), len(trail.times) - 1])
        rows = rows[rows > 0]
        tx, tv = (part.reshape(-1, seeds.room.size) for part in (moved.x, moved.v))
        before = tx.copy(), tv.copy()
        changes = self.stepping.change(act, trail, seeds, moved, rows)
        for row, _ in zip(rows.tolist(), changes, strict=True):
            for k in np.flatnonzero(between.rows == row - 1).tolist():
                visit(int(between.samples[k]), *_mixed(between, k, before, (tx, tv)))
            before = tx.copy(), tv.copy()


def _between(samples: Indices, rows: Indices, part: Floats, step: Floats) -> Interpolation:
    """Return the weights of Hermite's cubic at parts of steps."""
    s, h = part, step
    of_x = [
        (1 + 2 * s) * (1 - s) ** 2,
        h * s * (1 - s) ** 2,
        s * s * (3 - 2 * s),
        h * s * s * (s - 1),
    ]
    of_v = [6 * s * (s - 1) / h, (1 - s) * (1 - 3 * s), 6 * s * (1 - s) / h, s * (3 * s - 2)]
    return Interpolation(samples, rows, np.array(of_x), np.array(of_v))


def _look(trail: StepStates, between: Interpolation, found: SampledStates) -> None:
    """Enter the samples of a stretch."""
    rows, ends, (x, v, _) = between.rows, between.rows + 1, trail.states
    four = x[rows], v[rows], x[ends], v[ends]
    for weights, into in ((between.of_x, found.x), (between.of_v, found.v)):
        into[between.samples] = sum(
            w[:, None] * part for w, part in zip(weights, four, strict=True)
        )


def _with_rows(by: Floats, size: int) -> Floats:
    """Return derivatives by states of nodes with 0 for internal variables behind them.

    Args:
        by: In any unit, shape (sample, 3 node) or (sample, 3 row).
        size: Of a state.

    Returns:
        In the same unit, shape (sample, size).
    """
    return np.pad(by, ((0, 0), (0, size - by.shape[1])))


def _enter(
    states: NodeStates, between: Interpolation, by_x: Floats, by_v: Floats
) -> NodeStates:
    """Return derivatives by the rows of a stretch from those by its samples."""
    (count, size), rows = states.x.shape, between.rows
    at_x, at_v, _ = entering = NodeStates(*np.zeros((3, count, size)))
    for weights, given in ((between.of_x, by_x), (between.of_v, by_v)):
        mine = given[between.samples]
        for into, row, weight in zip(
            (at_x, at_v, at_x, at_v), (rows, rows, rows + 1, rows + 1), weights, strict=True
        ):
            np.add.at(into, row, weight[:, None] * mine)
    return entering


def _mixed(
    between: Interpolation, k: int, before: tuple[Floats, Floats], after: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Return the changes of one sample from those of the rows around it."""

    def weighed(weights: Floats) -> Floats:
        found = np.zeros_like(before[0])
        for weight, part in zip(weights.tolist(), (*before, *after), strict=True):
            if weight:
                found += weight * part
        return found

    return weighed(between.of_x[:, k]), weighed(between.of_v[:, k])


def _farthest(trail: StepStates) -> float:
    """Return how far nodes are from where they are at first, at most [m]."""
    away = (trail.states.x - trail.states.x[0]).reshape(len(trail.times), -1, 3)
    return float(np.sqrt(np.square(away).sum(axis=2).max(initial=0.0)))


def _last_finite(trail: StepStates) -> float:
    """Return the last time at which a motion has numbers [s]."""
    good = (np.isfinite(trail.states.x) & np.isfinite(trail.states.v)).all(axis=1)
    return float(trail.times[max(int(np.argmin(good)) - 1, 0)])
