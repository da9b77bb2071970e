"""Explicit Runge-Kutta methods with their derivatives; see ``kernels.explicit``.

(W. W. Hager, Numer. Math. 87:247, 2000, for the adjoint of Runge-Kutta methods.)
"""

from collections.abc import Iterator

import numpy as np

from tissuec.kernels.explicit import Prescribed, Table
from tissuec.kernels.sensitivity import Seeds, Values
from tissuec.learn.kernels import Kernels
from tissuec.learn.stepping import Act, State, Trail
from tissuec.learn.stepping.onestep import OneStep
from tissuec.learn.stepping.tableau import Tableau
from tissuec.network import Floats, Indices


class Explicit(OneStep):
    """Steps by a tableau whose stages follow from those before."""

    def __init__(self, tableau: Tableau, kernels: Kernels):
        self.name, self.kernels = tableau.name, kernels
        self.table = Table(*tableau.rows)
        self._stages = len(tableau.result)

    def run(self, act: Act, times: Floats, state: State) -> Trail:
        """Return the states at some times."""
        x, v = np.empty((2, len(times), len(state.x)))
        x[0], v[0] = state.x, state.v
        self.kernels.explicit_forward(
            times, x, v, self.table, self._given(act, times), *act.tables,
            *self._room(len(state.x)),
        )  # fmt: skip
        return Trail(times, x, v, np.zeros_like(x))

    def back(
        self, act: Act, trail: Trail, at_x: Floats, at_v: Floats, end: State, by: Values
    ) -> State:
        """Return the derivatives by the first row of a trail."""
        lx, lv = end.x.copy(), end.v.copy()
        by_x, by_v = np.empty((2, self._stages + 1, len(lx)))
        self.kernels.explicit_back(
            trail.times, trail.x, trail.v, self.table, self._given(act, trail.times),
            *act.tables, at_x, at_v, lx, lv, *self._room(len(lx)), by_x, by_v,
            np.empty_like(lx), by,
        )  # fmt: skip
        return State(lx, lv, np.zeros_like(lx))

    def change(
        self, act: Act, trail: Trail, seeds: Seeds, change: State, rows: Indices
    ) -> Iterator[State]:
        """Yield the changes of some rows that follow from those of the first one."""
        tx, tv, _ = change
        room, part = self._room(len(tx)), np.empty(tx.shape[1])
        moved = np.empty_like(tx), np.empty_like(tv)
        known = np.empty((self._stages, *tx.shape))
        step = self.kernels.explicit_change(
            *trail[:3], self.table, self._given(act, trail.times), *act.tables,
            seeds, tx, tv, *room, part, *moved, known,
        )  # fmt: skip
        before = 0
        for row in rows.tolist():
            step(before, row)
            before = row
            yield change

    def _room(self, size: int) -> tuple[Floats, Floats, Floats]:
        """Return arrays for the stages: places, velocities and accelerations."""
        states = np.empty((2, self._stages + 1, size))
        return states[0], states[1], np.empty((self._stages, size))

    def _given(self, act: Act, times: Floats) -> Prescribed:
        """Return what is prescribed at the start of all steps, at stages and at their ends."""
        h = np.diff(times)[:, None]
        inner = times[:-1, None] + h * np.append(0.0, self.table.nodes)
        paths = act.leg.paths(inner.ravel())
        return Prescribed(*(part.reshape(*inner.shape, -1) for part in paths))
