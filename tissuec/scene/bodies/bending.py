"""Bending of walls: ``bending is soft``, ``bending = 20 %`` or ``bending is elastic``."""

from typing import Annotated

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import Bending
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ChoiceClause, ValueClause

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


class BendingWord(VerbSentence, frozen=True):
    """How a surface resists bending, in a word."""

    word: Annotated[str, ChoiceClause("is", _CHOICES, what="choice", place="…")]


class BendingNumber(VerbSentence, frozen=True):
    """How stiff bending springs are, as a part of the springs of the tissue."""

    part: Annotated[s.Expression, ValueClause("=", units.NUMBER, place="NUMBER")]


_KIND = SentenceKind((BendingWord, BendingNumber))


def read_bending(
    item: s.Assign | s.Sentence | s.Block, scope: Scope
) -> tuple[Bending | None, Span | None]:
    """Return springs besides those of the tissue, or the entry that requires a shell."""
    if isinstance(item, s.Assign) and item.value.span.text.lower() in _CHOICES:
        schema.refuse_sign(item, scope, example="bending is soft")
    said: BendingWord | BendingNumber = SentenceReader("bending", _KIND, item, scope).get()
    if isinstance(said, BendingNumber):
        part = schema.read_value(_PART, said.part, scope, what="bending")
    elif said.word == ELASTIC:
        return None, item.span
    else:
        part = BENDING[said.word]
    return (Bending(part, item.span) if part else None), None


BENDING_ENTRY = written(
    "bending",
    "bending resistance of a surface: by springs, or elastic like a wall of its thickness",
    *_KIND.forms, begins=" is ", reads=read_bending,
)  # fmt: skip
