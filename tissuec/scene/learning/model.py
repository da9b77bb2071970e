"""A learn block as far as it can be read without a mesh."""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.learning.entries import LearnSettings
from tissuec.script.fit_problem import Data, Demand

FIT, AGAINST, ADJUST = "fit", "against column", "adjust"
AXES = ("time", "displacement")


class WrittenFitProblem(Struct, frozen=True):
    """A learn block whose sentences about nodes and springs are still to be read.

    Attributes:
        axis: What rows of tables are sorted by, if that is written.
        fits: Each with the ``against column`` after it, if there is one.
        names: Of the data, as written, by the names of the files.
        is_whole: Whether all of this could be read.
    """

    name: s.Name
    data: tuple[Data, ...]
    names: Mapping[str, str]
    axis: s.Sentence | None
    fits: tuple[tuple[s.Assign, s.Sentence | None], ...]
    adjusts: tuple[s.Assign | s.Sentence, ...]
    last_part: float
    revise: tuple[str, ...]
    settings: LearnSettings
    write: Path | None
    is_whole: bool
    span: Span


class WordTarget(Struct, frozen=True):
    """A number that the words of a tissue should give.

    Attributes:
        tissue, quantity: By their lower-case names.
        value: In SI units.
        deviation: Standard deviation, in the coordinate of the scale of the quantity.
        how: Whether the number is written in the tissue, or the middle of evidence.
        weight: Factor of its part of the error.
        held_out: Whether it is used for testing only.
        span: The fit that asks for it.
    """

    tissue: str
    quantity: str
    value: float
    deviation: float
    how: Literal["written", "evidence"]
    weight: float
    held_out: bool
    span: Span


class VocabularyFit(Struct, frozen=True):
    """A learn block that fits words to numbers of tissues, without mechanics.

    Attributes:
        scales: Properties and quantities whose words move, by lower-case name.
        rules: Rules whose weights change, by lower-case name.
        left_out: Sentences about tissues that ``all tissues`` passes over.
        write: File of the new vocabulary; None if it is not written.
        is_whole: Whether all of it could be read.
    """

    name: str
    targets: tuple[WordTarget, ...]
    scales: tuple[str, ...]
    rules: tuple[str, ...]
    left_out: tuple[str, ...]
    passes: int
    tolerance: float
    write: Path | None
    demands: tuple[Demand, ...]
    is_whole: bool
    span: Span
