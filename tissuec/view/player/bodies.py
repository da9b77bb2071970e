"""Solid shapes as triangles, with the lighting of the page (``web/shared.glsl``)."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.model.network import Floats
from tissuec.view.player.rules import RULES

_LAMP = np.array(RULES.lamp) / np.linalg.norm(RULES.lamp)
_SHARP = np.cos(np.radians(50.0))  # between faces, beyond which an edge is seen


class TriangleMesh(NamedTuple):
    """Triangles by their corners.

    Attributes:
        corners: [m], shape (triangle, 3, 3).
        normals: At the corners, shape (triangle, 3, 3).
    """

    corners: Floats
    normals: Floats


def across(axis: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors at right angles to each axis and to each other, shape (…, 3).

    Args:
        axis: Unit vectors, dimensionless, shape (…, 3).
    """
    upright = np.abs(axis[..., 2:]) < 0.9
    side = np.where(upright, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    right = np.cross(side, axis)
    right = np.asarray(right / np.linalg.norm(right, axis=-1, keepdims=True), dtype=float)
    return right, np.asarray(np.cross(axis, right), dtype=float)


def capsules(first: Floats, second: Floats, radius: Floats, *, sides: int = 24) -> TriangleMesh:
    """Return rods with round ends, or spheres where both ends are one point.

    Args:
        first, second: Middles of their ends [m], shape (rod, 3).
        radius: [m], shape (rod,).
        sides: Around each.
    """
    axis, around = _frames(second - first, sides)
    quarter = np.linspace(0.0, np.pi / 2.0, sides // 4 + 1)
    rings: list[Floats] = []
    normals: list[Floats] = []
    for middle, angles in ((first, quarter - np.pi / 2.0), (second, quarter)):
        for angle in angles:
            normal = np.cos(angle) * around + np.sin(angle) * axis
            rings.append(middle + radius[:, None] * normal)
            normals.append(normal)
    return _joined(np.array(rings), np.array(normals))


def along_rods(mesh: TriangleMesh, first: Floats, second: Floats, values: Floats) -> Floats:
    """Interpolate values at the ends of rods to corners, shape (triangle, 3).

    Args:
        mesh: Of ``capsules``.
        first, second: Middles of the ends of the rods [m], shape (rod, 3).
        values: At these, in any unit, shape (rod, 2).
    """
    each = len(mesh.corners) // max(len(first), 1)  # triangles of a rod
    way, foot = (np.repeat(one, each, axis=0)[:, None] for one in (second - first, first))
    length = np.maximum((way * way).sum(axis=-1), 1e-300)
    part = np.clip(((mesh.corners - foot) * way).sum(axis=-1) / length, 0.0, 1.0)
    begin, end = np.repeat(values, each, axis=0).T[..., None]
    return np.asarray(begin + part * (end - begin), dtype=float)


def arrows(foot: Floats, arrow: Floats, thick: float, *, sides: int = 10) -> TriangleMesh:
    """Return arrows as triangles; see the shader.

    Args:
        foot: Where they begin [m], shape (arrow, 3).
        arrow: Vectors [m], shape (arrow, 3).
        thick: Thickness [m].
        sides: Number of sides of a shaft.
    """
    length = np.linalg.norm(arrow, axis=1)
    slim = np.minimum(1.0, length / (9.0 * thick)) * thick
    head = np.minimum(6.0 * slim, 0.45 * length)
    axis, around = _frames(arrow, sides)
    rings: list[Floats] = []
    normals: list[Floats] = []
    for along, wide, slope in (
        (0.0 * length, slim, 0.0),
        (length - head, slim, 0.0),
        (length - head, 2.4 * slim, 0.4),
        (length, 0.0 * slim, 0.4),
    ):
        middle = foot + along[:, None] * axis
        rings.append(middle + wide[:, None] * around)
        normals.append(around + slope * axis)
    return _joined(np.array(rings), np.array(normals))


def _frames(way: Floats, sides: int) -> tuple[Floats, Floats]:
    """Return axes, shape (solid, 3), and directions around them, shape (side, solid, 3)."""
    length = np.linalg.norm(way, axis=1, keepdims=True)
    axis = np.where(length > 0.0, way / np.maximum(length, 1e-300), [0.0, 0.0, 1.0])
    right, up = across(axis)
    turn = 2.0 * np.pi * np.arange(sides) / sides
    return axis, np.cos(turn)[:, None, None] * right + np.sin(turn)[:, None, None] * up


def _joined(rings: Floats, normals: Floats) -> TriangleMesh:
    """Return the triangles between rings of points, both of shape (ring, side, solid, 3)."""
    count, sides = len(rings), int(rings.shape[1])
    corner = np.arange(count * sides).reshape(count, sides)
    a, b = corner[:-1], np.roll(corner, -1, axis=1)[:-1]
    c, d = corner[1:], np.roll(corner, -1, axis=1)[1:]
    chosen = np.concatenate([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    flat = [table.reshape(count * sides, -1, 3)[chosen] for table in (rings, normals)]
    return TriangleMesh(*(np.moveaxis(table, 2, 0).reshape(-1, 3, 3) for table in flat))


def smooth_mesh(position: Floats, triangles: NDArray[np.integer]) -> TriangleMesh:
    """Return triangles with normals that are smooth, except across sharp edges.

    Args:
        position: Points [m], shape (point, 3).
        triangles: Corners, shape (triangle, 3).
    """
    corners = position[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(face, axis=1)
    flat = triangles.reshape(-1)
    order = np.argsort(flat, kind="stable")
    count = np.bincount(flat, minlength=len(position))
    start = np.concatenate([[0], np.cumsum(count)])[flat]
    # Every corner beside every triangle around its node.
    often = count[flat]
    corner = np.repeat(np.arange(len(flat)), often)
    other = order[np.repeat(start, often) + counted_up(often)] // 3
    own = corner // 3
    alike = (face[own] * face[other]).sum(axis=1) >= _SHARP * size[own] * size[other]
    corner, other = corner[alike], other[alike]
    sums = [np.bincount(corner, axis[other], minlength=len(flat)) for axis in face.T]
    found = np.stack(sums, axis=1).astype(float)  # without any triangle they are whole
    found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-300)
    return TriangleMesh(corners, found.reshape(-1, 3, 3))


def bulges(position: Floats, triangles: NDArray[np.integer], mesh: TriangleMesh) -> Floats:
    """Return by how much edges bend towards normals, shape (triangle, 3, 3).

    Between ends q and r with normals n and m, the point with weights (1 - w) and w moves by
    half of w (1 - w) times ((q - r)·n) n + ((r - q)·m) m [m]. Sharp edges stay straight.

    Args:
        position: Points [m], shape (point, 3).
        triangles: Corners, shape (triangle, 3); edges lead from each to the next.
        mesh: The triangles with their normals.
    """
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    normals = np.stack([mesh.normals, np.roll(mesh.normals, -1, axis=1)], axis=2)
    normals = normals.reshape(-1, 2, 3)
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    face = np.cross(b - a, c - a)
    face = face / np.maximum(np.linalg.norm(face, axis=1, keepdims=True), 1e-300)
    turned = ends[:, 0] > ends[:, 1]
    ascending = np.where(turned[:, None, None], normals[:, ::-1], normals)
    keys = np.sort(ends, axis=1) @ [len(position), 1]
    _, edge, shared = np.unique(keys, return_inverse=True, return_counts=True)
    # Faces of an edge may see other neighbours at its ends: their mean leaves no gap.
    order = np.argsort(edge, kind="stable")
    pairs = order[np.flatnonzero(shared[edge[order]] == 2)].reshape(-1, 2)
    mean = ascending.copy()
    mean[pairs] = ascending[pairs].sum(axis=1, keepdims=True)
    mean /= np.maximum(np.linalg.norm(mean, axis=-1, keepdims=True), 1e-300)
    sides = face[pairs // 3]
    sharp = shared[edge] > 2
    sharp[pairs] = ((sides[:, 0] * sides[:, 1]).sum(axis=-1) < _SHARP)[:, None]
    way = position[ends.min(axis=1)] - position[ends.max(axis=1)]
    found = np.zeros_like(way)
    for end, sign in ((0, 1.0), (1, -1.0)):
        normal = mean[:, end]
        found += sign * (way * normal).sum(axis=1, keepdims=True) * normal
    found[sharp] = 0.0
    return found.reshape(-1, 3, 3)


def rounded(mesh: TriangleMesh, bulge: Floats, divisions: int) -> tuple[TriangleMesh, Floats]:
    """Return triangles bent to follow their normals, and the weights of corners in each part.

    A point of a flat triangle moves half of the way to the mean of its projections onto the
    tangent planes at the corners (Phong tessellation; T. Boubekeur, M. Alexa, ACM Transactions
    on Graphics 27 (2008) 141), which is a sum over edges. With a half, the chord of a circle
    becomes its arc to third order in its angle. Nodes stay in place, and flat faces flat.

    Args:
        mesh: Triangles, with corners in metres.
        bulge: See ``bulges``, shape (triangle, 3, 3).
        divisions: Into how many parts each edge is divided.

    Returns:
        The parts [m], those of each triangle together, and weights of shape (part, corner, 3).
    """
    weights = _parts(divisions)
    if divisions == 1:
        return mesh, weights
    products = 0.5 * weights * np.roll(weights, -1, axis=-1)
    corners = spread(mesh.corners, weights) + spread(bulge, products)
    normal = spread(mesh.normals, weights)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
    return TriangleMesh(corners, normal), weights


def spread(values: NDArray[Any], weights: Floats) -> Floats:
    """Interpolate values to the corners of parts, shape (triangle * part, 3, number).

    Args:
        values: At the corners of triangles, in any unit, shape (triangle, 3, number).
        weights: Of the corners, shape (part, 3, 3).
    """
    found = np.einsum("pcw,twk->tpck", weights, values)
    return found.reshape(-1, 3, values.shape[-1])


def _parts(divisions: int) -> Floats:
    """Return the weights of corners in the parts of a triangle, shape (part, 3, 3)."""
    found: list[list[tuple[int, int]]] = []
    for i in range(divisions):
        for j in range(divisions - i):
            found.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < divisions - 1:
                found.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    second, third = np.moveaxis(np.array(found) / divisions, -1, 0)
    return np.stack([1.0 - second - third, second, third], axis=-1)


def lit(base: Floats, normal: Floats, to_eye: Floats, shine: float | Floats) -> Floats:
    """Return colours in the light of the page, shape (…, 3).

    Args:
        base: Without light, from 0 to 1, shape (…, 3).
        normal: Of one unit, towards the eye, as the camera sees it, shape (…, 3).
        to_eye: Direction to the eye, shape (…, 3).
        shine: Of the highlight, one number or shape (…, 1).
    """
    direct = np.maximum(normal @ _LAMP, 0.0)[..., None]
    sky = 0.5 + 0.5 * normal[..., 1:2]
    facing = np.maximum((normal * to_eye).sum(axis=-1, keepdims=True), 0.0)
    mirrored = 2.0 * (normal @ _LAMP)[..., None] * normal - _LAMP
    spot = np.maximum((mirrored * to_eye).sum(axis=-1, keepdims=True), 0.0) ** 24
    light = 0.22 + 0.26 * sky + 0.7 * direct + 0.12 * (1.0 - facing) ** 3
    return np.sqrt(np.clip(base**2 * light + shine * spot, 0.0, 1.0))
