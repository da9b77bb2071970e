"""Nodes and shapes that may touch: which are near one another, and where.

A shape is a capsule, a plane or a triangle; see ``forces.contact``.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import distinct, norm
from tissuec.forces.contact.points import ContactPoints
from tissuec.forces.contact.sides import Meetings, kept_outside
from tissuec.forces.contact.sides_kernel import ALIKE
from tissuec.forces.fields import Field
from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.geometry.inclusion import weights
from tissuec.geometry.nearest import PLANE, TRIANGLE, NearestPlace, places
from tissuec.geometry.neighbours import (
    are_between,
    in_balls,
    nearest_triangles,
    triangles_within,
)
from tissuec.model.network import Floats, Indices

FEW = 12  # faces up to which all pairs are examined
MOST_COMPARED = 200_000  # pairs that an exhaustive search compares: as fast as a tree's


class ContactPairs(NamedTuple):
    """Nodes and shapes that may touch, ascending by node, then by surface and shape.

    Attributes:
        node: Numbers among the nodes of the contact, shape (pair,).
        shape: Numbers of shapes, shape (pair,).
        weight: How often the shape counts for this node, shape (pair,).
        radius: At which it touches this node [m], shape (pair,).
        sided: Kind of the surface, ``CLOSED`` or ``TORN``, if it is a triangle that determines
            on which side of it the node is, else 0, shape (pair,).
    """

    node: Indices
    shape: Indices
    weight: Floats
    radius: Floats
    sided: Indices

    def some(self, which: NDArray[np.bool_] | Indices) -> "ContactPairs":
        """Return a selection of pairs, by a mask of shape (pair,) or indices of shape (n,)."""
        columns: Any = (column[which] for column in self)
        return ContactPairs(*columns)

    def and_others(self, others: "ContactPairs") -> "ContactPairs":
        """Return these pairs followed by others."""
        columns: Any = map(np.concatenate, zip(self, others, strict=True))
        return ContactPairs(*columns)


class NearShapes(Field, frozen=True, dict=True):
    """Nodes and shapes that can touch.

    The first shapes are faces (triangles, capsules, planes), the others elements that these
    share, as capsules.

    Attributes:
        nodes: Nodes that can be touched, ascending, followed by points, shape (m,).
        owner: Body of each, or -1 of a point on the axis of a tool, shape (m,).
        size: Radius of the thread or axis that each belongs to [m], else 0, shape (m,).
        kind: ``CAPSULE``, ``PLANE`` or ``TRIANGLE``, shape (shape,).
        points: Nodes that carry each shape, shape (shape, 3): both ends of a capsule, a point
            of a plane and one straight in front of it, with the second one again; corners.
        surface: To which surface or line each belongs, shape (shape,).
        parts: Elements of each shape, see ``geometry.inclusion.Shared``, shape (shape, 6).
        radius: Around the line of a capsule or a triangle [m], shape (face,); a triangle
            touches nodes of a thread at the radius of the thread, if that is more.
        spared: Body whose nodes a face does not touch, -1 without one, shape (face,).
        bonds: Springs of which one must be intact for a capsule to touch, -1 for none, shape
            (face, 2).
        edges: Supports of the edges of the triangles, shape (triangle, 3).
        joined: Pairs of nodes that springs join, so that what one of them carries does not
            touch the other: lower node times number of all nodes plus upper node, ascending,
            shape (pair,).
        stride: Longest way of a node in a step, lest it passes through a shape unseen [m].
        between: The points between nodes; None without any.
        meetings: Which nodes may touch which faces.
        whole: Which faces are neither cut nor torn, shape (face,).
        there: Which nodes are not on torn faces, shape (m,).
        exhaustive: Whether every node is compared with every face, if there are not too many.
    """

    nodes: Indices
    owner: Indices
    size: Floats
    kind: Indices
    points: Indices
    surface: Indices
    parts: Indices
    radius: Floats
    spared: Indices
    bonds: Indices
    edges: SupportedEdges
    joined: Indices
    stride: float
    meetings: Meetings
    whole: NDArray[np.bool_]
    there: NDArray[np.bool_]
    between: ContactPoints | None = None
    exhaustive: bool = False

    def near(self, position: Floats, margin: float) -> ContactPairs:
        """Return the nodes that are less than a margin [m] outside of shapes."""
        nodes, position = len(position), self._with_points(position)
        node, face = self._candidates(position, margin)
        flat, radius = self.kind[face] == TRIANGLE, self._radii(node, face)
        pairs = ContactPairs(node, face, np.ones(len(node)), radius, np.zeros_like(node))
        reach = margin * (1.0 + self._lever(position, node, face))
        pairs = pairs.some(
            (self._places(position, pairs).depth > -reach) & (~flat | (radius > 0.0))
        )
        if self.meetings.is_sided:
            pairs = self._with_sides(position, pairs, margin)
        pairs = pairs.some(~self._are_joined(pairs, nodes))
        shared = self._shared(pairs.some(pairs.radius > 0.0))
        close = self._places(position, shared).depth > -margin
        every = pairs.and_others(shared.some(close))
        return every.some(np.lexsort((every.shape, self.surface[every.shape], every.node)))

    def _radii(self, node: Indices, face: Indices) -> Floats:
        """Return the radii at which faces touch nodes [m], shape (pair,)."""
        radius = self.radius[face]
        thick = np.where(self.owner[node] < 0, 0.0, radius)
        flat = self.kind[face] == TRIANGLE
        found = np.where(flat, np.maximum(thick, self.size[node]), radius)
        table = self.meetings
        own = table.distances[table.group[node], table.of[face]]
        return np.where(np.isnan(own), found, own)

    def _with_sides(self, position: Floats, pairs: ContactPairs, margin: float) -> ContactPairs:
        """Return pairs with the triangles that determine the sides of points, at any depth.

        Args:
            position: Of nodes and points [m], shape (node + point, 3).
            pairs: Those that may touch.
        """
        table, node, face = self.meetings, [pairs.node], [pairs.shape]
        for column in np.flatnonzero(table.sided.any(axis=0)):
            points = np.flatnonzero((table.sided[table.group, column] > 0) & self.there)
            faces = np.flatnonzero((table.of == column) & self.whole)
            if not len(faces):
                continue
            near = position[self.nodes[points]], position, self.points[faces]
            if (depth := table.depths.get(int(column))) is None:
                found = nearest_triangles(*near, margin, table.closed[int(column)])
            else:
                found = triangles_within(*near, depth, margin)
            node.append(points[found.point])
            face.append(faces[found.triangle])
        count = len(self.radius)
        key, own = np.unique(
            np.concatenate(node) * count + np.concatenate(face), return_inverse=True
        )
        own, (point, triangle) = own.reshape(-1), np.divmod(key, count)
        sides = np.zeros(len(key), dtype=bool)
        sides[own[len(pairs.node) :]] = True
        # All triangles that touch a point are near if those that tell its side are.
        surface = self.surface[triangle]
        beside = point * (1 + int(self.surface.max())) + surface
        sides |= np.isin(beside, beside[sides]) & (self.kind[triangle] == TRIANGLE)
        radius = self._radii(point, triangle)
        kind = np.where(sides, table.sided[table.group[point], table.of[triangle]], 0)
        return ContactPairs(point, triangle, np.ones(len(key)), radius, kind)

    def _shared(self, pairs: ContactPairs) -> ContactPairs:
        """Return the elements that faces near a node share, and which count."""
        counted = weights(pairs.node, pairs.shape, self.parts)
        return ContactPairs(
            pairs.node[counted.row],
            counted.element,
            counted.weight.astype(float),
            pairs.radius[counted.row],
            np.zeros_like(counted.element),
        )

    def _candidates(self, position: Floats, margin: float) -> tuple[Indices, Indices]:
        """Return pairs of nodes and whole faces that may touch.

        Pairs of a face with a body that it spares, or with a node that carries it, are left
        out.

        Args:
            position: Of nodes and points [m], shape (node + point, 3).
        """
        node, face = self._found(position, margin, np.flatnonzero(self.whole))
        apart = (self.points[face] != self.nodes[node][:, None]).all(axis=1)
        spared, table = self.spared[face], self.meetings
        apart &= ((self.owner[node] != spared) | (spared < 0)) & self.there[node]
        apart &= table.meets[table.group[node], table.of[face]]
        return node[apart], face[apart]

    def _found(
        self, position: Floats, margin: float, faces: Indices
    ) -> tuple[Indices, Indices]:
        """Return pairs of nodes and some faces; of many, only near ones."""
        if len(faces) <= FEW:
            return _all_pairs(np.arange(len(self.nodes)), faces)
        endless = self.kind[faces] == PLANE
        # Triangles without a radius of their own touch threads only.
        thin = (self.kind[faces] == TRIANGLE) & (self.radius[faces] == 0.0)
        found = [_all_pairs(np.arange(len(self.nodes)), faces[endless])]
        for body in distinct(self.spared[faces]):
            spares = self.spared[faces] == body
            everyone = np.flatnonzero((self.owner != body) | (body < 0))
            threads = everyone[self.size[everyone] > 0.0]
            found += [
                self._around(position, margin, everyone, faces[spares & ~endless & ~thin]),
                self._around(position, margin, threads, faces[spares & thin]),
            ]
        node, face = (np.concatenate(each) for each in zip(*found, strict=True))
        return node, face

    def _around(
        self, position: Floats, margin: float, node: Indices, face: Indices
    ) -> tuple[Indices, Indices]:
        """Return pairs whose node is in a ball about the face, and in a box around it."""
        x, (a, b, c) = position[self.nodes[node]], position[self.points[face].T]
        middle = (a + b + c) / 3.0
        size = np.max([norm(corner - middle) for corner in (a, b, c)], axis=0)
        flat = self.kind[face] == TRIANGLE
        thick = np.where(flat, self.size[node].max(initial=0.0), 0.0)
        reach = np.maximum(self.radius[face], thick) + margin
        low = np.minimum(np.minimum(a, b), c) - reach[:, None]
        high = np.maximum(np.maximum(a, b), c) + reach[:, None]
        if self.exhaustive and len(x) * len(face) <= MOST_COMPARED:
            everywhere = np.logical_and(x >= low[:, None], x <= high[:, None]).all(axis=2)
            ball, point = np.nonzero(everywhere)
            return node[point], face[ball]
        ball, point = in_balls(middle, size + reach, x)
        close = are_between(x[point], low[ball], high[ball])
        return node[point[close]], face[ball[close]]

    def _lever(self, position: Floats, node: Indices, face: Indices) -> Floats:
        """Return how much further than its points a plane goes where nodes are, turning."""
        lever = np.zeros(len(node))
        flat = self.kind[face] == PLANE
        point, ahead = position[self.points[face[flat], :2]].swapaxes(0, 1)
        away = np.linalg.norm(position[self.nodes[node[flat]]] - point, axis=1)
        lever[flat] = away / np.linalg.norm(ahead - point, axis=1)
        return lever

    def _are_joined(self, pairs: ContactPairs, nodes: int) -> NDArray[np.bool_]:
        """Return which nodes are joined by springs to a corner of their faces.

        Args:
            nodes: Number of all nodes.
        """
        if not len(self.joined):
            return np.zeros(len(pairs.node), dtype=bool)
        here, corners = self.nodes[pairs.node], self.points[pairs.shape]
        # Points are joined as the nodes that carry them are.
        joined = self._have_key(here[:, None], corners, nodes) & (here < nodes)
        if self.between is not None:
            own = np.flatnonzero(here >= nodes)
            for a in range(3):
                carrier = self.between.corners[here[own] - nodes, a][:, None]
                joined[own] |= self._have_key(carrier, corners[own], nodes)
                joined[own] |= (carrier == corners[own]).any(axis=1)
        return joined

    def _have_key(self, here: Indices, corners: Indices, nodes: int) -> NDArray[np.bool_]:
        """Return which nodes, shape (pair, 1), springs join to corners, shape (pair,)."""
        keys = np.minimum(here, corners) * nodes + np.maximum(here, corners)
        place = np.searchsorted(self.joined, keys).clip(max=len(self.joined) - 1)
        return np.asarray((self.joined[place] == keys).any(axis=1))

    def places(self, position: Floats, pairs: ContactPairs) -> NearestPlace:
        """Return the nearest places of the shapes to the nodes of pairs.

        Args:
            pairs: Nodes and shapes.
        """
        return self._places(self._with_points(position), pairs)

    def _with_points(self, position: Floats) -> Floats:
        """Return positions of nodes, followed by those of points [m], shape (…, n, 3)."""
        return position if self.between is None else self.between.behind(position)

    def _places(self, position: Floats, pairs: ContactPairs) -> NearestPlace:
        x, corners = position[self.nodes[pairs.node]], position[self.points[pairs.shape]]
        return self._sided(
            pairs, places(x, self.kind[pairs.shape], corners, pairs.radius), corners
        )

    def _sided(
        self,
        pairs: ContactPairs,
        place: NearestPlace,
        corners: Floats,
        state: Indices | int = 0,
    ) -> NearestPlace:
        """Return places in shapes, with the signs of depths of points inside of solids.

        Args:
            pairs: In one state or several.
            place: Without signs.
            corners: Of the shapes [m], shape (pair, 3, 3).
            state: Number of each state by pairs, shape (pair,), or 0 for one state.
        """
        if not pairs.sided.any():
            return place
        surfaces = 1 + int(self.surface.max())
        group = (state * len(self.nodes) + pairs.node) * surfaces + self.surface[pairs.shape]
        return kept_outside(place, corners, pairs.radius, pairs.sided, group, self.alike)

    @property
    def alike(self) -> float:
        """Return a length below which distances from surfaces are equal [m]."""
        return ALIKE * self.stride

    def are_at(self, nodes: Indices) -> NDArray[np.bool_]:
        """Return which nodes are among the given ones, and which points lie between these.

        Args:
            nodes: Indices, shape (n,).

        Returns:
            Shape (m,).
        """
        found = np.isin(self.nodes, nodes)
        if self.between is not None:
            corners = self.between.corners
            found[len(found) - len(corners) :] = np.isin(corners, nodes).any(axis=1)
        return found

    def has_points_on(self, nodes: slice) -> bool:
        """Return whether contact acts on faces between the given nodes."""
        return self.between is not None and bool(len(self.between.on(nodes)))

    def points_on(self, nodes: slice, position: Floats) -> tuple[Floats, Indices, Indices]:
        """Return the positions and numbers of the points on faces between nodes.

        Args:
            nodes: Those of a body.

        Returns:
            Positions [m], shape (n, 3); numbers among the nodes of the contact, shape (n,);
            numbers of their faces, shape (n,).
        """
        assert self.between is not None, "otherwise there are no points"
        own = self.between.on(nodes)
        first = len(self.nodes) - len(self.between.corners)
        # Some points act against a single body.
        table = self.meetings
        tools = table.of[self.kind[: len(table.of)] != TRIANGLE]
        own = own[table.meets[table.group[first + own]][:, tools].any(axis=1)]
        where = self._with_points(position)[len(position) + own]
        return where, first + own, self.between.face[own]

    def is_thin(self, radius: float) -> bool:
        """Return whether tools of a radius [m] have points along their axes."""
        return bool((self.size[self.owner < 0] == radius).any())


def _all_pairs(node: Indices, face: Indices) -> tuple[Indices, Indices]:
    return np.tile(node, len(face)), np.repeat(face, len(node))
