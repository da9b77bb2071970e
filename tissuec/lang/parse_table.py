"""The table of the parser, which is shipped so that Lark need not build it from the grammar.

``python -m tissuec.lang.parse_table`` writes it anew. It holds for the version of Lark that has
built it; with another one, the table is built by the user's own and kept in the cache.
"""

import pickle
import zlib
from hashlib import sha256
from io import BytesIO
from typing import Any

import lark
from lark import Lark

from tissuec.core.resources import PACKAGE

PATH = PACKAGE / "lang" / "parse_table.z"


def digest(text: str, options: dict[str, Any], version: str = lark.__version__) -> str:
    """Return what tells a table from others.

    Args:
        text: The grammar.
        options: Of Lark.
        version: Of Lark.
    """
    return sha256(f"{text}{options}{version}".encode()).hexdigest()[:16]


def read() -> dict[str, Any]:
    """Return the shipped table: ``data`` and ``memo`` of Lark, its ``version``, ``digest``."""
    found: dict[str, Any] = pickle.loads(zlib.decompress(PATH.read_bytes()))
    return found


class ShippedParser(Lark):
    """The parser of a table.

    Args:
        table: As ``read`` returns it.
        builder: Has a method for each rule, called as soon as the rule is complete.
    """

    def __init__(self, table: dict[str, Any], builder: object):
        self._load(table, transformer=builder)  # pyright: ignore[reportUnknownMemberType]  # untyped


def write(text: str, options: dict[str, Any]) -> None:
    """Build the table, and store it.

    Args:
        text: The grammar.
        options: Of Lark.
    """
    stored = BytesIO()
    built: Any = Lark(text, **options)
    built.save(stored)
    table = pickle.loads(stored.getvalue())
    table |= {"version": lark.__version__, "digest": digest(text, options)}
    PATH.write_bytes(zlib.compress(pickle.dumps(table), 9))


if __name__ == "__main__":
    from tissuec.lang.grammar import OPTIONS, grammar_text

    write(grammar_text(), OPTIONS)
