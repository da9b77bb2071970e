"""Conclusions from words alone for numbers of tissues, as a function of words and weights.

The first parameters move words (see ``MovingVocabulary``); the others are logarithms of the
factors by which weights of rules change. Rules and descriptions are evaluated by the functions
that compile a scene, with dual numbers, so that derivatives are exact.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, log

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.errors import TissueError
from tissuec.core.source import Span
from tissuec.fuzzy.duals import Dual, exp, slopes_of
from tissuec.fuzzy.rulebase import Inference
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.model import SIGMA
from tissuec.learn.vocabulary.moving import MovingVocabulary
from tissuec.learn.vocabulary.texts import TextEdit
from tissuec.learn.vocabulary.used import Use, use_of
from tissuec.model.network import Floats
from tissuec.scene.learning.model import VocabularyFit
from tissuec.scene.program.parameters import Constants
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.words.vocabulary import RulesBlock, RulesReader, Vocabulary

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
