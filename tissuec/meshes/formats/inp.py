"""Abaqus input files, read by the optional library meshlane.

Parts and instances, sets and included files are what the library reads rightly. Elements whose
type it does not know it leaves out with a warning; such files are refused here.
"""

import re
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core.errors import counted
from tissuec.meshes.formats import (
    CORNERS,
    FORMATS,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    known_by,
)

INSTALL = 'install it: pip install "tissuec[mesh]"'
_TYPE = re.compile(rb"^\*ELEMENT\b[^\n]*?\bTYPE\s*=\s*([\w-]+)", re.MULTILINE | re.IGNORECASE)
#: Beginnings of types of elements that are no cells: masses, springs, joints.
_NO_CELLS = ("MASS", "ROTARYI", "CONN", "SPRING", "DASHPOT", "DCOUP", "JOINT", "GAP")
_INCLUDE = re.compile(rb"^\*INCLUDE\b", re.MULTILINE | re.IGNORECASE)


@FORMATS.member(".inp")
@known_by(holds=b"\n*NODE")
def read(data: bytes, path: Path) -> RawMesh:
    """Return nodes and elements; element sets are parts, node sets are groups.

    Raises:
        FormatError: The library is not there or cannot read the file, or the file has elements
            of an unknown type or includes another file.
    """
    if _INCLUDE.search(data):
        raise FormatError("it includes another file, which is not supported", "join the files")
    if b"*node" not in data.lower():
        raise FormatError('it contains no "*NODE"')
    try:
        library: Any = import_module("meshlane.abaqus._abaqus")
        known: Mapping[str, str] = library.abaqus_to_meshio_type
        parse: Callable[[str], Any] = library.read
    except ImportError:
        message = "reading .inp needs the optional package meshlane"
        raise FormatError(message, INSTALL) from None
    types = {name.decode("ascii", "replace").upper() for name in _TYPE.findall(data)}
    left_out = sorted(name for name in types if name.startswith(_NO_CELLS))
    if unknown := sorted(types - set(known) - set(left_out)):
        raise FormatError(f"elements of type {', '.join(unknown)} are not supported")
    try:
        found = parse(str(path))
    except Exception as error:  # whatever strange bytes make it stumble over
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise FormatError(f"it cannot be read: {reason}") from None
    remarks = tuple(f"elements of type {name} left out" for name in left_out)
    return _mesh(found, remarks)


def _mesh(found: Any, remarks: tuple[str, ...]) -> RawMesh:
    position = np.asarray(found.points, dtype=float)
    if position.ndim != 2 or position.shape[1] != 3:
        raise FormatError("its nodes do not have three coordinates")
    cells: list[MeshCells] = []
    ignored: dict[str, int] = {}
    starts = np.cumsum([0, *(len(block.data) for block in found.cells)])
    curved = 0
    for block, start in zip(found.cells, starts, strict=False):
        kind = block.type.rstrip("0123456789")
        nodes = np.asarray(block.data, dtype=np.int64)
        if kind == "line":
            ignored["beam"] = ignored.get("beam", 0) + len(nodes)
        elif kind in CORNERS:
            curved += len(nodes) * (nodes.shape[1] > CORNERS[kind])
            elements = start + np.arange(len(nodes))
            cells.append(MeshCells(kind, nodes[:, : CORNERS[kind]], elements))
        else:
            raise FormatError(f"elements of type {block.type} are not supported")
    parts: dict[str, Indices] = {}
    for name, blocks in found.cell_sets.items():
        members = [
            start + np.asarray(rows, np.int64)
            for rows, start in zip(blocks, starts, strict=False)
            if rows is not None and len(rows)
        ]
        if members:
            parts[name] = np.concatenate(members)
    groups = {name: np.asarray(rows, np.int64) for name, rows in found.point_sets.items()}
    if ignored:
        remarks = (*remarks, f"{counted(ignored['beam'], 'beam')} left out")
    return RawMesh(position, tuple(cells), parts, groups, ignored, curved, remarks)
