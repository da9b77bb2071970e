"""VTKHDF files of unstructured grids, such as results: the cells of the last step.

Of a result, this is the deformed shape of the last frame; ``tissuec export --frame`` writes
others as ``.vtu``. (VTK file formats, section VTKHDF.)
"""

from io import BytesIO
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by
from tissuec.meshes.formats.numbers import as_whole
from tissuec.meshes.formats.vtk import of_types

_KIND = "UnstructuredGrid"
_WITH_CELLS = 3  # the first layout of results with volume cells


@FORMATS.member(".vtkhdf")
@known_by(begins=b"\x89HDF\r\n\x1a\n")
def read(data: bytes, path: Path) -> RawMesh:
    """Return the points and cells of the last step of an unstructured grid.

    Raises:
        FormatError: The file is no such file, or is damaged.
    """
    try:
        with h5py.File(BytesIO(data), "r") as file:
            if "VTKHDF" not in file:
                raise FormatError("it is an HDF5 file without the group VTKHDF")
            _refuse_earlier(file)
            return _mesh(file["VTKHDF"])
    except (OSError, KeyError, ValueError, IndexError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"it cannot be read: {error}") from None


def _refuse_earlier(file: h5py.File) -> None:
    """Reject results of versions whose solids are edges and triangles."""
    marks: Any = file["tissuec"].attrs if "tissuec" in file else {}
    layout = int(marks.get("layout_version", _WITH_CELLS))
    if layout < _WITH_CELLS:
        by = file["tissuec/manifest"].attrs.get("tissuec", "unknown")
        raise FormatError(
            f"it is a result of layout {layout} (of tissuec {by}), which has no volume cells",
            "run its scene again, and import the new result",
        )


def _mesh(group: Any) -> RawMesh:
    kind = group.attrs.get("Type", b"")
    kind = kind.decode() if isinstance(kind, bytes) else str(kind)
    if kind != _KIND:
        way = "export a frame as .vtu or .obj, or save one block in ParaView"
        raise FormatError(f'it contains "{kind}", not "{_KIND}"', way)
    part = point = cell = row = 0
    if "Steps" in group:
        steps = group["Steps"]
        last = int(steps.attrs["NSteps"]) - 1
        if last < 0:
            raise FormatError("it contains no frame, because its scene records no trajectory")
        part, point, cell, row = (
            int(np.ravel(steps[name][last])[0])
            for name in (
                "PartOffsets", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets",
            )
        )  # fmt: skip
    points, cells, rows = (
        int(group[name][part])
        for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds")
    )
    position = group["Points"][point : point + points]
    types = as_whole(group["Types"][cell : cell + cells])
    # Each part has one offset more than it has cells.
    ends = as_whole(group["Offsets"][cell + part : cell + part + cells + 1])
    flat = as_whole(group["Connectivity"][row : row + rows])
    if len(position) < points or len(types) < cells or len(ends) <= cells or len(flat) < rows:
        raise FormatError("it is truncated")
    return of_types(position, flat, np.diff(ends), types, {})
