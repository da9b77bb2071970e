"""Formats that the optional library reads: PLY, VTU and Gmsh's MSH.

meshlane is the maintained fork of meshio. Its readers are called one by one: the common entry
prints errors and ends the process. What it gives is not trusted: cells are counted against what
the file announces, and indices are checked with those of all other formats.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.meshes.formats import (
    CORNERS,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    faces,
    gather,
    numbered_parts,
)

INSTALL = 'install it: pip install "tissuec[mesh]"'


def by_library(name: str, path: Path) -> Any:
    """Return the mesh that the library reads from a file of a format, such as "vtu".

    Raises:
        FormatError: The library is not there, or cannot read the file.
    """
    try:
        read: Callable[[str], Any] = import_module(f"meshlane.{name}").read
    except ImportError:
        message = f"reading .{path.suffix[1:].lower()} needs the optional package meshlane"
        raise FormatError(message, INSTALL) from None
    try:
        return read(str(path))
    except Exception as error:  # whatever strange bytes make it stumble over
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise FormatError(f"it cannot be read: {reason}") from None


def raw_mesh(found: Any, names: dict[tuple[int, int], str] | None = None) -> RawMesh:
    """Return what the library read as a ``RawMesh``.

    Args:
        found: The mesh of the library.
        names: Names of Gmsh's physical groups, by dimension and number.

    Raises:
        FormatError: Points are not of two or three coordinates, or a cell is malformed.
    """
    position = np.asarray(found.points, dtype=float)
    if position.ndim != 2 or position.shape[1] not in (2, 3):
        raise FormatError(f"its points have {position.shape[-1]} coordinates")
    if position.shape[1] == 2:
        position = np.column_stack([position, np.zeros(len(position))])
    cells: list[MeshCells] = []
    ignored: dict[str, int] = {}
    curved = polygons = 0
    for block in found.cells:
        kind = block.type.rstrip("0123456789")
        nodes = block.data
        if not len(nodes):
            continue
        if kind in ("vertex", "line"):
            word = {"vertex": "point"}.get(kind, kind)
            ignored[word] = ignored.get(word, 0) + len(nodes)
        elif kind == "polygon":
            rows = [np.asarray(row, dtype=np.int64) for row in nodes]
            made, many = faces(np.concatenate(rows), np.array([len(row) for row in rows]))
            cells += made
            polygons += many
        elif kind in CORNERS:
            corners = np.asarray(nodes, dtype=np.int64).reshape(len(nodes), -1)
            curved += len(corners) * (corners.shape[1] > CORNERS[kind])
            cells.append(MeshCells(kind, corners[:, : CORNERS[kind]]))
        else:
            raise FormatError(
                f"{len(nodes)} cells are of type {block.type}, which is not supported"
            )
    groups = _groups(found, names or {})
    return RawMesh(position, tuple(cells), groups, ignored, curved, polygons)


def _groups(found: Any, names: dict[tuple[int, int], str]) -> dict[str, Indices]:
    members: dict[str, list[Indices]] = {}
    for name, columns in found.cell_data.items():
        if name == "gmsh:geometrical":
            continue
        for block, values in zip(found.cells, columns, strict=True):
            shown = "physical" if name == "gmsh:physical" else name
            for part, inside in numbered_parts(shown, np.asarray(values)).items():
                number = int(part.rsplit(" ", 1)[1])
                if name == "gmsh:physical" and not number:
                    continue  # which stands for none
                if name == "gmsh:physical":
                    part = names.get((int(block.dim), number), part)
                nodes = np.asarray(block.data)[inside]
                members.setdefault(part, []).append(np.asarray(nodes, dtype=np.int64))
    return {name: gather(nodes) for name, nodes in members.items()}
