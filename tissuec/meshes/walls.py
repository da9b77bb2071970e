"""Walls as triangles: the faces of a surface, and their edges instead of springs."""

import numpy as np
from msgspec.structs import replace

from tissuec.core.vectors import cross, norm
from tissuec.meshes.formats import FormatError
from tissuec.meshes.generators import Elemental, ElementMesh, Generator, Mesh, Threaded
from tissuec.meshes.generators.joining import springs

TRIANGLE = "triangle"  # the shape of elements of walls
_FLAT = 1e-9  # of the square of its longest side: a triangle of less area has none


def is_wall(mesh: Generator | None) -> bool:
    """Return whether a body of elements is a wall of triangles.

    Args:
        mesh: Of the body; None if it is explicit.
    """
    if mesh is None or isinstance(mesh, Threaded):
        return False
    return not (isinstance(mesh, Elemental) and mesh.is_solid)


def wall_of_triangles(mesh: Mesh) -> Mesh:
    """Return a surface whose elements are its triangles, and whose springs are their edges.

    Raises:
        FormatError: It is no surface, or a triangle has no area.
    """
    if mesh.volume is not None:
        raise FormatError("it has an inside, so it has no thickness", "remove thickness")
    if not len(mesh.skin):
        raise FormatError("it has no surface", "write made of springs")
    triangles = mesh.skin.astype(np.int64)
    corners = mesh.position[triangles]
    longest = np.ptp(corners, axis=1).max(axis=1)
    area = 0.5 * norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    if (flat := area <= _FLAT * longest**2).any():
        from tissuec.meshes.repair import place

        first = int(np.argmax(flat))
        raise FormatError(
            f"{int(flat.sum())} triangles without an area, the first of them around "
            f"{place(corners[first].mean(axis=0))}",
            "repair it in the program that made the mesh, or write made of springs",
        )
    pairs = (triangles[:, [k, (k + 1) % 3]] for k in range(3))
    ends = springs(len(mesh.position), *pairs)
    return replace(mesh, ends=ends, shares=None, elements=(ElementMesh(TRIANGLE, triangles),))
