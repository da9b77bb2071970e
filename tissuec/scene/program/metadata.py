"""Statements of a file about itself: its subject, authors, licence and citation."""

from typing import Annotated

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import declare
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import TextClause


class TextWords(VerbSentence, frozen=True):
    """A text in quotes."""

    text: Annotated[str, TextClause("", what="text", place='"TEXT"')]


_KIND = SentenceKind((TextWords,))
#: Sentences of one text in quotes, outside of all blocks; only "author" may be repeated.
TEXTS = {
    "about": "Describes the file in one sentence.",
    "author": "Names an author of the file; one sentence for each author.",
    "laboratory": "Names the institution of the authors.",
    "licence": "States the licence of the file.",
    "cite": "States how work that uses the file should cite it.",
}
for _place, (_word, _about) in enumerate(TEXTS.items(), start=1):
    declare(_word, _about, _place, "text", sentences=(TextWords,))

#: Those that other words mean.
MEANT = {
    **dict.fromkeys(("title", "description", "abstract", "summary"), "about"),
    **dict.fromkeys(("authors", "creator", "contributor", "contributors"), "author"),
    **dict.fromkeys(
        ("institution", "institute", "affiliation", "hospital", "university", "lab"),
        "laboratory",
    ),
    **dict.fromkeys(("license", "copyright", "rights"), "licence"),
    **dict.fromkeys(("for", "foreach", "while", "loop", "each"), "repeat"),
    "bodies": "body",
    **dict.fromkeys(("material", "materials"), "tissue"),
    **dict.fromkeys(("citation", "reference", "doi", "publication", "paper"), "cite"),
}


class Metadata(Struct, frozen=True):
    """The texts of a file about itself, each empty if it has none."""

    about: str = ""
    author: tuple[str, ...] = ()
    laboratory: str = ""
    licence: str = ""
    cite: str = ""

    @property
    def written(self) -> dict[str, str]:
        """Return the texts that the file has by their words, authors in one."""
        texts = {word: getattr(self, word) for word in TEXTS} | {
            "author": "; ".join(self.author)
        }
        return {word: text for word, text in texts.items() if text}


def is_metadata(item: s.Sentence) -> bool:
    """Return whether a sentence is one of `TEXTS` with a text in quotes."""
    return item.name.words.lower() in TEXTS and item.name.quoted is not None


def read_text(item: s.Sentence, scope: Scope) -> str:
    """Return the text of a sentence that consists of a word and a text in quotes.

    Args:
        scope: Takes diagnostics.
    """
    said: TextWords = SentenceReader(item.name.words.lower(), _KIND, item, scope).get()
    return said.text


def with_text(
    known: Metadata, item: s.Sentence, places: dict[str, Span], findings: Findings
) -> Metadata:
    """Return the texts of a file with another one.

    Args:
        known: Those before.
        item: See ``is_metadata``.
        places: Where each word was written first; takes that of this one.
    """
    word = item.name.words.lower()
    text = read_text(item, Scope(findings))
    if not text:
        findings.reject("TIS312", f"{word} has an empty text", item.span)
    if word == "author":
        return replace(known, author=(*known.author, text))
    if word in places:
        notes = (Note("first here", places[word]),)
        findings.reject("TIS503", f"{word} is given twice", item.span, notes=notes)
    places[word] = item.span
    return replace(known, **{word: text})
