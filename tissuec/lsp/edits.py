"""Changes of a text by an editor, and a text in canonical layout."""

from collections.abc import Iterable
from typing import NamedTuple

from tissuec.core.errors import CompileError
from tissuec.lang.characters import normalise
from tissuec.lang.printer import format_source
from tissuec.lsp.positions import LINE_END, UNITS, ProtocolPosition
from tissuec.scene.reading.spellings import respelled


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
