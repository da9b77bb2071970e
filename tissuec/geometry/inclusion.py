"""Elements that the faces of a surface share, and weights that count every point once.

A surface of triangles, or a line of pieces, has its *faces* as elements, and those edges and
corners that faces share. Each face has the weight 1, and each shared element what brings the
sum over all elements that contain it to 1 (inclusion and exclusion):

    an edge of n triangles               1 - n
    a corner of F triangles, E edges     1 + F - E
    a point between n pieces of a line   1 - n

So inner edges have -1 and inner corners of a surface 1, and what lies at its rim has 0. The
Euler characteristic χ of what a convex set cuts out of the surface is then the sum of the
weights of all elements that the set meets, so that Σ weight f(distance) depends on where the
surface is, and not on how it is divided into triangles. (D. A. Klain, G.-C. Rota, Introduction
to Geometric Probability, 1997.)
"""

from typing import NamedTuple

import numpy as np

from tissuec.geometry.edges import Indices

NONE = -1


class Shared(NamedTuple):
    """Elements that faces share.

    Attributes:
        points: Both nodes of an edge, the second one twice; that of a corner, three times;
            shape (element, 3).
        face: A face that has it, shape (element,).
        parts: The three edges and the three corners of each face and then of each of these
            elements, numbered behind the faces, -1 where there is none, shape
            (face + element, 6).
    """

    points: Indices
    face: Indices
    parts: Indices


def shared_elements(points: Indices, sides: Indices, surface: Indices) -> Shared:
    """Return the edges of triangles, and the corners of triangles and of pieces of lines.

    Args:
        points: Corners of each face, shape (face, 3); of a piece both ends, then any.
        sides: 3 for a triangle, 2 for a piece of a line, 0 for what shares nothing, shape
            (face,).
        surface: To which surface each face belongs, shape (face,); none is shared by two.
    """
    count = len(points)
    face, side = np.nonzero(np.arange(3) < np.where(sides == 3, 3, 0)[:, None])
    ends = np.stack([points[face, side], points[face, (side + 1) % 3]], axis=1)
    edges = _distinct(surface[face], np.sort(ends, axis=1))
    owner, corner = np.nonzero(np.arange(3) < sides[:, None])
    nodes = points[owner, corner][:, None]
    corners = _distinct(surface[owner], nodes)
    start = count + len(edges.first)
    parts = np.full((start + len(corners.first), 6), NONE)
    parts[face, side] = count + edges.of
    parts[owner, 3 + corner] = start + corners.of
    of_edge, first = face[edges.first], side[edges.first]
    # An edge has the corners of a triangle at its two ends.
    parts[count:start, 3] = parts[of_edge, 3 + first]
    parts[count:start, 4] = parts[of_edge, 3 + (first + 1) % 3]
    return Shared(
        np.concatenate([ends[edges.first][:, [0, 1, 1]], nodes[corners.first][:, [0, 0, 0]]]),
        np.concatenate([of_edge, owner[corners.first]]),
        parts,
    )


class _Distinct(NamedTuple):
    """The first place of each distinct row, and the number of the distinct row of each row."""

    first: Indices
    of: Indices


def _distinct(surface: Indices, rows: Indices) -> _Distinct:
    table = np.concatenate([surface[:, None], rows], axis=1)
    _, first, of = np.unique(table, axis=0, return_index=True, return_inverse=True)
    return _Distinct(first, of.reshape(-1))


class Counted(NamedTuple):
    """Shared elements near points, and their weights.

    Attributes:
        row: A face that has it, as a row of the request, shape (counted,).
        element: Its number, shape (counted,).
        weight: As above, never 0, shape (counted,).
    """

    row: Indices
    element: Indices
    weight: Indices


def weights(looker: Indices, face: Indices, parts: Indices) -> Counted:
    """Return the shared elements of those faces that each looker sees, and their weights.

    Args:
        looker: Who sees a face, each by itself, shape (row,).
        face: Its number, shape (row,).
        parts: As in ``Shared``, shape (face + element, 6).
    """
    size = len(parts)
    row, column = np.nonzero(parts[face] >= 0)
    keys, first, of = np.unique(
        looker[row] * size + parts[face[row], column], return_index=True, return_inverse=True
    )
    is_edge, element = column[first] < 3, keys % size
    # Triangles add to a corner, and take from an edge; pieces of a line take from their ends.
    adds = (column >= 3) & (parts[face[row], 0] >= 0)
    weight = 1 + np.bincount(of.reshape(-1), np.where(adds, 1, -1), len(keys)).astype(np.int64)
    edge = np.flatnonzero(is_edge)
    ends = (keys[edge] - element[edge])[:, None] + parts[element[edge], 3:5]
    np.subtract.at(weight, np.searchsorted(keys, ends.reshape(-1)), 1)
    counts = weight != 0
    return Counted(row[first][counts], element[counts], weight[counts])
