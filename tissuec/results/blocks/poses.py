"""Instruments as blocks, and where tools are in each frame, as numbers."""

from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tissuec.core.names import key_of
from tissuec.model.network import Floats, Indices
from tissuec.results.hdf5 import TEXT
from tissuec.results.instruments import JET, UPPER, Course
from tissuec.results.instruments.courses import courses, solids
from tissuec.results.instruments.meshes import mesh_of, placed
from tissuec.results.moments import Moments
from tissuec.results.store import describe
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


TOOL_POSES = "/tissuec/tools"

_NOWHERE = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])  # not turned, as quaternions say it


def write_poses(file: h5py.File, meshes: Sequence[ToolMesh], times: Floats) -> None:
    """Write where tools are, if there are any.

    Args:
        file: A blocks file.
        meshes: What is seen of each tool.
        times: Of the frames [s], shape (frame,).
    """
    if not meshes:
        return
    poses, group = ToolPoses.of(meshes, times), file.require_group(TOOL_POSES)
    names: Any = np.array([mesh.name for mesh in meshes], dtype=object)
    describe(group.create_dataset("name", data=names, dtype=TEXT), "", "name of each tool")
    for name, data, unit, text in (
        ("pose", poses.pose, "m",
         "where each tool works [m], and a quaternion x, y, z, w that turns the z axis into "
         "that of its shaft; shape (frame, tool, 7)"),
        ("opening", poses.opening, "rad",
         "angle between jaws or blades; 0 without any; shape (frame, tool)"),
        ("active", poses.active.astype("u1"), "",
         "1 where a tool is seen: it touches, holds, cuts or flows; shape (frame, tool)"),
    ):  # fmt: skip
        describe(group.create_dataset(name, data=data), unit, text)


class ToolPoses(Struct, frozen=True, eq=False):
    """Where tools are in each frame.

    Attributes:
        pose: Where each works [m], and how it is turned there: a quaternion x, y, z, w, which
            turns (0, 0, 1) into the direction of its shaft, shape (frame, tool, 7).
        opening: Angle between its jaws or blades [rad], shape (frame, tool); 0 without any.
        active: Whether it is seen: it touches, holds, cuts or flows, shape (frame, tool).
    """

    pose: Floats
    opening: Floats
    active: NDArray[np.bool_]

    @classmethod
    def of(cls, meshes: Sequence[ToolMesh], times: Floats) -> "ToolPoses":
        """Return those of some tools.

        Args:
            meshes: What is seen of each.
            times: Of the frames [s], shape (frame,).
        """
        shape = len(times), len(meshes)
        pose = np.tile(_NOWHERE, (*shape, 1))
        opening, active = np.zeros(shape), np.zeros(shape, dtype=bool)
        for tool, mesh in enumerate(meshes):
            some = np.array([bool(parts) for parts in mesh.variants])
            active[:, tool] = some[mesh.of_frame]
            shown = _shown(mesh, times)
            for number, part in enumerate(mesh.parts):
                frames = np.flatnonzero(shown == number)
                rows = mesh.row[frames]
                if not len(rows):
                    continue
                turn = Rotation.from_matrix(part.axes[rows].swapaxes(1, 2))
                pose[frames, tool, :3] = part.origin[rows]
                pose[frames, tool, 3:] = turn.as_quat()
                if (mesh_of(part.kind).part == UPPER).any():
                    opening[frames, tool] = 2.0 * part.setting[rows]
            pose[:, tool, 3:] = _continuous(pose[:, tool, 3:])
        return cls(pose, opening, active)


def _shown(mesh: ToolMesh, times: Floats) -> Indices:
    """Return the part that says where a tool is in each frame, -1 without any, shape (frame,).

    That is the first that is seen or, where none is, the last that was, or the first to come.
    """
    found = np.full(len(times), -1, dtype=np.int64)
    if not mesh.parts:
        return found
    begins = np.array([part.life[0] for part in mesh.parts])
    for frame, time in enumerate(times.tolist()):
        seen, before = mesh.variants[int(mesh.of_frame[frame])], begins <= time
        last = np.where(before, begins, -np.inf).argmax() if before.any() else begins.argmin()
        found[frame] = seen[0] if seen else last
    return found


def _continuous(turns: Floats) -> Floats:
    """Return quaternions, shape (frame, 4), each with the sign that is nearer to the last."""
    found = turns.copy()
    for frame in range(1, len(found)):
        if found[frame] @ found[frame - 1] < 0.0:
            found[frame] *= -1.0
    return found
