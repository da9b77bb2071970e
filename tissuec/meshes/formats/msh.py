"""MSH, the format of Gmsh (2.2, 4.0 and 4.1), read by the optional library."""

from pathlib import Path

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by
from tissuec.meshes.formats.optional import by_library, raw_mesh


@FORMATS.member(".msh")
@known_by(begins=b"$MeshFormat")
def read(data: bytes, path: Path) -> RawMesh:
    """Return nodes and elements; physical groups are groups, by name where they have one.

    Raises:
        FormatError: The file is no MSH file, or a section is missing or cut off.
    """
    if not data.lstrip().startswith((b"$MeshFormat", b"$Comments")):
        raise FormatError('it does not begin with "$MeshFormat"')
    for section in (b"Nodes", b"Elements"):
        if b"$" + section not in data:
            raise FormatError(f"it contains no ${section.decode()}")
        if b"$End" + section not in data:
            raise FormatError(f"it is truncated: $End{section.decode()} is missing")
    found = by_library("gmsh", path)
    names = {(int(dim), int(tag)): name for name, (tag, dim) in found.field_data.items()}
    return raw_mesh(found, names)
