"""What stands behind the joining words of sentences: ``of``, ``with``, ``along``."""

from collections.abc import Iterator

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import NODES, SPRINGS, Expected, number
from tissuec.lsp.forms import CHANGED, DIMENSIONS, forms_of, kinds_for
from tissuec.lsp.measured import kinds_measured, measured
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import CHOICE, Term, plain


def of_clause(prefix: Prefix) -> Expected:
    """Return what stands behind a joining word outside of orders."""
    word, subject = prefix.clause, prefix.subject
    match prefix.block.kind:
        case "":
            return _of_part(prefix)
        case "script" if prefix.head == "when":
            return measured()
        case "tissue" | "law" if word == "in":
            return Expected(names=("rules",))
        case "tissue" if word == "by":
            return Expected((v.SOURCE_TERMS,))
        case "body" if subject == "interface":
            return Expected(names=("region",))
        case "joint" | "force":
            return Expected(names=NODES)
        case "learn":
            return _of_learning(prefix)
        case "output" if subject == "surface":
            return Expected(names=("body",))
        case "output" if word in ("of", "to"):
            return Expected(names=kinds_measured(subject))
        case "quantity" if word == "to" and subject == "applies":
            return Expected((v.SPREADS,))
        case "mesh" if word == "in":
            return Expected(unit=True, dimension=units.LENGTH)
        case _:
            return number()


def _of_learning(prefix: Prefix) -> Expected:
    match prefix.subject, prefix.clause:
        case _, "using":
            return Expected((v.COLUMN,))
        case _, "with":
            return Expected((v.FREE_ZERO,))
        case _, "in":
            return Expected(unit=True, dimension=prefix.dimension)
        case _, "per":
            return Expected((v.DIVISIONS,))
        case "revise rules", "of":
            return Expected(names=("rules",))
        case "adjust", "of" if prefix.object == "words":
            return Expected(names=("quantity", "property"))
        case "adjust", "of":
            return Expected(names=("tissue", *SPRINGS, "region"))
        case _, "of":
            return Expected(names=("set", "body"))
        case _:
            return number()


def _of_part(prefix: Prefix) -> Expected:
    match prefix.head, prefix.clause:
        case "tissue", "like":
            return Expected(names=("tissue",))
        case (("property" | "quantity"), "on"):
            return Expected((v.LOG_SCALE,))
        case "set", "of":
            return Expected(names=("body",) if "nodes" in prefix.texts else ("body", "joint"))
        case "table", "of":
            return Expected(names=("body",))
        case "table", "in":
            return Expected(unit=True, dimension=units.LENGTH)
        case "table", "with":
            return Expected((v.COLUMNS,))
        case "expect", "over":
            return Expected((v.RUN,))
        case _:
            return number()


# --- orders -----------------------------------------------------------------------------------


def of_order(prefix: Prefix) -> Expected:
    """Return what a clause of an order holds, from the forms of its verb."""
    word, last = prefix.clause, prefix.last
    if word == "in":
        return Expected(unit=True, dimension=units.LENGTH)
    is_first = last is not None and last.text == word
    known: dict[str, Term] = {}
    names: list[str] = []
    for first, *more in _contents(prefix):
        if first in ("PROFILE", "COURSE"):
            known |= v.profiles()
        elif found := kinds_for(prefix.head, prefix.object, first):
            names += found
        elif first.isupper():
            is_first = False
        else:
            literal = " ".join(part for part in (first, *more) if part.islower())
            known |= plain(CHOICE, [literal])
    known |= v.kinds_of_clause(prefix.head, word)
    if is_first:
        return Expected((known,), tuple(dict.fromkeys(names)))
    found = number(known)
    return found._replace(names=(*names, *found.names))


def dimension_of_clause(prefix: Prefix) -> Dimension | None:
    """Return the dimension of numbers in a clause of an order."""
    word, verb = prefix.clause, prefix.head
    if verb == "change":
        return units.NUMBER if word == "by" else CHANGED.get(prefix.object)
    if verb == "move" and word == "by":
        return units.LENGTH
    found = (DIMENSIONS.get(content[0]) for content in _contents(prefix))
    return next((dimension for dimension in found if dimension is not None), None)


def _contents(prefix: Prefix) -> Iterator[tuple[str, ...]]:
    """Yield what can stand in a clause of an order, from the forms of its verb."""
    for form in forms_of("script", prefix.head):
        for clause, content in form.clauses:
            if clause == prefix.clause and (form.literal or prefix.object) == prefix.object:
                yield content
