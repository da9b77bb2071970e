"""A word of the language as editors know it, and the kind of block in which it occurs."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeAlias

from msgspec import Struct

from tissuec.core.units import Dimension

PART, ENTRY, VERB, MEASURE, CHOICE, KEYWORD, VARIABLE = (
    "part", "entry", "verb", "measure", "word", "keyword", "variable",
)  # fmt: skip

#: What completion writes before a text in quotes.
IN_QUOTES = ' "'


class Term(Struct, frozen=True):
    """A word of the language, which may be several words of English.

    Attributes:
        kind: What it is coloured as.
        about: Markdown.
        form: How it is written, with what comes after it.
        behind: What completion writes after it.
        dimension: Of the number that it takes or gives, if any.
        choices: What is allowed after its ``is``.
    """

    label: str
    kind: str
    about: str = ""
    form: str = ""
    behind: str = ""
    dimension: Dimension | None = None
    choices: "Terms | None" = None


Terms: TypeAlias = Mapping[str, Term]


class BlockKind(NamedTuple):
    """The kind of a block: "mesh" and "tube", "script" and ""; empty outside of all."""

    kind: str = ""
    member: str = ""


def by_label(terms: Iterable[Term]) -> Terms:
    """Return terms by their lookup keys: "young's modulus"."""
    return {term.label.lower(): term for term in terms}


def plain(kind: str, labels: Iterable[str], about: str = "") -> Terms:
    """Return terms with the same description.

    Args:
        kind: Kind of the terms.
        labels: Their names.
        about: The description.
    """
    return by_label(Term(label, kind, about) for label in labels)
