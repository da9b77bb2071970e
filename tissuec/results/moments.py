"""The moments of a result that a film is made of: frames, and both sides of events.

Rows are moments in the order of time. At an event, the net before it precedes the
net after it, at the same time, so that no event is between two rows.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.skin import BodySkin
from tissuec.model.network import Floats, Indices
from tissuec.results.fields import FieldChannel, magnitudes
from tissuec.results.frame_columns import MOTION, Numbers
from tissuec.results.mesh import Cells
from tissuec.results.volume_cells import mean_at

if TYPE_CHECKING:
    from tissuec.results.surface_table import SurfaceSeries
    from tissuec.results.trajectory import Trajectory

_NEAR = 1e-12  # of the duration: times that differ by less are one
_FRAME = 2  # rank at one time: behind the sides 0 and 1 of an event


class Moments(Struct, frozen=True, eq=False, dict=True):
    """Moments of a result, in order.

    Attributes:
        trajectory: The result.
        times: [s], shape (row,).
        frames: Number of the frame, or -1 for a side of an event, shape (row,).
        sides: Number of the side, or -1 for a frame, shape (row,).
    """

    trajectory: "Trajectory"
    times: Floats
    frames: Indices
    sides: Indices

    @classmethod
    def of(cls, trajectory: "Trajectory", chosen: Indices) -> Self:
        """Return some frames of a result, and the sides of all events between them.

        Args:
            trajectory: The result.
            chosen: Numbers of frames, ascending, shape (frame,).
        """
        times = trajectory.times[chosen]
        own = trajectory.sides.times
        sides = np.flatnonzero((own > times[0]) & (own <= times[-1]))
        sides = sides[: len(sides) // 2 * 2]
        placed = own[sides]
        # Frames at the time of an event show what is after it.
        near = _NEAR * float(trajectory.times[-1])
        nearest = np.clip(np.searchsorted(times, placed - near), 0, len(times) - 1)
        same = np.abs(times[nearest] - placed) <= near
        placed = np.where(same, times[nearest], placed)
        every = np.concatenate([times, placed])
        rank = np.concatenate([np.full(len(times), _FRAME), np.arange(len(sides)) % 2])
        order = np.lexsort((rank, every))
        none = -1
        frames = np.concatenate([chosen, np.full(len(sides), none)])
        numbers = np.concatenate([np.full(len(times), none), sides])
        return cls(trajectory, every[order], frames[order], numbers[order])

    def __len__(self) -> int:
        return len(self.times)

    def rows(self) -> Iterator[tuple[int, int, int]]:
        """Yield the number of each row, of its frame, and of its side."""
        return zip(range(len(self)), self.frames.tolist(), self.sides.tolist(), strict=True)

    def vectors(self, name: str, kept: Indices, kind: type[np.floating]) -> NDArray[Any]:
        """Return vectors at some points, shape (row, point, 3).

        Riding points have numbers in all rows, also before the cut that makes them.

        Args:
            name: "position" [m], "velocity" [m/s], or a field of vectors at nodes.
            kept: Rows of points in frames, shape (point,).
            kind: Type of the numbers.
        """
        found = np.empty((len(self), len(kept), 3), dtype=kind)
        for row in range(len(self)):
            found[row] = self._at_points(name, row)[kept]
        return found

    def _at_points(self, name: str, row: int) -> NDArray[Any]:
        """Return the numbers of a field at all points in a row, shape (point, …)."""
        frames, sides = self._arrays(name)
        frame, side = int(self.frames[row]), int(self.sides[row])
        mesh = self.trajectory.mesh
        every = sides[side][: len(mesh.nodes)] if frame < 0 else frames[frame]
        channels = (*MOTION, *self.trajectory.channels)
        return mesh.at_points(every, next(one for one in channels if one.name == name))

    def _arrays(self, name: str) -> tuple[Any, Any]:
        """Return the numbers at nodes in frames, and at sides of events."""
        trajectory = self.trajectory
        if name in ("position", "velocity"):
            return getattr(trajectory, name), getattr(trajectory.sides, name)
        return trajectory.fields[name], trajectory.sides.fields[name]

    def at_nodes(self, channel: FieldChannel, row: int) -> Floats:
        """Return one number at each point, NaN where it has none, shape (point,).

        That is the magnitude of vectors, and the mean of the springs, triangles or cells around
        a node, in the unit of the field.

        Args:
            row: Number of the row.
        """
        trajectory = self.trajectory
        mesh, nodes = trajectory.mesh, len(trajectory.nodes)
        if channel.at == "node":
            found = np.asarray(self._at_points(channel.name, row), dtype=float)
            return magnitudes(found) if channel.width > 1 else found
        numbers, items = self.shown(channel, row)
        if channel.at == "element":
            numbers = magnitudes(numbers) if channel.width > 1 else numbers
            return mesh.solids.at_nodes(numbers, self._cells(row).elements, mesh.points)
        if channel.at == "cell":
            assert trajectory.volume_cells is not None
            found = trajectory.volume_cells.at_nodes(numbers, trajectory.nodes)
        else:
            corners = trajectory.ends if channel.at == "spring" else trajectory.triangles
            found = mean_at(corners[items], numbers, nodes)
        return mesh.at_points(found, channel)

    def shown(self, channel: FieldChannel, row: int) -> tuple[Numbers, Indices]:
        """Return the numbers of springs, triangles or cells in a row, and whose they are.

        Args:
            channel: Of a field that is not about nodes.
            row: Number of the row.

        Returns:
            Numbers in the unit of the field, and rows of the recorded springs, triangles or
            cells, shape (shown,) each. Parts of elements have one row for each tetrahedron.
        """
        trajectory, frame, side = self.trajectory, int(self.frames[row]), int(self.sides[row])
        if frame >= 0 and channel.at != "cell":
            return trajectory.shown(channel.name, frame)
        if frame >= 0:
            every = np.asarray(trajectory.fields[channel.name][frame])
            return every, np.arange(len(every))
        every = np.asarray(trajectory.sides.fields[channel.name][side])
        there = np.arange(len(every))
        if channel.at == "spring":
            there = np.flatnonzero(trajectory.sides.alive(side)[trajectory.springs])
        elif channel.at in ("triangle", "element"):
            cells, mesh = self._cells(row), trajectory.mesh
            there = cells.faces if channel.at == "triangle" else mesh.items[cells.elements]
        return every[there], there

    def _cells(self, row: int) -> Cells:
        """Return the cells that exist in a row."""
        trajectory, frame = self.trajectory, int(self.frames[row])
        if frame >= 0:
            return trajectory.cells(frame)
        return trajectory.mesh.cells(trajectory.sides.alive(int(self.sides[row])))

    @cached_property
    def held(self) -> Indices:
        """Return rows in frames of the recorded nodes that are ever held, shape (node,)."""
        every = [np.zeros(0, dtype=np.int64), *(hold.nodes for hold in self.trajectory.holds)]
        return np.flatnonzero(np.isin(self.trajectory.nodes, np.concatenate(every)))

    @cached_property
    def _of_held(self) -> dict[str, Floats]:
        return {}

    def of_held(self, name: str, nodes: Indices) -> Floats:
        """Return vectors at some nodes that are ever held; files are read once for all.

        Args:
            name: As in ``vectors``, with the same units.
            nodes: Rows in frames, among ``held``, shape (node,).

        Returns:
            Shape (row, node, 3).
        """
        if name not in self._of_held:
            self._of_held[name] = self.vectors(name, self.held, np.float64)
        return self._of_held[name][:, np.searchsorted(self.held, nodes)]

    def vectors_in(self, name: str, row: int) -> Floats:
        """Return vectors at all recorded nodes in one row, shape (node, 3).

        Args:
            name: As in ``vectors``, with the same units.
            row: Number of the row.
        """
        found = self._at_points(name, row)[: len(self.trajectory.nodes)]
        return np.asarray(found, dtype=float)

    def tools(self) -> Floats:
        """Return the positions of the nodes of tools [m], shape (row, node, 3)."""
        tools, nodes = self.trajectory.tools, len(self.trajectory.nodes)
        if tools is None:
            return np.zeros((len(self), 0, 3))
        found = np.empty((len(self), tools.shape[1], 3))
        for row, frame, side in self.rows():
            found[row] = (
                tools[frame] if frame >= 0 else self.trajectory.sides.position[side][nodes:]
            )
        return found

    def tension(self, row: int) -> tuple[Numbers, Indices]:
        """Return the tensions of springs [N], and which they are, shape (alive,) each."""
        return self.shown(next(c for c in self.trajectory.channels if c.name == "tension"), row)

    def topologies(self) -> Iterator[tuple[int, Cells]]:
        """Yield the rows at which other cells are drawn than before, and these."""
        trajectory = self.trajectory
        last: Cells | None = None
        part, alive = -1, None
        for row, frame, side in self.rows():
            if frame >= 0:
                if trajectory.parts[frame] == part:
                    continue
                part = int(trajectory.parts[frame])
                cells = trajectory.cells(frame)
            else:
                now = trajectory.sides.alive(side)
                if alive is not None and np.array_equal(now, alive):
                    continue
                cells, alive = trajectory.mesh.cells(now), now
            if not cells.same_as(last):
                yield row, cells
                last = cells

    def surface(self, series: "SurfaceSeries") -> Iterator[tuple[int, Floats, Indices]]:
        """Yield the points [m] of a smooth surface at sides of events, and its triangles.

        Yields:
            The side, positions of shape (point, 3), and triangles of shape (triangle, 3).
        """
        network, sides = self.trajectory.network, self.trajectory.sides
        chosen = self.sides[self.sides >= 0].tolist()
        body = network.body_named(series.name)
        rows = np.arange(network.node_count)[body.nodes]
        shown = np.isin(rows, self.trajectory.nodes)
        if not chosen or not shown.all():
            return
        nodes = np.searchsorted(self.trajectory.nodes, rows)
        skin = BodySkin.of(network, body)
        smoothing = SURFACES[series.kind](**series.entries)
        made, last = None, None
        for side in chosen:
            present = skin.at(sides.alive(side))
            if made is None or last is None or not present.same_as(last):
                made, last = smoothing.refine(present), present
            position = np.asarray(sides.position[side][nodes], dtype=float)
            yield side, made.at(position[None])[0], made.triangles


def slopes(times: Floats, position: Floats) -> Floats:
    """Return velocities from differences [m/s], in the shape of ``position``.

    Between two rows with the same time, such as the sides of an event, none is taken.

    Args:
        times: Ascending [s], shape (row,).
        position: [m], shape (row, point, 3).
    """
    found = np.zeros_like(position)
    ends = [0, *(np.flatnonzero(np.diff(times) <= 0.0) + 1), len(times)]
    for start, stop in pairwise(ends):
        if stop - start > 1:
            own = slice(start, stop)
            found[own] = np.gradient(position[own], times[own], axis=0)
    return found


def curved(times: Floats, position: NDArray[Any], velocity: NDArray[Any]) -> NDArray[np.bool_]:
    """Return between which rows a cubic describes the motion, shape (row - 1,).

    It does where the mean of the velocities at both ends fits the way between them, and the way
    is not short beside them. Where the net vibrates faster than rows follow one another, a
    cubic would swing far beyond the motion.

    Args:
        times: Ascending [s], shape (row,).
        position: [m], shape (row, node, 3).
        velocity: [m/s], shape (row, node, 3).
    """
    found = np.zeros(max(0, len(times) - 1), dtype=bool)
    for row, step in enumerate(np.diff(times)):
        way = position[row + 1] - position[row]
        begin, end = step * velocity[row].astype(float), step * velocity[row + 1].astype(float)
        apart = np.abs(way - 0.5 * (begin + end)).sum()
        run, net = (np.abs(begin) + np.abs(end)).sum(), 2.0 * np.abs(way).sum()
        found[row] = step > 0.0 and apart <= _FITS * (run + net) and net >= _SHORT * run
    return found


#: Part of the size of ways and velocities by which they may differ. Motions with constant
#: acceleration differ by none; polynomials of degree 3 and 4, from rest, by 0.1 and 0.17.
_FITS = 0.25
#: Part of what the velocities alone would give: shorter ways are those of vibrations.
_SHORT = 0.2
