"""Offsets in a text, lines and columns as an editor counts them, and changes by an editor.

The compiler reads texts without a byte order mark, with one kind of line end, and composed
(NFC). An editor counts in its own text, in units of UTF-16 unless both agree on another
encoding. Lines are the same in both, so that each line is mapped by itself.
"""

import re
import unicodedata
from bisect import bisect_right
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import NamedTuple

from tissuec.core.errors import CompileError
from tissuec.lang.characters import normalise
from tissuec.lang.printer import format_source
from tissuec.scene.reading.spellings import respelled

LINE_END = re.compile(r"\r\n|\r|\n")
_BOM = "\ufeff"

#: Units that a character takes, by the name of the encoding in the protocol.
UNITS: dict[str, Callable[[str], int]] = {
    "utf-8": lambda text: len(text.encode("utf-8", errors="replace")),
    "utf-16": lambda text: len(text) + sum(character > "\uffff" for character in text),
    "utf-32": len,
}


class ProtocolPosition(NamedTuple):
    """A place as the protocol has it, both counted from 0."""

    line: int
    character: int


class Positions:
    """The places of one text.

    Args:
        raw: The text as the editor has it.
        encoding: What characters are counted in.
    """

    def __init__(self, raw: str, encoding: str = "utf-16"):
        self.raw = raw
        self.width = UNITS[encoding]

    @cached_property
    def lines(self) -> list[str]:
        """Return the lines of the editor, without their ends."""
        return LINE_END.split(self.raw)

    @cached_property
    def _read(self) -> list[str]:
        """Return the lines of the compiler."""
        lines = list(self.lines)
        lines[0] = lines[0].removeprefix(_BOM)
        return [
            line if line.isascii() else unicodedata.normalize("NFC", line) for line in lines
        ]

    @cached_property
    def _starts(self) -> list[int]:
        starts = [0]
        for line in self._read:
            starts.append(starts[-1] + len(line) + 1)
        return starts

    def position(self, offset: int) -> ProtocolPosition:
        """Return where an offset of the compiler's text is shown."""
        line = max(min(bisect_right(self._starts, offset) - 1, len(self.lines) - 1), 0)
        column = min(max(offset - self._starts[line], 0), len(self._read[line]))
        if self.lines[line].isascii():  # nearly all are, and there is one unit for each letter
            return ProtocolPosition(line, column)
        return ProtocolPosition(line, self.width(self.lines[line][: self._shown(line, column)]))

    def offset(self, line: int, character: int) -> int:
        """Return the offset in the compiler's text of a place; one beyond a line is its end."""
        if line >= len(self.lines):
            return self._starts[-1] - 1
        shown, column, taken = self.lines[line], 0, 0
        while column < len(shown) and taken < character:
            taken += self.width(shown[column])
            column += 1
        return self._starts[line] + self._column(line, column)

    def _shown(self, line: int, column: int) -> int:
        """Return the column of the editor for one of the compiler."""
        shown, read = self.lines[line], self._read[line]
        if shown == read:
            return column
        cuts = range(len(shown), -1, -1)  # marks go with the letter that they are put on
        return next(cut for cut in cuts if self._length(shown[:cut]) <= column)

    def _column(self, line: int, shown: int) -> int:
        """Return the column of the compiler for one of the editor."""
        if self.lines[line] == self._read[line]:
            return shown
        return min(self._length(self.lines[line][:shown]), len(self._read[line]))

    def _length(self, part: str) -> int:
        return len(unicodedata.normalize("NFC", part.removeprefix(_BOM)))


class Replacement(NamedTuple):
    """A stretch of a text, from its beginning up to its end, and its replacement."""

    start: ProtocolPosition
    end: ProtocolPosition
    text: str


def replaced(text: str, changes: Iterable[Replacement], encoding: str) -> str:
    """Return a text after changes, each of which counts in the text before it.

    Args:
        text: As the editor has it.
        changes: In order.
        encoding: What characters are counted in.
    """
    for change in changes:
        start = _offset(text, change.start, encoding)
        end = max(_offset(text, change.end, encoding), start)
        text = text[:start] + change.text + text[end:]
    return text


def _offset(text: str, place: ProtocolPosition, encoding: str) -> int:
    """Return the offset of a place; one beyond a line, or the text, is its end."""
    start, ends = 0, LINE_END.finditer(text)
    for _ in range(place.line):
        end = next(ends, None)
        if end is None:
            return len(text)
        start = end.end()
    last = next(ends, None)
    stop = len(text) if last is None else last.start()
    if text.isascii():
        return min(start + place.character, stop)
    taken, width = 0, UNITS[encoding]
    while start < stop and taken < place.character:
        taken += width(text[start])
        start += 1
    return start


def formatted(raw: str) -> str | None:
    """Return a text as ``tissuec fmt`` lays it out; None if it is wrong."""
    try:
        new = format_source(respelled(normalise(raw, "text")))
    except CompileError:
        return None
    return new.replace("\n", "\r\n") if "\r\n" in raw else new
