"""Fibres of a body: ``fibres = (1, 0, 0)``, or along, around or at an angle around a tube."""

from typing import Annotated, TypeAlias

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Point
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause, ValueClause

SECOND_FIBRES = "second fibres"
AXIAL, CIRCUMFERENTIAL = "axial", "circumferential"  # fibres of a tube
_WORDS = {
    AXIAL: "along the axis of a tube",
    CIRCUMFERENTIAL: "around the axis of a tube",
}


class Helix(Struct, frozen=True):
    """Fibres that run around a tube of elements as the thread of a screw.

    Attributes:
        angle: From around the tube towards its axis [rad].
    """

    angle: float

    def __str__(self) -> str:
        return "helical"


Direction: TypeAlias = Floats | str | Helix


class FibreWord(VerbSentence, frozen=True):
    """How fibres run in a tube."""

    word: Annotated[str, ChoiceClause("is", _WORDS, what="choice", place="…")]


class FibreVector(VerbSentence, frozen=True):
    """The direction of fibres."""

    direction: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="(x, y, z)")]


class FibreAngle(FibreVector, frozen=True):
    """The angle between fibres of a tube and the direction around it."""

    direction: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="ANGLE")]


_KIND = SentenceKind((FibreWord, FibreVector, FibreAngle))


def read_fibres(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Direction:
    """Return the direction of fibres [1], shape (3,), or how they run in a tube."""
    said: FibreWord | FibreVector = SentenceReader(item.name.key, _KIND, item, scope).get()
    if isinstance(said, FibreWord):
        return said.word
    node = said.direction
    if not scope.evaluate(node).is_vector:
        return Helix(scope.angle(node, what="the angle of fibres"))
    vector = schema.read_value(Point(units.NUMBER), node, scope, what="fibres")
    direction = np.asarray(vector, dtype=float)
    if not direction.any():
        scope.findings.reject(
            "TIS308", "fibres need a direction", item.span, hint="write fibres = (1, 0, 0)"
        )
    return direction / np.linalg.norm(direction)


FIBRES_ENTRY, SECOND_FIBRES_ENTRY = (
    written(name, about, *_KIND.forms, begins=" is ", reads=read_fibres)
    for name, about in (
        ("fibres", "the stiffer direction of a tissue with a fibre modulus"),
        (SECOND_FIBRES, "the direction of a second family of fibres, in a body of elements"),
    )
)
