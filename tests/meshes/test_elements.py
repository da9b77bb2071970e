"""Meshes of finite elements: from lattices and files, with matching faces and whole volumes."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from tests.imports.organs import blob, box_of_hexahedra, box_of_tetrahedra, write_msh, write_obj
from tissuec.core.fields import LocatedFile
from tissuec.geometry.edges import Edges, volume
from tissuec.geometry.elements import MIDDLES, SHAPES, Measures
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.imported import Imported, MeshFileError
from tissuec.meshes.generators.lattice import Lattice

TYPES = {4: 10, 5: 14, 6: 13, 8: 12}  # of VTK, by the number of corners
CUBE = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]) * 10.0

ASIDE = np.array([30.0, 0.0, 0.0])


def from_cells(folder: Path, position, *cells, **entries) -> Mesh:
    """Return the mesh of a file in millimetres with cells of any kind."""
    rows = [f"{len(nodes)} {' '.join(map(str, nodes))}" for nodes in cells]
    (folder / "a.vtk").write_text(
        "# vtk DataFile Version 3.0\nmixed\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(position)} double\n"
        + "\n".join(" ".join(map(repr, map(float, row))) for row in position)
        + f"\nCELLS {len(cells)} {sum(len(nodes) + 1 for nodes in cells)}\n"
        + "\n".join(rows)
        + f"\nCELL_TYPES {len(cells)}\n"
        + "\n".join(str(TYPES[len(nodes)]) for nodes in cells)
        + "\n"
    )
    return elements_of(folder / "a.vtk", **entries)


def elements_of(path: Path, **entries) -> Mesh:
    return Imported(LocatedFile(path.name, path, 1e-3), **entries).build_elements()


def refusal(folder: Path, position, *cells) -> str:
    with pytest.raises(MeshFileError) as caught:
        from_cells(folder, position, *cells)
    return f"{caught.value} | {caught.value.hint}"


def shapes_of(mesh: Mesh) -> dict[str, int]:
    return {one.shape: len(one.nodes) for one in mesh.elements}


def check(mesh: Mesh, size: float) -> None:
    """Check what holds for every solid of a known volume [m³]."""
    assert mesh.volume is not None
    total = sum(
        Measures.of(SHAPES[one.shape], mesh.position[one.nodes]).volume.sum()
        for one in mesh.elements
    )
    assert total == pytest.approx(size, rel=1e-12)
    assert mesh.volume.sum() == pytest.approx(size, rel=1e-12)
    assert mesh.volume.min() > 0.0
    assert Edges.among(mesh.skin).is_closed
    assert volume(mesh.position, mesh.skin) == pytest.approx(size, rel=1e-12)
    joined = {
        (min(a, b), max(a, b))
        for one in mesh.elements
        for nodes in one.nodes.tolist()
        for a, b in ((nodes[i], nodes[j]) for i, j in SHAPES[one.shape].edges.tolist())
    }
    assert mesh.ends.tolist() == sorted(map(list, joined))


def test_a_lattice_gives_a_hexahedron_for_each_cell():
    sides = np.array([0.02, 0.03, 0.04])
    lattice = Lattice("sodium chloride", 0.01, (np.zeros(3), sides))
    mesh = lattice.build_elements()
    assert shapes_of(mesh) == {"hexahedron": 24}
    assert mesh.position.tolist() == lattice.build().position.tolist()
    assert mesh.ends.tolist() == lattice.build().ends.tolist()  # the edges of cells
    check(mesh, float(sides.prod()))
    np.testing.assert_allclose(mesh.volume, lattice.build().volume, rtol=1e-12)
    (cells,) = mesh.elements
    faces, _ = lattice.cell_nodes()
    assert np.sort(cells.nodes).tolist() == [sorted(set(cell.ravel())) for cell in faces]


def test_tetrahedra_get_a_node_on_each_edge_and_straight_sides(tmp_path):
    position, cells = box_of_tetrahedra(3)
    write_msh(tmp_path / "box.msh", position, cells, "half")
    mesh = elements_of(tmp_path / "box.msh")
    edges = {tuple(sorted(p)) for row in cells.tolist() for p in combinations(row, 2)}
    assert shapes_of(mesh) == {"tetrahedron": len(cells)}
    assert len(mesh.position) == len(position) + len(edges)
    (one,) = mesh.elements
    corners = mesh.position[one.nodes]
    np.testing.assert_allclose(corners[:, 4:], corners[:, MIDDLES].mean(axis=2), atol=1e-15)
    check(mesh, 27e-6)
    assert len(mesh.skin) == 6 * 9 * 2 * 4
    half = cells[len(cells) // 2 :]
    places = {tuple(np.round(p, 9)) for p in position[np.unique(half)] / 1000.0}
    inside = {
        tuple(np.round(position[list(p)].mean(axis=0) / 1000.0, 9))
        for p in edges
        if set(p) <= set(half.ravel().tolist())
    }
    found = {tuple(np.round(p, 9)) for p in mesh.position[mesh.groups["half"]]}
    assert found == places | inside


def test_hexahedra_of_files_stay_hexahedra(tmp_path):
    position, cells = box_of_hexahedra(2)
    mesh = from_cells(tmp_path, position, *cells.tolist())
    assert shapes_of(mesh) == {"hexahedron": 8}
    check(mesh, 8e-6)


def test_wedges_beside_hexahedra_stay_wedges(tmp_path):
    position = np.concatenate([CUBE, [(20, 0, 0), (20, 0, 10)]])
    mesh = from_cells(tmp_path, position, range(8), (1, 2, 8, 5, 6, 9))
    assert shapes_of(mesh) == {"hexahedron": 1, "wedge": 1}
    check(mesh, 1.5e-6)


@pytest.mark.parametrize("order", [[4, 5, 6, 7, 0, 1, 2, 3], [1, 0, 3, 2, 5, 4, 7, 6]])
def test_cells_in_mirror_image_are_turned(order, tmp_path):
    mesh = from_cells(tmp_path, CUBE, order)
    check(mesh, 1e-6)


def test_hexahedra_that_meet_tetrahedra_are_divided(tmp_path):
    roof = np.concatenate([CUBE, [(5, 5, 20)]])
    mesh = from_cells(tmp_path, roof, range(8), (4, 5, 6, 7, 8))
    assert set(shapes_of(mesh)) == {"tetrahedron"}
    check(mesh, 1e-6 + 1e-6 / 3.0)


def test_hexahedra_apart_from_tetrahedra_stay(tmp_path):
    position = np.concatenate([CUBE, CUBE[[0, 1, 3, 4]] + ASIDE])
    mesh = from_cells(tmp_path, position, range(8), range(8, 12))
    assert shapes_of(mesh) == {"hexahedron": 1, "tetrahedron": 1}
    check(mesh, 1e-6 + 1e-6 / 6.0)


def test_a_hexahedron_with_a_corner_twice_is_divided(tmp_path):
    mesh = from_cells(tmp_path, CUBE[:7], (0, 1, 2, 3, 4, 5, 6, 6))
    assert set(shapes_of(mesh)) == {"tetrahedron"}
    assert Edges.among(mesh.skin).is_closed


def test_a_filled_surface_consists_of_tetrahedra(tmp_path):
    write_obj(tmp_path / "a.obj", *blob(2))
    whole = Imported(
        LocatedFile("a.obj", tmp_path / "a.obj", 1e-3), filling="tetrahedra", cell=0.025
    )
    mesh, net = whole.build_elements(), whole.build()
    assert mesh.volume is not None and net.tetrahedra is not None
    a, b, c, d = net.position[net.tetrahedra].swapaxes(0, 1)
    size = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6.0
    # Flat tetrahedra behind the surface are left out.
    outside = volume(mesh.position, mesh.skin)
    assert outside == pytest.approx(size, rel=5e-3)
    assert mesh.volume.sum() == pytest.approx(outside, rel=1e-9)
    assert mesh.volume.min() > 0.0


def test_what_cannot_consist_of_elements_is_refused(tmp_path):
    flat = CUBE[[0, 1, 2, 3]]
    assert refusal(tmp_path, np.concatenate([CUBE + ASIDE, flat]), range(8), range(8, 12))
    folded = CUBE.copy()
    folded[6] = (2, 2, 2)
    text = refusal(tmp_path, np.concatenate([CUBE + ASIDE, folded]), range(8), range(8, 16))
    assert '"a.vtk": 1 folded hexahedron, the first of them hexahedron 2 around ' in text
    assert text.endswith("repair it in the program that made the mesh, or remove it there")
    write_obj(tmp_path / "a.obj", *blob(1))
    with pytest.raises(MeshFileError) as caught:
        elements_of(tmp_path / "a.obj")
    assert "surface" in str(caught.value)
    assert "filling is tetrahedra" in caught.value.hint
