"""Hinges that make a wall resist bending as a plate does.

A plate of thickness t with Poisson's ratio ν = 1/3 resists curvatures κ with the moments

    D_ijkl κ_kl,    D_ijkl = D/3 (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk),

and D = E t³ / (12 (1 - ν²)).

In a grid, a hinge at a node whose tips are a step s away on either hand folds by κ(s, s) / h,
h being how far the tips are from the line of its edge. So the hinges of a cell have to make up
Σ k s s s s / h² = A D_ijkl for its area A, as springs do in the plane (see ``surface``).

Hinges at the edges of other triangles, of length e between areas A and A', get

    k = D e² / (A + A'),

which is D 2/√3 for equilateral ones (H. S. Seung and D. R. Nelson, Phys. Rev. A 38:1005, 1988).
These have the right D, which is all that counts in strips and in plates whose borders are held,
but ν = -1/3: moments along a free border differ.
"""

import numpy as np
from msgspec import Struct

from tissuec.matter.surface import STEPS, cell_sides, in_plane, isotropic
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.bending import around_edges
from tissuec.model.network import Floats, Grid, Indices

RIGIDITY = 3.0 / 32.0  # D / (E t³)


class Plate(Struct, frozen=True, eq=False):
    """The hinges of a wall.

    Attributes:
        nodes: Ends of the edge and tips of each hinge, shape (hinge, 4).
        constant: Of each per flexural rigidity D, shape (hinge,); positive.
    """

    nodes: Indices
    constant: Floats


def plate(mesh: Mesh) -> Plate:
    """Return the hinges of a mesh with a skin."""
    if (grid := mesh.even_grid) is not None:
        return _of_grid(mesh, grid)
    nodes = around_edges(mesh.skin)
    i, j, k, m = (mesh.position[nodes[:, corner]] for corner in range(4))
    edge = j - i
    areas = [np.linalg.norm(np.cross(edge, tip - i), axis=1) / 2.0 for tip in (k, m)]
    turns = np.minimum(*areas) > 0.0
    constant = np.einsum("hk,hk->h", edge, edge)[turns] / (areas[0] + areas[1])[turns]
    return Plate(nodes[turns], constant)


def _of_grid(mesh: Mesh, grid: Grid) -> Plate:
    """Return the hinges of a grid of equal cells, in the directions of its springs."""
    plane = cell_sides(mesh, grid)
    area = float(np.linalg.det(plane))
    families = [_along(grid, step, edge) for step, edge in zip(STEPS, _EDGES, strict=True)]
    there = [len(nodes) > 0 and _is_joined(mesh, nodes) for nodes, _ in families]
    nodes = np.concatenate([nodes for nodes, _ in families])
    if not any(there):
        return Plate(nodes[:0], np.zeros(0))
    steps, edges = (np.array(each)[:, ::-1] @ plane for each in (STEPS, _EDGES))
    away = np.linalg.det(np.stack([steps, edges], axis=1)) / np.linalg.norm(edges, axis=1)
    stretch = in_plane(steps) * (np.linalg.norm(steps, axis=1) / away)[:, None]
    found = isotropic(stretch, np.array(there) / area)
    constant = [k / 3.0 * share for k, (_, share) in zip(found, families, strict=True)]
    total = np.concatenate(constant)
    return Plate(nodes[total > 0.0], total[total > 0.0])


#: To the other end of the edge of a hinge whose tips are one of ``STEPS`` away.
_EDGES = ((1, 0), (0, 1), (1, -1), (1, 1))


def _along(grid: Grid, step: tuple[int, int], edge: tuple[int, int]) -> tuple[Indices, Floats]:
    """Return the hinges with tips a step away on either hand, and the share of each.

    Those along a free border represent half of a cell. Where tips lead across both rows and
    columns there are none on the border, and those next to it represent its half cells too, as
    twist does not end there.
    """
    row, column = (
        each.ravel() for each in np.indices((grid.rows, grid.columns), dtype=np.int64)
    )

    def node(down: int, right: int) -> tuple[Indices, "np.ndarray"]:
        r, c = row + down, column + right
        inside = (r >= 0) & (r < grid.rows)
        if not grid.closed:
            inside &= (c >= 0) & (c < grid.columns)
        return r * grid.columns + c % grid.columns, inside

    ahead, has_ahead = node(*step)
    behind, has_behind = node(-step[0], -step[1])
    one, has_one = node(*edge)
    other, has_other = node(-edge[0], -edge[1])
    exists = has_ahead & has_behind & (has_one | has_other)
    end = np.where(has_one, one, other)
    nodes = np.stack([row * grid.columns + column, end, ahead, behind], axis=1)
    share: Floats = np.where(has_one & has_other, 1.0, 0.5)
    if all(step):
        share = 1.0 + 0.5 * np.sum([row == r for r in (1, grid.rows - 2)], axis=0)
        if not grid.closed:
            share *= 1.0 + 0.5 * np.sum([column == c for c in (1, grid.columns - 2)], axis=0)
    return nodes[exists], share[exists]


def _is_joined(mesh: Mesh, nodes: Indices) -> bool:
    """Return whether springs lead to the tips of a hinge."""
    pair = np.sort(nodes[0, [0, 2]])
    return bool((np.sort(mesh.ends, axis=1) == pair).all(axis=1).any())
