"""Readings of contact: what touches where and how hard, and what is kept outside of solids.

Shared arguments:
    contact: That of a scene.
    nodes: Indices, shape (n,).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.contact.contact import Contact
from tissuec.forces.contact.points import NO_FACE
from tissuec.forces.fields import in_line
from tissuec.geometry.nearest import TRIANGLE
from tissuec.model.network import Floats, Indices


class Sunk(NamedTuple):
    """Points and nodes that are inside of solids.

    Attributes:
        owner: Body of each, shape (n,).
        body: The solid, shape (n,).
        depth: [m], shape (n,).
    """

    owner: Indices
    body: Indices
    depth: Floats


class Extent(NamedTuple):
    """How much of faces is in contact, for each of some states.

    Attributes:
        area: Of the points on faces that are touched, as the faces are now [m²], shape (…).
        depth: The largest one [m], shape (…).
        force: Sum of the normal forces on these points, without damping [N], shape (…).
    """

    area: Floats
    depth: Floats
    force: Floats


def keeps_outside(contact: Contact, line: slice, body: slice, alive: NDArray[np.bool_]) -> bool:
    """Return whether all of a tool or a thread is kept outside of a body at any depth.

    Args:
        line: Nodes of the tool or thread.
        body: Nodes of the body.
        alive: Springs that are there, shape (spring,).
    """
    table, points = contact.intact(alive).meetings, contact.between
    if not table.is_sided or points is None:
        return False
    first = points.corners[:, 0]
    lies = (first >= line.start) & (first < line.stop) & (points.face == NO_FACE)
    own = table.group[-len(first) :][lies]
    corner = contact.points[: len(contact.radius), 0]
    faces = table.of[(corner >= body.start) & (corner < body.stop)]
    where = np.ix_(np.unique(own), np.unique(faces))
    return bool(len(own)) and bool(table.sided[where].all())


def keeps_apart(contact: Contact, one: slice, other: slice) -> bool:
    """Return whether the surface of a body keeps another body outside at any depth.

    Args:
        one: Nodes of the body that is kept outside.
        other: Nodes of the body with the surface.
    """
    table, corner = contact.meetings, contact.points[: len(contact.radius), 0]
    faces = table.of[
        (contact.kind[: len(corner)] == TRIANGLE)
        & (corner >= other.start)
        & (corner < other.stop)
    ]
    own = contact.owner == contact.owner[one.start]
    kept = (table.sided > 0) & np.isfinite(table.distances)
    where = np.ix_(np.unique(table.group[own]), np.unique(faces))
    return bool(kept[where].any())


def depths_inside(contact: Contact, position: Floats) -> Sunk:
    """Return how deep points and nodes are inside of solids that push them out."""
    pairs, place = contact.pressed(position)
    table = contact.meetings
    shape = np.minimum(pairs.shape, len(table.of) - 1)
    kept = np.isfinite(table.distances[table.group[pairs.node], table.of[shape]])
    own = np.flatnonzero((pairs.sided > 0) & kept & (place.depth > pairs.radius))
    # What overlaps as drawn has a radius below zero, and is no deeper than since then.
    depth = place.depth[own] - np.maximum(pairs.radius[own], 0.0)
    owner = contact.owner[pairs.node[own]]
    body = contact.owner[contact.points[pairs.shape[own], 0]]
    return Sunk(owner, body, depth)


def extent_at(contact: Contact, nodes: Indices, position: Floats) -> Extent:
    """Return the extent of contact of shapes that some nodes carry.

    Shapes of tools and threads, and nodes and points on faces, count if all of their
    carriers are among the nodes.
    """
    on, by, below = _carried(contact, nodes, position.shape[-2])
    found: list[tuple[float, float, float]] = []
    states = in_line(position)
    for state, (pairs, place) in zip(states, contact.pressed_in(states), strict=True):
        own = (on[pairs.node] | by[pairs.shape]) & (pairs.weight > 0.0)
        touched = np.unique(pairs.node[own])
        # Both sides of a gap have points, each of which presses on the other side too.
        times = (on[pairs.node] | by[pairs.shape]) + 1.0 * below[pairs.shape]
        force = times * pairs.weight * contact.pressure(pairs, place.depth)
        force = force[_on_faces(contact, pairs.node)[0]].sum()
        deepest = place.depth[own].max(initial=0.0)
        found.append((_areas(contact, touched, state), float(deepest), float(force)))
    each = np.reshape(found, (*position.shape[:-2], 3))
    return Extent(each[..., 0], each[..., 1], each[..., 2])


def pressures(contact: Contact, position: Floats) -> Floats:
    """Return the pressure of contact at the nodes of faces [Pa].

    Σ p_a A_a is the sum of all normal forces on faces, where A_a is a third of the present
    area of each touched triangle around a node; of each triangle if none has a point that
    is touched, as below a thin tool. Damping of contact is no part of the forces.

    Returns:
        Shape (…, node).
    """
    found = np.zeros(position.shape[:-1])
    points = contact.between
    if points is None:
        return found
    states, rows = in_line(position), found.reshape(-1, position.shape[-2])
    for state, row, (pairs, place) in zip(
        states, rows, contact.pressed_in(states), strict=True
    ):
        on, own = _on_faces(contact, pairs.node)
        force = pairs.weight * contact.pressure(pairs, place.depth)
        _add(row, points.corners[own], points.shares[own] * force[on, None])
        below = contact.kind[pairs.shape] == TRIANGLE
        weights = place.weights[below] * force[below, None]
        _add(row, contact.points[pairs.shape[below]], weights)
        third = np.repeat(points.drawn * points.stretch(state) / 3.0, 3).reshape(-1, 3)
        touched = np.unique(points.face[own[pairs.weight[on] > 0.0]])
        area, every = np.zeros((2, len(row)))
        _add(area, points.triangles[touched], third[touched])
        _add(every, points.triangles, third)
        area = np.where(area > 0.0, area, every)
        row /= np.where(area > 0.0, area, np.inf)
    return found


def comes_near(contact: Contact, nodes: Indices, position: Floats, within: float) -> bool:
    """Return whether shapes that some nodes carry are closer to others than a distance.

    Args:
        within: The distance [m].
    """
    on, by, _ = _carried(contact, nodes, len(position))
    pairs = contact.near(position, within)
    pairs = pairs.some(np.flatnonzero(on[pairs.node] | by[pairs.shape]))
    place = contact.places(position, pairs)
    return bool((place.depth > -within).any())


def _on_faces(contact: Contact, points: Indices) -> tuple[NDArray[np.bool_], Indices]:
    """Return which of some nodes and points are on faces, and their numbers among points.

    Args:
        points: Numbers of nodes and points of contact, shape (n,).
    """
    if contact.between is None:
        return np.zeros(len(points), dtype=bool), points[:0]
    own = points - (len(contact.nodes) - len(contact.between.corners))
    on = (own >= 0) & (contact.between.face[own] != NO_FACE)
    return on, own[on]


def _areas(contact: Contact, touched: Indices, position: Floats) -> float:
    """Return the present area that some nodes and points represent [m²].

    Args:
        touched: Their numbers, shape (n,).
    """
    _, own = _on_faces(contact, touched)
    points = contact.between
    if points is None or not len(own):
        return 0.0
    return float(points.areas[own] @ points.stretch(position)[points.face[own]])


def _carried(contact: Contact, nodes: Indices, count: int) -> tuple[NDArray[np.bool_], ...]:
    """Return which points, shapes of tools, and triangles are carried by some nodes alone.

    Args:
        count: Number of all nodes.
    """
    carries = np.zeros(count, dtype=bool)
    carries[nodes] = True
    all_, is_face = carries[contact.points].all(axis=1), contact.kind == TRIANGLE
    on, own = np.zeros(len(contact.nodes), dtype=bool), len(contact.nodes)
    if contact.between is not None:
        own -= len(contact.between.corners)
        on[own:] = carries[contact.between.corners].all(axis=1)
    on[:own] = carries[contact.nodes[:own]]
    return on, all_ & ~is_face, all_ & is_face


def _add(to: Floats, nodes: Indices, values: Floats) -> None:
    """Add values of any unit at nodes; all are of shape (n, 3) but ``to``, of shape (node,)."""
    to += np.bincount(nodes.ravel(), values.ravel(), len(to))
