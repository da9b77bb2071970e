"""What a fit tells: estimates with their intervals, what is left of the data, and remarks."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import TIME, show
from tissuec.learn.derivatives.dynamic_model import DynamicModel
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.bootstrap import MOST_FAILED, Resampled
from tissuec.learn.fit.identifiability import SHOWN, Identifiability, judge
from tissuec.learn.fit.linearised import LinearisedFit, linearised
from tissuec.learn.fit.misfit import misfit, remarks, too_coarse, units
from tissuec.learn.fit.noise import NoiseDraws, noise_of
from tissuec.learn.fit.optimiser import LEAST_SQUARES
from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.fit.residual_structure import residual_structure
from tissuec.learn.fit.search import Search, SearchState
from tissuec.learn.fit.session import LearnSession
from tissuec.learn.fit.suspicions import contradictions, suspicions
from tissuec.model.network import Floats

NEAR_LIMIT = 1e-3  # of a parameter: the search stays that far inside


def assess(
    session: LearnSession,
    problem: Problem,
    search: Search,
    end: SearchState,
    resample: Callable[[Sequence[NoiseDraws]], Resampled | None],
) -> Learnt:
    """Return the parameters that a search ended with, and how far they can be believed.

    The time it took and the texts of words are left to the caller.

    Args:
        session: The learning.
        problem: What was fitted.
        search: The search.
        end: Where it ended.
        resample: Returns intervals by bootstrap, from the noise of each fit; None if they
            follow from derivatives.

    Raises:
        Diverged: The motion is not finite.
    """
    theta, fits = end.theta, session.fit_problem.fits
    errors = [trial.model.step_error(theta[: problem.own]) for trial in problem.trials]
    stepping, stepping_error = _stepping(problem, theta, errors)
    error = problem.error_at(theta)
    near = linearised(problem, theta)
    draws, names = noise_of(near), _names(session, problem)
    resampled = resample(draws)
    sureness = judge(near, draws, *names, np.concatenate([np.zeros(0), *errors]))
    failure, doubts = _doubts(near, theta, names[0], session)
    failure = too_coarse(stepping_error) or failure
    notes = (
        *(units(problem) if failure or sureness.blind else ()),
        *doubts,
        *filter(None, [_of_intervals(session, resampled)]),
        *_notes(session, theta, stepping_error),
    )
    return Learnt(
        fit_problem=session.fit_problem,
        estimates=tuple(estimates(session, theta, sureness, resampled)),
        zeros={fits[k].text: problem.zero(theta, k) for k in problem.zeroed},
        error=error,
        fitted=tuple(_fitted(session, problem, theta)),
        first_error=_first_error(problem),  # last: models are frozen elsewhere for it
        noise={fit.text: float(s) for fit, s in zip(fits, sureness.noise, strict=True)},
        singular=sureness.singular,
        blind=sureness.blind,
        method=_method(session, search),
        stepping=stepping,
        stepping_error=stepping_error,
        passes=end.passes,
        evaluations=end.evaluations,
        reason=end.reason,
        converged=end.converged,
        failure=failure,
        wall_time=0.0,
        notes=notes,
        doubts=tuple(doubts),
    )


def _doubts(
    near: LinearisedFit, theta: Floats, names: Sequence[str], session: LearnSession
) -> tuple[str, list[str]]:
    """Return why a fit is no solution, empty if it may be one, and what is doubtful about it.

    The motion is that of the result: after this, models may be frozen anew.
    """
    problem = near.problem
    singles = [session.judged([trial], problem) for trial in session.learning]
    structure = residual_structure(problem, near.left, near.basis)
    doubts = [*suspicions(near, theta), *contradictions(near, names)]
    failure = misfit(problem, theta, structure, singles)
    return failure, doubts if failure else [*remarks(problem, theta, structure), *doubts]


def _names(session: LearnSession, problem: Problem) -> tuple[list[str], list[str]]:
    """Return the names of all parameters, and of what kind they are."""
    shaping = session.shaping
    zeros = [f"zero of {session.fit_problem.fits[k].text}" for k in problem.zeroed]
    kinds = [block.adjust.what for block in shaping.blocks for _ in block.names]
    others = problem.size - len(kinds)
    return [*shaping.names, *zeros], kinds + [""] * others


def estimates(
    session: LearnSession,
    theta: Floats,
    sureness: Identifiability,
    resampled: Resampled | None = None,
) -> Iterator[Estimates]:
    """Yield the numbers of each ``adjust`` entry, with their intervals.

    Args:
        session: The learning.
        theta: The parameters, shape (parameter,).
        sureness: How far the data tells them.
        resampled: Intervals by bootstrap.
    """
    lows, highs = theta - sureness.away, theta + sureness.away
    if resampled is not None:  # of what no derivative tells, no resample does
        lows, highs = np.where(sureness.identified, resampled[:2], (lows, highs))
    for number, block in enumerate(session.shaping.blocks):
        part = session.shaping.place(number)
        here, known = theta[part], sureness.identified[part]
        with np.errstate(over="ignore"):
            low, high = block.value(lows[part]), block.value(highs[part])
        yield Estimates(
            adjust=block.adjust,
            names=block.names,
            start=block.start,
            value=block.value(here),
            low=low,
            high=high,
            identified=known,
            parts=block.parts,
        )


def _first_error(problem: Problem) -> float:
    """Return the error function at the beginning; infinite where the motion is not finite."""
    try:
        return problem.error_at(np.zeros(problem.size))
    except Diverged:
        return np.inf


def relative_error(problem: Problem, theta: Floats) -> float:
    """Return what is left of a problem over how far its data deviates from its mean.

    It is infinite where the motion is not finite: it is held-out data that is not met, then.
    """
    try:
        problem.freeze(theta)
        return problem.relative(theta)
    except Diverged:
        return np.inf


def _fitted(session: LearnSession, like: Problem, theta: Floats) -> Iterator[Fitted]:
    both: Sequence[tuple[FittedExperiment, bool]] = [
        *((trial, False) for trial in session.learning),
        *((trial, True) for trial in session.held_out),
    ]
    for trial, held_out in both:
        problem = session.judged([trial], like)
        error = relative_error(problem, theta)
        left = problem.left(theta) if np.isfinite(error) else np.full(len(problem.fits), np.inf)
        fits = session.fit_problem.fits
        rest: dict[str, float] = {
            fits[int(k)].text: float(np.sqrt(np.mean(np.square(left[problem.fits == k]))))
            for k in np.unique(problem.fits).tolist()
        }
        experiment = trial.experiment
        yield Fitted(experiment.name, held_out, len(left), error, rest, experiment.digest)


def _stepping(problem: Problem, theta: Floats, errors: Sequence[Floats]) -> tuple[str, float]:
    """Return how motions were stepped, and the largest error as a part of what was measured.

    Args:
        errors: Of the steps, of the predictions of each experiment, shape (number,).
    """
    found, worst = "", 0.0
    for trial, apart in zip(problem.trials, errors, strict=True):
        model = trial.model
        if not isinstance(model, DynamicModel):
            continue
        step = f"{model.motion.steps} steps of at most {show(model.motion.longest, TIME)}"
        found, predicted = f"{model.stepping.name}, {step}", model.predict(theta[: problem.own])
        for one, slot in zip(model.series, model.slots, strict=True):
            mine = slice(slot.start, slot.start + slot.rows * slot.width)
            seen = one.values[np.isfinite(one.values)]
            # Each in its own unit; what hardly moves is held against what was measured.
            both = [values for values in (predicted[mine], seen) if len(values)]
            span = max((float(np.ptp(v)) or float(np.abs(v).max()) for v in both), default=0.0)
            worst = max(worst, float(np.abs(apart[mine]).max(initial=0.0)) / (span or 1.0))
    return found, worst


def _method(session: LearnSession, search: Search) -> str:
    names = dict.fromkeys(trial.model.name for trial in session.learning)
    way = "forwards" if search.optimiser.method == LEAST_SQUARES else "backwards"
    derivatives = ", ".join(names)
    if any(isinstance(trial.model, DynamicModel) for trial in session.learning):
        derivatives += f", {way}"
    return f"{search.optimiser.method}, {derivatives}"


def _notes(session: LearnSession, theta: Floats, stepping_error: float) -> Iterator[str]:
    """Yield what else is to be known."""
    shaping = session.shaping
    low, high = shaping.bounds()
    own = theta[: shaping.size]
    at_limit = (own <= low + NEAR_LIMIT) | (own >= high - NEAR_LIMIT)
    if at_limit.any():
        names = _first_few(shaping.names, at_limit)
        yield f"at a limit, which the interval ignores: {names}"
    outside = (low > 0.0) | (high < 0.0)
    if outside.any():
        names = _first_few(shaping.names, outside)
        yield f"outside its limits, so the fit starts at the nearer limit: {names}"
    if stepping_error > 1e-4 and not too_coarse(stepping_error):
        yield (
            f"halving the step changes predictions by {stepping_error:.1g} of their range: "
            "write a smaller step"
        )
    for trial in (*session.learning, *session.held_out):
        yield from getattr(trial.model, "notes", ())


def _first_few(names: Sequence[str], chosen: NDArray[np.bool_]) -> str:
    """Return the first of some names, and how many more there are."""
    found = [names[k] for k in np.flatnonzero(chosen).tolist()]
    more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return ", ".join(found[:SHOWN]) + more


def _of_intervals(session: LearnSession, resampled: Resampled | None) -> str:
    """Return what the intervals are from, if not from derivatives; empty otherwise."""
    fits = session.fit_problem.bootstrap
    if fits is None:
        return ""
    if resampled is not None:
        return f"intervals: {resampled.sentence}"
    return (
        f"more than {MOST_FAILED:.0%} of {fits} fits to simulated data failed: the "
        "intervals are from derivatives"
    )
