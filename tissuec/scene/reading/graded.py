"""Quantities that depend on the place: ``Young's modulus = 5 kPa + 3 kPa * x / 10 mm``.

A body or a region grades a quantity of its tissue by a formula of x, y and z, the coordinates
of the body as drawn.
"""

from collections.abc import Collection, Iterable, Sequence
from typing import Annotated, NoReturn

from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import describe
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in, walk
from tissuec.scene.model import AssignedQuantity, Body, Graded, Tissue
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import Entries, by_name, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import QUANTITIES, SHARES, STIFFENING
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import Placeholder, ValueClause

COORDINATES = frozenset("xyz")
#: ``mass`` is that of the whole body; a law has one stiffening, and shares add up.
_EVEN = ("mass", STIFFENING, *SHARES)
#: What a body can grade, by key.
GRADABLE = {key: quantity for key, quantity in QUANTITIES.items() if key not in _EVEN}


class GradedWords(VerbSentence, frozen=True):
    """A quantity as a formula of the place."""

    formula: Annotated[
        s.Expression, ValueClause("=", places=(Placeholder("PLACE"),), place="FORMULA")
    ]


_GRADED = SentenceKind((GradedWords,))
#: The entries that do so.
GRADED_ENTRIES = by_name(
    *(
        written(
            one.name, f"The {one.name} of the tissue of this body, {describe(one.dimension)}, "
            "as a formula of x, y and z, the coordinates of the body as drawn.",
            GradedWords, dimension=one.dimension, begins=" = ",
        )
        for one in GRADABLE.values()
    )
)  # fmt: skip


def with_graded(entries: Entries) -> Entries:
    """Return the entries of a body or region, and those that grade its other quantities."""
    own = {
        key: replace(one, sentences=(*one.sentences, GradedWords))
        for key, one in entries.items()
        if key in GRADED_ENTRIES
    }
    return {**entries, **GRADED_ENTRIES, **own}


def is_graded(item: s.Item) -> bool:
    """Return whether an item gives a quantity of tissue as a formula of the place."""
    if not isinstance(item, s.Assign) or item.name.key not in QUANTITIES:
        return False
    return item.name.key != "mass" and depends_on_place(item.value)


def depends_on_place(node: s.Expression) -> bool:
    """Return whether an expression mentions a coordinate."""
    return any(name.key in COORDINATES for name in names_in(node))


def mentions_graded(declarations: Declarations) -> bool:
    """Return whether a body of a program gives a quantity as a formula of the place."""
    bodies = (declared.item for declared in declarations.of("body").values())
    return any(
        isinstance(part, s.Assign) and is_graded(part) for item in bodies for part in walk(item)
    )


def read_graded(item: s.Assign, others: Collection[Graded], scope: Scope) -> Graded:
    """Return a quantity that depends on the place, or reject it.

    Args:
        item: See ``is_graded``.
        others: What is read already of the same body or region.
        scope: Of the scene.
    """
    quantity, findings = QUANTITIES[item.name.key], scope.findings
    for other in others:
        if other.quantity is quantity:
            findings.refuse_second(f'"{quantity.name}"', item.span, other.span)
    if item.name.key in _EVEN:
        findings.reject(
            "TIS306",
            f"the {quantity.name} of a body is the same everywhere",
            item.span,
            hint="write it in tissues, and give regions of the body different ones",
        )
    said: GradedWords = SentenceReader(quantity.name, _GRADED, item, scope).get()
    return Graded(quantity, said.formula, item.span)


def refuse_even(
    item: s.Assign | s.Sentence | s.Block, owner: str, findings: Findings
) -> NoReturn:
    """Reject a quantity of tissue that does not depend on the place.

    Args:
        item: An entry with the name of a quantity in ``GRADABLE``.
        owner: The kind of its block: "body" or "region".
    """
    findings.reject(
        "TIS312",
        f"in a {owner}, the {GRADABLE[item.name.key].name} is a formula of x, y or z",
        item.span,
        hint="the same number everywhere belongs in its tissue: write "
        f"tissue NAME {{ {item.span.one_line} }}, and in the {owner} tissue is NAME",
    )


def require_of_tissue(
    graded: Sequence[Graded], tissue: Tissue | None, owner: str, where: Span, findings: Findings
) -> None:
    """Report quantities of a body or a region that its tissue does not have.

    Args:
        graded: Quantities that depend on the place.
        tissue: Of the body or the region; None without one.
        owner: The body or region in messages.
        where: Its head.
    """
    for one in graded:
        name = one.quantity.name
        if tissue is None:
            findings.add(
                "TIS304",
                f"{owner} needs a tissue, of which it can grade the {name}",
                where,
                hint="write tissue is …",
            )
        elif graded_of(tissue, one) is None:
            findings.add(
                "TIS304",
                f"{tissue.name} has no {name} that {owner} could grade",
                one.span,
                hint=f"write {name} = … in the tissue as well, as its usual value",
            )


def graded_of(tissue: Tissue, graded: Graded) -> AssignedQuantity | None:
    """Return the quantity of a tissue that a body grades, None if it has none."""
    quantity = graded.quantity
    given = tissue.given.get(key_of(quantity.name))
    if given is None and quantity.default is not None and quantity.default != quantity.none:
        given = AssignedQuantity(
            quantity, quantity.default, quantity.spreads[0], None, "written", graded.span
        )
    if given is None or given.value == quantity.none:
        return None
    return replace(given, how="written", span=graded.span, fired=(), formula=graded.formula)


def graded_tissue(tissue: Tissue | None, graded: Sequence[Graded]) -> Tissue | None:
    """Return a tissue with formulas in place of some of its numbers.

    Its quantities are separate objects, so that none is identical to that of the tissue.

    Args:
        tissue: The tissue; None without one.
        graded: Quantities that depend on the place.
    """
    if tissue is None or not graded:
        return tissue
    given = {key: replace(one) for key, one in tissue.given.items()}
    for one in graded:
        found = graded_of(tissue, one)
        if found is not None:
            given[key_of(one.quantity.name)] = found
    return replace(tissue, given=given)


def graded_by(bodies: Iterable[Body], tissue: str, key: str) -> Graded | None:
    """Return the formula that a body or a region has for a quantity of a tissue, if any.

    Args:
        bodies: Of the scene.
        tissue: Name of the tissue.
        key: Of the quantity.
    """
    for body in bodies:
        parts = [(body.tissue, body.graded)]
        parts += [(region.tissue or body.tissue, region.graded) for region in body.regions]
        for of, several in parts:
            if of is not None and of.name == tissue:
                found = (one for one in several if key_of(one.quantity.name) == key)
                if (one := next(found, None)) is not None:
                    return one
    return None
