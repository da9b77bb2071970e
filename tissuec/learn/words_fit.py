"""The fit of a vocabulary to numbers of tissues: model, optimiser and outcome.

E = ½ Σ w ((y(θ) - t) / σ)² + ½ Σ (θ / s)²

with the conclusion y of the words and the number t of a tissue, both in the coordinate of the
scale of the quantity (the logarithm on a scale with ``on log scale``), their standard deviation
σ, and the weight w of the fit. The second sum determines parameters that the first leaves open.

Conclusions from words alone for numbers of tissues, as a function of words and weights.

The first parameters move words (see ``MovingVocabulary``); the others are logarithms of the
factors by which weights of rules change. Rules and descriptions are evaluated by the functions
that compile a scene, with dual numbers, so that derivatives are exact.

Shared arguments:
    theta: Parameters: those of words, then logarithms of changes of weights,
        dimensionless, shape (number,).
    words: The program with the block, as far as it needs no bodies.
    fit: The ``learn`` block.
    learnt: The finished fit.
"""

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf, log
from typing import Any

import numpy as np
from msgspec import Struct

from tissuec.core.errors import CompileError, TissueError
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.fuzzy.duals import Dual, exp, slopes_of
from tissuec.fuzzy.rulebase import Inference
from tissuec.lang import syntax as s
from tissuec.learn.fit.learning import LearnProgress
from tissuec.learn.fit.outcome import DemandVerdict, verdicts_of
from tissuec.learn.vocabulary.moving import SIGMA, Drift, MovingVocabulary, drifts_between
from tissuec.learn.vocabulary.texts import TextEdit, apply
from tissuec.learn.vocabulary.used import Replaced, Use, use_of
from tissuec.model.network import Floats
from tissuec.pipeline import read_words
from tissuec.scene.learning.model import VocabularyFit, WordTarget
from tissuec.scene.program.parameters import Constants
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.scene.words.vocabulary import RulesBlock, RulesReader, Vocabulary
from tissuec.script.fit_problem import Errors

LEAST = 1e-3
"""Smallest weight, unless it is smaller already: no rule vanishes."""
FARTHEST = 10.0
"""Largest parameter of a word, at which a gap has nearly vanished."""
WORD_SIGMA, WEIGHT_SIGMA = SIGMA, log(3.0)
"""Standard deviations of parameters about the original text, so that words do not wander for a
few numbers, and parameters that the numbers leave open keep their values."""

WRITTEN_CLOSE = 5e-3  # allowed deviation of a written corner, as a part of the smallest gap
_WEIGHT_DIGITS = 2


class RuleWeight(Struct, frozen=True):
    """The weight of a rule that may change.

    Attributes:
        rules: Lower-case name of the rules.
        index: Of the rule among them.
        start: The written weight; 1 if there is none.
    """

    rules: str
    index: int
    start: float
    item: s.Rule


class VocabularyModel:
    """Conclusions of a vocabulary for the numbers of a fit.

    Attributes:
        words: Words that move.
        weights: Weights that change.
    """

    def __init__(self, program: ResolvedProgram, fit: VocabularyFit):
        self.program, self.targets = program, fit.targets
        self.words = MovingVocabulary(program, fit.scales)
        quantities = {target.quantity for target in fit.targets}
        self.weights = list(_weights(program, fit.rules, quantities))
        self.size = self.words.size + len(self.weights)
        asked: dict[str, list[str]] = {}
        for target in fit.targets:
            asked.setdefault(target.tissue, []).append(target.quantity)
        self.uses: list[Use] = [
            use_of(key, program.tissues[key], tuple(some), program)
            for key, some in asked.items()
        ]

    def places(self, theta: Floats) -> tuple[Floats, Floats]:
        """Return the conclusion from words for each target, and the derivatives.

        Returns:
            In the coordinates of the scales, which are SI units or their logarithms, shapes
            (target,) and (target, number).

        Raises:
            TissueError: With these words no rule concludes a quantity any more.
        """
        total = self.size
        vocabulary = self.words.vocabulary(theta[: self.words.size], total=total)
        factors = self._weights_at(theta)
        scope = Constants(
            self.program.declarations, self.program.constants.overrides, Findings()
        )
        rules: dict[str, RulesBlock] = {}
        found: dict[tuple[str, str], float] = {}
        for use in self.uses:
            if use.rules not in rules:
                rules[use.rules] = self._rules(use.rules, vocabulary, factors, scope)
            facts = use.facts(vocabulary, scope)
            for key in use.quantities:
                answer = rules[use.rules].base.conclude(key, facts)
                if not isinstance(answer, Inference):
                    raise TissueError(f"with these words, no rule gives the {key} of {use.key}")
                found[use.key, key] = self.coordinate(key, answer.value)
        listed = [found[target.tissue, target.quantity] for target in self.targets]
        slopes = [slopes_of(place, total) for place in listed]
        shape = len(listed), total
        return np.array([float(place) for place in listed]), np.reshape(slopes, shape)

    def coordinate(self, key: str, value: float) -> float:
        """Return a value of a quantity on its scale."""
        return self.program.vocabulary.quantities[key].named.scale.axis.coordinate(value)

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the smallest and largest parameters, dimensionless, shape (number,) each."""
        low = [-FARTHEST] * self.words.size
        high = [FARTHEST] * self.words.size
        for weight in self.weights:
            low.append(min(log(LEAST / weight.start), -1e-9))
            high.append(max(-log(weight.start), 1e-9))
        return np.array(low), np.array(high)

    def sigma(self) -> Floats:
        """Return the standard deviations of the parameters, dimensionless, shape (number,)."""
        return np.array(
            [WORD_SIGMA] * self.words.size + [WEIGHT_SIGMA] * len(self.weights), dtype=float
        )

    def edits(self, theta: Floats) -> Iterator[TextEdit]:
        """Yield the edits that write words and weights, with few digits."""
        yield from self.words.edits(theta[: self.words.size], WRITTEN_CLOSE)
        for weight, now in zip(self.weights, self._written_weights(theta), strict=True):
            if now == weight.start:
                continue
            clause = next(iter(weight.item.clauses), None)
            if clause is not None:
                yield TextEdit(clause.value.span, f"{now:g}")
                continue
            end = weight.item.span.end
            place = Span(weight.item.span.source, end, end)
            yield TextEdit(place, f" weighing {now:g}")

    def changed_weights(self, theta: Floats) -> list[tuple[RuleWeight, float]]:
        """Return the weights that change, each with its new written value."""
        pairs = zip(self.weights, self._written_weights(theta), strict=True)
        return [(weight, now) for weight, now in pairs if now != weight.start]

    def _written_weights(self, theta: Floats) -> list[float]:
        parts = theta[self.words.size :].tolist()
        return [
            float(f"{min(weight.start * float(np.exp(part)), 1.0):.{_WEIGHT_DIGITS}g}")
            for weight, part in zip(self.weights, parts, strict=True)
        ]

    def _weights_at(self, theta: Floats) -> dict[tuple[str, int], float]:
        """Return the weights of rules that change, as dual numbers."""
        found: dict[tuple[str, int], float] = {}
        for number, weight in enumerate(self.weights, self.words.size):
            unit = np.zeros(self.size)
            unit[number] = 1.0
            now = exp(Dual(float(theta[number]), unit)) * weight.start
            found[weight.rules, weight.index] = (
                now if now <= 1.0 else Dual(1.0, slopes_of(now, self.size))
            )
        return found

    def _rules(
        self,
        key: str,
        vocabulary: Vocabulary,
        factors: Mapping[tuple[str, int], float],
        scope: Constants,
    ) -> RulesBlock:
        declared = self.program.declarations.of("rules")[key]
        block = RulesReader(declared.name, declared.item, vocabulary, scope).read()
        rules = tuple(
            replace(rule, weight=factors.get((key, number), rule.weight))
            for number, rule in enumerate(block.base.rules)
        )
        return replace(block, base=replace(block.base, rules=rules))


def _weights(
    program: ResolvedProgram, names: Sequence[str], quantities: set[str]
) -> Iterator[RuleWeight]:
    """Yield the weights of rules that conclude a fitted quantity."""
    for key in names:
        block = program.declarations.of("rules")[key].item
        assert isinstance(block, s.Block)
        items = [item for item in block.items if isinstance(item, s.Rule)]
        rules = program.vocabulary.rules[key].base.rules
        for number, (rule, item) in enumerate(zip(rules, items, strict=True)):
            if quantities & {one.quantity for one in rule.conclusions}:
                yield RuleWeight(key, number, rule.weight, item)


def factor(one: float, other: float) -> float:
    """Return the factor by which two numbers differ, at least 1; infinite for different
    signs."""
    if one == other:
        return 1.0
    ratio = other / one if one else inf
    return max(ratio, 1.0 / ratio) if ratio > 0.0 else inf


HELD_OUT, ALL = "held out", "data"
NOTABLE = 1.01
"""Factor from which a change of a number that is not fitted is reported."""


class FittedNumber(Struct, frozen=True):
    """A number of a tissue, and those that its words give, in SI units.

    Attributes:
        name: Name of the quantity and the tissue: "Young's modulus of liver".
        before, after: Numbers from words before and after the fit.
    """

    target: WordTarget
    name: str
    before: float
    after: float

    @property
    def factor(self) -> float:
        """Return the factor by which words are off after the fit, at least 1."""
        return factor(self.target.value, self.after)

    @property
    def factor_before(self) -> float:
        """Return the factor by which they were off before."""
        return factor(self.target.value, self.before)


class LearntVocabulary(Struct, frozen=True, eq=False):
    """A finished fit of words.

    Attributes:
        numbers: In the order of the targets.
        error, first_error: The error function after and before.
        evaluations: Number of evaluations of the words.
        reason: The reason why it ended.
        converged: Whether it ended before the passes ran out.
        wall_time: [s].
        texts: New texts of files by the names that the program has for them.
        moved: Displacements of words.
        weights: Weights that changed, each with its new value.
        notes: Further remarks.
    """

    fit: VocabularyFit
    numbers: tuple[FittedNumber, ...]
    error: float
    first_error: float
    evaluations: int
    reason: str
    converged: bool
    wall_time: float
    texts: Mapping[str, str]
    moved: tuple[Drift, ...]
    weights: tuple[tuple[RuleWeight, float], ...]
    notes: tuple[str, ...]

    @property
    def errors(self) -> Errors:
        """Return the errors that expectations can use, by name: the largest factor less 1.

        These are the errors of the fitted numbers, of those held out, and of each tissue.
        """
        parts = {
            ALL: [one for one in self.numbers if not one.target.held_out],
            HELD_OUT: [one for one in self.numbers if one.target.held_out],
        }
        for one in self.numbers:
            parts.setdefault(one.target.tissue, []).append(one)
        return {
            name: max(one.factor for one in some) - 1.0 for name, some in parts.items() if some
        }

    @property
    def verdicts(self) -> list[DemandVerdict]:
        """Return a verdict on each expectation."""
        return verdicts_of(self.fit.demands, self.errors)


def fit_words(
    request: Request,
    fit: VocabularyFit,
    words: ResolvedProgram,
    *,
    progress: Callable[[LearnProgress], None] | None = None,
) -> LearntVocabulary:
    """Carry out a ``learn`` block that fits words to numbers of tissues.

    Args:
        request: The text with the block; it need not be a scene.
        fit: The block.
        words: The vocabulary and the tissues of the text.
        progress: Callback after each evaluation.

    Raises:
        TissueError: The new words cannot be written.
    """
    from scipy.optimize import least_squares

    began = clock.monotonic()
    model = VocabularyModel(words, fit)
    problem = _Problem(model, fit)
    start = np.zeros(model.size)
    first = problem.error(start)

    def residuals(theta: Floats) -> Floats:
        found = problem.residuals(theta)
        if progress is not None:
            error, seconds = 0.5 * float(found @ found), clock.monotonic() - began
            progress(
                LearnProgress(problem.evaluations, fit.passes, 1.0, error, first, None, seconds)
            )
        return found

    found: Any = least_squares(
        residuals, start, jac=problem.jacobian, bounds=model.bounds(), x_scale=1.0,
        ftol=max(fit.tolerance, 1e-15), xtol=1e-10, gtol=None, max_nfev=fit.passes,
    )  # fmt: skip
    theta = np.asarray(found.x) if problem.error(found.x) < first else start
    texts = apply(model.edits(theta))
    after = reread_words(request, texts)
    converged = found.status > 0
    return LearntVocabulary(
        fit=fit,
        numbers=tuple(_numbers(fit, words, after)),
        error=problem.error(theta),
        first_error=first,
        evaluations=problem.evaluations,
        reason="the error no longer decreases" if converged else "the passes ran out",
        converged=converged,
        wall_time=clock.monotonic() - began,
        texts=texts,
        moved=tuple(drifts_between(words.vocabulary, after.vocabulary)),
        weights=tuple(model.changed_weights(theta)),
        notes=(*fit.left_out, *_side_effects(fit, words, after)),
    )


class _Problem:
    """Residuals of one fit, in units of their standard deviations."""

    def __init__(self, model: VocabularyModel, fit: VocabularyFit):
        self.model = model
        self.rows = np.array([not one.held_out for one in fit.targets])
        learning = [one for one in fit.targets if not one.held_out]
        self.wanted = np.array(
            [model.coordinate(one.quantity, one.value) for one in learning], dtype=float
        )
        self.scale = np.array([one.weight**0.5 / one.deviation for one in learning])
        self.sigma = model.sigma()
        self.evaluations = 0
        self.last: tuple[Floats, Floats, Floats] | None = None

    def residuals(self, theta: Floats) -> Floats:
        """Return the deviations, and the pull to the old text; NaN if no rule fires."""
        try:
            places, _ = self._places(theta)
        except TissueError:
            return np.full(len(self.wanted) + len(theta), np.nan)
        return np.concatenate([self.scale * (places - self.wanted), theta / self.sigma])

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of the residuals, shape (residual, number)."""
        _, slopes = self._places(theta)
        return np.concatenate([self.scale[:, None] * slopes, np.diag(1.0 / self.sigma)])

    def error(self, theta: Floats) -> float:
        """Return the error function."""
        left = self.residuals(theta)
        return 0.5 * float(left @ left)

    def _places(self, theta: Floats) -> tuple[Floats, Floats]:
        if self.last is None or not np.array_equal(self.last[0], theta):
            self.evaluations += 1
            places, slopes = self.model.places(theta)
            self.last = np.array(theta), places[self.rows], slopes[self.rows]
        return self.last[1], self.last[2]


def reread_words(request: Request, texts: Mapping[str, str]) -> ResolvedProgram:
    """Return vocabulary and tissues with new texts of some files.

    Raises:
        TissueError: The new texts are not valid.
    """
    source = request.source
    main = replace(source, text=texts.get(source.name, source.text))
    again = replace(request, source=main, strict=False, files=Replaced(texts, request.files))
    try:
        return read_words(again)[0]
    except CompileError as error:
        raise TissueError(f"the new words cannot be written:\n{error}") from error


def _numbers(
    fit: VocabularyFit, before: ResolvedProgram, after: ResolvedProgram
) -> list[FittedNumber]:
    found: list[FittedNumber] = []
    for target in fit.targets:
        old, new = before.tissues[target.tissue], after.tissues[target.tissue]
        quantity = before.vocabulary.quantities[target.quantity].named.name
        found.append(
            FittedNumber(
                target,
                f"{quantity} of {old.name}",
                old.concluded[target.quantity],
                new.concluded[target.quantity],
            )
        )
    return found


def _side_effects(
    fit: VocabularyFit, before: ResolvedProgram, after: ResolvedProgram
) -> list[str]:
    """Return sentences about quantities that are not fitted and change with the words."""
    fitted = {target.quantity for target in fit.targets}
    most: dict[str, tuple[float, str]] = {}
    for key, old in before.tissues.items():
        for quantity, value in old.concluded.items():
            now = after.tissues[key].concluded.get(quantity, value)
            if quantity not in fitted and (far := factor(value, now)) >= NOTABLE:
                most[quantity] = max(most.get(quantity, (1.0, "")), (far, old.name))
    return [
        f"words also change the {QUANTITIES[key].name}, which is not fitted, by up to a factor "
        f"of {far:.3g} ({tissue})"
        for key, (far, tissue) in most.items()
    ]
