"""Proposed words for numbers: the description of a tissue that comes nearest to them.

All words of each property are tried, plain and with one hedge, property by property, until no
change of a single word comes nearer; the search begins with several descriptions. Numbers are
compared in the coordinates of their scales. Properties that change nothing are left out.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.names import key_of
from tissuec.fuzzy.hedges import Shift, has_effect, hedged
from tissuec.fuzzy.rulebase import Inference
from tissuec.lang.words import written_name
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.scene.words.vocabulary import RulesBlock, Vocabulary

#: Weight of deviations on a linear scale, relative to its range.
_LINEAR = 3.0
#: Deviations up to which a plain word is preferred to a hedged one, and a word to its neighbour
#: that is further from the initial one: to come nearer by 3 % is not worth a hedge.
_PER_HEDGE, _PER_STEP = 0.03, 0.05
_IDLE = 1e-3  # deviation below which a property counts as without effect
_SWEEPS = 12
_LEAST_DEGREE = 0.01
_CLEAR = 0.02  # change of a coordinate that counts as clear


class TriedWord(Struct, frozen=True):
    """A word of a property, plain or with a hedge.

    Attributes:
        text: As it is written.
        value: Its value.
        is_hedged: Whether there is a hedge.
        steps: Distance from the initial word, in words.
    """

    text: str
    value: float
    is_hedged: bool
    steps: float


class ProposedWord(Struct, frozen=True):
    """The proposal for one property.

    Attributes:
        property: Its name.
        phrase: The word, with its hedge: "rather soft".
        degrees: The words of the property that are true for it, with their degrees.
        decides: The requested quantity that it changes most; empty if there is no clear one.
    """

    property: str
    phrase: str
    degrees: tuple[tuple[str, float], ...]
    decides: str


class ProposedNumber(Struct, frozen=True):
    """A requested number, and that of the words.

    Attributes:
        quantity: Its name.
        wanted: The number, in SI units; None if it was not requested.
        found: The number that the words give.
        ratio: ``found`` over ``wanted``; None without.
    """

    quantity: str
    wanted: float | None
    found: float
    ratio: float | None

    def shown(self, value: float | None) -> str:
        """Return a value with its unit."""
        if value is None:
            return ""
        return QUANTITIES[key_of(self.quantity)].show(value, digits=4)


class ProposedTissue(Struct, frozen=True):
    """A description in words.

    Attributes:
        rules: Name of the rules that it is written for.
        words: Proposals, property by property.
        numbers: Those that were requested, then others that follow from the words.
        left: Properties that change none of the requested numbers.
    """

    rules: str
    words: tuple[ProposedWord, ...]
    numbers: tuple[ProposedNumber, ...]
    left: tuple[str, ...]

    def text(self, name: str) -> str:
        """Return the tissue under a name, as text to paste into a file."""
        lines = [f"  {one.property} is {one.phrase}" for one in self.words]
        head = f"tissue {written_name(name)} {{\n  described in {written_name(self.rules)}"
        return "\n".join([head, *lines, "}"])


def propose(
    vocabulary: Vocabulary,
    wanted: Mapping[str, AssignedQuantity],
    rules: str = "",
    facts: Mapping[str, float] | None = None,
) -> ProposedTissue:
    """Return the words that come nearest to numbers.

    Args:
        wanted: The numbers, by keys of their quantities.
        rules: Key of the rules to be used; otherwise the first that conclude most of them.
        facts: Initial values of properties; otherwise those in the middle.

    Raises:
        TissueError: There are no rules, or none that conclude any of the numbers.
    """
    if not vocabulary.rules:
        raise TissueError("the file has no rules, so no words lead to numbers")
    chosen = vocabulary.rules.get(rules)
    if chosen is None:
        chosen = max(
            vocabulary.rules.values(), key=lambda one: len(one.concluded & set(wanted))
        )
    asked = {key: one.value for key, one in wanted.items() if key in chosen.concluded}
    asked = {key: value for key, value in asked.items() if isfinite(value)}
    if not asked:
        names = ", ".join(QUANTITIES[key].name for key in sorted(chosen.concluded))
        raise TissueError(
            f"no rule of {chosen.name} concludes any of these numbers; it concludes: {names}"
        )
    return _WordSearch(vocabulary, chosen, asked, facts or {}).found()


class _WordSearch:
    """The search for words."""

    def __init__(
        self,
        vocabulary: Vocabulary,
        rules: RulesBlock,
        wanted: Mapping[str, float],
        facts: Mapping[str, float],
    ):
        self.vocabulary, self.rules, self.wanted = vocabulary, rules, wanted
        self.phrases = {
            key: list(_phrases(vocabulary, key, facts.get(key)))
            for key in vocabulary.properties
            if key in rules.base.asked
        }

    def found(self) -> ProposedTissue:
        """Return the best description."""
        best = min(map(self._descended, self._starts()), key=self.cost)
        kept = dict(best)
        for key in best:
            fewer = {one: phrase for one, phrase in kept.items() if one != key}
            if self.cost(fewer) <= self.cost(kept) + _IDLE:
                kept = fewer
        kept = self._descended(kept)
        answers = self._answers(kept)
        numbers = [
            ProposedNumber(
                QUANTITIES[key].name, value, answers[key], _ratio(answers[key], value)
            )
            for key, value in self.wanted.items()
            if key in answers
        ]
        numbers += [
            ProposedNumber(QUANTITIES[key].name, None, value, None)
            for key, value in answers.items()
            if key not in self.wanted
        ]
        properties = self.vocabulary.properties
        return ProposedTissue(
            self.rules.name,
            tuple(self._word(key, phrase, kept) for key, phrase in kept.items()),
            tuple(numbers),
            tuple(properties[key].name for key in self.phrases if key not in kept),
        )

    def _starts(self) -> Iterator[dict[str, TriedWord]]:
        """Yield initial descriptions: the nearest, and others in and off the middle."""
        yield {key: min(several, key=_steps) for key, several in self.phrases.items()}
        for part in (0.5, 0.25, 0.75):
            yield {
                key: _plain(phrases)[round(part * (len(_plain(phrases)) - 1))]
                for key, phrases in self.phrases.items()
            }

    def _descended(self, start: dict[str, TriedWord]) -> dict[str, TriedWord]:
        """Return a description that no change of a single word improves."""
        said, cost = dict(start), self.cost(start)
        for _ in range(_SWEEPS):
            before = cost
            for key in said:
                for phrase in self.phrases[key]:
                    other = {**said, key: phrase}
                    found = self.cost(other)
                    if found < cost - 1e-12:
                        said, cost = other, found
            if cost == before:
                break
        return said

    def cost(self, said: Mapping[str, TriedWord]) -> float:
        """Return the distance of a description from the numbers; infinite if it gives none."""
        answers = self._answers(said)
        if any(key not in answers for key in self.wanted):
            return float("inf")
        off = sum(self._off(key, answers[key]) ** 2 for key in self.wanted)
        extra = (_PER_HEDGE * one.is_hedged + _PER_STEP * one.steps for one in said.values())
        return off**0.5 + sum(extra)

    def _off(self, key: str, value: float) -> float:
        """Return the deviation of a number, in logarithms or parts of its range."""
        axis = self.vocabulary.quantities[key].named.scale.axis
        wanted = min(max(self.wanted[key], axis.low), axis.high)
        apart = axis.coordinate(value) - axis.coordinate(wanted)
        return apart if axis.log else _LINEAR * apart / (axis.high - axis.low)

    def _answers(self, said: Mapping[str, TriedWord]) -> dict[str, float]:
        """Return the conclusions of the rules for a description, by quantity."""
        facts = {key: phrase.value for key, phrase in said.items()}
        answers = self.rules.base.infer(facts)
        return {key: one.value for key, one in answers.items() if isinstance(one, Inference)}

    def _word(self, key: str, phrase: TriedWord, said: Mapping[str, TriedWord]) -> ProposedWord:
        named = self.vocabulary.properties[key]
        place = named.scale.axis.coordinate(phrase.value)
        degrees = [(word, shape.degree(place)) for word, shape in named.scale.words.items()]
        true_ = tuple(one for one in degrees if one[1] >= _LEAST_DEGREE)
        return ProposedWord(named.name, phrase.text, true_, self._decided(key, said))

    def _decided(self, key: str, said: Mapping[str, TriedWord]) -> str:
        """Return the number that the next words of a property change most."""
        phrases = _plain(self.phrases[key])
        here = min(range(len(phrases)), key=lambda n: abs(phrases[n].value - said[key].value))
        changes = dict.fromkeys(self.wanted, 0.0)
        for n in (here - 1, here + 1):
            if 0 <= n < len(phrases):
                answers = self._answers({**said, key: phrases[n]})
                before = self._answers(said)
                for one in changes:
                    if one in answers and one in before:
                        change = abs(self._off(one, answers[one]) - self._off(one, before[one]))
                        changes[one] = max(changes[one], change)
        most = max(changes, key=lambda one: changes[one])
        return QUANTITIES[most].name if changes[most] > _CLEAR else ""


def _steps(phrase: TriedWord) -> float:
    return phrase.steps


def _phrases(vocabulary: Vocabulary, key: str, begins: float | None) -> Iterator[TriedWord]:
    """Yield the words of a property, and each with each hedge that moves it.

    Args:
        key: Key of the property.
        begins: Its initial value; by default the middle.
    """
    scale = vocabulary.properties[key].scale
    low, high = scale.axis.bounds
    middle = 0.5 * (low + high) if begins is None else scale.axis.coordinate(begins)

    def tried(text: str, value: float, *, is_hedged: bool) -> TriedWord:
        apart = abs(scale.axis.coordinate(value) - middle) / (high - low)
        return TriedWord(text, value, is_hedged, apart * len(scale.words))

    for word, shape in scale.words.items():
        yield tried(word, scale.axis.value_of(shape), is_hedged=False)
        for name, hedge in vocabulary.hedges.items():
            if isinstance(hedge, Shift) and has_effect(hedge, shape, scale.axis):
                moved = hedged([hedge], shape, scale.axis)
                value = scale.axis.value_of(moved)
                yield tried(f"{name} {word}", value, is_hedged=True)


def _plain(phrases: Sequence[TriedWord]) -> list[TriedWord]:
    return [one for one in phrases if not one.is_hedged]


def _ratio(found: float, wanted: float) -> float | None:
    return found / wanted if wanted else None
