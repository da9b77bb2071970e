"""The sentences of the output block, for checks, editors and the reference."""

from typing import Annotated

from tissuec.core.units import TIME
from tissuec.geometry.surfaces import SURFACES
from tissuec.lang import syntax as s
from tissuec.results import PRECISIONS, SINGLE
from tissuec.scene.reading.block_sentences import SentenceKind, as_entries
from tissuec.scene.reading.parts import block, block_of, declare
from tissuec.script.forms import VerbSentence
from tissuec.script.measures import MEASURES
from tissuec.script.parts import (
    BODY,
    SET,
    ChoiceClause,
    MeasureClause,
    NameClause,
    NumberClause,
    Placeholder,
)

TRAJECTORY, SURFACE, ENERGY = "trajectory", "surface", "energy"
PRECISION, COMPRESS, BLOCKS = "precision", "compress", "blocks"
FIELD = Placeholder("FIELD")

#: Time between values [s].
Rate = Annotated[
    float,
    NumberClause("every", TIME, "positive", what="time between outputs", example="every 10 ms"),
]


class RecordedWords(VerbSentence, frozen=True):
    """What is recorded at regular times."""

    every: Rate


class MeasureRecorded(VerbSentence, frozen=True):
    """What of something is recorded at regular times."""

    measure: Annotated[s.Expression, MeasureClause("", place="MEASURE(MEASURED, MEASURED)")]
    every: Rate


class TrajectoryWords(VerbSentence, frozen=True):
    """Positions of nodes, by default of all, and fields."""

    of: Annotated[tuple[s.Name, ...] | None, NameClause("of", places=(SET,), listed=True)]
    fields: Annotated[
        tuple[s.Name, ...] | None, NameClause("with", places=(FIELD,), listed=True)
    ]
    every: Rate


class SurfaceWords(VerbSentence, frozen=True):
    """Surfaces of bodies."""

    of: Annotated[
        tuple[s.Name, ...], NameClause("of", what="body", places=(BODY,), listed=True)
    ]
    every: Rate


class PrecisionWords(VerbSentence, frozen=True):
    """How many digits of positions are stored."""

    kind: Annotated[str, ChoiceClause("is", PRECISIONS, what="precision")]


class AloneWords(VerbSentence, frozen=True):
    """A word that nothing can follow."""


#: What is recorded beside measures, by its first words.
SENTENCES: dict[str, SentenceKind] = {
    TRAJECTORY: SentenceKind(
        (TrajectoryWords,),
        "Positions of all or some nodes at regular times.",
        is_single=True,
        begins=" every ",
        instead="list several bodies: trajectory of [A, B] every 10 ms",
    ),
    PRECISION: SentenceKind(
        (PrecisionWords,),
        f"Whether positions are stored with single or double precision; without it, {SINGLE}.",
        is_single=True,
    ),
    COMPRESS: SentenceKind(
        (AloneWords,),
        "Makes frames and surfaces smaller, without loss.",
        is_single=True,
    ),
    BLOCKS: SentenceKind(
        (AloneWords,),
        "A file for ParaView with the parts of bodies, beside the result.",
        is_single=True,
    ),
    SURFACE: SentenceKind(
        (SurfaceWords,),
        "A smooth surface through a body at regular times.",
        opens=block_of(SURFACES, "kind of surface", default=""),
    ),
    ENERGY: SentenceKind(
        (RecordedWords,),
        "Energies of the whole scene and the drift of their sum.",
        is_single=True,
        begins=" every ",
    ),
}


def recorded() -> dict[str, SentenceKind]:
    """Return all outputs by name; measures of something are written with parentheses."""
    return SENTENCES | {
        name: SentenceKind((RecordedWords,), "A measure.", (f"{measure.form} every 10 ms",))
        for name, measure in MEASURES.items()
        if name not in SENTENCES
    }


declare(
    "output", "Contents of the result file.", 43, "single",
    example="output { trajectory every 10 ms }",
    block=block(lambda: as_entries(SENTENCES), MeasureRecorded),
)  # fmt: skip
