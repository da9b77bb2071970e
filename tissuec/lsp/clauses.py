"""What may follow the joining words of sentences: ``of``, ``with``, ``along``."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import takewhile

from tissuec.core import units
from tissuec.core.units import Dimension, parse_unit
from tissuec.lsp import vocabulary as v
from tissuec.lsp.expected import NODES, SPRINGS, Expected, number
from tissuec.lsp.forms import forms_of
from tissuec.lsp.measured import kinds_measured, measured
from tissuec.lsp.prefix import Prefix
from tissuec.lsp.terms import CHOICE, plain

#: Meanings of the capital words of forms outside of orders.
_STANDS_FOR = {
    "TISSUE": Expected(names=("tissue",)),
    "FORCE": Expected(names=("force",)),
    "RULES": Expected(names=("rules",)),
    "QUANTITY": Expected(names=("quantity", "property")),
    "REGION": Expected(names=("region",)),
    "BODY": Expected(names=("body",)),
    "UNIT": Expected(unit=True, dimension=units.LENGTH),
    "SET": Expected(names=NODES),
    "MODE": Expected((v.MODE_TERMS,)),
    "SOURCE": Expected((v.SOURCE_TERMS,)),
    "SPREAD": Expected((v.SPREADS,)),
    "TIME": number()._replace(dimension=units.TIME),
    "LENGTH": number()._replace(dimension=units.LENGTH),
    "NUMBER": number(),
    "LIST": number(),
}
#: Words of forms that are described.
_DESCRIBED = {
    "free zero": v.FREE_ZERO, "log scale": v.LOG_SCALE, "run": v.RUN, "column": v.COLUMN,
    "columns": v.COLUMNS, **dict.fromkeys(v.DIVISIONS, v.DIVISIONS),
}  # fmt: skip


def in_clause(prefix: Prefix) -> Expected:
    """Return what may follow a joining word, directly or later in its clause."""
    if prefix.block.kind == "script" and not prefix.has_verb:
        return measured() if prefix.head == "when" else _STANDS_FOR["TIME"]
    if prefix.clause == "in" and prefix.block.kind in ("learn", "mesh", "script"):
        of_table = prefix.block.kind != "learn"
        return Expected(unit=True, dimension=units.LENGTH if of_table else prefix.dimension)
    found = [_meaning(prefix, content) for content in _contents(prefix)]
    terms = {key: term for one in found for known in one.terms for key, term in known.items()}
    names = dict.fromkeys(name for one in found for name in one.names)
    expected = Expected((terms,), tuple(names), unit=any(one.unit for one in found))
    dimensions = (one.dimension for one in found if one.dimension is not None)
    expected = expected._replace(dimension=next(dimensions, None))
    last = prefix.last
    is_first = last is not None and last.text == prefix.clause
    if (prefix.has_verb and not is_first) or not (names or terms or expected.unit):
        several = number(terms)
        every = tuple(dict.fromkeys((*names, *several.names)))
        return several._replace(names=every, dimension=expected.dimension)
    return expected


def _contents(prefix: Prefix) -> Iterator[tuple[str, ...] | Expected]:
    """Yield the contents that the forms of a sentence allow in a clause."""
    kind = prefix.block.kind
    for form in forms_of(kind, prefix.head if kind in ("", "script") else prefix.subject):
        if form.fits(prefix.object, of_order=prefix.has_verb):
            yield from (content for word, content in form.clauses if word == prefix.clause)


def _meaning(prefix: Prefix, content: Sequence[str] | Expected) -> Expected:
    """Return the expectation for a part of a form within its sentence."""
    if isinstance(content, Expected):
        return content
    first = content[0] if content else ""
    if first == "FIELD":
        return Expected((v.frame_fields(),))
    if first == "MEASURED":
        return Expected(names=kinds_measured(prefix.subject))
    if first == "DRAWN":
        return Expected(names=("body",) if "nodes" in prefix.texts else ("body", "joint"))
    if first == "SET" and prefix.block.kind == "learn":
        is_adjusted = prefix.subject == "adjust"
        return Expected(names=(*SPRINGS, "region") if is_adjusted else ("set", "body"))
    return stands_for(content)


def stands_for(content: Sequence[str]) -> Expected:
    """Return the expectation for a part of a form, the same in every sentence."""
    first, *more = (*content, "")
    if first.isupper():
        return _STANDS_FOR.get(first, Expected())
    if not first[:1].isalpha():
        return number()._replace(dimension=_time_of(more))
    literal = " ".join(takewhile(str.isalpha, content))
    return Expected((_DESCRIBED.get(literal) or plain(CHOICE, [literal]),))


def _time_of(more: Sequence[str]) -> Dimension | None:
    """Return the dimension of time if the number in the form is a time, else None."""
    with suppress(ValueError, ArithmeticError):
        return units.TIME if parse_unit(more[0]).dimension == units.TIME else None
    return None
