"""Words of a tissue that have no effect: hedges that rules do not distinguish, and numbers that
take precedence over what rules conclude."""

from collections.abc import Collection, Iterable, Mapping
from typing import TypeAlias

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.fuzzy.rulebase import Inference, NoRule
from tissuec.lang import syntax as s
from tissuec.scene.model import AssignedQuantity, PropertyFact
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import CONCLUDED, replaced_by
from tissuec.scene.words.phrases import reading
from tissuec.scene.words.vocabulary import RulesBlock, Vocabulary

#: Conclusions closer than this part of their scale count as nearly the same.
ALIKE = 0.035

#: What rules say about each quantity.
Answers: TypeAlias = Mapping[str, Inference | NoRule]


class TissueWords(Struct, frozen=True):
    """The words of one tissue, and what rules conclude from them.

    Attributes:
        phrases: Where the words of properties are written.
    """

    rules: RulesBlock
    vocabulary: Vocabulary
    facts: tuple[PropertyFact, ...]
    phrases: Mapping[str, Span]
    answers: Answers
    findings: Findings

    @property
    def _numbers(self) -> dict[str, float]:
        return {fact.property: fact.number for fact in self.facts}

    def warn_of_unasked_properties(self, own: Collection[str]) -> None:
        """W205: no rule uses a property of the tissue.

        Args:
            own: Properties that the tissue itself writes.
        """
        asked = self.rules.base.asked
        for fact in self.facts if asked else ():
            if fact.property in own and fact.property not in asked:
                self.findings.add(
                    "W205",
                    f"{fact.property} has no effect: no rule of {self.rules.name} uses it",
                    fact.span,
                    hint="remove it, or describe the tissue in rules that use it",
                )

    def warn_of_idle_hedges(self, own: Collection[str]) -> None:
        """W205: the rules say the same of a word with a hedge as of the word alone.

        Args:
            own: Properties that the tissue itself writes.
        """
        for fact in self.facts:
            words = self.vocabulary.properties[fact.property].scale
            read = reading(s.key_of(fact.written), words.words, self.vocabulary.hedges)
            if fact.property not in own or read is None or not read[0]:
                continue
            plain = words.axis.value_of(words.words[read[1]])
            asked = [key for key, one in self.answers.items() if fact.property in _asked(one)]
            if plain == fact.number or not asked or self._differ(fact, plain, asked):
                continue
            is_gradual = self.rules.base.operators.result == "gradual mean"
            way_out = "" if is_gradual else (
                '; or choose rules in which every hedge counts: "result is gradual mean", '
                'as in "fuzzy/soft_matter"'
            )  # fmt: skip
            self.findings.add(
                "W205",
                f'"{fact.written}" gives the same numbers as "{read[1]}": the rules do not '
                "distinguish them",
                self.phrases[fact.property],
                hint=Hint(f'write "{read[1]}", or write numbers{way_out}', Edit(read[1])),
            )

    def warn_of_outdone_ones(
        self,
        own: Collection[str],
        before: Iterable[PropertyFact],
        numbers: Mapping[str, AssignedQuantity],
        inherited: Mapping[str, AssignedQuantity],
    ) -> None:
        """W206: the rules say something else than of the parent, whose number still holds.

        Args:
            own: Properties that the tissue itself writes.
            before: What the parent says.
            numbers: Written in the tissue or its parents, by quantity.
            inherited: Written in the parents.
        """
        held = [k for k, given in numbers.items() if given is inherited.get(k)]
        earlier = self.rules.base.infer({f.property: f.number for f in before}) if held else {}
        for key in held:
            answer = self.answers.get(key)
            asked = [
                f for f in self.facts if f.property in own and f.property in _asked(answer)
            ]
            if not asked or self._alike(key, answer, earlier[key]):
                continue
            given, names = numbers[key], ", ".join(fact.property for fact in asked)
            name = given.quantity.name
            last = max((fact.span for fact in asked), key=lambda span: span.end)
            self.findings.add(
                "W206",
                f"{names} {'is' if len(asked) == 1 else 'are'} written here, but the {name} "
                f"is inherited as a number from {given.span.place}",
                asked[0].span,
                hint=Hint(
                    f'write "{name} is {CONCLUDED}", so that the words count, or "{name} = …"',
                    Edit(f"{last.text}; {name} is {CONCLUDED}", last),
                ),
            )

    def refuse_outdone_ones(
        self,
        changed: Collection[str],
        tissue: str,
        numbers: Mapping[str, AssignedQuantity],
        left: Collection[str],
    ) -> None:
        """TIS208: a word that is set from outside would change a quantity written as a number.

        A word that changes a quantity left to rules on purpose is accepted, although other
        numbers remain.

        Args:
            changed: Properties that are set, by ``--set``, a study or Python.
            tissue: Name of the tissue.
            numbers: Written in the tissue or its parents, by quantity.
            left: Quantities that the text declares as concluded.
        """
        for fact in self.facts:
            if fact.property not in changed:
                continue
            if any(key in self.answers and self._counts(fact, key) for key in left):
                continue
            outdone = [
                given
                for own, given in numbers.items()
                if any(
                    key in self.answers and self._counts(fact, key)
                    for key in (own, *(_replaced(own, given) - numbers.keys()))
                )
            ]
            if not outdone:
                continue
            names = ", ".join(given.quantity.name for given in outdone)
            first = outdone[0].quantity.name
            shown = ", ".join(_shown(given) for given in outdone)
            self.findings.add(
                "TIS208",
                f"{fact.property} of {tissue} has no effect on its {names}, which "
                f"{'are written as numbers' if outdone[1:] else 'is written as a number'} "
                f"({shown})",
                fact.span,
                hint=f'set "{first} of {tissue} is {CONCLUDED}", too, so that words count '
                f"(in a study: vary {first} of {tissue} = [{CONCLUDED}]), or set the number",
                notes=tuple(Note("the number", given.span) for given in outdone),
            )

    def _counts(self, fact: PropertyFact, key: str) -> bool:
        """Return whether another word of a property would change what rules say."""
        scale = self.vocabulary.properties[fact.property].scale
        places = [scale.axis.value_of(shape) for shape in scale.words.values()]
        return any(self._differ(fact, place, [key]) for place in places)

    def _alike(
        self, key: str, one: Inference | NoRule | None, other: Inference | NoRule | None
    ) -> bool:
        """Return whether conclusions are nearly the same: less than a hedge of the word
        apart."""
        first, second = _value(one), _value(other)
        if first is None or second is None:
            return first == second
        axis = self.vocabulary.quantities[key].named.scale.axis
        low, high = axis.bounds
        apart = abs(axis.to_scale(first) - axis.to_scale(second))
        return apart <= ALIKE * (high - low)

    def _differ(self, fact: PropertyFact, place: float, keys: Iterable[str]) -> bool:
        """Return whether rules say something else of another value of a property."""
        numbers = self._numbers | {fact.property: place}
        base = self.rules.base
        return any(_value(base.conclude(k, numbers)) != _value(self.answers[k]) for k in keys)


def _replaced(key: str, given: AssignedQuantity) -> set[str]:
    """Return the other conclusions that a written number replaces."""
    return set(replaced_by(key, is_none=given.value == given.quantity.none))


def _asked(answer: Inference | NoRule | None) -> set[str]:
    """Return the properties that rules on a quantity use."""
    if answer is None:
        return set()
    fired = answer.fired if isinstance(answer, Inference) else ()
    return {atom.property for firing in (*fired, *answer.silent) for atom in firing.atoms}


def _value(answer: Inference | NoRule | None) -> float | None:
    return answer.value if isinstance(answer, Inference) else None


def _shown(given: AssignedQuantity) -> str:
    if given.value == given.quantity.none:
        return "none"
    return given.quantity.show(given.value)
