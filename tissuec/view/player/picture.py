"""A moment of a run as a picture, drawn without a browser.

Camera, colours and light are those of the page (``web/shared.glsl``, ``web/stage.js``).
"""

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.core.scale import scale_of
from tissuec.model.network import Floats, Indices
from tissuec.view.player.bodies import (
    TriangleMesh,
    across,
    arrows,
    bulges,
    capsules,
    lit,
    rounded,
    smooth_mesh,
    spread,
)
from tissuec.view.player.camera import (
    Camera,
    fitted,
    framing,
    half_height,
    outermost,
)
from tissuec.view.player.field_colours import between_rows, field_colours, readable
from tissuec.view.player.film import PlayerData, Resultant, ToolSolid
from tissuec.view.player.legends import draw_field_legend, draw_spring_legend
from tissuec.view.player.lifetimes import Mask, is_there
from tissuec.view.player.moment import InterpolatedFrame, position_at, surface_at
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Colour, Options
from tissuec.view.player.pace import near
from tissuec.view.player.posing import posed
from tissuec.view.player.projected import ProjectedTriangles
from tissuec.view.player.strokes import dashed, ramp, rgb
from tissuec.view.player.tints import SHINE
from tissuec.view.plots.page import need_matplotlib
from tissuec.view.plots.projection import viewpoint
from tissuec.view.section.caps import at_cap, cap, rims
from tissuec.view.section.film_section import section
from tissuec.view.section.plane import SectionPlane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissuec.view.player.raster import Raster

DPI = 100
_USUAL = 1000  # [px]: of a picture, in which lines are as wide as on the page
REACH = 0.18  # of the picture: how long the arrow of the largest resultant force is
LEAST = 0.005  # of it: what is smaller has no arrow
HELD = 0.75  # of the colour of tools, on skin that is held
_PALER = 0.4  # skin under springs, whose colours say something
_RIM = 1.2  # [px]: width of outlines in a section
_NEARER = 1.2e-3  # of the size: by which lines lie on the skin
SHORTEST = 3.0  # thicknesses of an arrow that is drawn; shorter ones are specks
LONGEST = 4.0  # times the scale of forces: arrows of outliers end there, as on the page
_PRESSED = 0.12  # of the scale: from which pressure on springs are dashed


class Painter:
    """Draws moments of a film into one figure.

    Args:
        film: What there is.
        options: How it is seen.
        size: Width and height [px].
        title: Above the picture.
        forces: Whether forces on nodes are drawn.
        field: What colours the skin; its tissues if None.
    """

    def __init__(
        self,
        film: PlayerData,
        options: Options,
        size: tuple[int, int],
        title: str,
        *,
        forces: bool = False,
        field: FieldValues | None = None,
    ):
        self.film, self.size, self.title, self.forces = film, size, title, forces
        self.field = field
        self.framing = framing(film)
        self._reach = self.framing.size / 8.0 / (film.most_force or 1.0)
        points = self.framing.points
        angles = options.view or viewpoint(points)
        if forces:
            points = np.concatenate([points, *self._tips()])
        self.home = self.camera = fitted(points, *angles, size[0] / size[1])
        self.options = options
        self.colour: Colour = options.colour or "tension"
        self._most = {"tension": film.most_tension, "strain": film.most_strain, "law": 1.0}
        self.shows_springs = film.shows_springs(options.colour)
        # Cut faces end at the flat triangles of the net.
        self._opens = options.section is not None and len(film.cells.tetrahedra) > 0
        is_plain = self.shows_springs and not self._colours_skin
        self._divisions = 1 if is_plain or self._opens else film.divisions
        # Smooth surfaces have no nodes, at which fields are known.
        self._shows_net = self.shows_springs or self._opens or field is not None
        rests = film.lines.rest[film.lines.rest > 0.0]
        mean = float(rests.mean()) if len(rests) else self.framing.size / 20.0
        self._dash = mean / 3.5
        self.marker = min(0.009 * self.framing.size, 0.16 * mean)

    @cached_property
    def figure(self) -> "Figure":
        """The figure that is drawn into; its canvas keeps pixels.

        Raises:
            TissueError: matplotlib is not installed.
        """
        need_matplotlib()
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(self.size[0] / DPI, self.size[1] / DPI), dpi=DPI)
        FigureCanvasAgg(figure)
        return figure

    @property
    def _colours_skin(self) -> bool:
        """Whether the colours of the skin are those of a field."""
        return self.field is not None and bool(len(self.film.skin.triangles))

    @property
    def _colours_springs(self) -> bool:
        """Whether those of springs are, as there is no skin."""
        return self.field is not None and not self._colours_skin

    def draw(self, at: float) -> "Figure":
        """Draw a moment, in frames, in the place of the former one."""
        self.figure.clear()
        figure: Any = self.figure
        sheet = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        sheet.axis("off")
        width, height = self.size
        sheet.imshow(self.scene(at), extent=(0, width, 0, height), aspect="auto")
        sheet.set(xlim=(0, width), ylim=(0, height))
        self._annotate(sheet, at, self.film.time_at(at))
        return self.figure

    def pixels(self, at: float) -> NDArray[np.uint8]:
        """Return a moment of a film as pixels, shape (height, width, 3)."""
        self.draw(at)
        canvas: Any = self.figure.canvas
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def scene(self, at: float) -> NDArray[np.uint8]:
        """Return the picture without what is written on it, shape (height, width, 3)."""
        from tissuec.view.player.raster import Raster

        moment = InterpolatedFrame.of(self.film, at)
        self.camera = self._following(at)
        raster = Raster(self.size, rgb(palette.PAPER))
        for shapes in self._solid(moment):
            self._rasterise(raster, shapes, hides=True)
        planes = (solid for solid in self.film.solids if solid.kind == "plane")
        for shapes in (self._plane(moment, one) for one in planes):
            self._rasterise(raster, shapes, hides=False)
        return raster.pixels()

    def _rasterise(self, raster: "Raster", shapes: ProjectedTriangles, *, hides: bool) -> None:
        depth = self.camera.distance - shapes.corners[..., 2]
        ahead = (depth > 0.02 * self.camera.distance).all(axis=1)
        scale = self.size[1] / 2.0 / half_height(self.camera.aspect)
        depth = depth[ahead][..., None]
        flat = np.array(self.size) / 2.0 + scale * shapes.corners[ahead, :, :2] / depth
        corners = np.concatenate([flat, 1.0 / depth], axis=2)
        raster.draw(corners, shapes.colour[ahead], shapes.opacity[ahead], hides=hides)

    def _following(self, at: float) -> Camera:
        """Return the camera, which follows where the film asks for that."""
        if not self.framing.follows:
            return self.home
        frames = np.arange(len(self.film.times))
        middle = self.framing.middle.T
        shift = [float(np.interp(at, frames, np.asarray(middle[axis]))) for axis in range(3)]
        return replace(self.home, target=self.home.target + shift)

    def _pixel(self, length: float) -> float:
        """Return how many pixels a length [m] has at the target."""
        seen = half_height(self.home.aspect) * self.home.distance
        return length * self.size[1] / 2.0 / seen

    def _solid(self, moment: InterpolatedFrame) -> Iterator[ProjectedTriangles]:
        """Yield all that hides what is behind it."""
        film, at = self.film, moment.at
        skin = film.skin
        shown = is_there(skin.life, at) & ~(skin.smooth & (not self._shows_net))
        tint = film.tints[skin.triangles[shown]]
        held = is_there(film.held.patches, at)[shown, None, None]
        tint[..., :3] += HELD * held * (rgb(palette.STEEL) - tint[..., :3])
        triangles = skin.triangles[shown]
        mesh = smooth_mesh(moment.position, triangles)
        bulge = bulges(moment.position, triangles, mesh) * (not self.shows_springs)
        mesh, weights = rounded(mesh, bulge, self._divisions)
        if self.field is not None:
            numbers = between_rows(self.field, at)[triangles, None]
            yield self._behind(self._coloured_skin(mesh, spread(numbers, weights)[..., 0]))
        else:
            hollow = np.repeat(skin.hollow[shown], len(weights))
            yield self._behind(self._skin(mesh, spread(tint, weights), hollow))
        for pieces in film.surfaces.values() if not self._shows_net else ():
            piece, position = surface_at(pieces, at)
            mesh = smooth_mesh(position, piece.triangles)
            tint = np.broadcast_to(piece.tint, (*mesh.corners.shape[:2], 4))
            yield self._behind(self._skin(mesh, tint, np.ones(len(tint), dtype=bool)))
        yield from self._caps(at)
        for mesh, colour in self._tools(moment):
            yield self._body(mesh, rgb(colour), 0.25)
        for mesh, colour in self._nodes(moment):
            yield self._behind(self._body(mesh, rgb(colour), 0.25))
        if self.forces:
            yield self._body(self._arrows(moment), rgb(palette.SERIES[2]), 0.1)
        if self.shows_springs:
            yield self._behind(self._springs(moment, is_there(film.lines.life, at)))

    @property
    def _section(self) -> SectionPlane | None:
        """Return the plane of the section, with its front to the eye."""
        plane, camera = self.options.section, self.camera
        return plane and plane.towards(camera.target + camera.distance * camera.axes[2])

    def _behind(self, shapes: ProjectedTriangles) -> ProjectedTriangles:
        """Return the parts that are not in front of the plane of the section."""
        if (plane := self._section) is None:
            return shapes
        normal = np.array(plane.normal)
        # A little more, lest rounding tears what lies in the plane.
        offset = plane.offset - float(normal @ self.camera.target) + 1e-6 * self.framing.size
        return shapes.behind(self.camera.axes @ normal, offset)

    def _caps(self, at: float) -> Iterator[ProjectedTriangles]:
        """Yield the cut faces of filled bodies, with outlines of bodies and tissues."""
        if (plane := self._section) is None or not self._opens:
            return
        cut = section(self.film, at, plane)
        if self.field is not None:
            numbers = at_cap(cut, between_rows(self.field, at))
            yield self._coloured_skin(cap(cut, plane), numbers)
        else:
            tint = at_cap(cut, self.film.tints)
            yield self._shaded(cap(cut, plane), tint[..., :3], SHINE * tint[..., 3:])
        outlines = rims(cut, plane, _RIM / self._pixel(1.0), _NEARER * self.framing.size)
        yield self._body(outlines, rgb(palette.INK), 0.0)

    def _body(self, mesh: TriangleMesh, base: Floats, shine: float) -> ProjectedTriangles:
        """Return triangles in the light."""
        return self._shaded(mesh, np.broadcast_to(base, mesh.corners.shape), shine)

    def _skin(self, mesh: TriangleMesh, tint: Floats, hollow: Mask) -> ProjectedTriangles:
        """Return triangles in the light, of other colour inside.

        Args:
            mesh: The triangles.
            tint: Colour and gloss of their corners, shape (triangle, 3, 4).
            hollow: Which of them have an inside, shape (triangle,).
        """
        colour = tint[..., :3]
        if self.shows_springs:
            colour = colour + _PALER * (rgb(palette.PAPER) - colour)
        seen = self._into(mesh.corners)
        normal = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
        to_eye = np.array([0.0, 0.0, self.camera.distance]) - seen[:, 0]
        is_front = (normal * to_eye).sum(axis=1) > 0.0
        base = np.where((is_front | ~hollow)[:, None, None], colour, rgb(palette.LUMEN))
        return self._shaded(mesh, base, SHINE * tint[..., 3:])

    def _coloured_skin(self, mesh: TriangleMesh, numbers: Floats) -> ProjectedTriangles:
        """Return triangles in the colours of the field, by its numbers at their corners."""
        assert self.field is not None
        seen, outer, to_eye = self._facing(mesh)
        colour = readable(field_colours(self.field, numbers), outer, to_eye)
        return ProjectedTriangles(seen, colour, np.ones(len(seen)))

    def _shaded(
        self, mesh: TriangleMesh, base: Floats, shine: float | Floats
    ) -> ProjectedTriangles:
        seen, outer, to_eye = self._facing(mesh)
        colour = lit(base, outer, to_eye, shine)
        return ProjectedTriangles(seen, self._hazy(colour, seen, 0.3), np.ones(len(seen)))

    def _facing(self, mesh: TriangleMesh) -> tuple[Floats, Floats, Floats]:
        """Return corners, their normals towards the eye, and directions to it, as seen."""
        seen = self._into(mesh.corners)
        normal = self._into(mesh.normals, direction=True)
        normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
        to_eye = np.array([0.0, 0.0, self.camera.distance]) - seen
        to_eye /= np.linalg.norm(to_eye, axis=-1, keepdims=True)
        away = (normal * to_eye).sum(axis=-1, keepdims=True) < 0.0
        inwards: Floats = -normal
        outer: Floats = np.where(away, inwards, normal)
        return seen, outer, to_eye

    def _hazy(self, colour: Floats, seen: Floats, most: float) -> Floats:
        """Return colours that are paler further away."""
        size = self.framing.size
        part = np.clip((-seen[..., 2:] / size + 0.25) / 1.15, 0.0, 1.0)
        fog = most * part * part * (3.0 - 2.0 * part)
        return colour + fog * (rgb(palette.PAPER) - colour)

    def _into(self, points: NDArray[Any], *, direction: bool = False) -> Floats:
        """Return points, or directions, as the camera sees them, shape (…, 3)."""
        return (points - (0.0 if direction else self.camera.target)) @ self.camera.axes.T

    def _tools(self, moment: InterpolatedFrame) -> Iterator[tuple[TriangleMesh, str]]:
        """Yield tools and threads with their colours."""
        for solid in self.film.solids:
            first, second = moment.position[list(solid.points)]
            if solid.kind == "opening":
                axis = (second - first) / np.linalg.norm(second - first)
                first, second = first - 0.3 * self.framing.size * axis, first
            if solid.kind != "plane":
                radius = np.array([solid.radius])
                yield capsules(first[None], second[None], radius, sides=40), palette.STEEL
        for instrument in self.film.instruments:
            if instrument.life[0] <= moment.at < instrument.life[1]:
                colour = palette.WATER if instrument.kind == "jet" else palette.STEEL
                yield posed(instrument, moment), colour
        lines = self.film.lines
        thread = is_there(lines.life, moment.at) & (lines.radius > 0.0)
        thread &= ~(lines.stitch & self.shows_springs)
        first, second = (moment.position[ends] for ends in lines.ends[thread].T)
        yield capsules(first, second, lines.radius[thread], sides=16), palette.SILK

    def _nodes(self, moment: InterpolatedFrame) -> Iterator[tuple[TriangleMesh, str]]:
        """Yield what is held besides patches of the skin, and nodes that nothing touches."""
        film, size = self.film, self.marker
        held = film.held.rods[is_there(film.held.life, moment.at)]
        dots = film.dots.of[is_there(film.dots.life, moment.at)]
        for ends in (held, np.stack([dots, dots], axis=1)):
            first, second = (moment.position[one] for one in ends.T)
            yield capsules(first, second, np.full(len(ends), size), sides=16), palette.STEEL

    def _tips(self) -> Iterator[Floats]:
        """Yield where arrows end in each frame [m], as far as the picture holds their nodes."""
        low, high = self.framing.points.min(axis=0), self.framing.points.max(axis=0)
        near = 1e-6 * self.framing.size
        for row, force in enumerate(self.film.force):
            foot = self.film.position[row, : self.film.node_count]
            foot = foot - self.framing.middle[row] * self.framing.follows
            held = ((foot >= low - near) & (foot <= high + near)).all(axis=1)
            yield outermost(foot[held] + self._arrow(force[held]))

    def _arrow(self, force: NDArray[Any]) -> Floats:
        """Return the arrows of forces [N], shape (node, 3), as they are drawn [m]."""
        most = LONGEST * (self.film.most_force or 1.0)
        size = np.linalg.norm(force.astype(float), axis=1, keepdims=True)
        return force * (self._reach * np.where(size > most, most / np.maximum(size, most), 1.0))

    def _arrows(self, moment: InterpolatedFrame) -> TriangleMesh:
        arrow, thick = self._arrow(moment.force), 0.0022 * self.framing.size
        seen = np.linalg.norm(arrow, axis=1) > SHORTEST * thick
        return arrows(moment.position[: self.film.node_count][seen], arrow[seen], thick)

    def _springs(self, moment: InterpolatedFrame, there: Mask) -> ProjectedTriangles:
        """Return springs as strips that face the eye; those that are pressed are dashed."""
        lines = self.film.lines
        is_spring = (lines.radius == 0.0) | lines.stitch
        chosen = np.flatnonzero(there & is_spring & self.shows_springs)
        value, colour = self._coloured(moment, chosen)
        ends = self._into(moment.position[lines.ends[chosen]])
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        pressed = (value < -_PRESSED) & (self.colour != "law") & (not self._colours_springs)
        fine = min(1.0, 18.0 / np.sqrt(max(1, len(lines.ends))))
        width = 1.25 * (0.55 + fine) * min(max(self.size[0] / _USUAL, 0.6), 4.0)
        wide = width * (1.0 if self.colour == "law" else 0.75 + 0.75 * np.abs(value))
        which, strips = dashed(ends, np.where(pressed, length / self._dash, 0.0))
        # Towards the eye, lest they sink into the skin.
        away = np.array([0.0, 0.0, self.camera.distance]) - strips
        distance = np.linalg.norm(away, axis=2, keepdims=True)
        strips = strips + away / distance * self.framing.size * _NEARER
        flat = strips[:, 1, :2] - strips[:, 0, :2]
        flat = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
        half = np.zeros_like(strips)
        near = np.clip(self.camera.distance / distance[..., 0], 0.35, 2.0)
        metres = near * np.asarray(wide * np.ones(len(value)))[which, None] / self._pixel(1.0)
        metres *= distance[..., 0] / self.camera.distance
        half[..., 0], half[..., 1] = -flat[:, 1:] * metres, flat[:, :1] * metres
        a, b, c, d = (strips[:, 0] - half[:, 0], strips[:, 0] + half[:, 0],
                      strips[:, 1] - half[:, 1], strips[:, 1] + half[:, 1])  # fmt: skip
        corners = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
        if self.field is None or not self._colours_springs:
            tint = np.repeat(np.tile(colour[which], (2, 1))[:, None], 3, axis=1)
            return ProjectedTriangles(
                corners, self._hazy(tint, corners, 0.62), np.ones(len(corners))
            )
        ends = field_colours(self.field, between_rows(self.field, moment.at))
        begin, end = ends[lines.ends[chosen]].swapaxes(0, 1)
        tint = np.concatenate(
            [np.stack([begin, begin, end], 1), np.stack([begin, end, end], 1)]
        )
        return ProjectedTriangles(corners, tint, np.ones(len(corners)))

    def _coloured(self, moment: InterpolatedFrame, shown: Indices) -> tuple[Floats, Floats]:
        """Return numbers from -1 to 1 and colours of some lines."""
        if self.colour == "law":
            table = np.array([rgb(text) for text in palette.SERIES])
            law = self.film.lines.law[shown]
            return np.zeros(len(law)), table[law % len(table)].reshape(-1, 3)
        number = moment.tension if self.colour == "tension" else moment.strain
        value = np.clip(number[shown] / (self._most[self.colour] or 1.0), -1.0, 1.0)
        return value, ramp(palette.TENSION, value)

    def _plane(self, moment: InterpolatedFrame, solid: ToolSolid) -> ProjectedTriangles:
        first, second = moment.position[list(solid.points)]
        axis = (second - first) / np.linalg.norm(second - first)
        points = self.framing.points
        middle = (points.max(axis=0) + points.min(axis=0)) / 2.0
        foot = middle - axis * float((middle - first) @ axis)
        right, up = across(axis)
        a, b, c, d = (foot + self.framing.size * 0.7 * (right * x + up * y)
                      for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))  # fmt: skip
        seen = self._into(np.array([[a, b, c], [a, c, d]]))
        colour = np.broadcast_to(rgb(palette.STEEL), seen.shape)
        return ProjectedTriangles(seen, colour, np.full(2, 0.35))

    def _resultant(self, sheet: Any, one: Resultant, at: float) -> None:
        """Draw a resultant force as an arrow with its number; see ``web/pulls.js``."""
        from matplotlib.patheffects import withStroke

        frames, most = np.arange(len(self.film.times)), self.film.most_resultant
        force = np.array([float(np.interp(at, frames, one.force[:, k])) for k in range(3)])
        size = float(np.linalg.norm(force))
        if not one.life[0] <= at < one.life[1] or size <= LEAST * most:
            return
        foot = position_at(self.film, at)[one.point]
        tip = foot + REACH * self.framing.size / most * force
        seen, _ = self.camera.seen(np.stack([foot, tip]))
        start, stop = (1.0 + seen) / 2.0 * self.size
        inside = np.clip(stop, 14.0, np.array(self.size) - 14.0)
        style = {"color": palette.SERIES[2], "lw": 2, "mutation_scale": 14}
        shape = "-|>" if np.array_equal(inside, stop) else "->"
        sheet.annotate("", inside, start, arrowprops={"arrowstyle": shape, **style})
        right = inside[0] >= start[0]
        room = 7.0 * len(text := one.scale.text(size))
        x = inside[0] + 6.0 if right else inside[0] - 6.0 - room
        left = min(max(x, 4.0), self.size[0] - room - 4.0)
        sheet.text(
            left, inside[1] + 14.0 * (left != x), text,
            color=palette.INK, fontsize=9, va="center", parse_math=False,
            path_effects=[withStroke(linewidth=2.5, foreground=palette.PAPER)],
        )  # fmt: skip

    def _annotate(self, sheet: Any, at: float, time: float) -> None:
        width, height = self.size
        style = {"color": palette.INK, "va": "top", "fontsize": 11, "parse_math": False}
        sheet.text(14, height - 12, self.title, weight="bold", **style)
        text = self.film.clock.text(time, digits=4)
        sheet.text(width - 14, height - 12, text, ha="right", **style)
        if self.options.section is not None:
            style["fontsize"] = 9
            sheet.text(14, height - 30, f"section {self.options.section.text}", **style)
        for resultant in self.film.resultants:
            self._resultant(sheet, resultant, at)
        length = near(110.0 / self._pixel(1.0))
        long = self._pixel(length)
        sheet.plot([14, 14, 14 + long, 14 + long], [22, 15, 15, 22], color=palette.INK, lw=1)
        text = scale_of("m", [length]).text(length)
        sheet.text(22 + long, 11, text, color=palette.INK, fontsize=9)
        if self.forces and self.film.most_force:
            self._force_ruler(sheet)
        above = 0.0
        if self.shows_springs and not self._colours_springs:
            most = self._most[self.colour]
            above = draw_spring_legend(sheet, self.film.laws, self.colour, most, self.size)
        if self.field is not None:
            draw_field_legend(sheet, self.field, self.size, above)

    def _force_ruler(self, sheet: Any) -> None:
        """Draw how long the arrow of a round force is."""
        force = near(0.7 * self.film.most_force)
        long, scale = self._pixel(force * self._reach), scale_of("N", [force])
        sheet.plot([14, 14 + long], [40, 40], color=palette.SERIES[2], lw=2)
        sheet.plot([14 + long], [40], ">", color=palette.SERIES[2], markersize=6)
        text, most = scale.text(force), LONGEST * self.film.most_force
        if max(float(np.linalg.norm(row, axis=1).max()) for row in self.film.force) > most:
            text += f"; arrows end at {scale.text(most)}"
        sheet.text(24 + long, 36, text, color=palette.INK, fontsize=9)
