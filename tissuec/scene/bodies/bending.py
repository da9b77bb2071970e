"""Bending of walls: ``bending is soft``, ``bending = 20 %`` or ``bending is elastic``."""

from typing import Annotated

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import Bending
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import entry
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ValueClause

_PART = Real(units.NUMBER, at_least=0.0, at_most=100.0)
ELASTIC = "elastic"  # how a wall of matter resists bending
#: How stiff bending springs are in words, as parts of the tissue's springs.
BENDING = {"none": 0.0, "soft": 0.05, "medium": 0.2, "stiff": 1.0}
_CHOICES = {
    **{
        word: f"{100 * part:.0f} % of the spring constant and viscosity of the tissue"
        for word, part in BENDING.items()
    },
    ELASTIC: "like a wall of its thickness",
}


class BendingNumber(VerbSentence, frozen=True):
    """How stiff bending springs are, as a part of the springs of the tissue."""

    part: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="NUMBER")]


def read_bending(
    item: s.Assign | s.Sentence | s.Block, scope: Scope
) -> tuple[Bending | None, Span | None]:
    """Return springs besides those of the tissue, or the entry that requires a shell."""
    example = "bending is soft, or bending = 20 %"
    if isinstance(item, s.Assign) and item.value.span.text.lower() in _CHOICES:
        schema.refuse_sign(item, scope, example=example)
    if isinstance(item, s.Assign):
        part = schema.read_entry(_AS_NUMBER, item, scope)
    else:
        word = schema.word_of(item, scope, example=example)
        if word.key == ELASTIC:
            return None, item.span
        part = _named_part(word, scope)
    return (Bending(part, item.span) if part else None), None


def _named_part(word: s.Name, scope: Scope) -> float:
    """Return how stiff bending springs are by a word."""
    if word.key not in BENDING:
        scope.findings.reject(
            "TIS305",
            f'bending cannot be "{word.text}"',
            word.span,
            hint=f"{alternatives(word.key, _CHOICES, what='choices')}, or bending = 20 %",
        )
    return BENDING[word.key]


BENDING_ENTRY = entry(
    "bending", OneOf(_CHOICES),
    "bending resistance of a surface: by springs, or elastic like a wall of its thickness",
    sentences=(BendingNumber,), begins=" is ", reads=read_bending,
)  # fmt: skip
_AS_NUMBER = entry("bending", _PART, BENDING_ENTRY.about)
