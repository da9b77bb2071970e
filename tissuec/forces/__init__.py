"""Forces, one file for each effect.

Each file holds the parameters of one effect, its loops over nodes or springs, its energy and
its stiffness matrix; long loops have a file of their own, whose name ends in ``kernel``, and
the derivatives that learning needs one that ends in ``derivatives_kernel``.
Springs come first, with their laws and viscoelastic branches. Every other force is an
``Effect``: ``Nodal`` if it acts on each node independently (weight, drag, loads), ``Field`` if
it depends on positions (volumes, bending, contact, jets, foundations). Fields are the blocks
of a net beside its springs, each under a name and a kind (``model.blocks``).
``mechanics.state`` collects them and ``accelerations`` sums them. ``FORCES`` registers the
kinds that a ``force`` block can name.

Shared arguments:
    time: Time [s].
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    a: Accelerations of all nodes [m/s²], flat, shape (3 node,).
    f: Forces on all nodes [N], flat, shape (3 node,); a kernel adds to them.
    power: Power supplied from outside and power dissipated [W], shape (2,); a kernel adds to
        them.
    part, parts: Index of this thread's share of the loop, and the number of shares.
    net: Record of the network; its fields give the shapes and units.
    weight, by_x, by_v, dx, dv, df, room: Of derivatives, see ``forces.matrices``; shapes
        (3 node,), (3 node change,) and (change,), in any unit.
"""

from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from msgspec import Struct, StructMeta
from msgspec.structs import astuple, replace
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.core.units import Dimension
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile, tabulated

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

    from tissuec.forces.element_limits import BreakableElements
    from tissuec.forces.load import Load
    from tissuec.forces.matrices import ForceDerivatives
    from tissuec.forces.memory import MemoryTangents
    from tissuec.forces.triangles import SkinTriangles

#: Time that a kernel takes for each number of its field, by measuring the shipped ones [s].
SECONDS = 5e-9
MATRIX = 400.0  # time of making a matrix, over that of an evaluation

#: Adds an operator applied to a vector to another one, both of shape (node, 3).
Resisting = Callable[[Floats, Floats], None]


class AbstractStruct(StructMeta, ABCMeta):
    """The class of a ``Struct`` that leaves functions to its members."""


class Effect(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """An effect on nodes; arrays are in the order of nodes of the scene.

    Shared arguments:
        time: Time [s], shape (…) or a number.
        position: Of all nodes [m], shape (…, node, 3), or (node, 3) where the result is one
            number or matrix.
        velocity: Of all nodes [m/s], shape as ``position``.
        to: Forces on all nodes that are added to [N], shape (…, node, 3).
        number: Of each node among those that may move, -1 for others, shape (node,).
        size: Number of nodes that may move; matrices have the shape (3 size, 3 size).
        exact: Whether the matrix includes the parts that may make it indefinite.
    """

    @abstractmethod
    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""

    @abstractmethod
    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers supplied from outside and dissipated [W], shape (…, 2).

        The work of nodes on prescribed paths is not included.
        """

    @abstractmethod
    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""

    def potential(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy whose negative gradient is the force at rest [J], shape (…).

        It includes the potential of external loads. ``wayward`` returns the other forces.
        """
        return self.energy(time, position)

    def wayward(self, time: float, position: Floats) -> Floats | None:
        """Return the part of forces at rest that has no potential [N], shape (node, 3).

        None, the default, where there is never any.
        """
        return None

    @abstractmethod
    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return minus the derivative of the forces by positions [N/m], shape (3 size, 3 size).

        Without ``exact``, parts that may make the matrix indefinite are left out.
        """

    @property
    def loss(self) -> str:
        """Return why energy is not conserved, as the beginning of a sentence.

        Empty if it is, or is lost only through ``braking``.
        """
        return ""

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[coo_matrix, Floats]":
        """Return the matrix as S and W of S + W Wᵀ; S in [N/m], W in [(N/m)^½].

        W, of shape (3 size, column), contains the parts that couple many nodes at once and
        would fill S.
        """
        whole = self.matrix(time, position, number, size, exact=exact)
        return whole, np.zeros((3 * size, 0))

    @property
    def joining_springs(self) -> Indices:
        """Return the springs whose ends its items hold together, shape (n,); often none."""
        return np.zeros(0, dtype=np.int64)

    @property
    def breakable(self) -> "BreakableElements | None":
        """Return the elements that break at a limit; None without any."""
        return None

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which nodes this ties to anything outside their piece, shape (node,)."""
        return np.zeros(len(position), dtype=bool)

    @property
    def relaxed(self) -> Self:
        """Return the effect after all relaxation, without its branches."""
        return self

    def recalling(self, velocity: Floats) -> Self:
        """Return the same with an energy and a matrix that include what relaxes.

        They are those of a change that leaves no time to relax.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3); those of hidden ones tell how far
                this has relaxed.
        """
        return self

    # --- bounds, which members override where they know better ones -----------------------

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return a bound on how negative an eigenvalue of the matrix may be [N/m].

        This is Gershgorin's bound of the parts that only the exact matrix has.
        """
        whole, positive = (
            self.matrix(time, position, number, size, exact=exact) for exact in (True, False)
        )
        return float(np.asarray(abs(whole - positive).sum(axis=1)).max(initial=0.0))

    def stiffening(self, time: float, position: Floats) -> Resisting | None:
        """Return a bound of the stiffness, an operator on displacements [N/m], or None.

        It is diagonal: the sums of absolute values in the rows of the matrix.
        """
        rows = self._rows(time, position)

        def resist(moved: Floats, to: Floats) -> None:
            to += rows * moved

        return resist

    def braking(self, position: Floats) -> Resisting | None:
        """Return a bound of the damping, an operator on velocities [N s/m], or None."""
        return None

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of the absolute terms of the energy, to scale rounding errors [J]."""
        forces = np.zeros_like(position)
        self.add_forces(time, position, np.zeros_like(position), forces)
        return float(abs(self.energy(time, position)) + np.abs(forces * position).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the largest absolute term of the forces, a scale of rounding errors [N]."""
        return float((self._rows(time, position) * np.abs(position)).max(initial=0.0))

    def _rows(self, time: float, position: Floats) -> Floats:
        """Return the sums of the sizes in the rows of the matrix [N/m], shape (node, 3)."""
        count = len(position)
        matrix = abs(self.matrix(time, position, np.arange(count), count).tocsr())
        return np.asarray(matrix.sum(axis=1), dtype=float).reshape(-1, 3)


class Nodal(Effect, frozen=True):
    """An effect on each node that does not depend on the positions of other nodes.

    The engine evaluates these effects in its own loop over nodes. They count as applied from
    outside: what holds a node does not feel them.
    """

    @property
    def steady(self) -> Floats | None:
        """Return accelerations of free nodes that are always the same [m/s²], shape (3,)."""
        return None

    @property
    def drag(self) -> Floats | None:
        """Return forces against velocities [N s/m], shape (node,)."""
        return None

    @property
    def loads(self) -> "tuple[Load, ...]":
        """Return the forces that do work on nodes."""
        return ()

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m]: none."""
        from scipy.sparse import coo_matrix

        return coo_matrix((3 * size, 3 * size))

    def stiffening(self, time: float, position: Floats) -> Resisting | None:
        """Return None: this force does not depend on displacements."""
        return None

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2): none."""
        return np.zeros((*position.shape[:-2], 2))


class Items(NamedTuple):
    """Nodes on which the items of a field act, such as hinges or cells; each on at least one.

    Attributes:
        places: Indices of the nodes in the arrays of the kernel, item by item, shape (n,).
        first: Those of item i are places[first[i]:first[i + 1]], shape (item + 1,).
    """

    places: Indices
    first: Indices


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
        remains = len(self.hidden) or len(self.changes)
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
    def hidden(self) -> Indices:
        """Return the hidden nodes whose accelerations the kernel adds as forces, shape (n,).

        They are ascending.
        """
        return np.zeros(0, dtype=np.int64)

    def giving(self, position: Floats, velocity: Floats) -> float:
        """Return a bound of the rates at which anything relaxes [1/s].

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        return 0.0

    @property
    def unsolved(self) -> str:
        """The forces that ``memory_tangents`` lacks, such as "elements that yield"; or ""."""
        has_all = type(self).memory_tangents is not Field.memory_tangents
        return "" if has_all or not len(self.hidden) else "forces with memory"

    def memory_tangents(self, position: Floats, velocity: Floats) -> "MemoryTangents | None":
        """Return the derivatives of the internal variables in hidden nodes; None without any.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        return None

    def let_relax(self, velocity: Floats, position: Floats, moved: NDArray[np.bool_]) -> None:
        """Make relaxation permanent in the velocities of hidden nodes.

        Args:
            velocity: Of all nodes, changed in place [m/s], shape (node, 3).
            position: Of all nodes [m], shape (node, 3).
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
        parts = astuple(self)
        return SECONDS * sum(part.size for part in parts if isinstance(part, np.ndarray))

    @property
    def matrix_seconds(self) -> float:
        """Return an estimate of the time of making its matrix [s], as that of an evaluation."""
        return MATRIX * self.seconds

    @property
    def derivatives(self) -> "ForceDerivatives | str":
        """Return the exact derivatives, or why there are none, as the end of a sentence."""
        return "has no exact derivatives"

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[coo_matrix, coo_matrix] | None":
        """Return minus the derivatives of damping forces, None without any.

        They are by positions [N/m] and by velocities [N s/m], shape (3 size, 3 size) each.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        return None

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

        shape, place = position.shape[:-2], np.arange(position.shape[-2], dtype=np.int64)
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
                forces, power = np.zeros_like(x[k]), np.zeros(2)
                call(times[k], x[k].reshape(-1), v[k].reshape(-1), forces.reshape(-1), power)
                yield states[k], forces, power


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


class Acted(Struct, frozen=True, eq=False):
    """The nodes that a force acts on, as they are drawn.

    Attributes:
        nodes: Ascending, shape (n,).
        position: [m], shape (n, 3).
        mass: [kg], shape (n,).
        area: Area of skin that each represents [m²], shape (n,); zero inside of a body.
        skin: Triangles of the skin of the whole network, shape (triangle, 3).
        ends: Nodes of each spring of the network, shape (spring, 2).
        skin_marks: The spring that marks the element of each triangle of the skin, or -1, shape
            (triangle,); None where no element may break.
    """

    nodes: Indices
    position: Floats
    mass: Floats
    area: Floats
    skin: NDArray[np.integer]
    ends: NDArray[np.integer]
    skin_marks: Indices | None = None

    def drawn(self, nodes: Indices) -> Floats:
        """Return where some of these nodes are drawn [m], shape (…, 3).

        Args:
            nodes: Their indices, shape (…).
        """
        return self.position[np.searchsorted(self.nodes, nodes)]

    @property
    def triangles(self) -> "SkinTriangles":
        """Return the triangles of the skin all of whose corners are among the nodes.

        Raises:
            ValueError: There is none.
        """
        from tissuec.forces.triangles import Areas, SkinTriangles  # where a force needs them

        rows = np.flatnonzero(np.isin(self.skin, self.nodes).all(axis=1))
        if not len(rows):
            raise ValueError(
                "it acts on the triangles of surfaces, but these nodes are the corners of none"
            )
        corners = self.skin[rows].astype(np.int64)
        drawn = Areas.at(np.searchsorted(self.nodes, corners), self.position).area
        marks = None if self.skin_marks is None else self.skin_marks[rows]
        return SkinTriangles(corners, rows, drawn, self.ends, marks)


class ForceOutput(Struct, frozen=True, eq=False):
    """Numbers of a force at nodes or triangles, which a scene can record in trajectories.

    Attributes:
        name: As in ``trajectory with NAME``.
        at: What has a number.
        dimension: Of the numbers.
        text: What they are, such as "tension of each triangle of a film".
        numbers: Takes a field of the force, times [s] of shape (…), and positions [m] of shape
            (…, node, 3). It returns the nodes, or the rows of the skin, shape (n,), and their
            numbers in the SI unit, shape (…, n). Several forces at the same place add up.
        signed: Whether numbers below 0 have a meaning of their own; colours then part at 0.
        remark: Further sentences for the reference.
    """

    name: str
    at: Literal["node", "triangle"]
    dimension: Dimension
    text: str
    numbers: Callable[[Any, Floats | float, Floats], tuple[Indices, Floats]]
    signed: bool = False
    remark: str = ""


class Force(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """Base of the members of ``FORCES``; their fields are entries in the language.

    Attributes:
        outputs: What trajectories can contain of it.
    """

    outputs: ClassVar[tuple[ForceOutput, ...]] = ()

    @abstractmethod
    def on(self, acted: Acted) -> Field:
        """Return the field on some nodes.

        Raises:
            ValueError: It cannot act on them, and why, as the end of a sentence about it.
        """


FORCES: Family[type[Force]] = Family("tissuec.forces", "force")


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
        term_first=np.array([0, count], dtype=np.int64),
        term_vector=vector,
        term_curve=np.arange(count, dtype=np.int64),
        turn_curve=np.full(1, -1),
        turn_centre=np.zeros((1, 3)),
        turn_axis=np.zeros((1, 3)),
        turn_angle=np.zeros(1),
        **tabulated([profile for _, profile in changes], start, until),
    )
