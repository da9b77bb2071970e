"""Stepping that can be derived: forwards, backwards, and with many changes at once.

A member steps a leg over rows of times. Every one of its methods gives exactly the derivative
of what ``run`` computes, discretisation included.
"""

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple, Protocol

from msgspec import Struct

from tissuec.compiled.tables import RecordTable
from tissuec.kernels.sensitivity import Links, Seeds, Values
from tissuec.learn.course import Leg
from tissuec.network import Floats, Indices


class Trail(NamedTuple):
    """States at some times of a leg.

    Attributes:
        times: [s], shape (row,).
        x, v, a: Places, velocities and what the method calls accelerations there, shape
            (row, 3 node).
    """

    times: Floats
    x: Floats
    v: Floats
    a: Floats

    @property
    def last(self) -> "State":
        """Return copies of the last row."""
        return State(self.x[-1].copy(), self.v[-1].copy(), self.a[-1].copy())


class State(NamedTuple):
    """A state, or derivatives by one (shape (3 node,)), or its changes (…, change)."""

    x: Floats
    v: Floats
    a: Floats


class Act(Struct, frozen=True, eq=False, dict=True):
    """What holds on a leg for the numbers of the moment."""

    leg: Leg
    links: Links
    values: Values

    @cached_property
    def tables(self) -> tuple[RecordTable, RecordTable]:
        """Return links and values as compiled code reads them."""
        return RecordTable(self.links), RecordTable(self.values)


class Stepping(Protocol):
    """A method of integration.

    Attributes:
        lands: Whether its steps are so large that they must end where one looks.
    """

    name: str
    lands: bool

    def begin(self, act: Act, x: Floats, v: Floats) -> Floats:
        """Return the accelerations at the beginning of a leg, shape (3 node,)."""
        ...

    def begin_back(
        self, act: Act, x: Floats, v: Floats, a: Floats, due: State, by: Values
    ) -> tuple[Floats, Floats]:
        """Return derivatives by state from those by the state and the answer of ``begin``."""
        ...

    def begin_change(
        self, act: Act, x: Floats, v: Floats, a: Floats, seeds: Seeds, tx: Floats, tv: Floats
    ) -> Floats:
        """Return the changes of the answer of ``begin``, shape (3 node, change)."""
        ...

    def run(self, act: Act, times: Floats, state: State) -> Trail:
        """Return the states at equidistant times, the first of which is given."""
        ...

    def back(
        self, act: Act, trail: Trail, at_x: Floats, at_v: Floats, end: State, by: Values
    ) -> State:
        """Return the derivatives by the first row of a trail.

        Args:
            at_x, at_v: Derivatives that enter in each row, shape (row, 3 node); those of the
                first row are not looked at.
            end: Derivatives by the last row, beside these.
            by: Derivatives by numbers; added to.
        """
        ...

    def change(
        self, act: Act, trail: Trail, seeds: Seeds, change: State, rows: Indices
    ) -> Iterator[State]:
        """Yield the changes of some rows that follow from changes of the first row.

        Args:
            seeds: How numbers change.
            change: Of the first row, shape (3 node, change); may be overwritten.
            rows: Which ones, ascending, of those behind the first one.
        """
        ...
