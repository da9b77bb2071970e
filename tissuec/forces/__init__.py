"""Forces on nodes by where these are: volumes, walls that bend, contact, jets.

Springs have their own way; everything else that acts on nodes is a ``Field``. Each file has the
numbers of one effect, its scalar loops, and all that the rest of the program wants to know of
it; long loops have a file of their own whose name ends in ``kernel``. Beside ``situation``,
which holds fields, and the reference, which has formulas of its own, nothing knows them by more
than ``Field``.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.courses import Course, tabulated
from tissuec.kernels.records import Acts
from tissuec.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

#: Adds an operator applied to a vector to another one, both of shape (node, 3).
Resisting = Callable[[Floats, Floats], None]


class Field(ABC):
    """What acts on nodes beside springs; arrays stand in the order of the scene.

    Arguments have the same meaning in all functions: ``time`` [s] of shape (…); ``position``
    [m] and ``velocity`` [m/s] of all nodes, shape (…, node, 3), or (node, 3) where the result
    is one number or matrix; ``number`` of each node among those that may move, -1 for others,
    and the ``size`` of these, so that matrices are of shape (3 size, 3 size).
    """

    __slots__ = ()

    @property
    @abstractmethod
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops: of time, positions, velocities, forces, powers and a table.

        They add forces [N] and the powers that are put in from outside and lost [W].
        """

    @abstractmethod
    def table(self, place: Indices, acts: Acts, position: Floats) -> Any:
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
    def changes(self) -> Sequence[tuple[float, Course]]:
        """Return what changes in time by itself: amounts, and the courses they follow."""
        return ()

    @abstractmethod
    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""

    @abstractmethod
    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m]; none that weakens unless exact."""

    @abstractmethod
    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return how far below zero an eigenvalue of the matrix may be [N/m]."""

    def stiffening(self, position: Floats) -> Resisting | None:
        """Return what resists displacements at most [N/m], None if nothing does."""
        return None

    def braking(self, position: Floats) -> Resisting | None:
        """Return what resists velocities at most [N s/m], None if nothing does."""
        return None

    @abstractmethod
    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""

    @abstractmethod
    def noise(self, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""

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


def acts_of(changes: Sequence[tuple[float, Course]], start: float, until: float) -> Acts:
    """Return amounts times courses as tables, as the first component of one act on no node.

    Args:
        start, until: The stretch that they are for, without knots inside [s].
    """
    count, none = len(changes), np.zeros(0, dtype=np.int64)
    vector = np.zeros((count, 3))
    vector[:, 0] = [amount for amount, _ in changes]
    return Acts(
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
        **tabulated([course for _, course in changes], start, until),
    )
