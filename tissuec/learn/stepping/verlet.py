"""Velocity Verlet with predicted velocity, as in ``integrators.verlet``, with derivatives."""

from collections.abc import Iterator

import numpy as np

from tissuec.kernels.sensitivity import Seeds, Values
from tissuec.learn.kernels import Kernels
from tissuec.learn.stepping import Act, State, Trail
from tissuec.network import Floats, Indices


class Verlet:
    """One force a step, second order; its adjoint is the backpropagation of the paper."""

    name = "velocity verlet"
    lands = False

    def __init__(self, kernels: Kernels):
        self.kernels = kernels

    def begin(self, act: Act, x: Floats, v: Floats) -> Floats:
        """Return the accelerations at the beginning of a leg."""
        a = np.empty_like(x)
        load = act.leg.paths(np.array([act.leg.start])).load[0]
        self.kernels.acceleration(x, v, load, *act.tables, a)
        return a

    def begin_back(
        self, act: Act, x: Floats, v: Floats, a: Floats, due: State, by: Values
    ) -> tuple[Floats, Floats]:
        """Return derivatives by state from those by the state and its accelerations."""
        lx, lv = due.x.copy(), due.v.copy()
        self.kernels.pull_back(x, v, a, due.a, *act.tables, lx, lv, by)
        return lx, lv

    def begin_change(
        self, act: Act, x: Floats, v: Floats, a: Floats, seeds: Seeds, tx: Floats, tv: Floats
    ) -> Floats:
        """Return the changes of the accelerations at the beginning of a leg."""
        ta, part = np.empty_like(tx), np.empty(tx.shape[1])
        self.kernels.push_forward(x, v, a, tx, tv, *act.tables, seeds, part, ta)
        return ta

    def run(self, act: Act, times: Floats, state: State) -> Trail:
        """Return the states at equidistant times."""
        x, v, a = np.empty((3, len(times), len(state.x)))
        x[0], v[0], a[0] = state
        place, speed, load = act.leg.paths(times)
        way = np.diff(place, axis=0)
        h = _step(times)
        self.kernels.verlet_forward(x, v, a, h, way, speed, load, *act.tables)
        return Trail(times, x, v, a)

    def back(
        self, act: Act, trail: Trail, at_x: Floats, at_v: Floats, end: State, by: Values
    ) -> State:
        """Return the derivatives by the first row of a trail."""
        lx, lv, la = (part.copy() for part in end)
        guess, weight = np.empty((2, len(lx)))
        h = _step(trail.times)
        self.kernels.verlet_back(
            *trail[1:], h, *act.tables, at_x, at_v, lx, lv, la, guess, weight, by
        )
        return State(lx, lv, la)

    def change(
        self, act: Act, trail: Trail, seeds: Seeds, change: State, rows: Indices
    ) -> Iterator[State]:
        """Yield the changes of some rows that follow from those of the first one."""
        tx, tv, ta = change
        part, guess = np.empty(tx.shape[1]), np.empty(len(tx))
        predicted, ta_end = np.empty_like(tx), np.empty_like(tx)
        step = self.kernels.verlet_change(
            *trail[1:], _step(trail.times), *act.tables, seeds, guess, part,
            tx, tv, ta, predicted, ta_end,
        )  # fmt: skip
        before = 0
        for row in rows.tolist():
            step(before, row)
            before = row
            yield change


def _step(times: Floats) -> float:
    """Return the step between equidistant times [s]."""
    return (times[-1] - times[0]) / (len(times) - 1)
