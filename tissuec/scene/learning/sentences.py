"""The sentences of a learn block, for checks, editors and the reference."""

from types import MappingProxyType
from typing import Annotated

from tissuec.core.units import LENGTH, NUMBER, TIME
from tissuec.lang import syntax as s
from tissuec.model.network import Floats
from tissuec.scene.learning.entries import DIVIDED
from tissuec.scene.reading.block_sentences import FileWords, SentenceKind
from tissuec.scene.reading.parts import block
from tissuec.script.fit_problem import POSITIONS, WEIGHTS, WORDS, DataColumn
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import (
    BODY,
    FORCE,
    OWN,
    QUANTITY,
    REGION,
    RULES,
    SET,
    SPRINGS,
    TISSUE,
    ColumnsClause,
    FilesClause,
    FlagPart,
    MeasureClause,
    NameClause,
    NumberClause,
    Placeholder,
    Refusal,
    ValueClause,
    direction,
)

#: Words in place of names and numbers.
INITIAL, ALL_TISSUES = "initial value", "all tissues"
ADJUSTED = Placeholder("ADJUSTED", ("param",))
LISTED = Placeholder("LISTED", ("param",))
DIVISION = Placeholder("DIVISION", words=DIVIDED, about="Each has its own number.")
#: Names after the words that say what is adjusted or fitted.
_WHAT = NameClause("", what="adjusted quantity", places=(ADJUSTED,))
_TISSUES = NameClause(
    "of", what="tissue", places=(TISSUE, Placeholder("", words=(ALL_TISSUES,))), listed=True
)
_OWNERS = (TISSUE, SPRINGS, REGION, FORCE)
#: What a file cannot have of its own.
OF_ALL = (
    "fits, zeros and what is adjusted are those of all files of a block; use a learn block "
    "for each machine or specimen, or give what differs by a param of the scene, as in "
    'data "three.csv" { NAME = 2 mm }'
)

Along = Annotated[Floats | None, direction("along", "(1, 0, 0)")]  # unit vector, shape (3,)
#: Least time between values of a column [s].
Every = Annotated[
    float | None,
    NumberClause("every", TIME, "positive", what="time between values", example="every 10 ms"),
]
#: Standard deviation of values, in their SI unit.
Noise = Annotated[
    float | None,
    NumberClause("to", OWN, "positive", what="standard deviation", example="to 2 mN"),
]
Weight = Annotated[
    float | None,
    NumberClause(
        "weighing", NUMBER, "positive", what="weight of a fit", example="weighing 0.5"
    ),
]
FreeZero = Annotated[
    bool, FlagPart("with free zero", about="The data has an unknown constant offset.")
]


class DataWords(VerbSentence, frozen=True):
    """Files of measurements.

    Attributes:
        files: Their names in quotes.
        start: Time of the files at which the run begins [s].
    """

    refused = MappingProxyType({"with": Refusal("files have no zeros of their own", OF_ALL)})

    files: Annotated[tuple[s.Name, ...], FilesClause("=", what="file")]
    start: Annotated[float | None, NumberClause("from", TIME, what="start of the run")]


class DatumWords(DataWords, frozen=True):
    """A file, for which params of the scene can differ."""

    files: Annotated[tuple[s.Name, ...], FilesClause("", what="file")]


class TimeWords(VerbSentence, frozen=True):
    """The column of times."""

    columns: Annotated[
        tuple[DataColumn, ...],
        ColumnsClause(
            "using", TIME, what="column of the time", example='using column "t_ms" in ms'
        ),
    ]


class DisplacementWords(VerbSentence, frozen=True):
    """The column of displacements of a set."""

    moved: Annotated[s.Name, NameClause("of", what="displaced set", places=(SET,))]
    along: Along
    columns: Annotated[
        tuple[DataColumn, ...],
        ColumnsClause(
            "using",
            LENGTH,
            what="column of the displacement",
            example='using column "u_mm" in mm',
        ),
    ]


class FitWords(VerbSentence, frozen=True):
    """A fit of a measure."""

    refused = MappingProxyType(
        {
            "along": Refusal(
                "a direction is written in the parentheses of its measure",
                "for example: force(SET along (0, 0, 1))",
            )
        }
    )

    measure: Annotated[s.Expression, MeasureClause("=", what="measure", others=(POSITIONS,))]
    columns: Annotated[tuple[DataColumn, ...] | None, ColumnsClause("using", OWN)]
    every: Every
    noise: Noise
    weight: Weight
    free_zero: FreeZero


class AgainstWords(VerbSentence, frozen=True):
    """The column of the fit on the line above."""

    columns: Annotated[tuple[DataColumn, ...], ColumnsClause("", OWN, example='"force_N" in N')]
    every: Every
    noise: Noise
    weight: Weight
    free_zero: FreeZero


class FitTissueWords(VerbSentence, frozen=True):
    """A fit of a number of tissues."""

    quantity: Annotated[s.Name, NameClause("=", what="quantity", places=(QUANTITY,))]
    tissues: Annotated[tuple[s.Name, ...] | None, _TISSUES]
    weight: Weight


class AdjustListed(VerbSentence, frozen=True):
    """Numbers of the tissue or force with the name of the block."""

    listed: Annotated[
        tuple[s.Name, ...], NameClause("=", what="quantities", places=(LISTED,), listed=True)
    ]


class AdjustScales(VerbSentence, frozen=True):
    """Words of quantities or properties."""

    literal = WORDS

    owners: Annotated[
        tuple[s.Name, ...],
        NameClause("of", what="owner of the words", places=(QUANTITY,), listed=True),
    ]


class AdjustWeights(VerbSentence, frozen=True):
    """Weights of rules."""

    literal = WEIGHTS

    owners: Annotated[
        tuple[s.Name, ...],
        NameClause("of", what="owner of the weights", places=(RULES,), listed=True),
    ]


class AdjustWords(VerbSentence, frozen=True):
    """What is adjusted, to what it belongs, and by what it is divided."""

    what: Annotated[s.Name, _WHAT]
    owners: Annotated[
        tuple[s.Name, ...] | None, NameClause("of", places=_OWNERS, owners=(BODY,))
    ]
    per: Annotated[s.Name | None, NameClause("per", places=(DIVISION,))]


class LimitWords(VerbSentence, frozen=True):
    """Limits of what is adjusted, and what is expected of it, in SI units."""

    along: Along
    low: Annotated[float | None, NumberClause("from", OWN, what="lower limit")]
    high: Annotated[float | None, NumberClause("to", OWN, what="upper limit")]
    around: Annotated[
        s.Expression | None,
        ValueClause(
            "around", what="expected value", places=(Placeholder("VALUE", words=(INITIAL,)),)
        ),
    ]
    by: Annotated[
        float | None,
        NumberClause(
            "by", NUMBER, "positive", what="expected relative deviation", example="by 30 %"
        ),
    ]


class ReviseWords(VerbSentence, frozen=True):
    """Rules that may be revised."""

    rules: Annotated[s.Name, NameClause("of", what="set of rules", places=(RULES,))]


class FilesHeld(VerbSentence, frozen=True):
    """Files that are held out."""

    files: Annotated[
        tuple[s.Name, ...], FilesClause("=", what="file", example='= ["one.csv", "two.csv"]')
    ]


class PartHeld(VerbSentence, frozen=True):
    """A part that is held out."""

    held: Annotated[s.Expression, ValueClause("=", what="part", example="= 20 %")]


class TissuesHeld(VerbSentence, frozen=True):
    """Tissues that are held out."""

    held: Annotated[
        tuple[s.Name, ...],
        NameClause("=", places=(TISSUE,), listed=True, example="= [TISSUE]"),
    ]


class TissueHeld(VerbSentence, frozen=True):
    """A tissue that is held out."""

    held: Annotated[tuple[s.Name, ...], NameClause("", places=(TISSUE,), listed=True)]


class WriteWords(VerbSentence, frozen=True):
    """The file of the result."""

    files: Annotated[
        tuple[s.Name, ...],
        FilesClause("", what="file", is_new=True, example='"learned/fat.tis"'),
    ]


SENTENCES: dict[str, SentenceKind] = {
    "data": SentenceKind(
        (DataWords, DatumWords),
        "Files of measurements beside the scene: tables, results of runs (HDF5), or H5MD. A"
        " block after the name gives the params of the scene that differ in this experiment."
        " ``from`` is the time of the file at which the run begins (by default 0 s); earlier"
        " rows are not used. Needed for fits of measures.",
        examples=(
            'data = ["one.csv", "two.csv"]',
            'data "three.csv" from 12.4 s { NAME = 2 mm }',
        ),
        opens=block({}),
    ),
    "time": SentenceKind(
        (TimeWords,),
        "The column of times, or of the numbers of pictures and the time between them, as in"
        ' ``column "frame" in 10 ms``. By'
        " default the first column (in TRC files the column of times), in seconds or in the"
        " unit that its name ends with.",
        is_single=True,
    ),
    "displacement": SentenceKind(
        (DisplacementWords,),
        "Instead of a time: the displacement of the set in each row, where the net is in"
        " equilibrium. It counts to where the script moves the set; ``along`` gives it a sign,"
        " for tension and compression in one table.",
        is_single=True,
    ),
    "fit": SentenceKind(
        (FitWords, FitTissueWords),
        "The measured quantity: a measure, or the positions of all nodes of a set, and its"
        " columns. Results of runs need no columns. ``every`` sets the least interval in time,"
        " ``to`` gives the standard deviation of the measured values, ``weighing`` gives their"
        " weight, and ``with free zero`` allows for an unknown constant offset. Or numbers of"
        " tissues that their words should give: those that are written, or else the evidence;"
        " such a block has no data.",
        examples=(
            'fit = force(SET) using column "force_N" in N every 10 ms to 2 mN weighing 0.5',
            'fit = position(SET along (1, 0, 0)) using column "x_mm" in mm with free zero',
            'fit = positions(SET) using columns "node x y z" in mm',
            "fit = QUANTITY of TISSUE weighing 2",
            "fit = QUANTITY of all tissues",
        ),
        is_needed=True,
    ),
    "against column": SentenceKind(
        (AgainstWords,),
        "The column of the fit on the line above, if that names none.",
    ),
    "adjust": SentenceKind(
        (AdjustListed, AdjustScales, AdjustWeights, AdjustWords, LimitWords),
        "The adjusted parameters: a quantity of a tissue (by default the tissue or force with"
        " the name of the block), a constant of its laws, or a param in their formulas; a"
        " spring constant, viscosity, mass or rest length of a set, body or region by one"
        " factor, or ``per spring``, ``per node`` or ``per region``; where a set starts, and"
        " how fast; a number of a force; or the words of a quantity or property, whose order"
        " is kept; with fits of numbers of tissues, also the weights of rules."
        " ``from … to …`` are limits, ``around … by …`` is the expected value and its"
        " relative deviation (one standard deviation); ``around initial value`` expects each"
        " where it starts.",
        examples=(
            "adjust = [spring constant, viscosity]",
            "adjust spring constant of TISSUE from 1 N/m to 1 kN/m around 20 N/m by 30 %",
            "adjust spring constant of SET per spring around initial value by 50 %",
            "adjust start position of SET along (1, 0, 0)",
            "adjust stiffness of FORCE from 1 kPa/m to 1 MPa/m",
            "adjust words of QUANTITY",
            "adjust weights of RULES",
        ),
        is_needed=True,
    ),
    "revise rules": SentenceKind(
        (ReviseWords,),
        "Rules that may be changed, added or dropped if this reduces the error of rows that"
        " were not fitted. Words and numbers are fitted again with each candidate.",
    ),
    "hold out": SentenceKind(
        (FilesHeld, FileWords, PartHeld, TissuesHeld, TissueHeld),
        "Data for testing, not for learning: some of the files, the last part of each"
        " experiment, or tissues whose numbers are fitted.",
    ),
    "write": SentenceKind(
        (WriteWords,),
        "The file of the preset, or of the vocabulary, relative to the scene.",
        is_single=True,
    ),
}  # fmt: skip
