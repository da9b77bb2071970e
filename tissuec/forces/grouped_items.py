"""Points that nodes carry, such as the middle of a cap: z = Σ A x + b; items between them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Number
from tissuec.forces.matrices import assembled
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix


class CarriedPoints(Struct, frozen=True, eq=False):
    """Points that follow from nodes, in order; each has one at least.

    Attributes:
        nodes: Of each point, one after the other, shape (part,).
        point: That each of these carries, ascending, shape (part,).
        parts: A of each, without a unit, shape (part, 3, 3).
        fixed: b of each point [m], shape (point, 3).
    """

    nodes: Indices
    point: Indices
    parts: Floats
    fixed: Floats

    @property
    def count(self) -> int:
        """Return the number of points."""
        return len(self.fixed)

    def at(self, position: Floats) -> Floats:
        """Return where the points are [m], shape (…, point, 3).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        if not self.count:
            return np.zeros((*position.shape[:-2], 0, 3))
        own = np.einsum("nij,...nj->...ni", self.parts, position[..., self.nodes, :])
        first = np.searchsorted(self.point, np.arange(self.count))
        return np.add.reduceat(own, first, axis=-2) + self.fixed

    def joined(self, other: "CarriedPoints") -> "CarriedPoints":
        """Return these points, and others after them."""
        return CarriedPoints(
            np.concatenate([self.nodes, other.nodes]),
            np.concatenate([self.point, self.count + other.point]),
            np.concatenate([self.parts, other.parts]),
            np.concatenate([self.fixed, other.fixed]),
        )

    # --- together with nodes ------------------------------------------------------------------

    def and_nodes(self, position: Floats) -> Floats:
        """Return positions in which -1 - p is the index of the point p [m], (…, node + p, 3).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        if not self.count:
            return position
        return np.concatenate([position, self.at(position)[..., ::-1, :]], axis=-2)

    def inputs(self, letter: str, corners: Indices, vectors: Floats) -> dict[str, Floats]:
        """Return components at the corners of items, by names of traced inputs.

        Args:
            letter: Of the inputs.
            corners: Nodes, or -1 - p for the point p, shape (item, corner).
            vectors: Of all nodes, in any unit, shape (…, node, 3).
        """
        x = self.and_nodes(vectors)
        return {
            f"{letter}.{corner}.{axis}": x[..., corners[:, corner], axis]
            for corner, axis in np.ndindex(corners.shape[1], 3)
        }

    def numbers(self, corners: Indices, number: Indices, size: int) -> Indices:
        """Return the numbers of corners, in which those of points follow all others.

        Args:
            corners: As of ``inputs``, of any shape, which is also that of the result.
            number: As of ``follow``, shape (node,).
            size: As of ``follow``.
        """
        return np.where(corners < 0, size - 1 - corners, number[np.maximum(corners, 0)])

    def follow(self, number: Indices, size: int) -> "csr_matrix":
        """Return the derivative of nodes and points, shape (3 (size + point), 3 size).

        Args:
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix, identity, vstack

        own = number[self.nodes]
        moves = own >= 0
        rows = 3 * self.point[moves, None, None] + np.arange(3)[:, None]
        columns = 3 * own[moves, None, None] + np.arange(3)
        values = self.parts[moves]
        row, column = (np.broadcast_to(each, values.shape).ravel() for each in (rows, columns))
        shape = 3 * self.count, 3 * size
        points = csr_matrix((values.ravel(), (row, column)), shape=shape)
        return csr_matrix(vstack([identity(3 * size), points]))

    def assembled(
        self, blocks: Floats, corners: Indices, number: Indices, size: int
    ) -> "csr_matrix | csc_matrix":
        """Return the matrix in which the blocks of items add up, shape (3 size, 3 size).

        Args:
            blocks: In any unit, shape (item, corner, 3, corner, 3).
            corners: As of ``inputs``.
            number, size: As of ``follow``.
        """
        places = self.numbers(corners, number, size)
        found = assembled(blocks, places, size + self.count)
        if not self.count:
            return found
        from scipy.sparse import csr_matrix

        follow = self.follow(number, size)
        return csr_matrix(follow.T @ found @ follow)


NO_POINTS = CarriedPoints(
    np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros((0, 3, 3)),
    np.zeros((0, 3)),
)  # fmt: skip


class GroupedItems(NamedTuple):
    """Items, group by group.

    Attributes:
        corners: Nodes of each, or -1 - p for a point p that nodes carry; shape (item, corner).
        first: Where each group begins among them and, last, where all end, shape (group + 1,).
        seen: The node or point from which a group is seen, shape (group,).
        points: That nodes carry.
        numbers: Of items, in SI units, shape (), (item,), or (component, item or 1).
        of_groups: Numbers of groups, alike.
    """

    corners: Indices
    first: Indices
    seen: Indices
    points: CarriedPoints
    numbers: Mapping[str, Floats | float]
    of_groups: Mapping[str, Floats | float]

    @property
    def owner(self) -> Indices:
        """Return the group of each item, shape (item,)."""
        return np.repeat(np.arange(len(self.seen)), np.diff(self.first))

    @property
    def carries(self) -> bool:
        """Return whether nodes carry any points."""
        return self.points.count > 0

    def inputs(self, position: Floats) -> dict[str, Floats]:
        """Return the inputs of items but λ, shape (…, item) or (1,) each.

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        corners = np.column_stack([self.corners, self.seen[self.owner]])
        return inputs(self.numbers) | self.points.inputs("x", corners, position)

    def each(self, outputs: Sequence[Number], values: Mapping[str, Floats]) -> Floats:
        """Return numbers of items in any unit, shape (item, output).

        Args:
            values: Of all inputs, shape (item,) or (1,).
        """
        # Many of a matrix are equal, or zero.
        single = {each.place: each for each in outputs}
        rows = {place: k for k, place in enumerate(single)}
        found = np.empty((len(rows), len(self.corners)))
        for row, one in zip(found, evaluate(list(single.values()), values), strict=True):
            row[:] = one
        return found[[rows[each.place] for each in outputs]].T


def as_rows(numbers: Mapping[str, Floats | float]) -> dict[str, Floats]:
    """Return numbers in SI units, shape (component, n) each, n being 1 for those of all.

    Args:
        numbers: Shape (), (n,) or (component, n).
    """
    return {name: np.atleast_2d(np.asarray(each, float)) for name, each in numbers.items()}


def inputs(numbers: Mapping[str, Floats | float]) -> dict[str, Floats]:
    """Return numbers as inputs of a graph, in SI units, shape (n,) each; as for ``as_rows``."""
    rows = as_rows(numbers).items()
    return {f"p.{name}.{k}": row for name, own in rows for k, row in enumerate(own)}
