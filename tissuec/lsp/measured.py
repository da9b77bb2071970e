"""The subjects of measures, and the contents of their brackets."""

from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import NODES, SPRINGS, Expected, number
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import Terms
from tissuec.script.measures import MEASURES

#: What a measure is taken of, by what it takes.
_TAKEN_OF = {
    "nodes": (*NODES, "holding"),
    "springs": SPRINGS,
    "any": (*SPRINGS, "holding"),
    "body": ("body",),
    "solid": (*NODES, "holding"),
    "body or solid": (*NODES, "holding"),
    "jaws": ("holding",),
}


def measured(*known: Terms) -> Expected:
    """Return the subject of a condition on the motion: a measure, a number, or other terms."""
    return number(v.measures(), *known)


def kinds_measured(measure: str) -> tuple[str, ...]:
    """Return kinds of names of what a measure is taken of."""
    return _TAKEN_OF[MEASURES[measure].takes] if measure in MEASURES else NODES


def argument(prefix: Prefix) -> Expected:
    """Return the expectation of an argument of a measure: its subject, place or time."""
    call, last = prefix.call, prefix.last
    assert last is not None
    if call == "error":
        return Expected((v.ERRORS_OF,))
    if call == "count" and last.text == "(":
        return Expected((v.COUNTED,))
    if last.text not in ("(", ",", "of"):
        return number()
    if last.text == "," and call in MEASURES and prefix.commas[-1] >= MEASURES[call].subjects:
        return number()
    return Expected(
        names=kinds_measured(
            prefix.last_words(len(prefix.tokens) - 1) if call == "count" else call
        )
    )
