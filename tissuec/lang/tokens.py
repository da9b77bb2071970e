"""The tokens of a text: one regular expression for compiler, formatter, messages and editor."""

import re
from collections.abc import Iterator
from functools import cache

from msgspec import Struct

from tissuec.core.units import unit_pattern
from tissuec.lang.words import RESERVED

#: How numbers, words and signs are written.
NUMBER_PATTERN = r"[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?"
WORD_PATTERN = r"[^\W\d]\w*(?:'[^\W\d]\w*)?"
SIGN_PATTERN = r"[<>=!]=?|[-+*/^,;:(){}\[\]]"

_NUMBER = re.compile(NUMBER_PATTERN)
_SIGNS = {
    "=": "EQUAL", ",": "COMMA", ":": "COLON", ";": "SEMICOLON", "^": "CIRCUMFLEX",
    "+": "PLUS", "-": "MINUS", "*": "STAR", "/": "SLASH",
    "(": "LPAR", "[": "LSQB", "{": "LBRACE", "]": "RSQB", "}": "RBRACE",
}  # fmt: skip
_RESERVED = {word: word.upper() for word in RESERVED}
#: Kinds of tokens, for those who need not know which word or sign one is.
COMMENT, STRING, NUMBER, UNIT, WORD, KEYWORD, SIGN, LINE, ODD = (
    "comment", "string", "number", "unit", "word", "keyword", "sign", "line", "odd",
)  # fmt: skip
_KINDS = dict.fromkeys(_RESERVED.values(), KEYWORD) | {
    "COMMENT": COMMENT, "REMARK": COMMENT, "STRING": STRING, "OPEN_QUOTE": STRING,
    "NUMBER": NUMBER, "QUANTITY": NUMBER, "STEPS": NUMBER, "UNIT": UNIT, "WORD": WORD,
    "LINE": LINE, "CHARACTER": ODD, "ODD": ODD,
}  # fmt: skip
#: What tokens made of two pieces are made of.
_PIECES = {
    "QUANTITY": ("NUMBER", "UNIT"), "STEPS": ("NUMBER", "WORD"), "RPAR_UNIT": ("RPAR", "UNIT"),
}  # fmt: skip
#: A character that is allowed in quotes and comments only.
_ODD = "\x1a"


class Token(Struct, frozen=True, gc=False):
    """The smallest part of a text.

    Attributes:
        type: A terminal of the grammar, or one of COMMENT, LINE, SEMICOLON, ROWS (of a table),
            OPEN_QUOTE (a text whose quote is not closed), REMARK (a comment of another
            language), CHARACTER (one that begins no token).
        text: As it is written.
        start, stop: Offsets in the text.
    """

    type: str
    text: str
    start: int
    stop: int

    @property
    def is_name(self) -> bool:
        """Return whether it can be part of a name."""
        return self.kind in (WORD, STRING)

    @property
    def kind(self) -> str:
        """Return the kind of the token, such as "word" or "sign"."""
        return _KINDS.get(self.type, SIGN)

    @property
    def pieces(self) -> "tuple[Token, ...]":
        """Return a number or bracket and its unit as two tokens, any other one as it is."""
        if self.type not in _PIECES:
            return (self,)
        first, second = _PIECES[self.type]
        unit = self.text[1:] if first == "RPAR" else number_and_unit(self.text)[1]
        unit = unit.strip()
        number = self.text[: len(self.text) - len(unit)].rstrip()
        return (
            Token(first, number, self.start, self.start + len(number)),
            Token(second, unit, self.stop - len(unit), self.stop),
        )


def number_and_unit(text: str) -> tuple[str, str]:
    """Return the number and the unit of a quantity as they are written."""
    found = _NUMBER.match(text)
    end = found.end() if found else 0
    return text[:end], text[end:].strip()


@cache
def _pattern() -> re.Pattern[str]:
    number, unit = NUMBER_PATTERN, rf"[ \t]*(?:{unit_pattern()})"
    return re.compile(
        rf"[ \t]*+(?:(?P<WORD>{WORD_PATTERN})|(?P<LINE>\n[ \t\n]*)"
        rf"|(?P<QUANTITY>{number}{unit})|(?P<STEPS>{number}[ \t]+steps?(?!\w))"
        rf"|(?P<NUMBER>{number})"
        r'|(?P<STRING>"[^"\n]*")|(?P<OPEN_QUOTE>"[^"\n]*)|(?P<COMMENT>\#[^\n]*)'
        rf"|(?P<RPAR_UNIT>\){unit})|(?P<RPAR>\))|(?P<COMPARISON>[<>]=?|[!=]=)"
        r"|(?P<REMARK>//[^\n]*|/\*[\s\S]*?\*/)|(?P<SIGN>[-+*/^,;:={}(\[\]])"
        r"|(?P<CHARACTER>[^ \t])|\Z)"
    )


def tokens(
    text: str, start: int = 0, stop: int | None = None, scanned: str = ""
) -> Iterator[Token]:
    """Yield every token of a part of a text, right or wrong; blanks are left out.

    Args:
        start: First character of the part.
        stop: End of the part; None is the end of the text.
        scanned: The text without odd characters, where that is known.
    """
    scanned, before = scanned or without_odd_characters(text), ""
    for found in _pattern().finditer(scanned, start, len(text) if stop is None else stop):
        kind = found.lastgroup
        if kind is None:
            return
        first, last = found.span(kind)
        written = text[first:last]
        if kind == "WORD":
            kind = _RESERVED.get(written, "WORD")
            if kind == "WORD" and (lower := written.lower()) in _RESERVED:
                kind, written = _RESERVED[lower], lower  # as "Set", as mail programs write it
        elif kind == "SIGN":
            kind = _SIGNS[written]
        elif written == "%" and before == "IN":
            kind = "WORD"  # the unit of a column
        before = kind
        yield Token(kind, written, first, last)


def without_odd_characters(text: str) -> str:
    """Return a text of the same length without characters that belong to no word or sign."""
    if text.isascii():
        return text
    odd = (one for one in set(text) if not (one.isascii() or one.isalpha() or one == "·"))
    return text.translate({ord(one): _ODD for one in odd})
