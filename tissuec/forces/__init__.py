"""Forces, one file for each effect.

Each file has the numbers of one effect, its scalar loops, and all that the rest of the program
wants to know of it; long loops have a file of their own whose name ends in ``kernel``. Springs
with their laws and branches come first. Everything else is an ``Effect``: a ``Nodal`` one acts
on each node by itself (weight, drag, loads), a ``Field`` by where nodes are (volumes, bending,
contact, jets, ``force`` blocks). Beside ``state``, which holds them, and the reference,
which has formulas of its own, nothing knows them by more than that. Members of ``FORCES`` are
the kinds of ``force NAME { kind is … }`` in a scene. ``accelerations`` sums up all of them.
"""

from abc import ABCMeta, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from msgspec import Struct, StructMeta
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.core.source import Span
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile, tabulated

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

    from tissuec.forces.load import Load

#: Time that a kernel takes for each number of its field, by measuring the shipped ones [s].
SECONDS = 5e-9

#: Adds an operator applied to a vector to another one, both of shape (node, 3).
Resisting = Callable[[Floats, Floats], None]


class _Abstract(StructMeta, ABCMeta):
    """The class of a ``Struct`` that leaves functions to its members."""


class Effect(Struct, metaclass=_Abstract, frozen=True, eq=False):
    """What acts on nodes; arrays stand in the order of the scene.

    Arguments have the same meaning in all functions: ``time`` [s] of shape (…); ``position``
    [m] and ``velocity`` [m/s] of all nodes, shape (…, node, 3), or (node, 3) where the result
    is one number or matrix; ``number`` of each node among those that may move, -1 for others,
    and the ``size`` of these, so that matrices are of shape (3 size, 3 size).
    """

    @abstractmethod
    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""

    @abstractmethod
    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2).

        What moves nodes on prescribed paths puts in more.
        """

    @abstractmethod
    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""

    @abstractmethod
    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m]; none that weakens unless exact."""

    @property
    def loss(self) -> str:
        """Return why energy is not kept, as the beginning of a sentence.

        Empty if it is, or is lost only in what ``braking`` tells.
        """
        return ""

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[coo_matrix, Floats]":
        """Return the matrix as S and W of S + W Wᵀ, W of shape (3 size, column).

        W has what acts between many nodes at once, and would fill S.
        """
        whole = self.matrix(time, position, number, size, exact=exact)
        return whole, np.zeros((3 * size, 0))

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which nodes it ties to what is outside of their piece, shape (node,)."""
        return np.zeros(len(position), dtype=bool)

    # --- bounds, which members override where they know better ones -----------------------

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return how far below zero an eigenvalue of the matrix may be [N/m].

        Gershgorin's bound of what only the exact one has.
        """
        whole, positive = (
            self.matrix(time, position, number, size, exact=exact) for exact in (True, False)
        )
        return float(np.asarray(abs(whole - positive).sum(axis=1)).max(initial=0.0))

    def stiffening(self, time: float, position: Floats) -> Resisting | None:
        """Return what resists displacements at most [N/m], None if nothing does.

        The sums of the rows of the matrix, on its diagonal.
        """
        rows = self._rows(time, position)

        def resist(moved: Floats, to: Floats) -> None:
            to += rows * moved

        return resist

    def braking(self, position: Floats) -> Resisting | None:
        """Return what resists velocities at most [N s/m], None if nothing does."""
        return None

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        forces = np.zeros_like(position)
        self.add_forces(time, position, np.zeros_like(position), forces)
        return float(abs(self.energy(time, position)) + np.abs(forces * position).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return float((self._rows(time, position) * np.abs(position)).max(initial=0.0))

    def _rows(self, time: float, position: Floats) -> Floats:
        """Return the sums of the sizes in the rows of the matrix [N/m], shape (node, 3)."""
        count = len(position)
        matrix = abs(self.matrix(time, position, np.arange(count), count).tocsr())
        return np.asarray(matrix.sum(axis=1)).reshape(-1, 3)


class Nodal(Effect, frozen=True):
    """What acts on each node by itself, whatever the places of others are.

    The engine adds up what members say here in its own loop over nodes. It counts as applied
    from outside: what holds a node does not feel it.
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
        """Return forces that do work on nodes."""
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
        """Return that nothing resists displacements."""
        return None

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2): none."""
        return np.zeros((*position.shape[:-2], 2))


class Field(Effect, frozen=True):
    """What acts on nodes by their places, with a kernel of its own."""

    @property
    @abstractmethod
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops: of time, positions, velocities, forces, powers and a table.

        They add forces [N] and the powers that are put in from outside and lost [W].
        """

    @abstractmethod
    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> Any:
        """Return what the kernel is given, a record of arrays.

        Args:
            place: Where nodes stand for it, shape (node,).
            acts: The sum of ``changes``, as the first component of its only act.
            position: Around which it holds: while no node has gone by more than ``reach``.
        """

    @property
    def reach(self) -> float:
        """Return how far from where a table was made it holds [m]."""
        return inf

    @property
    def changes(self) -> Sequence[tuple[float, TimeProfile]]:
        """Return what changes in time by itself: amounts, and the profiles they follow."""
        return ()

    @property
    def seconds(self) -> float:
        """Return about how long one evaluation takes [s]; counted, so that runs repeat."""
        parts = astuple(self)
        return SECONDS * sum(part.size for part in parts if isinstance(part, np.ndarray))

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
        from tissuec.kernels.calls import kernel_on

        shape, place = position.shape[:-2], np.arange(position.shape[-2])
        times = np.broadcast_to(np.asarray(time, dtype=float), shape)
        states, times = list(np.ndindex(shape)), times.ravel()
        x, v = (in_line(each).astype(float) for each in (position, velocity))
        for part in stretches(x, self.reach):
            made = None
            for k in range(part.start, part.stop):
                if made is None or (self.changes and times[k] != made):
                    made = times[k]
                    table = self.table(place, acts_of(self.changes, made, made), x[part.start])
                    call = kernel_on(self.kernel, table)
                forces, power = np.zeros_like(x[k]), np.zeros(2)
                call(times[k], x[k].reshape(-1), v[k].reshape(-1), forces.reshape(-1), power)
                yield states[k], forces, power


class Acted(Struct, frozen=True, eq=False):
    """The nodes that a force acts on, as they are drawn.

    Attributes:
        nodes: Ascending, shape (n,).
        position: [m], shape (n, 3).
        mass: [kg], shape (n,).
        area: Of the skin that each stands for [m²], shape (n,); zero inside of a body.
    """

    nodes: Indices
    position: Floats
    mass: Floats
    area: Floats


class Force(Protocol):
    """What a member of ``FORCES`` can do; its fields are its entries in the language."""

    def on(self, acted: Acted) -> Field:
        """Return the field on some nodes.

        Raises:
            ValueError: It cannot act on them, and why, as the end of a sentence about it.
        """
        ...


FORCES: Family[type[Force]] = Family("tissuec.forces", "force")


class Imposed(Struct, frozen=True, eq=False):
    """A force that a scene describes: its name and kind there, and its field."""

    name: str
    kind: str
    field: Field
    span: Span


def diagonal(blocks: Floats, number: Indices, size: int) -> "coo_matrix":
    """Return a matrix of blocks on its diagonal, one for each node that may move.

    Args:
        blocks: Shape (n, 3, 3).
        number: Of the nodes among those that may move, -1 for others, shape (n,).
        size: How many may move; the matrix is of shape (3 size, 3 size).
    """
    from scipy.sparse import coo_matrix

    moves = number >= 0
    row = np.broadcast_to(
        3 * number[moves, None, None] + np.arange(3)[:, None], (moves.sum(), 3, 3)
    )
    where = row.ravel(), row.swapaxes(1, 2).ravel()
    return coo_matrix((blocks[moves].ravel(), where), shape=(3 * size, 3 * size))


def in_line(states: Floats) -> Floats:
    """Return states of shape (…, node, 3) one after the other, shape (state, node, 3)."""
    return states.reshape(-1, *states.shape[-2:])


def stretches(position: Floats, reach: float) -> Iterator[slice]:
    """Yield states in turn among which no node is further than a reach [m] from the first.

    Args:
        position: Of all nodes [m], shape (state, node, 3).
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
        start, until: The stretch that they are for, without knots inside [s].
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
