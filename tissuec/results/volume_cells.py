"""The cells of preserved volumes, the nodes around them, and means at these."""

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import BodyPart, Floats, Indices, Network


class VolumeCells(Struct, frozen=True, eq=False):
    """The cells of all volumes that a run may preserve, one body after another.

    Attributes:
        bodies: Names of their bodies.
        counts: How many cells each of them has, shape (body,).
        pairs: Nodes of the network and the cells around them, shape (pair, 2).
    """

    bodies: tuple[str, ...]
    counts: Indices
    pairs: Indices

    @classmethod
    def of(cls, network: Network, bodies: Sequence[BodyPart]) -> Self:
        """Return the cells of some bodies whose volumes can be preserved."""
        counts: list[int] = []
        found = [np.zeros((0, 2), dtype=np.int64)]
        for body in bodies:
            pairs = cells_around(body)
            if pairs is None:  # the volume inside its surface is one cell
                nodes = np.unique(network.skin_of(body)).astype(np.int64)
                pairs = np.stack([nodes, np.zeros_like(nodes)], axis=1)
            found.append(pairs + np.array([0, sum(counts)]))
            counts.append(int(pairs[:, 1].max()) + 1)
        names = tuple(body.name for body in bodies)
        return cls(names, np.array(counts, dtype=np.int64), np.concatenate(found))

    @property
    def total(self) -> int:
        """Return how many cells there are."""
        return int(self.counts.sum())

    def at_nodes(self, values: NDArray[Any], nodes: NDArray[np.integer]) -> Floats:
        """Return the mean of the cells around nodes, NaN where there is none.

        Args:
            values: Of all cells in any unit, shape (…, cell).
            nodes: Network numbers of the nodes, ascending, shape (node,).

        Returns:
            In the same unit, shape (…, node).
        """
        shown = self.pairs[np.isin(self.pairs[:, 0], nodes)]
        at = np.searchsorted(nodes, shown[:, 0])
        return mean_at(at[:, None], values[..., shown[:, 1]], len(nodes))


def cells_around(part: BodyPart) -> Indices | None:
    """Return the nodes of a body of cells, and the cells around them.

    Returns:
        Numbers in the network and among the cells, shape (pair, 2); None for a body without
        cells.
    """
    if part.cells is not None:
        faces, inner = part.cells()
        members = np.concatenate([faces.reshape(len(faces), -1), inner], axis=1)
        cells = np.repeat(np.arange(len(members)), members.shape[1])
        return np.unique(np.stack([members.ravel() + part.nodes.start, cells], axis=1), axis=0)
    return None


def mean_at(corners: NDArray[np.integer], values: NDArray[Any], nodes: int) -> Floats:
    """Return the mean at each node of the items that it is a corner of, NaN without any.

    Args:
        corners: Nodes of each item, shape (item, corner).
        values: Of the items, in any unit, shape (…, item).
        nodes: How many nodes there are.

    Returns:
        In the unit of ``values``, shape (…, node).
    """
    at, width = corners.reshape(-1), corners.shape[1]
    count = np.bincount(at, minlength=nodes)
    leading = values.shape[:-1]
    rows = np.repeat(values.reshape(-1, values.shape[-1]), width, axis=1)
    total = [np.bincount(at, row, nodes) for row in rows.astype(float)]
    means = np.full((len(rows), nodes), np.nan)
    np.divide(np.array(total).reshape(len(rows), nodes), count, out=means, where=count > 0)
    return means.reshape(*leading, nodes)
