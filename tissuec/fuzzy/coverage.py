"""Finds combinations of facts that leave a quantity without a firing rule.

Whether a rule fires depends only on which of its words are fully false, fully true, or between;
all conjunctions and disjunctions on offer agree about that. Between two corners of the sets
none of these changes, so that finitely many cells represent every combination of facts.

Cells of an axis are parts on which the logic of its sets does not change. What is true to a
negligible degree counts as false.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from msgspec import Struct

from tissuec.fuzzy.rulebase import RuleBase
from tissuec.fuzzy.rules import Operators, Rule, atoms, degree
from tissuec.fuzzy.scale import Axis
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


_LOGIC = Operators()  # minimum and maximum keep 0, 0.5 and 1 apart


class Coverage(Struct, frozen=True):
    """Whether some combination of facts leaves a quantity without a rule.

    Attributes:
        quantity: The quantity.
        checked: False if the search was given up because there are too many combinations.
        hole: Values of properties, from and to (equal for a single value), between which no
            rule fires wherever the facts lie; None if there is no such place, or none was
            found. Properties that are not named may have any value.
    """

    quantity: str
    checked: bool
    hole: Mapping[str, tuple[float, float]] | None


def coverage(base: RuleBase, quantity: str, *, limit: int = 100_000) -> Coverage:
    """Return whether some combination of facts leaves a quantity without a firing rule.

    Every property is taken to have a fact. Places with a width are sought first, then single
    values, such as the point where two triangles touch.

    Args:
        quantity: Name of the quantity.
        limit: How many partial combinations to try before giving up.

    Raises:
        ValueError: The rules have no such quantity.
    """
    if quantity not in base.quantities:
        raise ValueError(f'"{quantity}" is not a quantity of these rules')
    about = [r for r in base.rules if any(c.quantity == quantity for c in r.conclusions)]
    search = _Search(base, about, limit)
    try:
        hole = search.hole(points=False)
        if hole is None:
            hole = search.hole(points=True)
    except _TooMany:
        return Coverage(quantity, checked=False, hole=None)
    return Coverage(quantity, checked=True, hole=hole)


class _TooMany(Exception):
    """The search tried as many combinations as it may."""


class _Search:
    """Depth-first search, property by property, for facts under which no rule fires."""

    def __init__(self, base: RuleBase, rules: Sequence[Rule], limit: int):
        self.base, self.axes = base, base.properties
        self.left = limit
        self.order = _by_use(rules)
        self.shapes = {name: _shapes(name, rules) for name in self.order}
        self.decided = {name: _decided_by(name, rules, self.order) for name in self.order}

    def hole(self, *, points: bool) -> dict[str, tuple[float, float]] | None:
        """Return a place where no rule fires, or None; ``points`` admits single values."""
        choices = [
            cells(self.axes[name], self.shapes[name], points=points) for name in self.order
        ]
        found = self._extend({}, choices)
        return None if found is None else {n: self._values(n, c) for n, c in found.items()}

    def _extend(
        self, chosen: dict[str, Cell], choices: Sequence[Sequence[Cell]]
    ) -> dict[str, Cell] | None:
        if len(chosen) == len(self.order):
            return chosen
        name = self.order[len(chosen)]
        for cell in choices[len(chosen)]:
            if self.left == 0:
                raise _TooMany
            self.left -= 1
            extended = {**chosen, name: cell}
            if any(self._fires(rule, extended) for rule in self.decided[name]):
                continue
            found = self._extend(extended, choices)
            if found is not None:
                return found
        return None

    def _fires(self, rule: Rule, chosen: Mapping[str, Cell]) -> bool:
        states = (
            chosen[part.property].states[self.shapes[part.property].index(part.word.shape)]
            for part in atoms(rule.condition)
        )
        return degree(rule.condition, states, _LOGIC) > 0.0

    def _values(self, name: str, cell: Cell) -> tuple[float, float]:
        start, end = cell.place
        return self.base.value_at(name, start), self.base.value_at(name, end)


def _names(rule: Rule) -> set[str]:
    return {part.property for part in atoms(rule.condition)}


def _by_use(rules: Sequence[Rule]) -> list[str]:
    """Return properties, those of many rules first: a rule that fires ends a branch early."""
    names = [name for rule in rules for name in _names(rule)]
    return sorted(set(names), key=lambda name: (-names.count(name), name))


def _decided_by(name: str, rules: Sequence[Rule], order: Sequence[str]) -> list[Rule]:
    """Return the rules whose last property, in the order of choice, is ``name``."""
    return [rule for rule in rules if max(_names(rule), key=order.index) == name]


def _shapes(name: str, rules: Sequence[Rule]) -> list[AnyShape]:
    """Return the different sets that conditions use of one property."""
    parts = (part for rule in rules for part in atoms(rule.condition))
    return list(dict.fromkeys(part.word.shape for part in parts if part.property == name))
