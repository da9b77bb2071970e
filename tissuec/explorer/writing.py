"""Names and places as a page has them."""

import re
from pathlib import Path

from tissuec.core.source import Span
from tissuec.lang.words import RESERVED

_WORD = re.compile(r"[^\W\d]\w*(?:'[^\W\d]\w*)?")


def written_name(name: str) -> str:
    """Return a name as it stands in a text: in quotes if it is more than plain words."""
    parts = name.split(" ")
    plain = all(_WORD.fullmatch(part) and part.lower() not in RESERVED for part in parts)
    return name if plain else f'"{name}"'


def short_place(span: Span) -> str:
    """Return file and line without folders, which tell nothing to whom a page is sent."""
    return f"{Path(span.source.name).name}:{span.line}"
