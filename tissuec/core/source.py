"""Sources and spans: a named text, and places in it that findings quote."""

import re
from bisect import bisect_right
from functools import cached_property
from pathlib import Path

from msgspec import Struct


class Source(Struct, frozen=True, eq=False, dict=True):
    """A whole text and what to call it.

    Attributes:
        name: What messages print, such as ``sterilisation.tis``.
        text: The text after normalisation (no byte order mark, NFC, line ends as ``\\n``).
        path: The file it came from; None for text given directly.
        is_composed: Whether a program composes it, so that its numbers are those of variables.
    """

    name: str
    text: str
    path: Path | None = None
    is_composed: bool = False

    @cached_property
    def line_starts(self) -> list[int]:
        """Return the offset at which each line begins."""
        starts = [0]
        find = self.text.find
        end = find("\n")
        while end >= 0:
            starts.append(end + 1)
            end = find("\n", end + 1)
        return starts

    def line_text(self, line: int) -> str:
        """Return line number ``line`` (from 1) without its line end."""
        start = self.line_starts[line - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]


class Span(Struct, frozen=True):
    """A stretch of a source, as character offsets; ``end`` is exclusive.

    Attributes:
        repetition: Of a statement that is repeated, the value of its index, such as "i = 3".
    """

    source: Source
    start: int
    end: int
    repetition: str = ""

    def __repr__(self) -> str:
        return f"Span({self.place}, {self.text!r})"

    @property
    def line(self) -> int:
        """Return the line of the first character, counted from 1."""
        return bisect_right(self.source.line_starts, self.start)

    @property
    def column(self) -> int:
        """Return the column of the first character, counted from 1."""
        return self.start - self.source.line_starts[self.line - 1] + 1

    @property
    def text(self) -> str:
        """Return the text that the span covers."""
        return self.source.text[self.start : self.end]

    @property
    def one_line(self) -> str:
        """Return the text that the span covers on one line, with single blanks."""
        return " ".join(self.text.split())

    @property
    def with_values(self) -> str:
        """Return the text on one line, with the value of each index of a repetition."""
        text = self.one_line
        for one in self.repetition.split(", ") if self.repetition else ():
            index, _, value = one.partition(" = ")
            found = rf"\{{\s*{re.escape(index)}\s*\}}|\b{re.escape(index)}\b"
            text = re.sub(found, lambda _, value=value: value, text, flags=re.IGNORECASE)
        return text

    @property
    def place(self) -> str:
        """Return ``name:line``, the short form for tables and run-time messages."""
        return f"{self.source.name}:{self.line}"

    def to(self, other: "Span") -> "Span":
        """Return the span from the start of this one to the end of ``other``."""
        return Span(self.source, self.start, max(self.end, other.end), self.repetition)
