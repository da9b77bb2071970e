"""The reserved words of the language: the one table that every other part of it reads.

A reserved word ends a name; a name that contains one is written in quotes.
"""

import re

_WORD = re.compile(r"[^\W\d]\w*(?:'[^\W\d]\w*)?")  # WORD of the grammar

#: Begin a time: ``at 0.1 s: …``, and clauses: ``every 1 ms``.
TIME_WORDS = ("at", "from", "to", "every", "until", "after")

#: Join a clause to what stands before it: ``with forceps A``.
JOINING_WORDS = (
    "by", "with", "along", "across", "through", "facing", "of", "on", "in", "as", "like", "per",
    "using", "over", "around", "weighing",
)  # fmt: skip

#: Hold conditions and rules together.
LOGIC_WORDS = ("if", "then", "and", "or", "not", "is", "where", "when", "within", "between")

#: Begin a sentence of their own.
DECLARING_WORDS = ("param", "let", "set", "expect", "table", "language")

RESERVED = frozenset(TIME_WORDS + JOINING_WORDS + LOGIC_WORDS + DECLARING_WORDS)

#: Stands behind a number like a unit: ``in 9 steps``.
STEPS = "steps"

#: A line that begins with one of these continues the line above. Time words are not among
#: them, because they begin sentences of a script.
CONTINUING = ("then", "and", "or", "is", "where", "within", "between", *JOINING_WORDS)

#: A statement can begin with one of these (or with a name).
STARTING = frozenset((*TIME_WORDS, *DECLARING_WORDS, "if", "when"))


def written_name(name: str) -> str:
    """Return a name as it is written: in quotes if it is more than plain words."""
    parts = name.split(" ")
    plain = all(_WORD.fullmatch(part) and part.lower() not in RESERVED for part in parts)
    return name if plain else f'"{name}"'
