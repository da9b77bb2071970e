"""A learnt tissue as text, in three forms: like its original, in its words, or in numbers.

The first is the shortest and needs a file that can be used; the last needs no other file.
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct

from tissuec.core.units import LENGTH
from tissuec.lang.words import written_name
from tissuec.learn.fit.outcome import PARTS, interval, shown
from tissuec.learn.presets.drafts import Draft, LearntNumber
from tissuec.learn.presets.laws import changed_constants, exact, law_text, learnt
from tissuec.scene.model import AssignedQuantity, PropertyFact, Scene

LIKE, IN_WORDS, IN_NUMBERS = "like", "in words", "in numbers"
FORMS = (LIKE, IN_WORDS, IN_NUMBERS)
WHOLE = "whole body"


class TissueWriter(Struct, frozen=True):
    """Writes tissues of one scene.

    Attributes:
        about: What every tissue says of itself, without quotes.
    """

    scene: Scene
    about: str

    def block(self, draft: Draft, form: str) -> list[str]:
        """Return the lines of a tissue."""
        parent = f" like {written_name(draft.original.name)}" if form == LIKE else ""
        lines = [f"# for {draft.remark}"] if draft.remark else []
        lines.append(f"tissue {written_name(draft.name)}{parent} {{")
        lines.append(f'about "{self.about}"')
        if form == IN_WORDS and draft.original.vocabulary:
            lines.append(f"described in {written_name(draft.original.vocabulary)}")
            lines += [self._fact(fact) for fact in draft.original.facts]
        elif form == IN_NUMBERS:
            lines += [f"# {fact.span.one_line}" for fact in draft.original.facts]
        lines += self._numbers(draft, form)
        lines += self._laws(draft, form)
        return [*lines, "}"]

    # --- entries ------------------------------------------------------------------------------

    def _fact(self, fact: PropertyFact) -> str:
        """Return the statement of a tissue on a property: its word, or a number."""
        scale = self.scene.vocabulary.properties[fact.property]
        if "=" in fact.span.text:
            return f"{written_name(fact.property)} = {exact(fact.number, scale.dimension)}"
        return fact.span.one_line

    def _numbers(self, draft: Draft, form: str) -> Iterator[str]:
        for name in self._written(draft, form):
            given = draft.original.given[name]
            if name in draft.numbers:
                yield _learnt_line(name, draft.numbers[name], given)
            elif given.spread == WHOLE:
                value = shown(given.value, given.quantity.dimension)
                yield f"# {name} of the whole body: {value}"
            else:
                yield _given_line(given)

    def _written(self, draft: Draft, form: str) -> Sequence[str]:
        """Return the names of the quantities that a form writes, in the order of the original.

        What rules say is written only where there are no rules.
        """
        given = draft.original.given
        if form == LIKE:
            return [name for name in given if name in draft.numbers]
        if form == IN_NUMBERS:
            return list(given)
        return [n for n, one in given.items() if one.how == "written" or n in draft.numbers]

    def _laws(self, draft: Draft, form: str) -> Iterator[str]:
        for word, law in draft.original.written_laws.items():
            changed = changed_constants(law, draft.constants)
            if form == LIKE and not changed:
                continue
            text = law_text(word, law, changed, self.scene.constants)
            remarks = [f"{name}: {remark(number)}" for name, number in changed.items()]
            yield f"{text}  # {'; '.join(remarks)}" if remarks else text


def remark(number: LearntNumber, what: str = "") -> str:
    """Return the comment after a learnt number: its interval, and its former value."""
    known = f"95 %: {interval(number.low, number.high, number.dimension, what)}"
    if not number.identified:
        known = "not identified by the data"
    return f"{known}; before: {shown(number.start, number.dimension, what)}"


def _learnt_line(name: str, number: LearntNumber, given: AssignedQuantity) -> str:
    if given.spread == WHOLE:
        return (
            f"# {name} of the whole body: {shown(number.value, number.dimension, digits=6)}, "
            f"to be written in the body ({remark(number)})"
        )
    text = learnt(
        number.value, number.low, number.high, number.dimension, percent=name in PARTS
    )
    return f"{given.quantity.name} = {text}{_per(given)}  # {remark(number, name)}"


def _given_line(given: AssignedQuantity) -> str:
    name = given.quantity.name
    if given.value == given.quantity.none:
        return f"{name} is none"
    value = exact(given.value, given.quantity.dimension, percent=name in PARTS)
    return f"{name} = {value}{_per(given)}"


def _per(given: AssignedQuantity) -> str:
    """Return the length of springs that a number is for, if it is for one."""
    if given.length is None:
        return ""
    return f" per {exact(given.length, LENGTH)}"
