"""Legacy VTK files: polygons (POLYDATA) and cells (UNSTRUCTURED_GRID), as text or binary.

Cells are written as "count, corners, count, corners, …" up to version 4, and as offsets and
connectivity from version 5 on. Binary numbers have their highest byte first; files of programs
that write the lowest first cannot be read that way, and are read the other way. Whole-numbered
arrays of the cells number parts, as ``label 3``.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.core.structs import replace
from tissuec.meshes.between import BetweenNodes
from tissuec.meshes.formats import (
    CORNERS,
    FORMATS,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    faces,
    known_by,
    numbered_parts,
    way_of,
)
from tissuec.meshes.formats.numbers import as_floats, as_whole

_TYPES = {
    "unsigned_char": "u1", "char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8",
    "float": "f4", "double": "f8", "vtkidtype": "i4",
    "vtktypeint8": "i1", "vtktypeuint8": "u1", "vtktypeint16": "i2", "vtktypeuint16": "u2",
    "vtktypeint32": "i4", "vtktypeuint32": "u4", "vtktypeint64": "i8", "vtktypeuint64": "u8",
}  # fmt: skip
_LISTS = ("VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS")
#: Numbers of cell types -> kind; curved ones name their corners first.
_KINDS = {
    5: "triangle", 22: "triangle", 34: "triangle", 69: "triangle",
    9: "quad", 23: "quad", 28: "quad", 70: "quad",
    10: "tetra", 24: "tetra", 71: "tetra",
    12: "hexahedron", 25: "hexahedron", 29: "hexahedron", 72: "hexahedron",
    13: "wedge", 26: "wedge", 32: "wedge", 73: "wedge",
    14: "pyramid", 27: "pyramid", 74: "pyramid",
}  # fmt: skip
#: Curved cells whose nodes besides the corners are kept, and how many nodes they have.
_WHOLE = {24: 10, 29: 27}
_ALIGNED = {8: ("quad", (0, 1, 3, 2)), 11: ("hexahedron", (0, 1, 3, 2, 4, 5, 7, 6))}
_POLYGON, _STRIP = 7, 6
_UNREAD = {41: "convex set of points", 42: "polyhedron"}
_NOT_CELLS = {1: "point", 2: "point", 3: "line", 4: "line", 21: "line", 68: "line"}


@FORMATS.member(".vtk")
@known_by(begins=b"# vtk DataFile")
def read(data: bytes, path: Path) -> RawMesh:
    """Return the points and cells of a legacy VTK file."""
    try:
        return _File(data, path, ">").mesh()
    except FormatError as error:
        try:
            mesh = _File(data, path, "<").mesh()
        except FormatError:
            raise error from None
        remark = "its numbers have their lowest byte first, which legacy VTK files should not"
        return replace(mesh, remarks=(remark,))


class _File:
    """What has been read so far, and the bytes that are left."""

    def __init__(self, data: bytes, path: Path, order: str):
        self.left, self.path, self.order = data, path, order
        head = self._line()
        if not head.startswith("# vtk DataFile Version"):
            raise FormatError('it does not begin with "# vtk DataFile Version"')
        self._line()  # the title
        form = self._line().strip().upper()
        if form not in ("ASCII", "BINARY"):
            raise FormatError(f'its third line is neither ASCII nor BINARY but "{form[:20]}"')
        self.is_text = form == "ASCII"
        self.position: NDArray[Any] | None = None
        self.lists: dict[str, tuple[Indices, Indices]] = {}
        self.types: Indices | None = None
        self.arrays: dict[str, NDArray[Any]] = {}

    def _line(self) -> str:
        line, _, self.left = self.left.partition(b"\n")
        return line.decode("utf-8", "replace").rstrip("\r")

    def mesh(self) -> RawMesh:
        count = None  # of cells or points that arrays are about, None before there are any
        is_of_cells = False
        while self.left.strip():
            words = self._line().split()
            if not words:
                continue
            key = words[0].upper()
            try:
                if key == "METADATA":
                    while self.left and self._line().strip():
                        pass
                elif key in ("CELL_DATA", "POINT_DATA"):
                    count, is_of_cells = int(words[1]), key == "CELL_DATA"
                elif count is not None:
                    found = self._attribute(key, words, count)
                    if found is None:
                        break  # arrays that are of no use here; nothing else can follow
                    self.arrays |= found if is_of_cells else {}
                else:
                    self._geometry(key, words)
            except (IndexError, KeyError, ValueError, OverflowError) as error:
                if isinstance(error, FormatError):
                    raise
                raise FormatError(f'"{" ".join(words)[:40]}" cannot be read') from None
        return self._result()

    def _geometry(self, key: str, words: list[str]) -> None:
        if key == "DATASET":
            if words[1].upper() not in ("POLYDATA", "UNSTRUCTURED_GRID"):
                raise FormatError(
                    f"it contains {words[1].upper()}; POLYDATA or UNSTRUCTURED_GRID is needed",
                    way_of(words[1], self.path),
                )
        elif key == "POINTS":
            self.position = self._numbers(3 * int(words[1]), words[2]).reshape(-1, 3)
        elif key in _LISTS:
            self.lists[key] = self._cells(int(words[1]), int(words[2]))
        elif key == "CELL_TYPES":
            self.types = as_whole(self._numbers(int(words[1]), "int"))
        elif key == "FIELD":
            self._field(int(words[2]))
        else:
            raise FormatError(f'"{" ".join(words)[:40]}" is unknown')

    def _cells(self, count: int, size: int) -> tuple[Indices, Indices]:
        """Return the corners of a list of cells one after another, and how many each has."""
        if self.left.lstrip().upper().startswith(b"OFFSETS"):
            self.left = self.left.lstrip()
            offsets = as_whole(self._numbers(count, self._line().split()[1]))
            self.left = self.left.lstrip()
            flat = as_whole(self._numbers(size, self._line().split()[1]))
            sizes = np.diff(offsets)
            if len(offsets) and (offsets[0] or offsets[-1] != size or (sizes < 0).any()):
                raise FormatError("the offsets of the cells do not match their corners")
            return flat, sizes
        row = as_whole(self._numbers(size, "int"))
        sizes, at = np.zeros(count, dtype=np.int64), 0
        for cell in range(count):
            if at >= size or row[at] < 0:
                raise FormatError(f"cell {cell + 1} of {count} is truncated")
            sizes[cell] = row[at]
            at += 1 + int(row[at])
        if at != size:
            raise FormatError(f"the cells need {at} numbers, but {size} are declared")
        heads = np.cumsum(sizes + 1) - sizes - 1
        return np.delete(row, heads), sizes

    def _attribute(
        self, key: str, words: list[str], count: int
    ) -> dict[str, NDArray[Any]] | None:
        """Return an array, by name; None where it cannot be passed over."""
        columns = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9}
        if key == "FIELD":
            return self._field(int(words[2]))
        if key == "SCALARS":
            width = int(words[3]) if len(words) > 3 else 1
            while not self._line().upper().startswith("LOOKUP_TABLE"):
                if not self.left:
                    return None
            values = self._numbers(width * count, words[2])
            return {words[1]: values} if width == 1 else {}
        if key in columns:
            self._numbers(columns[key] * count, words[2])
        elif key == "TEXTURE_COORDINATES":
            self._numbers(int(words[2]) * count, words[3])
        elif key == "COLOR_SCALARS":
            self._numbers(int(words[2]) * count, "unsigned_char")
        elif key == "LOOKUP_TABLE":
            self._numbers(4 * int(words[2]), "unsigned_char")
        else:
            return None
        return {}

    def _field(self, count: int) -> dict[str, NDArray[Any]] | None:
        found: dict[str, NDArray[Any]] = {}
        for _ in range(count):
            words: list[str] = []
            while not words or words[0] == "METADATA":
                if words:
                    while self.left and self._line().strip():
                        pass
                if not self.left:
                    return found
                words = self._line().split()
            name, width, rows, kind = words[:4]
            if kind.lower() not in _TYPES:
                return None
            values = self._numbers(int(width) * int(rows), kind)
            if int(width) == 1:
                found[name] = values
        return found

    def _numbers(self, count: int, kind: str) -> NDArray[Any]:
        """Take numbers off what is left."""
        kind = _TYPES[kind.lower()]
        if not self.is_text:
            size = count * np.dtype(kind).itemsize
            if len(self.left) < size or size < 0:
                raise FormatError(f"it is truncated: {size - len(self.left)} bytes are missing")
            values = np.frombuffer(self.left[:size], f"{self.order}{kind}")
            self.left = self.left[size:]
            return values.astype(kind)
        words = self.left.split(None, count)
        if len(words) < count:
            raise FormatError(f"it is truncated: {count - len(words)} numbers are missing")
        self.left = words.pop() if len(words) > count else b""
        if not count:
            return np.zeros(0)
        return as_floats(words)

    def _result(self) -> RawMesh:
        if self.position is None:
            raise FormatError("it contains no points")
        if "CELLS" in self.lists:
            if self.types is None or len(self.types) != len(self.lists["CELLS"][1]):
                raise FormatError("it is truncated: the types of its cells are missing")
            return of_types(self.position, *self.lists["CELLS"], self.types, self.arrays)
        kinds = {"VERTICES": 1, "LINES": 4, "POLYGONS": _POLYGON, "TRIANGLE_STRIPS": _STRIP}
        used = [(self.lists[name], kind) for name, kind in kinds.items() if name in self.lists]
        empty = np.zeros(0, dtype=np.int64)
        flat = np.concatenate([empty, *(cells[0] for cells, _ in used)])
        sizes = np.concatenate([empty, *(cells[1] for cells, _ in used)])
        types = np.concatenate([empty, *(np.full(len(c[1]), kind) for c, kind in used)])
        return of_types(self.position, flat, sizes, types, self.arrays)


def of_types(
    position: NDArray[Any],
    flat: Indices,
    sizes: Indices,
    types: Indices,
    arrays: dict[str, NDArray[Any]],
) -> RawMesh:
    """Return a mesh from cells of VTK's numbered types and the arrays of these cells.

    Args:
        position: Points in the unit of the file, shape (point, 3).
        flat: Corners of all cells, one cell after the other, shape (corner,).
        sizes: Number of corners of each cell, shape (cell,).
        types: VTK's type of each cell, shape (cell,).
        arrays: Values of each cell by name, dimensionless, shape (cell,) or (cell, column).

    Raises:
        FormatError: A type is unknown, or a cell has a wrong number of corners.
    """
    first = np.cumsum(sizes) - sizes
    cells: list[MeshCells] = []
    ignored: dict[str, int] = {}
    curved, between = 0, BetweenNodes.none()
    for kind in np.unique(types).tolist():
        here = np.flatnonzero(types == kind)
        if kind in _NOT_CELLS:
            word = _NOT_CELLS[kind]
            ignored[word] = ignored.get(word, 0) + len(here)
        elif kind == _POLYGON:
            if short := int((sizes[here] < 3).sum()):
                raise FormatError(f"{short} polygons have fewer than three corners")
            rows = [flat[a : a + n] for a, n in zip(first[here], sizes[here], strict=True)]
            cells += faces(np.concatenate(rows), sizes[here], here)
        elif kind == _STRIP:
            cells.append(_strips(flat, first[here], sizes[here], here))
        elif kind in _KINDS or kind in _ALIGNED:
            name, order = _ALIGNED.get(kind, (_KINDS.get(kind, ""), ()))
            order = order or tuple(range(CORNERS[name]))
            if sizes[here].min() < len(order):
                raise FormatError(f"a cell of type {kind} has fewer than {len(order)} corners")
            if kind in _WHOLE and (sizes[here] == _WHOLE[kind]).all():
                nodes = flat[first[here][:, None] + np.arange(_WHOLE[kind])]
                if (nodes >= 0).all() and (nodes < len(position)).all():
                    between = between.joined(BetweenNodes.of(nodes, position.astype(float)))
            else:
                curved += int((sizes[here] > len(order)).sum())
            cells.append(MeshCells(name, flat[first[here][:, None] + np.array(order)], here))
        else:
            named = f"{kind} ({_UNREAD[kind]})" if kind in _UNREAD else f"{kind}"
            raise FormatError(
                f"{counted(len(here), 'cell')} of type {named}, which is not supported",
                "divide such cells into tetrahedra in the program that made them; in ParaView: "
                "Filters > Tetrahedralize",
            )
    parts: dict[str, Indices] = {}
    for name, values in arrays.items():
        if len(values) == len(types):
            parts |= numbered_parts(name, values)
    position = position.astype(float)
    return RawMesh(position, tuple(cells), parts, {}, ignored, curved, between=between)


def _strips(flat: Indices, first: Indices, sizes: Indices, number: Indices) -> MeshCells:
    """Return the triangles of strips; every other one is turned."""
    rows: list[tuple[int, int, int]] = []
    element: list[int] = []
    for start, size, one in zip(first.tolist(), sizes.tolist(), number.tolist(), strict=True):
        for k in range(size - 2):
            a, b, c = flat[start + k : start + k + 3].tolist()
            rows.append((a, b, c) if k % 2 == 0 else (b, a, c))
            element.append(one)
    nodes = np.array(rows, dtype=np.int64).reshape(-1, 3)
    return MeshCells("triangle", nodes, np.array(element, dtype=np.int64))
