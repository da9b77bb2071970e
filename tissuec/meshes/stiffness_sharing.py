"""Distribution of a tissue's stiffness to the springs of an irregular mesh.

A. Van Gelder, Approximate simulation of elastic membranes by triangulated spring meshes, J.
Graphics Tools 3(2):21-41 (1998): the stiffness of an edge of length L is

    membranes   k = E h Σ A / L²    over the triangles of area A that have the edge,
    solids      k = E Σ V / L²      over the tetrahedra of volume V that have it,

E being Young's modulus and h the thickness. In a net of equal sides, each inner edge of two
triangles has k = E h √3/2. So the share of a spring, relative to that,

    s = 2/√3 Σ A / L²,

makes a membrane of E h = 2 c/√3 of a spring constant c, whatever its triangles are like and
however fine. Solids have no such measure, because k grows with L there: their shares are
relative to their mean, so that c is the mean spring constant.

Stretched evenly by ε, the springs of a triangle store 3/2 E h A ε² and those of a tetrahedron
3 E V ε², whatever their shape: exactly as much as a membrane of Poisson's ratio 1/3 and a solid
of 1/4. Other strains are met on average only.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.edges import volume as enclosed

LEAST = 0.1  # of the mean share by area: what a node of a filled surface has


def area_shares(
    position: Floats,
    triangles: NDArray[np.integer],
    ends: NDArray[np.int32],
    *,
    elsewhere: float = 1.0,
) -> Floats:
    """Return the share of each spring by the area rule.

    Args:
        position: Nodes [m], shape (node, 3).
        triangles: Corners, shape (triangle, 3).
        ends: Node pair of each spring, lower node first, in ascending order, shape (spring, 2).
        elsewhere: The share of springs that no triangle has.
    """
    a, b, c = position[triangles].swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    total, found = _summed(position, triangles, area, ends)
    return np.where(found, 2.0 / np.sqrt(3.0) * total, elsewhere)


def volume_shares(position: Floats, tetrahedra: Indices, ends: NDArray[np.int32]) -> Floats:
    """Return the share of each spring by the volume rule, dimensionless, shape (spring,).

    It is 1 where no tetrahedron has the spring.

    Args:
        position: Of the nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
        ends: Node pair of each spring, shape (spring, 2).
    """
    total, found = _summed(position, tetrahedra, _volumes(position, tetrahedra), ends)
    return np.where(found, total / total[found].mean(), 1.0)


def node_volumes(position: Floats, tetrahedra: Indices) -> Floats:
    """Return a quarter of the tetrahedra around each node [m³], shape (node,)."""
    volume = _volumes(position, tetrahedra)
    return _sums(tetrahedra.ravel(), np.repeat(volume / 4.0, 4), len(position))


def node_areas(position: Floats, triangles: NDArray[np.integer]) -> Floats:
    """Return a third of the triangles around each node [m²], shape (node,)."""
    a, b, c = position[triangles].swapaxes(0, 1)
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return _sums(triangles.ravel(), np.repeat(third, 3), len(position))


def grid_areas(position: Floats, rows: int, columns: int, *, closed: bool) -> Floats:
    """Return a quarter of the cells around each node of a grid [m²], shape (node,).

    Args:
        position: Nodes row by row [m], shape (node, 3).
        rows: Number of rows.
        columns: Number of columns.
        closed: Whether the last column is followed by the first.
    """
    number = np.arange(rows * columns).reshape(rows, columns)
    if closed:
        number = np.hstack([number, number[:, :1]])
    ends = slice(-1), slice(1, None)
    corners = [number[(r, c)].ravel() for r in ends for c in ends]
    a, b, c, d = (position[nodes] for nodes in corners)
    quarter = np.linalg.norm(np.cross(d - a, c - b), axis=1) / 8.0
    return _sums(np.concatenate(corners), np.tile(quarter, 4), len(position))


def filled_volumes(position: Floats, triangles: Indices, tetrahedra: Indices) -> Floats:
    """Return the volume of each node of a filled surface [m³], shape (node,).

    A quarter of the tetrahedra around each, times what makes them as large as the inside. Nodes
    of the surface get some of its part by their area at least: at a sharp rim, there may be no
    tetrahedra.

    Args:
        position: Nodes of the surface and after them those inside [m], shape (node, 3).
        triangles: The closed surface, shape (triangle, 3).
        tetrahedra: That divide the inside, shape (tetrahedron, 4).
    """
    found = node_volumes(position, tetrahedra)
    outer = int(triangles.max()) + 1
    area = node_areas(position[:outer], triangles)
    least = LEAST * found[:outer].sum() * area / area.sum()
    found[:outer] = np.maximum(found[:outer], least)
    return found * (enclosed(position, triangles) / found.sum())


def _volumes(position: Floats, tetrahedra: Indices) -> Floats:
    a, b, c, d = position[tetrahedra].swapaxes(0, 1)
    return np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / 6.0


def _sums(rows: NDArray[np.integer], values: Floats, count: int) -> Floats:
    """Return the sums of values by rows, shape (count,)."""
    return np.bincount(rows, values, count).astype(float, copy=False)


def _summed(
    position: Floats, cells: NDArray[np.integer], content: Floats, ends: NDArray[np.int32]
) -> tuple[Floats, np.ndarray]:
    """Return the sum of content / L² over the cells of each spring, and which have any."""
    size = len(position)
    total, found = np.zeros(len(ends)), np.zeros(len(ends), dtype=bool)
    keys = ends[:, 0].astype(np.int64) * size + ends[:, 1]
    for one, other in combinations(range(cells.shape[1]), 2):
        low, high = np.sort(cells[:, [one, other]], axis=1).T
        length = np.linalg.norm(position[high] - position[low], axis=1)
        place = np.searchsorted(keys, np.asarray(low * size + high, dtype=np.int64))
        here = place < len(keys)
        here[here] = keys[place[here]] == (low * size + high)[here]
        np.add.at(total, place[here], content[here] / length[here] ** 2)
        found[place[here]] = True
    return total, found
