"""Entries of bodies that are one value each, some of which joints share."""

from tissuec.core import units
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint
from tissuec.lang import syntax as s
from tissuec.scene.model import Rupture
from tissuec.scene.reading.entries import entry
from tissuec.scene.reading.entry_hints import left_side
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.tissues.quantities import TOUGHNESS

#: Of nets from tables, and of joints.
SECTION = entry(
    "section", Real(units.AREA, above=0.0),
    "cross-section of each spring, if the body is made of matter",
)  # fmt: skip
#: Entries of a body that are one value each.
VALUES = (
    entry(
        "mass", Real(units.MASS, above=0.0),
        "mass of the whole body, shared equally by its nodes; by volume in elements",
    ),
    entry(
        "thickness", Real(units.LENGTH, above=0.0),
        "thickness of a sheet or a wall that is made of matter",
    ),
    SECTION,
    entry("velocity", Point(units.VELOCITY), "initial velocity"),
    entry(
        "spin", Point(units.FREQUENCY), "initial rotation about the centre of mass, in rad/s"
    ),
)  # fmt: skip


def _read_rupture(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Rupture:
    """Return the value of ``rupture is …`` or ``rupture by toughness``."""
    if isinstance(item, s.Sentence) and item.phrase is None and len(item.clauses) == 1:
        (clause,) = item.clauses
        if clause.word == "by" and s.key_of(clause.value.span.text) == TOUGHNESS:
            return "by toughness"
    phrase = None if isinstance(item, s.Assign) else item.phrase
    if phrase is None or phrase.words[0].key != "allowed" or phrase.kind == "between":
        words = "is allowed", "is not allowed", "by toughness"
        forms = [f"{left_side(item)} {word}" for word in words]
        scope.findings.reject(
            "TIS305",
            "rupture is allowed, not allowed, or by toughness",
            item.span,
            hint=Hint(f"write {', '.join(forms[:-1])} or {forms[-1]}", *map(Edit, forms)),
        )
    return "allowed" if phrase.kind == "word" else ""


RUPTURE = entry(
    "rupture", OneOf({"allowed": "Springs and elements break above their limits."}),
    "whether springs and elements break above their limits", "",
    more=(f"rupture by {TOUGHNESS}",), begins=" is ", reads=_read_rupture,
)  # fmt: skip
