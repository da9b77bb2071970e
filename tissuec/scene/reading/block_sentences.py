"""Blocks of sentences, such as ``learn`` and ``study``: kinds of sentences and settings."""

from collections.abc import Iterable

from msgspec import Struct

from tissuec.core.hints import alternatives, did_you_mean
from tissuec.lang import syntax as s
from tissuec.scene.reading.findings import Findings


class Sentences(Struct, frozen=True):
    """One kind of sentence of a block.

    Attributes:
        forms: How it is written; capital words are placeholders for names.
        about: What it says.
        is_needed: Whether there must be one.
        is_single: Whether there can only be one.
    """

    forms: tuple[str, ...]
    about: str
    is_needed: bool = False
    is_single: bool = False


def entry_of(name: s.Name, known: Iterable[str], findings: Findings, *, what: str) -> str:
    """Return which entry of a block a sentence begins with, or reject it.

    Args:
        known: Kinds of sentences and settings of the block.
    """
    known, words = tuple(known), s.key_of(name.words)
    for entry in known:
        if words == entry or words.startswith(f"{entry} "):
            return entry
    key = words if did_you_mean(words, known) else words.partition(" ")[0]
    findings.reject(
        "TIS303",
        f'"{name.text}" is not an entry of {what}',
        name.span,
        hint=alternatives(key, known, what="entries"),
    )
