"""The forms of sentences, taken apart: what each joining word of an order or entry holds."""

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

from tissuec.core.units import show
from tissuec.lang.words import RESERVED
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import Expected, number
from tissuec.lsp.terms import CHOICE, Term, Terms, by_label, plain
from tissuec.scene.reading.parts import PARTS, blocks, entries_in
from tissuec.scene.reading.parts import forms_of as part_forms
from tissuec.script import forms as script_forms
from tissuec.script.fit_problem import WEIGHTS, WORDS
from tissuec.script.forms import VerbForm
from tissuec.script.parts import (
    ChoiceClause,
    FlagPart,
    NumberClause,
    Part,
    ProfileClause,
    SubjectPart,
    ToolClause,
)
from tissuec.script.verbs import VERBS


class SentenceForm(NamedTuple):
    """One form of a sentence.

    Attributes:
        literal: Words after its first ones, such as "spring constant".
        names: Kinds of names that can follow them.
        clauses: Joining words, and what is expected or written after them in forms.
    """

    literal: str
    names: tuple[str, ...]
    clauses: tuple[tuple[str, tuple[str, ...] | Expected], ...]

    def fits(self, object_: str, *, of_order: bool) -> bool:
        """Return whether a sentence about something can be of this form.

        Args:
            object_: Words between its first ones and a name, such as "spring constant".
            of_order: Whether it is an order; entries are about more than their forms show.
        """
        if of_order:
            return (self.literal or object_) == object_
        return self.literal == object_ or not {self.literal, object_} & {WORDS, WEIGHTS}


@cache
def forms_of(block: str, entry: str) -> tuple[SentenceForm, ...]:
    """Return the forms of a part, entry or order, taken apart.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    if block == "script" and entry in VERBS:
        return tuple(map(_of_verb, script_forms.forms_of(entry)))
    return tuple(_form(text, entry) for text in texts_of(block, entry))


def texts_of(block: str, entry: str) -> tuple[str, ...]:
    """Return the forms of a part, entry or order as the reference has them.

    Args:
        block: Kind of the block that it stands in.
        entry: The part, entry or verb.
    """
    if block == "script" and entry in VERBS:
        return script_forms.texts_of(entry, every=True)
    if not block:
        return part_forms(entry) if entry in PARTS else ()
    found = entries_in(block).get(entry)
    if found is not None:
        return found.forms
    known = blocks().get(block)
    return known.free if known is not None else ()


def _form(text: str, entry: str) -> SentenceForm:
    groups: list[list[str]] = [[]]
    for word in text.removeprefix(entry).replace("(", "( ").split():
        if (word in RESERVED and word != "table") or word == "=":
            groups.append([])
        groups[-1].append(word)
    literal = " ".join(word for word in groups[0] if word.islower())
    return SentenceForm(
        literal, (), tuple((group[0], tuple(group[1:])) for group in groups[1:])
    )


def _of_verb(form: VerbForm) -> SentenceForm:
    """Return a form of a verb with what its declaration expects."""
    is_literal = form.cases is not None and not form.cases.word
    names = (name for part in form.subjects for name in _names(part))
    clauses = (
        (word, (part,) if isinstance(part, str) else _expected(form, word, part))
        for word, part in form.clauses
    )
    literal = form.literal if is_literal else ""
    return SentenceForm(literal, tuple(dict.fromkeys(names)), tuple(clauses))


def _names(part: SubjectPart | ToolClause) -> tuple[str, ...]:
    """Return the kinds of names that a part takes."""
    if isinstance(part, ToolClause):
        return (part.kind,)
    return tuple(name for place in part.places for name in place.names)


def _expected(form: VerbForm, word: str, part: Part) -> Expected:
    """Return the possible values after a joining word of a verb."""
    dimension = form.dimension_of(word)
    match part:
        case SubjectPart() | ToolClause():
            return Expected(names=_names(part))
        case ProfileClause():
            return Expected((v.profiles(),))
        case FlagPart(text=text):
            return Expected((plain(CHOICE, [text.removeprefix(f"{word} ")]),))
        case ChoiceClause(words=words):
            return Expected((_terms(words),))
        case NumberClause(words=words):
            terms = _terms({name: show(value, dimension) for name, value in words.items()})
            return (number(terms) if terms else number())._replace(dimension=dimension)
        case _:
            return number()._replace(dimension=dimension)


def _terms(described: Mapping[str, str]) -> Terms:
    return by_label(Term(word, CHOICE, about) for word, about in described.items())
