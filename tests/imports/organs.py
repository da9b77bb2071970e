"""Organs for the tests of mesh files, and writers of every format, by code of their own."""

import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tissuec.meshes.generators.sphere import divide, icosahedron


def blob(subdivisions: int):
    """Return a closed surface like a liver, in millimetres: nodes and outward triangles."""
    unit, triangles = icosahedron()
    for _ in range(subdivisions):
        unit, triangles = divide(unit, triangles)
    x, y, z = unit.T
    left = 1.0 / (1.0 + np.exp(-4.0 * (x - 0.1)))  # the left lobe is thin
    thick = 1.0 - 0.55 * left
    lower = np.where(z < 0.0, 0.8 - 0.25 * np.exp(-8.0 * ((x - 0.2) ** 2 + y**2)), 1.0)
    position = np.stack([100 * x, 60 * y * (1 - 0.3 * left), 45 * z * thick * lower], axis=1)
    return position + np.array([7.0, -3.0, 110.0]), triangles


def box_of_tetrahedra(cells: int = 2):
    """Return a box of 10 mm cells, each divided in six tetrahedra round its diagonal."""
    side = cells + 1
    grid = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    found = []
    for one in range(3):
        for two in range(3):
            if one != two:
                path = [(0, 0, 0), tuple(corners[1 + one]), None, (1, 1, 1)]
                path[2] = tuple(np.add(path[1], corners[1 + two]))
                found.append(path)
    low = grid[(grid < cells).all(axis=1)]
    nodes = (low[:, None, None] + np.array(found)[None]) @ (side * side, side, 1)
    return 10.0 * grid, nodes.reshape(-1, 4)


def box_of_hexahedra(cells: int = 2):
    """Return a box of 10 mm cells, in VTK's order of corners."""
    places = np.meshgrid(*[np.arange(cells + 1)] * 3, indexing="ij")
    return grid_of_hexahedra(10.0 * np.stack(places, axis=-1))


def grid_of_hexahedra(place: Any):
    """Return nodes and cells between places of shape (column, row, layer, 3)."""
    number = np.arange(place[..., 0].size).reshape(place.shape[:3])
    low = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    cells = np.stack([*(n[..., :-1] for n in low), *(n[..., 1:] for n in low)], axis=-1)
    return place.reshape(-1, 3), cells.reshape(-1, 8)


NAMES = {
    3: ("triangle", 5, 2, "tri3"),
    4: ("tetra", 10, 4, "tet4"),
    6: ("wedge", 13, 6, "penta6"),
    8: ("hexahedron", 12, 5, "hex8"),
}


def write_obj(path: Path, position, cells, group=""):
    with path.open("w") as file:
        file.writelines("v {!r} {!r} {!r}\n".format(*p) for p in position.tolist())
        for name, rows in named(cells, group):
            file.write(f"g {name}\n" if name else "")
            file.writelines(
                "f {}\n".format(" ".join(map(str, row))) for row in (rows + 1).tolist()
            )


def named(cells, group):
    """Return the second half of the cells under a name, if there is one."""
    half = len(cells) // 2
    return [("rest", cells[:half]), (group, cells[half:])] if group else [("", cells)]


def write_stl(path: Path, position, cells):
    facets = np.zeros(len(cells), dtype=[("n", "<f4", 3), ("p", "<f4", (3, 3)), ("a", "<u2")])
    facets["p"] = position[cells]
    path.write_bytes(
        b"solid-looking remark".ljust(80) + struct.pack("<I", len(cells)) + facets.tobytes()
    )


def write_stl_text(path: Path, position, cells):
    lines = ["solid blob"]
    for corners in position[cells].tolist():
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {:.9g} {:.9g} {:.9g}".format(*p) for p in corners]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid blob", ""]))


def write_ply(path: Path, position, cells, *, binary=False):
    kind = "binary_little_endian" if binary else "ascii"
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {len(position)}\nproperty double x\n"
        f"property double y\nproperty double z\nelement face {len(cells)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    if binary:
        faces = np.zeros(len(cells), dtype=[("n", "u1"), ("v", "<i4", 3)])
        faces["n"], faces["v"] = 3, cells
        path.write_bytes(head.encode() + position.astype("<f8").tobytes() + faces.tobytes())
    else:
        points = "".join("{!r} {!r} {!r}\n".format(*p) for p in position.tolist())
        path.write_text(
            head + points + "".join("3 {} {} {}\n".format(*c) for c in cells.tolist())
        )


def write_vtk(
    path: Path, position: Any, cells: Any, *, binary=False, version="3.0", parts: Any = None
):
    """Write POLYDATA for triangles, else an UNSTRUCTURED_GRID; ``parts`` number the cells."""

    def block(values, kind):
        values = np.asarray(values)
        if binary:
            return values.astype(f">{kind}").tobytes() + b"\n"
        return (" ".join(map(repr, values.ravel().tolist())) + "\n").encode()

    corners = cells.shape[1]
    flat = corners == 3
    word = "POLYGONS" if flat else "CELLS"
    out = f"# vtk DataFile Version {version}\nblob\n{'BINARY' if binary else 'ASCII'}\n"
    out = (out + f"DATASET {'POLYDATA' if flat else 'UNSTRUCTURED_GRID'}\n").encode()
    out += f"POINTS {len(position)} double\n".encode() + block(position, "f8")
    if version.startswith("5"):
        out += f"{word} {len(cells) + 1} {cells.size}\nOFFSETS vtktypeint64\n".encode()
        out += block(np.arange(len(cells) + 1) * corners, "i8")
        out += b"CONNECTIVITY vtktypeint64\n" + block(cells, "i8")
    else:
        rows = np.column_stack([np.full(len(cells), corners), cells])
        out += f"{word} {len(cells)} {rows.size}\n".encode() + block(rows, "i4")
    if not flat:
        out += f"CELL_TYPES {len(cells)}\n".encode()
        out += block(np.full(len(cells), NAMES[corners][1]), "i4")
    if parts is not None:
        out += f"CELL_DATA {len(cells)}\nSCALARS label int 1\nLOOKUP_TABLE default\n".encode()
        out += block(parts, "i4")
    path.write_bytes(out)


def write_vtu(path: Path, position, cells, parts=None):
    corners = cells.shape[1]

    def array(name, kind, values, width=""):
        text = " ".join(map(repr, np.asarray(values).ravel().tolist()))
        return (
            f'<DataArray type="{kind}" Name="{name}" {width} format="ascii">{text}</DataArray>'
        )

    data = "" if parts is None else array("label", "Int32", parts)
    path.write_text(
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" '
        f'byte_order="LittleEndian"><UnstructuredGrid><Piece NumberOfPoints="{len(position)}" '
        f'NumberOfCells="{len(cells)}"><Points>'
        + array("Points", "Float64", position, 'NumberOfComponents="3"')
        + "</Points><Cells>"
        + array("connectivity", "Int64", cells)
        + array("offsets", "Int64", corners * np.arange(1, len(cells) + 1))
        + array("types", "UInt8", np.full(len(cells), NAMES[corners][1]))
        + f"</Cells><CellData>{data}</CellData></Piece></UnstructuredGrid></VTKFile>"
    )


def write_vtkhdf(path: Path, position, cells):
    """Write VTKHDF without steps."""
    with h5py.File(path, "w") as file:
        group = file.create_group("VTKHDF")
        group.attrs["Type"] = np.bytes_("UnstructuredGrid")
        group["NumberOfPoints"], group["NumberOfCells"] = [len(position)], [len(cells)]
        group["NumberOfConnectivityIds"] = [cells.size]
        group["Points"], group["Connectivity"] = position, cells.ravel()
        group["Offsets"] = cells.shape[1] * np.arange(len(cells) + 1)
        group["Types"] = np.full(len(cells), NAMES[cells.shape[1]][1], dtype="u1")


def write_msh(path: Path, position, cells, group=""):
    """Write Gmsh's format 2.2; the second half of the cells is a physical group."""
    kind = NAMES[cells.shape[1]][2]
    dimension = 2 if cells.shape[1] == 3 else 3
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if group:
        lines += ["$PhysicalNames", "1", f'{dimension} 2 "{group}"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(position))]
    lines += ["{} {!r} {!r} {!r}".format(k, *p) for k, p in enumerate(position.tolist(), 1)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    for k, row in enumerate((cells + 1).tolist()):
        tag = 2 if group and k >= len(cells) // 2 else 1
        lines.append(f"{k + 1} {kind} 2 {tag} {tag} " + " ".join(map(str, row)))
    path.write_text("\n".join([*lines, "$EndElements", ""]))


def write_feb(path: Path, position, cells, group="", version="2.5"):
    """Write FEBio's XML with node and element numbers that have gaps."""
    kind = NAMES[cells.shape[1]][3]
    node = "".join(
        '<node id="{}">{!r},{!r},{!r}</node>'.format(10 + 2 * k, *p)
        for k, p in enumerate(position.tolist())
    )
    element = "".join(
        f'<elem id="{5 + 3 * k}">{",".join(str(10 + 2 * n) for n in row)}</elem>'
        for k, row in enumerate(cells.tolist())
    )
    ids = [5 + 3 * k for k in range(len(cells) // 2, len(cells))]
    if version == "2.5":
        inside, tag = "".join(f'<elem id="{i}"/>' for i in ids), "Geometry"
    else:
        inside, tag = ",".join(map(str, ids)), "Mesh"
    members = f'<ElementSet name="{group}">{inside}</ElementSet>' if group else ""
    path.write_text(
        f'<?xml version="1.0" encoding="ISO-8859-1"?><febio_spec version="{version}"><{tag}>'
        f'<Nodes name="Object">{node}</Nodes><Elements type="{kind}" name="Part">{element}'
        f"</Elements>{members}</{tag}></febio_spec>"
    )


def write_vtp(path: Path, position, cells, parts=None):
    write_vtu(path, position, cells, parts)
    text = path.read_text()
    types = text[text.index('<DataArray type="UInt8"') : text.index("</Cells>")]
    text = text.replace(types, "").replace("UnstructuredGrid", "PolyData")
    path.write_text(text.replace("Cells>", "Polys>").replace("NumberOfCells", "NumberOfPolys"))


def write_off(path: Path, position, cells):
    lines = ["OFF # blob", f"{len(position)} {len(cells)} 0"]
    lines += ["{!r} {!r} {!r}".format(*p) for p in position.tolist()]
    lines += [f"{len(row)} {' '.join(map(str, row))} 200 10 10" for row in cells.tolist()]
    path.write_text("\n".join([*lines, ""]))


def write_mesh(path: Path, position, cells, group=""):
    """Write Medit's format; the second half of the cells has the reference 2."""
    word = {3: "Triangles", 4: "Tetrahedra", 8: "Hexahedra"}[cells.shape[1]]
    lines = ["MeshVersionFormatted 2", "Dimension", "3", "Vertices", str(len(position))]
    lines += ["{!r} {!r} {!r} 0".format(*p) for p in position.tolist()]
    lines += ["Corners 2", "1 2", f"{word} {len(cells)}"]
    for k, row in enumerate((cells + 1).tolist()):
        lines.append(" ".join(map(str, row)) + (" 2" if 2 * k >= len(cells) else " 1"))
    path.write_text("\n".join([*lines, "End", ""]))


def write_inp(path: Path, position, cells, group=""):
    kind = {3: "S3", 4: "C3D4", 8: "C3D8R"}[cells.shape[1]]
    lines = ["*HEADING", "blob", "*NODE"]
    lines += ["{}, {!r}, {!r}, {!r}".format(k, *p) for k, p in enumerate(position.tolist(), 1)]
    lines.append(f"*ELEMENT, TYPE={kind}, ELSET=all")
    rows = enumerate((cells + 1).tolist(), 1)
    lines += [f"{k}, " + ", ".join(map(str, row)) for k, row in rows]
    if group:
        lines += [f"*ELSET, ELSET={group}, GENERATE", f"{len(cells) // 2 + 1}, {len(cells)}, 1"]
    path.write_text("\n".join([*lines, ""]))


def write_msh_1(path: Path, position, cells):
    kind = NAMES[cells.shape[1]][2]
    lines = ["$NOD", str(len(position))]
    lines += ["{} {!r} {!r} {!r}".format(k, *p) for k, p in enumerate(position.tolist(), 1)]
    lines += ["$ENDNOD", "$ELM", str(len(cells))]
    for k, row in enumerate((cells + 1).tolist(), 1):
        lines.append(f"{k} {kind} 1 1 {len(row)} " + " ".join(map(str, row)))
    path.write_text("\n".join([*lines, "$ENDELM", ""]))


def write_msh_4(path: Path, position, cells, group="", *, binary=False):
    """Write Gmsh's format 4.1; the second half of the cells is an entity with a group."""
    kind, dimension = NAMES[cells.shape[1]][2], 2 if cells.shape[1] == 3 else 3
    out = f"$MeshFormat\n4.1 {int(binary)} 8\n".encode()
    out += (struct.pack("<i", 1) + b"\n" if binary else b"") + b"$EndMeshFormat\n"

    def numbers(**kinds):
        """Return rows of numbers, each under the letter of its type."""
        found = b""
        for letters, values in kinds.values():
            if binary:
                found += np.asarray(values).astype(f"<{letters}").tobytes()
            else:
                found += (
                    " ".join(map(repr, np.asarray(values).ravel().tolist())) + "\n"
                ).encode()
        return found

    def entity(tag, groups):
        box = [0.0] * 6
        head = numbers(a=("i4", [tag]), b=("f8", box), c=("u8", [len(groups)]))
        return head + numbers(a=("i4", groups), b=("u8", [0]))

    if group:
        out += f'$PhysicalNames\n1\n{dimension} 7 "{group}"\n$EndPhysicalNames\n'.encode()
    counts = [0, 0, 2, 0] if dimension == 2 else [0, 0, 0, 2]
    out += b"$Entities\n" + numbers(a=("u8", counts))
    out += entity(1, []) + entity(2, [7] if group else []) + b"$EndEntities\n"
    count, many, half = len(position), len(cells), len(cells) // 2
    out += b"$Nodes\n" + numbers(
        a=("u8", [1, count, 1, count]), b=("i4", [dimension, 1, 0]), c=("u8", [count]),
        d=("u8", np.arange(1, count + 1)), e=("f8", position),
    ) + b"$EndNodes\n$Elements\n" + numbers(a=("u8", [2, many, 1, many]))  # fmt: skip
    for tag, rows in ((1, np.arange(half)), (2, np.arange(half, many))):
        table = np.column_stack([rows + 1, cells[rows] + 1])
        out += numbers(a=("i4", [dimension, tag, kind]), b=("u8", [len(rows)]), c=("u8", table))
    path.write_bytes(out + b"$EndElements\n")


def write_msh_binary(path: Path, position, cells):
    """Write Gmsh's format 2.2 in binary."""
    nodes = np.zeros(len(position), dtype=[("tag", "<i4"), ("place", "<f8", 3)])
    nodes["tag"], nodes["place"] = np.arange(1, len(position) + 1), position
    rows = np.column_stack([np.arange(1, len(cells) + 1), np.ones((len(cells), 2)), cells + 1])
    head = np.array([NAMES[cells.shape[1]][2], len(cells), 2], dtype="<i4")
    path.write_bytes(
        b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n"
        + f"$Nodes\n{len(nodes)}\n".encode() + nodes.tobytes() + b"\n$EndNodes\n"
        + f"$Elements\n{len(cells)}\n".encode() + head.tobytes()
        + rows.astype("<i4").tobytes() + b"\n$EndElements\n"
    )  # fmt: skip


WRITERS = {
    "organ.obj": write_obj,
    "organ.stl": write_stl,
    "text.stl": write_stl_text,
    "organ.ply": write_ply,
    "binary.ply": lambda *a: write_ply(*a, binary=True),
    "organ.vtk": write_vtk,
    "binary.vtk": lambda *a: write_vtk(*a, binary=True),
    "new.vtk": lambda *a: write_vtk(*a, version="5.1"),
    "newbinary.vtk": lambda *a: write_vtk(*a, version="5.1", binary=True),
    "organ.vtu": write_vtu,
    "organ.vtp": write_vtp,
    "organ.vtkhdf": write_vtkhdf,
    "organ.off": write_off,
    "organ.mesh": write_mesh,
    "organ.inp": write_inp,
    "organ.msh": write_msh,
    "binary.msh": write_msh_binary,
    "one.msh": write_msh_1,
    "new.msh": write_msh_4,
    "newbinary.msh": lambda *a: write_msh_4(*a, binary=True),
    "organ.feb": write_feb,
    "new.feb": lambda *a: write_feb(*a, version="4.0"),
}
