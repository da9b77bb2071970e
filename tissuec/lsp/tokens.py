"""A text as lexemes, by the signs of the grammar, also in texts with errors."""

import re
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from tissuec.core.units import unit_pattern
from tissuec.lang.words import RESERVED

COMMENT, STRING, NUMBER, UNIT, WORD, KEYWORD, SIGN, LINE, ODD = (
    "comment", "string", "number", "unit", "word", "keyword", "sign", "line", "odd",
)  # fmt: skip

#: How numbers, words and signs are written; those of ``grammars/common.lark``.
NUMBER_PATTERN = r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
WORD_PATTERN = r"[^\W\d]\w*(?:'[^\W\d]\w*)?"
SIGN_PATTERN = r"[<>=!]=?|[-+*/^,;:(){}\[\]]"


class Lexeme(NamedTuple):
    """The smallest part of a text; ``start`` and ``stop`` are offsets in characters."""

    kind: str
    text: str
    start: int
    stop: int

    @property
    def is_name(self) -> bool:
        """Return whether it can be part of a name."""
        return self.kind in (WORD, STRING)


@cache
def _pattern() -> re.Pattern[str]:
    unit = rf"[ \t]*(?P<unit>{unit_pattern()})"
    return re.compile(
        rf"(?P<comment>\#[^\r\n]*)|(?P<string>\"[^\"\r\n]*\"?)"
        rf"|(?P<number>{NUMBER_PATTERN})(?:{unit})?"
        rf"|(?P<word>{WORD_PATTERN})|(?P<line>\r\n|\r|\n)"
        # A unit behind a bracket belongs to a vector.
        rf"|(?P<close>\))(?:{unit.replace('<unit>', '<of>')})?"
        rf"|(?P<sign>{SIGN_PATTERN})|(?P<odd>[^\s])"
    )


def lexemes(text: str) -> Iterator[Lexeme]:
    """Yield every lexeme of a text, in order; blanks are left out."""
    for found in _pattern().finditer(text):
        kind = found.lastgroup or ""
        if kind in ("unit", "number"):
            yield _part(found, "number", NUMBER)
            yield from _unit(found, "unit")
        elif kind in ("of", "close"):
            yield _part(found, "close", SIGN)
            yield from _unit(found, "of")
        elif kind == WORD and found[0] in RESERVED:
            yield _part(found, "word", KEYWORD)
        else:
            yield _part(found, kind, kind)


def _unit(found: re.Match[str], group: str) -> Iterator[Lexeme]:
    if found[group] is not None:
        yield _part(found, group, UNIT)


def _part(found: re.Match[str], group: str, kind: str) -> Lexeme:
    return Lexeme(kind, found[group], *found.span(group))
