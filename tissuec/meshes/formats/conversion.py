"""Files that hold no mesh of cells or faces, and how one is made of them."""

from pathlib import Path

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
