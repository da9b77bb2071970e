"""Quantities that conditions measure, and how they are described in messages."""

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.units import Dimension, parse_unit, show, show_in
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.lang.words import STEPS
from tissuec.model.network import Floats
from tissuec.scene.reading.expressions import InnerScope, Scope, Truth
from tissuec.scene.reading.values import Value
from tissuec.script.measures import Measure, Subject
from tissuec.script.measures.common import DirectedMeasure
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.plan import ComparedPair

Place = tuple[int, int]  # where a node of a condition begins and ends in its text
DIGITS = 8  # of measured values in messages: enough to see why "==" does not hold


class ObservedMeasure(Struct, frozen=True, eq=False):
    """One measure as a condition uses it.

    Attributes:
        time: Of an earlier snapshot [s]; None for the present one.
        along: Unit vector along which a part is taken; None for the whole size.
    """

    measure: type[Measure]
    subjects: tuple[Subject, ...]
    time: float | None
    along: Floats | None

    @property
    def needs_ledger(self) -> bool:
        """Return whether it needs the energy ledger of a run."""
        return getattr(self.measure, "needs_ledger", False)

    def value(self, snapshot: Snapshot) -> Floats:
        """Return the number in SI units, shape (…) as the snapshot."""
        then = snapshot if self.time is None else snapshot.pinned[self.time]
        sample = self.measure.sample(self.subjects, then)
        if self.along is None:
            return self.measure.value(sample)
        assert issubclass(self.measure, DirectedMeasure)
        return self.measure.along(sample, self.along)


def place_of(node: s.Expression) -> Place:
    """Return the place of a node in its condition, the same in copies of the condition."""
    return node.span.start, node.span.end


class MeasureScope(InnerScope):
    """A scope of measures.

    Without a snapshot every measure has the value 1, so that units and names can be checked.

    Attributes:
        comparisons: What ``decide`` has compared, in the order of the text.
    """

    is_known = False

    def __init__(
        self,
        readings: Mapping[Place, ObservedMeasure],
        constants: Scope,
        snapshot: Snapshot | None,
    ):
        super().__init__(constants)
        self.readings = readings
        self.snapshot = snapshot
        self.comparisons: list[ComparedPair] = []

    def name(self, name: s.Name) -> Value:
        measured = place_of(name) in self.readings
        return self._measured(name) if measured else self.constants.name(name)

    def has(self, name: s.Name) -> bool:
        return place_of(name) in self.readings or self.constants.has(name)

    def names(self) -> Sequence[str]:
        return self.constants.names()

    def call(self, call: s.Call) -> Value:
        return self._measured(call)

    def test(self, node: s.Expression) -> Truth:
        if isinstance(node, s.Call | s.Name):
            reading = self.readings.get(place_of(node))
            if reading is not None and getattr(reading.measure, "counts", False):
                count = self._measured(node)
                self.comparisons.append(ComparedPair("!=", count.amount, count.dimension))
                return np.asarray(count.amount != 0.0)
        return super().test(node)

    def _compared(self, left: Value, sign: str, right: Value) -> Truth:
        gap = left.amount - right.amount
        self.comparisons.append(ComparedPair(sign, gap, left.dimension))
        return super()._compared(left, sign, right)

    def _measured(self, node: s.Call | s.Name) -> Value:
        reading = self.readings[place_of(node)]
        value = 1.0 if self.snapshot is None else reading.value(self.snapshot)
        return Value.number(value, reading.measure.dimension)


class CompiledCondition(Struct, frozen=True, eq=False):
    """A condition as a function of a snapshot."""

    condition: s.Expression
    readings: Mapping[Place, ObservedMeasure]
    constants: Scope

    def __call__(self, snapshot: Snapshot) -> bool:
        """Return whether the condition holds."""
        return bool(self.holds(snapshot))

    def holds(self, snapshots: Snapshot) -> NDArray[np.bool_]:
        """Return when the condition holds, shape (…) as a batch of snapshots."""
        return np.asarray(self._at(snapshots).decide(self.condition))

    def margin(self, snapshots: Snapshot) -> Floats | None:
        """Return how far a comparison is from being true, in the unit of its sides.

        It has the shape (…) as a batch of snapshots. It is None of conditions of several parts,
        and of those that compare nothing.
        """
        match self.condition:
            case s.Compare(sign=">" | ">="):
                return -self.weighed(snapshots)[1][..., 0]
            case s.Compare(sign="<" | "<="):
                return self.weighed(snapshots)[1][..., 0]
            case _:
                return None

    @property
    def comparisons(self) -> tuple[ComparedPair, ...]:
        """Return its comparisons, without the gaps of a run."""
        scope = MeasureScope(self.readings, self.constants, None)
        scope.decide(self.condition)
        return tuple(scope.comparisons)

    @property
    def needs_ledger(self) -> bool:
        """Return whether it needs the energy ledger of a run."""
        return any(reading.needs_ledger for reading in self.readings.values())

    def weighed(self, snapshots: Snapshot) -> tuple[NDArray[np.bool_], Floats]:
        """Return when the condition holds, and by how much each of its comparisons does.

        Returns:
            Shape (…) as a batch of snapshots, and the gaps of ``comparisons`` in SI units,
            shape (…, comparison).
        """
        scope = self._at(snapshots)
        holds = np.asarray(scope.decide(self.condition))
        gaps = [np.broadcast_to(one.gap, np.shape(snapshots.time)) for one in scope.comparisons]
        return holds, np.stack(gaps, axis=-1)

    def possible(self, gaps: Floats, errors: Floats) -> "Possible":
        """Return when the condition may hold, and when it may fail.

        Args:
            gaps: Of ``weighed``, shape (row, comparison).
            errors: By how much each gap may be wrong, in SI units, shape (comparison,).
        """
        bounds = zip(self.comparisons, gaps.T, errors, strict=True)
        found = (_possible(one.sign, gap, error) for one, gap, error in bounds)
        return _combined(self.condition, found)

    def describe(self, snapshot: Snapshot, *, digits: int = DIGITS) -> str:
        """Return a description of the measured value, with so many significant digits."""
        return describe_sides(self.condition, self._at(snapshot), digits=digits)

    def _at(self, snapshot: Snapshot) -> MeasureScope:
        return MeasureScope(self.readings, self.constants, snapshot)


class Possible(NamedTuple):
    """When a condition may hold and when it may fail, shape (row,) each."""

    holds: NDArray[np.bool_]
    fails: NDArray[np.bool_]

    @property
    def negated(self) -> "Possible":
        """Return the same of the opposite condition."""
        return Possible(self.fails, self.holds)


def _possible(sign: str, gap: Floats, error: float) -> Possible:
    """Return where a comparison may hold and may fail, if its gap is off by an error."""
    low, high = gap - error, gap + error
    match sign:
        case "<":
            return Possible(low < 0.0, high >= 0.0)
        case "<=":
            return Possible(low <= 0.0, high > 0.0)
        case ">":
            return Possible(high > 0.0, low <= 0.0)
        case ">=":
            return Possible(high >= 0.0, low < 0.0)
        case _:
            equal = Possible((low <= 0.0) & (high >= 0.0), (gap != 0.0) | (error > 0.0))
            return equal if sign == "==" else equal.negated


def _combined(node: s.Expression, found: Iterator[Possible]) -> Possible:
    """Return where a condition may hold and may fail, from its comparisons in text order."""
    match node:
        case s.And(operands=operands):
            return _all([_combined(operand, found) for operand in operands])
        case s.Or(operands=operands):
            return _all([_combined(operand, found).negated for operand in operands]).negated
        case s.Not(operand=operand):
            return _combined(operand, found).negated
        case s.Between():
            return _all([next(found), next(found)])
        case _:
            return next(found)


def _all(parts: Sequence[Possible]) -> Possible:
    """Return where several conditions together may hold and may fail."""
    return Possible(
        reduce(np.logical_and, (part.holds for part in parts)),
        reduce(np.logical_or, (part.fails for part in parts)),
    )


def describe_sides(condition: s.Expression, scope: Scope, *, digits: int = DIGITS) -> str:
    """Return the values of both sides of a condition: ``gap(ovary) = 8.1 mm, limit = 9 mm``."""
    parts: list[str] = []
    units = {parse_unit(one.unit).dimension: one.unit for one in _amounts(condition)}
    for side in _sides(condition):
        value = scope.number(side)
        shown = _shown(float(value.amount), value.dimension, units, digits)
        parts.append(f"{side.span.one_line} = {shown}")
    return ", ".join(parts)


def _amounts(condition: s.Expression) -> Iterator[s.Quantity]:
    """Yield the numbers with units in a condition, but for those in its calls."""
    parts = walk(condition, enters=lambda call: False)
    return (part for part in parts if isinstance(part, s.Quantity) and part.unit != STEPS)


def _shown(
    value: float, dimension: Dimension, units: Mapping[Dimension, str], digits: int
) -> str:
    """Return a value in the unit of the numbers of its dimension beside it, if there is any."""
    if dimension in units:
        return show_in(value, units[dimension], digits=digits)
    return show(value, dimension, digits=digits)


def _sides(node: s.Expression) -> list[s.Expression]:
    """Return the sides of all comparisons in a condition, except literal numbers."""
    match node:
        case s.Compare(left=left, right=right):
            sides = [left, right]
        case s.Between(subject=subject, low=low, high=high):
            sides = [subject, low, high]
        case s.Not(operand=operand):
            sides = _sides(operand)
        case s.And(operands=operands) | s.Or(operands=operands):
            sides = [side for operand in operands for side in _sides(operand)]
        case _:
            sides = [node]
    return [side for side in sides if not isinstance(side, s.Number | s.Quantity)]
