"""The section of bodies at some moments: regions in the colours of their tissues."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.palette import INK, STEEL
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.results.instruments.meshes import mesh_of, placed
from tissuec.view.player.bodies import capsules
from tissuec.view.player.cells import cut_solids, read_cells
from tissuec.view.player.lifetimes import lives
from tissuec.view.player.tints import node_tints, node_tissues
from tissuec.view.plots.frame_contents import FrameInstruments, SeenInstrument
from tissuec.view.plots.frame_reader import every_point
from tissuec.view.plots.over_time import say_unfinished
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject
from tissuec.view.section.cross_section import CrossSection, check_reach, cross_section, met
from tissuec.view.section.plane import SectionPlane

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.plots.drawing import Axes

WIDTH, TALLEST = 180.0, 150.0  # of a page [mm]
AROUND, BELOW = 14.0, 24.0  # of panels, for labels and the legend [mm]
_MARGIN = 0.06  # of the larger side
_MM2 = 1e-6  # [m²]


class SectionMoment(Struct, frozen=True, eq=False):
    """A section at a moment.

    Attributes:
        title: Of its panel.
        cut: The section of filled bodies.
        hollow: Where the plane meets the skins of other bodies [m], shape (segment, 2, 3).
        instruments: Where it meets instruments [m], shape (segment, 2, 3) each.
    """

    title: str
    cut: CrossSection
    hollow: Floats
    instruments: list[Floats]

    @property
    def borders(self) -> Floats:
        """Return all outlines [m], shape (segment, 2, 3)."""
        return np.concatenate([self.cut.borders, self.hollow])


def section_picture(
    subjects: Sequence[PlotSubject], plane: SectionPlane, titles: Mapping[int, str]
) -> Picture:
    """Return the picture of the sections of a result.

    Args:
        subjects: The result.
        titles: Frames, ascending, and the titles of their panels.

    Raises:
        TissueError: The plane meets nothing in one of the frames; says how far bodies reach.
    """
    trajectory: Trajectory = subjects[0].content
    names, tissue = node_tissues(trajectory)
    found, filled = _moments(trajectory, plane, titles)
    tints = node_tints(trajectory)[:, :3]
    colours = np.array([tints[tissue == k].mean(axis=0) for k in range(len(names))])
    flat = [one.borders @ plane.basis.T for one in found]
    ends = np.concatenate([one.reshape(-1, 2) for one in flat])
    size = float(np.ptp(ends, axis=0).max())
    low, high = ends.min(axis=0) - _MARGIN * size, ends.max(axis=0) + _MARGIN * size
    scale, count = scale_of("m", [size]), len(found)
    columns = min(count, 2 if count < 5 else 3)
    rows, shape = -(-count // columns), float((high - low)[1] / (high - low)[0])
    height = rows * min((WIDTH / columns - AROUND) * shape + AROUND, TALLEST) + BELOW
    hollow = [body.name for body in trajectory.network.bodies if body.name not in filled]
    verb = "is" if len(hollow) == 1 else "are"
    notes = (
        (f"{', '.join(hollow)} {verb} not filled: only the outline is drawn",) if hollow else ()
    )

    def draw(sheet: Canvas) -> None:
        grid = sheet.figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        panels = grid.ravel()
        for axes, one in zip(panels, found, strict=False):
            _draw_moment(axes, one, plane, scale, colours)
            left, right = scale.of((low[0], high[0]))
            bottom, top = scale.of((low[1], high[1]))
            axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
            if not len(one.borders):
                style = {"ha": "center", "va": "center", "color": INK}
                axes.text(
                    0.5, 0.5, "the plane meets nothing", transform=axes.transAxes, **style
                )
            areas = one.cut.areas(len(names)) / _MM2
            sheet.tell("areas_mm2", one.title, dict(zip(names, areas.tolist(), strict=True)))
        for axes in panels[count:]:
            axes.remove()
        _say_axes(list(panels[:count]), columns, plane, scale)
        there = np.unique(np.concatenate([one.cut.tissue for one in found]))
        _say_tissues(sheet, [names[int(k)] for k in there], colours[there])
        say_unfinished(sheet, subjects)

    return Picture(WIDTH, height, draw, notes)


def _moments(
    trajectory: "Trajectory", plane: SectionPlane, titles: Mapping[int, str]
) -> tuple[list[SectionMoment], tuple[str, ...]]:
    """Return the sections, and the names of the bodies that are filled."""
    names, tissue = node_tissues(trajectory)
    whole = np.ones(len(trajectory.lines), dtype=bool)
    alive = [
        np.isin(trajectory.lines, trajectory.cells(frame).line_numbers) for frame in titles
    ]
    changes = [(0.0, whole), *((1.0 + number, one) for number, one in enumerate(alive))]
    cells = read_cells(trajectory, changes, np.zeros(0), most=None)
    mesh = trajectory.mesh
    if mesh.cut is not None:
        shown = [
            np.isin(np.arange(len(mesh.solids)), trajectory.cells(f).elements) for f in titles
        ]
        there = lives(
            ((1.0 + number, one) for number, one in enumerate(shown)), len(mesh.solids)
        )
        cells = cells.joined(cut_solids(trajectory, there))
    solid = np.zeros(mesh.points, dtype=bool)
    solid[cells.tetrahedra] = True
    tools = FrameInstruments.of(trajectory)
    found: list[SectionMoment] = []
    for number, (frame, title) in enumerate(titles.items()):
        place = every_point(trajectory, frame)
        when = f"at {trajectory.clock.text(float(trajectory.times[frame]))}"
        check_reach(place[mesh.are_matter], plane, when)
        there = cells.there(1.0 + number)
        cut = cross_section(place, there, tissue, len(names), plane)
        triangles = trajectory.cells(frame).triangles
        skin = place[triangles[~solid[triangles].any(axis=1)]]
        hollow = met(skin, skin @ np.array(plane.normal) - plane.offset)
        seen = [_met_by(plane, one) for one in tools.at(frame)]
        found.append(SectionMoment(title, cut, hollow, [one for one in seen if len(one)]))
    if not any(len(one.borders) for one in found):
        raise TissueError(
            f"the plane {plane.text} meets no skin and no filled body; springs and threads "
            "have no section"
        )
    return found, cells.filled


def _met_by(plane: SectionPlane, instrument: SeenInstrument) -> Floats:
    """Return where a plane meets an instrument [m], shape (segment, 2, 3)."""
    course, row = instrument
    if course.kind == "capsule":  # finely, as circles
        first, second = instrument.ends[:, None]
        corners = capsules(first, second, np.array([course.size]), sides=60).corners
    else:
        corners = placed(course, row)[mesh_of(course.kind).triangles]
    return met(corners, corners @ np.array(plane.normal) - plane.offset)


def _draw_moment(
    axes: "Axes", one: SectionMoment, plane: SectionPlane, scale: AxisUnit, colours: Floats
) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    pieces, borders = (scale.of(part @ plane.basis.T) for part in (one.cut.pieces, one.borders))
    tints = colours[one.cut.tissue]
    # Edges of the same colour, lest the paper shows between pieces.
    axes.add_collection(
        PolyCollection(list(pieces), facecolors=tints, edgecolors=tints, linewidths=0.5)
    )
    axes.add_collection(LineCollection(list(borders), colors=INK, linewidths=0.8))
    for outline in one.instruments:
        lines = list(scale.of(outline @ plane.basis.T))
        axes.add_collection(LineCollection(lines, colors=STEEL, linewidths=1.4, gid="tool"))
    axes.set_title(one.title, fontsize=8.5)
    axes.grid(visible=False)


def _say_axes(
    panels: Sequence["Axes"], columns: int, plane: SectionPlane, scale: AxisUnit
) -> None:
    right, up = plane.labels
    for number, axes in enumerate(panels):
        axes.locator_params(nbins=5)
        if number % columns == 0:
            axes.set_ylabel(scale.label(up))
        if number + columns >= len(panels):
            axes.set_xlabel(scale.label(right))
            axes.tick_params(labelbottom=True)


def _say_tissues(sheet: Canvas, names: Sequence[str], colours: Floats) -> None:
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=tuple(colour), edgecolor=INK, linewidth=0.5, label=name)
        for name, colour in zip(names, colours, strict=True)
    ]
    if handles:
        sheet.figure.legend(
            handles=handles, loc="outside lower center", ncols=min(len(handles), 4)
        )
