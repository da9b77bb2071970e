"""Formats of mesh files: a member is one file with a reader, named after its extension.

A reader takes what the file says and no more: coordinates in whatever unit the file has, cells,
and named groups. Whether that makes a good mesh is for ``meshes.repair`` to say.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.registry import Family

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]

#: Cells that a mesh can be made of, and how many corners each has.
CORNERS = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
_MOST_VALUES = 256  # of an array that numbers the parts of a mesh; more is a measured quantity


class FormatError(ValueError):
    """A file is not what its name says, or is broken; the message names no file."""

    def __init__(self, message: str, hint: str = ""):
        self.hint = hint
        super().__init__(message)


class MeshCells(Struct, frozen=True, eq=False):
    """Cells of one kind.

    Attributes:
        kind: One of ``CORNERS``.
        nodes: Corners, shape (cell, corner); VTK's order, so that faces are known.
    """

    kind: str
    nodes: Indices


class RawMesh(Struct, frozen=True, eq=False):
    """Contents of a mesh file.

    Attributes:
        position: In the unit of the file, shape (node, 3).
        cells: Surface and volume cells.
        groups: Nodes of each named part, by name.
        ignored: How many lines and single points there are besides.
        curved: How many cells have nodes besides their corners, which are left out.
        polygons: How many faces had more than four corners and were divided.
    """

    position: Floats
    cells: tuple[MeshCells, ...]
    groups: Mapping[str, Indices] = field(default_factory=dict[str, Indices])
    ignored: Mapping[str, int] = field(default_factory=dict[str, int])
    curved: int = 0
    polygons: int = 0


Reader: TypeAlias = Callable[[bytes, Path], RawMesh]

#: Readers by extension; each takes the bytes of a file and its path.
FORMATS: Family[Reader] = Family("tissuec.meshes.formats", "mesh format")

#: How a file begins, and what it holds near its beginning, by the reader of its format.
_SIGNS: dict[Reader, tuple[bytes, bytes]] = {}


def known_by(*, begins: bytes = b"", holds: bytes = b"") -> Callable[[Reader], Reader]:
    """Return a decorator of readers that says how their files are known under a wrong name."""

    def enter(reader: Reader) -> Reader:
        _SIGNS[reader] = begins, holds
        return reader

    return enter


def read(data: bytes, path: Path) -> RawMesh:
    """Return the contents of a mesh file.

    Raises:
        FormatError: The extension is unknown, or the file is not of that format or is broken.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        kinds = ", ".join(FORMATS)
        raise FormatError(f'the format "{suffix}" is not supported', f"formats: {kinds}")
    if not data.strip():
        raise FormatError("the file is empty")
    looks = looks_like(data)
    try:
        return FORMATS[suffix](data, path)
    except FormatError as error:
        if looks and looks != suffix:
            begin = data.lstrip()[:12].split(b"\n")[0].decode("ascii", "replace")
            raise FormatError(
                f'this is not a {suffix} file: it begins with "{begin}"',
                f'it looks like {looks}: rename it to "{path.with_suffix(looks).name}"',
            ) from error
        raise


def looks_like(data: bytes) -> str:
    """Return the extension that the content of a file would fit, or an empty string."""
    head = data[:4096].lstrip(b"\xef\xbb\xbf \r\n\t")
    signs = {suffix: _SIGNS.get(reader, (b"", b"")) for suffix, reader in FORMATS.items()}
    for suffix, (begins, _) in signs.items():
        if begins and head.startswith(begins):
            return suffix
    for suffix, (_, holds) in signs.items():
        if holds and holds in b"\n" + head:
            return suffix
    return ""


def faces(flat: Indices, sizes: Indices) -> tuple[tuple[MeshCells, ...], int]:
    """Return faces of any number of corners as triangles and quads.

    Args:
        flat: Corners, face by face.
        sizes: How many corners each face has, shape (face,); at least three.

    Returns:
        The faces, and how many of them had more than four corners: these are divided from
        their first corner, as renderers do.
    """
    first = np.cumsum(sizes) - sizes
    triangles = [np.zeros((0, 3), dtype=np.int64)]
    quads = np.zeros((0, 4), dtype=np.int64)
    for size in np.unique(sizes):
        rows = flat[first[sizes == size][:, None] + np.arange(size)]
        if size == 4:
            quads = rows
        else:
            fan = [rows[:, [0, k, k + 1]] for k in range(1, size - 1)]
            triangles.append(np.stack(fan, axis=1).reshape(-1, 3))
    cells = (MeshCells("triangle", np.concatenate(triangles)), MeshCells("quad", quads))
    return tuple(c for c in cells if len(c.nodes)), int(np.count_nonzero(sizes > 4))


def numbered_parts(name: str, values: NDArray[np.generic]) -> dict[str, NDArray[np.bool_]]:
    """Return which cells have each value of an array that numbers parts: "label 3".

    Args:
        name: Name of the array.
        values: Of each cell, dimensionless, shape (cell,). An array with several columns, with
            fractions or with very many different values does not number parts and gives
            nothing.
    """
    if values.ndim != 1 or values.dtype.kind not in "iuf" or not len(values):
        return {}
    if not np.isfinite(values.astype(float)).all():
        return {}
    found = np.unique(values)
    if len(found) > _MOST_VALUES or np.any(found != np.rint(found)):
        return {}
    return {f"{name} {int(value)}": values == value for value in found}


def gather(nodes: Sequence[Indices]) -> Indices:
    """Return each node of several index arrays of any shape once, ascending, shape (n,)."""
    return np.unique(np.concatenate([np.zeros(0, np.int64), *(n.ravel() for n in nodes)]))
