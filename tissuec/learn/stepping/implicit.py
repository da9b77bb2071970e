"""Runge-Kutta methods for x'' = a(x, v) with one implicit stage after another.

Stage i is at x_i = x + c_i h v + h² Σ (A²)_ij a_j and v_i = v + h Σ A_ij a_j, where a_i is the
acceleration; the step ends at x + h v + h² Σ (b A)_j a_j and v + h Σ b_j a_j. Where A_ii is not
zero, Newton's method finds a_i to rounding, so that the derivatives are exact:

    S = 1 - (h A_ii)² ∂a/∂x - h A_ii ∂a/∂v,    S δa_i = changes by everything before.

Backwards, from the last stage to the first, the derivatives α_i by a_i give μ_i = S⁻ᵀ α_i, and
``pull_back`` of μ_i those by x_i and v_i, which belong to x, v and the stages before.
(W. W. Hager, Numer. Math. 87:247, 2000, for the adjoint of Runge-Kutta methods.)
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from tissuec.core.units import TIME, show
from tissuec.kernels.sensitivity import Seeds, Values
from tissuec.learn.course import Paths
from tissuec.learn.kernels import Kernels
from tissuec.learn.motion import Diverged
from tissuec.learn.stepping import Act, State, Trail
from tissuec.learn.stepping.matrices import Matrices
from tissuec.learn.stepping.onestep import OneStep
from tissuec.learn.stepping.tableau import Tableau
from tissuec.network import Floats, Indices

ITERATIONS = 40
SLOW = 0.1  # contraction from which S is made anew
ROUNDING = 4.0 * np.finfo(float).eps


class Unsolved(Diverged):
    """A stage is not found; the time [s] is its argument."""

    def __str__(self) -> str:
        return f"a step at {show(float(self.args[0]), TIME)} has no solution that can be found"


class Stage(NamedTuple):
    """One stage that was found: where it is, and what is prescribed there."""

    x: Floats
    v: Floats
    a: Floats


class Implicit(OneStep):
    """Steps by a tableau."""

    def __init__(self, tableau: Tableau, kernels: Kernels, matrices: Matrices):
        self.name, self.tableau = tableau.name, tableau
        self.kernels, self.matrices = kernels, matrices
        self._stages = len(tableau.result)
        self._for_x, self._for_v, self._nodes = tableau.rows
        self._factor: SuperLU | None = None
        self._factored: tuple[object, float] = (None, 0.0)

    def begin(self, act: Act, x: Floats, v: Floats) -> Floats:
        """Return no accelerations; matrices of other numbers are forgotten."""
        self._factor = None
        return super().begin(act, x, v)

    def run(self, act: Act, times: Floats, state: State) -> Trail:
        """Return the states at equidistant times."""
        x, v, a = np.zeros((3, len(times), len(state.x)))
        x[0], v[0], a[0] = state
        for row in range(len(times) - 1):
            *_, end = self._step(act, times, row, x[row], v[row])
            x[row + 1], v[row + 1] = end.x, end.v
        return Trail(times, x, v, a)

    def back(
        self, act: Act, trail: Trail, at_x: Floats, at_v: Floats, end: State, by: Values
    ) -> State:
        """Return the derivatives by the first row of a trail."""
        lx, lv = end.x.copy(), end.v.copy()
        for row in range(len(trail.times) - 2, -1, -1):
            lx += at_x[row + 1]
            lv += at_v[row + 1]
            lx, lv = self._step_back(act, trail, row, lx, lv, by)
        return State(lx, lv, np.zeros_like(lx))

    def change(
        self, act: Act, trail: Trail, seeds: Seeds, change: State, rows: Indices
    ) -> Iterator[State]:
        """Yield the changes of some rows that follow from those of the first one."""
        looked_at = set(rows.tolist())
        for row in range(len(trail.times) - 1):
            change = self._step_change(act, trail, row, seeds, change)
            if row + 1 in looked_at:
                yield change

    # --- one step -----------------------------------------------------------------------------

    def _step(self, act: Act, times: Floats, row: int, x: Floats, v: Floats) -> Iterator[Stage]:
        """Yield all stages and, last, the state at the end of the step with no acceleration."""
        h = times[row + 1] - times[row]
        accelerations = np.zeros((self._stages, len(x)))
        paths = self._paths(act, times, row)
        free = np.repeat(~act.leg.held, 3)
        driven = _three(act.links.driven)
        for i in range(self._stages + 1):
            stage_x, stage_v = x.copy(), np.zeros_like(v)
            known = accelerations[:i]
            place = x + h * self._nodes[i] * v + h * h * (self._for_x[i, :i] @ known)
            stage_x[free] = place[free]
            stage_v[free] = (v + h * (self._for_v[i, :i] @ known))[free]
            # Driven nodes go on from where they are.
            stage_x[driven] += paths.place[i + 1] - paths.place[0]
            stage_v[driven] = paths.speed[i + 1]
            if i == self._stages:
                yield Stage(stage_x, stage_v, np.zeros_like(x))
                return
            own = h * self.tableau.weights[i, i]
            load = paths.load[i + 1]
            if own == 0.0:
                self.kernels.acceleration(stage_x, stage_v, load, *act.tables, accelerations[i])
            else:
                guess = accelerations[i - 1] if i else np.zeros_like(x)
                time = times[row] + h * self._nodes[i]
                accelerations[i] = self._solve(act, stage_x, stage_v, load, own, guess, time)
                stage_x += own * own * accelerations[i]
                stage_v += own * accelerations[i]
            yield Stage(stage_x, stage_v, accelerations[i])

    def _solve(
        self, act: Act, x: Floats, v: Floats, load: Floats, own: float, guess: Floats,
        time: float,
    ) -> Floats:  # fmt: skip
        """Return the a with a = a(x + own² a, v + own a), by Newton's method to rounding."""
        a, found, before = guess.copy(), np.empty_like(guess), np.inf
        for _ in range(ITERATIONS):
            at = x + own * own * a, v + own * a
            self.kernels.acceleration(*at, load, *act.tables, found)
            factor = self._factor
            if factor is None or not self._is_made_for(act, own):
                factor = self._made(act, *at, own, time)
            step = factor.solve(found - a)
            a += step
            size, scale = np.abs(step).max(initial=0.0), np.abs(a).max(initial=0.0)
            noise = ROUNDING * (scale + np.abs(x).max() / (own * own))
            if size <= noise or (size < 1e-9 * scale and size >= before):
                return a
            if not np.isfinite(size):
                break
            if size > SLOW * before:
                self._made(act, x + own * own * a, v + own * a, own, time)
            before = size
        raise Unsolved(time)

    def _is_made_for(self, act: Act, own: float) -> bool:
        """Tell whether S is that of a leg, for a step that differs by rounding only."""
        leg, size = self._factored
        return leg is act.leg and abs(size - own) <= 1e-9 * own

    def _made(self, act: Act, x: Floats, v: Floats, own: float, time: float) -> SuperLU:
        """Return S, factorised, and keep it."""
        self._factor = self._factorised(act, x, v, own, time)
        self._factored = act.leg, own
        return self._factor

    def _factorised(self, act: Act, x: Floats, v: Floats, own: float, time: float) -> SuperLU:
        """Return S, factorised; raises Unsolved where it is singular."""
        try:
            return splu(self.matrices.solver(act, x, v, own))
        except RuntimeError as failure:
            raise Unsolved(time) from failure

    def _step_back(
        self, act: Act, trail: Trail, row: int, lx: Floats, lv: Floats, by: Values
    ) -> tuple[Floats, Floats]:
        """Return derivatives by the beginning of a step from those by its end."""
        h = trail.times[row + 1] - trail.times[row]
        *stages, _ = self._step(act, trail.times, row, trail.x[row], trail.v[row])
        held = np.repeat(act.leg.held, 3)
        lv = np.where(held, 0.0, lv)
        by_x, by_v = np.zeros((2, self._stages + 1, len(lx)))
        by_x[-1], by_v[-1] = lx, lv
        for i in range(self._stages - 1, -1, -1):
            stage, later = stages[i], slice(i + 1, self._stages + 1)
            weight = h * h * (self._for_x[later, i] @ by_x[later])
            weight += h * (self._for_v[later, i] @ by_v[later])
            weight[held] = 0.0
            own = h * self.tableau.weights[i, i]
            if own != 0.0:
                factor = self._factorised(act, stage.x, stage.v, own, trail.times[row])
                weight = factor.solve(weight, "T")
            self.kernels.pull_back(
                stage.x, stage.v, stage.a, weight, *act.tables, by_x[i], by_v[i], by
            )
            by_v[i, held] = 0.0
        total = by_x.sum(axis=0)
        # Velocities of held nodes are prescribed.
        return total, np.where(held, 0.0, by_v.sum(axis=0) + h * (self._nodes @ by_x))

    def _step_change(
        self, act: Act, trail: Trail, row: int, seeds: Seeds, change: State
    ) -> State:
        """Return the changes at the end of a step from those at its beginning."""
        h = trail.times[row + 1] - trail.times[row]
        *stages, _ = self._step(act, trail.times, row, trail.x[row], trail.v[row])
        tx, tv, _ = change
        held = np.repeat(act.leg.held, 3)
        part = np.empty(tx.shape[1])
        known = np.zeros((self._stages, *tx.shape))
        for i, stage in enumerate(stages):
            at_x, at_v = self._changed(i, h, tx, tv, known, held)
            self.kernels.push_forward(
                stage.x, stage.v, stage.a, at_x, at_v, *act.tables, seeds, part,
                known[i],
            )  # fmt: skip
            own = h * self.tableau.weights[i, i]
            if own != 0.0:
                factor = self._factorised(act, stage.x, stage.v, own, trail.times[row])
                known[i] = factor.solve(known[i])
        return State(*self._changed(self._stages, h, tx, tv, known, held), change.a)

    def _changed(
        self, i: int, h: float, tx: Floats, tv: Floats, known: Floats, held: NDArray[np.bool_]
    ) -> tuple[Floats, Floats]:
        """Return the changes of a stage that follow from those before it."""
        for_x = np.tensordot(self._for_x[i, :i], known[:i], axes=1)
        for_v = np.tensordot(self._for_v[i, :i], known[:i], axes=1)
        at_x = tx + h * self._nodes[i] * np.where(held[:, None], 0.0, tv) + h * h * for_x
        return at_x, np.where(held[:, None], 0.0, tv + h * for_v)

    def _paths(self, act: Act, times: Floats, row: int) -> Paths:
        """Return what is prescribed at the start of a step, at all stages and at its end."""
        h = times[row + 1] - times[row]
        return act.leg.paths(np.append(times[row], times[row] + h * self._nodes))


def _three(nodes: Indices) -> Indices:
    """Return where the components of nodes are, shape (3 node,)."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()
