"""A text in canonical layout."""

from tissuec.core.errors import CompileError
from tissuec.lang.characters import normalise
from tissuec.lang.printer import format_source
from tissuec.scene.reading.spellings import respelled


def formatted(raw: str) -> str | None:
    """Return a text as ``tissuec fmt`` lays it out; None if it is wrong."""
    try:
        new = format_source(respelled(normalise(raw, "text")))
    except CompileError:
        return None
    return new.replace("\n", "\r\n") if "\r\n" in raw else new
