"""Solid elements as cells of VTK, wherever nodes are counted from."""

from typing import Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.geometry.elements import SHAPES
from tissuec.model.network import Indices, Network

VERTEX, LINE, TRIANGLE = 1, 3, 5
#: VTK's numbers of the shapes of elements (VTK file formats, table of cell types).
TYPES = {"hexahedron": 12, "quadratic hexahedron": 29, "tetrahedron": 24, "wedge": 13}
_SHAPES = {number: SHAPES[name] for name, number in TYPES.items()}


def ends_of(sizes: NDArray[np.integer]) -> Indices:
    """Return where cells of some sizes begin, and the end of the last, shape (cell + 1,)."""
    return np.append(0, np.cumsum(sizes)).astype(np.int64)


class ElementCells(Struct, frozen=True, eq=False):
    """Solid elements, body after body.

    Attributes:
        types: VTK's number of the shape of each, shape (element,).
        nodes: Of all elements, one after another, in the order of VTK, shape (row,).
        entities: Their numbers among the entities of the network, shape (element,).
    """

    types: NDArray[np.uint8]
    nodes: NDArray[np.integer]
    entities: NDArray[np.integer]

    @classmethod
    def of(cls, network: Network) -> Self:
        """Return the elements of a compiled network, in the order of its blocks."""
        types: list[NDArray[Any]] = [np.zeros(0, dtype=np.uint8)]
        nodes: list[NDArray[Any]] = [np.zeros(0, dtype=np.int32)]
        entities: list[NDArray[Any]] = [np.zeros(0, dtype=np.int32)]
        for one in network.of_kind("elements"):
            types.append(np.full(len(one.nodes), TYPES[one.shape.name], dtype=np.uint8))
            nodes.append(one.nodes.reshape(-1).astype(np.int32))
            entities.append(one.walls)
        found = types, nodes, [each.astype(np.int32) for each in entities]
        return cls(*map(np.concatenate, found))

    @classmethod
    def none(cls) -> Self:
        """Return no elements."""
        whole = np.zeros(0, dtype=np.int32)
        return cls(np.zeros(0, dtype=np.uint8), whole, whole)

    def __len__(self) -> int:
        return len(self.types)

    @property
    def firsts(self) -> NDArray[np.integer]:
        """Return the first node of each, shape (element,)."""
        return self.nodes[ends_of(self.sizes)[:-1]]

    @property
    def sizes(self) -> Indices:
        """Return how many nodes each has, shape (element,)."""
        sizes = np.zeros(256, dtype=np.int64)
        for number, shape in _SHAPES.items():
            sizes[number] = shape.nodes
        return sizes[self.types]

    def some(self, items: Indices) -> Self:
        """Return some of the elements, by ascending indices of shape (n,)."""
        if len(items) == len(self):
            return self
        sizes = self.sizes
        first, own = ends_of(sizes)[items], sizes[items]
        rows = np.repeat(first, own) + counted_up(own)
        return type(self)(self.types[items], self.nodes[rows], self.entities[items])

    def at_nodes(self, values: NDArray[Any], items: Indices, nodes: int) -> NDArray[Any]:
        """Return the mean at each node of the elements around it, NaN without any.

        Args:
            values: Of some elements in any unit, shape (n,).
            items: Which these are, ascending, shape (n,).
            nodes: How many nodes there are.

        Returns:
            In the unit of ``values``, shape (node,).
        """
        own = self.some(items)
        total = np.bincount(own.nodes, np.repeat(values, own.sizes), nodes)
        count = np.bincount(own.nodes, minlength=nodes)
        return np.divide(total, count, out=np.full(nodes, np.nan), where=count > 0)

    def by_shape(self) -> list[tuple[int, Indices, NDArray[np.integer]]]:
        """Return VTK's number of each shape, its elements, and their nodes (element, node)."""
        first, found = ends_of(self.sizes), list[tuple[int, Indices, Any]]()
        for number in np.unique(self.types).tolist():
            items = np.flatnonzero(self.types == number)
            rows = first[items][:, None] + np.arange(_SHAPES[number].nodes)
            found.append((number, items, self.nodes[rows]))
        return found
