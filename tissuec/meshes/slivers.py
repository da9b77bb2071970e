"""Better tetrahedra in fillings: slivers are left out or rounded.

The quality of a tetrahedron of volume V whose edges have the mean square l² is 6 √2 V/l³: 1 if
it is regular, 0 if it is flat (J. R. Shewchuk, 11th Int. Meshing Roundtable, p. 115, 2002).
A few bad ones make explicit steps short, as the lowest height of all sets the step, and stress
poor.

- Two triangles of a convex surface may have a flat tetrahedron behind them, whose other two
  faces are on the other diagonal. It is left out, and the surface follows that diagonal.
- An inner node moves towards the mean of its neighbours if the worst tetrahedron around it
  becomes better, one after the other among neighbours. (L. A. Freitag, C. Ollivier-Gooch, Int.
  J. Numer. Meth. Eng. 40:3979, 1997.)
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.geometry.divisions import OPPOSITE, oriented
from tissuec.geometry.edges import Floats, Indices

POOR = 0.05  # quality of tetrahedra that are reported
_THIN, _BETTER = 0.1, 0.2  # which are left out, and around which nodes move
_FLAT = 0.8  # cosine between faces that one surface may be divided into either way
_ROUNDS = 20  # of each kind; few are needed
_PARTS = (1.0, 0.5, 0.25)  # of the way to the mean of the neighbours that are tried
_LEAST = 1e-3  # by which the worst quality improves where a node moves
_PAIRS = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])


def quality(corners: Floats) -> Floats:
    """Return the quality of tetrahedra [1], shape (…); negative where they are inside out.

    Args:
        corners: Positions [m], shape (…, 4, 3).
    """
    a, b, c, d = (corners[..., k, :] for k in range(4))
    content = dot(cross(b - a, c - a), d - a)
    sides = corners[..., _PAIRS[:, 0], :] - corners[..., _PAIRS[:, 1], :]
    square = np.einsum("...ki,...ki->...", sides, sides) / 6.0
    return np.asarray(np.sqrt(2.0) * content / np.maximum(square, 1e-300) ** 1.5)


def worst_and_mean(position: Floats, tetrahedra: Indices) -> tuple[float, float]:
    """Return the worst and the mean quality of tetrahedra [1], in either order of corners.

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
    """
    value = np.abs(quality(position[tetrahedra]))
    return float(value.min()), float(value.mean())


def poor_ones(position: Floats, tetrahedra: Indices) -> Iterator[str]:
    """Yield a clause with how many tetrahedra are poor and where the worst is, if any are.

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
    """
    value = np.abs(quality(position[tetrahedra]))
    if not (many := int((value < POOR).sum())):
        return
    from tissuec.meshes.repair import place

    worst = int(value.argmin())
    what = "tetrahedron" if many == 1 else "tetrahedra"
    yield (
        f"{many} {what} of a quality below {POOR:g}, the worst one of {value[worst]:.2g} "
        f"around {place(position[tetrahedra[worst]].mean(axis=0))}: steps are short, and "
        "stress is poor there"
    )


def without_slivers(
    position: Floats, tetrahedra: Indices, inner: int
) -> tuple[Floats, Indices]:
    """Return nodes [m] and tetrahedra of better quality, shapes (node, 3) and (n, 4).

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: That fill a closed surface, in any order of corners, shape (tetrahedron, 4).
        inner: Number of the first node that may move; all before lie in the surface.
    """
    cells = oriented(position, tetrahedra)
    for _ in range(_ROUNDS):
        thin = _thin(position, cells)
        if not len(thin):
            break
        cells = np.delete(cells, thin, axis=0)
    return _rounded(position, cells, inner), cells


def _thin(position: Floats, cells: Indices) -> Indices:
    """Return tetrahedra that can be left out at once, shape (n,).

    They have two faces in the surface, nearly in one plane, and their other diagonal is no
    edge of the surface. No two of them share a face or that diagonal, so no node is lost.
    """
    count = len(position)
    faces = cells[:, OPPOSITE]
    powers = np.array([count * count, count, 1])
    _, face, shared = np.unique(
        np.sort(faces.reshape(-1, 3), axis=1) @ powers, return_inverse=True, return_counts=True
    )
    face = face.reshape(-1, 4)
    is_outer = shared[face] == 1
    found = np.flatnonzero(is_outer.sum(axis=1) == 2)
    value = quality(position[cells[found]])
    found = found[(value < _THIN) & _are_flat(position, faces[found][is_outer[found]])]
    found = found[np.argsort(quality(position[cells[found]]), kind="stable")]
    skin = faces[is_outer]
    drawn = np.concatenate([skin[:, [0, 1]], skin[:, [1, 2]], skin[:, [2, 0]]])
    drawn = np.sort(drawn, axis=1) @ (count, 1)
    diagonal = np.sort(cells[found][is_outer[found]].reshape(-1, 2), axis=1) @ (count, 1)
    used: set[int] = set(drawn[np.isin(drawn, diagonal)].tolist())
    taken: list[int] = []
    beside: set[int] = set()
    for one, edge in zip(found.tolist(), diagonal.tolist(), strict=True):
        own = face[one][~is_outer[one]].tolist()
        if edge not in used and beside.isdisjoint(own):
            used.add(edge)
            beside.update(own)
            taken.append(one)
    return np.array(taken, dtype=np.int64)


def _are_flat(position: Floats, outer: Indices) -> NDArray[np.bool_]:
    """Return whether pairs of faces lie nearly in one plane, shape (pair,).

    Args:
        outer: Faces, the two of a pair after one another, shape (2 pair, 3).
    """
    a, b, c = position[outer].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    one, other = normal[::2], normal[1::2]
    return np.asarray(dot(one, other) > _FLAT * norm(one) * norm(other))


def _rounded(position: Floats, cells: Indices, inner: int) -> Floats:
    """Return positions [m] with inner nodes moved; arguments as for ``without_slivers``."""
    place, count = position.copy(), len(position)
    ends = np.unique(np.sort(cells[:, _PAIRS].reshape(-1, 2), axis=1) @ (count, 1))
    ends = np.stack(np.divmod(ends, count), axis=1)
    degree = np.maximum(np.bincount(ends.ravel(), minlength=count), 1)
    for _ in range(_ROUNDS):
        worst = np.full(count, np.inf)
        np.minimum.at(worst, cells, quality(place[cells])[:, None])
        moves = worst < _BETTER
        moves[:inner] = False
        if not moves.any():
            break
        mean = np.stack(
            [
                np.bincount(ends[:, 0], axis[ends[:, 1]], count)
                + np.bincount(ends[:, 1], axis[ends[:, 0]], count)
                for axis in place.T
            ],
            axis=1,
        )
        gain, to = _gains(place, cells, mean / degree[:, None], moves, worst)
        highest = gain.copy()  # among neighbours
        np.maximum.at(highest, ends[:, 0], gain[ends[:, 1]])
        np.maximum.at(highest, ends[:, 1], gain[ends[:, 0]])
        first = (gain > _LEAST) & (gain >= highest)
        if not first.any():
            break
        place[first] = to[first]
    return place


def _gains(
    place: Floats, cells: Indices, mean: Floats, moves: NDArray[np.bool_], worst: Floats
) -> tuple[Floats, Floats]:
    """Return how much the worst quality around each node can gain, and where the node is then.

    Args:
        place: Nodes [m], shape (node, 3).
        cells: Shape (tetrahedron, 4).
        mean: Of their neighbours [m], shape (node, 3).
        moves: Which nodes may move, shape (node,).
        worst: Quality around each now [1], shape (node,).

    Returns:
        Shapes (node,) and (node, 3) [m].
    """
    gain, to = np.zeros(len(place)), place.copy()
    cell, corner = np.nonzero(moves[cells])
    own, row = cells[cell, corner], np.arange(len(cell))
    for part in _PARTS:
        there = place + part * (mean - place)
        corners = place[cells[cell]]
        corners[row, corner] = there[own]
        found = np.full(len(place), np.inf)
        np.minimum.at(found, own, quality(corners))
        better = moves & (found - worst > gain)
        gain[better] = (found - worst)[better]
        to[better] = there[better]
    return gain, to
