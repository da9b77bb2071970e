"""Instruments as blocks: all that is seen of a tool, as triangles."""

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.names import key_of
from tissuec.model.network import Floats, Indices
from tissuec.results.instruments import JET, Course
from tissuec.results.instruments.courses import courses, solids
from tissuec.results.instruments.meshes import mesh_of, placed
from tissuec.results.moments import Moments
from tissuec.results.trajectory import Trajectory


class ToolMesh(Struct, frozen=True, eq=False):
    """All that is seen of a tool.

    Attributes:
        name: Of the tool or jet, or what it is where the scene names none.
        parts: Its shapes and instruments.
        row: Of each frame, in the courses of the parts, shape (frame,).
        variants: Which parts are seen together.
        of_frame: Which of these in each frame, shape (frame,).
    """

    name: str
    parts: tuple[Course, ...]
    row: Indices
    variants: tuple[tuple[int, ...], ...]
    of_frame: Indices

    def size(self, variant: int) -> int:
        """Return how many points a variant has."""
        return sum(len(mesh_of(self.parts[n].kind).vertices) for n in self.variants[variant])

    def triangles(self, variant: int) -> Indices:
        """Return the corners of the triangles of a variant, shape (triangle, 3)."""
        found, first = [np.zeros((0, 3), dtype=np.int64)], 0
        for number in self.variants[variant]:
            mesh = mesh_of(self.parts[number].kind)
            found.append(mesh.triangles + first)
            first += len(mesh.vertices)
        return np.concatenate(found)

    def at(self, frame: int) -> Floats:
        """Return the points in a frame [m], shape (point, 3)."""
        shown = self.variants[int(self.of_frame[frame])]
        row = int(self.row[frame])
        return np.concatenate([np.zeros((0, 3)), *(placed(self.parts[n], row) for n in shown)])


def tool_meshes(trajectory: Trajectory, tools: Mapping[str, str]) -> Sequence[ToolMesh]:
    """Return the meshes of all tools, followed by those of jets and scalpels.

    Args:
        trajectory: A result with frames.
        tools: Kinds of the tools of its scene by name, as far as they are known.
    """
    moments = Moments.of(trajectory, np.arange(len(trajectory.times)))
    row = np.flatnonzero(moments.frames >= 0)
    names = [*dict.fromkeys([*(tool.name for tool in trajectory.network.tools), *tools])]
    groups: dict[str, tuple[str, list[Course]]] = {key_of(name): (name, []) for name in names}
    for course in (*solids(moments), *courses(moments)):
        name = f"{course.name} jet" if course.kind == JET else course.name or course.kind
        groups.setdefault(key_of(name), (name, []))[1].append(course)
    return [_mesh(name, parts, row, trajectory.times) for name, parts in groups.values()]


def _mesh(name: str, parts: Sequence[Course], row: Indices, times: Floats) -> ToolMesh:
    seen = [
        tuple(n for n, part in enumerate(parts) if part.life[0] <= time < part.life[1])
        for time in times.tolist()
    ]
    variants = tuple(dict.fromkeys(seen))
    of_frame = np.array([variants.index(one) for one in seen], dtype=np.int64)
    return ToolMesh(name, tuple(parts), row, variants, of_frame)
