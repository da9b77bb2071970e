"""PLY, the Stanford format, read by the optional library."""

import re
from pathlib import Path

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by
from tissuec.meshes.formats.optional import by_library, raw_mesh


@FORMATS.member(".ply")
@known_by(begins=b"ply")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices and faces.

    Raises:
        FormatError: The header is missing, or elements are missing.
    """
    head, end, _ = data.partition(b"end_header")
    if not head.startswith(b"ply") or not end:
        raise FormatError('it does not begin with a header from "ply" to "end_header"')
    found = by_library("ply", path)
    there = {
        b"vertex": len(found.points),
        b"face": sum(len(block.data) for block in found.cells if block.type != "vertex"),
    }
    for name, count in there.items():  # the library takes a file that is cut off as it is
        announced = re.search(rb"^element\s+%s\s+(\d+)" % name, head, re.MULTILINE)
        if announced and int(announced[1]) != count:
            what, how_many = name.decode(), announced[1].decode()
            raise FormatError(
                f"it is truncated: {how_many} of element {what}, {count} were read"
            )
    return raw_mesh(found)
