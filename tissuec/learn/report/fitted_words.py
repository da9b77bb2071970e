"""A finished fit of words as parts of a report, and as plain data."""

from collections.abc import Iterator
from typing import Any

from tissuec.core.errors import counted
from tissuec.core.report import Fact, FactTable, Part
from tissuec.core.units import si_unit
from tissuec.learn.fit.outcome import shown
from tissuec.learn.report.learnt import sentences
from tissuec.learn.words_fit.fitting import FittedNumber, LearntVocabulary
from tissuec.scene.tissues.quantities import QUANTITIES

HEAD = ("quantity of tissue", "number", "from words, before", "from words, after", "ratio")


def fitted_parts(learnt: LearntVocabulary) -> list[Part]:
    """Return the fitted numbers, moved words, changed weights and notes."""
    ended = learnt.reason if learnt.converged else f"NOT CONVERGED, {learnt.reason}"
    return [
        f"learn {learnt.fit.name}: {ended}",
        FactTable(HEAD, [*map(_row, learnt.numbers)]),
        *sentences(learnt.moved),
        *_weights(learnt),
        *_largest(learnt),
        *(Fact("note", note) for note in learnt.notes),
        f"error function: {learnt.first_error:.4g} before, {learnt.error:.4g} after",
        "method: least squares, exact derivatives of the inference; "
        f"{counted(learnt.evaluations, 'evaluation')}, {learnt.wall_time:.1f} s",
    ]


def as_dict(learnt: LearntVocabulary) -> dict[str, Any]:
    """Return everything that was learnt, in SI units."""
    return {
        "learn": learnt.fit.name,
        "converged": learnt.converged,
        "reason": learnt.reason,
        "numbers": [_number(one) for one in learnt.numbers],
        "error": learnt.error,
        "first_error": learnt.first_error,
        "errors": dict(learnt.errors),
        "expectations": [verdict.data for verdict in learnt.verdicts],
        "words": dict(learnt.texts),
        "weights": [
            {"rule": weight.item.span.one_line, "before": weight.start, "after": now}
            for weight, now in learnt.weights
        ],
        "drift": [
            {
                "scale": one.scale, "word": one.word, "before": one.before, "after": one.after,
                "centre": one.centre, "most": one.most,
            }
            for one in learnt.moved
        ],
        "evaluations": learnt.evaluations,
        "wall_time": learnt.wall_time,
        "notes": list(learnt.notes),
    }  # fmt: skip


def _row(one: FittedNumber) -> tuple[str, ...]:
    target = one.target
    dimension = QUANTITIES[target.quantity].dimension
    remarks = ["of evidence"] * (target.how == "evidence") + ["held out"] * target.held_out
    name = f"{one.name} ({', '.join(remarks)})" if remarks else one.name
    values = (shown(value, dimension) for value in (target.value, one.before, one.after))
    return name, *values, f"{one.after / target.value:.3g}"


def _weights(learnt: LearntVocabulary) -> Iterator[str]:
    for weight, now in learnt.weights:
        rule = " ".join(weight.item.span.text.split()).partition(" weighing ")[0]
        yield f"weight: {weight.start:g} becomes {now:g}: {rule}"


def _largest(learnt: LearntVocabulary) -> Iterator[str]:
    """Yield the largest factors of the fitted numbers, and of those held out."""
    for held_out, head in ((False, "largest factor"), (True, "largest factor, held out")):
        some = [one for one in learnt.numbers if one.target.held_out == held_out]
        if some:
            before = max(some, key=lambda one: one.factor_before)
            worst = max(some, key=lambda one: one.factor)
            yield (
                f"{head}: {worst.factor:.3g} ({worst.name}); "
                f"before {before.factor_before:.3g} ({before.name})"
            )


def _number(one: FittedNumber) -> dict[str, Any]:
    target = one.target
    return {
        "quantity": target.quantity,
        "tissue": target.tissue,
        "unit": si_unit(QUANTITIES[target.quantity].dimension),
        "from": target.how,
        "held_out": target.held_out,
        "value": target.value,
        "deviation": target.deviation,
        "before": one.before,
        "after": one.after,
        "factor": one.factor,
    }
