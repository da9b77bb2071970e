"""The drawable contents of a result, as arrays, in its frames and between them.

Moments within a run are counted in *frames*: 2.5 lies halfway between the frames 2 and 3. What
is there for a while only, such as a spring that is cut, has a *life*: the frames from which on,
and until which, it is there. A spring that comes back, as a knot does after it has slipped, is
several of them.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.scale import AxisUnit, scale_of
from tissuec.model.network import Floats, Indices
from tissuec.view.player.cells import SolidCells
from tissuec.view.player.lifetimes import Lifetimes, Timeline, is_there

#: Fields of frames that films contain as what is drawn: arrows and colours of springs.
DRAWN = ("force", "tension")
SURE = 0.98  # of all numbers: scales of colours and arrows end there


class Lines(Struct, frozen=True, eq=False):
    """Springs; one that returns is listed more than once.

    Attributes:
        ends: Shape (line, 2).
        life: In frames, shape (line, 2).
        tension: [N], shape (frame, line); the last one known where it is not there.
        rest: Rest length before the run [m], shape (line,); 0 where it has none.
        law: Number among the laws, shape (line,).
        radius: Of threads and stitches [m], shape (line,); 0 of other springs.
        stitch: Whether it is of a joint, shape (line,): these cross gaps between skins, so they
            are drawn like threads while springs are hidden.
        bears: Whether it can bear a force, shape (line,); edges of elements do not.
        number: Network number of the spring or edge, or of one of those that the line
            represents, ascending, shape (line,).
    """

    ends: Indices
    life: Floats
    tension: NDArray[np.float32]
    rest: Floats
    law: Indices
    radius: Floats
    stitch: NDArray[np.bool_]
    bears: NDArray[np.bool_]
    number: Indices


class SkinPiece(Struct, frozen=True, eq=False):
    """Triangles of the net.

    Attributes:
        triangles: Shape (triangle, 3).
        life: In frames, shape (triangle, 2).
        smooth: Whether a smooth surface shows the same, shape (triangle,).
        hollow: Whether their back is the inside of an organ, shape (triangle,).
    """

    triangles: NDArray[np.integer]
    life: Floats
    smooth: NDArray[np.bool_]
    hollow: NDArray[np.bool_]


class SurfacePiece(Struct, frozen=True, eq=False):
    """A smooth surface while its triangles stay the same.

    Attributes:
        frames: Of the film, where each set of points belongs, shape (moment,).
        triangles: Shape (triangle, 3).
        position: [m], shape (moment, point, 3).
        tint: Red, green, blue and gloss, from 0 to 1, shape (4,).
    """

    frames: Floats
    triangles: Indices
    position: NDArray[Any]
    tint: Floats


class ToolSolid(Struct, frozen=True):
    """A shape of a tool.

    Attributes:
        kind: "capsule", "plane" or "opening".
        radius: [m].
        points: The two points that carry it.
        name: Of the tool.
    """

    kind: str
    radius: float
    points: tuple[int, int]
    name: str


class HeldTissue(Struct, frozen=True, eq=False):
    """Fixed and held parts of the net.

    Attributes:
        patches: When each triangle of the skin is held at all corners, in frames, the longest
            time; 0 and 0 for never, shape (triangle, 2).
        rods: Ends of springs between held nodes outside of patches, or single nodes twice,
            without those that drawn instruments hold, shape (rod, 2).
        life: Of rods, in frames, shape (rod, 2).
        rims: Ends of the edges around patches, shape (rim, 2).
        rim_life: Of these, in frames, shape (rim, 2).
    """

    patches: Floats
    rods: Indices
    life: Floats
    rims: Indices
    rim_life: Floats


class Instrument(Struct, frozen=True):
    """An instrument that is drawn with a shape of its own.

    Attributes:
        kind: Name of its mesh, see ``mesh_of``.
        name: Of the tool; empty where the scene has none.
        size: Of one unit of the mesh [m].
        life: In frames.
        points: Four points that carry it: its origin, and those at ``size`` from it along its z
            and x, and at ``size`` times its setting along z.
    """

    kind: str
    name: str
    size: float
    life: tuple[float, float]
    points: tuple[int, int, int, int]


class Resultant(Struct, frozen=True, eq=False):
    """A force on tissue at one place, by a tool, a set that is held, or a fixed part.

    Attributes:
        name: Of the tool or set.
        point: The point at which it acts.
        life: In frames.
        force: [N], shape (frame, 3).
    """

    name: str
    point: int
    life: tuple[float, float]
    force: Floats

    @property
    def scale(self) -> AxisUnit:
        """Return the unit in which it is shown."""
        return scale_of("N", [np.linalg.norm(self.force, axis=1)])


MOST_FACES = 60_000
"""Faces of skin that is rounded."""


class PlayerData(Struct, frozen=True, eq=False):
    """All moving objects.

    Attributes:
        times: Of the frames [s], shape (frame,).
        clock: The unit in which times are shown.
        position: Of all points [m], shape (frame, point, 3): nodes, and after them those of
            tools.
        velocity: Of all points [m/s], shape (frame, point, 3).
        curved: Between which frames a cubic describes the motion, shape (frame - 1,).
        is_side: Which frames are beside an event, shape (frame,).
        force: Sum of the spring forces on each node [N], shape (frame, node, 3).
        fields: One number at each node by further fields of frames, in their units, NaN where
            they are unknown, shape (frame, node).
        lines: Springs.
        skin: Triangles of the net, with the caps of filled bodies that are cut or torn.
        cells: What filled bodies consist of.
        tints: Red, green, blue and gloss at each node, from 0 to 1, shape (node, 4).
        tissue: Number of the tissue of each node, shape (node,).
        tissues: Names of the tissues.
        dots: Nodes that nothing touches, for a while, shape (dot,), and their lives.
        held: What is held.
        solids: Shapes of tools.
        instruments: What is drawn of tools besides.
        resultants: Forces on tissue by whatever holds or touches it.
        surfaces: Smooth surfaces, a list of pieces for each body.
        laws: Names of the laws.
        recorded: How many nodes, springs and edges of elements the file shows.
        numbers: Network numbers of the nodes, ascending, shape (node,). Riding points, which
            follow nodes of the network, count as nodes here.
        matter: Which nodes are places of matter: all but those on the far side of a cut.
    """

    times: Floats
    clock: AxisUnit
    position: NDArray[Any]
    velocity: NDArray[np.float32]
    curved: NDArray[np.bool_]
    is_side: NDArray[np.bool_]
    force: NDArray[Any]
    fields: Mapping[str, NDArray[np.float32]]
    lines: Lines
    skin: SkinPiece
    cells: SolidCells
    tints: Floats
    tissue: Indices
    tissues: tuple[str, ...]
    dots: Lifetimes
    held: HeldTissue
    solids: tuple[ToolSolid, ...]
    instruments: tuple[Instrument, ...]
    resultants: tuple[Resultant, ...]
    surfaces: dict[str, list[SurfacePiece]]
    laws: tuple[str, ...]
    recorded: tuple[int, int, int]
    numbers: Indices
    matter: Indices | slice

    def time_at(self, at: float) -> float:
        """Return the time [s] of a moment in frames."""
        return float(np.interp(at, np.arange(len(self.times)), self.times))

    def moment_at(self, time: float) -> float:
        """Return the moment, in frames, of a time [s]; those outside are at an end."""
        return float(Timeline(self.times).frame_of(np.clip(time, *self.times[[0, -1]])))

    @property
    def divisions(self) -> int:
        """Return into how many parts each edge of the skin is divided to make it round."""
        count = len(self.skin.triangles)
        return next((n for n in (8, 4, 2) if n * n * count <= MOST_FACES), 1)

    def shows_springs(self, colour: str | None) -> bool:
        """Return whether springs are drawn at first: by a colour, or where no skin is."""
        return bool(len(self.lines.ends)) and (colour is not None or not self.has_skin)

    @property
    def has_skin(self) -> bool:
        return bool(len(self.skin.triangles) or self.surfaces)

    @property
    def frame_count(self) -> int:
        """Return how many frames there are, without the sides of events."""
        return int(np.count_nonzero(~self.is_side))

    @property
    def is_curved(self) -> NDArray[np.bool_]:
        """Return at which frames velocities are needed, shape (frame,)."""
        return np.append(self.curved, False) | np.append(False, self.curved)

    @property
    def node_count(self) -> int:
        """Return how many of the points are nodes."""
        return self.force.shape[1]

    def strain(self, frame: int) -> Floats:
        """Return elongation over rest length of each line, dimensionless, shape (line,).

        It is 0 for a line without rest length.
        """
        first, second = self.position[frame][self.lines.ends.T]
        length = np.linalg.norm(second - first, axis=1)
        rest = self.lines.rest
        return np.where(rest > 0.0, length / np.where(rest > 0.0, rest, 1.0) - 1.0, 0.0)

    def alive(self, frame: float) -> NDArray[np.bool_]:
        """Return which lines are there, shape (line,)."""
        return is_there(self.lines.life, frame)

    @property
    def most_tension(self) -> float:
        """Return the end of the colour scale of tensions [N]; larger ones look alike."""
        bears = self.lines.bears
        return usual_end(
            np.abs(row[self.alive(frame) & bears])
            for frame, row in enumerate(self.lines.tension)
        )

    @property
    def most_strain(self) -> float:
        """Return where the colours of strain end."""
        frames = range(0, len(self.times), max(1, len(self.times) // 20))
        return usual_end(np.abs(self.strain(frame)[self.alive(frame)]) for frame in frames)

    @property
    def most_resultant(self) -> float:
        """Return the largest resultant force of all [N]."""
        sizes = (np.linalg.norm(one.force, axis=1).max(initial=0.0) for one in self.resultants)
        return float(max(sizes, default=0.0))

    @property
    def most_force(self) -> float:
        """Return the size of force that has the longest arrow but for outliers [N]."""
        return usual_end(np.linalg.norm(row, axis=1) for row in self.force)


def usual_end(rows: Iterable[NDArray[Any]]) -> float:
    """Return the 98 % quantile of each row; 0 if it is not positive.

    It is rounded up to two digits.

    Args:
        rows: In one unit, of any shape.
    """
    tops = [float(np.quantile(row, SURE)) for row in rows if len(row)]
    most = max(tops, default=0.0)
    if not most > 0.0:
        return 0.0
    digits = 1 - int(np.floor(np.log10(most)))
    return round(float(np.ceil(most * 10.0**digits - 1e-9)) / 10.0**digits, digits)


class InterpolatedFrame(Struct, frozen=True, eq=False):
    """A film between two of its frames.

    Attributes:
        at: In frames.
        position: Of all points [m], shape (point, 3).
        force: On nodes [N], shape (node, 3).
        tension: Of lines [N], shape (line,).
        strain: Of lines, shape (line,).
    """

    at: float
    position: Floats
    force: Floats
    tension: Floats
    strain: Floats

    @classmethod
    def of(cls, film: PlayerData, at: float) -> "InterpolatedFrame":
        """Return the content of a film at a number of frames."""
        first = int(at)
        second, part = min(first + 1, len(film.times) - 1), at - first

        def between(numbers: NDArray[Any]) -> Floats:
            return (1.0 - part) * numbers[first] + part * numbers[second]

        position = position_at(film, at)
        ends, rest = film.lines.ends, film.lines.rest
        length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
        stretch = length / np.where(rest > 0.0, rest, np.inf) - 1.0
        strain = np.where(rest > 0.0, stretch, 0.0)
        return cls(at, position, between(film.force), between(film.lines.tension), strain)


def position_at(film: PlayerData, at: float) -> Floats:
    """Return the positions of all points at a number of frames [m], shape (point, 3).

    Between two frames they follow the cubic through the positions and velocities of both, or
    a straight line where the motion is too fast for that.
    """
    first = int(at)
    second, part = min(first + 1, len(film.times) - 1), at - first
    straight = (1.0 - part) * film.position[first] + part * film.position[second]
    if first == second or not film.curved[first]:
        return straight
    step = float(film.times[second] - film.times[first])
    way = film.position[second] - film.position[first]
    begin, end = step * film.velocity[first : second + 1].astype(float)
    left = 1.0 - part
    return straight + part * left * (left * (begin - way) + part * (way - end))


def surface_at(pieces: list[SurfacePiece], at: float) -> tuple[SurfacePiece, Floats]:
    """Return the visible piece of a smooth surface, and its points [m], shape (point, 3).

    Args:
        at: Moment, in frames.
    """
    piece = [one for one in pieces if one.frames[0] <= at + 1e-6 or one is pieces[0]][-1]
    place = float(np.interp(at, piece.frames, np.arange(len(piece.frames))))
    first = int(place)
    second = min(first + 1, len(piece.frames) - 1)
    part = place - first
    return piece, (1.0 - part) * piece.position[first] + part * piece.position[second]
