"""Reasons for a verdict, in sentences."""

import numpy as np

from tissuec.compiler.compile import Compiled
from tissuec.core.units import TIME, show
from tissuec.engine.execution.failure_messages import describe_spring
from tissuec.validate.compare import QuantityError
from tissuec.validate.engine_run import Observed
from tissuec.validate.events import Miss
from tissuec.validate.judge import Judge
from tissuec.validate.reference import FINEST
from tissuec.validate.uncertainty import BETTER, EstimatedReference

MOST = 5  # differences of one kind that are told one by one


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
    """Return what is not known of the reference itself."""
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
