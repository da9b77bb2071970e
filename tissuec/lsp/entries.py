"""The entries of each block as terms, from their declarations."""

from collections.abc import Iterable
from functools import cache

from tissuec.compiler.measures.conditions import COUNT
from tissuec.core.markdown import described
from tissuec.lang.words import RESERVED
from tissuec.lsp.terms import CHOICE, ENTRY, IN_QUOTES, MEASURE, BlockKind, Term, Terms
from tissuec.lsp.vocabulary import logged, measures, parts
from tissuec.scene.reading.entries import (
    Entry,
    default_in_words,
    entries_of_members,
    kind_in_words,
    sentence,
)
from tissuec.scene.reading.parts import entries_in
from tissuec.script.measures import MEASURES


@cache
def entries(block: BlockKind) -> Terms:
    """Return the first words of statements of a block, or of parts, without own names."""
    if not block.kind:
        return parts()
    found = {name: _term(entry) for name, entry in entries_in(*block).items()}
    return {**_measured(), **found} if block.kind == "output" else found


def _term(entry: Entry) -> Term:
    facts, rest = kind_in_words(entry.kind), default_in_words(entry)
    if facts and rest and rest != "needed":
        facts = f"{facts}; without it {rest}"
    about = "\n\n".join(part for part in (sentence(entry.about), facts) if part)
    begins = entry.begins or _begins(entry.name, entry.forms)
    return Term(
        entry.name, ENTRY, about, entry.forms[0], begins, entry.dimension, _choices(entry)
    )


def _begins(name: str, forms: Iterable[str]) -> str:
    """Return the text after the name in all forms; a quote, if any form has one."""
    rest = [form.removeprefix(name).split()[:1] for form in forms]
    first = {word for words in rest for word in words}
    if not all(rest):
        return ""
    if any(word.startswith('"') for word in first):
        return IN_QUOTES
    (word, *more) = first
    return f" {word} " if not more and (word == "=" or word in RESERVED) else " "


def _choices(entry: Entry) -> Terms | None:
    """Return the words that can be chosen, with their meanings."""
    return {word: _choice(word, about, entry) for word, about in entry.words.items()} or None


def _choice(word: str, about: object, entry: Entry) -> Term:
    members = entry.members
    own = entries_of_members(members, word) if word in members else {}
    needs_block = any(one.is_required for one in own.values())
    return Term(
        f'"{word}"' if "-" in word else word,
        CHOICE,
        about if isinstance(about, str) else described(about),
        behind=" { " if needs_block else "",
    )


def _measured() -> Terms:
    """Return the measures that an output can log."""
    found = {
        name: Term(name, MEASURE, term.about, "", "(" if MEASURES[name].subjects else " every ")
        for name, term in logged().items()
    }
    return {**found, COUNT: measures()[COUNT]}
