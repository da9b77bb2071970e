"""Entries of bodies that are one value each, some of which joints share."""

from tissuec.core import units
from tissuec.core.fields import OneOf, Point, Real
from tissuec.core.hints import Edit, Hint
from tissuec.lang import syntax as s
from tissuec.scene import schema
from tissuec.scene.body_parts import INTERFACES
from tissuec.scene.entry_meanings import left_side
from tissuec.scene.findings import Findings

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


def read_rupture(item: s.Assign | s.Sentence | s.Block, findings: Findings) -> bool:
    """Return what ``rupture is …`` says."""
    phrase = None if isinstance(item, s.Assign) else item.phrase
    if phrase is None or phrase.words[0].key != "allowed" or phrase.kind == "between":
        forms = [f"{left_side(item)} is {word}" for word in ("allowed", "not allowed")]
        findings.reject(
            "TIS305",
            "rupture is either allowed or not",
            item.span,
            hint=Hint(f"write {', or '.join(forms)}", *map(Edit, forms)),
        )
    return phrase.kind == "word"
