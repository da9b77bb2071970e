"""The clauses of a sentence: words with a value behind them, such as ``by 2 mm``."""

from collections.abc import Container, Sequence
from typing import NoReturn

import numpy as np

from tissuec.core.hints import Edit, Hint, one_left, proposal
from tissuec.core.source import Span
from tissuec.core.units import NUMBER, Dimension, suggested_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.expressions import Scope
from tissuec.scene.values import Value, unit_vector

#: Clauses that say all by their own words, beside another one with the same joining word.
FLAGS = ("with caps",)


class ClauseReader:
    """Reads the clauses of one sentence, and rejects those that nobody asked for.

    Its methods are those of ``Order`` (see ``tissuec.script.verbs``) that need no network.

    Args:
        sentence: The syntax node.
        verb: Its verb.
        forms: How sentences with this verb may be written.
        duration: Time from its beginning to its end [s]; None without an interval.
        scope: Names and findings of the scene.
    """

    def __init__(
        self, sentence: s.Sentence, verb: str, forms: tuple[str, ...], duration: float | None,
        scope: Scope,
    ):  # fmt: skip
        self.sentence = sentence
        self.verb = verb
        self.forms = forms
        self._duration, self._lasts = duration, False
        self.scope = scope
        self.span: Span = sentence.span
        self.object = _behind(sentence.name, verb)
        self.words = self.object.text
        self.clauses: dict[str, s.Clause] = {}
        self.asked: set[str] = set()
        for clause in sentence.clauses:
            flag = f"{clause.word} {clause.value.span.text.lower()}"
            if flag in FLAGS and any(flag in form for form in forms):
                self.clauses[flag] = clause
                continue
            if clause.word in self.clauses:
                first = self.clauses[clause.word].span
                hint = one_left(clause.span, first)
                scope.findings.refuse_second(f'"{clause.word}"', clause.span, first, hint=hint)
            self.clauses[clause.word] = clause

    @property
    def duration(self) -> float | None:
        """Time from the beginning of the sentence to its end [s]; None without an interval."""
        self._lasts = True
        return self._duration

    def finish(self) -> None:
        """Reject clauses that the verb did not ask for, and warn of an end that it ignored."""
        for word, clause in self.clauses.items():
            if word not in self.asked:
                form = Hint(f"write: {self._nearest_form()}", Edit(self._flag_for(clause)))
                message = f'{self.verb} does not take "{word}"'
                self.reject("TIS303", message, hint=form, word=clause.word)
        if self._duration is not None and not self._lasts:
            self.scope.findings.add(
                "W412",
                f"{self.verb} happens once, at the beginning: the end of the interval has no "
                "effect",
                self.span,
                hint='use "at" and a time; to end the effect, add an action at a later time',
            )

    def reject(
        self, code: str, message: str, *, hint: str = "", word: str | None = None
    ) -> NoReturn:
        span = self.clauses[word].span if word in self.clauses else self.span
        self.scope.findings.reject(
            code,
            message,
            span,
            hint=hint or f"write: {self._nearest_form()}",
        )

    def _flag_for(self, clause: s.Clause) -> str:
        """Return the flag that a wrong clause means: "with caps" for "on caps", or nothing."""
        for flag in FLAGS:
            is_free = flag not in self.clauses and any(flag in form for form in self.forms)
            if is_free and flag.partition(" ")[2] == clause.value.span.text.lower():
                return flag
        return ""

    def _nearest_form(self) -> str:
        """Return the form of the verb that shares most words with the sentence."""
        written = set(self.span.text.split())
        return max(self.forms, key=lambda form: len(written & set(form.split())))

    def has(self, word: str) -> bool:
        self.asked.add(word)
        return word in self.clauses

    def vector(self, word: str, dimension: Dimension) -> Floats:
        value = self._value(word)
        if not value.is_vector:
            text = self.clauses[word].value.span.text
            fits = value.dimension == dimension or value.is_literal
            part = text if fits else f"1 {suggested_unit(dimension)}".rstrip()
            hint = f"its three components, for example: {word} (0, 0, {part})"
            self.reject("TIS312", f"{word} needs a vector (x, y, z)", word=word, hint=hint)
        if np.any(value.amount) or not value.is_literal:
            self.scope.expect(
                value,
                dimension,
                self.clauses[word].value.span,
                what=f"the value after {word}",
            )
        return value.amount

    def number(self, word: str, dimension: Dimension) -> float:
        value = self._value(word)
        if value.is_vector:
            self.reject("TIS312", f"{word} needs a number, not a vector", word=word)
        self.scope.expect(
            value, dimension, self.clauses[word].value.span, what=f"the value after {word}"
        )
        return float(value.amount)

    def positive(
        self,
        word: str,
        dimension: Dimension,
        *,
        what: str,
        example: str,
        words: Sequence[str] = (),
    ) -> float:
        node = self._clause(word).value
        if words and isinstance(node, s.Name) and not self.scope.has(node):
            self.scope.findings.reject(
                "TIS305", f'there is no {what} called "{node.text}"', node.span,
                hint=Hint(f"words: {', '.join(words)}", *map(Edit, words)),
            )  # fmt: skip
        number = self.number(word, dimension)
        if number > 0.0:
            return number
        match node:
            case s.Signed(operand=s.Number() | s.Quantity() as plain) if number < 0.0:
                hint = proposal(f"{word} {plain.span.text}")
            case _:
                hint = Hint(f"for example: {example}", Edit(example))
        message = f"the {what} must be above 0, not {node.span.one_line}"
        self.reject("TIS308", message, hint=hint, word=word)

    def direction(self, word: str) -> Floats:
        value = self._value(word)
        if not value.is_vector or value.dimension != NUMBER:
            self.reject(
                "TIS312",
                f"{word} needs a direction without a unit, such as (0, 0, 1)",
                word=word,
            )
        direction = unit_vector(value.amount)
        if direction is None:
            self.reject("TIS308", "a direction cannot be (0, 0, 0)", word=word)
        return direction

    def is_vector(self, word: str) -> bool:
        return self._value(word).is_vector

    def word(self, word: str, choices: Container[str]) -> str | None:
        value = self.clauses[word].value if word in self.clauses else None
        if not isinstance(value, s.Name) or value.key not in choices:
            return None
        self.asked.add(word)
        return value.key

    def text(self, word: str) -> str:
        return self._name(word).text

    def _object(self, after: str) -> s.Name:
        name = _behind(self.object, after) if after else self.object
        if not name.text:
            self.reject("TIS304", f"the object of {self.verb} is missing")
        return name

    def _clause(self, word: str) -> s.Clause:
        if not self.has(word):
            self.reject("TIS304", f'{self.verb} needs "{word}"')
        return self.clauses[word]

    def _name(self, word: str) -> s.Name:
        value = self._clause(word).value
        if isinstance(value, s.Listing) and all(isinstance(n, s.Name) for n in value.items):
            message = f"{self.verb} takes one name after {word}"
            self.reject("TIS312", message, word=word, hint=self._one_each(value))
        if not isinstance(value, s.Name):
            self.reject("TIS312", f"{word} needs a name", word=word)
        return value

    def _one_each(self, listed: s.Listing) -> Hint:
        """Return the hint to write a sentence for each of some names."""
        text, place = self.span.text, listed.span
        start, end = place.start - self.span.start, place.end - self.span.start
        each = [f"{text[:start]}{name.span.text}{text[end:]}" for name in listed.items]
        is_alone = self.span.source.text[: self.span.start].rstrip().endswith(":")
        written = "; ".join(each)
        edit = Edit(f"{{ {written} }}" if is_alone else written, self.span)
        return Hint(f"write: {written}", edit)

    def _value(self, word: str) -> Value:
        return self.scope.evaluate(self._clause(word).value)


def _behind(name: s.Name, prefix: str) -> s.Name:
    """Return the name without its leading words; the prefix is known to be there."""
    count = len(prefix.split())
    rest = " ".join(name.words.split(" ")[count:])
    if not rest and name.quoted is None:
        return s.Name("", None, name.span)
    marker = rest or f'"{name.quoted}"'
    start = name.span.text.find(marker, len(prefix))
    span = Span(name.span.source, name.span.start + max(start, 0), name.span.end)
    return s.Name(rest, name.quoted, span)
