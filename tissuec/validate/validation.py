"""From a compiled scene to a verdict: run, reference, comparison.

An event that ends a run before its duration may occur a little later in the reference, by the
errors of both. The reference is therefore computed a little further, and its events after the
end of the run count only if they occurred in the run.
"""

import time as clock

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.compiler.compile import Compiled
from tissuec.model.blocks import KINDS, SYMMETRY
from tissuec.script.plan import Plan
from tissuec.script.verbs.end import without_end
from tissuec.validate.compare import QuantityError
from tissuec.validate.engine_run import Observed, observe, output_times, thinned
from tissuec.validate.events import Matching
from tissuec.validate.forces import FORMULAS
from tissuec.validate.judge import Judge, Verdict, reasons
from tissuec.validate.reference import WITHOUT_PROMISE
from tissuec.validate.reference_run import MINIMISERS
from tissuec.validate.solution import Reference
from tissuec.validate.stepping import ReferenceFailure
from tissuec.validate.uncertainty import EstimatedReference, Progress, known_reference


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
        if block.kind not in (*KINDS, SYMMETRY, *FORMULAS):
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
