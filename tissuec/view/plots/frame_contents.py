"""What pictures of frames show beside the net: numbers as colours, instruments, held nodes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.palette import AMOUNT, INK, PAPER, STEEL, TENSION, WATER
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.model.network import Floats, Indices
from tissuec.results.instruments import JET, Course
from tissuec.results.instruments.meshes import mesh_of, placed
from tissuec.view.plots import net
from tissuec.view.plots.projection import Projection

if TYPE_CHECKING:
    from matplotlib.colors import Normalize

    from tissuec.results.trajectory import Trajectory
    from tissuec.view.plots.drawing import Axes

_UNKNOWN = 0.62  # grey, as on the page


class FrameNumbers(Struct, frozen=True, eq=False):
    """Numbers of springs or triangles in some frames.

    Attributes:
        trajectory: The result.
        name: Of the field; "tension" where none is named.
        label: What the numbers are, for the scale of colours.
        unit: Of the numbers; "" without one.
        shades: Between which their colours lie.
        norm: From numbers to colours.
        at_nodes: One number at each point by frame, NaN where it is unknown; none where
            springs have numbers of their own.
    """

    trajectory: "Trajectory"
    name: str
    label: str
    unit: str
    shades: tuple[str, ...]
    norm: "Normalize"
    at_nodes: dict[int, Floats]

    @classmethod
    def of_tension(cls, trajectory: "Trajectory", frames: Sequence[int]) -> Self:
        """Return the tensions of springs; edges of elements have none."""
        norm = net.tension_norm([trajectory.spring_force(frame)[0] for frame in frames])
        label = "tension of the springs"
        return cls(trajectory, "tension", label, "N", TENSION, norm, {})

    @classmethod
    def of(cls, trajectory: "Trajectory", name: str, frames: Sequence[int]) -> Self:
        """Return a field of pages.

        Args:
            name: Of the field.
            frames: Numbers of the frames, ascending.

        Raises:
            TissueError: The result has no such field.
        """
        from matplotlib.colors import Normalize

        from tissuec.results.moments import Moments
        from tissuec.view.player.drawn_nodes import DrawnNodes
        from tissuec.view.player.node_values import read_field
        from tissuec.view.player.options import Options
        from tissuec.view.player.reading import film_of

        film = film_of(Moments.of(trajectory, np.array(frames)), Options(cells=False))
        values = read_field(DrawnNodes(film, trajectory), name)
        rows = np.flatnonzero(~film.is_side)
        shades = TENSION if values.is_signed else AMOUNT
        norm, found = Normalize(values.low, values.high), values.value[rows]
        at_nodes = dict(zip(frames, found, strict=True))
        text, unit = values.field.text, values.field.unit
        return cls(trajectory, name, text, unit, shades, norm, at_nodes)

    def of_lines(self, frame: int) -> Floats:
        """Return the numbers of the lines in a frame, in the unit, shape (alive,)."""
        lines = self.trajectory.cells(frame).lines
        if self._is_of("spring"):
            numbers, found = (
                self.trajectory.shown(self.name, frame)[0],
                np.full(len(lines), np.nan),
            )
            found[: len(numbers)] = numbers  # edges of elements, which have none, come last
            return found
        return self.at_nodes[frame][lines].mean(axis=1)

    def of_triangles(self, frame: int) -> Floats:
        """Return the numbers of the triangles in a frame, in the unit, shape (triangle,)."""
        if self._is_of("triangle"):
            found = np.full(len(self.trajectory.cells(frame).triangles), np.nan)
            own = self.trajectory.shown(self.name, frame)[0]
            found[: len(own)] = own  # parts of elements, which have none, come last
            return found
        return self.at_nodes[frame][self.trajectory.cells(frame).triangles].mean(axis=1)

    def _is_of(self, at: str) -> bool:
        return any(one.name == self.name and one.at == at for one in self.trajectory.channels)

    @property
    def scale(self) -> AxisUnit:
        """Return the unit in which numbers are shown."""
        assert self.norm.vmax is not None
        return scale_of(self.unit, [self.norm.vmax]) if self.unit else PERCENT

    def colours(self, numbers: Floats) -> Any:
        """Return the colours of numbers in the unit, grey where unknown, shape (number, 4).

        Args:
            numbers: In the unit, NaN where they are unknown, shape (number,).
        """
        known = np.isfinite(numbers)
        found = net.colours_between(self.shades)(self.norm(np.where(known, numbers, 0.0)))
        found[~known, :3] = _UNKNOWN
        return found

    def said(self, every: Floats) -> dict[str, Any]:
        """Return the scale of colours: its norm, whether it extends further, and its label.

        Args:
            every: All numbers that are drawn, in the unit, shape (number,).
        """
        from matplotlib.colors import Normalize

        known = every[np.isfinite(every)]
        low, high = float(self.norm.vmin or 0.0), float(self.norm.vmax or 0.0)
        ends = bool((known < low).any()), bool((known > high).any())
        extend = {(False, False): "neither", (True, False): "min", (False, True): "max"}
        label = self.scale.label(self.label)
        if self.name == "tension" and not self.at_nodes:
            label += "; negative: compression"
        return {
            "norm": Normalize(float(self.scale.of(low)), float(self.scale.of(high))),
            "extend": extend.get(ends, "both"),
            "label": label,
        }


_SHOWN = 5.2  # units of instruments that belong to the picture, as on the page
_SOLID, _PALE = 0.45, 0.15  # opacity of instruments, and of planes, which are everywhere
_FIXED, _HELD = ("s", 2.6, PAPER), ("o", 2.8, STEEL)  # form, size [pt] and filling of marks


class SeenInstrument(NamedTuple):
    """An instrument at the moment of a row of its course."""

    course: Course
    row: int

    @property
    def reach(self) -> Floats:
        """Return points that must be in the picture [m], shape (point, 3)."""
        course, row = self
        if course.kind == "plane":
            return np.zeros((0, 3))
        if course.kind == "capsule":
            around = np.concatenate([np.eye(3), -np.eye(3)]) * course.size
            return np.concatenate([around + end for end in self.ends])
        far = 0.0 if course.kind in ("opening", JET) else _SHOWN * course.size
        return course.origin[row] + np.outer([0.0, far], course.axes[row, 2])

    @property
    def ends(self) -> Floats:
        """Return the ends of a rod with round ends [m], shape (2, 3)."""
        way = self.course.setting[self.row] * self.course.size * self.course.axes[self.row, 2]
        return self.course.origin[self.row] + np.outer([0.0, 1.0], way)

    def draw(self, axes: "Axes", view: Projection, scale: AxisUnit) -> None:
        """Draw it.

        Args:
            scale: Unit of the axes.
        """
        course = self.course
        if course.kind == "capsule":  # its outline is known exactly
            net.draw_tool(axes, scale.of(self.ends), float(scale.of(course.size)), view)
            return
        net.draw_silhouette(
            axes, scale.of(placed(course, self.row)), mesh_of(course.kind).triangles, view,
            colour=WATER if course.kind == JET else STEEL,
            opacity=_PALE if course.kind == "plane" else _SOLID,
        )  # fmt: skip


class FrameInstruments(Struct, frozen=True, eq=False):
    """Instruments and holds of a run.

    Attributes:
        trajectory: The run.
        courses: All instruments.
        row: Of each frame in these, shape (frame,).
    """

    trajectory: "Trajectory"
    courses: tuple[Course, ...]
    row: Indices

    @classmethod
    def of(cls, trajectory: "Trajectory") -> Self:
        """Return those of a result with frames."""
        # Files are opened when something is drawn, and not when kinds of plots are listed.
        from tissuec.results.instruments.courses import courses, solids
        from tissuec.results.moments import Moments

        moments = Moments.of(trajectory, np.arange(len(trajectory.times)))
        row = np.flatnonzero(moments.frames >= 0)
        return cls(trajectory, (*solids(moments), *courses(moments)), row)

    def at(self, frame: int) -> list[SeenInstrument]:
        """Return the instruments that are seen in a frame."""
        time, row = float(self.trajectory.times[frame]), int(self.row[frame])
        return [
            SeenInstrument(one, row)
            for one in self.courses
            if one.life[0] <= time < one.life[1]
        ]

    def held(self, frame: int) -> tuple[Indices, Indices]:
        """Return rows of nodes that are fixed, and that are held otherwise, shape (n,) each."""
        from tissuec.results.tools import FIX, with_ends

        time, shown = float(self.trajectory.times[frame]), self.trajectory.nodes
        none = np.zeros(0, dtype=np.int64)
        fixed, held = [none], [none]
        for hold, stop in with_ends(self.trajectory.holds):
            if hold.time <= time < stop:
                (fixed if hold.holder == FIX else held).append(hold.nodes)
        found = (np.flatnonzero(np.isin(shown, np.concatenate(some))) for some in (fixed, held))
        return next(found), next(found)

    def mark_held(
        self,
        frame: int,
        axes: "Axes",
        place: Floats,
        view: Projection,
        seen: NDArray[np.integer],
    ) -> None:
        """Mark nodes that are fixed by squares, and that are held otherwise by dots.

        Args:
            frame: Number of the frame.
            place: Of all nodes, in the unit of the axes, shape (node, 3).
            seen: Rows of the nodes that are drawn.
        """
        for nodes, (form, size, filling) in zip(self.held(frame), (_FIXED, _HELD), strict=True):
            shown = view.flat(place[np.intersect1d(nodes, seen)])
            if len(shown):
                axes.plot(
                    *shown.T, form, markersize=size, markerfacecolor=filling,
                    markeredgecolor=INK, markeredgewidth=0.4, zorder=2.5,
                )  # fmt: skip
