"""The reference of a static run: equilibria by SciPy's minimisers, from time to time.

Nothing is integrated, so the work is the unexplained part of the change of energies.
"""

from collections.abc import Callable

import numpy as np

from tissuec.model.network import Floats
from tissuec.script.plan import LOAD_STEPS
from tissuec.validate.equations import Equations, overloaded
from tissuec.validate.reference_run import Ending, ReferenceRun
from tissuec.validate.resting import rest
from tissuec.validate.solution import standing_energy

MINIMISERS = "minimisers"  # instead of the name of a method
CLOSE = 1e-7  # of the duration: to this, times of ruptures and triggers are found


class StillEquations(Equations):
    """Equations of a net whose holders move so slowly that dashpots exert no force."""

    def spread(self, time: float, y: Floats) -> tuple[Floats, Floats]:
        """Return displacements [m] of all nodes, and no velocities, shape (node, 3) each."""
        moved, velocity = super().spread(time, y)
        return moved, np.zeros_like(velocity)


class StaticRun(ReferenceRun):
    """One reference under way; see the module."""

    def _equations(self, stop: float) -> Equations:
        return StillEquations(self.state, stop)

    @property
    def _longest(self) -> float:
        """Return the longest time between two equilibria [s]."""
        return self.plan.simulation.step or np.inf

    def _at_once(self, equations: Equations) -> Ending | None:
        """Return nothing: ruptures are determined when the net is at rest."""
        return None

    def _stretch(
        self, equations: Equations, stop: float, progress: Callable[[float], None]
    ) -> Ending:
        """Go from one equilibrium to the next, to a time or to the first break or trigger."""
        state, size = self.state, self._longest
        if (ending := self._rested(equations, state.time)) is not None:
            return ending
        self._look_now(equations)
        while state.time < stop:
            start, position = state.time, state.position.copy()
            ending = self._rested(equations, min(self.track.due, stop, start + size))
            if ending is not None:
                return self._closed_in(equations, start, position, ending)
            self._look_now(equations)
            progress(state.time)
        return Ending(stop, np.zeros(0, dtype=np.int64), [])

    def _closed_in(
        self, equations: Equations, start: float, position: Floats, ending: Ending
    ) -> Ending:
        """Return the first rupture or trigger after a time without one [s]."""
        state = self.state
        while ending.time - start > CLOSE * self.duration:
            middle = 0.5 * (start + ending.time)
            state.time, state.position[:] = start, position
            found = self._rested(equations, middle)
            if found is None:
                start, position = middle, state.position.copy()
            else:
                ending = found
        state.time, state.position[:] = start, position
        return self._rested(equations, ending.time) or ending

    def _rested(self, equations: Equations, time: float) -> Ending | None:
        """Bring the state to equilibrium at a time [s]; return the events there."""
        state = self.state
        state.time = time
        state.place_held()
        state.velocity[:] = 0.0
        rest(state, np.ones(self.network.node_count, dtype=bool))
        self.work = standing_energy(state) - self.initial - self.switched + self.lost
        y = self._y(equations)
        moved, velocity = equations.spread(time, y)
        self.track.measure(equations, time, y)
        broken = overloaded(equations, moved, equations.pull(time, moved, velocity))
        true = self._true(self._now())
        return Ending(time, broken, true) if len(broken) or true else None


class PhasedRun(StaticRun):
    """One reference under way that is static for some intervals."""

    @property
    def _is_still(self) -> bool:
        return self.state.still_until > self.state.time

    @property
    def _longest(self) -> float:
        return self.duration / LOAD_STEPS

    def _equations(self, stop: float) -> Equations:
        of = super()._equations if self._is_still else super(StaticRun, self)._equations
        return of(stop)

    def _at_once(self, equations: Equations) -> Ending | None:
        of = super()._at_once if self._is_still else super(StaticRun, self)._at_once
        return of(equations)

    def _stretch(
        self, equations: Equations, stop: float, progress: Callable[[float], None]
    ) -> Ending:
        of = super()._stretch if self._is_still else super(StaticRun, self)._stretch
        return of(equations, stop, progress)
