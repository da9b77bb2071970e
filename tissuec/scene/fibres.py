"""Fibres of a body: ``fibres = (1, 0, 0)``, or along or around a tube."""

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Point
from tissuec.core.hints import alternatives
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene import schema
from tissuec.scene.expressions import Scope

SECOND_FIBRES = "second fibres"
AXIAL, CIRCUMFERENTIAL = "axial", "circumferential"  # fibres of a tube


def read_fibres(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> Floats | str:
    """Return the direction of fibres [1], shape (3,), or how they run in a tube."""
    if not isinstance(item, s.Assign):
        example = "fibres is axial, or fibres = (1, 0, 0)"
        word = schema.word_of(item, scope, example=example)
        known = (AXIAL, CIRCUMFERENTIAL)
        if word.key in known:
            return word.key
        scope.findings.reject(
            "TIS305", f'fibres cannot be "{word.text}"', word.span,
            hint=f"{alternatives(word.key, known, what='choices')}, or fibres = (1, 0, 0)",
        )  # fmt: skip
    entry = schema.Entry("fibres", "fibres", Point(units.NUMBER), None, "")
    direction = np.asarray(schema.read_entry(entry, item, scope), dtype=float)
    if not direction.any():
        scope.findings.reject(
            "TIS308", "fibres need a direction", item.span, hint="write fibres = (1, 0, 0)"
        )
    return direction / np.linalg.norm(direction)
