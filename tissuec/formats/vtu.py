"""VTU, VTK's unstructured grids in XML, read by the optional library."""

import re
from pathlib import Path

from tissuec.formats import FORMATS, FormatError, RawMesh
from tissuec.formats.foreign import by_library, raw_mesh
from tissuec.formats.markup import refuse_document_type

_PIECE = re.compile(rb"<Piece\b[^>]*\bNumberOfCells\s*=\s*[\"'](\d+)")


@FORMATS.member(".vtu")
def read(data: bytes, path: Path) -> RawMesh:
    """Return points and cells; whole-numbered arrays of the cells are groups."""
    refuse_document_type(data)
    if b"<VTKFile" not in data[:4096]:
        raise FormatError('it holds no "VTKFile"')
    found = by_library("vtu", path)
    announced = [int(count) for count in _PIECE.findall(data)]
    cells = sum(len(block.data) for block in found.cells)
    if sum(announced) != cells:  # of several pieces the library keeps the last one
        raise FormatError(
            f"{sum(announced)} cells in {len(announced)} pieces are announced, "
            f"and {cells} were read",
            "write it as one piece",
        )
    return raw_mesh(found)
