"""Spring constants that make a net an isotropic elastic surface, with Poisson's ratio 1/3.

A surface of thickness t and Young's modulus E resists stretching in its plane with

    C_ijkl = μ (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk),    μ = 3/8 E t,

symmetric in all indices, as forces along springs require (Cauchy; A. E. H. Love, A Treatise on
the Mathematical Theory of Elasticity, 4th edition 1927).

In a grid all cells are alike. The springs of a cell, of length L along n, have to make up
Σ k L² n_i n_j n_k n_l = A C_ijkl for its area A; of a rectangle with sides a and b, diagonals

    k = μ A (a² + b²) / (2 a² b²),    sides along a:  k = μ (3 - a²/b²) b/a,

which are not negative up to a = √3 b. Springs through the inside of a tube count by how they
lengthen as it widens, is drawn out and twisted; so the whole tube is as stiff as its wall.
Other triangles follow the area rule (see ``meshes.stiffness_sharing``), which is exact for even
stretching, and for all strains on average.
"""

from functools import lru_cache

import numpy as np
from msgspec import Struct

from tissuec.matter.elasticity import evenly_as_tube, range_of_wall, young_around
from tissuec.matter.linear import elongations
from tissuec.matter.solid import Fibres
from tissuec.meshes.generators import Mesh
from tissuec.meshes.stiffness_sharing import area_shares, grid_areas, node_areas
from tissuec.model.network import Floats, Grid

#: From a node of a grid to others of the same cell, as rows and columns.
STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
_SHEAR = 3.0 / 8.0  # μ / (E t)
_ALIKE = 1e-4  # how much it counts that springs are alike, beside what they make up
_ROUNDS = 20  # in which the lateral stiffness is found that springs can have, at most
_SAME = 1e-15  # change of it that is rounding
_ISOTROPIC = np.array([[3.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 1.0]])  # μ = 1
_LEAST = 0.1  # of an even share: what any spring has in a tube with springs inside
_SHARE = 3.0**0.5 / 2.0  # k / (E t) of a spring with the share 1


class Surface(Struct, frozen=True, eq=False):
    """A net as a surface.

    Attributes:
        area: Area that each node represents [m²], shape (node,).
        constant: Of each spring per Young's modulus and thickness, shape (spring,).
        range: The least and the largest Young's modulus of all directions, per the one given.
    """

    area: Floats
    constant: Floats
    range: tuple[float, float]


def surface(mesh: Mesh, fibres: Fibres | None = None) -> Surface:
    """Return a mesh with a skin as a surface.

    Args:
        fibres: In it, along the rows of a grid and at right angles to them; None without any.

    Raises:
        ValueError: Some springs lie in no face of the surface, and not across a tube.
    """
    if (grid := mesh.even_grid) is not None:
        return _of_grid(mesh, grid, fibres)
    if fibres is not None:
        raise ValueError("fibres need springs in rows, as those of a sheet or a tube")
    constant = area_shares(mesh.position, mesh.skin, mesh.ends, elsewhere=0.0) * _SHARE
    if not constant.all():
        raise ValueError("some of its springs are not in a triangle of its surface")
    found = range_of_wall(mesh.position, mesh.ends, constant, mesh.skin)
    return Surface(node_areas(mesh.position, mesh.skin), constant, found)


def _of_grid(mesh: Mesh, grid: Grid, fibres: Fibres | None) -> Surface:
    """Return a grid of equal cells as a surface."""
    rows, columns = np.divmod(mesh.ends.astype(np.int64), grid.columns)
    down, right = rows[:, 1] - rows[:, 0], columns[:, 1] - columns[:, 0]
    if grid.closed:  # the shorter way round
        half = grid.columns // 2
        right = (right + half) % grid.columns - half
        right = np.where(down == 0, np.abs(right), right)
    steps, first, family, count = np.unique(
        np.stack([down, right], axis=1),
        axis=0, return_index=True, return_inverse=True, return_counts=True,
    )  # fmt: skip
    inside = np.array([tuple(step) not in STEPS for step in steps.tolist()])
    if inside.any() and not grid.closed:
        raise ValueError("some of its springs join nodes that are not neighbours in its wall")
    plane = cell_sides(mesh, grid)
    area = float(np.linalg.det(plane))
    stretch = in_plane(steps[:, ::-1] @ plane)
    if inside.any():
        through = elongations(mesh.position, mesh.ends[first[inside]])
        stretch[inside] = through @ evenly_as_tube(mesh.position, grid)
    each = (grid.rows - np.abs(steps[:, 0])) * (
        grid.columns - (0 if grid.closed else np.abs(steps[:, 1]))
    )
    weight = count / each / area
    least = _LEAST if inside.any() else 0.0
    if fibres is None:
        found, asked = isotropic(stretch, weight, least), _ISOTROPIC
    else:
        asked = _ISOTROPIC + fibres.stiffness / _SHEAR
        found = _made_of(stretch, weight, asked, least)
    found = _SHEAR * found
    free = (down == 0) & np.isin(rows[:, 0], (0, grid.rows - 1))
    if not grid.closed:
        free |= (right == 0) & np.isin(columns[:, 0], (0, grid.columns - 1))
    constant = found[family.ravel()] * np.where(free, 0.5, 1.0)
    young = young_around(np.einsum("k,ki,kj->ij", found * weight, stretch, stretch))
    young = young / young_around(_SHEAR * asked)
    areas = grid_areas(mesh.position, grid.rows, grid.columns, closed=grid.closed)
    return Surface(areas, constant, (float(young.min()), float(young.max())))


def in_plane(vectors: Floats) -> Floats:
    """Return elongations of springs in a plane under unit strains xx, yy and xy [m], (k, 3).

    Args:
        vectors: From end to end [m], shape (k, 2).
    """
    x, y = vectors.T
    return np.stack([x * x, y * y, x * y], axis=1) / np.hypot(x, y)[:, None]


def cell_sides(mesh: Mesh, grid: Grid) -> Floats:
    """Return both sides of a cell in its own plane [m], along a row first, shape (2, 2)."""
    sides = mesh.position[[1, grid.columns]] - mesh.position[0]
    square: Floats = sides @ sides.T
    return np.linalg.cholesky(square).astype(float, copy=False)


def isotropic(stretch: Floats, weight: Floats, least: float = 0.0) -> Floats:
    """Return k for which Σ k w s s is the tensor C of a surface with μ = 1, shape (k,).

    Where none make it up, they have the right Young's modulus in both directions, if they can.

    Args:
        stretch: s of each spring, as from ``in_plane`` [m], shape (k, 3).
        weight: w, shape (k,).
        least: Least k, as a part of what it is if all springs are alike.
    """
    return _isotropic(stretch.tobytes(), weight.tobytes(), least).copy()


@lru_cache(maxsize=64)  # learning compiles the same net many times
def _isotropic(stretches: bytes, weights: bytes, least: float) -> Floats:
    stretch, weight = np.frombuffer(stretches).reshape(-1, 3), np.frombuffer(weights)
    found, wanted, before = np.zeros(len(weight)), _ISOTROPIC, np.nan
    for _ in range(_ROUNDS):
        found = _made_of(stretch, weight, wanted, least)
        lateral = float(stretch[:, 0] * stretch[:, 1] * weight @ found)
        if abs(lateral - before) <= _SAME * abs(lateral):
            break
        before = lateral
        straight = 4.0 / 3.0 + np.hypot(4.0 / 3.0, lateral)  # for which E t is 8/3 μ
        wanted = np.diag([straight, straight, 1.0])
        wanted[0, 1] = wanted[1, 0] = lateral
    return found


def _made_of(stretch: Floats, weight: Floats, wanted: Floats, least: float) -> Floats:
    """Return k for which Σ k w s s is next to a tensor, shape (k,).

    Args:
        wanted: In Voigt's order, shape (3, 3).
        stretch, weight, least: As in ``isotropic``.
    """
    from scipy.optimize import nnls

    one, other = np.triu_indices(3)
    shear = (one == 2).astype(int) + (other == 2)
    times = np.sqrt(np.where(one == other, 1.0, 2.0) * 2.0**shear)
    made_of = (times * stretch[:, one] * stretch[:, other] * weight[:, None]).T
    right = times * wanted[one, other]
    even = right.sum() / max(float(made_of.sum()), np.finfo(float).tiny)
    alike = np.linalg.norm(made_of) * _ALIKE * np.eye(len(weight))  # of all that do
    left = right - least * even * made_of.sum(axis=1)
    rows = np.concatenate([left, (1.0 - least) * even * alike.sum(axis=1)])
    return np.asarray(least * even + nnls(np.vstack([made_of, alike]), rows)[0])
