"""The clauses of a sentence, read by the declaration of its parts."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NoReturn, TypeAlias, TypeVar, cast

import numpy as np

from tissuec.core.hints import Edit, Hint, alternatives, insertion, one_left, proposal
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import NUMBER, Dimension, describe, suggested_unit
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.values import Value, unit_vector
from tissuec.script.forms import VerbForm, VerbSentence, form_of, text_of, texts_of
from tissuec.script.parts import (
    Amount,
    AngleClause,
    CasePart,
    Cases,
    ChoiceClause,
    ClausePart,
    DirectedClause,
    DirectionClause,
    EitherClause,
    FlagPart,
    LastingPart,
    NameClause,
    NumberClause,
    Part,
    RangeClause,
    SubjectPart,
    VectorClause,
)

T = TypeVar("T", bound=VerbSentence)
#: What can be a sentence.
Written: TypeAlias = (
    s.Assign | s.Sentence | s.Function | s.Block | s.RecordedCall | s.Expect | s.Rule | s.Table
)


class ClauseReader:
    """Reads one sentence, and rejects what its form does not have.

    It is an ``Order`` (see ``tissuec.script.verbs``) for sentences that name nothing of a
    network.

    Args:
        sentence: The syntax node.
        verb: Its verb.
        forms: In which sentences with this verb may be written.
        scope: Names and findings of the scene.
        duration: Time from its beginning to its end [s]; None without an interval.
        texts: The forms for messages, if not those of the verb.
    """

    lead = "write"  # before a form in a hint

    def __init__(
        self, sentence: Written, verb: str, forms: Sequence[VerbForm],
        scope: Scope, duration: float | None = None, *, texts: Sequence[str] = (),
    ):  # fmt: skip
        self.sentence = sentence
        self.verb = verb
        self.forms = forms
        self.texts = texts
        self.duration, self._lasts = duration, False
        self.scope = scope
        self.span = _head_of(sentence)
        self.object = _object_of(sentence, verb)
        self.words = self.object.text
        self.asked: set[str] = set()
        parts = [part for form in forms for part in form.parts.values()]
        self._flags = {part.text for part in parts if isinstance(part, FlagPart)}
        may_repeat = {p.word for p in parts if isinstance(p, NameClause) and p.owners}
        self.repeated: list[s.Name] = []  # names behind the second clause with a word
        self.clauses: dict[str, s.Clause] = {}
        for clause in clauses_of(sentence):
            flag = f"{clause.word} {clause.value.span.text.lower()}"
            word = flag if flag in self._flags else clause.word
            if word in may_repeat and word in self.clauses and not self.repeated:
                self.repeated = [self._name_of(clause)]
                continue
            if word in self.clauses:
                first = self.clauses[word].span
                hint = one_left(clause.span, first)
                scope.findings.refuse_second(f'"{word}"', clause.span, first, hint=hint)
            self.clauses[word] = clause

    # --- the whole sentence -------------------------------------------------------------------

    def read(self) -> VerbSentence:
        """Return the content of the sentence, by the first form that fits."""
        form = self.choose()
        if form.cases is not None and not form.cases.word:
            self.object = behind(self.object, form.literal)
        return self.read_form(form)

    def read_form(self, form: VerbForm) -> VerbSentence:
        """Return the content of the sentence in one form, which may use only some clauses."""
        self.form = form
        for word, refusal in form.kind.refused.items():
            is_of_sine = word == "of" and "using" in self.clauses
            if word in self.clauses and form.of_word(word) is None and not is_of_sine:
                self.reject("TIS303", refusal.message, hint=refusal.hint, word=word)
        self.check_complete(form)
        values = dict[str, Any]()
        with self.scope.findings.together():
            for name, part in form.parts.items():
                with self.scope.findings.item():
                    values[name] = self._part(name, part)
        return form.kind(span=self.span, **values)

    def finish(self) -> None:
        """Reject clauses that the form does not have; warn of an end that has no effect."""
        for word, clause in self.clauses.items():
            if word not in self.asked:
                self.refuse(clause)
        if self.duration is not None and not self._lasts:
            self.scope.findings.add(
                "W412",
                f"{self.verb} happens once, at the beginning: the end of the interval has no "
                "effect",
                self.span,
                hint='use "at" and a time; to end the effect, add an action at a later time',
            )

    def refuse(self, clause: s.Clause) -> NoReturn:
        """Reject a clause that the form does not have."""
        message = f'{self.verb} does not take "{clause.word}"'
        hint = self.hint_without(clause)
        self.scope.findings.reject("TIS303", message, clause.span, hint=hint)

    def hint_without(self, clause: s.Clause) -> Hint:
        """Return the remedy for a clause that the form does not have."""
        return Hint(f"{self.lead}: {self._nearest_form()}", Edit(self._flag_for(clause)))

    def reject(
        self, code: str, message: str, *, hint: str = "", word: str | None = None
    ) -> NoReturn:
        span = self.clauses[word].span if word in self.clauses else self.span
        hint = hint or f"{self.lead}: {self._nearest_form()}"
        self.scope.findings.reject(code, message, span, hint=hint)

    def reject_at(self, span: Span, code: str, message: str) -> NoReturn:
        """Reject a place in the sentence, with a form as the hint."""
        self.scope.findings.reject(
            code, message, span, hint=f"{self.lead}: {self._nearest_form()}"
        )

    def has(self, word: str) -> bool:
        self.asked.add(word)
        return word in self.clauses

    def names_springs(self) -> bool:
        return False

    def choose(self) -> VerbForm:
        """Return the form that the words of the sentence choose."""
        cases = self.forms[0].cases
        if cases is None:
            return self.forms[0]
        by_literal = {form.literal: form for form in self.forms}
        if cases.word:
            if not self.has(cases.word):
                return by_literal[""]
            literal = self.name_in(cases.word).text.lower()
            if literal not in by_literal:
                known = filter(None, by_literal)
                hint = alternatives(literal, known, what=cases.what)
                self.reject(cases.code, cases.wrong.format(literal), hint=hint, word=cases.word)
            return by_literal[literal]
        key = key_of(self.words)
        for literal in sorted(filter(None, by_literal), key=len, reverse=True):
            form = by_literal[literal]
            if self._fits(form, key, is_only="" not in by_literal):
                return form
        return by_literal[""] if "" in by_literal else self._refuse_words(cases, key)

    def _fits(self, form: VerbForm, key: str, *, is_only: bool) -> bool:
        """Return whether words choose a form; ``is_only`` if no form without words exists."""
        if key != form.literal:
            return bool(form.subjects) and key.startswith(f"{form.literal} ")
        named = (part for part in form.parts.values() if isinstance(part, SubjectPart))
        return is_only or all(part.word in self.clauses for part in named)

    def _refuse_words(self, cases: Cases, key: str) -> NoReturn:
        if any(form.subjects for form in self.forms):
            key = key.partition(" ")[0]
        shown = cases.shown or tuple(cases.forms)
        if not key and cases.what:
            hint = alternatives("", shown, what="it can be")
            if any(form.subjects for form in self.forms):
                firsts: dict[type, VerbForm] = {}
                for form in self.forms:
                    firsts.setdefault(form.kind, form)
                texts = [text_of(self.verb, form) for form in firsts.values()]
                hint = f"write: {', or: '.join(texts)}"
            self.reject("TIS304", f"the {cases.what} is missing", hint=hint)
        if cases.hint is not None:
            hint = cases.hint(self)
        elif len(shown) == 1:
            hint = Hint(f"write: {self.verb} {shown[0]}", Edit(f"{self.verb} {shown[0]}"))
        else:
            hint = alternatives(key, shown, what="it can be")
        self.reject(cases.code, cases.wrong.format(key), hint=hint)

    def check_complete(self, form: VerbForm) -> None:
        """Reject a sentence that lacks something, before its parts are read."""
        for name, part in form.parts.items():
            if name not in form.optional and isinstance(part, ClausePart | SubjectPart):
                if part.word and part.word not in self.clauses:
                    self.missing(part)
                if not part.word and not self.object.text:
                    what = part.what or f"object of {self.verb}"
                    self.reject("TIS304", f"the {what} is missing")

    def _flag_for(self, clause: s.Clause) -> str:
        """Return the flag that a wrong clause means: "with caps" for "on caps", or nothing."""
        for flag in sorted(self._flags - self.clauses.keys()):
            if flag.partition(" ")[2] == clause.value.span.text.lower():
                return flag
        return ""

    def _nearest_form(self) -> str:
        """Return the form that shares most words with the sentence."""
        written = set(self.span.text.split())
        texts = self.texts or texts_of(self.verb, every=True)
        return max(texts, key=lambda form: len(written & set(form.split())))

    # --- parts --------------------------------------------------------------------------------

    def _part(self, name: str, part: Part) -> Any:
        """Return the value of a part; None if it is optional and not written."""
        match part:
            case LastingPart():
                self._lasts = True
                return self.duration
            case CasePart():
                return self.form.literal
            case FlagPart():
                return self._flag(part)
            case EitherClause():
                return self._either(part)
            case ClausePart(word=word) if word and not self.has(word):
                return None
            case NumberClause():
                return self._number(part)
            case AngleClause(word=word):
                return self.scope.angle(self.clauses[word].value, what="the angle")
            case VectorClause(word=word, dimension=dimension):
                return self._vector(word, dimension)
            case DirectionClause(word=word):
                return self._direction(word)
            case DirectedClause():
                return self._directed(part)
            case RangeClause():
                return self._range(part)
            case ChoiceClause():
                return self._choice(part)
            case _:
                return self.read_other(part, is_optional=name in self.form.optional)

    def missing(self, part: Part, *, word: str | None = None) -> NoReturn:
        """Reject a sentence without a part.

        Args:
            word: The clause to mark; the whole sentence if None.
        """
        examples = [part.example] if part.example else []
        match part:
            case ChoiceClause(word=joining, words=words):
                examples = [f"{joining} {one}" for one in words]
            case NumberClause(word=joining, words=words):
                examples += [f"{joining} {one}" for one in list(words)[:1]]
            case _:
                pass
        hint: str = ""
        if examples:
            edits = [insertion(f" {one}", self.span) for one in examples if "…" not in one]
            text = f"for example: {', or '.join(examples)}"
            if isinstance(part, ChoiceClause):
                text = f"{part.what}s: {', '.join(part.words)}"
            hint = Hint(text, *edits)
        what = f"the {part.what} is missing"
        if not part.what:
            what = f'{self.verb} needs "{getattr(part, "word", "")}"'
        self.reject("TIS304", what, hint=hint, word=word)

    def read_other(self, part: Part, *, is_optional: bool) -> Any:
        """Return the value of a part that not all sentences have.

        Args:
            is_optional: Whether it can be omitted.

        Raises:
            TypeError: Such a sentence does not have parts of this kind.
        """
        raise TypeError(f"{type(part).__name__} is not a part of this sentence")

    def _flag(self, part: FlagPart) -> bool:
        word = part.word
        if self.has(part.text):
            return True
        if self.form.of_word(word) is part and word in self.clauses:
            text = self.name_in(word).text
            hint = Hint(f"write: {part.text}", Edit(part.text))
            message = f'unexpected "{text}" after "{word}"'
            self.reject("TIS305", message, hint=hint, word=word)
        return False

    def _either(self, part: EitherClause) -> Amount:
        written = [one for one in part.clauses if self.has(one.word)]
        if len(written) == 1:
            return Amount(written[0].word, self._number(written[0]))
        either = " or ".join(f"a {one.what}" for one in part.clauses)
        message = f'"{self.verb} {self.form.literal}" needs either {either}'
        if written:
            places = [self.clauses[one.word].span for one in written]
            self.reject("TIS306", message, hint=one_left(*places))
        text = text_of(self.verb, self.form)
        first, *others = (f"{one.word} {one.placeholder}" for one in part.clauses)
        texts = [text, *(text.replace(first, other) for other in others)]
        self.reject("TIS304", message, hint=f"write: {', or: '.join(texts)}")

    def _choice(self, part: ChoiceClause) -> str:
        value = self.clauses[part.word].value
        if not isinstance(value, s.Name) or value.key not in part.words:
            text = self.name_in(part.word).text
            hint = alternatives(text, part.words, what=f"{part.what}s")
            message = f'unknown {part.what} "{text}"'
            if part.word == "is":
                message = f'{self.verb} cannot be "{text}"'
            self.reject("TIS305", message, hint=hint, word=part.word)
        return value.key

    def _directed(self, part: DirectedClause) -> Floats:
        has_direction = self.has(part.along)
        if self._value(part.word).is_vector:
            if has_direction:
                self.reject(
                    "TIS306",
                    f"the {part.what} already has a direction",
                    hint=f'write an amount such as 0.1 N before "{part.along}", or remove '
                    f'"{part.along}"',
                    word=part.along,
                )
            return self._vector(part.word, part.dimension)
        amount = self.number(part.word, part.dimension)
        if not has_direction:
            self.reject(
                "TIS304",
                f"the direction of the {part.what} is missing",
                hint=Hint(
                    f"write a vector such as (0, 0, -0.1) N, or add: {part.direction}",
                    insertion(f" {part.direction}", self.span),
                ),
                word=part.word,
            )
        return amount * self._direction(part.along)

    def _range(self, part: RangeClause) -> tuple[float, float]:
        low, hint = self.number(part.word, part.dimension), f"for example: {part.example}"
        if not self.has("to"):
            message = f"the upper limit of the {part.what} is missing"
            self.reject("TIS304", message, hint=hint, word=part.word)
        high = self.number("to", part.dimension)
        if not 0.0 <= low < high:
            message = (
                f"limits of the {part.what} must grow from 0, not from {low:g} to {high:g}"
            )
            self.reject("TIS308", message, hint=hint, word=part.word)
        return low, high

    def _vector(self, word: str, dimension: Dimension) -> Floats:
        value = self._value(word)
        if not value.is_vector:
            text = self.clauses[word].value.span.text
            fits = value.dimension == dimension or value.is_literal
            part = text if fits else f"1 {suggested_unit(dimension)}".rstrip()
            hint = f"its three components, for example: {word} (0, 0, {part})"
            self.reject("TIS312", f'"{word}" needs a vector (x, y, z)', word=word, hint=hint)
        if np.any(value.amount) or not value.is_literal:
            self._expect(value, word, dimension)
        return value.amount

    def number(self, word: str, dimension: Dimension) -> float:
        """Return the number of a clause in SI units."""
        value = self._value(word)
        if value.is_vector:
            self.reject("TIS312", f'"{word}" needs a number, not a vector', word=word)
        self._expect(value, word, dimension)
        return float(value.amount)

    def _expect(self, value: Value, word: str, dimension: Dimension) -> None:
        place = self.clauses[word].value.span
        other = self.form.kind.instead.get(value.dimension)
        if other is not None and value.dimension != dimension:
            given, wanted = describe(value.dimension), describe(dimension)
            self.reject(
                "TIS502",
                f'"{self.verb}" takes {wanted}, but {place.text} is {given}',
                hint=f"write: {other.format(f'{self.words} {word} {place.text}')}",
                word=word,
            )
        self.scope.expect(value, dimension, place, what=self.called(word))

    def called(self, word: str) -> str:
        """Return the name of the value after a joining word, for messages."""
        return f"the value after {word}"

    def _number(self, part: NumberClause) -> float:
        word, what = part.word, part.what
        if isinstance(part.dimension, Mapping):
            what = self.form.literal or what
        node = self.clauses[word].value
        if part.words and isinstance(node, s.Name):
            if node.key in part.words:
                return part.words[node.key]
            if not self.scope.has(node):
                self.scope.findings.reject(
                    "TIS305", f'there is no {what} called "{node.text}"', node.span,
                    hint=Hint(f"words: {', '.join(part.words)}", *map(Edit, part.words)),
                )  # fmt: skip
        number = self.number(word, self.dimension_of(word))
        least = "above 0" if part.sign == "positive" else "0 or more"
        if part.sign == "any" or number > 0.0 or (number == 0.0 and least == "0 or more"):
            return number
        hint: str = ""
        match node:
            case s.Signed(operand=s.Number() | s.Quantity() as plain) if number < 0.0:
                hint = proposal(plain.span.text)
            case _ if part.example:
                edit = Edit(part.example, self.clauses[word].span)
                hint = Hint(f"for example: {part.example}", edit)
            case _:
                pass
        message = f"the {what} must be {least}, not {node.span.one_line}"
        hint = hint or f"{self.lead}: {self._nearest_form()}"
        self.scope.findings.reject("TIS308", message, node.span, hint=hint)

    def _direction(self, word: str) -> Floats:
        value, example = self._value(word), f"{word} (0, 0, 1)"
        hint = Hint(f"for example: {example}", Edit(example))
        if not value.is_vector or value.dimension != NUMBER:
            message = f'"{word}" needs a direction without a unit'
            self.reject("TIS312", message, word=word, hint=hint)
        direction = unit_vector(value.amount)
        if direction is None:
            self.reject("TIS308", "a direction cannot be (0, 0, 0)", word=word, hint=hint)
        return direction

    def dimension_of(self, word: str) -> Dimension:
        """Return the dimension of the numbers after a joining word."""
        return self.form.dimension_of(word)

    # --- values -------------------------------------------------------------------------------

    def name_in(self, word: str) -> s.Name:
        """Return the name in a clause that is written."""
        return self.one(self.names_in(word), word)

    def names_in(self, word: str) -> s.Name:
        """Return the name in a clause that is written, or several as that of their union."""
        self.asked.add(word)
        return self._name_of(self.clauses[word])

    def _name_of(self, clause: s.Clause) -> s.Name:
        name = s.as_name(clause.value)
        if name is None:
            self.reject("TIS312", f'"{clause.word}" needs a name', word=clause.word)
        return name

    def one(self, name: s.Name, after: str) -> s.Name:
        """Return a name, which is none of a union.

        Args:
            after: The word before it.
        """
        if name.listed:
            place = f" after {after}" if after != self.verb else ""
            message = f"{self.verb} takes one name{place}"
            hint = self._one_each(name)
            self.scope.findings.reject("TIS312", message, name.span, hint=hint)
        return name

    def _one_each(self, listed: s.Name) -> Hint:
        """Return the hint to write a sentence for each of some names."""
        text, place = self.span.text, listed.span
        start, end = place.start - self.span.start, place.end - self.span.start
        each = [f"{text[:start]}{name.span.text}{text[end:]}" for name in listed.listed]
        is_alone = self.span.source.text[: self.span.start].rstrip().endswith(":")
        written = "; ".join(each)
        edit = Edit(f"{{ {written} }}" if is_alone else written, self.span)
        return Hint(f"write: {written}", edit)

    def _value(self, word: str) -> Value:
        return self.scope.evaluate(self.clauses[word].value)


def read_sentence(
    sentence: s.Sentence, first: str, kind: type[T], scope: Scope, text: str
) -> T:
    """Return the content of a sentence that is not about a network.

    Args:
        sentence: The syntax node.
        first: Its first words.
        kind: The class of its content.
        scope: Names and findings of the scene.
        text: Its form, for messages.
    """
    reader = ClauseReader(sentence, first, (form_of(kind),), scope, texts=(text,))
    said = reader.read()
    reader.finish()
    return cast(T, said)


def clauses_of(sentence: Written) -> Iterator[s.Clause]:
    """Yield the clauses of a sentence, also what follows ``is``, ``=`` and ``between``."""
    if isinstance(sentence, s.Function):
        yield from sentence.arguments
    if isinstance(sentence, s.Rule):
        span = sentence.conclusions[0].span.to(sentence.conclusions[-1].span)
        yield s.Clause("then", s.Name(span.one_line, None, span), span)
    if isinstance(sentence, s.Sentence | s.Block) and (phrase := sentence.phrase) is not None:
        place = phrase.span
        start = place.source.text.rfind("is", sentence.name.span.end, place.start)
        is_word = phrase.kind == "word"
        word = phrase.words[0] if is_word else s.Name(place.one_line, None, place)
        yield s.Clause("is", word, replace(place, start=start))
    if isinstance(sentence, s.Assign | s.Function):
        yield s.Clause("=", sentence.value, sentence.value.span)
    if isinstance(sentence, s.Assign) and (ends := sentence.bounds) is not None:
        yield s.Clause("between", s.Listing((ends.low, ends.high), ends.span), ends.span)
    yield from sentence.clauses


def _head_of(sentence: Written) -> Span:
    """Return the place of a sentence, without a block or rows after it."""
    if isinstance(sentence, s.Table):
        parts = (sentence.name, *sentence.clauses)
        return parts[0].span.to(parts[-1].span)
    return sentence.head if isinstance(sentence, s.Block) else sentence.span


def _object_of(sentence: Written, first: str) -> s.Name:
    """Return the object of a sentence: the name or condition after its first words."""
    if isinstance(sentence, s.Expect | s.Rule):
        span = sentence.condition.span
        return s.Name(span.one_line, None, span)
    if isinstance(sentence, s.Table) or (isinstance(sentence, s.Assign) and sentence.keyword):
        return sentence.name
    return behind(sentence.name, first)


def behind(name: s.Name, prefix: str) -> s.Name:
    """Return the name without its leading words; the prefix is known to be there."""
    count = len(prefix.split())
    rest = " ".join(name.words.split(" ")[count:])
    if not rest and name.quoted is None and not name.listed:
        return s.Name("", None, name.span)
    marker = rest or ("[" if name.quoted is None else f'"{name.quoted}"')
    start = name.span.text.find(marker, len(prefix))
    span = replace(name.span, start=name.span.start + max(start, 0))
    return s.Name(rest, name.quoted, span, name.listed)
