"""Methods with a tableau and derivatives of their steps: explicit, implicit, and the choice.

Stage i is at x_i = x + c_i h v + h² Σ X_ij a_j and v_i = v + h Σ V_ij a_j, where a_i is the
acceleration. Where V_ii is not zero, Newton's method finds a_i to rounding, so that derivatives
are exact:

    S = 1 - (h V_ii)² ∂a/∂x - h V_ii ∂a/∂v,    S δa_i = changes by everything before.

Backwards, from the last stage to the first, the derivatives α_i by a_i give μ_i = S⁻ᵀ α_i, and
``pull_back`` of μ_i those by x_i and v_i, which belong to x, v and the stages before.
"""

from collections.abc import Callable, Iterator
from math import factorial
from typing import NamedTuple

import numpy as np

from tissuec.compiled.record_tables import tabulated
from tissuec.core.units import TIME, show
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.derivatives_kernel import (
    Steps,
    length_of,
    moment_of,
    state,
    time_of,
)
from tissuec.engine.method_choice import measured_facts
from tissuec.kernels.derivative_records import NodeState, NodeStates, Seeds, Values
from tissuec.learn.derivatives.matrices import (
    acceleration,
    begin_dues,
    combine_stage,
    enter_stage,
    leave_step,
    pull_back,
    push_forward,
    stage_matrix,
    step_back,
    step_change,
    step_forward,
    weigh_stage,
)
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.derivatives.stepping import LegForces, Stepping, StepStates
from tissuec.learn.parameters.elements import elements_of
from tissuec.learn.parameters.numbers import starting_state
from tissuec.mechanics.stiffness import LowRankFactor
from tissuec.model.inelastic import VISCOSITY
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import AUTOMATIC, Plan


class ByTableau:
    """The tableau of an integrator, and the beginning of a leg; see ``Stepping``."""

    def __init__(self, name: str):
        member = INTEGRATORS[name]
        assert member.tableau is not None, f"{name} has no tableau"
        self.name, self.tableau = name, tabulated(member.tableau)
        # Between both ends of its steps, a cubic is as exact as a method of second order.
        self.lands = member.implicit or member.order > 2
        nodes = self.tableau.for_x[: self.tableau.result + 1, 0]
        # Moments of a step; its end is the beginning of the next one.
        self._parts = np.append(0.0, np.setdiff1d(nodes, [0.0, 1.0]))
        self._moment = np.array([[*self._parts, 1.0].index(node) for node in nodes])

    def begin(self, act: LegForces, x: Floats, v: Floats) -> Floats:
        """Return the accelerations that the first step begins with, if it needs any."""
        a = np.zeros_like(x)
        if self.tableau.carries:
            load = act.leg.paths(np.array([act.leg.start])).load[0]
            acceleration(act.forces, act.leg.start, load, NodeState(x, v, a))
        return a

    def begin_back(self, act: LegForces, start: NodeState, due: NodeState, by: Values) -> None:
        """Add what is due to these accelerations to what is due to the state."""
        if self.tableau.carries:
            pull_back(act.forces, act.leg.start, start, due, by)

    def begin_change(
        self, act: LegForces, start: NodeState, seeds: Seeds, change: NodeState
    ) -> None:
        """Set the changes of these accelerations."""
        if self.tableau.carries:
            push_forward(act.forces, act.leg.start, start, seeds, change)

    def _begun(self, times: Floats, state: NodeState) -> StepStates:
        """Return a trail of which only the first row is known."""
        states = NodeStates(*np.zeros((3, len(times), len(state.x))))
        for rows, first in zip(states, state, strict=True):
            rows[0] = first
        return StepStates(times, states)

    def _room(self, trail: StepStates) -> NodeStates:
        """Return room for all stages up to the result."""
        return NodeStates(*np.empty((3, self.tableau.result + 1, trail.states.x.shape[1])))

    def _steps(self, act: LegForces, times: Floats) -> Steps:
        """Return the steps between some times, with what is prescribed at their stages."""
        within = times[:-1, None] + np.diff(times)[:, None] * self._parts
        paths = act.leg.paths(np.append(within.ravel(), times[-1]))
        return Steps(self.tableau, times, *paths, len(self._parts), self._moment)


class ExplicitStepping(ByTableau):
    """Steps by a tableau whose stages follow from those before."""

    def run(self, act: LegForces, times: Floats, state: NodeState) -> StepStates:
        """Return the states at some times."""
        trail = self._begun(times, state)
        step_forward(act.forces, self._steps(act, times), trail.states, self._room(trail))
        return trail

    def back(
        self,
        act: LegForces,
        trail: StepStates,
        entering: NodeStates,
        due: NodeState,
        by: Values,
    ) -> None:
        """Turn derivatives by the last row of a trail into those by its first row."""
        steps, room = self._steps(act, trail.times), (self._room(trail), self._room(trail))
        step_back(act.forces, steps, trail.states, entering, *room, due, by)

    def change(
        self, act: LegForces, trail: StepStates, seeds: Seeds, change: NodeState, rows: Indices
    ) -> Iterator[None]:
        """Carry changes from the first row on; yield at some rows."""
        moved = NodeState(*(np.empty_like(part) for part in change))
        known = np.empty((self.tableau.result, len(change.x)))
        step = step_change.of_first(
            act.forces, self._steps(act, trail.times), trail.states, self._room(trail),
            seeds, change, moved, known,
        )  # fmt: skip
        for first, last in zip([0, *rows[:-1].tolist()], rows.tolist(), strict=True):
            step(first, last)
            yield


ITERATIONS = 60
SLOW = 0.4  # contraction from which S is made anew, which takes as long as many rounds
ROUNDING = 4.0 * np.finfo(float).eps
NOISE = 1e4  # times rounding: what forces that cancel leave of steps


class Unsolved(Diverged):
    """A stage is not found; the time [s] is its argument."""

    def __str__(self) -> str:
        return f"no solution was found for the step at {show(float(self.args[0]), TIME)}"


class ImplicitStepping(ByTableau):
    """Steps by a tableau whose stages are found one after the other."""

    def __init__(self, name: str):
        super().__init__(name)
        self._own = np.diagonal(self.tableau.for_v[:, 1:])[: self.tableau.result + 1]
        self._factor: LowRankFactor | None = None
        self._factored: tuple[object, float] = (None, 0.0)

    def begin(self, act: LegForces, x: Floats, v: Floats) -> Floats:
        """Return no accelerations; matrices of other numbers are forgotten."""
        self._factor = None
        return super().begin(act, x, v)

    def run(self, act: LegForces, times: Floats, state: NodeState) -> StepStates:
        """Return the states at some times."""
        trail = self._begun(times, state)
        steps = self._steps(act, times)
        for row in range(len(times) - 1):
            stages = self._found(act, steps, row, trail)
            trail.states.x[row + 1], trail.states.v[row + 1] = stages.x[-1], stages.v[-1]
        return trail

    def back(
        self,
        act: LegForces,
        trail: StepStates,
        entering: NodeStates,
        due: NodeState,
        by: Values,
    ) -> None:
        """Turn derivatives by the last row of a trail into those by its first row."""
        steps, dues = self._steps(act, trail.times), self._room(trail)
        for row in range(len(trail.times) - 2, -1, -1):
            stages = self._found(act, steps, row, trail)
            begin_dues(act.forces, due, state(row + 1, entering), dues)
            for i in range(len(dues.a) - 1, -1, -1):
                own, time = length_of(row, steps) * self._own[i], time_of(i, row, steps)
                if i < len(dues.a) - 1:
                    weigh_stage(i, row, steps, dues)
                else:
                    dues.a[i] = own * own * dues.x[i] + own * dues.v[i]
                if own != 0.0:
                    dues.a[i] = self._pulled(act, state(i, stages), own, time, dues.a[i])
                pull_back(act.forces, time, state(i, stages), state(i, dues), by)
            leave_step(row, act.forces, steps, dues, due)

    def change(
        self, act: LegForces, trail: StepStates, seeds: Seeds, change: NodeState, rows: Indices
    ) -> Iterator[None]:
        """Carry changes from the first row on; yield at some rows."""
        steps, looked_at = self._steps(act, trail.times), set(rows.tolist())
        for row in range(len(trail.times) - 1):
            self._change(act, steps, row, trail, seeds, change)
            if row + 1 in looked_at:
                yield

    # --- one step -----------------------------------------------------------------------------

    def _change(
        self,
        act: LegForces,
        steps: Steps,
        row: int,
        trail: StepStates,
        seeds: Seeds,
        change: NodeState,
    ) -> None:
        """Carry changes over a step."""
        stages, h = self._found(act, steps, row, trail), length_of(row, steps)
        x, v, known = *np.empty((2, len(change.x))), np.empty((len(stages.a), len(change.x)))
        for i, own in enumerate(h * self._own):
            moved = NodeState(x, v, known[i])
            combine_stage(i, row, act.forces, steps, change, known, moved)
            time = time_of(i, row, steps)
            at = state(i, stages)

            def image(
                a: Floats, at: NodeState = at, own: float = own, time: float = time,
                x: Floats = x, v: Floats = v,
            ) -> Floats:  # fmt: skip
                there = NodeState(x + own * own * a, v + own * a, np.empty_like(a))
                push_forward(act.forces, time, at, seeds, there)
                return there.a

            moved.a[:] = known[i - 1] if i else 0.0
            if own == 0.0:
                moved.a[:] = image(moved.a)
            else:
                size = ROUNDING * np.abs(x).max(initial=0.0) / (own * own)
                self._find(act, lambda _, at=at: at, own, time, image, moved.a, size)
            x += own * own * moved.a
            v += own * moved.a
        change.x[:], change.v[:] = x, v

    def _found(self, act: LegForces, steps: Steps, row: int, trail: StepStates) -> NodeStates:
        """Return all stages of a step, the last of which is its result."""
        start, stages, h = state(row, trail.states), self._room(trail), length_of(row, steps)
        for i, own in enumerate(h * self._own):
            at, load = state(i, stages), steps.load[moment_of(i, row, steps)]
            enter_stage(i, row, act.forces, steps, start, stages.a, at)
            if own == 0.0:
                acceleration(act.forces, time_of(i, row, steps), load, at)
            else:
                at.a[:] = stages.a[i - 1] if i else 0.0
                self._solve(act, at, load, own, time_of(i, row, steps))
        return stages

    def _solve(
        self, act: LegForces, at: NodeState, load: Floats, own: float, time: float
    ) -> None:
        """Find the a with a = a(x + own² a, v + own a), by Newton's method to rounding.

        Args:
            at: x and v, and a guess of a; then the solution.
        """

        def there(a: Floats) -> NodeState:
            return NodeState(at.x + own * own * a, at.v + own * a, np.empty_like(a))

        def image(a: Floats) -> Floats:
            found = there(a)
            acceleration(act.forces, time, load, found)
            return found.a

        size = ROUNDING * np.abs(at.x).max() / (own * own)
        self._find(act, there, own, time, image, at.a, size)
        at.x[:] += own * own * at.a
        at.v[:] += own * at.a

    def _pulled(
        self, act: LegForces, at: NodeState, own: float, time: float, due: Floats
    ) -> Floats:
        """Return S⁻ᵀ times derivatives by accelerations, shape (3 node,)."""
        aside, found = act.leg.nothing, due.copy()

        def image(a: Floats) -> Floats:
            by = NodeState(np.zeros_like(a), np.zeros_like(a), a.copy())
            pull_back(act.forces, time, at, by, aside)
            return due + own * own * by.x + own * by.v

        least = ROUNDING * np.abs(due).max(initial=0.0)
        self._find(act, lambda _: at, own, time, image, found, least, transposed=True)
        return found

    def _find(
        self, act: LegForces, there: Callable[[Floats], NodeState], own: float, time: float,
        image: Callable[[Floats], Floats], found: Floats, least: float, *,
        transposed: bool = False,
    ) -> None:  # fmt: skip
        """Find what is its own image, by Newton's method with a kept S; raises Unsolved.

        Args:
            there: Returns the state in which S is made anew.
            image: Of accelerations, or of derivatives by them, shape (3 node,), or with several
                changes of each component.
            found: A guess; then the solution.
            least: Size of steps that are rounding.
            transposed: Whether the derivative of the image is that of Sᵀ.
        """
        before, is_exact = np.inf, False
        for _ in range(ITERATIONS):
            left, factor = image(found) - found, self._factor
            if factor is None or not self._is_made_for(act, own):
                factor = self._made(act, there(found), own, time)
            solve = factor.solve_transposed if transposed else factor.solve
            count = len(act.forces.links.inverse) * 3
            step = solve(left.reshape(count, -1)).reshape(left.shape)
            found += step
            size, scale = np.abs(step).max(initial=0.0), np.abs(found).max(initial=0.0)
            if size <= ROUNDING * scale + least:
                return
            # What is left is rounding where steps no longer become shorter, or S is exact.
            left_is_small = size <= 1e-9 * scale + NOISE * least
            if (left_is_small and 2.0 * size >= before) or (is_exact and size <= 1e-6 * scale):
                return
            if not np.isfinite(size):
                break
            is_exact = size > SLOW * before
            if is_exact:
                self._made(act, there(found), own, time)
            before = size
        raise Unsolved(time)

    def _is_made_for(self, act: LegForces, own: float) -> bool:
        """Return whether S is that of a leg, for a step that differs by rounding only."""
        leg, size = self._factored
        return leg is act.leg and abs(size - own) <= 1e-9 * own

    def _made(self, act: LegForces, at: NodeState, own: float, time: float) -> LowRankFactor:
        """Return S, factorised, and keep it."""
        self._factor = self._factorised(act, at, own, time)
        self._factored = act.leg, own
        return self._factor

    def _factorised(
        self, act: LegForces, at: NodeState, own: float, time: float
    ) -> LowRankFactor:
        """Return S, factorised; raises Unsolved where it is singular."""
        try:
            return stage_matrix(act, time, at, own)
        except RuntimeError as failure:
            raise Unsolved(time) from failure


# Errors of a step h of order p are about (h ω)ᵖ / (p + 1)!: at this, they are near 1e-6 of the
# motion after some swings.
FINE = 1 / 15_000
YIELDING = 4.0  # times as fine where springs yield: steps do not end where they begin to
MOST = 50_000  # explicit steps above which a method is implicit
MOST_OF_ELEMENTS = 3_000  # the same, of elements


class ChosenMethod(NamedTuple):
    """A method and its largest step [s]."""

    stepping: Stepping
    step: float


def choose(
    name: str, step: float | None, network: Network, plan: Plan, *, duration: float,
) -> ChosenMethod:  # fmt: skip
    """Return the method and step of a motion.

    Args:
        name: Of an integrator with a tableau; "automatic" chooses DOP853, or ESDIRK4(3) for
            stiff nets.
        step: Step size [s]; None: so that errors are small compared with those of any
            measurement.
        network: With numbers in its laws.
        plan: The plan of the experiment, with numbers in its forces.
        duration: Of the experiment [s].
    """
    state = starting_state(plan, network)
    facts = measured_facts(state)
    rate = facts["omega"] * max(1.0, 2.0 * facts["zeta"])
    rate = max(rate, state.acting.giving(state.position))
    has_elements = bool(elements_of(network))
    if name == AUTOMATIC:
        most = MOST_OF_ELEMENTS if has_elements else MOST
        explicit = duration * rate / swing(INTEGRATORS["dop853"].order) <= most
        explicit |= network.springs.inelastic is not None or network.contact is not None
        name = "dop853" if explicit else "esdirk43"
    member = INTEGRATORS[name]
    if step is None:
        if member.implicit:
            # Elements have larger errors by their sizes, and steps cost more.
            step = duration / ((20 if has_elements else 160) * 5 ** (4 / member.order))
        else:
            step = swing(member.order) / rate if rate else duration / 20
            if (
                network.springs.inelastic is not None
                and network.springs.inelastic.has(VISCOSITY).any()
            ):
                step /= YIELDING
    step = min(step, duration) if np.isfinite(step) else duration
    stepping = ImplicitStepping if member.implicit else ExplicitStepping
    return ChosenMethod(stepping(name), step)


def swing(order: int) -> float:
    """Return the steps of explicit methods in units of 1/ω, to two digits."""
    return float(f"{(FINE * factorial(order + 1)) ** (1 / order):.2g}")
