"""Names as a text must have them, so that what a page copies can be compiled."""

import re

from tissuec.lang.words import RESERVED

_WORD = re.compile(r"[^\W\d]\w*")


def written_name(name: str) -> str:
    """Return a name as it stands in a text: in quotes if it is more than plain words."""
    parts = name.split(" ")
    plain = all(_WORD.fullmatch(part) and part.lower() not in RESERVED for part in parts)
    return name if plain else f'"{name}"'
