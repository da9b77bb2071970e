"""Springs where nothing moves: what they pull with, store, and resist as a matrix.

A spring of direction u and tension T = f(L - L0) contributes to the stiffness matrix

    f' u uᵀ + T/L (1 - u uᵀ),

both of whose parts are clamped at zero where the exact one would not be positive (J. Teran,
E. Sifakis, G. Irving, R. Fedkiw, Symp. Computer Animation 2005, p. 181). Dashpots do not act;
branches have given way, and rest lengths stay as they have flowed.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.laws.evaluation import Behaviour
from tissuec.model.network import Floats, Indices


class Bars(NamedTuple):
    """State of springs at given positions of the nodes.

    Attributes:
        direction: Unit vectors, shape (spring, 3); zero where the length is.
        length: [m], shape (spring,).
        tension: [N], shape (spring,); zero where the length is.
        position: Of all nodes of the scene [m], shape (node, 3).
    """

    direction: Floats
    length: Floats
    tension: Floats
    position: Floats


class RestingSprings(Struct, frozen=True, eq=False, dict=True):
    """The springs of some free nodes, without internal variables.

    Attributes:
        ends: Number of the free node at either end, -1 for one that stays, shape (spring, 2).
        outer_ends: The same as numbers among all nodes of the scene, shape (spring, 2).
        behaviour: Their laws and numbers.
        rest: Their rest lengths with what they flowed [m], shape (spring,).

    Shared arguments:
        bars: The springs at the positions of interest.
        to: Forces on the free nodes that are added to [N], shape (free, 3).
    """

    ends: Indices
    outer_ends: NDArray[np.int32]
    behaviour: Behaviour
    rest: Floats

    def bars(self, position: Floats) -> Bars:
        """Return the state of the springs.

        Args:
            position: Of all nodes of the scene [m], shape (node, 3).
        """
        reach, length = reached(self.outer_ends, position)
        has_direction = length > 0.0
        direction = reach / np.where(has_direction, length, 1.0)[:, None]
        tension = np.where(has_direction, self.behaviour.pull(length - self.rest), 0.0)
        return Bars(direction, length, tension, position.copy())

    def add_forces(self, bars: Bars, to: Floats) -> None:
        """Add what the springs pull at the free nodes."""
        pull = bars.tension[:, None] * bars.direction
        for end, sign in ((0, 1.0), (1, -1.0)):
            moves = self.ends[:, end] >= 0
            np.add.at(to, self.ends[moves, end], sign * pull[moves])

    def energy(self, bars: Bars) -> Floats:
        """Return the energy of each spring [J], shape (spring,)."""
        return self.behaviour.energy(bars.length - self.rest)

    def noise(self, bars: Bars, size: float) -> float:
        """Return the largest term of the tensions [N], a scale of rounding errors.

        Args:
            size: Largest coordinate [m].
        """
        steep = np.abs(self.behaviour.slope(bars.length - self.rest))
        return float((steep * (bars.length + self.rest + size)).max(initial=0.0))

    def weakening(self, bars: Bars, count: int) -> float:
        """Return a bound on how negative pressed springs make an eigenvalue [N/m].

        Their part of the matrix is -T/L across two nodes each; Gershgorin's bound over the
        free nodes.

        Args:
            count: Number of free nodes.
        """
        pressed = np.maximum(-bars.tension, 0.0) / np.where(bars.length > 0.0, bars.length, 1.0)
        total = np.zeros(count)
        for end in (0, 1):
            moves = self.ends[:, end] >= 0
            np.add.at(total, self.ends[moves, end], 2.0 * pressed[moves])
        return float(total.max(initial=0.0))

    def entries(self, bars: Bars, *, exact: bool) -> tuple[Floats, Indices, Indices]:
        """Return the contributions to the stiffness matrix [N/m], with their rows and columns.

        All three arrays have the shape (entry,); entries of one place add up.

        Args:
            exact: Whether pressed springs weaken the net; otherwise the sum is positive
                semidefinite.
        """
        has_direction = bars.length > 0.0
        steep = self.behaviour.slope(bars.length - self.rest)
        if not exact:
            steep = np.maximum(steep, 0.0)
        across = bars.tension / np.where(has_direction, bars.length, 1.0)
        if not exact:
            across = np.maximum(across, 0.0)
        # What has no direction resists in all of them.
        across = np.where(has_direction, across, steep)
        along = np.where(has_direction, steep - across, 0.0)
        block = along[:, None, None] * np.einsum("si,sj->sij", bars.direction, bars.direction)
        block += across[:, None, None] * np.eye(3)
        moves, sign, row, column = self._blocks
        return (sign[:, None, None] * block[moves]).ravel(), row, column

    @cached_property
    def _blocks(self) -> tuple[Indices, Floats, Indices, Indices]:
        """Return blocks of the matrix: spring and sign of each, and rows and columns."""
        pairs, signs = ((0, 0), (1, 1), (0, 1), (1, 0)), (1.0, 1.0, -1.0, -1.0)
        moves = [np.flatnonzero((self.ends[:, pair] >= 0).all(axis=1)) for pair in pairs]
        counts = [len(each) for each in moves]
        one, other = (
            np.concatenate(
                [self.ends[m, pair[k]] for m, pair in zip(moves, pairs, strict=True)]
            )
            for k in (0, 1)
        )
        shape = len(one), 3, 3
        row = np.broadcast_to(3 * one[:, None, None] + np.arange(3)[:, None], shape)
        column = np.broadcast_to(3 * other[:, None, None] + np.arange(3), shape)
        sign = np.repeat(signs, counts)
        return np.concatenate(moves), sign, row.ravel(), column.ravel()


def reached(ends: NDArray[np.integer], position: Floats) -> tuple[Floats, Floats]:
    """Return the vectors along springs [m], shape (spring, 3), and lengths, shape (spring,).

    Args:
        ends: Node pair of each spring, shape (spring, 2).
    """
    reach = position[ends[:, 1]] - position[ends[:, 0]]
    return reach, np.sqrt(np.einsum("sk,sk->s", reach, reach))
