"""The direction in which a body of elements is prestressed: ``prestress along (1, 0, 0)``."""

from typing import NoReturn

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Point
from tissuec.lang import syntax as s
from tissuec.scene.model import PrestressDirection
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope

PRESTRESS = "prestress"
ALONG, ACROSS = "along", "across"
FORMS = "prestress along (1, 0, 0), or prestress across (0, 0, 1) for that of a plane"


def read_prestress(item: s.Sentence, scope: Scope) -> PrestressDirection:
    """Return the direction that ``prestress along …`` or ``prestress across …`` gives."""
    words = [clause.word for clause in item.clauses]
    if item.phrase is not None or words not in ([ALONG], [ACROSS]):
        _wrong_form(item, scope)
    kind, value = Point(units.NUMBER), item.clauses[0].value
    axis = np.asarray(schema.read_value(kind, value, scope, what="the direction"), dtype=float)
    if not axis.any():
        scope.findings.reject(
            "TIS308", "prestress needs a direction", item.span, hint=f"write {FORMS}"
        )
    return PrestressDirection(axis / np.linalg.norm(axis), words == [ACROSS])


def _wrong_form(item: s.Sentence, scope: Scope) -> NoReturn:
    scope.findings.reject(
        "TIS312", "prestress of a body has one direction", item.span, hint=f"write {FORMS}"
    )


DIRECTION_ENTRY = written(
    PRESTRESS,
    "the direction in which a body of elements is prestressed, or the normal of the plane in "
    "which it is",
    f"{PRESTRESS} {ALONG} VECTOR", f"{PRESTRESS} {ACROSS} VECTOR",
    begins=f" {ALONG} ", reads=read_prestress,
)  # fmt: skip
