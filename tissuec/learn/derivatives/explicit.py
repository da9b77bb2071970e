"""Explicit methods with their derivatives; see ``engine.integrators.derivatives_kernel``."""

from collections.abc import Iterator

import numpy as np

from tissuec.kernels.derivative_records import NodeState, NodeStates, Seeds, Values
from tissuec.learn.derivatives.kernels import step_back, step_change, step_forward
from tissuec.learn.derivatives.stepping import LegForces, StepStates
from tissuec.learn.derivatives.tableaus import ByTableau
from tissuec.model.network import Floats, Indices


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
