"""Formats of mesh files: a member has a reader, and is named after its extension.

A reader takes what the file says and no more: coordinates in whatever unit the file has, cells,
and named groups. Whether that makes a good mesh is for ``meshes.repair`` to say.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.meshes.between import BetweenNodes

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]

#: Cells of a fixed number of corners. Besides these there are polygons, faces of five or more.
CORNERS = {"triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
_MOST_VALUES = 256  # of an array that numbers the parts of a mesh; more is a measured quantity


class FormatError(ValueError):
    """A file is not what its name says, or is broken; the message names no file.

    Attributes:
        hint: What to do about it.
        unit: Unit of length of the file, where another one is given.
    """

    def __init__(self, message: str, hint: str = "", *, unit: str = ""):
        self.hint = hint
        self.unit = unit
        super().__init__(message)


class MeshCells(Struct, frozen=True, eq=False):
    """Cells of one kind and number of corners.

    Attributes:
        kind: One of ``CORNERS``, or "polygon".
        nodes: Corners, shape (cell, corner); VTK's order, so that faces are known.
        element: The number of each cell in the file, from 0, shape (cell,).
        label: What the file calls faces that are walls of their own, not sides of solids.
    """

    kind: str
    nodes: Indices
    element: Indices
    label: str = ""

    def at(self, rows: Indices | NDArray[np.bool_]) -> "MeshCells":
        """Return some of the cells, by indices or by a mask of shape (cell,)."""
        return MeshCells(self.kind, self.nodes[rows], self.element[rows], self.label)


class RawMesh(Struct, frozen=True, eq=False):
    """Contents of a mesh file.

    Attributes:
        position: In the unit of the file, shape (node, 3).
        cells: Surface and volume cells.
        parts: Numbers of the elements of each named part, by name.
        groups: Nodes of each named set of nodes, by name.
        ignored: How many lines, beams and single points there are besides.
        curved: How many cells have nodes besides their corners, which are left out.
        remarks: What else is to be reported about the file.
        between: Nodes of tetrahedra and hexahedra that are no corners.
    """

    position: Floats
    cells: tuple[MeshCells, ...]
    parts: Mapping[str, Indices] = field(default_factory=dict[str, Indices])
    groups: Mapping[str, Indices] = field(default_factory=dict[str, Indices])
    ignored: Mapping[str, int] = field(default_factory=dict[str, int])
    curved: int = 0
    remarks: tuple[str, ...] = ()
    between: BetweenNodes = field(default_factory=BetweenNodes.none)


Reader: TypeAlias = Callable[[bytes, Path], RawMesh]

#: Readers by extension; each takes the bytes of a file and its path.
FORMATS: Family[Reader] = Family("tissuec.meshes.formats", "mesh format")

#: How a file begins, and what it holds near its beginning, by the reader of its format.
_SIGNS: dict[Reader, tuple[bytes | tuple[bytes, ...], bytes]] = {}


def known_by(
    *, begins: bytes | tuple[bytes, ...] = (), holds: bytes = b""
) -> Callable[[Reader], Reader]:
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
        looks = ".dcm" if begins_like_dicom(data) else suffix
        kinds, way = ", ".join((*FORMATS, *IMAGES)), way_of(looks, path)
        hint = f"{way}  formats: {kinds}" if way else f"formats: {kinds}"
        if not suffix:
            raise FormatError("its name does not end with that of a format", hint)
        raise FormatError(f'the format "{suffix}" is not supported', hint)
    if not data.strip():
        raise FormatError("the file is empty")
    looks = looks_like(data)
    try:
        return _read(FORMATS[suffix], data, path)
    except FormatError as error:
        if looks and looks != suffix:
            begin = data.lstrip()[:12].split(b"\n")[0].decode("ascii", "replace")
            raise FormatError(
                f'this is not a {suffix} file: it begins with "{begin}"',
                f'it looks like {looks}: rename it to "{path.with_suffix(looks).name}"',
            ) from error
        raise


def _read(reader: Reader, data: bytes, path: Path) -> RawMesh:
    try:
        with np.errstate(over="raise", invalid="raise"):
            return reader(data, path)
    except (OverflowError, FloatingPointError):
        raise FormatError("one of its whole numbers is too large for an index") from None


def looks_like(data: bytes) -> str:
    """Return the extension that the content of a file would fit, or an empty string."""
    head = data[:4096].lstrip(b"\xef\xbb\xbf \r\n\t")
    signs = {suffix: _SIGNS.get(reader, ((), b"")) for suffix, reader in FORMATS.items()}
    for suffix, (begins, _) in signs.items():
        if head.startswith(begins):
            return suffix
    for suffix, (_, holds) in signs.items():
        if holds and holds in b"\n" + head:
            return suffix
    return ""


def faces(flat: Indices, sizes: Indices, element: Indices) -> tuple[MeshCells, ...]:
    """Return faces of any number of corners as triangles, quads and polygons.

    Args:
        flat: Corners, face by face.
        sizes: How many corners each face has, shape (face,); at least three.
        element: The number of each face in the file, shape (face,).
    """
    first = np.cumsum(sizes) - sizes
    found: list[MeshCells] = []
    for size in np.unique(sizes).tolist():
        here = sizes == size
        kind = {3: "triangle", 4: "quad"}.get(size, "polygon")
        found.append(
            MeshCells(kind, flat[first[here][:, None] + np.arange(size)], element[here])
        )
    return tuple(found)


def numbered_parts(name: str, values: NDArray[np.generic]) -> dict[str, Indices]:
    """Return the cells that have each value of an array that numbers parts: "label 3".

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
    return {f"{name} {int(value)}": np.flatnonzero(values == value) for value in found}


_GRID = (
    "write its cells one by one, in Python with pyvista: "
    'pyvista.read("{name}").cast_to_unstructured_grid().save("{stem}.vtu")'
)
_FIELD = (
    "an image is not a mesh: make a surface of it (a segmentation in 3D Slicer, or the filter "
    'Contour of ParaView), and save that as "{stem}.stl" or "{stem}.vtp"'
)
_IMAGE = (
    "for an image of labels: open it in 3D Slicer, and save it as "
    '"{stem}.nrrd" or "{stem}.nii.gz"; for a picture, save its segmentation'
)
_DICOM = (
    "open the series in 3D Slicer, segment it, and save the segmentation as "
    '"{stem}.seg.nrrd"; dcm2niix writes a series of labels as .nii.gz'
)
_OBJECT = 'export the object from a mesh program, such as Blender, as "{stem}.stl"'
_SHAPE = 'make a mesh of it first, such as with Gmsh: gmsh "{name}" -3 -o "{stem}.msh"'
_SEVERAL = (
    "open it in ParaView, choose one time and one block, and save that as "
    '"{stem}.vtu" (cells) or "{stem}.vtp" (surfaces)'
)

_PREAMBLE = 128  # bytes before the sign of DICOM: DICOM PS3.10, 7.1
#: Endings of names of label images, which ``meshes.images`` reads.
IMAGES = (".nrrd", ".nhdr", ".nii", ".nii.gz")

#: By the extension of a file, or by what VTK calls its contents, in small letters.
_WAYS = {
    **dict.fromkeys(("structuredgrid", "rectilineargrid", ".vts", ".vtr"), _GRID),
    **dict.fromkeys(("structuredpoints", "imagedata", ".vti"), _FIELD),
    **dict.fromkeys((".mha", ".mhd", ".tif", ".tiff", ".hdr", ".img", ".mgz"), _IMAGE),
    **dict.fromkeys((".dcm", ".dicom", ".ima"), _DICOM),
    **dict.fromkeys((".gltf", ".glb", ".fbx", ".blend", ".dae", ".3mf", ".3ds"), _OBJECT),
    **dict.fromkeys((".step", ".stp", ".iges", ".igs", ".brep", ".geo"), _SHAPE),
    **dict.fromkeys((".vtm", ".pvd", ".pvtu", ".xdmf", ".e", ".exo", ".case"), _SEVERAL),
}


def begins_like_dicom(data: bytes) -> bool:
    """Return whether contents of a file begin as DICOM, whatever the name of the file."""
    return data[_PREAMBLE : _PREAMBLE + 4] == b"DICM"


def way_of_folder(path: Path) -> str:
    """Return how a mesh is made of a folder: of a DICOM series, or of one of its files."""
    try:
        with next(one for one in sorted(path.iterdir()) if one.is_file()).open("rb") as file:
            if begins_like_dicom(file.read(_PREAMBLE + 4)):
                return way_of(".dcm", path)
    except (OSError, StopIteration):
        pass
    return "name one file in it"


def way_of(kind: str, path: Path) -> str:
    """Return how a mesh is made of a file that contains something else; empty if unknown.

    Args:
        kind: The extension of the file, or what VTK calls its contents.
        path: The file.
    """
    way = _WAYS.get(kind.lower().replace("_", ""), "")
    return way.format(name=path.name, stem=path.stem)
