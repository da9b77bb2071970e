"""What is allowed at a place: words of the language, kinds of names, numbers, units, files."""

from typing import NamedTuple

from tissuec.core.units import Dimension
from tissuec.lsp import vocabulary as v
from tissuec.lsp.terms import Terms

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
