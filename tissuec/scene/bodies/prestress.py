"""The direction in which a body of elements is prestressed: ``prestress along (1, 0, 0)``."""

from typing import Annotated

from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.model import PrestressDirection
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import written
from tissuec.scene.reading.expressions import Scope
from tissuec.script.forms import VerbSentence, texts_of_sentences
from tissuec.script.parts import direction

PRESTRESS = "prestress"


class AlongWords(VerbSentence, frozen=True):
    """The direction of the prestress, as a unit vector of shape (3,)."""

    axis: Annotated[Floats, direction("along", "(1, 0, 0)")]


class AcrossWords(VerbSentence, frozen=True):
    """The normal of the plane of the prestress, as a unit vector of shape (3,)."""

    axis: Annotated[Floats, direction("across")]


_KIND = SentenceKind((AlongWords, AcrossWords), wrong="prestress of a body has one direction")


def examples() -> str:
    """Return examples of all forms, for messages."""
    texts = texts_of_sentences(PRESTRESS, _KIND.forms, as_examples=True)
    return f"{', or '.join(texts)} for that of a plane"


def read_prestress(item: s.Sentence, scope: Scope) -> PrestressDirection:
    """Return the direction that ``prestress along …`` or ``prestress across …`` gives."""
    said: AlongWords | AcrossWords = SentenceReader(PRESTRESS, _KIND, item, scope).get()
    return PrestressDirection(said.axis, isinstance(said, AcrossWords))


DIRECTION_ENTRY = written(
    PRESTRESS,
    "the direction in which a body of elements is prestressed, or the normal of the plane in "
    "which it is",
    *_KIND.forms, begins=" along ", reads=read_prestress,
)  # fmt: skip
