"""Fewer nodes to draw, by clusters of nodes within one cube.

Each cluster is drawn as one of its nodes, so that what is drawn moves as something does that
was computed. The springs between two clusters become one line with the mean of their tensions,
triangles with three different clusters stay (vertex clustering: J. Rossignac, P. Borrel, in
Modeling in Computer Graphics, 1993, pp. 455-465). Nodes of different bodies, or of what is in
pieces at the end, never come together, so that a cut stays open.
"""

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model import topology
from tissuec.model.network import Floats, Indices
from tissuec.results.frame_columns import POSITION
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.lifetimes import FOREVER, Lifetimes


class Thinning(Struct, frozen=True, eq=False):
    """The nodes that are drawn.

    Attributes:
        kept: Rows of the nodes that are drawn, among those of the frames, shape (drawn,).
        place: The one of these that represents each node of the frames, shape (node,).
    """

    kept: Indices
    place: Indices

    @property
    def is_whole(self) -> bool:
        """Return whether all nodes are drawn."""
        return len(self.kept) == len(self.place)

    def nodes(self, found: Lifetimes) -> Lifetimes:
        """Return the lives of those nodes that are drawn."""
        drawn = self.kept[self.place[found.of]] == found.of
        return Lifetimes(self.place[found.of[drawn]], found.life[drawn])


def whole(count: int) -> Thinning:
    """Return a thinning that draws all nodes."""
    return Thinning(np.arange(count), np.arange(count))


def thinned(trajectory: Trajectory, most: int) -> Thinning:
    """Return a limited number of points of a result, as evenly spread as the net."""
    position = trajectory.mesh.at_points(np.asarray(trajectory.position[0], float), POSITION)
    groups = _groups(trajectory)
    if len(np.unique(groups)) >= most:  # such as loose points: every so many of them
        groups = np.zeros_like(groups)
    corner, extent = position.min(axis=0), float(np.ptp(position, axis=0).max())
    low, high = 0.0, 2.0 * extent or 1.0
    for _ in range(40):
        side = 0.5 * (low + high)
        clusters = _clusters(position - corner, side, groups)
        if clusters.max() + 1 > most:
            low = side
        else:
            high = side
        if most * 0.95 < clusters.max() + 1 <= most:
            break
    clusters = _clusters(position - corner, high, groups)
    return Thinning(_middles(position, clusters), clusters)


def _clusters(position: Floats, side: float, groups: Indices) -> Indices:
    """Return the cluster of each node, numbered from 0, shape (node,)."""
    cells = np.floor(position / side).astype(np.int64)
    shape = cells.max(axis=0) + 1
    flat = (cells[:, 0] * shape[1] + cells[:, 1]) * shape[2] + cells[:, 2]
    _, flat = np.unique(flat, return_inverse=True)
    keys = flat.reshape(-1) * (int(groups.max()) + 1) + groups
    return np.unique(keys, return_inverse=True)[1].reshape(-1)


def _middles(position: Floats, clusters: Indices) -> Indices:
    """Return the node nearest to the middle of each cluster, shape (cluster,)."""
    count = np.bincount(clusters)
    middle = np.stack([np.bincount(clusters, axis) / count for axis in position.T], axis=1)
    away = ((position - middle[clusters]) ** 2).sum(axis=1)
    order = np.lexsort((away, clusters))
    return order[np.searchsorted(clusters[order], np.arange(len(count)))]


def _groups(trajectory: Trajectory) -> Indices:
    """Return numbers that differ for points of different bodies or pieces, shape (point,)."""
    cells, mesh = trajectory.cells(-1), trajectory.mesh
    ends = trajectory.ends[np.searchsorted(trajectory.lines, cells.line_numbers)]
    count = mesh.points
    if mesh.cut is not None:  # whose parts have no lines
        for _, _, own in mesh.solids.some(cells.elements).by_shape():
            pairs = np.stack([np.roll(own, 1, axis=1), own], axis=2).reshape(-1, 2)
            ends = np.concatenate([ends, pairs])
    labels = np.asarray(topology.pieces(count, ends.astype(np.int32)))
    bodies = np.zeros(count, dtype=np.int64)
    for number, body in enumerate(trajectory.network.bodies):
        inside = (mesh.representatives >= body.nodes.start) & (
            mesh.representatives < body.nodes.stop
        )
        bodies[inside] = number
    # A node by itself is no piece: it would be kept whatever the net around it.
    alone = np.bincount(labels)[labels] == 1
    return np.where(alone, 0, labels + 1) * (int(bodies.max(initial=0)) + 1) + bodies


class SpringLines(Struct, frozen=True, eq=False):
    """The lines that are drawn for the springs.

    Attributes:
        of: Strand of each spring, -1 within a cluster, shape (spring,).
        ends: Shape (strand, 2).
        first: A spring of each strand, shape (strand,).
    """

    of: Indices
    ends: Indices
    first: Indices

    def mean(self, values: NDArray[Any], chosen: Indices) -> tuple[Floats, Indices]:
        """Return the means over some springs in the unit of ``values``, and their strands.

        Args:
            values: In any unit, shape (chosen,).
            chosen: Springs, shape (chosen,).
        """
        at = self.of[chosen]
        values, at = values[at >= 0], at[at >= 0]
        count = np.bincount(at, minlength=len(self.ends))
        there = np.flatnonzero(count)
        sums = np.bincount(at, values, minlength=len(self.ends))
        return sums[there] / count[there], there

    def lives(self, springs: Lifetimes) -> Lifetimes:
        """Return from when until when any spring of each strand is there."""
        if len(self.ends) == len(self.of):
            return springs
        at = self.of[springs.of]
        life, at = springs.life[at >= 0], at[at >= 0]
        births, deaths = np.full(len(self.ends), FOREVER), np.zeros(len(self.ends))
        np.minimum.at(births, at, life[:, 0])
        np.maximum.at(deaths, at, life[:, 1])
        return Lifetimes(np.arange(len(self.ends)), np.stack([births, deaths], axis=1))


def strands(thinning: Thinning, ends: Indices) -> SpringLines:
    """Return the lines that are drawn for springs with these ends, shape (spring, 2)."""
    numbers = np.arange(len(ends))
    if thinning.is_whole:
        return SpringLines(numbers, ends, numbers)
    pairs = np.sort(thinning.place[ends], axis=1)
    apart = pairs[:, 0] != pairs[:, 1]
    of = np.full(len(ends), -1)
    drawn, first, inverse = np.unique(
        pairs[apart], axis=0, return_index=True, return_inverse=True
    )
    of[apart] = inverse.reshape(-1)
    return SpringLines(of, drawn.reshape(-1, 2), numbers[apart][first])


def thin_triangles(
    thinning: Thinning, triangles: NDArray[np.integer], life: Floats
) -> tuple[NDArray[np.integer], Indices, Floats]:
    """Return triangles between drawn nodes, one of those that each represents, and their lives.

    Args:
        thinning: The clusters.
        triangles: Corners, shape (triangle, 3).
        life: Of the triangles, in units of frames, shape (triangle, 2).
    """
    numbers = np.arange(len(triangles))
    if thinning.is_whole or not len(triangles):
        return triangles, numbers, life
    corners = thinning.place[triangles]
    # The smallest first, so that turned ones are alike and keep their front.
    turn = (np.argmin(corners, axis=1)[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(corners, turn, axis=1)
    apart = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    drawn, first, inverse = np.unique(
        corners[apart], axis=0, return_index=True, return_inverse=True
    )
    births, deaths = np.full(len(drawn), FOREVER), np.zeros(len(drawn))
    np.minimum.at(births, inverse.reshape(-1), life[apart, 0])
    np.maximum.at(deaths, inverse.reshape(-1), life[apart, 1])
    return drawn.reshape(-1, 3), numbers[apart][first], np.stack([births, deaths], axis=1)
