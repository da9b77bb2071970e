"""Medit's format (``.mesh``) as text: keywords, each followed by a count and rows of numbers.

The last number of a row is a reference; those of the cells number parts, as ``reference 3``.
"""

from pathlib import Path

import numpy as np

from tissuec.meshes.formats import (
    FORMATS,
    Floats,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    known_by,
    numbered_parts,
)
from tissuec.meshes.formats.numbers import NumberStream, as_whole

_KINDS = {
    "edges": ("line", 2), "triangles": ("triangle", 3), "quadrilaterals": ("quad", 4),
    "tetrahedra": ("tetra", 4), "pyramids": ("pyramid", 5), "prisms": ("wedge", 6),
    "hexahedra": ("hexahedron", 8), "hexaedra": ("hexahedron", 8),
}  # fmt: skip


@FORMATS.member(".mesh")
@known_by(begins=b"MeshVersionFormatted")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices and cells.

    Raises:
        FormatError: The file is no such file, or is cut off.
    """
    sections = _sections(data)
    if "meshversionformatted" not in sections:
        raise FormatError('it does not begin with "MeshVersionFormatted"')
    if "vertices" not in sections or "dimension" not in sections:
        raise FormatError("it contains no Dimension or no Vertices")
    dimension = sections["dimension"].one()
    if dimension not in (2, 3):
        raise FormatError(f"it has {dimension} dimensions")
    rows = _rows("Vertices", sections["vertices"], dimension + 1)
    position = np.zeros((len(rows), 3))
    position[:, :dimension] = rows[:, :dimension]
    cells: list[MeshCells] = []
    references: list[Indices] = []
    ignored: dict[str, int] = {}
    count = 0
    for name, (kind, corners) in _KINDS.items():
        if name not in sections:
            continue
        found = as_whole(_rows(name.capitalize(), sections[name], corners + 1))
        if kind == "line":
            ignored[kind] = len(found)
            continue
        element = count + np.arange(len(found))
        cells.append(MeshCells(kind, found[:, :-1] - 1, element))
        references.append(found[:, -1])
        count += len(found)
    marks = np.concatenate([np.zeros(0, np.int64), *references])
    parts = numbered_parts("reference", marks) if marks.any() else {}
    return RawMesh(position, tuple(cells), parts, {}, ignored)


def _sections(data: bytes) -> dict[str, NumberStream]:
    """Return the numbers after each keyword, by the keyword in lower case."""
    lines = [line.split(b"#")[0] for line in data.splitlines()]
    words = b" ".join(lines).split()
    heads = [k for k, word in enumerate(words) if word[:1].isalpha() and len(word) > 2]
    found: dict[str, NumberStream] = {}
    for start, end in zip(heads, [*heads[1:], len(words)], strict=True):
        key = words[start].decode("ascii", "replace").lower()
        if key in found and key in (*_KINDS, "vertices"):
            raise FormatError(f'"{key.capitalize()}" is given twice')
        if key in (*_KINDS, "vertices", "dimension", "meshversionformatted"):
            found[key] = NumberStream(b" ".join(words[start + 1 : end]))
    return found


def _rows(name: str, numbers: NumberStream, width: int) -> Floats:
    """Return the rows of a section; there must be as many as it declares."""
    count = numbers.one()
    if numbers.left != count * width:
        rows = numbers.left / width
        raise FormatError(f"it is truncated: {name} declares {count}, but contains {rows:g}")
    return numbers.take(count * width, "f8").reshape(count, width)
