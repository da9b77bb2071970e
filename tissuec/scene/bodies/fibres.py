"""Fibres of a body: ``fibres = (1, 0, 0)``, or along, around or at an angle around a tube."""

from typing import Annotated, TypeAlias

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import OneOf, Point
from tissuec.core.hints import alternatives
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import entry
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ValueClause

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


class FibreVector(VerbSentence, frozen=True):
    """The direction of fibres."""

    direction: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="(x, y, z)")]


class FibreAngle(VerbSentence, frozen=True):
    """The angle between fibres of a tube and the direction around it."""

    angle: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="ANGLE")]


def read_fibres(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Direction:
    """Return the direction of fibres [1], shape (3,), or how they run in a tube."""
    if not isinstance(item, s.Assign):
        example = "fibres is axial, or fibres = (1, 0, 0)"
        word = schema.word_of(item, scope, example=example)
        if word.key in _WORDS:
            return word.key
        scope.findings.reject(
            "TIS305", f'fibres cannot be "{word.text}"', word.span,
            hint=f"{alternatives(word.key, _WORDS, what='choices')}, or fibres = (1, 0, 0)",
        )  # fmt: skip
    if isinstance(item.value, s.Quantity | s.Signed):
        angle = scope.number(item.value)
        scope.expect(angle, units.NUMBER, item.value.span, what="the angle of fibres")
        return Helix(float(angle.amount))
    direction = np.asarray(schema.read_entry(_AS_VECTOR, item, scope), dtype=float)
    if not direction.any():
        scope.findings.reject(
            "TIS308", "fibres need a direction", item.span, hint="write fibres = (1, 0, 0)"
        )
    return direction / np.linalg.norm(direction)


FIBRES_ENTRY, SECOND_FIBRES_ENTRY = (
    entry(
        name, OneOf(_WORDS), about, sentences=(FibreVector, FibreAngle), begins=" is ",
        reads=read_fibres,
    )
    for name, about in (
        ("fibres", "the stiffer direction of a tissue with a fibre modulus"),
        (SECOND_FIBRES, "the direction of a second family of fibres, in a body of elements"),
    )
)  # fmt: skip
_AS_VECTOR = entry("fibres", Point(units.NUMBER), "")
