"""The assessment of a fit: estimates with their intervals, residuals, and remarks.

Remarks name likely errors of a measurement: its scale, clock or zero, or an expected value. A
wrong scale changes measured values by a multiple of the prediction, a wrong clock by a multiple
of its rate, a wrong zero by a constant. Each is tested as a further parameter of the linearised
fit (a score test, C. R. Rao, Proc. Cambridge Phil. Soc. 44:50, 1948). Only errors that are
certain even with correlated noise, and that explain the residuals, are reported.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import TIME, show
from tissuec.learn.derivatives.dynamic_model import DynamicModel
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.fit.bootstrap import MOST_FAILED, Resampled
from tissuec.learn.fit.identifiability import SHOWN, Identifiability, half_widths, judge
from tissuec.learn.fit.linearised import LinearisedFit, linearised
from tissuec.learn.fit.misfit import misfit, mistakes, remarks, too_coarse
from tissuec.learn.fit.noise import NoiseDraws, chains_of, noise_of
from tissuec.learn.fit.optimiser import LEAST_SQUARES
from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.fit.residual_structure import residual_structure
from tissuec.learn.fit.search import Search, SearchState
from tissuec.learn.fit.session import LearnSession
from tissuec.model.network import Floats
from tissuec.script.fit_problem import Fit

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
        problem: What was fitted.
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
        *(mistakes(problem) if failure or sureness.blind else ()),
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
        theta: The parameters, shape (parameter,).
        sureness: How well the data determines them.
        resampled: Intervals by bootstrap.
    """
    lows, highs = theta - sureness.away, theta + sureness.away
    if resampled is not None:  # what no derivative determines, no resample does
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
    """Return the residuals of a problem relative to the deviation of its data from the mean.

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
    """Yield further remarks."""
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
    """Return the source of the intervals, if not derivatives; empty otherwise."""
    fits = session.fit_problem.bootstrap
    if fits is None:
        return ""
    if resampled is not None:
        return f"intervals: {resampled.sentence}"
    return (
        f"more than {MOST_FAILED:.0%} of {fits} fits to simulated data failed: the "
        "intervals are from derivatives"
    )


SURE = 0.999  # that something is not by chance, if it is reported
PROBABLE = 4.0  # standard deviations with white noise, from which on it is examined
ALIKE = 1e-3  # of a column: what the parameters leave of it
MOST = 0.5  # of the squares of residuals of a fit: what leaves less is always reported
RIVAL = 0.8  # of the best explanation: as good
AT_WAR = 3.0  # standard deviations of an expected value against the data
TOLD_BY_DATA = 1e-6  # of the information on a parameter


class _Suspect(NamedTuple):
    """A quantity that may be wrong: its column in J, in SI units, shape (counted,)."""

    kind: str
    fit: Fit
    column: Floats


def suspicions(fit: LinearisedFit, theta: Floats) -> list[str]:
    """Return the most likely errors of the measurements, as sentences.

    Args:
        fit: The fit, near its result.
        theta: The result, dimensionless, shape (parameter,).
    """
    found: list[tuple[float, str]] = []
    problem = fit.problem
    for one in _suspects(problem, theta):
        gain = _gain(fit, one.column)
        if gain < PROBABLE**2:
            continue
        more = fit.with_column(one.column)
        move = more.answer @ fit.left + more.firm @ fit.surprise
        away = float(half_widths(more, noise_of(more), SURE)[-1])
        rest, mine = fit.left - more.rows @ move, one.column != 0.0
        explained = np.square(rest[mine]).sum() < MOST * np.square(fit.left[mine]).sum()
        is_all = not residual_structure(problem, rest, more.basis).is_significant
        if abs(move[-1]) > away and (is_all or explained):
            found.append((gain, _sentence(one, -float(move[-1]), away)))
    best = max((gain for gain, _ in found), default=0.0)
    return [sentence for gain, sentence in found if gain >= RIVAL * best]


def contradictions(fit: LinearisedFit, names: Sequence[str]) -> Iterator[str]:
    """Yield which expected values the data contradicts.

    The residual of an expected value is held against its standard deviation if it is right,
    which is less than 1 as it has its part in the result.

    Args:
        fit: The fit, near its result.
        names: Of the parameters.
    """
    own = np.square(fit.expected @ fit.directions).sum(axis=1)
    for prior, surprise, share in zip(fit.problem.priors, fit.surprise, own, strict=True):
        others = max(1.0 - float(share), TOLD_BY_DATA)
        if abs(surprise) > AT_WAR * np.sqrt(others):
            yield (
                f"the data and the expected value of {names[prior.place]} differ by "
                f"{abs(surprise) / others:.3g} of its deviations: one of them is wrong, and "
                "the interval ignores that"
            )


# --- suspects ---------------------------------------------------------------------------------


def _suspects(problem: Problem, theta: Floats) -> Iterator[_Suspect]:
    """Yield a scale, a clock and a zero for each fit, where they are no parameters."""
    predicted = problem.predicted(theta)[problem.counted]
    rate = _rates(problem, predicted)
    for k, fit in enumerate(problem.fit_problem.fits):
        mine = problem.fits == k
        yield _Suspect("scale", fit, np.where(mine, predicted - problem.zero(theta, k), 0.0))
        if problem.fit_problem.axis.nodes is None:
            yield _Suspect("clock", fit, np.where(mine, -rate, 0.0))
        if not fit.free_zero:
            yield _Suspect("zero", fit, mine.astype(float))


def _rates(problem: Problem, predicted: Floats) -> Floats:
    """Return how fast predictions change, by differences of rows; 0 for single ones."""
    found, times = np.zeros(len(predicted)), problem.times[problem.counted]
    for chains in chains_of(problem):
        for part in np.split(chains.order, np.flatnonzero(np.isinf(chains.apart))[1:]):
            if len(part) > 1:
                found[part] = np.gradient(predicted[part], times[part])
    return found


def _gain(fit: LinearisedFit, column: Floats) -> float:
    """Return by how much a parameter reduces the squares of residuals over the noise."""
    scale = 1.0 / fit.noise[fit.problem.fits]
    rest = column - fit.rows @ (fit.answer @ column)
    size = float(np.square(scale * rest).sum())
    if size <= ALIKE**2 * float(np.square(scale * column).sum()) or size == 0.0:
        return 0.0
    return float((scale * rest) @ (scale * fit.left)) ** 2 / size


def _sentence(one: _Suspect, shift: float, away: float) -> str:
    name = one.fit.text
    if one.kind == "scale":
        ends = f"{100 * (shift - away):+.2g} to {100 * (shift + away):+.2g} %"
        wrong, way_out = (
            f"scale of {name} is off by {100 * shift:+.2g} % ({ends})",
            "calibration",
        )
        return f"probably the {wrong}: check its {way_out}"
    if one.kind == "clock":
        late = "late" if shift > 0.0 else "early"
        shown = f"{show(abs(shift), TIME)} {late}, ±{show(away, TIME)}"
        return f"probably the clock of {name} is off ({shown}): check where its time starts"
    shown = f"{show(shift, one.fit.dimension)}, ±{show(away, one.fit.dimension)}"
    return f"probably the zero of {name} is off ({shown}): write after it: with free zero"
