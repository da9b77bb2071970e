"""Types that say how an entry is written; a dataclass of them is a schema of the language.

The compiler reads a member's fields (name, type, default, "Attributes:" line of the docstring)
and from them checks entries, converts units, suggests near misses and writes the reference. An
underscore in a field name is a blank in the language.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.source import Span
from tissuec.core.units import Dimension


@dataclass(frozen=True, slots=True)
class Measure:
    """A number with a dimension. ``above``/``at_least``/``at_most`` are limits in SI units."""

    dimension: Dimension
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole number with limits."""

    at_least: int = 1
    at_most: int = 100_000_000


@dataclass(frozen=True, slots=True)
class OneOf:
    """One of a few words, written with ``is``.

    Attributes:
        opens: Whether a word may be followed by a block, of which somebody else knows.
    """

    words: tuple[str, ...]
    opens: bool = False


@dataclass(frozen=True, slots=True)
class Point:
    """A vector of three components with a dimension."""

    dimension: Dimension


@dataclass(frozen=True, slots=True)
class FromTo:
    """``axis from (…) to (…)``: two points."""

    dimension: Dimension


@dataclass(frozen=True, slots=True)
class Several:
    """A list of numbers with a dimension, written ``[1 mm, 2 mm]``."""

    dimension: Dimension
    at_least: int = 1


@dataclass(frozen=True, slots=True)
class FileIn:
    """``file "liver.stl" in mm``: a file whose numbers have no unit, and their unit."""

    dimension: Dimension


@dataclass(frozen=True, slots=True)
class LocatedFile:
    """A file that a scene names.

    Attributes:
        name: As it was written.
        path: Where it was found.
        factor: SI units in the unit of its numbers.
        span: The entry.
    """

    name: str
    path: Path
    factor: float
    span: Span | None = None


Segment = tuple[NDArray[np.float64], NDArray[np.float64]]

Length = Annotated[float, Measure(units.LENGTH, above=0.0)]
Count = Annotated[int, Whole(at_least=1)]
InFile = Annotated[LocatedFile, FileIn(units.LENGTH)]
Position = Annotated[NDArray[np.float64], Point(units.LENGTH)]
Points = Annotated[Segment, FromTo(units.LENGTH)]

LengthIfAny = Annotated[float | None, Measure(units.LENGTH, above=0.0)]
PositionIfAny = Annotated[NDArray[np.float64] | None, Point(units.LENGTH)]
PointsIfAny = Annotated[Segment | None, FromTo(units.LENGTH)]
