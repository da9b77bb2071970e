"""Spring constants that make a net an isotropic elastic surface, with Poisson's ratio 1/3.

A surface of thickness t and Young's modulus E resists stretching in its plane with

    C_ijkl = μ (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk),    μ = 3/8 E t.

In a grid all cells are alike. The springs of a cell, of length L along n, have to make up
Σ k L² n_i n_j n_k n_l = A C_ijkl for its area A; of a rectangle with sides a and b, diagonals

    k = μ A (a² + b²) / (2 a² b²),    sides along a:  k = μ (3 - a²/b²) b/a,

which are not negative up to a = √3 b. Other triangles follow the area rule (see
``shapes.sharing``), which is exact for even stretching, and for all strains on average.
"""

from dataclasses import dataclass

import numpy as np

from tissuec.matter.elasticity import range_of_wall
from tissuec.meshes import Mesh
from tissuec.network import Floats, Grid
from tissuec.shapes.sharing import area_shares, node_areas

#: From a node of a grid to others of the same cell, as rows and columns.
STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
_SHEAR = 3.0 / 8.0  # μ / (E t)
_SHARE = 3.0**0.5 / 2.0  # k / (E t) of a spring with the share 1


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A net as a surface.

    Attributes:
        area: What each node stands for [m²], shape (node,).
        constant: Of each spring per Young's modulus and thickness, shape (spring,).
        range: The least and the largest Young's modulus of all directions, per the one given.
    """

    area: Floats
    constant: Floats
    range: tuple[float, float]


def surface(mesh: Mesh) -> Surface:
    """Return a mesh with a skin as a surface.

    Raises:
        ValueError: Some springs lie in no face of the surface.
    """
    if mesh.grid is not None:
        area, constant = _of_grid(mesh, mesh.grid)
    else:
        constant = area_shares(mesh.position, mesh.skin, mesh.ends, elsewhere=0.0) * _SHARE
        if not constant.all():
            raise ValueError("some of its springs lie in no triangle of its surface")
        area = node_areas(mesh.position, mesh.skin)
    found = range_of_wall(mesh.position, mesh.ends, constant, mesh.skin, mesh.grid)
    return Surface(area, constant, found)


def _of_grid(mesh: Mesh, grid: Grid) -> tuple[Floats, Floats]:
    """Return areas of nodes [m²] and constants of springs of a grid of equal cells."""
    rows, columns = np.divmod(mesh.ends.astype(np.int64), grid.columns)
    down, right = rows[:, 1] - rows[:, 0], columns[:, 1] - columns[:, 0]
    if grid.closed:  # the shorter way round
        half = grid.columns // 2
        right = (right + half) % grid.columns - half
        right = np.where(down == 0, np.abs(right), right)
    families = [(down == d) & (right == r) for d, r in STEPS]
    if not np.any(families, axis=0).all():
        raise ValueError("some of its springs join nodes that are not neighbours in its wall")
    plane = cell_sides(mesh, grid)
    area = float(np.linalg.det(plane))
    there = np.array([family.any() for family in families])
    found, _ = isotropic(np.array(STEPS)[:, ::-1] @ plane, there / area)
    free = (down == 0) & np.isin(rows[:, 0], (0, grid.rows - 1))
    if not grid.closed:
        free |= (right == 0) & np.isin(columns[:, 0], (0, grid.columns - 1))
    constant = _SHEAR * found @ np.array(families) * np.where(free, 0.5, 1.0)
    return _areas(grid, area), constant


def cell_sides(mesh: Mesh, grid: Grid) -> Floats:
    """Return both sides of a cell in its own plane [m], along a row first, shape (2, 2)."""
    sides = mesh.position[[1, grid.columns]] - mesh.position[0]
    return np.linalg.cholesky(sides @ sides.T)


def isotropic(vectors: Floats, weight: Floats) -> tuple[Floats, float]:
    """Return k ≥ 0 for which Σ k w L² n n n n is the tensor C of a surface with μ = 1.

    Args:
        vectors: L n in the plane [m], shape (k, 2).
        weight: w, shape (k,).

    Returns:
        k, shape (k,), and which part of C they miss.
    """
    from scipy.optimize import nnls

    made_of = np.stack([_moments(vector) for vector in vectors], axis=1) * weight
    wanted = np.array([3.0, 0.0, 6.0**0.5, 0.0, 3.0])
    found, missed = nnls(made_of, wanted)
    return found, float(missed / np.linalg.norm(wanted))


def _moments(vector: Floats) -> Floats:
    """Return L² n n n n of a vector in a plane; its squares sum up to the norm of that."""
    x, y = vector
    root = np.sqrt([1.0, 4.0, 6.0, 4.0, 1.0])
    return np.array([x**4, x**3 * y, x**2 * y**2, x * y**3, y**4]) * root / (x * x + y * y)


def _areas(grid: Grid, cell: float) -> Floats:
    """Return what the nodes of a grid stand for [m²], shape (node,)."""
    along = np.ones(grid.columns)
    if not grid.closed:
        along[[0, -1]] = 0.5
    across = np.ones(grid.rows)
    across[[0, -1]] = 0.5
    return np.asarray((cell * across[:, None] * along).ravel())
