"""Folds that make a wall resist bending as a plate does, by the curvature of triangles.

A triangle and the tips of its three neighbours are six points, through which one quadratic
surface passes. Unfolded into the plane of the triangle, a surface with the curvatures
κ = (κxx, κyy, 2 κxy) has the folds θ = Q κ at its edges: the jumps of the slope across them of
the linear surfaces on either side. A plate of the rigidity D and Poisson's ratio ν stores
κᵀ C κ/2 per area, with C = D (1, ν, 0; ν, 1, 0; 0, 0, (1 - ν)/2). So the folds of a triangle of
the area A store θᵀ K θ/2 with

    K = A (Q C⁻¹ Qᵀ)⁻¹,

also where an edge has no neighbour and no row in Q: then there is no moment across it. (Finite
elements without rotations, from patches of four triangles: E. Oñate, F. Zárate, Int. J. Numer.
Meth. Eng. 47:557, 2000.)

In nets whose neighbouring triangles are mirror images about the middle of their edge, such as
grids, that is exact. In others, plates are too soft, because even moments are not in
equilibrium. They are with the mean curvature ∮ n ⊗ s du/A of the triangle, where the slope s on
an edge of the normal n and length l is the mean of those of both neighbours,

    κ = Σ_i l_i θ_i n_i ⊗ n_i / 2A,

but then plates are too stiff, because even curvatures are not found. (E. Oñate, M. Cervera,
Eng. Comput. 10:543, 1993.) The inverse of this is another Q, the same in grids; K is a mean of
both.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Floats, Indices

#: Of the eigenvalues of Q C⁻¹ Qᵀ, below which they count as this part of the largest: points of
#: patches that nearly lie on a conic do not determine curvatures.
_LEAST = 1e-2
_FITTED = 0.7  # weight of the quadratic surface, found by tests of plates in irregular nets


class Patches(Struct, frozen=True, eq=False):
    """Triangles with the tips of their neighbours.

    Attributes:
        nodes: Corners of the triangle, and the tip across the edge opposite to each of them;
            the corner again where there is none, shape (triangle, 6).
        beside: The neighbour across the edge opposite to each corner, -1 where there is none,
            shape (triangle, 3).
        folds: Q [m] of the surface and of the mean, shape (2, triangle, 3, 3), for the edges
            opposite to the corners; zero where there is no neighbour.
        area: [m²], shape (triangle,).
    """

    nodes: Indices
    beside: Indices
    folds: Floats
    area: Floats

    @property
    def is_hinge(self) -> NDArray[np.bool_]:
        """Return which edges have a neighbour, shape (triangle, 3)."""
        return self.nodes[:, 3:] != self.nodes[:, :3]

    def stiffness(self, rigidity: Floats, poisson: Floats) -> Floats:
        """Return K of each triangle [N m], shape (triangle, 3, 3).

        Args:
            rigidity: D [N m], shape (triangle,).
            poisson: ν, shape (triangle,).
        """
        soft = np.zeros((len(self.area), 3, 3))
        soft[:, 0, 0] = soft[:, 1, 1] = 1.0
        soft[:, 0, 1] = soft[:, 1, 0] = -poisson
        soft[:, 2, 2] = 2.0 * (1.0 + poisson)
        soft /= (1.0 - poisson**2)[:, None, None]
        parts = [self._inverse(folds @ soft @ folds.swapaxes(1, 2)) for folds in self.folds]
        both = self.is_hinge[:, :, None] & self.is_hinge[:, None, :]
        mean = _FITTED * parts[0] + (1.0 - _FITTED) * parts[1]
        return (rigidity * self.area)[:, None, None] * np.where(both, mean, 0.0)

    def bounds(self, rigidity: Floats, poisson: Floats) -> Floats:
        """Return bounds on the stiffness of a net under uniform curvature, relative to a plate.

        Nodes on a surface of uniform curvature store the energy of the folds Q κ, the upper
        bound. The moments M of the mean curvature are in equilibrium, and bound the energy from
        below if nodes inside may move: with their work a in the folds and their complementary
        energy b/2, it is at least a²/2b. Triangles at borders are left out.

        Args:
            rigidity: D [N m], shape (triangle,).
            poisson: ν, shape (triangle,).

        Returns:
            Lower and upper bound, for equal curvatures in all directions and for opposite ones
            and twist together, shape (2, 2); 1 for nets in which bending is exact.
        """
        inner = self.is_hinge.all(axis=1)
        if not inner.any():
            return np.ones((2, 2))
        stiff, folds = self.stiffness(rigidity, poisson)[inner], self.folds[:, inner]
        weight, ratio = (rigidity * self.area)[inner], poisson[inner]
        plate = np.zeros_like(stiff)
        plate[:, 0, 0] = plate[:, 1, 1] = 1.0
        plate[:, 0, 1] = plate[:, 1, 0] = ratio
        plate[:, 2, 2] = 0.5 * (1.0 - ratio)
        plate *= weight[:, None, None]
        # Hinge moments of uniform curvatures, by the inverse of the second Q.
        mean = np.asarray(np.linalg.inv(folds[1]), dtype=float)
        moments: Floats = np.einsum("tji,tjk->tik", mean, plate)
        found: list[tuple[float, float]] = []
        for states in (
            np.array([[1.0, 1.0, 0.0]]),
            np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 2.0]]),
        ):
            bent, held = folds[0] @ states.T, moments @ states.T
            exact = float(np.einsum("si,tij,sj->", states, plate, states))
            most = float(np.einsum("tis,tij,tjs->", bent, stiff, bent))
            work = float(np.einsum("tis,tis->", held, bent))
            stored = float(np.einsum("tis,tis->", held, np.linalg.solve(stiff, held)))
            found.append((work * work / (stored * exact), most / exact))
        return np.array(found)

    def _inverse(self, matrix: Floats) -> Floats:
        """Return the inverses of matrices without the rows of what is no hinge.

        Args:
            matrix: Shape (triangle, 3, 3), zero in these rows and columns.
        """
        value, way = np.linalg.eigh(matrix)
        least = _LEAST * value[:, -1:]
        lacks = (~self.is_hinge).sum(axis=1)
        is_left_out = np.arange(3) < lacks[:, None]
        part = np.where(is_left_out, 0.0, 1.0 / np.maximum(np.maximum(value, least), 1e-300))
        return (way * part[:, None, :]) @ way.swapaxes(1, 2)


def patches(mesh: Mesh) -> Patches:
    """Return the patches of a mesh with a skin."""
    triangles = mesh.skin.astype(np.int64)
    tips, beside = _across(triangles)
    is_hinge = beside >= 0
    corners = mesh.position[triangles]
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = cross(side, other)
    twice = norm(normal)
    x = side / norm(side)[:, None]
    y = cross(normal / twice[:, None], x)
    axes = np.stack([x, y], axis=1)
    flat = np.einsum("tak,tik->tai", corners - corners[:, :1], axes)
    of_surface = np.zeros((len(triangles), 3, 3))
    for edge in range(3):
        has = np.flatnonzero(is_hinge[:, edge])
        tip = mesh.position[tips[has, edge]]
        of_surface[has, edge] = _slope_jumps(edge, flat[has], corners[has], tip)
    of_mean = np.where(is_hinge[..., None], np.linalg.inv(_means(flat, twice)), 0.0)
    nodes = np.concatenate([triangles, tips], axis=1)
    return Patches(nodes, beside, np.stack([of_surface, of_mean]), 0.5 * twice)


def _slope_jumps(edge: int, flat: Floats, corners: Floats, tip: Floats) -> Floats:
    """Return the rows of Q of a quadratic surface for one edge of each triangle [m].

    Args:
        edge: Its number, that of the corner opposite to it.
        flat: Corners in the plane of the triangle [m], shape (triangle, 3, 2).
        corners: The same in space [m], shape (triangle, 3, 3).
        tip: Of the neighbour [m], shape (triangle, 3).
    """
    i, j = (edge + 1) % 3, (edge + 2) % 3
    a, b, c = flat[:, i], flat[:, j], flat[:, edge]
    length = np.hypot(*(b - a).T)[:, None]
    along = (b - a) / length
    out = np.stack([along[:, 1], -along[:, 0]], axis=1)
    # The neighbour, turned about the edge into the plane.
    axis, reach = (corners[:, j] - corners[:, i]) / length, tip - corners[:, i]
    part = dot(reach, axis)[:, None]
    unfolded = a + part * along + norm(reach - part * axis)[:, None] * out
    found: list[Floats] = []
    for p, q in ((0, 0), (1, 1), (0, 1)):
        at_a, at_b = (0.5 * one[:, p] * one[:, q] for one in (a, b))
        slopes: list[Floats] = []
        for place in (c, unfolded):
            # The slope across the edge of a linear surface through both of its ends.
            to, value = place - a, 0.5 * place[:, p] * place[:, q]
            share = np.einsum("tk,tk->t", to, along) / length[:, 0]
            lift = value - at_a - share * (at_b - at_a)
            slopes.append(lift / np.einsum("tk,tk->t", to, out))
        found.append(slopes[1] - slopes[0])
    return np.stack(found, axis=1)


def _means(flat: Floats, twice: Floats) -> Floats:
    """Return the mean curvatures of triangles by their folds [1/m], shape (triangle, 3, 3).

    Args:
        flat: Corners in the plane [m], shape (triangle, 3, 2).
        twice: Two times the areas [m²], shape (triangle,).
    """
    along = np.roll(flat, -2, axis=1) - np.roll(flat, -1, axis=1)
    length = np.hypot(along[..., 0], along[..., 1])
    x, y = along[..., 1] / length, -along[..., 0] / length
    part = length / twice[:, None]
    return np.stack([part * x * x, part * y * y, 2.0 * part * x * y], axis=1)


def _across(triangles: Indices) -> tuple[Indices, Indices]:
    """Return the tip across the edge opposite to each corner, and the triangle that has it.

    Where not exactly two triangles share the edge, these are the corner itself and -1. Shapes
    are (triangle, 3).
    """
    size = int(triangles.max()) + 1
    first, second = np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)
    keys = (np.minimum(first, second) * size + np.maximum(first, second)).ravel()
    order = np.argsort(keys, kind="stable")
    ascending = keys[order]
    begins = np.flatnonzero(np.diff(ascending, prepend=-1))
    shared = begins[np.diff(begins, append=len(keys)) == 2]
    tips, corner = triangles.ravel().copy(), triangles.ravel()
    beside = np.full(tips.shape, -1)
    one, other = order[shared], order[shared + 1]
    tips[one], tips[other] = corner[other], corner[one]
    beside[one], beside[other] = other // 3, one // 3
    return tips.reshape(triangles.shape), beside.reshape(triangles.shape)
