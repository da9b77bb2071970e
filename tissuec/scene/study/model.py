"""A study block as far as it can be read without a mesh."""

from typing import TypeAlias

from msgspec import Struct

from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.study.entries import StudySettings

#: A value of a factor: a number in its unit, or a text as a scene has it.
Cell: TypeAlias = float | str
#: The name of a study that only options describe.
UNNAMED = "study"


def called(name: str) -> str:
    """Return what headings and messages call a study: "study NAME", or "study"."""
    return name if name == UNNAMED else f"study {name}"


class Levels(Struct, frozen=True):
    """Values that are listed.

    Attributes:
        places: Where each is written; the whole range for those of a range.
    """

    values: tuple[Cell, ...]
    places: tuple[Span, ...]


class Distribution(Struct, frozen=True):
    """Values that are drawn.

    Attributes:
        kind: One of ``DISTRIBUTIONS``.
        numbers: Its parameters in the unit of the factor, but for factors.
        low, high: Limits between which it is cut off; None for no limit.
    """

    kind: str
    numbers: tuple[float, ...]
    low: float | None = None
    high: float | None = None


class Factor(Struct, frozen=True):
    """What varies.

    Attributes:
        name: As it is called in the table, such as "hardness of fallopian tube".
        verb: "=" or "is", between it and its value.
        unit: Of numbers, as in the table.
        spread: Its values; None where a file of rows has them.
        written: Its values as they are written, "" for none.
        own: What the scene itself has; None if nothing, or not known.
    """

    name: str
    verb: str
    unit: str
    is_text: bool
    spread: Levels | Distribution | None
    written: str
    own: Cell | None
    span: Span

    def override(self, value: Cell) -> str:
        """Return the text of ``--set`` for a value."""
        text = value if isinstance(value, str) else f"{plain(value)} {self.unit}".rstrip()
        return f"{self.name} {self.verb} {text}"


class WrittenMeasure(Struct, frozen=True):
    """A ``measure`` line.

    Attributes:
        name: Of the column; the text of the measure if none is written.
    """

    name: str
    item: s.Assign
    span: Span


class Study(Struct, frozen=True):
    """A study block.

    Attributes:
        design: One of ``DESIGNS``.
        rows: Values of the factors for each run, from a file; None without one.
        estimates: Whether the error of each run is estimated.
    """

    name: str
    factors: tuple[Factor, ...]
    rows: tuple[tuple[Cell, ...], ...] | None
    measures: tuple[WrittenMeasure, ...]
    expects: tuple[s.Expect, ...]
    design: str
    estimates: bool
    settings: StudySettings
    is_whole: bool
    span: Span


def plain(number: float) -> str:
    """Return a number with all its digits, as a text of the language has it."""
    return repr(float(number)).removesuffix(".0").replace("e+", "e")
