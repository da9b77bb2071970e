"""The verdict on a scene: its run compared with the reference, and judged by its promise.

What is promised are positions, by the tolerance; and since an integrator that loses energy is
wrong even where positions look right, the energy ledger must close to the same tolerance.
Velocities, forces and times of events follow from positions with factors of their own (spring
constants, frequencies): they are told, with what positions within the promise would allow,
and not judged.
"""

import time as clock
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tissuec.compiler import Compiled
from tissuec.core.units import TIME, show
from tissuec.validate import compare
from tissuec.validate.compare import Quantity
from tissuec.validate.events import (
    Matching,
    between_events,
    break_times,
    firing_times,
    match,
    missed,
    near_ties,
)
from tissuec.validate.observing import Observed, observe, output_times, thinned
from tissuec.validate.uncertainty import BETTER, Known, Progress, known_reference

Verdict = Literal["kept", "broken", "undecided", "nothing promised", "diverged"]


@dataclass(frozen=True, slots=True, eq=False)
class Validation:
    """What came out.

    Attributes:
        verdict: On the promise.
        reasons: Sentences that explain it.
        tolerance: What was promised; None for a fixed step.
        quantities: Errors; positions and energy balance first. None of a run that diverged.
        ruptures, triggers: How events match; None of a run that diverged.
        judged: Until when positions were judged [s].
        output_times, compared: How many there are, and how many were compared.
        run: What the engine did.
        known: The reference; None where the run diverged.
        wall_time: Of everything [s].
    """

    verdict: Verdict
    reasons: tuple[str, ...]
    tolerance: float | None
    quantities: tuple[Quantity, ...]
    ruptures: Matching | None
    triggers: Matching | None
    judged: float
    output_times: int
    compared: int
    run: Observed
    known: Known | None
    wall_time: float


def validate(
    compiled: Compiled, *, method: str, rtol: float | None, progress: Progress
) -> Validation:
    """Return how the engine's run of a scene compares with SciPy's.

    Args:
        method: Of SciPy, for the reference.
        rtol: Error per step of the reference; None lets the promise decide.
        progress: Told a stage and the simulated time [s].

    Raises:
        ReferenceFailure: SciPy's solver could not go on.
    """
    started = clock.monotonic()
    network, plan = compiled.network, compiled.plan
    every = output_times(network, plan)
    times = thinned(every, network.node_count)
    run = observe(network, plan, times, lambda t: progress("run", t))
    if run.outcome.kind != "done":
        counts = len(every), len(run.times)
        ended = clock.monotonic() - started
        message = (run.outcome.message,)
        tolerance = plan.simulation.tolerance
        return Validation(
            "diverged", message, tolerance, (), None, None, 0.0, *counts, run, None, ended
        )
    known = known_reference(
        network, plan, run.times, method=method, rtol=rtol, progress=progress
    )
    judge = Judge(compiled, run, known)
    verdict, reasons = judge.verdict()
    return Validation(
        verdict,
        (*reasons, *_thinning(len(every), len(times))),
        judge.tolerance,
        judge.quantities,
        judge.ruptures,
        judge.triggers,
        judge.until,
        len(every),
        len(times),
        run,
        known,
        clock.monotonic() - started,
    )


class Judge:
    """Compares and decides.

    Attributes:
        ruptures, triggers: How events match.
        until: Until when positions are judged [s].
        quantities: All errors; positions and energy balance first.
    """

    def __init__(self, compiled: Compiled, run: Observed, known: Known):
        self.network, self.plan = compiled.network, compiled.plan
        self.run, self.known = run, known
        self.tolerance = self.plan.simulation.tolerance
        self.duration = self.plan.simulation.duration
        self._match_events()
        self.until = self._horizon()
        self.quantities = self._quantities()

    def _match_events(self) -> None:
        run, reference = self.run, self.known.reference
        broken = break_times(run.breaks), break_times(reference.breaks)
        fired = firing_times(run.firings), firing_times(reference.firings)
        shift = (self.tolerance or 0.0) * float(reference.displacement[-1])
        strains = run.strain, reference.strain
        misses = near_ties(missed(*broken), self.network, strains, shift)
        self.ruptures = match(*broken, misses, self.duration)
        self.triggers = match(*fired, missed(*fired), self.duration)
        masks = [between_events(run.times, *times, self.duration) for times in (broken, fired)]
        self._valid = ~(masks[0] | masks[1])

    def _horizon(self) -> float:
        """Return until when the reference is known well enough, and no near tie has parted it."""
        known = self.known.horizon(self.tolerance) if self.tolerance else self.duration
        ties = [miss.time for miss in self.ruptures.misses if miss.is_tie]
        return min([known, *(np.nextafter(time, -np.inf) for time in ties)])

    def _quantities(self) -> tuple[Quantity, ...]:
        run, reference, bound = self.run, self.known.reference, self.tolerance
        judged = slice(0, int(np.searchsorted(run.times, self.until, side="right")))
        groups = compare.force_groups(self.plan, reference)
        end = run.outcome.situation
        return (
            compare.position(run, reference, self.network, bound, judged),
            compare.energy_balance(run, bound),
            compare.velocity(run, reference, self._valid),
            *compare.support_forces(run, reference, end, groups, self._valid, bound),
        )

    # --- verdict -------------------------------------------------------------------------------

    def verdict(self) -> tuple[Verdict, tuple[str, ...]]:
        """Return the verdict and why, in sentences."""
        told = (*self._own_doubts(), *self._event_sentences())
        if self.tolerance is None:
            return "nothing promised", ("a fixed step promises nothing; errors are told only", *told)
        broken = [q for q in self.quantities if q.is_kept is False]
        if broken:
            return "broken", (*(self._breach(quantity) for quantity in broken), *told)
        if self.until < self.duration:
            return "undecided", told
        return "kept", told

    def _breach(self, quantity: Quantity) -> str:
        return (
            f"{quantity.name} is wrong by {quantity.error:.2g} at {show(quantity.time, TIME)}; "
            f"promised were {quantity.bound:g}"
        )

    def _own_doubts(self) -> list[str]:
        known, error = self.known, self.known.uncertainty[-1]
        if self.tolerance is None:
            return [f"the reference itself is known to {error:.1e} of the largest displacement"]
        horizon = known.horizon(self.tolerance)
        if horizon >= self.duration:
            return []
        since = f"from {show(max(horizon, 0.0), TIME)} on " if np.isfinite(horizon) else ""
        sentences = [
            f"{since}the reference itself is only known to {error:.1e} of the largest "
            f"displacement, and must be {BETTER:g} times better than the promise of "
            f"{self.tolerance:g} to judge it"
        ]
        if known.is_sensitive:
            sentences.append(
                "finer steps do not bring references together: this motion amplifies errors of "
                "the size of rounding (it buckles, folds or is chaotic), and no method in "
                "double precision can keep such a promise; viscosity makes it tamer"
            )
        elif known.reference.rtol > 1e-13:
            sentences.append("try a smaller --rtol or another --method")
        return sentences

    def _event_sentences(self) -> list[str]:
        sentences = [self._miss("spring", miss) for miss in self.ruptures.misses]
        sentences += [self._miss("trigger", miss) for miss in self.triggers.misses]
        return sentences[:MOST_MISSES] + (
            [f"{len(sentences) - MOST_MISSES} more differences of this kind"]
            if len(sentences) > MOST_MISSES
            else []
        )

    def _miss(self, kind: str, miss: "compare.Miss") -> str: ...
