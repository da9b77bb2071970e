"""PLY, the Stanford format, read by the optional library."""

from pathlib import Path

from tissuec.formats import FORMATS, FormatError, RawMesh
from tissuec.formats.foreign import by_library, raw_mesh


@FORMATS.member(".ply")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices and faces."""
    head, end, _ = data.partition(b"end_header")
    if not head.startswith(b"ply") or not end:
        raise FormatError('it does not begin with a header from "ply" to "end_header"')
    return raw_mesh(by_library("ply", path))
