"""Cells of an axis: parts on which the logic of its sets does not change.

What is true to a negligible degree counts as false.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from msgspec import Struct

from tissuec.fuzzy.axis import Axis
from tissuec.fuzzy.sets import NEGLIGIBLE, AnyShape

_HALF_TRUE = 0.5


class Cell(Struct, frozen=True):
    """A part of an axis on which every set is fully false, fully true, or between.

    Attributes:
        place: From and to, in the coordinate.
        states: 0, 0.5 or 1 for each set of the property.
    """

    place: tuple[float, float]
    states: tuple[float, ...]

    @property
    def width(self) -> float:
        """Return the length of the cell; 0 for a single coordinate."""
        return self.place[1] - self.place[0]


def cells(axis: Axis, shapes: Sequence[AnyShape], *, points: bool) -> list[Cell]:
    """Return one cell for each different combination of states, the widest there is.

    Args:
        axis: The range.
        shapes: The sets, in the coordinate of the axis.
        points: Whether to include cells that are a single coordinate, up to rounding.
    """
    widest: dict[tuple[float, ...], Cell] = {}
    for cell in _joined(_pieces(axis, shapes)):
        known = widest.get(cell.states)
        # Corners that differ by rounding are one corner, and no place between them has a width.
        if not points and cell.width <= axis.rounding:
            continue
        if known is None or cell.width > known.width:
            widest[cell.states] = cell
    return list(widest.values())


def _pieces(axis: Axis, shapes: Sequence[AnyShape]) -> Iterator[Cell]:
    """Yield corner, open interval, corner, … from the low to the high end of the range."""
    low, high = axis.bounds
    inside = (x for shape in shapes for x in shape.corners if low < x < high)
    places = sorted({low, high, *inside})
    for a, b in pairwise(places):
        yield Cell((a, a), _states(shapes, a))
        yield Cell((a, b), _states(shapes, a + (b - a) / 2))
    yield Cell((high, high), _states(shapes, high))


def _states(shapes: Sequence[AnyShape], x: float) -> tuple[float, ...]:
    degrees = [shape.degree(x) for shape in shapes]
    return tuple(0.0 if d < NEGLIGIBLE else 1.0 if d == 1.0 else _HALF_TRUE for d in degrees)


def _joined(pieces: Iterator[Cell]) -> Iterator[Cell]:
    """Join neighbours on which nothing changes."""
    current = next(pieces)
    for piece in pieces:
        if piece.states == current.states:
            current = Cell((current.place[0], piece.place[1]), current.states)
        else:
            yield current
            current = piece
    yield current
