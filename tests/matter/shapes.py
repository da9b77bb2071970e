"""Bars as mesh files, of tetrahedra or as surfaces; lengths in mm."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import Delaunay

from tissuec.meshes.generators.lattice import Lattice

Floats = NDArray[np.float64]
Cells = NDArray[np.int_]
SIDES = np.array([40.0, 20.0, 20.0])  # of a bar


def tetrahedra(sides: ArrayLike, cell: float, moved: float) -> tuple[Floats, Cells]:
    """Return nodes and tetrahedra of a bar, nodes inside moved by a part of its cell."""
    lattice = Lattice("caesium chloride", cell, (np.zeros(3), sides)).build()
    x = lattice.position.copy()
    inside = ((x > 0.0) & (x < sides)).all(axis=1)
    x[inside] += moved * cell * np.random.default_rng(1).uniform(-1, 1, x[inside].shape)
    cells = Delaunay(x + 1e-7 * inside[:, None] * np.sin(x)).simplices
    volume = np.abs(np.linalg.det(x[cells[:, 1:]] - x[cells[:, :1]])) / 6.0
    return x, cells[volume > 1e-6 * cell**3]


def as_vtk(x: Floats, cells: Cells) -> str:
    """Return tetrahedra as the text of a VTK file."""
    points = "\n".join(" ".join(map(repr, row)) for row in x.tolist())
    corners = "\n".join(f"4 {a} {b} {c} {d}" for a, b, c, d in cells.tolist())
    kinds = "\n".join(["10"] * len(cells))
    return (
        "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(x)} double\n{points}\nCELLS {len(cells)} {5 * len(cells)}\n{corners}\n"
        f"CELL_TYPES {len(cells)}\n{kinds}\n"
    )


def surface(sides: ArrayLike, edge: float) -> tuple[Floats, Cells]:
    """Return nodes and outward triangles of a bar, whose faces are squares of about an edge."""
    count = np.maximum(np.rint(np.asarray(sides) / edge), 1).astype(int)
    number, triangles = {}, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for high in (False, True):
            for i, j in np.ndindex(count[u], count[v]):
                corners = []
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))[
                    :: 1 if high else -1
                ]:
                    place = [0, 0, 0]
                    place[axis], place[u], place[v] = high * count[axis], a, b
                    corners.append(number.setdefault(tuple(place), len(number)))
                triangles += [corners[:3], [corners[0], *corners[2:]]]
    return np.array(list(number)) * (sides / count), np.array(triangles)


def as_obj(x: Floats, triangles: Cells) -> str:
    """Return triangles as the text of an OBJ file."""
    points = "\n".join("v " + " ".join(map(repr, row)) for row in x.tolist())
    corners = "\n".join(f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist())
    return f"{points}\n{corners}\n"
