"""A moment of a run as a picture, drawn without a browser.

Camera, colours and light are those of the page (``web/shared.glsl``, ``web/stage.js``).
"""

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.core.structs import replace
from tissuec.model.network import Floats, Indices
from tissuec.results.instruments.meshes import mesh_of
from tissuec.view.player.annotations import Annotations, PictureSetting
from tissuec.view.player.bodies import (
    TriangleMesh,
    across,
    along_rods,
    arrows,
    bulges,
    capsules,
    rounded,
    smooth_mesh,
    spread,
)
from tissuec.view.player.camera import Camera, half_height
from tissuec.view.player.film import (
    Instrument,
    InterpolatedFrame,
    PlayerData,
    ToolSolid,
    surface_at,
)
from tissuec.view.player.lifetimes import is_there
from tissuec.view.player.node_values import FieldValues, between_rows, field_colours
from tissuec.view.player.options import Options
from tissuec.view.player.rules import RULES, dashed, ramp, rgb
from tissuec.view.player.shading import ProjectedTriangles, Shading
from tissuec.view.plots.page import need_matplotlib
from tissuec.view.section.cross_section import at_cap, cap, rims, section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissuec.view.player.shading import Raster

DPI = 100
_RIM = 1.2  # [px]: width of outlines in a section


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
        self.setting = PictureSetting(film, options, size, title, forces, field)
        self.film, self.options, self.size, self.title = film, options, size, title
        self.home = self.camera = self.setting.home
        self.shows_springs = self.setting.shows_springs
        # Cut faces end at the flat triangles of the net.
        self._opens = options.section is not None and len(film.cells.tetrahedra) > 0
        is_plain = self.shows_springs and not self.setting.colours_skin
        self._divisions = 1 if is_plain or self._opens else film.divisions
        # Smooth surfaces have no nodes, at which fields are known.
        self._shows_net = self.shows_springs or self._opens or field is not None
        self.marker = min(
            RULES.marker * self.setting.framing.size,
            RULES.marker_rest * self.setting.mean_rest,
        )

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

    def draw(self, at: float) -> "Figure":
        """Draw a moment, in frames, in the place of the former one."""
        self.figure.clear()
        figure: Any = self.figure
        sheet = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        sheet.axis("off")
        width, height = self.size
        sheet.imshow(self.scene(at), extent=(0, width, 0, height), aspect="auto")
        sheet.set(xlim=(0, width), ylim=(0, height))
        Annotations(sheet, self.setting, self.camera, at).draw()
        return self.figure

    def pixels(self, at: float) -> NDArray[np.uint8]:
        """Return a moment of a film as pixels, shape (height, width, 3)."""
        self.draw(at)
        canvas: Any = self.figure.canvas
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()

    def scene(self, at: float) -> NDArray[np.uint8]:
        """Return the picture without what is written on it, shape (height, width, 3)."""
        from tissuec.view.player.shading import Raster

        moment = InterpolatedFrame.of(self.film, at)
        self.camera = self._following(at)
        raster = Raster(self.size, rgb(palette.PAPER))
        for shapes in self._solid(moment):
            self._rasterise(raster, shapes, hides=True)
        planes = (solid for solid in self.film.solids if solid.kind == "plane")
        for shapes in (self._plane(moment, one) for one in planes):
            self._rasterise(raster, shapes, hides=False)
        return raster.pixels()

    @property
    def _shading(self) -> Shading:
        size, plane = self.setting.framing.size, self.options.section
        return Shading(self.camera, size, plane)

    def _rasterise(self, raster: "Raster", shapes: ProjectedTriangles, *, hides: bool) -> None:
        depth = self.camera.distance - shapes.corners[..., 2]
        ahead = (depth > 0.02 * self.camera.distance).all(axis=1)
        scale = self.size[1] / 2.0 / half_height(self.camera.aspect)
        depth = depth[ahead][..., None]
        flat = np.array(self.size) / 2.0 + scale * shapes.corners[ahead, :, :2] / depth
        corners = np.concatenate([flat, 1.0 / depth], axis=2)
        raster.draw(corners, shapes.colour[ahead], shapes.opacity[ahead], hides=hides)

    def _following(self, at: float) -> Camera:
        """Return the camera, which follows if the film requires that."""
        framing = self.setting.framing
        if not framing.follows:
            return self.home
        frames = np.arange(len(self.film.times))
        middle = framing.middle.T
        shift = [float(np.interp(at, frames, np.asarray(middle[axis]))) for axis in range(3)]
        return replace(self.home, target=self.home.target + shift)

    def _solid(self, moment: InterpolatedFrame) -> Iterator[ProjectedTriangles]:
        """Yield all that hides what is behind it."""
        shading = self._shading
        for shapes in self._tissue(moment, shading):
            yield shading.behind(shapes)
        yield from self._caps(moment.at, shading)
        for mesh, colour in self._tools(moment):
            yield shading.body(mesh, rgb(colour), RULES.gloss)
        if self.setting.forces:
            yield shading.body(self._arrows(moment), rgb(palette.SERIES[2]), 0.1)

    def _tissue(
        self, moment: InterpolatedFrame, shading: Shading
    ) -> Iterator[ProjectedTriangles]:
        """Yield the parts that a section cuts open."""
        yield self._skin(moment, shading)
        if not self._shows_net:
            yield from self._surfaces(moment, shading)
        yield self._threads(moment, shading)
        for mesh in self._nodes(moment):
            yield shading.body(mesh, rgb(palette.STEEL), RULES.gloss)
        if self.setting.colours_skin:
            yield shading.body(self._rims(moment), rgb(palette.INK), 0.0)
        if self.shows_springs:
            lines = self.film.lines
            is_spring = (lines.radius == 0.0) | lines.stitch
            chosen = np.flatnonzero(is_there(lines.life, moment.at) & is_spring)
            yield spring_strips(self.setting, shading, moment, chosen)

    def _skin(self, moment: InterpolatedFrame, shading: Shading) -> ProjectedTriangles:
        film, at, skin, field = self.film, moment.at, self.film.skin, self.setting.field
        shown = is_there(skin.life, at) & ~(skin.smooth & (not self._shows_net))
        triangles = skin.triangles[shown]
        mesh = smooth_mesh(moment.position, triangles)
        bulge = bulges(moment.position, triangles, mesh) * (not self.shows_springs)
        mesh, weights = rounded(mesh, bulge, self._divisions)
        if field is not None:
            numbers = between_rows(field, at)[triangles, None]
            return shading.field(mesh, field, spread(numbers, weights)[..., 0])
        tint = film.tints[triangles]
        held = is_there(film.held.patches, at)[shown, None, None]
        tint[..., :3] += RULES.held * held * (rgb(palette.STEEL) - tint[..., :3])
        hollow = np.repeat(skin.hollow[shown], len(weights))
        return shading.skin(mesh, spread(tint, weights), hollow, paler=self.shows_springs)

    def _surfaces(
        self, moment: InterpolatedFrame, shading: Shading
    ) -> Iterator[ProjectedTriangles]:
        for pieces in self.film.surfaces.values():
            piece, position = surface_at(pieces, moment.at)
            mesh = smooth_mesh(position, piece.triangles)
            tint = np.broadcast_to(piece.tint, (*mesh.corners.shape[:2], 4))
            hollow = np.ones(len(tint), dtype=bool)
            yield shading.skin(mesh, tint, hollow, paler=self.shows_springs)

    def _caps(self, at: float, shading: Shading) -> Iterator[ProjectedTriangles]:
        """Yield the cut faces of filled bodies, with outlines of bodies and tissues."""
        plane, field = shading.front, self.setting.field
        if plane is None or not self._opens:
            return
        cut = section(self.film, at, plane)
        if field is not None:
            numbers = at_cap(cut, between_rows(field, at))
            yield shading.field(cap(cut, plane), field, numbers)
        else:
            tint = at_cap(cut, self.film.tints)
            yield shading.shaded(cap(cut, plane), tint[..., :3], RULES.shine * tint[..., 3:])
        width = _RIM / self.setting.pixels(1.0)
        outlines = rims(cut, plane, width, RULES.nearer * self.setting.framing.size)
        yield shading.body(outlines, rgb(palette.INK), 0.0)

    def _tools(self, moment: InterpolatedFrame) -> Iterator[tuple[TriangleMesh, str]]:
        """Yield tools with their colours; a section leaves them whole."""
        for solid in self.film.solids:
            first, second = moment.position[list(solid.points)]
            if solid.kind == "opening":
                axis = (second - first) / np.linalg.norm(second - first)
                first, second = first - RULES.opening * self.setting.framing.size * axis, first
            if solid.kind != "plane":
                radius = np.array([solid.radius])
                yield capsules(first[None], second[None], radius, sides=40), palette.STEEL
        for instrument in self.film.instruments:
            if instrument.life[0] <= moment.at < instrument.life[1]:
                colour = palette.WATER if instrument.kind == "jet" else palette.STEEL
                yield posed(instrument, moment), colour

    def _threads(self, moment: InterpolatedFrame, shading: Shading) -> ProjectedTriangles:
        """Return threads and stitches, in the colours of the field like skin."""
        lines, field = self.film.lines, self.setting.field
        thread = is_there(lines.life, moment.at) & (lines.radius > 0.0)
        thread &= ~(lines.stitch & self.shows_springs)
        first, second = (moment.position[ends] for ends in lines.ends[thread].T)
        mesh = capsules(first, second, lines.radius[thread], sides=16)
        if field is None:
            return shading.body(mesh, rgb(palette.SILK), RULES.gloss)
        each = between_rows(field, moment.at)[lines.ends[thread]]
        return shading.field(mesh, field, along_rods(mesh, first, second, each))

    def _nodes(self, moment: InterpolatedFrame) -> Iterator[TriangleMesh]:
        """Yield held nodes outside patches of the skin, and nodes that nothing touches."""
        film, size = self.film, self.marker
        held = film.held.rods[is_there(film.held.life, moment.at)]
        dots = film.dots.of[is_there(film.dots.life, moment.at)]
        for ends in (held, np.stack([dots, dots], axis=1)):
            first, second = (moment.position[one] for one in ends.T)
            yield capsules(first, second, np.full(len(ends), size), sides=16)

    def _rims(self, moment: InterpolatedFrame) -> TriangleMesh:
        """Return the edges around held patches, which the colours of a field do not show."""
        held = self.film.held
        ends = held.rims[is_there(held.rim_life, moment.at)]
        first, second = (moment.position[one] for one in ends.T)
        radius = np.full(len(ends), RULES.thick * self.setting.framing.size)
        return capsules(first, second, radius, sides=8)

    def _arrows(self, moment: InterpolatedFrame) -> TriangleMesh:
        """Return the arrows of forces on nodes."""
        arrow, thick = self.setting.arrow(moment.force), RULES.thick * self.setting.framing.size
        seen = np.linalg.norm(arrow, axis=1) > RULES.shortest * thick
        return arrows(moment.position[: self.film.node_count][seen], arrow[seen], thick)

    def _plane(self, moment: InterpolatedFrame, solid: ToolSolid) -> ProjectedTriangles:
        first, second = moment.position[list(solid.points)]
        axis = (second - first) / np.linalg.norm(second - first)
        points = self.setting.framing.points
        middle = (points.max(axis=0) + points.min(axis=0)) / 2.0
        foot = middle - axis * float((middle - first) @ axis)
        right, up = across(axis)
        a, b, c, d = (foot + self.setting.framing.size * 0.7 * (right * x + up * y)
                      for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))  # fmt: skip
        seen = self._shading.into(np.array([[a, b, c], [a, c, d]]))
        colour: Floats = np.broadcast_to(rgb(palette.STEEL), seen.shape)
        return ProjectedTriangles(seen, colour, np.full(2, 0.35))


def posed(instrument: Instrument, moment: InterpolatedFrame) -> TriangleMesh:
    """Return an instrument as it is at a moment; see ``web/instruments.glsl``."""
    origin, *others = moment.position[list(instrument.points)]
    z, x, setting = (np.asarray(one) - origin for one in others)
    z = z / np.linalg.norm(z)
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    mesh = mesh_of(instrument.kind)
    local = mesh.posed(float(setting @ z) / instrument.size) * instrument.size
    return smooth_mesh(origin + local @ np.stack([x, np.cross(z, x), z]), mesh.triangles)


_USUAL = 1000  # [px]: of a picture, in which lines are as wide as on the page


def spring_strips(
    setting: PictureSetting, shading: Shading, moment: InterpolatedFrame, chosen: Indices
) -> ProjectedTriangles:
    """Return springs as strips; those that are pressed are dashed.

    Args:
        shading: Of the moment.
        chosen: Which lines of the film, shape (line,).
    """
    lines, field = setting.film.lines, setting.spring_field
    value, colour = _coloured(setting, moment, chosen)
    ends = shading.into(moment.position[lines.ends[chosen]])
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    pressed = (value < -RULES.pressed) & (setting.colour != "law") & (field is None)
    fine = min(1.0, 18.0 / np.sqrt(max(1, len(lines.ends))))
    width = 1.25 * (0.55 + fine) * min(max(setting.size[0] / _USUAL, 0.6), 4.0)
    wide = width * (1.0 if setting.colour == "law" else 0.75 + 0.75 * np.abs(value))
    dash = setting.mean_rest / RULES.dashes
    which, strips = dashed(ends, np.where(pressed, length / dash, 0.0))
    wide = np.asarray(wide * np.ones(len(value)))[which] / setting.pixels(1.0)
    corners = _widened(shading, strips, wide)
    if field is None:
        tint = np.repeat(np.tile(colour[which], (2, 1))[:, None], 3, axis=1)
        tint = shading.hazy(tint, corners, RULES.fog)
        return ProjectedTriangles(corners, tint, np.ones(len(corners)))
    both = field_colours(field, between_rows(field, moment.at))
    begin, end = both[lines.ends[chosen]].swapaxes(0, 1)
    tint = np.concatenate([np.stack([begin, begin, end], 1), np.stack([begin, end, end], 1)])
    return ProjectedTriangles(corners, tint, np.ones(len(corners)))


def _widened(shading: Shading, strips: Floats, wide: Floats) -> Floats:
    """Return lines as pairs of triangles, the first ones of all before the second ones.

    Args:
        shading: Of the moment.
        strips: Ends as the camera sees them [m], shape (line, 2, 3).
        wide: Half of their widths at the target [m], shape (line,).
    """
    far = shading.camera.distance
    # Towards the eye, lest they sink into the skin.
    away = np.array([0.0, 0.0, far]) - strips
    distance = np.linalg.norm(away, axis=2, keepdims=True)
    strips = strips + away / distance * shading.size * RULES.nearer
    flat = strips[:, 1, :2] - strips[:, 0, :2]
    flat = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
    half = np.zeros_like(strips)
    near = np.clip(far / distance[..., 0], 0.35, 2.0)
    metres = near * wide[:, None] * distance[..., 0] / far
    half[..., 0], half[..., 1] = -flat[:, 1:] * metres, flat[:, :1] * metres
    a, b, c, d = (strips[:, 0] - half[:, 0], strips[:, 0] + half[:, 0],
                  strips[:, 1] - half[:, 1], strips[:, 1] + half[:, 1])  # fmt: skip
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])


def _coloured(
    setting: PictureSetting, moment: InterpolatedFrame, shown: Indices
) -> tuple[Floats, Floats]:
    """Return numbers from -1 to 1 and colours of some lines."""
    if setting.colour == "law":
        table = np.array([rgb(text) for text in palette.SERIES])
        law = setting.film.lines.law[shown]
        return np.zeros(len(law)), table[law % len(table)].reshape(-1, 3)
    number = moment.tension if setting.colour == "tension" else moment.strain
    value = np.clip(number[shown] / (setting.most or 1.0), -1.0, 1.0)
    return value, ramp(palette.TENSION, value)
