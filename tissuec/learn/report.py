"""Learnt results as parts of a report and as plain data, of scenes and of words."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import unified_diff
from typing import Any

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.progress import ProgressLine, minutes
from tissuec.core.report import Fact, FactSection, FactTable, FailedExpectation, Part, holding
from tissuec.core.units import si_unit
from tissuec.learn.fit.learning import LearnProgress
from tissuec.learn.fit.outcome import (
    DemandVerdict,
    Estimates,
    Fitted,
    Learnt,
    errors_of,
    interval,
    judged,
    percent,
    shown,
)
from tissuec.learn.vocabulary.moving import Drift, drifts_between
from tissuec.learn.vocabulary.used import reread
from tissuec.learn.words_fit import FittedNumber, LearntVocabulary
from tissuec.model.network import Floats
from tissuec.scene.model import Scene
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.script.fit_problem import START_POSITION, START_VELOCITY, WORDS

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


HEADINGS = ("parameter", "before", "learned", "95 % interval", "change")
MANY = 12  # numbers of one entry, from which on only a summary is shown
WORST = 3  # of these, those that are known least


def numbers_of(estimates: Sequence[Estimates]) -> list[Part]:
    """Return a table of single numbers, followed by statistics of large groups."""
    rows = [row for one in estimates if len(one.names) < MANY for row in _rows(one)]
    many = [_summary(one) for one in estimates if len(one.names) >= MANY]
    return [*([FactTable(HEADINGS, rows)] if rows else []), *many]


def _rows(estimates: Estimates) -> Iterator[tuple[str, ...]]:
    for number, name in enumerate(estimates.names):
        yield (
            name,
            _shown(estimates, estimates.start[number]),
            _shown(estimates, estimates.value[number]),
            _interval(estimates, number),
            _change(estimates, number),
        )


def _shown(estimates: Estimates, value: float) -> str:
    adjust = estimates.adjust
    return shown(float(value), adjust.dimension, adjust.what)


def _interval(estimates: Estimates, number: int) -> str:
    """Return the interval of a number, or the remark that the data does not determine it."""
    if not estimates.identified[number]:
        return "not identified"
    adjust = estimates.adjust
    low, high = float(estimates.low[number]), float(estimates.high[number])
    return interval(low, high, adjust.dimension, adjust.what)


def _change(estimates: Estimates, number: int) -> str:
    """Return by which part a number changed; of places, velocities and what was 0, how far."""
    start, value = float(estimates.start[number]), float(estimates.value[number])
    what = estimates.adjust.what
    if start == 0.0 or what in (START_POSITION, START_VELOCITY):
        sign = "+" if value >= start else ""
        return sign + shown(value - start, estimates.adjust.dimension, what)
    return f"{100.0 * (value - start) / abs(start):+.3g} %"


# --- many numbers -----------------------------------------------------------------------------


def _summary(estimates: Estimates) -> FactSection:
    """Return statistics of many numbers, and those that are known least."""
    adjust, known = estimates.adjust, estimates.identified
    rows = [
        ("before", *_spread(estimates, estimates.start)),
        ("learnt", *_spread(estimates, estimates.value)),
    ]
    parts: list[Part] = [FactTable(("", "median", "quartiles", "range"), rows)]
    half = uncertainty(estimates)[known]
    if len(half):
        typical, most = float(np.median(half)), float(half.max())
        parts.append(f"accurate to {percent(typical)} (median), {percent(most)} (worst)")
    if not known.all():
        parts.append(f"not identified: {int((~known).sum())} of them")
    for number in _worst(estimates):
        value = _shown(estimates, estimates.value[number])
        name, interval = estimates.names[number], _interval(estimates, number)
        parts.append(Fact("least accurate", f"{name}: {value} ({interval})"))
    count = counted(len(known), "parameter")
    title = f"{adjust.what} per {adjust.per} of {adjust.of}: {count}"
    return FactSection(title, parts, apart=False)


def _spread(estimates: Estimates, values: Floats) -> tuple[str, str, str]:
    low, first, middle, last, high = np.quantile(values, [0.0, 0.25, 0.5, 0.75, 1.0])
    return (
        _shown(estimates, middle),
        f"{_shown(estimates, first)} to {_shown(estimates, last)}",
        f"{_shown(estimates, low)} to {_shown(estimates, high)}",
    )


def uncertainty(estimates: Estimates) -> Floats:
    """Return half the width of each interval divided by its value, dimensionless.

    It is infinite where the data does not identify a number, or where it is 0; shape (number,).
    """
    size = np.abs(estimates.value)
    width = (estimates.high - estimates.low) / 2.0
    found = np.full(len(size), np.inf)
    told = estimates.identified & (size > 0.0) & np.isfinite(width)
    found[told] = width[told] / size[told]
    return found


def _worst(estimates: Estimates) -> list[int]:
    order = np.argsort(-uncertainty(estimates), kind="stable")
    return order[:WORST].tolist()


def drifts(scene: Scene, texts: Mapping[str, str]) -> list[Drift]:
    """Return how far each word moved whose file has a new text.

    Args:
        texts: New texts by the names that the scene has for their files.
    """
    if not texts:
        return []
    return drifts_between(scene.vocabulary, reread(scene, texts).vocabulary)


def sentences(moved: Iterable[Drift]) -> Iterator[str]:
    """Yield sentences about words that moved."""
    return (f"word: {one.sentence}" for one in moved if one.most != 0.0)


def differences(scene: Scene, texts: Mapping[str, str]) -> Iterator[str]:
    """Yield the change of each text as a unified diff."""
    before = {source.name: source.text for source in (*scene.imports, scene.source)}
    yield from unified(before, texts)


def unified(before: Mapping[str, str], texts: Mapping[str, str]) -> Iterator[str]:
    """Yield the change of each text as a unified diff.

    Args:
        before: Old texts by name.
        texts: New ones.
    """
    for name, text in texts.items():
        old, new = before[name].splitlines(True), text.splitlines(True)
        yield "".join(unified_diff(old, new, name, f"{name} (learned)"))


class Passes(ProgressLine):
    """The line of a learning: passes, the part of the data in use, errors, time left.

    Until it ends, a learning writes nothing that can be read, so files get lines, too.
    """

    def __init__(self, name: str, *, shown: bool):
        super().__init__(name, shown=shown, logged=True)

    def at(self, progress: LearnProgress) -> None:
        """Show the state of a learning, if it is time to."""
        self.show(lambda _: f"{self.name}: {self._text(progress)}")

    def _text(self, at: LearnProgress) -> str:
        if at.fits is not None:
            return f"{counted(at.fits, 'fit')} to simulated data, {at.seconds:.0f} s"
        parts = [f"pass {at.passes} of at most {at.most}"]
        if at.horizon < 1.0:
            parts.append(f"first {100 * at.horizon:.0f} % of the data")
        if at.first > 0.0:
            parts.append(f"error {at.error / at.first:.2e} of the first")
        if at.held_out is not None:
            parts.append(f"held out {100 * at.held_out:.3g} %")
        parts.append(f"{at.seconds:.0f} s")
        if at.passes > 0:
            left = (at.most - at.passes) * at.seconds / at.passes
            parts.append(f"at most {minutes(left)} left")
        return ", ".join(parts)


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


def fitted_as_dict(learnt: LearntVocabulary) -> dict[str, Any]:
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
