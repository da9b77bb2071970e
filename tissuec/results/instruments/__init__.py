"""Instruments as they are drawn: their shapes, and where they are at each moment.

Forceps and scissors without a shape act on nodes by name. They are drawn where they hold and
cut; this has no effect on a run.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats

JET = "jet"  # the kind of what flows out of a nozzle
#: How a vertex moves within its instrument.
FIXED, UPPER, LOWER, STRETCHED, SHIFTED = 0, 1, 2, 3, 4


class InstrumentMesh(Struct, frozen=True, eq=False):
    """The shape of a kind of instrument, in units of its size.

    The point where it works is the origin. It opens along x, its blades lie across y, and its
    shaft leads away from the tissue along z.

    Attributes:
        vertices: Closed, shape (vertex, 3).
        part: How each vertex moves: with the shaft, with one of the jaws, which turn about
            the pivot, or stretched or shifted along z, shape (vertex,).
        triangles: Shape (triangle, 3).
        pivot: Where on z the jaws turn.
    """

    vertices: Floats
    part: NDArray[np.int64]
    triangles: NDArray[np.int64]
    pivot: float = 0.0

    def posed(self, setting: float) -> Floats:
        """Return the vertices of an instrument that is open or long, shape (vertex, 3).

        Args:
            setting: Angle by which each jaw is open [rad], factor of what is stretched, or way
                of what is shifted.
        """
        points = self.vertices.copy()
        for part, sign in ((UPPER, 1.0), (LOWER, -1.0)):
            chosen = self.part == part
            x, z = points[chosen, 0], points[chosen, 2] - self.pivot
            cosine, sine = np.cos(sign * setting), np.sin(sign * setting)
            points[chosen, 0] = cosine * x - sine * z
            points[chosen, 2] = sine * x + cosine * z + self.pivot
        points[self.part == STRETCHED, 2] *= setting
        points[self.part == SHIFTED, 2] += setting
        return points


class Course(Struct, frozen=True, eq=False):
    """What an instrument does while it is seen.

    Attributes:
        kind: Name of its mesh.
        name: Of the tool; empty where the scene has none.
        size: Of one unit of the mesh [m].
        life: When it comes and goes [s].
        origin: Where it works [m], shape (moment, 3).
        axes: Unit vectors x, y and z of the mesh, shape (moment, 3, 3).
        setting: See ``InstrumentMesh.posed``, shape (moment,).
    """

    kind: str
    name: str
    size: float
    life: tuple[float, float]
    origin: Floats
    axes: Floats
    setting: Floats
