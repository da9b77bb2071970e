"""What is allowed at a place: words, kinds of names, numbers, units, subjects of measures."""

from typing import NamedTuple

from tissuec.core.units import Dimension
from tissuec.lsp import vocabulary as v
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import Terms
from tissuec.script.measures import MEASURES
from tissuec.script.measures.cut_faces import CUT_FACES
from tissuec.script.measures.statistics import STATISTICS

#: Kinds of names that numbers, and that orders, are about.
NUMBERS = ("param", "let", "function")
SUBJECTS = ("set", "body", "joint", "tool")
#: Of those, what has nodes; by the sorts of sets and tools.
NODES = ("nodes", "body")
#: And what has springs.
SPRINGS = ("set", "body", "joint")
#: All of these names differ from one another, so that a name identifies its kind.
ONE_NAMESPACE = (*NUMBERS, *SUBJECTS, "force")


class Expected(NamedTuple):
    """Completions that are allowed at a place.

    Attributes:
        terms: Words of the language.
        names: Kinds of names that are declared.
        scale: The property or quantity whose words are allowed here.
        declares: Kind of the name that is new here.
        files: What kind of file is named here: "use", or the entry that names it.
        unit: Whether a unit is allowed here.
        dimension: Of the unit, where that is known.
        like: The param that has the same dimension, if there is one of this name.
    """

    terms: tuple[Terms, ...] = ()
    names: tuple[str, ...] = ()
    scale: str = ""
    declares: str = ""
    files: str = ""
    unit: bool = False
    dimension: Dimension | None = None
    like: str = ""


def number(*known: Terms) -> Expected:
    """Return the expectation of a number: a param, a function, or one of some terms."""
    return Expected((*known, v.functions()), NUMBERS)


#: What a measure is taken of, by what it takes.
_TAKEN_OF = {
    "nodes": (*NODES, "holding"),
    "springs": SPRINGS,
    "any": (*SPRINGS, "holding"),
    "body": ("body",),
    CUT_FACES: ("body",),
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
    if call == "[" and len(prefix.calls) > 1:  # a union
        return Expected(names=kinds_measured(prefix.calls[-2]))
    if call == "error":
        return Expected((v.ERRORS_OF,))
    if call == "count" and last.text == "(":
        return Expected((v.COUNTED,))
    if call in STATISTICS and last.text == "(":
        return Expected((v.fields(),))
    if last.text == "(" and call in MEASURES and MEASURES[call].takes == CUT_FACES:
        return Expected((v.FACES,))
    if last.text not in ("(", ",", "of"):
        return number()
    if call in STATISTICS and last.text == ",":
        return number()
    if last.text == "," and call in MEASURES and prefix.commas[-1] >= MEASURES[call].subjects:
        return number()
    return Expected(
        names=kinds_measured(
            prefix.last_words(len(prefix.tokens) - 1) if call == "count" else call
        )
    )
