"""Hedges: "very", "slightly" and their like.

A :class:`Shift` moves a word along its scale, so that it works in conditions, conclusions and
facts alike. Let p be the middle of the word's core and f the fraction. The target t is the
nearer end of the range ("outward") or its middle ("inward"), and the middle of the core always
becomes exactly p + f (t - p). A word in the middle of the range has no nearer end
and stays. In full, with "inner" for the side that faces the middle of the range:

- the core: every point x moves to x + f (t - x); a core that touches an end keeps touching it
  when it moves outward, and leaves it when it moves inward;
- the inner flank moves with the inner end of the core and keeps its slope; what would leave
  the range is cut off;
- the outer flank, outward: every point moves by the same fraction of its own way to the end;
- the outer flank, inward: the outer foot stays and the flank stretches. The outer foot of a
  word that is still true at the end of the range is that end.

Each piece is an increasing map of the axis, so that points keep their order; middles of words
keep theirs because they move by one fraction towards one target on either side.

A :class:`PowerHedge` raises degrees to a power (concentration and dilation: L. A. Zadeh, J.
Cybernetics 2(3):4, 1972). It moves no peak, and leaves the centre of a symmetric triangle where
it was: only conditions may use it.
"""

from collections.abc import Sequence
from typing import Literal, TypeAlias

from msgspec import Struct

from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import AnyShape, Gaussian, Piecewise, Powered, Shape, points

_CENTRED = 1e-9  # of the range; closer to a target than this is on it, up to rounding


class Shift(Struct, frozen=True):
    """Move a word along its scale by a fraction of its way to an end or to the middle."""

    fraction: float
    direction: Literal["outward", "inward"]

    def __post_init__(self) -> None:
        if not 0.0 < self.fraction < 1.0:
            raise ValueError("a shift must be above 0 % and below 100 %")
        if self.direction not in ("outward", "inward"):
            raise ValueError("a shift is either outward or inward")


class PowerHedge(Struct, frozen=True):
    """Raise every degree to a power."""

    exponent: float

    def __post_init__(self) -> None:
        if not 0.0 < self.exponent < float("inf"):
            raise ValueError("a power must be above zero and finite")


Hedge: TypeAlias = Shift | PowerHedge


def hedged(hedges: Sequence[Hedge], shape: AnyShape, axis: Axis) -> AnyShape:
    """Return a word's set under hedges in written order: the last one acts first.

    Args:
        hedges: The hedges in their order before the word.
        shape: The set of the word, in the coordinate of ``axis``.
        axis: The range on which the word lives.
    """
    for hedge in reversed(hedges):
        shape = _apply(hedge, shape, axis)
    return shape


def has_effect(hedge: Hedge, shape: AnyShape, axis: Axis) -> bool:
    """Return whether a hedge changes the degrees of a set anywhere.

    Args:
        shape: The set.
        axis: Range of its scale.
    """
    if isinstance(hedge, Shift):
        return moves(hedge, shape, axis)
    sharp = isinstance(shape, Piecewise) and _is_sharp(shape)
    return hedge.exponent != 1.0 and not sharp


def moves(hedge: Hedge, shape: AnyShape, axis: Axis) -> bool:
    """Return whether a hedge changes the value of a word that is given as a fact.

    Args:
        shape: The set of the word.
        axis: Range of its scale.
    """
    return isinstance(hedge, Shift) and _target(hedge, shape.middle, axis) is not None


def _apply(hedge: Hedge, shape: AnyShape, axis: Axis) -> AnyShape:
    if isinstance(hedge, PowerHedge):
        base, exponent = _split(shape)
        return Powered(base, exponent * hedge.exponent)
    if isinstance(shape, Powered):
        return Powered(_shifted(hedge, shape.base, axis), shape.exponent)
    return _shifted(hedge, shape, axis)


def _split(shape: AnyShape) -> tuple[Shape, float]:
    return (shape.base, shape.exponent) if isinstance(shape, Powered) else (shape, 1.0)


def _is_sharp(shape: Piecewise) -> bool:
    """Return whether every degree is 0 or 1, so that no power changes it."""
    flat = all(
        a == b or x0 == x1
        for x0, a, x1, b in zip(shape.xs, shape.ys, shape.xs[1:], shape.ys[1:], strict=False)
    )
    return flat and set(shape.ys) <= {0.0, 1.0}


def _target(shift: Shift, middle: float, axis: Axis) -> float | None:
    """Return where the shift pulls a word to, or None if the word is there or has no side."""
    low, high = axis.bounds
    end = nearer_end(middle, axis)
    if end is None:
        return None
    target = low + (high - low) / 2 if shift.direction == "inward" else end
    return None if abs(target - middle) <= _CENTRED * (high - low) else target


def nearer_end(middle: float, axis: Axis) -> float | None:
    """Return the end of the range that is nearer to a place, or None in the middle."""
    low, high = axis.bounds
    centre = low + (high - low) / 2
    if abs(middle - centre) <= _CENTRED * (high - low):
        return None
    return high if middle > centre else low


def _shifted(shift: Shift, shape: Shape, axis: Axis) -> Shape:
    target = _target(shift, shape.middle, axis)
    if target is None:
        return shape
    if isinstance(shape, Gaussian):
        moved = shape.mean + shift.fraction * (target - shape.mean)
        return Gaussian(moved, shape.sigma)
    low, high = axis.bounds
    move = _outward if shift.direction == "outward" else _inward
    if shape.middle > low + (high - low) / 2:
        return _ordered(move(shape, shift.fraction, target), low, high)
    # The low side is the mirror image of the high side.
    moved = _ordered(move(_mirrored(shape), shift.fraction, -target), -high, -low)
    return _mirrored(moved)


def _outward(shape: Piecewise, fraction: float, end: float) -> list[tuple[float, float]]:
    """Move a word of the upper half towards the upper end of the range."""
    inner = shape.core[0]

    def moved(x: float) -> float:
        return x + fraction * (end - max(x, inner))

    return [(moved(x), y) for x, y in _pairs(shape)]


def _inward(shape: Piecewise, fraction: float, centre: float) -> list[tuple[float, float]]:
    """Move a word of the upper half towards the middle of the range."""
    inner, outer = shape.core
    foot = shape.support[1]
    moved_outer = outer + fraction * (centre - outer)

    def moved(x: float) -> float:
        if x <= outer:
            return x + fraction * (centre - max(x, inner))
        if x < foot:
            return moved_outer + (x - outer) * ((foot - moved_outer) / (foot - outer))
        return x

    pairs = _pairs(shape)
    if foot > outer:
        return [(moved(x), y) for x, y in pairs]
    # The core ends in a vertical edge, or at the end of the range: the edge becomes a slope.
    top = max(shape.ys)
    through_core = [(moved(x), y) for x, y in pairs if x < outer or (x == outer and y == top)]
    return [*through_core, (foot, 0.0)]


def _pairs(shape: Piecewise) -> list[tuple[float, float]]:
    return list(zip(shape.xs, shape.ys, strict=True))


def _mirrored(shape: Piecewise) -> Piecewise:
    return Piecewise(tuple(-x for x in reversed(shape.xs)), tuple(reversed(shape.ys)))


def _ordered(pairs: list[tuple[float, float]], low: float, high: float) -> Piecewise:
    """Return the set through moved points, in the range; rounding must not swap neighbours."""
    ordered: list[tuple[float, float]] = []
    for x, y in pairs:
        ordered.append((max(x, ordered[-1][0]) if ordered else x, y))
    return points(ordered).within(low, high)
