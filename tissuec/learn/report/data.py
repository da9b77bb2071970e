"""A finished learning as plain data, for JSON and for other programs."""

from collections.abc import Sequence
from typing import Any

from tissuec.core.units import si_unit
from tissuec.learn.fit.expectations import errors_of, judged
from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt
from tissuec.learn.vocabulary.drift import Drift
from tissuec.script.fit_problem import WORDS


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
        "data": [_fitted(one) for one in learnt.fitted],
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
    """Return whether the data tells every number, and every combination of numbers.

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


def _fitted(fitted: Fitted) -> dict[str, Any]:
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
