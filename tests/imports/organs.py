"""Organs for the tests of mesh files, and writers of every format, by code of their own."""

import struct
from pathlib import Path

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
    side = cells + 1
    grid = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    low = grid[(grid < cells).all(axis=1)]
    flat = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    corner = np.concatenate([flat, flat + np.array([0, 0, 1])])
    return 10.0 * grid, (low[:, None] + corner) @ (side * side, side, 1)


NAMES = {
    3: ("triangle", 5, 2, "tri3"),
    4: ("tetra", 10, 4, "tet4"),
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


def write_vtk(path: Path, position, cells, *, binary=False, version="3.0", parts=None):
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
    "organ.msh": write_msh,
    "organ.feb": write_feb,
    "new.feb": lambda *a: write_feb(*a, version="4.0"),
}
