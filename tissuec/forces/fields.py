"""Fields: effects that depend on the positions of nodes, each with a kernel of its own."""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.forces.effects import Effect
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile, tabulated

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from tissuec.forces.matrices import ForceDerivatives
    from tissuec.forces.memory import MemoryTangents

#: Time that a kernel takes for each number of its field, by measuring the shipped ones [s].
SECONDS = 5e-9
MATRIX = 100.0  # time of making a matrix, over that of an evaluation


class Items(NamedTuple):
    """Nodes on which the items of a field act, such as hinges or cells; each on at least one.

    Attributes:
        places: Indices of the nodes in the arrays of the kernel, item by item, shape (n,).
        first: Those of item i are places[first[i]:first[i + 1]], shape (item + 1,).
    """

    places: Indices
    first: Indices

    @classmethod
    def of(cls, nodes: Indices) -> "Items":
        """Return items that have equally many nodes each, of shape (item, node)."""
        count, width = nodes.shape
        return cls(nodes.ravel(), width * np.arange(count + 1))


class Field(Effect, frozen=True):
    """An effect that depends on the positions of nodes and has a kernel of its own."""

    @property
    @abstractmethod
    def kernel(self) -> Callable[..., None]:
        """Return the loops: a function of time, positions, velocities, forces, powers, a table.

        It adds forces [N] and the powers supplied from outside and dissipated [W].
        """

    @abstractmethod
    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> Any:
        """Return the record of arrays that the kernel reads.

        Args:
            place: Index of each node in the arrays of the kernel, shape (node,).
            acts: The sum of ``changes``, as the first component of its only act.
            position: Positions [m], shape (node, 3); the table is valid until a node has moved
                by more than ``reach``.
        """

    def items(self, place: Indices) -> Items | None:
        """Return the items that the kernel computes independently, for threads to share.

        None, the default, if one thread has to compute all of the field.

        Args:
            place: Index of each node in the arrays of the kernel, shape (node,).
        """
        return None

    def only(self, items: Indices) -> Self:
        """Return the field of some items, by indices of shape (n,), to make its table.

        Raises:
            NotImplementedError: It has no items.
        """
        raise NotImplementedError

    def moving(self, still: NDArray[np.bool_]) -> Self | None:
        """Return the field without items that have no effect on motion; None without any left.

        All nodes of these are still: they push nothing that moves, and no work is done on them.

        Args:
            still: Nodes that are held and do not follow a path, shape (node,).
        """
        remains = len(self.internal_rows) or len(self.changes)
        items = None if remains or not still.any() else self.items(np.arange(len(still)))
        if items is None or not len(items.places):
            return self
        idle = np.logical_and.reduceat(still[items.places], items.first[:-1])
        if not idle.any():
            return self
        return None if idle.all() else self.only(np.flatnonzero(~idle))

    def in_parts(self, table: Any, parts: int) -> list[list[Any]]:
        """Return tables that together make the kernel do the same to the last bit.

        They are in groups, one after the other; threads share the tables of a group. This is
        for a field without items that can be computed in parts nevertheless.

        Args:
            table: As made by ``table``.
            parts: How many keep the threads busy; 1 where there is a single thread.
        """
        return [[table]]

    @property
    def internal_rows(self) -> Indices:
        """Return rows of internal variables whose rates the kernel adds as forces, shape (n,).

        They are ascending.
        """
        return np.zeros(0, dtype=np.int64)

    @property
    def remembered(self) -> Indices:
        """Return rows of internal variables that the kernel reads, ascending, shape (n,)."""
        return self.internal_rows

    def read_rows(self, velocity: Floats, nodes: int) -> Floats:
        """Return velocities with the rows that the kernel reads, 0 where there are none.

        Args:
            velocity: In any unit, shape (…, row, 3).
            nodes: How many nodes there are.

        Returns:
            Of nodes, and of rows up to the last that is read, shape (…, n, 3).
        """
        rows = max(nodes, int(self.remembered.max(initial=-1)) + 1)
        lacks = rows - velocity.shape[-2]
        if lacks <= 0:
            return velocity[..., :rows, :]
        return np.concatenate([velocity, np.zeros((*velocity.shape[:-2], lacks, 3))], axis=-2)

    def giving(self, position: Floats, velocity: Floats) -> float:
        """Return a bound of the rates at which anything relaxes [1/s]."""
        return 0.0

    @property
    def unsolved(self) -> str:
        """The forces that ``memory_tangents`` lacks, such as "elements that yield"; or ""."""
        has_all = type(self).memory_tangents is not Field.memory_tangents
        return "" if has_all or not len(self.internal_rows) else "forces with memory"

    def memory_tangents(self, position: Floats, velocity: Floats) -> "MemoryTangents | None":
        """Return the derivatives of internal variables; None without any."""
        return None

    def let_relax(self, velocity: Floats, position: Floats, moved: NDArray[np.bool_]) -> None:
        """Make relaxation permanent in internal variables.

        Args:
            velocity: Of all nodes, followed by internal variables, changed in place [m/s],
                shape (node + row, 3).
            moved: Nodes whose items relax, shape (node,).
        """

    @property
    def reach(self) -> float:
        """Return how far nodes may move before the table must be made again [m]."""
        return inf

    def within(self, distance: float) -> Self:
        """Return the same with a table that holds until a node has moved by a distance [m].

        A field whose ``reach`` is infinite returns itself.
        """
        return self

    @property
    def changes(self) -> Sequence[tuple[float, TimeProfile]]:
        """Return the amounts that change in time, each with the profile that it follows."""
        return ()

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s].

        It is counted from array sizes instead of measured, so that runs are reproducible.
        """
        return SECONDS * self._numbers_kept

    @property
    def _numbers_kept(self) -> int:
        """Return how many numbers all arrays have."""
        parts = astuple(self)
        return sum(part.size for part in parts if isinstance(part, np.ndarray))

    @property
    def matrix_seconds(self) -> float:
        """Return an estimate of the time of making its matrix [s], as that of an evaluation."""
        return MATRIX * self.seconds

    @property
    def derivatives(self) -> "ForceDerivatives | str":
        """Return the exact derivatives, or why there are none, as the end of a sentence."""
        return "has no exact derivatives"

    def column(self, name: str) -> Floats | float:
        """Return a column that ``derivatives`` names, in SI units.

        It is a number, or has the shape (item, …).
        """
        return getattr(self, name)

    def with_columns(self, columns: Mapping[str, Any]) -> Self:
        """Return the field with other columns, by name, in SI units."""
        return replace(self, **columns)

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix] | None":
        """Return minus the derivatives of damping forces, None without any.

        They are by positions [N/m] and by velocities [N s/m], shape (3 size, 3 size) each.
        """
        return None

    def damping_derivatives(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix] | None":
        """Return ``damping_matrices`` without anything left out, for learning.

        They are by positions [N/m] and by velocities [N s/m], shape (3 size, 3 size) each.
        """
        return self.damping_matrices(position, velocity, number, size)

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the items that no longer act because they have lost a spring, ascending.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        return np.zeros(0, dtype=np.int64)

    def intact(self, alive: NDArray[np.bool_]) -> Self:
        """Return the field without what cuts and ruptures have taken from it.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        return self

    # --- what the kernel says of any state ------------------------------------------------

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        for state, forces, _ in self._evaluated(time, position, velocity):
            to[state] += forces

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2).

        What moves nodes on prescribed paths puts in more.
        """
        found = np.zeros((*position.shape[:-2], 2))
        for state, _, power in self._evaluated(time, position, velocity):
            found[state] = power
        return found

    def _evaluated(
        self, time: Floats | float, position: Floats, velocity: Floats
    ) -> Iterator[tuple[tuple[int, ...], Floats, Floats]]:
        """Yield the index of each state, with forces of shape (node, 3), and powers."""
        from tissuec.compiled.calls import kernel_on

        shape, nodes = position.shape[:-2], position.shape[-2]
        velocity = self.read_rows(velocity, nodes)
        place = np.arange(velocity.shape[-2], dtype=np.int64)
        more = len(place) - nodes
        times = np.broadcast_to(np.asarray(time, dtype=float), shape)
        states, times = list(np.ndindex(shape)), times.ravel()
        x, v = (in_line(each).astype(float) for each in (position, velocity))
        for part in stretches(x, self.reach):
            made, call = None, None
            for k in range(part.start, part.stop):
                if call is None or (self.changes and times[k] != made):
                    made = times[k]
                    table = self.table(place, acts_of(self.changes, made, made), x[part.start])
                    call = kernel_on(self.kernel, table)
                forces, power = np.zeros_like(v[k]), np.zeros(2)
                here = np.pad(x[k], ((0, more), (0, 0))) if more else x[k]
                call(times[k], here.reshape(-1), v[k].reshape(-1), forces.reshape(-1), power)
                yield states[k], forces[:nodes], power


class WalledField(Field, frozen=True):
    """A field with items that act only while all of their springs exist.

    Attributes:
        walls: Springs that items depend on.
        walled: The item of each of them, shape of ``walls``.
        at_once: Items whose matrices are in memory at a time.
    """

    at_once: ClassVar[int] = 4096
    walls: Indices
    walled: Indices

    @property
    @abstractmethod
    def item_count(self) -> int:
        """Return the number of items."""

    def in_blocks(self) -> Iterator[tuple[Indices, Self]]:
        """Yield the items a block at a time, with their numbers, shape (n,)."""
        for first in range(0, self.item_count, self.at_once):
            part = np.arange(first, min(first + self.at_once, self.item_count))
            yield part, self.only(part)

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the items that have lost a spring, ascending; ``alive`` as in ``Field``."""
        return np.unique(self.walled[~alive[self.walls]])

    def lost_walls(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the springs that items have lost, shape (n,); ``alive`` as in ``Field``."""
        return self.walls[~alive[self.walls]]

    def intact(self, alive: NDArray[np.bool_]) -> Self:
        """Return the items that have all their springs; ``alive`` as in ``Field``."""
        lost = self.lost_items(alive)
        return self.without(lost) if len(lost) else self

    def without(self, items: Indices) -> Self:
        """Return the field without some items, given by indices of shape (n,)."""
        stays = np.ones(self.item_count, dtype=bool)
        stays[items] = False
        walls = stays[self.walled]
        walled = (np.cumsum(stays) - 1)[self.walled[walls]]
        return replace(self.only(np.flatnonzero(stays)), walls=self.walls[walls], walled=walled)


def in_line(states: Floats) -> Floats:
    """Return states of shape (…, node, 3), in any unit, in the shape (state, node, 3)."""
    return states.reshape(-1, *states.shape[-2:])


def stretches(position: Floats, reach: float) -> Iterator[slice]:
    """Yield slices of states in which no node is further than ``reach`` from the first state.

    Args:
        position: Of all nodes [m], shape (state, node, 3).
        reach: Largest distance [m].
    """
    start = 0
    for k in range(1, len(position)):
        gone = np.square(position[k] - position[start]).sum(axis=-1).max(initial=0.0)
        if not gone <= reach * reach:
            yield slice(start, k)
            start = k
    if len(position):
        yield slice(start, len(position))


def acts_of(
    changes: Sequence[tuple[float, TimeProfile]], start: float, until: float
) -> BoundaryConditions:
    """Return amounts times profiles as tables, as the first component of one act on no node.

    Args:
        changes: Amounts, and the profile that each of them follows.
        start: Start of the interval that the tables cover [s].
        until: End of the interval, without a knot of a profile inside [s].
    """
    count, none = len(changes), np.zeros(0, dtype=np.int64)
    vector = np.zeros((count, 3))
    vector[:, 0] = [amount for amount, _ in changes]
    return BoundaryConditions(
        motions=0,
        first=np.zeros(2, dtype=np.int64),
        nodes=none,
        base=np.zeros((0, 3)),
        partial=np.zeros(1, dtype=np.int64),
        along=np.zeros((0, 9)),
        share=np.zeros(0),
        term_first=np.array([0, count], dtype=np.int64),
        term_vector=vector,
        term_curve=np.arange(count, dtype=np.int64),
        turn_curve=np.full(1, -1),
        turn_centre=np.zeros((1, 3)),
        turn_axis=np.zeros((1, 3)),
        turn_angle=np.zeros(1),
        **tabulated([profile for _, profile in changes], start, until),
    )
