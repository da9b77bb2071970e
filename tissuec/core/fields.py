"""Types that say how an entry is written; a class of them is a schema of the language.

The compiler reads a member's fields (name, type, default, "Attributes:" line of the docstring)
and from them checks entries, converts units, suggests near misses and writes the reference. An
underscore in a field name is a blank in the language.
"""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.source import Span
from tissuec.core.units import Dimension


class Real(Struct, frozen=True):
    """A number with a dimension.

    Attributes:
        above, at_least, at_most: Limits in SI units.
        example: A usual amount, such as "20 kPa/m", for hints; by default one of its units.
        by_axis: Whether it can also be three numbers along x, y and z, ``(4, 4, 1) mm``, whose
            value is an array of shape (3,).
    """

    dimension: Dimension
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    example: str = ""
    by_axis: bool = False


class Whole(Struct, frozen=True):
    """A whole number with limits."""

    at_least: int = 1
    at_most: int = 100_000_000


class OneOf(Struct, frozen=True):
    """One of a few words, written with ``is``.

    Attributes:
        words: The words; a mapping has what each means, as a sentence or in its docstring.
        opens: Whether a word may be followed by a block, which is read separately.
        inside: Classes whose fields are the entries of that block, by the word before it.
    """

    words: Collection[str]
    opens: bool = False
    inside: Mapping[str, type] = {}


class Point(Struct, frozen=True):
    """A vector of three components with a dimension."""

    dimension: Dimension


class FromTo(Struct, frozen=True):
    """``axis from (…) to (…)``: two points.

    Attributes:
        may_bend: Whether it can also be ``axis through [(…), (…), (…)]``: points of a curve.
    """

    dimension: Dimension
    may_bend: bool = False


class Several(Struct, frozen=True):
    """A list of numbers with a dimension, written ``[1 mm, 2 mm]``."""

    dimension: Dimension
    at_least: int = 1


class FileIn(Struct, frozen=True):
    """``file "liver.stl" in mm``: a file whose numbers have no unit, and their unit."""

    dimension: Dimension


class Named(Struct, frozen=True):
    """``part "left lobe"``: a name in quotes.

    Attributes:
        example: A name as it could be written.
    """

    example: str


class LocatedFile(Struct, frozen=True):
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


class UnfitEntries(ValueError):
    """Entries of a member that are right one by one do not fit together.

    Attributes:
        hint: A way out.
    """

    def __init__(self, message: str, hint: str):
        self.hint = hint
        super().__init__(message)


Segment = tuple[NDArray[np.float64], NDArray[np.float64]]

Length = Annotated[float, Real(units.LENGTH, above=0.0)]
Count = Annotated[int, Whole(at_least=1)]
InFile = Annotated[LocatedFile, FileIn(units.LENGTH)]
Position = Annotated[NDArray[np.float64], Point(units.LENGTH)]
Points = Annotated[Segment, FromTo(units.LENGTH)]

#: Two ends of a line, or points of a curve.
Axis = Annotated[Sequence[NDArray[np.float64]], FromTo(units.LENGTH, may_bend=True)]

LengthIfAny = Annotated[float | None, Real(units.LENGTH, above=0.0)]

#: One length, or three along x, y and z.
Lengths = Annotated[float | NDArray[np.float64], Real(units.LENGTH, above=0.0, by_axis=True)]
LengthsIfAny = Annotated[
    float | NDArray[np.float64] | None, Real(units.LENGTH, above=0.0, by_axis=True)
]
PositionIfAny = Annotated[NDArray[np.float64] | None, Point(units.LENGTH)]
PointsIfAny = Annotated[Segment | None, FromTo(units.LENGTH)]
DirectionIfAny = Annotated[NDArray[np.float64] | None, Point(units.NUMBER)]
