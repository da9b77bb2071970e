"""Syntax nodes of a text with errors: unreadable parts are left out."""

import re
from collections.abc import Iterator
from typing import cast

from lark import UnexpectedInput
from lark.exceptions import LarkError
from lark.utils import TextSlice

from tissuec.core.errors import CompileError
from tissuec.core.source import Source, Span
from tissuec.lang import syntax as s
from tissuec.lang.grammar import parsed
from tissuec.lang.layout import Layout, lay_out
from tissuec.lang.parser import reading
from tissuec.lang.recovery import statement_at

_PART = re.compile(r'"[^"\n]*"|[\n;{}]')
_HEADING = re.compile(r"[\n; \t]*language[ \t]+[0-9.]*")

#: Statements of one part of a text that are left out before the part is given up.
MOST_LEFT_OUT = 20
#: Longer texts are not mended, for that would keep an author waiting.
LONGEST = 1_000_000


def mended(source: Source) -> s.Module:
    """Return the module of a text that is wrong; whatever cannot be read is left out."""
    return s.Module(s.Number(1.0, Span(source, 0, 0)), _items(source), source)


def _items(source: Source) -> tuple[s.Item, ...]:
    """Return the items that can be read."""
    try:
        layout = lay_out(source)
    except CompileError:
        return ()
    if len(source.text) > LONGEST:
        return ()
    return tuple(
        item for start, stop in _parts(layout.text) for item in _read(layout, start, stop)
    )


def _parts(text: str) -> Iterator[tuple[int, int]]:
    """Yield the stretches of a text that stand outside of all blocks, one by one."""
    heading = _HEADING.match(text)
    start = heading.end() if heading else 0
    depth = 0
    for part in _PART.finditer(text, start):
        if part[0] == "{":
            depth += 1
        elif part[0] == "}":
            depth -= 1
        elif part[0][0] != '"' and depth <= 0:
            if text[start : part.start()].strip("\n; \t"):
                yield start, part.start()
            start, depth = part.end(), 0
    if text[start:].strip("\n; \t"):
        yield start, len(text)


def _read(layout: Layout, start: int, stop: int) -> tuple[s.Item, ...]:
    """Return the items of a stretch, without its statements that are wrong."""
    text = layout.text
    for _ in range(MOST_LEFT_OUT):
        try:
            with reading(layout) as parser:
                module = parsed(parser, TextSlice(text, start, stop), "items")
            return cast(s.Module, module).items
        except UnexpectedInput as error:
            place = min(max(error.pos_in_stream or 0, start), stop - 1)
            text = _without_statement(text, start, stop, place)
        except LarkError:
            return ()
    return ()


def _without_statement(text: str, start: int, stop: int, place: int) -> str:
    """Return the text without the statement at a place; a block keeps its braces."""
    begin, end = statement_at(text, start, place)
    end = min(end, stop)
    if text[begin:end].strip():
        # The head of a block becomes a name, so that what is in the block can still be read.
        name = "_" if text.startswith("{", end) else " "
        return text[:begin] + name.ljust(end - begin) + text[end:]
    return text[:place] + " " + text[place + 1 :]
