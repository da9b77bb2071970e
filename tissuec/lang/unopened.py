"""Blocks on one line whose opening brace is missing: ``tissue gel density = 1 g/cm^3 }``."""

import re
from collections.abc import Callable, Mapping, Sequence

from tissuec.lang.tokens import Token

#: Each returns words that begin blocks, and whether a name follows them.
_VOCABULARIES: list[Callable[[], Mapping[str, bool]]] = []


def add_vocabulary(blocks: Callable[[], Mapping[str, bool]]) -> None:
    """Add what returns words that begin blocks, and whether a name follows them."""
    _VOCABULARIES.append(blocks)


def begins_block(word: str, *, alone: bool = False) -> bool:
    """Return whether a block begins with a word.

    Args:
        alone: Whether to return blocks without a name.
    """
    found = [blocks()[word.lower()] for blocks in _VOCABULARIES if word.lower() in blocks()]
    return not all(found) if alone else bool(found)


def head_of(parts: Sequence[Token], text: str) -> int | None:
    """Return where the head of a block ends, if a statement is one with its first entry.

    Names have as many words as are used together elsewhere in the text, and one at least.

    Args:
        parts: Tokens of the statement.
        text: The whole text.

    Returns:
        The offset after the name of the block; None if the statement is something else.
    """
    kinds = [part.type for part in parts]
    sign = next((at for at, kind in enumerate(kinds) if kind in ("EQUAL", "IS")), 0)
    if not sign or not begins_block(parts[0].text):
        return None
    if begins_block(parts[0].text, alone=True):
        return parts[0].stop
    start = kinds.index("LIKE") + 1 if "LIKE" in kinds[:sign] else 1
    words = list(parts[start:sign])
    if len(words) < 2 or any(word.type not in ("WORD", "STRING") for word in words):
        return None
    for count in range(len(words) - 1, 1, -1):
        name = r"\s+".join(re.escape(word.text) for word in words[:count])
        if len(re.findall(rf"(?<!\w){name}(?!\w)", text)) > 1:
            return words[count - 1].stop
    return words[0].stop
