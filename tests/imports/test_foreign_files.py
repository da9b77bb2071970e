"""Mesh files as other programs write them: each stands for a habit of some program."""

import struct
from itertools import product

import numpy as np
import pytest

from tests.imports.organs import box_of_hexahedra, write_feb, write_obj, write_vtk
from tests.imports.test_imported import imported, refusal
from tissuec.geometry.divisions import CrossingError, triangles_of
from tissuec.geometry.edges import Edges, volume
from tissuec.meshes.repair import FACES

CORNERS = 20.0 * np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1),
                           (1, 1, 1), (0, 1, 1)])  # fmt: skip
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
TRIANGLES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])
VERTICES = "".join("v {:g} {:g} {:g}\n".format(*p) for p in CORNERS)
POINTS = "".join("{:g} {:g} {:g}\n".format(*p) for p in CORNERS)
#: A tetrahedron in each corner of the cube, and one between them.
TETRAHEDRA = [(0, 1, 3, 4), (2, 3, 1, 6), (5, 4, 6, 1), (7, 6, 4, 3), (1, 3, 4, 6)]


def is_cube(mesh) -> bool:
    """Return whether a mesh is the cube of 20 mm, with a closed surface that faces outwards."""
    skin = mesh.skin.astype(np.int64)
    return (
        len(mesh.position) == 8
        and len(skin) == 12
        and Edges.among(skin).is_closed
        and abs(volume(mesh.position, skin) - 8e-6) < 1e-15
    )


def solid(head="solid", end="endsolid lump"):
    text = f"{head} lump\n"
    for corners in CORNERS[TRIANGLES]:
        rows = "".join("  vertex {:g} {:g} {:g}\n".format(*p) for p in corners)
        text += f"facet normal 0 0 0\n outer loop\n{rows} endloop\nendfacet\n"
    return f"{text}{end}\n"


def ply(face: str, rows: bytes, form="ascii") -> bytes:
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = (
        f"ply\nformat {form} 1.0\nelement vertex 8\n{axes}element face 12\n{face}end_header\n"
    )
    order = {"binary_big_endian": ">f4", "binary_little_endian": "<f4"}.get(form)
    points = CORNERS.astype(order).tobytes() if order else POINTS.encode()
    return head.encode() + points + rows


def rows_of(layout: str, *behind) -> bytes:
    return b"".join(struct.pack(layout, 3, *t, *behind) for t in TRIANGLES.tolist())


INDICES = "property list uchar int vertex_indices\n"
COLOURS = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
COORDINATES = "property list uchar float texcoord\n"
TEXTURED = "".join("3 {} {} {} 6 0 0 1 0 0 1\n".format(*t) for t in TRIANGLES)
GMSH = {
    "begin": "$MeshFormat\n{} 0 8\n$EndMeshFormat\n",
    "nodes": "".join("{} {:g} {:g} {:g}\n".format(k, *p) for k, p in enumerate(CORNERS, 1)),
    "cells": "".join(
        "{} 4 2 1 1 {} {} {} {}\n".format(k, *(n + 1 for n in t))
        for k, t in enumerate(TETRAHEDRA, 1)
    ),
}
PARAMETRIC = (
    GMSH["nodes"].replace("0 0 0\n", "0 0 0 1 4 0.25\n").replace("20 20\n", "20 20 0 3\n")
)
FILES = {
    "end.stl": solid(end="end solid lump"),
    "upper.stl": solid().upper(),
    "crlf.stl": solid().replace("\n", "\r\n").replace("  ", "\t"),
    "mac.stl": solid().replace("\n", "\r"),
    "apart.stl": solid().replace("endfacet", "end facet"),
    "continued.obj": VERTICES
    + "".join(f"f {a + 1} {b + 1} \\\n {c + 1} {d + 1}\n" for a, b, c, d in SIDES),
    "windows.obj": VERTICES.replace("\n", "\r\n")
    + "".join(f"f {a + 1} {b + 1} \\\r\n {c + 1} {d + 1}\r\n" for a, b, c, d in SIDES),
    "colours.ply": ply(INDICES + COLOURS, rows_of("<B3i3B", 9, 8, 7), "binary_little_endian"),
    "big.ply": ply(INDICES + COLOURS, rows_of(">B3i3B", 9, 8, 7), "binary_big_endian"),
    "before.ply": ply(
        "property int flag\n" + INDICES,
        b"".join(struct.pack("<iB3i", k % 2, 3, *t) for k, t in enumerate(TRIANGLES.tolist())),
        "binary_little_endian",
    ),
    "texture.ply": ply(INDICES + COORDINATES, TEXTURED.encode()),
    "texture_binary.ply": ply(
        INDICES + COORDINATES,
        rows_of("<B3iB6f", 6, 0, 0, 1, 0, 0, 1),
        "binary_little_endian",
    ),
    "parametric.msh": GMSH["begin"].format("2.2")
    + f"$ParametricNodes\n8\n{PARAMETRIC}$EndParametricNodes\n"
    + f"$Elements\n5\n{GMSH['cells']}$EndElements\n",
    "comments.msh": "$Comments\nby hand\n$EndComments\n"
    + GMSH["begin"].format("2")
    + f"$Nodes\n8\n{GMSH['nodes']}$EndNodes\n$Elements\n5\n{GMSH['cells']}$EndElements\n",
    "colour.off": f"COFF\n8 12 0\n# vertices\n{POINTS.replace(chr(10), ' 9 9 9 255' + chr(10))}"
    + "".join("3 {} {} {}\n".format(*t) for t in TRIANGLES),
    "one_line.off": f"OFF 8 6 12\n{POINTS}"
    + "".join("4 {} {} {} {}\n".format(*q) for q in SIDES),
}


@pytest.mark.parametrize("name", FILES)
def test_a_cube_as_another_program_writes_it(name, tmp_path):
    content = FILES[name]
    data = content if isinstance(content, bytes) else content.encode()
    (tmp_path / name).write_bytes(data)
    mesh = imported(tmp_path / name)
    assert is_cube(mesh)
    assert not mesh.remarks
    if name == "before.ply":
        assert sorted(mesh.groups) == ["flag 0", "flag 1"]


def test_a_solid_without_its_end_is_read_with_a_remark(tmp_path):
    (tmp_path / "a.stl").write_text(solid(end=""))
    mesh = imported(tmp_path / "a.stl")
    assert is_cube(mesh)
    assert mesh.remarks == ('the file does not end with "endsolid"; part of it may be missing',)


def test_little_endian_vtk_is_recognised(tmp_path):
    for name in ("right", "wrong"):
        write_vtk(tmp_path / f"{name}.vtk", CORNERS, TRIANGLES, binary=True)
    data = (tmp_path / "wrong.vtk").read_bytes()
    points = CORNERS.astype(">f8").tobytes()
    faces = np.column_stack([np.full(12, 3), TRIANGLES]).astype(">i4").tobytes()
    for block, kind in ((points, "f8"), (faces, "i4")):
        data = data.replace(
            block, np.frombuffer(block, f">{kind}").astype(f"<{kind}").tobytes()
        )
    (tmp_path / "wrong.vtk").write_bytes(data)
    assert is_cube(imported(tmp_path / "right.vtk"))
    mesh = imported(tmp_path / "wrong.vtk")
    assert is_cube(mesh)
    assert mesh.remarks == (
        "its numbers have their lowest byte first, which legacy VTK files should not",
    )


def test_refusals_name_what_is_wrong(tmp_path):
    grid = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    cases = {
        "huge.obj": (
            f"{VERTICES}f 1 2 9223372036854775808\n",
            "line 9 uses vertex 92233720368",
        ),
        "far.obj": (
            f"{VERTICES}f 1 2 -9\n",
            "line 9 uses vertex -9, but there are 8 before it",
        ),
        "two.obj": (f"{VERTICES}f 1 2\n", "line 9: a face needs three corners or more"),
        "comma.obj": (
            VERTICES.replace("20", "20,0"),
            'line 2 cannot be read: "v 20,0 0 0" | write decimals with a point',
        ),
        "huge.vtk": (
            f"{grid}POINTS 8 float\n{POINTS}CELLS 1 5\n4 0 1 2 1e30\nCELL_TYPES 1\n10\n",
            "1e+30 is not the number of a node or cell",
        ),
        "poly.vtk": (
            f"{grid}POINTS 8 float\n{POINTS}CELLS 1 6\n5 1 3 0 1 2\nCELL_TYPES 1\n42\n",
            "1 cell of type 42 (polyhedron), which is not supported | divide such cells",
        ),
        "new.msh": (GMSH["begin"].format("5.0"), "version 5 of the format is not supported"),
        "lost.msh": (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + f"$Nodes\n8\n{GMSH['nodes']}$EndNodes\n"
            "$Elements\n1\n1 4 2 1 1 1 2 3 9\n$EndElements",
            "element 1 uses node 9, which does not exist",
        ),
        "short.ply": (ply(INDICES, b"3 0 1 2\n"), "in its face elements: it is truncated"),
        "bow.obj": (
            "v 0 0 0\nv 9 9 0\nv 9 0 0\nv 5 0 0\nv 0 9 0\nf 1 2 3 4 5\n",
            "a face of 5 corners around (4.6 mm, 3.6 mm, 0 m) crosses itself",
        ),
        "two.off": (
            "OFF\n8 12 0\n0 0 0\n",
            "it is truncated: 19 lines of vertices or faces are",
        ),
    }
    for name, (content, expected) in cases.items():
        data = content if isinstance(content, bytes) else content.encode()
        (tmp_path / name).write_bytes(data)
        assert f'"{name}": {expected}' in refusal(tmp_path / name)


def test_beams_beside_a_solid_are_left_out_with_a_remark(tmp_path):
    write_feb(tmp_path / "a.feb", CORNERS, np.arange(8)[None], version="4.0")
    text = (tmp_path / "a.feb").read_text()
    beam = '<Elements type="line2" name="fibre"><elem id="99">10,22</elem></Elements>'
    (tmp_path / "a.feb").write_text(text.replace("</Elements>", f"</Elements>{beam}"))
    mesh = imported(tmp_path / "a.feb")
    assert is_cube(mesh)
    assert mesh.remarks == ("1 beam left out",)


def test_only_some_entities_of_gmsh_have_groups(tmp_path):
    entities = (
        "$Entities\n0 0 1 1\n1 0 0 0 20 20 20 1 5 0\n1 0 0 0 20 20 20 0 0\n$EndEntities\n"
    )
    tags = "\n".join(map(str, range(1, 9)))
    cells = "".join(
        f"{k} {' '.join(str(n + 1) for n in t)}\n" for k, t in enumerate(TETRAHEDRA, 3)
    )
    (tmp_path / "a.msh").write_text(
        GMSH["begin"].format("4.1")
        + f'$PhysicalNames\n1\n2 5 "lid"\n$EndPhysicalNames\n{entities}'
        + f"$Nodes\n1 8 1 8\n3 1 0 8\n{tags}\n{POINTS}$EndNodes\n"
        + f"$Elements\n2 7 1 7\n2 1 2 2\n1 5 6 7\n2 5 7 8\n3 1 4 5\n{cells}$EndElements\n"
    )
    mesh = imported(tmp_path / "a.msh")
    assert is_cube(mesh)
    assert mesh.groups["lid"].tolist() == [4, 5, 6, 7]


# --- parts and merging ------------------------------------------------------------------------


def two_blocks(path):
    """Write two hexahedra in contact, as FEBio does: with nodes of their own."""
    upper = CORNERS + np.array((0, 0, 20))
    position = np.concatenate([CORNERS, upper])
    write_feb(path, position, np.arange(16).reshape(2, 8), "upper", version="4.0")


def test_a_part_of_a_file_can_be_the_body(tmp_path):
    two_blocks(tmp_path / "a.feb")
    whole = imported(tmp_path / "a.feb")
    assert len(whole.position) == 12
    assert "4 nodes merged" in whole.remarks[0]
    part = imported(tmp_path / "a.feb", part="upper")
    assert len(part.position) == 8
    assert part.position[:, 2].min() == 0.02
    assert not part.remarks
    assert 'is not a part of it | did you mean "upper"?' in refusal(
        tmp_path / "a.feb", part="uper"
    )
    assert "is a set of nodes, which has no cells" in refusal(tmp_path / "a.feb", part="Object")


def test_a_part_has_its_own_cells_even_between_nodes_of_another(tmp_path):
    """All corners of the middle triangles belong to the outer part as well."""
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv -1 0 0\nv -1 1 0\n"
        "g outer\nf 7 1 4 8\nf 2 5 6 3\ng middle\nf 1 2 3 4\n"
    )
    assert len(imported(tmp_path / "a.obj", part="outer").skin) == 4
    assert len(imported(tmp_path / "a.obj", part="middle").skin) == 2


@pytest.mark.parametrize("entries", [{"merging": "off"}, {"merging_distance": 0.0}])
def test_parts_in_contact_stay_apart_without_merging(entries, tmp_path):
    two_blocks(tmp_path / "a.feb")
    mesh = imported(tmp_path / "a.feb", **entries)
    assert len(mesh.position) == 16
    assert not mesh.remarks
    across = (mesh.ends[:, 0] < 8) != (mesh.ends[:, 1] < 8)
    assert not across.any()


def test_lumps_that_share_a_face_are_named_with_the_place(tmp_path):
    upper = TRIANGLES + 8
    position = np.concatenate([CORNERS, CORNERS + np.array((20, 0, 0))])
    write_obj(tmp_path / "a.obj", position, np.concatenate([TRIANGLES, upper]), "right")
    said = refusal(tmp_path / "a.obj", filling="sodium chloride", cell=0.005)
    assert (
        "4 edges of more than two triangles, the first of them between (20 mm, 0 m, 0 m)"
        in said
    )
    assert 'merging is off; or import each part alone: part "rest"' in said
    right = imported(tmp_path / "a.obj", part="right", filling="sodium chloride", cell=0.005)
    assert len(right.position) > 8


# --- division ---------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", range(5))
def test_a_concave_face_is_divided_within_itself(turn):
    """A pentagon with one corner pushed in, begun at each of its corners."""
    corners = np.array([(0, 0), (20, 0), (20, 20), (10, 4), (0, 20)], float)
    flat = np.roll(corners, turn, axis=0)
    position = np.column_stack([flat, 3.0 * flat[:, 0]])
    triangles = triangles_of(position, np.arange(5)[None])
    a, b, c = flat[triangles].swapaxes(0, 1)
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(240.0)


def test_random_polygons_are_divided_without_overlap():
    """Star-shaped polygons: all triangles face the same way and add up to the area."""
    random = np.random.default_rng(5)
    for _ in range(100):
        count = int(random.integers(5, 40))
        angle = np.sort(random.uniform(0, 2 * np.pi, count))
        if np.diff(angle, append=angle[0] + 2 * np.pi).max() > 3.0:
            continue
        radius = random.uniform(0.2, 1.0, count)
        flat = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        flat = np.roll(flat, int(random.integers(count)), axis=0)
        triangles = triangles_of(
            np.column_stack([flat, np.zeros(count)]), np.arange(count)[None]
        )
        a, b, c = flat[triangles].swapaxes(0, 1)
        areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        x, y = flat.T
        whole = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        assert areas.min() > -1e-9
        assert areas.sum() == pytest.approx(whole, rel=1e-9)


def test_a_face_that_crosses_itself_is_refused():
    bow = np.array([(0, 0, 0), (2, 2, 0), (2, 0, 0), (1, 0, 0), (0, 2, 0)], float)
    with pytest.raises(CrossingError):
        triangles_of(bow, np.arange(5)[None])


@pytest.mark.parametrize("kind", FACES)
def test_cells_divide_alike_whatever_their_numbers(kind, tmp_path):
    """Under every numbering tried, the tetrahedra fill the cell, and none is inside out."""
    shapes = {
        "hexahedron": CORNERS,
        "wedge": CORNERS[[0, 1, 3, 4, 5, 7]],
        "pyramid": np.vstack([CORNERS[:4], [(10, 10, 20)]]),
    }
    contents = {"hexahedron": 8e-6, "wedge": 4e-6, "pyramid": 8e-6 / 3}
    number = {"hexahedron": 12, "wedge": 13, "pyramid": 14}[kind]
    corners, random = shapes[kind], np.random.default_rng(2)
    for _ in range(30):
        order = random.permutation(len(corners))
        place = np.empty_like(corners)
        place[order] = corners
        rows = "".join("{:g} {:g} {:g}\n".format(*p) for p in place)
        (tmp_path / "a.vtk").write_text(
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            f"POINTS {len(place)} float\n{rows}CELLS 1 {len(place) + 1}\n{len(place)} "
            f"{' '.join(map(str, order))}\nCELL_TYPES 1\n{number}\n"
        )
        mesh = imported(tmp_path / "a.vtk")
        assert not mesh.remarks
        a, b, c, d = mesh.position[mesh.tetrahedra].swapaxes(0, 1)
        content = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / 6
        assert content.sum() == pytest.approx(contents[kind], rel=1e-12)
        skin = mesh.skin.astype(np.int64)
        assert Edges.among(skin).is_closed
        assert volume(mesh.position, skin) == pytest.approx(contents[kind], rel=1e-12)


def test_a_grid_of_hexahedra_is_the_lattice_of_its_nodes(tmp_path):
    """Edges and both diagonals of all faces: sodium chloride with second neighbours."""
    position, cells = box_of_hexahedra(3)
    order = np.random.default_rng(3).permutation(len(position))
    shuffled = np.empty_like(position)
    shuffled[order] = position
    write_vtk(tmp_path / "box.vtk", shuffled, order[cells])
    mesh = imported(tmp_path / "box.vtk")
    apart = np.linalg.norm(np.subtract(*mesh.position[mesh.ends.T]), axis=1)
    near = {
        (i, j)
        for i, j in product(range(64), range(64))
        if i < j and np.linalg.norm(mesh.position[i] - mesh.position[j]) < 0.0142
    }
    assert set(map(tuple, mesh.ends.tolist())) == near
    assert apart.max() < 0.0142
    assert mesh.volume.sum() == pytest.approx(27e-6, rel=1e-12)
    assert not mesh.remarks


def test_a_hexahedron_with_corners_in_one_node_is_a_wedge(tmp_path):
    cell = np.array([[0, 1, 2, 2, 4, 5, 6, 6]])
    write_vtk(tmp_path / "a.vtk", CORNERS, cell)
    mesh = imported(tmp_path / "a.vtk")
    skin = mesh.skin.astype(np.int64)
    assert Edges.among(skin).is_closed
    assert volume(mesh.position, skin) == pytest.approx(4e-6, rel=1e-12)


def test_a_twisted_hexahedron_is_reported(tmp_path):
    position = CORNERS.copy()
    position[6] = (-30, -30, -30)
    write_vtk(tmp_path / "a.vtk", position, np.arange(8)[None])
    assert "1 hexahedron so distorted that parts of them are inside out" in str(
        imported(tmp_path / "a.vtk").remarks
    )


def test_a_concave_quad_is_cut_through_its_inner_corner(tmp_path):
    (tmp_path / "dart.obj").write_text("v 0 0 0\nv 10 3 0\nv 0 6 0\nv 3 3 0\nf 1 2 3 4\n")
    mesh = imported(tmp_path / "dart.obj")
    assert [1, 3] in mesh.ends.tolist() and [0, 2] not in mesh.ends.tolist()


def test_triangles_without_area_are_dropped_where_they_hang_loose(tmp_path):
    faces = "".join("f {} {} {}\n".format(*(t + 1)) for t in TRIANGLES)
    (tmp_path / "loose.obj").write_text(f"{VERTICES}v 10 0 0\n{faces}f 1 2 9\n")
    mesh = imported(tmp_path / "loose.obj")
    assert is_cube(mesh)
    assert mesh.remarks == ("1 triangle without area removed",)
    # On one side the edge has a node in its middle: the triangle closes the gap, and stays.
    split = faces.replace("f 1 2 6\n", "f 1 9 6\nf 9 2 6\n") + "f 1 2 9\n"
    (tmp_path / "gap.obj").write_text(f"{VERTICES}v 10 0 0\n{split}")
    mesh = imported(tmp_path / "gap.obj")
    skin = mesh.skin.astype(np.int64)
    assert Edges.among(skin).is_closed and len(skin) == 14
    assert volume(mesh.position, skin) == pytest.approx(8e-6, rel=1e-12)


def test_holes_are_named_with_their_place(tmp_path):
    write_obj(tmp_path / "a.obj", CORNERS, TRIANGLES[:-1])
    said = refusal(tmp_path / "a.obj", filling="sodium chloride", cell=0.005)
    assert "3 edges of one triangle, at a hole around (0 m, 13.3 mm, 13.3 mm)" in said
