"""VTU, VTK's unstructured grids in XML, read by the optional library."""

import re
from pathlib import Path

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by
from tissuec.meshes.formats.optional import by_library, raw_mesh
from tissuec.meshes.formats.xml import refuse_document_type

_PIECE = re.compile(rb"<Piece\b([^<>]*)")
_CELLS = re.compile(rb"\bNumberOfCells\s*=\s*[\"'](\d+)")


@FORMATS.member(".vtu")
@known_by(holds=b"<VTKFile")
def read(data: bytes, path: Path) -> RawMesh:
    """Return points and cells; whole-numbered arrays of the cells are groups.

    Raises:
        FormatError: The file is no VTU file, or the library read another number of cells.
    """
    refuse_document_type(data)
    if b"<VTKFile" not in data[:4096]:
        raise FormatError('it contains no "VTKFile"')
    found = by_library("vtu", path)
    announced = cells_announced(data)
    cells = sum(len(block.data) for block in found.cells)
    if sum(announced) != cells:  # of several pieces the library keeps the last one
        raise FormatError(
            f"{sum(announced)} cells in {len(announced)} pieces are declared, "
            f"but {cells} were read",
            "write it as one piece",
        )
    return raw_mesh(found)


def cells_announced(data: bytes) -> list[int]:
    """Return how many cells each piece says that it has."""
    pieces = map(_CELLS.search, _PIECE.findall(data))
    return [int(count[1]) for count in pieces if count]
