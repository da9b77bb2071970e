"""One run of a study as a row of its table, and the heads above the rows."""

from msgspec import Struct

from tissuec.scene.study.model import Cell

#: What the outcome of a run can be: it came to its end, or its script ended it; the motion
#: could not be computed; the text was wrong; or its worker process died.
DONE, ENDED, DIVERGED, STUCK, REFUSED, DIED = (
    "done", "ended", "diverged", "stuck", "refused", "died",
)  # fmt: skip
OUTCOMES = (DONE, ENDED, DIVERGED, STUCK, REFUSED, DIED)


class FactorHead(Struct, frozen=True):
    """The head above the values of a factor.

    Attributes:
        name: Such as "lift" or "hardness of fallopian tube".
        unit: Of numbers, such as "mm"; "" for numbers without a unit and for words.
        is_text: Whether values are words.
        values: Its values as they were written, such as "normal(5 mm, 1 mm)".
    """

    name: str
    unit: str
    is_text: bool = False
    values: str = ""


class MeasureHead(Struct, frozen=True):
    """The head above a measure.

    Attributes:
        name: Such as "pull".
        unit: Such as "N".
        every: Time between the values of a curve [s]; None for a single number.
    """

    name: str
    unit: str
    every: float | None = None


class StudyHead(Struct, frozen=True):
    """All of a table except its rows.

    Attributes:
        name: Of the study.
        scene: Name of the scene.
        design: Such as "grid" or "sobol".
        seed: Of random designs.
        base: Base number of "sobol indices"; 0 for other designs.
        planned: Number of runs of the whole study.
        measures: Single numbers before curves.
    """

    name: str
    scene: str
    design: str
    seed: int
    base: int
    planned: int
    factors: tuple[FactorHead, ...]
    measures: tuple[MeasureHead, ...]


class Row(Struct, frozen=True):
    """One run.

    Attributes:
        run: Its number in the design, from 0.
        values: Of the factors.
        measures: Of single numbers one value, of curves all, NaN where there is none.
        outcome: One of ``OUTCOMES``.
        reason: One line; "" for a run that came to its end.
        promise: "kept", "broken from T", "unknown from T" or "not checked".
        error: Estimated error of positions, relative to displacements; NaN if not known.
        digest: Of all that the row follows from.
        doubts: Kinds of what makes its numbers doubtful, such as "inside out"; "" for none.
    """

    run: int
    values: tuple[Cell, ...]
    measures: tuple[float | tuple[float, ...], ...]
    outcome: str
    reason: str
    promise: str
    error: float
    digest: str = ""
    doubts: str = ""


def title(name: str, unit: str) -> str:
    """Return the head of a column: "lift [mm]"."""
    return f"{name} [{unit}]" if unit else name
