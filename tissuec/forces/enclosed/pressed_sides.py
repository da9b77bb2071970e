"""The faces on which pressure acts, and the side towards which it pushes them.

Pressure pushes a solid from outside. It pushes a wall from within: away from the space that the
wall encloses once its rims are closed by flat caps. A wall that encloses nothing, such as a
sheet, has no inside; there a direction says where pressure pushes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross
from tissuec.forces.enclosed.pressed_faces import PressedFaces, WeightedTriangles, faces_of
from tissuec.forces.enclosed.rims import (
    Crossing,
    Rims,
    are_parallel,
    planes_at,
    rims_of,
    within_planes,
)
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.model.topology import pieces

FLAT = 1e-3  # of the area to the power of 3/2: a surface that encloses less volume is a sheet
SHARP = 0.42  # cosine of the angle between normals beyond which an edge parts two patches


class NoSide(ValueError):
    """Pressure cannot act; the message is a sentence without its full stop.

    Attributes:
        hint: The way out.
    """

    def __init__(self, message: str, hint: str):
        super().__init__(message)
        self.hint = hint


class NoInside(NoSide):
    """A wall encloses no space."""


class Pressed(NamedTuple):
    """A set or body that is pressed.

    Attributes:
        name: Of the set or body.
        nodes: Its nodes, ascending, shape (n,).
        is_inside: Whether only faces towards a space within are pressed.
        along: Direction in which a sheet is pressed, shape (3,); None without one.
    """

    name: str
    nodes: Indices
    is_inside: bool = False
    along: Floats | None = None


def pressed_faces(network: Network, pressed: Pressed) -> PressedFaces:
    """Return the faces on which pressure acts, oriented along its push.

    Raises:
        NoSide: There are none, or the direction of the push is not known.
    """
    chosen = np.zeros(network.node_count, dtype=bool)
    chosen[pressed.nodes] = True
    rows = np.flatnonzero(chosen[network.skin].all(axis=1))
    if not len(rows):
        raise NoSide(
            f"{pressed.name} has no complete triangle of a surface on which pressure could act",
            "pressure acts on the surface of a body, or on the triangles of it all of whose "
            "corners are in the set",
        )
    kept, turns = np.zeros(len(rows), dtype=bool), np.zeros(len(rows), dtype=bool)
    for part in network.bodies:
        first = network.skin[rows, 0]
        own = np.flatnonzero((first >= part.nodes.start) & (first < part.nodes.stop))
        if len(own):
            kept[own], turns[own] = _of_body(network, part, rows[own], pressed)
    if not kept.any():
        raise NoSide(
            f"the skin of {pressed.name} encloses no space inside",
            f"name the nodes of the surface that is pressed: set lumen = nodes of "
            f"{pressed.name} where …",
        )
    faces = faces_of(network, rows[kept])
    turned = np.zeros(faces.triples.count, dtype=bool)
    turned[faces.face] = turns[kept][np.searchsorted(rows[kept], faces.rows)]
    return faces.turned(turned)


def _of_body(
    network: Network, part: BodyPart, rows: Indices, pressed: Pressed
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the pressed triangles of a body, and which are pressed against their normal.

    Args:
        rows: The requested triangles of its skin, shape (n,).
        pressed: The pressed set or body.
    """
    start, stop = part.nodes.start, part.nodes.stop
    inside = (network.skin >= start) & (network.skin < stop)
    every = np.flatnonzero(inside.all(axis=1))
    corners, position = network.skin[every].astype(np.int64), network.position
    place = np.searchsorted(every, rows)
    _refuse_branches(network, part, corners)
    if part.is_solid:
        if pressed.along is not None:
            raise NoSide(
                f"pressure on the solid {part.name} acts from outside and takes no direction",
                'remove "along"; a negative pressure pulls',
            )
        kept = np.ones(len(rows), dtype=bool)
        if pressed.is_inside:
            kept = _faces_a_space(position, corners)[place]
        outwards = _volume(position, corners) > 0.0
        return kept, np.full(len(rows), outwards)
    kept = np.ones(len(rows), dtype=bool)
    if pressed.along is not None:
        return kept, np.full(len(rows), _against(position, corners[place], pressed, part))
    turns, component = np.zeros(len(corners), dtype=bool), components(corners)
    for label in np.unique(component[place]):
        own = component == label
        volume = _volume(position, corners[own])
        if abs(volume) <= _smallest(position, corners[own]):
            raise NoInside(
                f"{part.name} encloses no space, so that it has no inside",
                "write the direction in which the pressure pushes: along (0, 0, 1)",
            )
        turns[own] = volume < 0.0
    return kept, turns[place]


def _against(position: Floats, corners: Indices, pressed: Pressed, part: BodyPart) -> bool:
    """Return whether a direction is against the normals of triangles.

    Raises:
        NoSide: It is neither along nor against them.
    """
    a, b, c = position[corners].swapaxes(0, 1)
    areas = cross(b - a, c - a)
    along = float(areas.sum(axis=0) @ pressed.along)
    if abs(along) <= FLAT * float(np.linalg.norm(areas, axis=1).sum()):
        raise NoSide(
            f"{pressed.name} faces as much along this direction as against it",
            f"remove it if {part.name} encloses a space; otherwise write another direction",
        )
    return along < 0.0


def _refuse_branches(network: Network, part: BodyPart, corners: Indices) -> None:
    """Reject a skin that is not a surface with two sides.

    Raises:
        NoSide: An edge has more than two triangles, or its triangles face different ways.
    """
    pairs = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if met := _met_by_more(network, pairs, np.sort(pairs, axis=1), 2):
        raise NoSide(
            f"the skin of {part.name} branches at the edge between the nodes {met}",
            "press a set of nodes on one side of the branch, or repair the mesh",
        )
    if met := _met_by_more(network, pairs, pairs, 1):
        raise NoSide(
            f"the skin of {part.name} has no side: its triangles at the edge between the nodes "
            f"{met} face different ways",
            "list the corners of all triangles counter-clockwise as seen from one side",
        )


def _met_by_more(network: Network, pairs: Indices, alike: Indices, most: int) -> str:
    """Return the nodes of the first edge of more triangles than it may have; "" without one.

    Args:
        pairs: Nodes of the edges of triangles, shape (edge, 2).
        alike: Equal for those that are one edge, shape (edge, 2).
        most: Largest number of triangles that it may have.
    """
    keys = alike[:, 0] * network.node_count + alike[:, 1]
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    if not (count > most).any():
        return ""
    one, other = network.node_ids[pairs[first[np.argmax(count > most)]]]
    return f"{one} and {other}"


def components(corners: Indices) -> Indices:
    """Return the component of each triangle; triangles that share an edge belong to one.

    Args:
        corners: Nodes of the triangles, shape (triangle, 3).

    Returns:
        Numbers from 0, shape (triangle,).
    """
    pairs = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return _joined_at(pairs, np.ones(3 * len(corners), dtype=bool))


def _joined_at(pairs: Indices, holds: NDArray[np.bool_]) -> Indices:
    """Return the component of each triangle.

    Args:
        pairs: Nodes of the edges of triangles, lower ones first, shape (3 triangle, 2).
        holds: Whether an edge joins its triangles, shape (3 triangle,).
    """
    ahead, behind = _beside(pairs)
    joins = holds[ahead] & holds[behind]
    links = np.stack([ahead[joins] // 3, behind[joins] // 3], axis=1)
    return pieces(len(pairs) // 3, links.astype(np.int32)).astype(np.int64)


def _beside(pairs: Indices) -> tuple[Indices, Indices]:
    """Return pairs that are alike, by the indices of one and of the next, shape (n,) each."""
    order = np.lexsort(pairs.T)
    same = (pairs[order[1:]] == pairs[order[:-1]]).all(axis=1)
    return order[1:][same], order[:-1][same]


def _faces_a_space(position: Floats, corners: Indices) -> NDArray[np.bool_]:
    """Return which triangles of the skin of a solid face a space within it.

    The skin is divided at its sharp edges; a patch faces a space if its normals, which point
    out of the solid, point into the volume that the patch encloses with caps on its rims.

    Args:
        corners: Of all triangles of the skin, shape (triangle, 3).
    """
    a, b, c = position[corners].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    pairs = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ahead, behind = _beside(pairs)
    bent = np.einsum("nk,nk->n", normal[ahead // 3], normal[behind // 3]) < SHARP
    holds = np.ones(len(pairs), dtype=bool)
    holds[ahead[bent]] = holds[behind[bent]] = False
    outwards = 1.0 if _volume(position, corners) > 0.0 else -1.0
    found = np.zeros(len(corners), dtype=bool)
    closed = components(corners)
    patches = _joined_at(pairs, holds)
    # A cavity is closed, whatever edges it has.
    for labels in (closed, patches):
        for label in np.unique(labels):
            own = labels == label
            volume = outwards * _volume(position, corners[own])
            found[own] |= volume < -_smallest(position, corners[own])
    return found


def _volume(position: Floats, corners: Indices) -> float:
    """Return the volume that triangles enclose with caps on their rims [m³]."""
    triples = WeightedTriangles(corners, np.ones(len(corners)), np.arange(len(corners) + 1))
    return float(enclosed(position, triples, rims_of(corners, triples.weight)))


def enclosed(
    position: Floats, triples: WeightedTriangles, *rims: Rims, crossing: Crossing | None = None
) -> Floats:
    """Return the volume between weighted triangles and caps on rims [m³], shape (…).

    Args:
        rims: All rims of these.
        crossing: Of the planes of symmetry at which the triangles end.
    """
    # Seen from near one of the nodes, volumes keep their digits far from the origin.
    near = position[..., triples.corners[:1, 0], :]
    from_here = near if crossing is None else crossing.at(near)
    six = _triple(position - from_here, triples.corners, triples.weight)
    for rim in rims:
        x = rim.middles.and_nodes(position) - from_here
        six = six + _triple(x, rim.fans, rim.weight)
    return np.asarray(six / 6.0)


def _triple(x: Floats, corners: Indices, weight: Floats) -> Floats:
    """Return six times the volume under weighted triangles [m³], shape (…)."""
    a, b, c = (x[..., corners[:, k], :] for k in range(3))
    found: Floats = (weight * np.einsum("...k,...k->...", a, cross(b, c))).sum(axis=-1)
    return found


def _smallest(position: Floats, corners: Indices) -> float:
    """Return the volume below which triangles count as enclosing nothing [m³]."""
    a, b, c = position[corners].swapaxes(0, 1)
    area = 0.5 * np.linalg.norm(cross(b - a, c - a), axis=1).sum()
    return float(FLAT * area**1.5)


def closed_by_caps(network: Network, name: str, faces: PressedFaces) -> None:
    """Reject faces whose rims caps cannot close.

    Args:
        name: Of the set or body.

    Raises:
        NoSide: There is no rim, one is not a single loop, or caps enclose nothing.
    """
    planes = network.mirrored
    if are_parallel([one for one in planes if planes_at(faces.corners.ravel(), [one]).any()]):
        raise NoSide(
            f"caps cannot close {name}, which reaches two parallel planes of symmetry",
            "press without caps, and push or hold the ends",
        )
    if not faces.rims.count:
        by = ", together with its mirror image" if faces.planes else ""
        raise NoSide(
            f"{name} is closed{by}, so there is nothing for caps to close",
            'remove "with caps"',
        )
    pairs = faces.corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    keys, count = np.unique(low * network.node_count + high, return_counts=True)
    edges = np.stack(np.divmod(keys[count == 1], network.node_count), axis=1)
    edges = edges[~within_planes(edges, faces.planes)]
    nodes, met = np.unique(edges, return_counts=True)
    met = met * 2 ** planes_at(nodes, faces.planes)
    if (met > 2).any():
        crossing = network.node_ids[nodes[np.argmax(met > 2)]]
        raise NoSide(
            f"caps cannot close {name}: {int(met.max())} edges of its rim meet at the node "
            f"{crossing}",
            "each rim has to be a single loop: add the faces that are missing to the set, or "
            "press without caps",
        )
    volume = enclosed(network.position, faces.triples, faces.rims, crossing=faces.crossing)
    if abs(float(volume)) <= _smallest(network.position, faces.corners):
        raise NoSide(
            f"{name} is flat, so that the pressure on caps would balance that on its faces",
            'remove "with caps"',
        )
