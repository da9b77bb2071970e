"""The reserved words of the language: the one table that every other part of it reads.

A reserved word ends a name; a name that contains one is written in quotes.
"""

import re

_WORD = re.compile(r"[^\W\d]\w*(?:'[^\W\d]\w*)?")  # WORD of the grammar

#: Begin a time: ``at 0.1 s: …``, and clauses: ``every 1 ms``.
TIME_WORDS = {
    "at": "The time of an action or an expectation.",
    "from": "A start point or time, or the tool that releases.",
    "to": "An end point or time.",
    "every": "The time between repetitions or samples.",
    "until": "An end time, or the end of a plateau of a scale.",
    "after": "A time relative to the start of the surrounding block.",
}

#: Join a clause to the text before it: ``with forceps A``.
JOINING_WORDS = {
    "by": "A distance, a factor, an expected deviation, or a source.",
    "with": "A tool, a force, a knot or columns.",
    "along": "A direction or a path.",
    "across": "The normal of a plane.",
    "through": "A point on a plane or an axis, or a nozzle.",
    "facing": "The normal direction of a plane.",
    "of": "The object that something belongs to or is measured on.",
    "on": "on log scale, or on each node.",
    "in": "A unit, a vocabulary, or a list of ids.",
    "as": "Reserved for later versions; not allowed in names.",
    "like": "The tissue or body whose entries are inherited.",
    "per": "The spring length that a value is given for, or the parts with separate numbers.",
    "using": "The time profile of a motion or a force, or the column of a table.",
    "over": "Over the whole run: over run.",
    "around": "The axis of a turn, or the expected value of a number.",
    "weighing": "The weight of a rule (above 0, at most 1) or of a fit; a density.",
}

#: Hold conditions and rules together.
LOGIC_WORDS = {
    "if": "Begins a rule.",
    "then": "What a rule concludes.",
    "and": "Logical and; also joins limits and conclusions.",
    "or": "Logical or.",
    "not": "Logical not.",
    "is": "Chooses a word.",
    "where": "A condition on nodes or springs.",
    "when": "A condition that triggers an action once.",
    "within": "Within a distance from a point.",
    "between": "Between two limits, both included.",
}

#: Begin a sentence of their own.
DECLARING_WORDS = ("param", "let", "set", "expect", "table", "language")

RESERVED = frozenset((*TIME_WORDS, *JOINING_WORDS, *LOGIC_WORDS, *DECLARING_WORDS))
#: What reserved words mean; those that begin parts of a text are explained there.
MEANINGS = {
    **TIME_WORDS, **JOINING_WORDS, **LOGIC_WORDS,
    "language": "The version of the language, on the first line of every text.",
}  # fmt: skip

#: Follows a number like a unit: ``in 9 steps``.
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
