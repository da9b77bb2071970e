"""Tokens in plain words, for messages."""

from collections.abc import Set

from tissuec.lang.mistake import ENDS
from tissuec.lang.words import JOINING_WORDS, RESERVED, TIME_WORDS

_LONGEST = 72

#: The name of a set of token types of which at least one is allowed somewhere.
_GROUPS: tuple[tuple[frozenset[str], str], ...] = (
    (frozenset({"WORD", "STRING"}), "a name"),
    (frozenset({"NUMBER", "QUANTITY", "STEPS"}), "a number"),
    (frozenset({"LPAR"}), '"("'),
    (frozenset({"LSQB"}), '"["'),
    (frozenset({"STAR", "SLASH", "CIRCUMFLEX"}), "an arithmetic sign"),
    (frozenset({"COMPARISON"}), 'a comparison such as "<"'),
    (frozenset(word.upper() for word in TIME_WORDS), 'a time word such as "at"'),
    (frozenset(word.upper() for word in JOINING_WORDS), 'a joining word such as "with"'),
)
_SIGNS = {
    "EQUAL": '"="',
    "COLON": '":"',
    "COMMA": '","',
    "RPAR": '")"',
    "RSQB": '"]"',
    "LBRACE": '"{"',
}
_WORDS = frozenset(word.upper() for word in RESERVED)


def shown(text: str) -> str:
    """Return text in quotes, cut where it is long; line ends and the end of a file by name."""
    if not text.strip(" \t\n;"):
        return '";"' if ";" in text else "the end"
    text = " ".join(text.split())
    return f'"{text}"' if len(text) <= _LONGEST else f'"{text[: _LONGEST - 1].rstrip()}…"'


def expected(accepted: Set[str]) -> str:
    """Return a hint about what is allowed somewhere: ``expected a name or "("``."""
    parts: list[str] = []
    # The word "table" before a file name is too rare to be offered beside every name.
    rest = set(accepted - {"TABLE"} if "WORD" in accepted else accepted)
    for group, name in _GROUPS:
        if rest & group:
            parts.append(name)
            rest -= group
    parts += [sign for kind, sign in _SIGNS.items() if kind in rest]
    parts += sorted(f'"{kind.lower()}"' for kind in rest & _WORDS)
    if rest & ENDS:
        parts.append("the end of the statement")
    if not parts:
        return ""
    return f"expected {' or '.join(filter(None, (', '.join(parts[:-1]), parts[-1])))}"
