"""What is drawn of cells that a cut has divided: the matter of their parts, and cut faces.

A part of a cell has nodes of the whole cell, some of them on the far side of the cut, where
there is no matter of it. What is drawn of it has corners that are nodes, or *riding points*:
fixed weighted sums x = Σ w x_node.
"""

from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.model.network import Floats, Indices, MirrorPlane, Network, numbers_in


class WeightedSums(Struct, frozen=True, eq=False):
    """Fixed weighted sums of values of nodes.

    Attributes:
        first: Hosts of sum k are hosts[first[k]:first[k + 1]], at least one, shape (sum + 1,).
        hosts: Nodes, shape (host,).
        weights: Dimensionless, shape (host,); those of a sum add up to 1.
    """

    first: Indices
    hosts: Indices
    weights: Floats

    @classmethod
    def of(cls, counts: NDArray[np.integer], hosts: Indices, weights: Floats) -> Self:
        """Return sums whose hosts follow one another.

        Args:
            counts: How many hosts each has, shape (sum,).
            hosts, weights: As for the class; weights are dimensionless, shape (host,).
        """
        return cls(np.append(0, np.cumsum(counts)).astype(np.int64), hosts, weights)

    def __len__(self) -> int:
        return len(self.first) - 1

    @property
    def counts(self) -> Indices:
        """Return how many hosts each has, shape (sum,)."""
        return np.diff(self.first)

    @property
    def owners(self) -> Indices:
        """Return the number of the sum that each of the hosts belongs to, shape (host,)."""
        return np.repeat(np.arange(len(self)), self.counts)

    @property
    def main_hosts(self) -> Indices:
        """Return the host of each that has the largest weight, shape (sum,)."""
        order = np.lexsort((-self.weights, self.owners))
        return self.hosts[order[self.first[:-1]]]

    def weighted(self, values: Floats) -> Floats:
        """Return the sums of values of hosts, in any unit, shape (sum, …).

        Args:
            values: Of all nodes, shape (node, …).
        """
        weights = self.weights.reshape(-1, *(1,) * (values.ndim - 1))
        return np.add.reduceat(weights * values[self.hosts], self.first[:-1], axis=0)

    def beside(self, values: Floats) -> Floats:
        """Return values with the sums behind them, in their unit, shape (node + sum, …).

        Args:
            values: Of all nodes, shape (node, …).
        """
        return np.concatenate([values, self.weighted(values).astype(values.dtype)])

    def some(self, chosen: NDArray[np.bool_]) -> Self:
        """Return those that are chosen; a mask of shape (sum,)."""
        own = chosen[self.owners]
        return type(self).of(self.counts[chosen], self.hosts[own], self.weights[own])


class CutCells(Struct, frozen=True, eq=False):
    """The parts of all cells that were ever cut.

    Tables only grow: a later cut adds points, parts, tetrahedra and triangles behind those that
    are there. What belongs to an entity that is no longer alive is not drawn. A part that is
    cut again, or gets other nodes, becomes other parts, with entities of their own.

    Corners are numbers of nodes or, from ``nodes`` on, of riding points.

    Attributes:
        nodes: How many nodes the network has.
        points: Riding points.
        parts: Their entities, each once, shape (part,).
        wholes: The element of the network that each is a part of, an entity, shape (part,).
        corners: Of tetrahedra that fill the parts, with positive volume, shape (tetrahedron,
            4).
        owners: The part that each belongs to, an entity, shape (tetrahedron,).
        triangles: Of the outer surface and of cut faces, as seen from outside, shape (triangle,
            3).
        borders: The part that each bounds, an entity, shape (triangle,).
        cuts: The cut of its body that each is a face of, its number from 1 on, above 0 in front
            of the cut and below 0 behind it; 0 on the outer surface, shape (triangle,).
    """

    nodes: int
    points: WeightedSums
    parts: Indices
    wholes: Indices
    corners: Indices
    owners: Indices
    triangles: Indices
    borders: Indices
    cuts: Indices

    def __post_init__(self) -> None:
        count = self.nodes + len(self.points)
        for table in (self.corners, self.triangles):
            if len(table) and not 0 <= table.min() <= table.max() < count:
                raise ValueError(f"corners must be less than {count}, the number of points")
        for entities in (self.owners, self.borders):
            if not np.isin(entities, self.parts).all():
                raise ValueError("every tetrahedron and triangle must belong to a part")
        if len(np.unique(self.parts)) < len(self.parts):
            raise ValueError("every part needs an entity of its own")
        if len(self.points.hosts) and self.points.hosts.max() >= self.nodes:
            raise ValueError("riding points are sums of nodes")

    @classmethod
    def none(cls, nodes: int) -> Self:
        """Return none of a network of so many nodes."""
        none = np.zeros(0, dtype=np.int64)
        points = WeightedSums(np.zeros(1, dtype=np.int64), none, np.zeros(0))
        corners, triangles = none.reshape(0, 4), none.reshape(0, 3)
        return cls(nodes, points, none, none, corners, none, triangles, none, none)

    def wholes_of(self, parts: Indices) -> Indices:
        """Return the whole element of each part, an entity, shape (n,)."""
        order = np.argsort(self.parts)
        return self.wholes[order[np.searchsorted(self.parts, parts, sorter=order)]]

    def followed_by(self, more: Self) -> Self:
        """Return these and others behind them.

        Args:
            more: Whose corners count their riding points from that of the first of their own.
        """
        points = WeightedSums.of(
            np.concatenate([self.points.counts, more.points.counts]),
            np.concatenate([self.points.hosts, more.points.hosts]),
            np.concatenate([self.points.weights, more.points.weights]),
        )
        first = len(self.points)
        corners, triangles = (
            np.where(table >= more.nodes, table + first, table)
            for table in (more.corners, more.triangles)
        )
        joined = {
            name: np.concatenate([getattr(self, name), getattr(more, name)])
            for name in ("parts", "wholes", "owners", "borders", "cuts")
        }
        return replace(
            self,
            points=points,
            corners=np.concatenate([self.corners, corners]),
            triangles=np.concatenate([self.triangles, triangles]),
            **joined,
        )


class PartTriangles(Struct, frozen=True, eq=False):
    """Triangles that bound parts of solids now, where something can act on them.

    Attributes:
        corners: Nodes, riders among them, as seen from outside, shape (triangle, 3).
        skin: The triangle of the skin as drawn that each is a part of, -1 of cut faces, shape
            (triangle,).
        cuts: The cut that each is a face of, see ``CutCells``, shape (triangle,).
        parts: The part that each bounds, an entity, shape (triangle,).
        planes: Of symmetry, with copies of their nodes and riders.
    """

    corners: Indices
    skin: Indices
    cuts: Indices
    parts: Indices
    planes: tuple[MirrorPlane, ...] = ()

    def on(self, rows: Indices) -> Self:
        """Return those that are parts of some triangles of the skin, shape (n,)."""
        return self.chosen(np.isin(self.skin, rows) & (self.skin >= 0))

    def chosen(self, own: NDArray[np.bool_]) -> Self:
        """Return some; a mask of shape (triangle,)."""
        columns = {n: getattr(self, n)[own] for n in ("corners", "skin", "cuts", "parts")}
        return replace(self, **columns)


def reserved_entities(network: Network, solid: NDArray[np.integer]) -> tuple[Indices, Indices]:
    """Return entities of bodies of solid elements that no element has: those of parts.

    Args:
        solid: Entities of all solid elements, shape (element,).

    Returns:
        Ascending, and the number of the body of each, shape (entity,) each.
    """
    found, of = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    names = [body.name for body in network.bodies]
    for part in network.phantoms:
        whole = network.bodies[names.index(part.body)].elements
        if not ((solid >= whole.start) & (solid < whole.stop)).any():
            continue  # a wall
        found.append(numbers_in(part.elements))
        of.append(np.full(len(found[-1]), names.index(part.body)))
    return np.concatenate(found), np.concatenate(of)


def solid_entities(network: Network) -> Indices:
    """Return the entities of all solid elements, block by block, then of parts, shape (item,).

    Numbers of elements over time are in this order, whatever is cut.
    """
    none = np.zeros(0, dtype=np.int64)
    solid = np.concatenate([none, *(each.walls for each in network.of_kind("elements"))])
    return np.concatenate([solid, reserved_entities(network, solid)[0]])
