"""The grammar of statements, and the parse table that Lark builds from it, which is shipped.

``python -m tissuec.lang.parse_table`` writes it anew. It holds for the version of Lark that has
built it; another one builds its own, which ``lang.grammar`` keeps in the cache.
"""

import pickle
import zlib
from hashlib import sha256
from io import BytesIO
from typing import Any

import lark
from lark import Lark

from tissuec.core.resources import PACKAGE, grammar
from tissuec.lang.words import JOINING_WORDS, TIME_WORDS

PATH = PACKAGE / "lang" / "parse_table.z"
_FILES = ("common.lark", "rules.lark", "tissue.lark")

#: Options for Lark, whose own lexer is not used.
OPTIONS: dict[str, Any] = {
    "parser": "lalr",
    "lexer": "basic",
    "start": ["statement", "heading"],
    "maybe_placeholders": True,
}


def grammar_text() -> str:
    """Return the whole grammar, with reserved words put in."""
    text = "\n".join(grammar(name).read_text(encoding="utf-8") for name in _FILES)
    for mark, words in (("@TIME@", TIME_WORDS), ("@JOIN@", JOINING_WORDS)):
        text = text.replace(mark, " | ".join(f'"{word}"' for word in words))
    return text


def digest(text: str, version: str = lark.__version__) -> str:
    """Return the digest of a table.

    Args:
        text: The grammar.
        version: Of Lark.
    """
    return sha256(f"{text}{OPTIONS}{version}".encode()).hexdigest()[:16]


def read() -> dict[str, Any]:
    """Return the shipped table: ``data`` and ``memo`` of Lark, its ``version``, ``digest``."""
    return unpacked(PATH.read_bytes())


def unpacked(packed: bytes) -> dict[str, Any]:
    """Return the table that ``packed`` made."""
    found: dict[str, Any] = pickle.loads(zlib.decompress(packed))
    return found


class StoredParser(Lark):
    """The parser of a table.

    Args:
        table: As ``read`` returns it.
        builder: Has a method for each rule, called as soon as the rule is complete.
    """

    def __init__(self, table: dict[str, Any], builder: object):
        self._load(table, transformer=builder)  # pyright: ignore[reportUnknownMemberType]  # untyped


def packed(text: str) -> bytes:
    """Return the table of a grammar, built by this version of Lark, as bytes."""
    stored = BytesIO()
    built: Any = Lark(text, **OPTIONS)
    built.save(stored)
    table = pickle.loads(stored.getvalue())
    table |= {"version": lark.__version__, "digest": digest(text)}
    return zlib.compress(pickle.dumps(table), 9)


def write() -> None:
    """Build the table, and store it."""
    PATH.write_bytes(packed(grammar_text()))


if __name__ == "__main__":
    write()
