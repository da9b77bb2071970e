"""Entries of bodies that are one value each, some of which joints share."""

from tissuec.core import units
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.body_parts import INTERFACES
from tissuec.scene.entry_meanings import left_side
from tissuec.scene.findings import Findings
from tissuec.scene.model import Rupture
from tissuec.scene.quantities import TOUGHNESS

#: Of nets from tables, and of joints.
SECTION = schema.Entry(
    "section",
    "section",
    Real(units.AREA, above=0.0),
    None,
    "cross-section of each spring, if the body is made of matter",
)
#: Entries of a body beside mesh, tissue and regions.
BODY_ENTRIES: dict[str, schema.Entry] = {
    entry.name: entry
    for entry in (
        schema.Entry(
            "mass",
            "mass",
            Real(units.MASS, above=0.0),
            None,
            "mass of the whole body, shared equally by its nodes; by volume in elements",
        ),
        schema.Entry(
            "thickness",
            "thickness",
            Real(units.LENGTH, above=0.0),
            None,
            "thickness of a sheet or a wall that is made of matter",
        ),
        SECTION,
        schema.Entry(
            "interface",
            "interface",
            OneOf(INTERFACES),
            "",
            "the material of springs between two regions",
        ),
        schema.Entry("velocity", "velocity", Point(units.VELOCITY), None, "initial velocity"),
        schema.Entry(
            "spin",
            "spin",
            Point(units.FREQUENCY),
            None,
            "initial rotation about the centre of mass, in rad/s",
        ),
    )
}


def read_rupture(item: s.Assign | s.Sentence | s.Block, findings: Findings) -> Rupture:
    """Return the value of ``rupture is …`` or ``rupture by toughness``."""
    if isinstance(item, s.Sentence) and item.phrase is None and len(item.clauses) == 1:
        (clause,) = item.clauses
        if clause.word == "by" and s.key_of(clause.value.span.text) == TOUGHNESS:
            return "by toughness"
    phrase = None if isinstance(item, s.Assign) else item.phrase
    if phrase is None or phrase.words[0].key != "allowed" or phrase.kind == "between":
        words = "is allowed", "is not allowed", "by toughness"
        forms = [f"{left_side(item)} {word}" for word in words]
        findings.reject(
            "TIS305",
            "rupture is allowed, not allowed, or by toughness",
            item.span,
            hint=Hint(f"write {', '.join(forms[:-1])} or {forms[-1]}", *map(Edit, forms)),
        )
    return "allowed" if phrase.kind == "word" else ""
