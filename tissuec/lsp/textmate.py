"""Rules of TextMate grammars: patterns and their colours."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from tissuec.core.units import unit_pattern
from tissuec.lang.tokens import NUMBER_PATTERN, WORD_PATTERN
from tissuec.lang.words import RESERVED
from tissuec.lsp.terms import Term

Rule = dict[str, Any]

SCOPE = "source.tissuec"
#: What each kind of ``semantic_tokens`` is called in themes.
SCOPES = {
    "comment": "comment.line.number-sign.tissuec",
    "string": "string.quoted.double.tissuec",
    "number": "constant.numeric.tissuec",
    "unit": "keyword.other.unit.tissuec",
    "keyword": "keyword.control.tissuec",
    "part": "storage.type.tissuec",
    "entry": "entity.other.attribute-name.tissuec",
    "verb": "support.function.verb.tissuec",
    "measure": "support.function.measure.tissuec",
    "word": "constant.language.tissuec",
    "name": "variable.other.tissuec",
    "sign": "keyword.operator.tissuec",
}

START = r"(?:^|(?<=[;{}]))\s*"
#: A word that ends no name, and several of them.
RESERVED_WORD = "|".join(sorted(RESERVED, key=lambda word: (-len(word), word)))
_WORD = rf"(?!(?:{RESERVED_WORD})\b){WORD_PATTERN}"
RUN = rf"{_WORD}(?:\s+{_WORD})*"


def include(*names: str) -> list[Rule]:
    """Return the rules under some names in the repository of the grammar."""
    return [{"include": f"#{name}"} for name in names]


def captures(kinds: Mapping[int, str]) -> Rule:
    """Return the colours of the groups of a pattern, by their numbers."""
    return {str(number): {"name": SCOPES[kind]} for number, kind in kinds.items()}


def rule(match: str, kinds: Mapping[int, str]) -> Rule:
    """Return the rule of a pattern on one line.

    Args:
        match: The pattern.
        kinds: The kind of each of its groups.
    """
    return {"match": match, "captures": captures(kinds)}


def between(
    begin: str,
    kinds: Mapping[int, str],
    end: str,
    patterns: list[Rule],
    *,
    closes: bool = False,
) -> Rule:
    """Return the rule of the text between two patterns.

    Args:
        begin: The first pattern.
        kinds: The kind of each of its groups.
        end: The second pattern.
        patterns: The rules between them.
        closes: Whether the second pattern is a sign, and no mere place.
    """
    closing = {"endCaptures": captures({0: "sign"})} if closes else {}
    colours = captures(kinds)
    return {
        "begin": begin,
        "beginCaptures": colours,
        "end": end,
        **closing,
        "patterns": patterns,
    }


def braces(patterns: list[Rule]) -> Rule:
    """Return the rule of a block with rules for its contents."""
    return between(r"\{", {0: "sign"}, r"\}", patterns, closes=True)


def any_of(labels: Iterable[str]) -> str:
    """Return a pattern of any of some words, which may be several words each."""
    longest_first = sorted(labels, key=lambda label: (-len(label), label))
    words = "|".join(re.escape(label).replace(r"\ ", r"\s+") for label in longest_first)
    return rf"(?i:{words})(?!\w)"


def listed(found: Mapping[str, Term], before: str = r"\b") -> Rule:
    """Return the rule of words that follow something."""
    return rule(f"{before}({any_of(found)})", {1: "word"})


def called(found: Mapping[str, Term]) -> list[Rule]:
    """Return the rules of words before a bracket, and of words alone."""
    before = [term.label for term in found.values() if term.behind == "("]
    alone = [term.label for term in found.values() if term.behind != "("]
    rules = [rule(rf"\b({any_of(before)})(?=\s*\()", {1: "measure"})] if before else []
    return rules + ([rule(rf"\b({any_of(alone)})", {1: "measure"})] if alone else [])


def basics() -> list[Rule]:
    """Return comments, texts, numbers with units."""
    return [
        {"match": r"#.*$", "name": SCOPES["comment"]},
        {"match": r'"[^"\n]*"?', "name": SCOPES["string"]},
        rule(rf"({NUMBER_PATTERN})(?:[ \t]*({unit_pattern()}))?", {1: "number", 2: "unit"}),
        rule(rf"(\))[ \t]*({unit_pattern()})", {1: "sign", 2: "unit"}),
    ]
