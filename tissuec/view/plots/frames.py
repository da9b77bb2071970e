"""The net at some moments, side by side and from the same direction."""

import re
from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import Event
from tissuec.view.plots import PLOTS, net
from tissuec.view.plots.axes import SILENT, told
from tissuec.view.plots.frame_contents import FrameInstruments, FrameNumbers
from tissuec.view.plots.frame_reader import batches, drawn, every_point, no_frames
from tissuec.view.plots.options import Direction, Option, read_time
from tissuec.view.plots.over_time import say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.projection import (
    Mask,
    Projection,
    front_nodes,
    seen_springs,
    solid_nodes,
    viewpoint,
)
from tissuec.view.plots.subjects import PlotSubject
from tissuec.view.section import read_plane
from tissuec.view.section.plane import SectionPlane

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.plots.drawing import Axes

WIDTH, TALLEST = 180.0, 150.0  # of a page [mm]
TITLE, AROUND = 6.0, 16.0  # of each panel, and of the scale of colours [mm]
LINE, LETTER = 3.6, 1.6  # height and usual width of the letters of titles [mm]
LABELS = 4.0  # of axes, as far as they need more than is left around panels [mm]
USUAL = 4  # moments
MOST = 24
_MARGIN = 0.04  # of the larger side
_BARS = (1.0, 2.0, 5.0)
SHOWN = ("springs", "skin", "surface")
_UNIT = re.compile(r"(\d) (?=[a-zµ])")  # a number stays with its unit


class ChosenFrame(NamedTuple):
    """A frame and its title."""

    frame: int
    title: str


@PLOTS.member("frames")
class FramesPlot(Struct, frozen=True):
    """The net at some moments: springs coloured by tension, or skins in the light.

    Of solid bodies only the springs on the visible side are drawn. Instruments are
    silhouettes; squares mark fixed nodes, and dots nodes that are held otherwise.

    Attributes:
        times: When [s]; some moments that differ, from the first to the last, if none is named.
        view: Azimuth and elevation of who looks [deg]; chosen by the shape if None.
        section: A plane by which bodies are cut open, or its text; their outside if None.
        show: "springs", "skin", or "surface" for the smooth one of a scene.
        field: What colours springs or skins; the tension of springs if None.
    """

    takes: ClassVar[str] = "result"
    several: ClassVar[bool] = False

    times: Annotated[
        tuple[float, ...],
        Option(
            "The frame nearest to this time; may be repeated.", "TIME", read_time,
            ("--time", "--times"),
        ),
    ] = ()  # fmt: skip
    view: Direction = None
    show: Annotated[str, Option(f"Parts to show: {', '.join(SHOWN)}.", "|".join(SHOWN))] = (
        "springs"
    )
    field: Annotated[
        str | None,
        Option(
            "Colour springs or skins by this field, such as strain; springs by their tension "
            "if not given.",
            "FIELD",
        ),
    ] = None
    section: Annotated[
        SectionPlane | str | None,
        Option(
            'The section by a plane: "z = 6 mm", or "through (0, 0, 6) mm facing (0, 1, 1)".',
            "PLANE",
            read_plane,
        ),
    ] = None

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        """Return the picture of some frames.

        Raises:
            TissueError: ``show`` is unknown, or the result has no frames, skins or surfaces, or
                the plane meets nothing.
        """
        subject = subjects[0]
        trajectory: Trajectory = subject.content
        if self.show not in SHOWN:
            raise TissueError(f'"{self.show}" cannot be shown; there are: {", ".join(SHOWN)}')
        if not len(trajectory.times):
            raise no_frames(trajectory)
        if self.section is not None:
            plane = self.section
            return self._cut_open(
                read_plane(plane) if isinstance(plane, str) else plane, subjects
            )
        shown = Shown.of(self, trajectory)
        columns, height = shown.layout()

        def draw(sheet: Canvas) -> None:
            shown.draw(sheet, columns)
            say_unfinished(sheet, subjects)

        return Picture(WIDTH, height, draw, shown.notes)

    def _cut_open(
        self, section: SectionPlane | str, subjects: Sequence[PlotSubject]
    ) -> Picture:
        """Return the picture of a section."""
        from tissuec.view.section.section_frames import section_picture

        if self.view is not None or self.field is not None or self.show != "springs":
            what = "--field" if self.field is not None else "--show"
            what = "--from" if self.view is not None else what
            raise TissueError(f"a section always shows its regions from the front: omit {what}")
        plane = read_plane(section) if isinstance(section, str) else section
        trajectory: Trajectory = subjects[0].content
        chosen = moments(trajectory, self.times)
        return section_picture(subjects, plane, {one.frame: one.title for one in chosen})


def moments(trajectory: "Trajectory", times: Sequence[float]) -> list[ChosenFrame]:
    """Return frames by time; without times, some that differ in time and in motion.

    Raises:
        TissueError: There are too many.
    """
    known = trajectory.times
    if times:
        frames = [int(np.abs(known - wanted).argmin()) for wanted in times]
    else:
        frames = telling_frames(trajectory)
    frames = sorted(set(frames))
    if len(frames) > MOST:
        raise TissueError(
            f"{len(frames)} frames are too many for a page; at most {MOST} are possible"
        )
    titles: list[str] = []
    before = -np.inf
    for frame in frames:
        between = [
            event
            for event in trajectory.events
            if before < event.time <= known[frame]
            and event.kind not in SILENT
            and (event.time > 0.0 or known[frame] == 0.0)
        ]
        titles.append(_title(trajectory.clock, float(known[frame]), between))
        before = known[frame]
    return [ChosenFrame(frame, title) for frame, title in zip(frames, titles, strict=True)]


def _title(clock: AxisUnit, time: float, events: Sequence[Event]) -> str:
    """Return the title of a frame, with what happened since the frame before it, and when.

    Args:
        clock: Unit of times.
        time: Of the frame [s].
        events: Since the frame before it.
    """
    text = clock.text(time)
    if not events or time <= 0.0:
        return text
    first, last = events[0].time, events[-1].time
    when = f" at {clock.text(first)}"
    if last > first:
        when = f" from {clock.text(first)} to {clock.text(last)}"
    return f"{text}: {told(events)}{when if first < time else ''}"


def telling_frames(trajectory: "Trajectory") -> list[int]:
    """Return some frames, evenly spread over time and over the distance moved."""
    times, steps, last = trajectory.times, [np.zeros(1)], None
    if len(times) < 2:
        return [0]
    for position in batches(trajectory):
        whole = position if last is None else np.concatenate([last[None], position])
        steps.append(np.linalg.norm(np.diff(whole, axis=0), axis=2).max(axis=1, initial=0.0))
        last = position[-1]
    way = np.cumsum(np.concatenate(steps))
    along = (times - times[0]) / (times[-1] - times[0]) + (way / way[-1] if way[-1] else 0.0)
    wanted = np.linspace(float(along[0]), float(along[-1]), USUAL)
    return [int(np.abs(along - place).argmin()) for place in wanted]


class Shown(Struct, frozen=True, eq=False):
    """The drawable contents of a run, laid out.

    Attributes:
        points: Of each moment, what is drawn [m], shape (point, 3).
        box: From where to where it reaches on paper [m]: left, low, right, high.
        numbers: By which springs or skins are coloured; None where they are not.
        solid: Which nodes belong to bodies of which only the outside is drawn, shape (node,).
    """

    trajectory: "Trajectory"
    kind: str
    moments: list[ChosenFrame]
    view: Projection
    points: list[Floats]
    scale: AxisUnit
    box: tuple[float, float, float, float]
    numbers: FrameNumbers | None
    solid: Mask
    instruments: FrameInstruments
    notes: tuple[str, ...]

    @classmethod
    def of(cls, plot: FramesPlot, trajectory: "Trajectory") -> "Shown":
        """Read the drawable contents of a result.

        Raises:
            TissueError: Bodies have no skin, or the result has no smooth surface.
        """
        chosen = moments(trajectory, plot.times)
        points = [every_point(trajectory, m.frame) for m in chosen]
        home = drawn(trajectory)
        moved = [place[: len(home)] - home for place in points]
        view = Projection(*(plot.view or viewpoint(home, moved)))
        frames = [m.frame for m in chosen]
        numbers = (
            None if plot.field is None else FrameNumbers.of(trajectory, plot.field, frames)
        )
        instruments = FrameInstruments.of(trajectory)
        if plot.show == "surface":
            if numbers is not None:
                raise TissueError("smooth surfaces have no fields; show springs or skin")
            points = [_surface(trajectory, m.frame)[0] for m in chosen]
        elif plot.show == "skin":
            if not any(len(trajectory.cells(m.frame).triangles) for m in chosen):
                what = f'the bodies of "{trajectory.path}" have no skin'
                raise TissueError(f"{what}; show springs")
        elif numbers is None:
            numbers = FrameNumbers.of_tension(trajectory, frames)
        reached = [one.reach for m in chosen for one in instruments.at(m.frame)]
        matter = trajectory.mesh.are_matter
        places = points if plot.show == "surface" else [one[matter] for one in points]
        flat = view.flat(np.concatenate([*places, *reached]))
        low, high = flat.min(axis=0), flat.max(axis=0)
        margin = _MARGIN * float((high - low).max()) or 1e-3
        box = (*(low - margin), *(high + margin))
        scale = scale_of("m", [np.ptp(flat, axis=0).max()])
        solid = solid_nodes(trajectory.network)[trajectory.mesh.representatives]
        notes: tuple[str, ...] = ()
        if plot.show == "springs" and solid.any():
            notes = ("springs and edges inside and behind solid bodies are not drawn",)
        return cls(
            trajectory, plot.show, chosen, view, points, scale, box, numbers, solid,
            instruments, notes,
        )  # fmt: skip

    def layout(self) -> tuple[int, float]:
        """Return columns and the height of a page [mm] on which panels are large."""
        left, low, right, high = self.box
        shape, count = (high - low) / (right - left), len(self.moments)
        below = (AROUND if self.numbers else 4.0) + (LABELS if self.view.axes else 0.0)
        best = (0.0, 1, 0.0)
        for columns in range(1, count + 1):
            rows = -(-count // columns)
            lines = max(title.count("\n") for title in self._titles(columns))
            title = TITLE + LINE * lines
            width = min(WIDTH / columns, (TALLEST / rows - title) / shape)
            height = rows * (width * shape + title) + below
            # Large, without empty places, and rather wide than tall.
            full, flat = count / (rows * columns), min(1.0, 0.62 * WIDTH / height)
            worth = width * full**0.5 * flat**1.5
            best = max(best, (worth, columns, height))
        return best[1], max(best[2], 45.0)

    def _titles(self, columns: int) -> list[str]:
        """Return the titles of the moments, in lines that fit above so many columns."""
        letters = int(WIDTH / columns / LETTER)
        lines = (fill(_UNIT.sub("\\1\u00a0", one.title), letters) for one in self.moments)
        return [text.replace("\u00a0", " ") for text in lines]

    def draw(self, sheet: Canvas, columns: int) -> None:
        """Draw the panels in so many columns."""
        rows = -(-len(self.moments) // columns)
        grid = sheet.figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        panels = grid.ravel()
        moments = zip(panels, self.moments, self.points, self._titles(columns), strict=False)
        for axes, moment, points, title in moments:
            self._draw_moment(axes, moment, points)
            axes.set_title(title, fontsize=8.5)
        for axes in panels[len(self.moments) :]:
            axes.remove()
        self._say_lengths(list(panels[: len(self.moments)]), columns)
        if self.numbers is not None:
            drawn = list(panels[: len(self.moments)])
            _say_numbers(sheet, self.numbers, self._drawn_numbers(self.numbers), drawn)

    def _drawn_numbers(self, numbers: FrameNumbers) -> list[Floats]:
        return [
            numbers.of_triangles(moment.frame)
            if self.kind == "skin"
            else self._springs(numbers, moment, points)[0]
            for moment, points in zip(self.moments, self.points, strict=True)
        ]

    def _springs(
        self, numbers: FrameNumbers, moment: ChosenFrame, points: Floats
    ) -> tuple[Floats, Indices]:
        """Return the numbers of the springs that are drawn, and their rows."""
        cells, every = self.trajectory.cells(moment.frame), numbers.of_lines(moment.frame)
        rows = np.searchsorted(self.trajectory.lines, cells.line_numbers)
        ends, triangles = cells.lines, cells.triangles
        seen = seen_springs(ends, self.solid, points, triangles, self.view)
        return every[seen], rows[seen]

    def _draw_moment(self, axes: "Axes", moment: ChosenFrame, points: Floats) -> None:
        place, view, run = self.scale.of(points), self.view, self.trajectory
        cells = run.cells(moment.frame)
        drawn = np.zeros(0, dtype=np.int64)
        if self.kind == "surface":
            _, triangles = _surface(run, moment.frame)
            net.draw_skin(axes, place, triangles, view, rims=False)
        elif self.kind == "skin":
            own = None
            if self.numbers is not None:
                own = self.numbers.colours(self.numbers.of_triangles(moment.frame))[:, :3]
            net.draw_skin(axes, place, cells.triangles, view, rims=own is None, own=own)
            drawn = np.unique(cells.triangles)
        else:
            assert self.numbers is not None
            numbers, rows = self._springs(self.numbers, moment, points)
            wide = net.thread_springs(run.network)[run.lines[rows]]
            net.draw_springs(
                axes, place[run.ends[rows]], view, colours=self.numbers.colours(numbers),
                width=np.where(wide, 2.4, _line_width(len(rows))),
            )  # fmt: skip
            drawn = np.unique(run.ends[rows])
        if self.kind != "surface":
            net.draw_nodes(axes, place[cells.vertices[:, 0]], view)
            front = ~self.solid | front_nodes(points, cells.triangles, view)
            seen = drawn[front[drawn]]
            self.instruments.mark_held(moment.frame, axes, place, view, seen)
        for instrument in self.instruments.at(moment.frame):
            instrument.draw(axes, view, self.scale)
        left, low, right, high = self.scale.of(self.box)
        axes.set(xlim=(left, right), ylim=(low, high), aspect="equal")

    def _say_lengths(self, panels: Sequence["Axes"], columns: int) -> None:
        """Label the axes, or where they are none of space draw a bar of known length."""
        names = self.view.axes
        for number, axes in enumerate(panels):
            axes.grid(visible=False)
            if names is None:
                axes.axis("off")
                continue
            axes.locator_params(nbins=5)
            if number % columns == 0:
                axes.set_ylabel(self.scale.label(names[1]))
            if number + columns >= len(panels):
                axes.set_xlabel(self.scale.label(names[0]))
                axes.tick_params(labelbottom=True)
        if names is None:
            _draw_bar(panels[-1], self.scale, self.box)


def _line_width(springs: int) -> float:
    """Return the width of lines [pt]: thinner where there are many."""
    return float(np.clip(0.9 * (1500.0 / max(springs, 1)) ** 0.35, 0.15, 1.2))


def _draw_bar(axes: "Axes", scale: AxisUnit, box: tuple[float, float, float, float]) -> None:
    """Draw a bar of a round length below the right end of a panel."""
    left, low, right, _ = scale.of(box)
    wanted = 0.2 * (right - left)
    power = 10.0 ** np.floor(np.log10(wanted))
    length = power * max(step for step in _BARS if step * power <= wanted * (1 + 1e-9))
    ends = right - length, right
    (line,) = axes.plot(ends, [low, low], color=INK, linewidth=2.0, clip_on=False)
    line.set_solid_capstyle("butt")
    line.set_gid("bar")
    axes.annotate(
        f"{length:g} {scale.unit}", (sum(ends) / 2, low), xytext=(0, -3),
        textcoords="offset points", ha="center", va="top", fontsize=7.5, annotation_clip=False,
    )  # fmt: skip


def _say_numbers(
    sheet: Canvas, numbers: FrameNumbers, drawn: list[Floats], panels: list["Axes"]
) -> None:
    from matplotlib.cm import ScalarMappable

    every = np.concatenate([np.zeros(0), *drawn])
    if not np.isfinite(every).any():
        return
    said = numbers.said(every)
    colours: Any = ScalarMappable(said["norm"], net.colours_between(numbers.shades))
    bar = sheet.figure.colorbar(
        colours, ax=panels, location="bottom", shrink=0.5, aspect=40, pad=0.03,
        extend=said["extend"],
    )  # fmt: skip
    bar.set_label(said["label"])
    bar.outline.set_visible(False)


def _surface(trajectory: "Trajectory", frame: int) -> tuple[Floats, Any]:
    """Return points and triangles of all smooth surfaces at the time of a frame."""
    if not trajectory.surfaces:
        bodies = trajectory.network.bodies
        raise TissueError(
            f'"{trajectory.path}" has no smooth surfaces; write output {{ surface of '
            f"{bodies[0].name if bodies else 'BODY'} every 40 ms }} into the scene and run it "
            "again, or show the skin"
        )
    points: list[Floats] = []
    triangles: list[Any] = []
    count = 0
    for series in trajectory.surfaces.values():
        if len(series):
            number = int(np.abs(series.times - trajectory.times[frame]).argmin())
            points.append(np.asarray(series.position(number), dtype=float))
            triangles.append(series.triangles(number) + count)
            count += len(points[-1])
    return np.concatenate(points), np.concatenate(triangles)
