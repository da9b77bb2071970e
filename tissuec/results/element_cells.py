"""Solid elements as cells of VTK, wherever nodes are counted from."""

from typing import Any, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import astuple
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.geometry.elements import SHAPES
from tissuec.model.network import Floats, Indices, Network

VERTEX, LINE, TRIANGLE, PIECE = 1, 3, 5, 10
FIBRES = ("fibres", "second_fibres")
#: VTK's numbers of the shapes of elements (VTK file formats, table of cell types).
TYPES = {"hexahedron": 12, "quadratic hexahedron": 29, "tetrahedron": 24, "wedge": 13}
#: Nodes of these, and corners of the tetrahedra that parts of cut elements are drawn by.
_NODES = {number: SHAPES[name].nodes for name, number in TYPES.items()} | {PIECE: 4}


def ends_of(sizes: NDArray[np.integer]) -> Indices:
    """Return where cells of some sizes begin, and the end of the last, shape (cell + 1,)."""
    return np.append(0, np.cumsum(sizes)).astype(np.int64)


class ElementCells(Struct, frozen=True, eq=False):
    """Solid elements, body after body.

    Attributes:
        types: VTK's number of the shape of each, shape (element,).
        nodes: Of all elements, one after another, in the order of VTK, shape (row,).
        entities: Their numbers among the entities of the network, shape (element,).
        region, tissue: Of each, as numbers among the names of the network, shape (element,).
        fibres: Directions of families as drawn, shape (element, family, 3); 0 without fibres.
    """

    types: NDArray[np.uint8]
    nodes: NDArray[np.integer]
    entities: NDArray[np.integer]
    region: NDArray[np.integer]
    tissue: NDArray[np.integer]
    fibres: Floats

    @classmethod
    def of(cls, network: Network) -> Self:
        """Return the elements of a compiled network, in the order of its blocks."""
        every = network.of_kind("elements")
        if not every:
            return cls.none()
        types = [np.full(len(one.nodes), TYPES[one.shape.name]) for one in every]
        nodes = [one.nodes.reshape(-1) for one in every]
        entities = np.concatenate([one.walls for one in every])
        region, tissue = _regions(network, entities)
        fibres = np.zeros((len(entities), max(one.drawn_fibres.shape[1] for one in every), 3))
        first = 0
        for one in every:
            own = one.drawn_fibres
            fibres[first : first + len(own), : own.shape[1]] = own
            first += len(own)
        return cls(
            np.concatenate(types).astype(np.uint8),
            np.concatenate(nodes).astype(np.int32),
            entities.astype(np.int32), region, tissue, fibres,
        )  # fmt: skip

    @classmethod
    def none(cls) -> Self:
        """Return no elements."""
        whole = np.zeros(0, dtype=np.int32)
        return cls(np.zeros(0, np.uint8), *[whole] * 4, np.zeros((0, 0, 3)))

    @property
    def labels(self) -> dict[str, NDArray[Any]]:
        """Return regions, tissues and directions of fibres by the names that VTK shows.

        They have no unit and the shape (element,), or (element, 3) of directions.
        """
        families = zip(FIBRES, self.fibres.swapaxes(0, 1), strict=False)
        return {"region": self.region, "tissue": self.tissue, **dict(families)}

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
        for number, nodes in _NODES.items():
            sizes[number] = nodes
        return sizes[self.types]

    def followed_by(self, more: Self) -> Self:
        """Return these and others behind them, with as many families of fibres."""
        pairs = zip(astuple(self), astuple(more), strict=True)
        return type(self)(*map(np.concatenate, pairs))

    def some(self, items: Indices) -> Self:
        """Return some of the elements, by ascending indices of shape (n,)."""
        if len(items) == len(self):
            return self
        sizes = self.sizes
        first, own = ends_of(sizes)[items], sizes[items]
        rows = np.repeat(first, own) + counted_up(own)
        others = self.entities, self.region, self.tissue, self.fibres
        return type(self)(
            self.types[items], self.nodes[rows], *(each[items] for each in others)
        )

    def at_nodes(self, values: NDArray[Any], items: Indices, nodes: int) -> NDArray[Any]:
        """Return the mean at each node of the elements around it, NaN without any.

        A part of an element, which has several cells, counts once at each of its corners.

        Args:
            values: Of some elements in any unit, shape (n,).
            items: Which these are, ascending, shape (n,).
            nodes: How many nodes there are.

        Returns:
            In the unit of ``values``, shape (node,).
        """
        own = self.some(items)
        at, values = own.nodes, np.repeat(values, own.sizes)
        if (own.types == PIECE).any():
            of = np.repeat(own.entities, own.sizes).astype(np.int64)
            _, first = np.unique(of * nodes + at, return_index=True)
            at, values = at[first], values[first]
        total = np.bincount(at, values, nodes)
        count = np.bincount(at, minlength=nodes)
        return np.divide(total, count, out=np.full(nodes, np.nan), where=count > 0)

    def by_shape(self) -> list[tuple[int, Indices, NDArray[np.integer]]]:
        """Return VTK's number of each shape, its elements, and their nodes (element, node)."""
        first, found = ends_of(self.sizes), list[tuple[int, Indices, Any]]()
        for number in np.unique(self.types).tolist():
            items = np.flatnonzero(self.types == number)
            rows = first[items][:, None] + np.arange(_NODES[number])
            found.append((number, items, self.nodes[rows]))
        return found


def _regions(
    network: Network, entities: Indices
) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Return the numbers of the regions and tissues of elements, shape (element,) each.

    Args:
        entities: Which elements, ascending within each body, shape (element,).
    """
    tissues, first = network.tissue_names, 0
    region, tissue = np.zeros((2, len(entities)), dtype=np.int32)
    for body in network.bodies:
        if body.element_region is not None:
            own = (entities >= body.elements.start) & (entities < body.elements.stop)
            part = body.element_region[entities[own] - body.elements.start]
            region[own] = np.where(part > 0, part + first, 0)
            tissue[own] = np.array([tissues.index(name) for _, name in body.regions])[part]
        first += len(body.regions) - 1
    return region, tissue
