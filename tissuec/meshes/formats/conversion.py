"""Files that hold no mesh of cells or faces, and how one is made of them."""

from pathlib import Path

_GRID = (
    "write its cells one by one, in Python with pyvista: "
    'pyvista.read("{name}").cast_to_unstructured_grid().save("{stem}.vtu")'
)
_IMAGE = (
    "an image is no mesh: make a surface of it (a segmentation in 3D Slicer, or the filter "
    'Contour of ParaView), and save that as "{stem}.stl" or "{stem}.vtp"'
)
_OBJECT = 'export the object from a mesh program, such as Blender, as "{stem}.stl"'
_SHAPE = 'make a mesh of it first, such as with Gmsh: gmsh "{name}" -3 -o "{stem}.msh"'
_SEVERAL = (
    "open it in ParaView, choose one time and one block, and save that as "
    '"{stem}.vtu" (cells) or "{stem}.vtp" (surfaces)'
)

#: By the extension of a file, or by what VTK calls its contents, in small letters.
_WAYS = {
    **dict.fromkeys(("structuredgrid", "rectilineargrid", ".vts", ".vtr"), _GRID),
    **dict.fromkeys(("structuredpoints", "imagedata", ".vti"), _IMAGE),
    **dict.fromkeys((".dcm", ".nii", ".nrrd", ".mha", ".mhd", ".tif", ".tiff"), _IMAGE),
    **dict.fromkeys((".gltf", ".glb", ".fbx", ".blend", ".dae", ".3mf", ".3ds"), _OBJECT),
    **dict.fromkeys((".step", ".stp", ".iges", ".igs", ".brep", ".geo"), _SHAPE),
    **dict.fromkeys((".vtm", ".pvd", ".pvtu", ".xdmf", ".e", ".exo", ".case"), _SEVERAL),
}


def way_of(kind: str, path: Path) -> str:
    """Return how a mesh is made of a file that contains something else; empty if unknown.

    Args:
        kind: The extension of the file, or what VTK calls its contents.
        path: The file.
    """
    way = _WAYS.get(kind.lower().replace("_", ""), "")
    return way.format(name=path.name, stem=path.stem)
