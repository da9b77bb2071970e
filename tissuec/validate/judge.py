"""The verdict on a run.

What is promised are positions, by the tolerance; and since an integrator that loses energy is
wrong even where positions look right, the energy ledger must close to the same tolerance.
Velocities, forces and times of events follow from positions with factors of their own (spring
constants, frequencies): they are told, with what positions within the promise would allow,
and not judged. The exception is the force on a tool that touches nothing, which depends on no
position of a body.
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.validate import compare
from tissuec.validate.compare import QuantityError
from tissuec.validate.engine_run import Observed
from tissuec.validate.events import (
    Matching,
    between_events,
    break_times,
    firing_times,
    match,
    missed,
    near_ties,
)
from tissuec.validate.uncertainty import EstimatedReference

Verdict = Literal["kept", "broken", "undecided", "nothing promised", "diverged"]


class Judge:
    """Holds a run against a reference.

    Attributes:
        tolerance: What was promised; None for a fixed step.
        ruptures, triggers: How events match.
        until: Until when positions are judged [s]: as long as the reference is known well
            enough, and no near tie between springs has parted it from the run.
        quantities: All errors; positions and energy balance first.
        verdict: On the promise.
    """

    ruptures: Matching
    triggers: Matching

    def __init__(self, compiled: Compiled, run: Observed, known: EstimatedReference):
        self._network, self._plan = compiled.network, compiled.plan
        self._run, self._known = run, known
        self._duration = self._plan.simulation.duration
        self.tolerance = self._plan.simulation.tolerance
        between = self._match_events()
        self.until = self._horizon()
        self.quantities = self._measure(valid=~between)
        self.verdict: Verdict = self._decide()

    def _match_events(self) -> NDArray[np.bool_]:
        """Match events; return at which rows some event happened in one solution only."""
        run, reference = self._run, self._known.reference
        broken = break_times(run.breaks), break_times(reference.breaks)
        fired = firing_times(run.firings), firing_times(reference.firings)
        shift = (self.tolerance or 0.0) * float(reference.displacement[-1])
        strains = run.strain, reference.strain
        misses = near_ties(missed(*broken), self._network, strains, shift)
        self.ruptures = match(*broken, misses, self._duration)
        self.triggers = match(*fired, missed(*fired), self._duration)
        masks = [between_events(run.times, *t, self._duration) for t in (broken, fired)]
        return masks[0] | masks[1]

    def _horizon(self) -> float:
        known = self._known.horizon(self.tolerance) if self.tolerance else self._duration
        ties = [miss.time for miss in self.ruptures.misses if miss.is_tie]
        return min([known, *(float(np.nextafter(time, -np.inf)) for time in ties)])

    def _measure(self, valid: NDArray[np.bool_]) -> tuple[QuantityError, ...]:
        run, reference, bound = self._run, self._known.reference, self.tolerance
        judged = int(np.searchsorted(run.times, self.until, side="right"))
        groups = compare.force_groups(self._plan, reference)
        end = run.outcome.state
        return (
            *compare.position(run, reference, self._network, bound, judged),
            compare.energy_balance(run, self._network, bound),
            compare.velocity(run, reference, self._network, valid),
            *compare.support_forces(run, reference, end, groups, valid, bound),
        )

    def _decide(self) -> Verdict:
        if self.tolerance is None:
            return "nothing promised"
        if any(quantity.is_kept is False for quantity in self.quantities):
            return "broken"
        return "kept" if self.until >= self._run.times[-1] else "undecided"
