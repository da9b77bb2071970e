"""Bars of tetrahedra as mesh files; lengths in mm."""

import numpy as np
from scipy.spatial import Delaunay

from tissuec.meshes.lattice import Lattice

SIDES = np.array([40.0, 20.0, 20.0])  # of a bar


def tetrahedra(sides, cell, moved):
    """Return nodes and tetrahedra of a bar, nodes inside moved by a part of its cell."""
    lattice = Lattice("caesium chloride", cell, (np.zeros(3), sides)).build()
    x = lattice.position.copy()
    inside = ((x > 0.0) & (x < sides)).all(axis=1)
    x[inside] += moved * cell * np.random.default_rng(1).uniform(-1, 1, x[inside].shape)
    cells = Delaunay(x + 1e-7 * inside[:, None] * np.sin(x)).simplices
    volume = np.abs(np.linalg.det(x[cells[:, 1:]] - x[cells[:, :1]])) / 6.0
    return x, cells[volume > 1e-6 * cell**3]


def as_vtk(x, cells):
    """Return tetrahedra as the text of a VTK file."""
    points = "\n".join(" ".join(map(repr, row)) for row in x.tolist())
    corners = "\n".join(f"4 {a} {b} {c} {d}" for a, b, c, d in cells.tolist())
    kinds = "\n".join(["10"] * len(cells))
    return (
        "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(x)} double\n{points}\nCELLS {len(cells)} {5 * len(cells)}\n{corners}\n"
        f"CELL_TYPES {len(cells)}\n{kinds}\n"
    )
