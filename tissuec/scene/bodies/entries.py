"""Entries of bodies that are one value each, some of which joints share."""

from typing import Annotated

from tissuec.core import units
from tissuec.core.fields import Point, Real
from tissuec.lang import syntax as s
from tissuec.scene.model import Rupture
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import entry, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.tissues.quantities import TOUGHNESS
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause

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


FACES = "faces"


class RuptureWords(VerbSentence, frozen=True):
    """Whether anything breaks."""

    word: Annotated[
        str,
        ChoiceClause(
            "is",
            {
                "allowed": "Springs and elements break above their limits.",
                "not allowed": "Nothing breaks.",
            },
            what="choice",
        ),
    ]


class RuptureByWords(VerbSentence, frozen=True):
    """How elements break."""

    limit: Annotated[
        str,
        ChoiceClause(
            "by",
            {
                TOUGHNESS: "Elements break by toughness alone.",
                FACES: "Solids tear: faces open, and no element is lost.",
            },
            what="choice",
        ),
    ]


_RUPTURE = SentenceKind(
    (RuptureWords, RuptureByWords),
    wrong="rupture is allowed, not allowed, by toughness, or by faces",
)


def _read_rupture(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Rupture:
    said: RuptureWords | RuptureByWords = SentenceReader("rupture", _RUPTURE, item, scope).get()
    if isinstance(said, RuptureByWords):
        return "by faces" if said.limit == FACES else "by toughness"
    return "allowed" if said.word == "allowed" else ""


RUPTURE = written(
    "rupture", "whether springs and elements break above their limits", *_RUPTURE.forms,
    default="", begins=" is ", reads=_read_rupture,
)  # fmt: skip
