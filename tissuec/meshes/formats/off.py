"""OFF, the format of Geomview: a line for each vertex, and for each face.

The first word may name colours, normals or texture coordinates of the vertices (``COFF``),
which follow the three coordinates and are left out.
"""

import re
from pathlib import Path

import numpy as np

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, faces, known_by
from tissuec.meshes.formats.numbers import as_floats, as_whole

_HEAD = re.compile(r"(ST)?C?N?OFF(\s+BINARY)?")


@FORMATS.member(".off")
@known_by(begins=b"OFF")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices and faces.

    Raises:
        FormatError: The file is no OFF file, is binary or cut off.
    """
    lines = [line.split("#")[0] for line in data.decode("utf-8", "replace").splitlines()]
    rows = [line.split() for line in lines if line.strip()]
    head = _HEAD.match(" ".join(rows[0])) if rows else None
    if head is None:
        raise FormatError('it does not begin with "OFF"')
    if head[2]:
        raise FormatError("it is binary, which is not supported", "save it as text")
    # The numbers of vertices, faces and edges may follow on the first line.
    counts = as_whole(as_floats(rows.pop(0)[1:] or (rows.pop(0) if rows else [])))
    if len(counts) < 2 or (counts < 0).any():
        raise FormatError("its numbers of vertices and faces are missing")
    vertices, count = int(counts[0]), int(counts[1])
    if len(rows) < vertices + count:
        missing = vertices + count - len(rows)
        raise FormatError(f"it is truncated: {missing} lines of vertices or faces are missing")
    if any(len(row) < 3 for row in rows[:vertices]):
        raise FormatError("a vertex has fewer than three coordinates")
    position = as_floats([word for row in rows[:vertices] for word in row[:3]]).reshape(-1, 3)
    corners: list[str] = []
    sizes = as_whole(as_floats([row[0] for row in rows[vertices : vertices + count]]))
    for number in range(count):
        size = int(sizes[number])
        row = rows[vertices + number][1 : 1 + size]
        if len(row) != size or size < 3:
            raise FormatError(f"face {number + 1} has {len(row)} of {size} corners")
        corners += row
    flat = as_whole(as_floats(corners))
    return RawMesh(position, faces(flat, sizes, np.arange(count)))
