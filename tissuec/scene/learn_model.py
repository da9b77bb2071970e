"""A learn block as far as it can be read without a mesh."""

from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.learn_entries import LearnSettings
from tissuec.script.fit_problem import Data

FIT, AGAINST, ADJUST = "fit", "against column", "adjust"
AXES = ("time", "displacement")


class WrittenFitProblem(Struct, frozen=True):
    """A learn block whose sentences about nodes and springs are still to be read.

    Attributes:
        axis: What rows of tables are sorted by, if that is written.
        fits: Each with the ``against column`` behind it, if there is one.
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
