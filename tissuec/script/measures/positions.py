"""Where things are, how fast they move, and how far apart they are."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.arrays import distinct, dot
from tissuec.model.network import Floats, Indices
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, VectorMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("position")
class Position(VectorMeasure):
    """The mean position of the nodes of A; NaN if a tool holds nothing."""

    form = "position(A)"
    dimension = units.LENGTH
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return snapshot.mean(subjects[0], snapshot.position)


@MEASURES.member("speed")
class Speed(ScalarMeasure):
    """The speed of the fastest node of A; 0 if A has no nodes."""

    form = "speed(A)"
    dimension = units.VELOCITY
    needs = ("motion",)
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        if subjects[0].weights is not None:
            own = snapshot.mean(subjects[0], snapshot.velocity)
            return one_column(np.linalg.norm(own, axis=-1), snapshot)
        velocity = snapshot.velocity[..., snapshot.nodes(subjects[0]), :]
        speed = np.linalg.norm(velocity, axis=-1)
        return one_column(speed.max(axis=-1, initial=0.0), snapshot)


@MEASURES.member("distance")
class Distance(ScalarMeasure):
    """The distance between the mean positions of A and of B; NaN if a tool holds nothing."""

    form = "distance(A, B)"
    dimension = units.LENGTH
    subjects = 2
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        first, second = (Position.sample((subject,), snapshot) for subject in subjects)
        return one_column(np.linalg.norm(second - first, axis=-1), snapshot)


FEW = 400  # points up to which comparing each with each is quicker than a sweep
CHUNK = 64  # points compared at a time with those ahead: small beside the caches for any body


@MEASURES.member("gap")
class Gap(ScalarMeasure):
    """The smallest distance between nodes of A in different pieces of the net.

    Where blades have divided elements, corners of the faces or edges of cuts count as well. 0
    as long as A is in one piece.
    """

    form = "gap(A)"
    dimension = units.LENGTH
    needs = ("division",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        nodes = snapshot.nodes(subjects[0])
        position, piece = snapshot.position[..., nodes, :], snapshot.pieces[nodes]
        if snapshot.state.cut_cells is not None:
            position, piece = _of_matter(snapshot, nodes)
        before = position.shape[:-2]
        states = position.reshape(math.prod(before), *position.shape[-2:])
        return one_column(smallest_gaps(states, piece).reshape(before), snapshot)


def _of_matter(snapshot: Snapshot, nodes: Indices) -> tuple[Floats, NDArray[np.int32]]:
    """Return places of nodes with matter and of corners of surfaces, and the piece of each.

    Copies of nodes are beyond the cut that they are made by, where there is no matter.

    Args:
        nodes: With their copies, shape (n,).
    """
    state, cut = snapshot.state, snapshot.state.cut_cells
    assert cut is not None
    chosen = np.zeros(cut.nodes, dtype=bool)
    chosen[nodes] = True
    corners = cut.triangles[state.alive[cut.borders]]
    points = distinct(corners[corners >= cut.nodes]) - cut.nodes
    hosts = cut.points.hosts[cut.points.first[points]]
    points, hosts = points[chosen[hosts]], hosts[chosen[hosts]]
    drawn = nodes[state.network.parents[nodes] == nodes]
    of_points = cut.points.weighted(np.moveaxis(snapshot.position, -2, 0))[points]
    places = [snapshot.position[..., drawn, :], np.moveaxis(of_points, 0, -2)]
    return (
        np.concatenate(places, axis=-2),
        np.concatenate([snapshot.pieces[drawn], snapshot.pieces[hosts]]),
    )


def smallest_gaps(states: Floats, piece: NDArray[np.int32]) -> Floats:
    """Return the smallest distance between points of different pieces; 0 for a single piece.

    Args:
        states: Points [m], shape (state, point, 3).
        piece: The piece of each, shape (point,).
    """
    pieces = distinct(piece)
    if len(pieces) < 2:
        return np.zeros(len(states))
    if len(piece) > FEW:
        return np.array([_swept(state, piece) for state in states])
    pairs = [(piece == one, piece > one) for one in pieces[:-1]]
    return np.array([min(_closest(state[a], state[b]) for a, b in pairs) for state in states])


def _closest(some: Floats, others: Floats) -> float:
    """Return the smallest distance of some points from others [m], shape (point, 3)."""
    apart = some[:, None] - others
    return float(np.sqrt(dot(apart, apart).min()))


def _swept(position: Floats, piece: NDArray[np.int32]) -> float:
    """Return the smallest distance in one state.

    Points are swept along the longest side of their box: what lies further ahead than the best
    distance so far needs no comparison.

    Args:
        position: Points [m], shape (point, 3).
        piece: The piece of each, shape (point,).
    """
    axis = int(np.ptp(position, axis=0).argmax())
    order = np.argsort(position[:, axis], kind="stable")
    position, piece = position[order], piece[order]
    best = np.inf
    for start in range(0, len(position), CHUNK):
        stop = min(start + CHUNK, len(position))
        reach = int(
            np.searchsorted(
                position[:, axis], float(position[stop - 1, axis]) + best, side="right"
            )
        )
        apart = position[start:stop, None, :] - position[None, start:reach, :]
        is_other = piece[start:stop, None] != piece[None, start:reach]
        squared = dot(apart, apart)
        best = min(best, float(np.sqrt(squared.min(where=is_other, initial=np.inf))))
    return best
