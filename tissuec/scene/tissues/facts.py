"""Facts of tissues: the words and numbers of their properties."""

from typing import Annotated

from tissuec.core.hints import Hint, proposal
from tissuec.fuzzy.scale import OutOfRange
from tissuec.fuzzy.sets import Powered
from tissuec.lang import syntax as s
from tissuec.scene.model import PropertyFact
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entry_hints import left_side
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.words.phrases import NamedScale, read_word
from tissuec.scene.words.vocabulary import Vocabulary
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import NameClause, Placeholder, ValueClause


class FactInWords(VerbSentence, frozen=True):
    """A property in words."""

    property: Annotated[s.Name, NameClause("", places=(Placeholder("NAME"),))]
    word: Annotated[s.Name, NameClause("is", places=(Placeholder("WORD"),))]


class FactInNumbers(VerbSentence, frozen=True):
    """A property as a number."""

    property: Annotated[s.Name, NameClause("", places=(Placeholder("NAME"),))]
    number: Annotated[s.Expression, ValueClause("=", place="NUMBER")]


FACT_KIND = SentenceKind((FactInWords, FactInNumbers))


class FactReader:
    """Reads what tissues say of properties."""

    def __init__(self, vocabulary: Vocabulary, scope: Scope):
        self.vocabulary, self.scope, self.findings = vocabulary, scope, scope.findings

    def read(self, item: s.Sentence | s.Assign) -> PropertyFact:
        """Return the fact that an entry states, or reject the entry."""
        scale = self.vocabulary.properties[item.name.key]
        if isinstance(item, s.Assign):
            number, written = self._slider(item, scale), item.value.span.text
        else:
            number, written = self._word(item, scale)
        return PropertyFact(item.name.key, written, number, item.span)

    def _slider(self, item: s.Assign, scale: NamedScale) -> float:
        if isinstance(item.value, s.Name) and item.value.key in scale.scale.words:
            self.findings.reject(
                "TIS312", 'use "is" to choose a word; "=" assigns a number', item.span,
                hint=proposal(f"{left_side(item)} is {item.value.text}"),
            )  # fmt: skip
        said: FactInNumbers = SentenceReader("", FACT_KIND, item, self.scope).get(FactInNumbers)
        value = self.scope.number(said.number)
        self.scope.expect(value, scale.dimension, said.number.span, what=scale.name)
        try:
            scale.scale.axis.to_scale(float(value.amount))
        except OutOfRange as error:
            self.findings.reject("TIS308", str(error), item.value.span)
        return float(value.amount)

    def _word(self, item: s.Sentence, scale: NamedScale) -> tuple[float, str]:
        if item.phrase is None or item.clauses:
            self.findings.reject(
                "TIS312",
                f"{item.name.text} needs a word: {left_side(item)} is …",
                item.span,
                hint=_words_joined(item),
            )
        if item.phrase.kind == "not":
            self.findings.reject(
                "TIS312", "\"not\" is not allowed in the description of a "
                "tissue", item.phrase.span,
                hint=f"write {item.name.text} is …, or {item.name.text} is between … and …",
            )  # fmt: skip
        shapes = [
            read_word(name, scale, self.vocabulary.hedges, self.scope).shape
            for name in item.phrase.words
        ]
        axis = scale.scale.axis
        if any(isinstance(shape, Powered) for shape in shapes):
            self.findings.add(
                "W205",
                f'"{item.phrase.span.text}": a power hedge does not move a word',
                item.phrase.span,
                hint="in a tissue it has no effect; use a hedge that shifts, or write a number",
            )
        number = (
            axis.value_of(shapes[0]) if len(shapes) == 1 else axis.halfway(shapes[0], shapes[1])
        )
        return number, item.phrase.span.one_line


def _words_joined(item: s.Sentence | s.Assign) -> Hint | str:
    """Return a hint for ``hardness is soft to medium``, or an empty one."""
    phrase = item.phrase if isinstance(item, s.Sentence) else None
    clauses = item.clauses
    if phrase is None or phrase.kind != "word" or [one.word for one in clauses] != ["to"]:
        return ""
    first, last = phrase.span, clauses[0].span
    words = f"between {first.text} and {clauses[0].value.span.text}"
    return proposal(words, first.to(last))
