"""A finished learning as parts of a report, and as plain data."""

from collections.abc import Iterator, Sequence
from typing import Any

from tissuec.core.errors import counted
from tissuec.core.report import Fact, FactTable, FailedExpectation, Part, holding
from tissuec.core.units import si_unit
from tissuec.learn.fit.expectations import DemandVerdict, errors_of, judged
from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt
from tissuec.learn.fit.shown import percent, shown
from tissuec.learn.report.numbers import numbers_of
from tissuec.learn.report.words import sentences
from tissuec.learn.vocabulary.drift import Drift
from tissuec.script.fit_problem import WORDS

DATA = ("data", "error", "points", "residuals")


def learnt_parts(learnt: Learnt, moved: list[Drift] | None = None) -> list[Part]:
    """Return the estimates, moved words, residuals and notes of a learning.

    Args:
        learnt: The learning.
        moved: How far words moved, where any did.
    """
    told = {one.sentence for one in moved or ()}
    notes = [Fact("note", note) for note in learnt.notes if note not in told]
    rows = [_data_row(learnt, one) for one in learnt.fitted]
    return [
        f"learn {learnt.fit_problem.name}: {ending(learnt)}",
        *numbers_of(learnt.estimates),
        *sentences(moved or []),
        FactTable(DATA, rows),
        *_of_fits(learnt),
        *_blind(learnt),
        *notes,
        *_effort(learnt),
    ]


def judged_parts(verdicts: Sequence[DemandVerdict]) -> list[Part]:
    """Return the expectations that fail, and how many hold."""
    if not verdicts:
        return []
    failures = [
        FailedExpectation(f"{one.demand.span.place}: {one.demand.span.one_line}", one.measured)
        for one in verdicts
        if not one.holds
    ]
    states = ["holds" if one.holds else "fails" for one in verdicts]
    return [*failures, Fact("expectations", holding(states), "remark")]


def ending(learnt: Learnt) -> str:
    """Return how it ended."""
    return learnt.reason if learnt.converged else f"NOT CONVERGED, {learnt.reason}"


def _data_row(learnt: Learnt, fitted: Fitted) -> tuple[str, str, str, str]:
    left = ", ".join(
        f"{text} {_of_fit(learnt, text, value)}" for text, value in fitted.left.items()
    )
    name = f"{fitted.file} (held out)" if fitted.held_out else fitted.file
    return name, percent(fitted.error), str(fitted.count), left


def _of_fits(learnt: Learnt) -> Iterator[str]:
    """Yield the noise and the unknown zero of each fit."""
    given = {fit.text for fit in learnt.fit_problem.fits if fit.noise is not None}
    for text, noise in learnt.noise.items():
        known = "given" if text in given else "estimated"
        yield f"noise of {text}: {_of_fit(learnt, text, noise)} ({known})"
    for text, zero in learnt.zeros.items():
        yield f"zero of {text}: {_of_fit(learnt, text, zero)}"


def _of_fit(learnt: Learnt, text: str, value: float) -> str:
    dimensions = {fit.text: fit.dimension for fit in learnt.fit_problem.fits}
    return shown(value, dimensions[text]) if text in dimensions else f"{value:.4g}"


def _blind(learnt: Learnt) -> Iterator[str]:
    """Yield the unidentified parameters, each with data that would identify it."""
    for blind in learnt.blind:
        yield f"not identified: {blind.sentence}"
        yield f"  to identify it: {blind.advice}"


def _effort(learnt: Learnt) -> Iterator[str]:
    yield f"error function: {learnt.first_error:.4g} before, {learnt.error:.4g} after"
    passes, evaluations = (
        counted(learnt.passes, "pass"),
        counted(learnt.evaluations, "evaluation"),
    )
    yield f"method: {learnt.method}; {passes}, {evaluations}, {learnt.wall_time:.1f} s"
    if learnt.stepping:
        known = f"halving the step changes predictions by {learnt.stepping_error:.1e}"
        yield f"steps: {learnt.stepping}; {known} of the range of the data"


def as_dict(learnt: Learnt, moved: Sequence[Drift] = ()) -> dict[str, Any]:
    """Return everything that was learnt, in SI units.

    Args:
        moved: How far words moved, where any did.
    """
    return {
        "learn": learnt.fit_problem.name,
        "converged": learnt.converged,
        "reason": learnt.reason,
        "identified": is_identified(learnt),
        "failure": learnt.failure,
        "estimates": [_estimates(one) for one in learnt.estimates],
        "zeros": dict(learnt.zeros),
        "error": learnt.error,
        "first_error": learnt.first_error,
        "data": [_fitted_data(one) for one in learnt.fitted],
        "errors": errors_of(learnt.fitted),
        "noise": dict(learnt.noise),
        "singular": learnt.singular.tolist(),
        "blind": [
            {"sentence": one.sentence, "advice": one.advice, "spread": one.spread}
            for one in learnt.blind
        ],
        "expectations": [verdict.data for verdict in judged(learnt)],
        "words": dict(learnt.words),
        "drift": [_drift(one) for one in moved],
        "method": learnt.method,
        "stepping": learnt.stepping,
        "stepping_error": learnt.stepping_error,
        "seed": learnt.fit_problem.seed,
        "passes": learnt.passes,
        "evaluations": learnt.evaluations,
        "wall_time": learnt.wall_time,
        "notes": list(learnt.notes),
    }


def is_identified(learnt: Learnt) -> bool:
    """Return whether the data determines every number, and every combination of numbers.

    Words are held by where the expert has them, so that one that no tissue uses does no harm.
    """
    has_words = any(adjust.what == WORDS for adjust in learnt.fit_problem.adjusts)
    told = all(bool(one.identified.all()) for one in learnt.estimates)
    return told and (has_words or not learnt.blind)


def _estimates(estimates: Estimates) -> dict[str, Any]:
    adjust = estimates.adjust
    return {
        "adjust": adjust.what,
        "of": adjust.of,
        "per": adjust.per,
        "unit": si_unit(adjust.dimension),
        "names": list(estimates.names),
        "start": estimates.start.tolist(),
        "value": estimates.value.tolist(),
        "low": estimates.low.tolist(),
        "high": estimates.high.tolist(),
        "identified": estimates.identified.tolist(),
    }


def _fitted_data(fitted: Fitted) -> dict[str, Any]:
    return {
        "file": fitted.file,
        "held_out": fitted.held_out,
        "count": fitted.count,
        "error": fitted.error,
        "left": dict(fitted.left),
        "sha256": fitted.digest,
    }


def _drift(drift: Drift) -> dict[str, Any]:
    return {
        "scale": drift.scale,
        "word": drift.word,
        "before": drift.before,
        "after": drift.after,
        "centre": drift.centre,
        "most": drift.most,
    }
