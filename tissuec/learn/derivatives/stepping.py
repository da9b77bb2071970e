"""Steps with derivatives: forwards, backwards, and with many changes at once.

A member steps a leg over rows of times. Every one of its methods gives exactly the derivative
of what ``run`` computes, discretisation included.
"""

from collections.abc import Iterator
from math import inf
from typing import NamedTuple, Protocol, cast

from msgspec import Struct

from tissuec.compiled.calls import raise_failure
from tissuec.compiled.record_tables import RecordTable, tabulated
from tissuec.forces.fields import Field
from tissuec.kernels.derivative_records import (
    Forces,
    NodeState,
    NodeStates,
    Seeds,
    Values,
)
from tissuec.learn.derivatives.event_schedule import Leg, acting_fields
from tissuec.model.network import Floats, Indices


class StepStates(NamedTuple):
    """States at some times of a leg.

    Attributes:
        times: [s], shape (row,).
        states: There; accelerations are those that steps begin with, if the method carries them
            on from one step to the next.
    """

    times: Floats
    states: NodeStates

    @property
    def last(self) -> NodeState:
        """Return a copy of the last row."""
        return NodeState(*(part[-1].copy() for part in self.states))


class LegForces(Struct, frozen=True, eq=False):
    """Everything that acts on a leg, with present numbers; springs are among ``fields``."""

    leg: Leg
    forces: Forces
    fields: tuple[Field, ...] = ()

    @property
    def reach(self) -> float:
        """Return how far nodes may be from where this was made [m]."""
        return min((field.reach for field in self.fields), default=inf)

    def raise_failures(self) -> None:
        """Raise the error of a loop of a field that runs as Python, if there was one."""
        for table in cast("tuple[RecordTable, ...]", self.forces.fields.kept):
            raise_failure(table)


def act_on(leg: Leg, values: Values, x: Floats, reach: float | None = None) -> LegForces:
    """Return everything that acts on a leg, while nodes are near some places.

    Args:
        values: Numbers in SI units as they are on this leg, shapes as in ``Values``.
        x: The places [m], shape (3 node,).
        reach: How far nodes may be from there [m]; None: as far as suits fields.
    """
    springs, others = leg.acting.with_numbers(values)
    fields: tuple[Field, ...] = (*springs, *others.values())
    if reach is not None:
        fields = tuple(field.within(reach) for field in fields)
    forces = Forces(leg.links(values), acting_fields(leg, fields, x, leg.guides))
    return LegForces(leg, tabulated(forces), fields)


class Stepping(Protocol):
    """A method of integration.

    Attributes:
        lands: Whether its steps are so large that they must end where one looks.
    """

    name: str
    lands: bool

    def begin(self, act: LegForces, x: Floats, v: Floats) -> Floats:
        """Return the accelerations at the beginning of a leg [m/s²], shape (3 node,)."""
        ...

    def begin_back(self, act: LegForces, start: NodeState, due: NodeState, by: Values) -> None:
        """Add the derivatives by the result of ``begin`` to those by the state."""
        ...

    def begin_change(
        self, act: LegForces, start: NodeState, seeds: Seeds, change: NodeState
    ) -> None:
        """Set the changes of the result of ``begin``."""
        ...

    def run(self, act: LegForces, times: Floats, state: NodeState) -> StepStates:
        """Return the states at some times, the first of which is given."""
        ...

    def back(
        self,
        act: LegForces,
        trail: StepStates,
        entering: NodeStates,
        due: NodeState,
        by: Values,
    ) -> None:
        """Convert derivatives by the last row of a trail to those by its first row.

        Args:
            entering: Derivatives that enter in each row, shape (row, 3 node); those of the
                first row are ignored.
            due: Derivatives by the last row, in addition to these.
            by: Derivatives by numbers; added to.
        """
        ...

    def change(
        self, act: LegForces, trail: StepStates, seeds: Seeds, change: NodeState, rows: Indices
    ) -> Iterator[None]:
        """Carry changes from the first row on; yield at some rows.

        Args:
            seeds: Changes of the numbers.
            change: Of the first row, shape (3 node change,); set again.
            rows: Ascending numbers of rows after the first one, shape (n,).
        """
        ...
