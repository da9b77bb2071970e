"""Organs from files: the same from every format, filled, repaired, or refused with a reason."""

import re
import time
from contextlib import suppress
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.imports.organs import (
    WRITERS,
    blob,
    box_of_hexahedra,
    box_of_tetrahedra,
    write_feb,
    write_msh,
    write_obj,
    write_stl,
    write_stl_text,
    write_vtk,
    write_vtu,
)
from tissuec.core.fields import LocatedFile
from tissuec.geometry.edges import Edges, volume
from tissuec.geometry.inside import inside
from tissuec.meshes.generators.imported import Imported, MeshFileError
from tissuec.model.topology import floppy_modes, pieces

FILLINGS = ("sodium chloride", "caesium chloride", "diamond", "tetrahedra")


def imported(path: Path, **entries):
    """Return the mesh of a file in millimetres."""
    return Imported(LocatedFile(path.name, path, 1e-3), **entries).build()


def refusal(path: Path, **entries) -> str:
    with pytest.raises(MeshFileError) as caught:
        imported(path, **entries)
    return f"{caught.value} | {caught.value.hint}"


def test_every_format_has_a_writer_here():
    from tissuec.meshes.formats import FORMATS

    assert {Path(name).suffix for name in WRITERS} == set(FORMATS)


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_organ(name, tmp_path):
    position, triangles = blob(3)
    WRITERS[name](tmp_path / name, position, triangles)
    mesh = imported(tmp_path / name)
    assert not mesh.remarks
    assert len(mesh.position) == len(position)
    # STL holds single precision: 110 mm to 24 bits.
    allowed = 1e-8 if name.endswith(".stl") else 1e-15
    gap = np.linalg.norm(mesh.position[:, None] - position / 1000.0, axis=2)
    number = gap.argmin(axis=1)
    assert gap.min(axis=1).max() < allowed
    expected = {tuple(pair) for pair in Edges.among(triangles).ends.tolist()}
    assert {tuple(sorted(pair)) for pair in number[mesh.ends].tolist()} == expected
    found = volume(mesh.position, mesh.skin.astype(np.int64))
    assert found == pytest.approx(1e-9 * volume(position, triangles), rel=1e-6)
    assert found > 0


LARGE = 20480  # triangles
QUICK = ("sodium chloride", "tetrahedra")


@pytest.mark.parametrize(
    ("filling", "count"),
    [
        *((filling, LARGE // 4) for filling in QUICK),
        *(
            pytest.param(filling, count, marks=pytest.mark.slow)
            for filling in FILLINGS
            for count in (LARGE // 4, LARGE)
            if count == LARGE or filling not in QUICK
        ),
    ],
)
def test_an_organ_of_up_to_twenty_thousand_triangles_is_filled(filling, count, tmp_path):
    position, triangles = blob(5 if count == LARGE else 4)
    assert len(triangles) == count
    write_obj(tmp_path / "liver.obj", position, triangles)
    start = time.process_time()
    mesh = imported(tmp_path / "liver.obj", filling=filling, cell=0.008)
    # Half of it is usual; other work on the computer must not fail the test.
    assert time.process_time() - start < 6.0
    inner = mesh.position[len(position) :]
    assert len(inner) > 500
    assert inside(inner, 1e-3 * position, triangles).all()
    assert not pieces(len(mesh.position), mesh.ends).any()
    assert np.bincount(mesh.ends.ravel()).min() >= 3
    length = np.linalg.norm(
        mesh.position[mesh.ends[:, 0]] - mesh.position[mesh.ends[:, 1]], axis=1
    )
    assert length.max() < 2.0 * 0.008 + 1e-9
    # A cell holds so many nodes; those near the surface are left out.
    per_cell = {"sodium chloride": 1, "caesium chloride": 2, "diamond": 8, "tetrahedra": 2}
    cells = 1e-9 * volume(position, triangles) / 0.008**3
    assert 0.6 * per_cell[filling] * cells < len(inner) < per_cell[filling] * cells


@pytest.mark.parametrize("filling", FILLINGS)
def test_filled_with_second_neighbours_nothing_folds(filling, tmp_path):
    position, triangles = blob(1)
    write_obj(tmp_path / "liver.obj", position, triangles)
    reach = {} if filling == "tetrahedra" else {"reach": "second neighbours"}
    mesh = imported(tmp_path / "liver.obj", filling=filling, cell=0.036, **reach)
    held = np.zeros(len(mesh.position), dtype=bool)
    length = np.linalg.norm(
        mesh.position[mesh.ends[:, 0]] - mesh.position[mesh.ends[:, 1]], axis=1
    )
    modes = floppy_modes(mesh.position, mesh.ends, np.ones(len(length)), length, held)
    assert modes.checked
    assert (modes.count, modes.rigid) == (0, 6)


def test_tetrahedra_fill_the_volume_of_a_smooth_organ(tmp_path):
    position, triangles = blob(4)
    write_obj(tmp_path / "liver.obj", position, triangles)
    mesh = imported(
        tmp_path / "liver.obj", filling="tetrahedra", cell=0.01, stiffness="volume rule"
    )
    assert not mesh.remarks
    assert mesh.shares is not None and mesh.shares.mean() == pytest.approx(1.0, rel=1e-2)


def test_no_spring_bridges_a_cleft(tmp_path):
    """A thin flap over a block, joined at one end: the nearest inner nodes lie across it."""
    size = (range(10), range(4), range(6))
    cells = [(x, y, z) for x, y, z in product(*size) if z != 4 or x < 2]
    position, triangles = surface_of_boxes(cells, thin={4: 0.6})
    write_obj(tmp_path / "flap.obj", position, triangles)
    mesh = imported(tmp_path / "flap.obj", filling="sodium chloride", cell=0.0013)
    flap = (
        "nodes of the surface not joined to the inside: the body is thin compared with "
        "the cell there"
    )
    assert len(mesh.remarks) == 1 and mesh.remarks[0].endswith(flap)
    assert len(mesh.position) > len(position) + 20
    x, _, z = mesh.position[mesh.ends].transpose(2, 0, 1)
    bridges = (z.min(axis=1) < 0.0041) & (z.max(axis=1) > 0.0045) & (x.min(axis=1) > 0.0025)
    assert not bridges.any()


def surface_of_boxes(cells, thin):
    """Return the outward surface of unit boxes, whose layers along z may be thinner."""
    heights = np.concatenate([[0.0], np.cumsum([thin.get(k, 1.0) for k in range(20)])])
    taken = set(cells)
    number, quads = {}, []
    for cell in cells:
        for axis in range(3):
            for step in (0, 1):
                beyond = list(cell)
                beyond[axis] += 2 * step - 1
                if tuple(beyond) in taken:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                rows = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += step
                    corner[u] += du
                    corner[v] += dv
                    rows.append(number.setdefault(tuple(corner), len(number)))
                quads.append(rows if step else rows[::-1])
    place = np.array(list(number), dtype=float)
    place[:, 2] = heights[place[:, 2].astype(int)]
    quads = np.array(quads)
    return place, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def test_a_cavity_stays_empty_and_faces_inwards(tmp_path):
    position, triangles = blob(2)
    middle = position.mean(axis=0)
    both = np.concatenate([position, middle + 0.5 * (position - middle)])
    shells = np.concatenate([triangles, triangles + len(position)])  # both face outwards
    write_obj(tmp_path / "hollow.obj", both, shells)
    mesh = imported(tmp_path / "hollow.obj", filling="sodium chloride", cell=0.01)
    assert mesh.remarks[0] == "320 triangles flipped to face the same way as the others"
    enclosed = volume(mesh.position, mesh.skin.astype(np.int64))
    assert enclosed == pytest.approx(1e-9 * volume(position, triangles) * (1 - 0.125), rel=1e-9)
    inner = 1000 * mesh.position[len(both) :]
    assert not inside(inner, middle + 0.5 * (position - middle), triangles).any()


# --- cells -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "writer"),
    [("a.vtk", write_vtk), ("a.vtu", write_vtu), ("a.msh", write_msh), ("a.feb", write_feb)],
)
@pytest.mark.parametrize("box", [box_of_tetrahedra, box_of_hexahedra])
def test_the_skin_of_a_box_of_cells_is_its_surface(name, writer, box, tmp_path):
    position, cells = box(3)
    writer(tmp_path / name, position, cells)
    mesh = imported(tmp_path / name)
    skin = mesh.skin.astype(np.int64)
    assert len(skin) == 2 * 6 * 9
    assert Edges.among(skin).is_closed
    assert volume(mesh.position, skin) == pytest.approx(27e-6, rel=1e-12)
    # Edges of the grid, and both diagonals of each of its faces; or one, and one in each cube.
    grid, squares = 3 * 3 * 16, 3 * 4 * 9
    assert len(mesh.ends) == grid + squares + (27 if box is box_of_tetrahedra else squares)
    assert len(mesh.tetrahedra) == 6 * 27


def test_a_hexahedron_does_not_fold(tmp_path):
    position, cells = box_of_hexahedra(2)
    write_vtk(tmp_path / "box.vtk", position, cells)
    mesh = imported(tmp_path / "box.vtk")
    length = np.linalg.norm(
        mesh.position[mesh.ends[:, 0]] - mesh.position[mesh.ends[:, 1]], axis=1
    )
    modes = floppy_modes(
        mesh.position, mesh.ends, np.ones(len(length)), length, np.zeros(27, dtype=bool)
    )
    assert (modes.count, modes.rigid) == (0, 6)


def test_wedges_and_pyramids_enclose_what_they_hold(tmp_path):
    """A cube of two wedges, and a pyramid as its roof."""
    points = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 1.8"
    (tmp_path / "mixed.vtk").write_text(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS 9 float\n{points}\nCELLS 3 20\n"
        "6 0 1 2 4 5 6\n6 0 2 3 4 6 7\n5 4 5 6 7 8\nCELL_TYPES 3\n13 13 14\n"
    )
    mesh = imported(tmp_path / "mixed.vtk")
    skin = mesh.skin.astype(np.int64)
    # The square below the pyramid is one face for it and two for the wedges; both sides stay in
    # the skin, where they cancel.
    assert volume(mesh.position, skin) == pytest.approx((1 + 0.8 / 3) * 1e-9, rel=1e-12)


def test_quads_are_cut_along_their_shorter_diagonal(tmp_path):
    (tmp_path / "kite.obj").write_text("v 0 0 0\nv 3 -1 0\nv 5 0 0\nv 3 1 0\nf 1 2 3 4\n")
    mesh = imported(tmp_path / "kite.obj")
    assert [1, 3] in mesh.ends.tolist() and [0, 2] not in mesh.ends.tolist()


# --- groups ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "writer", "group"),
    [
        ("a.obj", write_obj, "tumour"),
        ("a.msh", write_msh, "tumour"),
        ("a.feb", write_feb, "tumour"),
        ("b.feb", lambda *a: write_feb(*a, version="4.0"), "tumour"),
        (
            "a.vtk",
            lambda p, x, c, g: write_vtk(p, x, c, parts=1 * (np.arange(len(c)) >= len(c) // 2)),
            "label 1",
        ),
        (
            "a.vtu",
            lambda p, x, c, g: write_vtu(p, x, c, 1 * (np.arange(len(c)) >= len(c) // 2)),
            "label 1",
        ),
    ],
)
def test_groups_of_every_format(name, writer, group, tmp_path):
    position, triangles = blob(2)
    writer(tmp_path / name, position, triangles, "tumour")
    mesh = imported(tmp_path / name)
    expected = np.unique(triangles[len(triangles) // 2 :])
    assert np.array_equal(mesh.groups[group], expected)


def test_solids_of_a_text_stl_are_groups(tmp_path):
    position, triangles = blob(1)
    for part, rows in (("left", triangles[:40]), ("right", triangles[40:])):
        write_stl_text(tmp_path / f"{part}.stl", position, rows)
    text = [
        (tmp_path / f"{part}.stl").read_text().replace("blob", part)
        for part in ("left", "right")
    ]
    (tmp_path / "both.stl").write_text("".join(text))
    mesh = imported(tmp_path / "both.stl")
    assert {name: len(nodes) for name, nodes in mesh.groups.items()} == {
        "left": len(np.unique(triangles[:40])),
        "right": len(np.unique(triangles[40:])),
    }


def test_vertices_counted_backwards(tmp_path):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf 1/2/3 -3//1 -1\n"
    )
    mesh = imported(tmp_path / "a.obj")
    assert mesh.skin.tolist() == [[0, 1, 2], [0, 1, 3]] or len(mesh.skin) == 2
    assert {tuple(sorted(t)) for t in mesh.skin.tolist()} == {(0, 1, 2), (0, 1, 3)}


# --- repair ----------------------------------------------------------------------------------


def test_repairs_are_counted_and_give_the_clean_organ(tmp_path):
    position, triangles = blob(2)
    random = np.random.default_rng(4)
    dirty = np.concatenate([position, position[:30] + 1e-5, [(500.0, 0.0, 0.0)] * 5])
    broken = triangles.copy()
    moved = random.permutation(
        np.flatnonzero((triangles == triangles.min(axis=1, keepdims=True)).any(axis=1))
    )[:60]
    for row in moved:
        small = np.flatnonzero(broken[row] < 30)
        broken[row, small[:1]] += len(position)
    turned = random.permutation(len(broken))[:40]
    broken[turned] = broken[turned][:, ::-1]
    used = len(np.intersect1d(broken, np.arange(len(position), len(position) + 30)))
    lost = len(np.setdiff1d(np.arange(30), broken))
    broken = np.concatenate([broken, broken[:7], [[0, 0, 1]] * 3])
    write_obj(tmp_path / "dirty.obj", dirty, broken)
    mesh = imported(tmp_path / "dirty.obj")
    assert mesh.remarks == (
        f"{5 + (30 - used) + lost} nodes without a surface or cell removed",
        f"{used - lost} nodes merged with another node that is no more than 238 nm away",
        "3 triangles with two corners in one node removed",
        "7 triangles removed (duplicate)",
        "40 triangles flipped to face the same way as the others",
    )
    assert Edges.among(mesh.skin.astype(np.int64)).is_closed
    assert len(mesh.skin) == len(triangles)
    clean = 1e-9 * volume(position, triangles)
    assert volume(mesh.position, mesh.skin.astype(np.int64)) == pytest.approx(clean, rel=1e-5)


def test_an_organ_inside_out_is_turned(tmp_path):
    position, triangles = blob(2)
    write_obj(tmp_path / "a.obj", position, triangles[:, ::-1])
    mesh = imported(tmp_path / "a.obj")
    said = "the surface turned inside out: all of its triangles faced inwards"
    assert mesh.remarks == (said,)
    assert volume(mesh.position, mesh.skin.astype(np.int64)) > 0


def test_edges_of_three_triangles_are_told_and_cannot_be_filled(tmp_path):
    position, triangles = blob(1)
    fin = np.array([[0, 12, len(position)]])
    edge = Edges.among(triangles).ends[0]
    fin[0, :2] = edge
    write_obj(
        tmp_path / "fin.obj", np.vstack([position, [0, 0, 300]]), np.vstack([triangles, fin])
    )
    mesh = imported(tmp_path / "fin.obj")
    assert mesh.remarks[0].startswith(
        "1 edge of more than two triangles, the first of them between ("
    )
    said = refusal(tmp_path / "fin.obj", filling="diamond", cell=0.02)
    assert (
        "not closed and cannot be filled: 2 edges of one triangle, at a hole around "
        "(4.67 mm, -11.2 mm, 158 mm); 1 of more than two" in said
    )


def test_merging_can_be_widened_and_switched_off(tmp_path):
    position, triangles = blob(1)
    write_stl(tmp_path / "a.stl", position, triangles)
    soup = position[triangles].reshape(-1, 3) + np.random.default_rng(1).uniform(
        -0.01, 0.01, (240, 3)
    )
    write_obj(tmp_path / "soup.obj", soup, np.arange(240).reshape(-1, 3))
    assert len(imported(tmp_path / "soup.obj").position) == 240
    assert len(imported(tmp_path / "soup.obj", merging_distance=5e-5).position) == len(position)
    double = np.concatenate([position, position])
    write_obj(
        tmp_path / "two.obj", double, np.concatenate([triangles, triangles[:, ::-1] + 42])
    )
    assert len(imported(tmp_path / "two.obj").position) == 42
    assert "42 nodes merged" in imported(tmp_path / "two.obj").remarks[0]


def test_two_builds_of_a_filled_organ_are_equal(tmp_path):
    position, triangles = blob(2)
    write_obj(tmp_path / "a.obj", position, triangles)
    for filling in FILLINGS:
        one, other = (
            imported(tmp_path / "a.obj", filling=filling, cell=0.012) for _ in range(2)
        )
        assert one.ends.tobytes() == other.ends.tobytes()
        assert one.position.tobytes() == other.position.tobytes()


# --- what is refused -------------------------------------------------------------------------


@pytest.fixture
def organ(tmp_path):
    """Return a folder with a small organ in every format that the library is there for."""
    position, triangles = blob(1)
    for name, write in WRITERS.items():
        write(tmp_path / name, position, triangles)
    return tmp_path


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("part", [0.3, 0.6, 0.93])
def test_a_truncated_file_is_refused(name, part, organ):
    path = organ / name
    data = path.read_bytes()
    path.write_bytes(data[: int(part * len(data))])
    if name == "organ.obj":
        # Text of lines: half an organ is an organ with a hole, unless a line or a vertex lacks.
        with suppress(MeshFileError):
            assert not Edges.among(imported(path).skin.astype(np.int64)).is_closed
        return
    said = refusal(path)
    assert said.startswith(f'"{name}": ')
    assert re.search(
        "truncated|cannot be read|are missing|begin|no \\$Elements|no cell", said
    ), said


@pytest.mark.parametrize("name", WRITERS)
def test_noise_never_passes_in_silence(name, organ):
    """Bytes changed at random give an organ, a remark or a refusal, and no other error."""
    path, random = organ / name, np.random.default_rng(11)
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    for _ in range(12):
        noisy = data.copy()
        noisy[random.integers(0, len(data), 6)] = random.integers(32, 127, 6)
        path.write_bytes(noisy.tobytes())
        try:
            mesh = imported(path)
        except MeshFileError:
            continue
        assert np.isfinite(mesh.position).all()
        assert mesh.ends.min() >= 0 and mesh.ends.max() < len(mesh.position)


@pytest.mark.parametrize("name", [n for n in WRITERS if n not in ("organ.stl", "text.stl")])
def test_a_file_under_another_name_is_told_its_own(name, organ):
    path = organ / name
    other = path.with_name("other.stl")
    other.write_bytes(path.read_bytes())
    assert f'rename it to "other{path.suffix}"' in refusal(other)


def test_exact_refusals(tmp_path):
    cases = {
        "empty.stl": ("", "the file is empty | "),
        "nothing.obj": (
            "v 0 0 0\nv 1 0 0\nl 1 2\n",
            "it contains no surface and no cell, only 2 nodes and 1 line | ",
        ),
        "far.obj": (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
            "line 4 uses vertex 4, but there are 3 | ",
        ),
        "zero.obj": (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
            'line 4 cannot be read: "f 0 1 2" | ',
        ),
        "nan.obj": (
            "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
            "1 node with a coordinate that is not finite, the first of them node 2 | ",
        ),
        "organ.step": (
            "x",
            'the format ".step" is not supported | make a mesh of it first, such as with Gmsh: '
            'gmsh "organ.step" -3 -o "organ.msh"  '
            "formats: .feb, .inp, .mesh, .msh, .obj, .off, .ply, .stl, .vtk, .vtkhdf, .vtp, "
            ".vtu, .nrrd, .nhdr, .nii, .nii.gz",
        ),
        "grid.vtk": (
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n",
            "it contains STRUCTURED_POINTS; POLYDATA or UNSTRUCTURED_GRID is needed | "
            "an image is not a mesh: make a surface of it (a segmentation in 3D Slicer, or the "
            'filter Contour of ParaView), and save that as "grid.stl" or "grid.vtp"',
        ),
        "lobe.vtk": (
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 2 2 2\n",
            "it contains STRUCTURED_GRID; POLYDATA or UNSTRUCTURED_GRID is needed | write its "
            "cells one by one, in Python with pyvista: "
            'pyvista.read("lobe.vtk").cast_to_unstructured_grid().save("lobe.vtu")',
        ),
        "lobe.vts": (
            '<VTKFile type="StructuredGrid"/>',
            'the format ".vts" is not supported | write its cells one by one, in Python with '
            'pyvista: pyvista.read("lobe.vts").cast_to_unstructured_grid().save("lobe.vtu")  '
            "formats: .feb, .inp, .mesh, .msh, .obj, .off, .ply, .stl, .vtk, .vtkhdf, .vtp, "
            ".vtu, .nrrd, .nhdr, .nii, .nii.gz",
        ),
        "renamed.vtu": (
            '<VTKFile type="StructuredGrid"><StructuredGrid/></VTKFile>',
            'it contains no "UnstructuredGrid" | write its cells one by one, in Python with '
            'pyvista: pyvista.read("renamed.vtu").cast_to_unstructured_grid()'
            '.save("renamed.vtu")',
        ),
        "folded.feb": (
            '<febio_spec version="4.0"><Mesh><Nodes><node id="1">0,0,0</node>'
            '<node id="2">1,0,0</node><node id="3">0,1,0</node></Nodes>'
            '<Elements type="tet4"><elem id="9">1,2,3,3</elem></Elements></Mesh></febio_spec>',
            "1 tetra with two corners at the same position, the first of them tetra 1 | "
            "remove it, or write: merging is off",
        ),
        "lost.feb": (
            '<febio_spec><Mesh><Nodes><node id="1">0,0,0</node></Nodes>'
            '<Elements type="tri3"><elem id="9">1,2,3</elem></Elements></Mesh></febio_spec>',
            'elem "9" contains node 2, which does not exist | ',
        ),
        "laughs.feb": (
            '<!DOCTYPE a [<!ENTITY l "ha"><!ENTITY m "&l;&l;">]><febio_spec>&m;</febio_spec>',
            "it defines a document type, which mesh files do not need | ",
        ),
        "laughs.vtu": (
            '<!DOCTYPE a [<!ENTITY l "ha">]><VTKFile>&l;</VTKFile>',
            "it defines a document type, which mesh files do not need | ",
        ),
        "elsewhere.feb": (
            '<febio_spec><Geometry from="geo.feb"/></febio_spec>',
            'its mesh is in another file, "geo.feb" | ',
        ),
    }
    for name, (text, expected) in cases.items():
        (tmp_path / name).write_text(text)
        assert refusal(tmp_path / name) == f'"{name}": {expected}'


def test_coordinates_that_are_not_finite_in_binary(tmp_path):
    position, triangles = blob(1)
    position[5] = np.nan
    write_stl(tmp_path / "a.stl", position, triangles)
    assert "with a coordinate that is not finite, the first of them node" in refusal(
        tmp_path / "a.stl"
    )


def test_a_volume_cannot_be_filled_and_rules_ask_for_their_cells(tmp_path):
    position, cells = box_of_hexahedra(1)
    write_vtk(tmp_path / "box.vtk", position, cells)
    path = tmp_path / "box.vtk"
    assert "it contains volume cells, which cannot be filled" in refusal(
        path, filling="diamond", cell=0.01
    )
    assert "the area rule is for surfaces" in refusal(path, stiffness="area rule")
    assert "but it contains 1 other cell" in refusal(path, stiffness="volume rule")
    write_obj(tmp_path / "blob.obj", *blob(1))
    assert "the volume rule is for tetrahedra, but there are none" in refusal(
        tmp_path / "blob.obj", stiffness="volume rule"
    )


def test_a_cell_too_large_or_too_small_is_refused(tmp_path):
    position, triangles = blob(2)
    write_obj(tmp_path / "a.obj", position, triangles)
    path = tmp_path / "a.obj"
    assert "no node of the filling lies inside" in refusal(
        path, filling="sodium chloride", cell=1.0
    )
    generator = Imported(LocatedFile("a.obj", path, 1e-3), filling="diamond", cell=1e-6)
    assert generator.size()[0] > 50_000_000


def test_pieces_of_a_vtu_are_put_together(tmp_path):
    position, triangles = blob(1)
    write_vtu(tmp_path / "a.vtu", position, triangles[:30])
    write_vtu(tmp_path / "b.vtu", position, triangles[30:])
    text, other = ((tmp_path / name).read_text() for name in ("a.vtu", "b.vtu"))
    piece = other[other.index("<Piece") : other.index("</Unstr")]
    (tmp_path / "a.vtu").write_text(text.replace("</Unstr", piece + "</Unstr"))
    mesh = imported(tmp_path / "a.vtu")
    assert len(mesh.skin) == len(triangles)
    assert Edges.among(mesh.skin.astype(np.int64)).is_closed


def test_files_of_vtk_itself_are_read(tmp_path):
    vtk = pytest.importorskip("vtkmodules.all")
    position, triangles = blob(2)
    WRITERS["organ.obj"](tmp_path / "a.obj", position, triangles)
    reader = vtk.vtkOBJReader()
    reader.SetFileName(str(tmp_path / "a.obj"))
    reader.Update()
    label = vtk.vtkIntArray()
    label.SetName("label")
    for k in range(len(triangles)):
        label.InsertNextValue(k % 2)
    reader.GetOutput().GetCellData().AddArray(label)
    for version in (42, 51):
        for binary in (0, 1):
            writer = vtk.vtkPolyDataWriter()
            writer.SetFileName(str(tmp_path / "a.vtk"))
            writer.SetInputData(reader.GetOutput())
            writer.SetFileVersion(version)
            writer.SetFileType(1 + binary)
            writer.Write()
            mesh = imported(tmp_path / "a.vtk")
            assert len(mesh.skin) == len(triangles), (version, binary)
            assert {"label 0", "label 1"} <= set(mesh.groups), (version, binary)


@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
@pytest.mark.parametrize("compressor", ["None", "ZLib", "LZMA"])
def test_grids_of_vtk_itself_are_read(mode, compressor, tmp_path):
    vtk = pytest.importorskip("vtkmodules.all")
    position, cells = box_of_tetrahedra(2)
    write_vtk(tmp_path / "a.vtk", position, cells)
    reader = vtk.vtkUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "a.vtk"))
    reader.Update()
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(tmp_path / "a.vtu"))
    writer.SetInputData(reader.GetOutput())
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    for encoded in (0, 1):
        writer.SetEncodeAppendedData(encoded)
        writer.Write()
        mesh = imported(tmp_path / "a.vtu")
        assert len(mesh.position) == 27 and len(mesh.skin) == 48
    for version in (42, 51):
        legacy = vtk.vtkUnstructuredGridWriter()
        legacy.SetFileName(str(tmp_path / "b.vtk"))
        legacy.SetInputData(reader.GetOutput())
        legacy.SetFileVersion(version)
        legacy.SetFileTypeToBinary()
        legacy.Write()
        assert len(imported(tmp_path / "b.vtk").ends) == len(mesh.ends)
