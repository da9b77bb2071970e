"""Common code of methods with a tableau, and explicit ones with their derivatives."""

from collections.abc import Iterator

import numpy as np

from tissuec.compiled.record_tables import tabulated
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.derivatives_kernel import Steps
from tissuec.kernels.derivative_records import Laws, NodeState, NodeStates, Seeds, Values
from tissuec.learn.derivatives.kernels import (
    acceleration,
    pull_back,
    push_forward,
    step_back,
    step_change,
    step_forward,
)
from tissuec.learn.derivatives.stepping import LegForces, StepStates
from tissuec.model.network import Floats, Indices


class ByTableau:
    """The tableau of an integrator, and the beginning of a leg; see ``Stepping``."""

    def __init__(self, name: str, laws: Laws):
        member = INTEGRATORS[name]
        assert member.tableau is not None, f"{name} has no tableau"
        self.name, self.laws, self.tableau = name, laws, tabulated(member.tableau)
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
