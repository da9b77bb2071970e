"""Points and cells of one moment, written for other programs."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.files import write_file
from tissuec.results import ResultError
from tissuec.results.element_cells import LINE, VERTEX
from tissuec.results.fields import Place
from tissuec.results.mesh import CellGrid, DrawnMesh

_VTK_TYPES = {"float32": "Float32", "float64": "Float64", "int64": "Int64", "uint8": "UInt8"}


class ExportedShape(Struct, frozen=True, eq=False):
    """The drawn shape at one moment.

    Attributes:
        title: Where it comes from.
        time: [s].
        points: Positions [m], shape (point, 3).
        grid: What VTK shows of it.
        triangles: Its skin, also that of solid elements, shape (triangle, 3).
        point_data, cell_data: Numbers at points and at the cells of the grid by name.
    """

    title: str
    time: float
    points: NDArray[Any]
    grid: CellGrid
    triangles: NDArray[np.integer]
    point_data: Mapping[str, NDArray[Any]]
    cell_data: Mapping[str, NDArray[Any]]


def net_shape(
    title: str,
    time: float,
    drawing: DrawnMesh,
    points: Mapping[str, NDArray[Any]],
    own: Mapping[str, tuple[Place, NDArray[Any]]],
) -> ExportedShape:
    """Return a net as a shape.

    Args:
        title: Where it comes from.
        time: [s].
        drawing: What is drawn.
        points: "position" [m], shape (node, 3), and what else there is at the nodes.
        own: What has numbers, and these, of all that the mesh has; 0 at other cells.
    """
    grid = drawing.grid
    numbers = {name: grid.over(at, values) for name, (at, values) in own.items()}
    others = {name: values for name, values in points.items() if name != "position"}
    return ExportedShape(
        title, time, points["position"], grid, drawing.cells.triangles, others,
        {**numbers, **drawing.labels},
    )  # fmt: skip


def write_vtu(
    shape: ExportedShape, path: Path, texts: Mapping[str, Sequence[str]] | None = None
) -> None:
    """Write a VTK unstructured grid (XML); ResultError if the file cannot be written.

    Args:
        shape: What is written.
        path: The file.
        texts: Texts that belong to all of it, by name.
    """
    grid, texts = shape.grid, texts or {}
    topology = {
        "connectivity": grid.points.astype(np.int64),
        "offsets": grid.ends[1:],
        "types": grid.types,
    }
    time = _data_array("TimeValue", np.array([shape.time]), tuples=True)
    body = [
        f"<FieldData>\n{time}{''.join(map(_text_array, texts, texts.values()))}</FieldData>\n",
        f'<Piece NumberOfPoints="{len(shape.points)}" NumberOfCells="{len(grid)}">\n',
        _section("Points", {"position": shape.points}),
        _section("Cells", topology),
        _section("PointData", shape.point_data),
        _section("CellData", shape.cell_data),
        "</Piece>\n",
    ]
    write_xml(path, "UnstructuredGrid", "".join(body))


def write_xml(path: Path, kind: str, body: str) -> None:
    """Write a file of VTK's XML formats; ResultError if it cannot be written.

    Args:
        path: The file.
        kind: Type of the data, which is also the name of the outer element.
        body: Content of that element.
    """
    head = f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian"'
    text = f'{head} header_type="UInt64">\n<{kind}>\n{body}</{kind}>\n</VTKFile>\n'
    _write(path, text.encode())


def write_obj(shape: ExportedShape, path: Path) -> None:
    """Write Wavefront OBJ (text); ResultError if the file cannot be written."""
    vertices, lines_of = shape.grid.of_type(VERTEX, 1), shape.grid.of_type(LINE, 2)
    parts = {"p": vertices, "l": lines_of, "f": shape.triangles}
    lines = [f"# {shape.title}, {float(shape.time)!r} s, in metres\n"]
    lines += [_obj_line("v", row) for row in shape.points.tolist()]
    for letter, table in parts.items():
        lines += [_obj_line(letter, row) for row in (table + 1).tolist()]  # OBJ counts from 1
    _write(path, "".join(lines).encode())


def write_ply(shape: ExportedShape, path: Path) -> None:
    """Write PLY (binary): points, lines as edges; ResultError if that is impossible."""
    number = "float" if shape.points.dtype == np.float32 else "double"
    head = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment {' '.join(shape.title.split())}, {float(shape.time)!r} s, in metres",
        f"element vertex {len(shape.points)}",
        *(f"property {number} {axis}" for axis in "xyz"),
        f"element face {len(shape.triangles)}",
        "property list uchar int vertex_indices",
    ]
    faces = np.zeros(len(shape.triangles), dtype=[("count", "u1"), ("points", "<i4", 3)])
    faces["count"], faces["points"] = 3, shape.triangles
    data = shape.points.astype(shape.points.dtype.newbyteorder("<")).tobytes() + faces.tobytes()
    if len(lines := shape.grid.of_type(LINE, 2)):
        head += [f"element edge {len(lines)}"]
        head += [f"property int {end}" for end in ("vertex1", "vertex2")]
        data += lines.astype("<i4").tobytes()
    _write(path, "\n".join([*head, "end_header\n"]).encode() + data)


#: How a shape is written, by the ending of the file.
WRITERS = {"vtu": write_vtu, "obj": write_obj, "ply": write_ply}


def cannot_write(path: Path, error: OSError) -> ResultError:
    """Return the error that a file cannot be written."""
    return ResultError(f'cannot write "{path}": {error.strerror or error}')


def _obj_line(letter: str, numbers: Iterable[float]) -> str:
    return " ".join([letter, *map(repr, numbers)]) + "\n"


def _section(name: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    texts = [_data_array(key, data) for key, data in arrays.items()]
    return f"<{name}>\n{''.join(texts)}</{name}>\n"


def _data_array(name: str, data: NDArray[Any], *, tuples: bool = False) -> str:
    """Return an array as VTK's XML has it: base64 of its length in bytes and its bytes."""
    kind = _VTK_TYPES[data.dtype.name]
    plain = data.astype(data.dtype.newbyteorder("<")).tobytes()
    code = b64encode(np.array(len(plain), dtype="<u8").tobytes() + plain).decode()
    count = f' NumberOfTuples="{len(data)}"' if tuples else ""
    width = f' NumberOfComponents="{data.shape[1]}"' if data.ndim == 2 else ""
    attributes = f'type="{kind}" Name={quoteattr(name)}{width}{count} format="binary"'
    return f"<DataArray {attributes}>{code}</DataArray>\n"


def _text_array(name: str, texts: Sequence[str]) -> str:
    """Return texts as VTK's XML has them: the codes of their bytes, with a zero behind each."""
    codes = " ".join(str(code) for text in texts for code in (*text.encode(), 0))
    head = f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="{len(texts)}"'
    return f'{head} format="ascii">{codes}</Array>\n'


def _write(path: Path, data: bytes) -> None:
    try:
        write_file(path, data)
    except OSError as error:
        raise cannot_write(path, error) from error
