"""From a compiled scene to a verdict: run, reference, comparison, judgement.

An event that ends a run before its duration may occur a little later in the reference, by the
errors of both. The reference is therefore computed a little further, and its events after the
end of the run count only if they occurred in the run.

What is promised are positions, by the tolerance; and since an integrator that loses energy is
wrong even where positions look right, the energy ledger must close to the same tolerance.
Velocities, forces and times of events follow from positions with factors of their own (spring
constants, frequencies): they are reported with what positions within the promise would allow,
and not judged. The exception is the force on a tool that touches nothing, which depends on no
position of a body.
"""

import time as clock
from typing import Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.compile import Compiled
from tissuec.core.structs import replace
from tissuec.core.units import TIME, show
from tissuec.engine.execution.failure_messages import describe_spring
from tissuec.model.blocks import EMBEDDING, KINDS
from tissuec.script.plan import Plan
from tissuec.script.verbs.end import without_end
from tissuec.validate import compare
from tissuec.validate.compare import (
    Matching,
    Miss,
    QuantityError,
    between_events,
    break_times,
    firing_times,
    match,
    missed,
    near_ties,
)
from tissuec.validate.engine_run import Observed, observe, output_times, thinned
from tissuec.validate.forces import FORMULAS
from tissuec.validate.reference import FINEST, MINIMISERS, WITHOUT_PROMISE
from tissuec.validate.solution import Reference
from tissuec.validate.stepping import ReferenceFailure
from tissuec.validate.uncertainty import BETTER, EstimatedReference, Progress, known_reference

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
        # What breaks as the run ends parts it from the reference only later.
        last = 2.0 * self._run.outcome.state.time - end_of_reference(self._plan, self._run)
        ties = [miss.time for miss in self.ruptures.misses if miss.is_tie and miss.time < last]
        return min([known, *(float(np.nextafter(time, -np.inf)) for time in ties)])

    def _measure(self, valid: NDArray[np.bool_]) -> tuple[QuantityError, ...]:
        run, reference, bound = self._run, self._known.reference, self.tolerance
        judged = int(np.searchsorted(run.times, self.until, side="right"))
        groups = compare.force_groups(self._plan, reference)
        end = run.outcome.state
        return (
            *compare.position(run, reference, self._network, bound, judged),
            compare.energy_balance(run, self._network, bound),
            compare.velocity(run, reference, valid),
            *compare.support_forces(run, reference, end, groups, valid, bound),
        )

    def _decide(self) -> Verdict:
        if self.tolerance is None:
            return "nothing promised"
        if any(quantity.is_kept is False for quantity in self.quantities):
            return "broken"
        return "kept" if self.until >= self._run.times[-1] else "undecided"


MOST = 5  # differences of one kind that are listed


def reasons(
    compiled: Compiled, judge: Judge, run: Observed, known: EstimatedReference
) -> list[str]:
    """Return the sentences that explain a verdict.

    Args:
        compiled: The scene.
        judge: The compared quantities.
        run: The engine's run.
        known: The reference and its uncertainty.
    """
    sentences: list[str] = []
    if judge.tolerance is None:
        sentences.append("a fixed step has no tolerance, so errors are reported without limits")
    sentences += [
        _breach(quantity) for quantity in judge.quantities if quantity.is_kept is False
    ]
    sentences += _doubts(known, judge.tolerance)
    sentences += _several([_rupture(miss, run) for miss in judge.ruptures.misses])
    sentences += _several([_trigger(miss, compiled) for miss in judge.triggers.misses])
    for kind, matching in (("springs", judge.ruptures), ("triggers", judge.triggers)):
        if not matching.in_order and not matching.misses:
            sentences.append(f"the same {kind} occurred in another order than in the reference")
    return sentences


def _breach(quantity: QuantityError) -> str:
    return (
        f"the error of {quantity.name} is {quantity.error:.2g} at {show(quantity.time, TIME)}, "
        f"above the limit {quantity.bound:g}"
    )


def _doubts(known: EstimatedReference, tolerance: float | None) -> list[str]:
    """Return sentences on the uncertainty of the reference itself."""
    error = known.uncertainty[-1]
    if tolerance is None:
        return [f"the reference itself is accurate to {error:.1e} of the largest displacement"]
    horizon = known.horizon(tolerance)
    if horizon >= known.reference.times[-1]:
        return []
    since = f"after {show(horizon, TIME)} " if np.isfinite(horizon) else ""
    sentences = [
        f"{since}the reference itself is accurate to only {error:.1e} of the largest "
        f"displacement; checking {tolerance:g} needs a reference {BETTER:g} times more accurate"
    ]
    if known.is_sensitive:
        sentences.append(
            "references do not converge with smaller steps: the motion amplifies rounding "
            "errors, as in buckling, folding or chaos; no solver in double precision can keep "
            "or check such a tolerance; more viscosity makes the motion less sensitive"
        )
    elif known.reference.rtol > FINEST:
        sentences.append("a smaller --rtol or another --method may be more accurate")
    return sentences


def _rupture(miss: Miss, run: Observed) -> str:
    here, there = ("run", "reference") if miss.in_run else ("reference", "run")
    why = "a near tie" if miss.is_tie else "more than an error within the limit explains"
    return (
        f"{describe_spring(run.outcome.state, miss.number)}, breaks at "
        f"{show(miss.time, TIME, digits=6)} in the {here} only; in the {there} it reached "
        f"{100.0 * miss.strain:.6g} % of its limit, {why}"
    )


def _trigger(miss: Miss, compiled: Compiled) -> str:
    span = compiled.plan.triggers[miss.number].span
    here = "run" if miss.in_run else "reference"
    return f"{span.place} fires at {show(miss.time, TIME, digits=6)} in the {here} only"


def _several(sentences: list[str]) -> list[str]:
    if len(sentences) <= MOST:
        return sentences
    return [*sentences[:MOST], f"and {len(sentences) - MOST} more such differences"]


class RunComparison(Struct, frozen=True, eq=False):
    """Comparison of a run that reached its end.

    Attributes:
        quantities: Errors; positions and energy balance first.
        ruptures, triggers: How events match.
        judged: Until when positions were judged [s]; -inf if never.
        known: The reference.
    """

    quantities: tuple[QuantityError, ...]
    ruptures: Matching
    triggers: Matching
    judged: float
    known: EstimatedReference


class Validation(Struct, frozen=True, eq=False):
    """Results of a validation.

    Attributes:
        verdict: On the promise.
        reasons: Sentences that explain it.
        tolerance: What was promised; None for a fixed step.
        output_times: How many there are; as many as there are rows in ``run`` were compared.
        run: What the engine did.
        comparison: None of a run that could not continue.
        wall_time: Of everything [s].
    """

    verdict: Verdict
    reasons: tuple[str, ...]
    tolerance: float | None
    output_times: int
    run: Observed
    comparison: RunComparison | None
    wall_time: float


def validate(
    compiled: Compiled, *, method: str, rtol: float | None, progress: Progress
) -> Validation:
    """Return how the engine's run of a scene compares with SciPy's.

    Args:
        compiled: The scene.
        method: Of SciPy, for the reference; static runs have its minimisers.
        rtol: Error per step of the reference; None derives it from the tolerance.
        progress: Called with a stage and the simulated time [s].

    Raises:
        ReferenceFailure: SciPy's solver could not continue, or lacks a formula.
    """
    started = clock.monotonic()
    network, plan = compiled.network, compiled.plan
    for block in network.blocks:
        if block.kind not in (*KINDS, EMBEDDING, *FORMULAS):
            raise ReferenceFailure(
                f"the reference has no independent formula for {block.name}: no file in "
                f'tissuec/validate/forces has a member "{block.kind}"'
            )
    if plan.simulation.is_static:
        method = MINIMISERS
    every = output_times(network, plan)
    times = thinned(every, network.node_count)
    run = observe(network, plan, times, lambda time: progress("run", time))
    if run.outcome.kind != "done":
        why, took = (run.outcome.message,), clock.monotonic() - started
        tolerance = plan.simulation.tolerance
        return Validation("diverged", why, tolerance, len(every), run, None, took)
    known = known_reference(
        network,
        without_end(plan),
        run.times,
        method=method,
        rtol=rtol,
        progress=progress,
        until=end_of_reference(plan, run),
    )
    known = replace(
        known,
        reference=without_later(known.reference, run),
        second=without_later(known.second, run),
    )
    judge = Judge(compiled, run, known)
    return Validation(
        judge.verdict,
        tuple(reasons(compiled, judge, run, known)),
        judge.tolerance,
        len(every),
        run,
        RunComparison(judge.quantities, judge.ruptures, judge.triggers, judge.until, known),
        clock.monotonic() - started,
    )


def end_of_reference(plan: Plan, run: Observed) -> float:
    """Return the time up to which the reference of a run is needed [s]."""
    simulation, time = plan.simulation, run.outcome.state.time
    late = (simulation.tolerance or WITHOUT_PROMISE) * simulation.duration
    return time if run.outcome.ended is None else min(time + late, simulation.duration)


def without_later(reference: Reference, run: Observed) -> Reference:
    """Return a reference without events after the end of the run that only it has."""
    end = run.outcome.state.time
    broken = np.concatenate([np.zeros(0, dtype=np.int64), *(one.springs for one in run.breaks)])
    fired = {one.trigger for one in run.firings}
    breaks = (
        one if one.time <= end else replace(one, springs=np.intersect1d(one.springs, broken))
        for one in reference.breaks
    )
    return replace(
        reference,
        breaks=tuple(one for one in breaks if len(one.springs)),
        firings=tuple(
            one for one in reference.firings if one.time <= end or one.trigger in fired
        ),
    )
