"""A moment of a run as a picture, drawn without a browser.

Camera, colours and light are those of the page (``web/shared.glsl``, ``web/stage.js``); what is
further away is drawn first.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core import looks
from tissuec.core.errors import TissueError
from tissuec.network import Floats, Indices
from tissuec.player.camera import Camera, axes, fitted, framing, half_height, viewpoint
from tissuec.player.film import Film, Piece, Solid
from tissuec.player.lives import Mask, is_there
from tissuec.player.options import Colour, Options
from tissuec.player.pace import near, scaled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 100
_LAMP = np.array([-0.45, 0.6, 0.75]) / np.linalg.norm([-0.45, 0.6, 0.75])
_PALER = 0.5  # skin under springs, whose colours say something
_NEARER = 1.2e-3  # of the size: by which lines lie on the skin
_SIDES, _RINGS = 24, 12


def need_matplotlib() -> None:
    """Raise a TissueError that says what to install, where matplotlib is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise TissueError(
            'a picture needs matplotlib; pip install "tissuec[plot]" brings it'
        ) from error


def rgb(text: str) -> Floats:
    """Return red, green and blue of ``#rrggbb``, from 0 to 1."""
    return np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0


def ramp(colours: tuple[str, ...], value: Floats) -> Floats:
    """Return colours of numbers from -1 to 1, shape (number, 3)."""
    table = np.array([rgb(text) for text in colours])
    place = np.linspace(-1.0, 1.0, len(table))
    return np.stack([np.interp(value, place, column) for column in table.T], axis=1)


class Shapes(NamedTuple):
    """Polygons and lines of a picture.

    Attributes:
        corners: As seen by the camera, shape (shape, corner, 3): right, up, to the eye [m].
        face: Colour inside with opacity, shape (shape, 4); lines have none.
        edge: Colour of the rim, shape (shape, 4).
        width: Of the rim [px], shape (shape,).
        order: What is drawn later, shape (shape,): how near to the eye [m].
    """

    corners: Floats
    face: Floats
    edge: Floats
    width: Floats
    order: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
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
    def of(cls, film: Film, at: float) -> "Moment":
        """Return what a film shows at a number of frames; it goes straight between two."""
        first = int(at)
        second, part = min(first + 1, len(film.times) - 1), at - first

        def between(numbers: NDArray) -> Floats:
            return (1.0 - part) * numbers[first] + part * numbers[second]

        position = between(film.position)
        ends, rest = film.lines.ends, film.lines.rest
        length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
        stretch = length / np.where(rest > 0.0, rest, np.inf) - 1.0
        strain = np.where(rest > 0.0, stretch, 0.0)
        return cls(at, position, between(film.force), between(film.lines.tension), strain)


class Painter:
    """Draws moments of a film into one figure.

    Args:
        film: What there is.
        options: How it is seen.
        size: Width and height [px].
        title: Above the picture.
        forces: Whether forces on nodes are drawn.
    """

    def __init__(
        self,
        film: Film,
        options: Options,
        size: tuple[int, int],
        title: str,
        *,
        forces: bool = False,
    ):
        need_matplotlib()
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.film, self.size, self.title, self.forces = film, size, title, forces
        self.framing = framing(film)
        angles = options.view or viewpoint(self.framing.points)
        self.camera = fitted(self.framing.points, *angles, size[0] / size[1])
        self.colour: Colour = options.colour
        self.figure: Figure = Figure(figsize=(size[0] / DPI, size[1] / DPI), dpi=DPI)
        self._canvas = FigureCanvasAgg(self.figure)
        self._most = {"tension": film.most_tension, "strain": film.most_strain, "law": 1.0}
        self._reach = self.framing.size / 8.0 / (film.most_force or 1.0)

    def draw(self, at: float) -> "Figure":
        """Draw a moment, in frames, in the place of the former one."""
        from matplotlib.collections import PolyCollection

        self.figure.clear()
        moment = Moment.of(self.film, at)
        axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.axis("off")
        axes.set(xlim=(0, self.size[0]), ylim=(0, self.size[1]))
        for shapes in self._layers(moment):
            flat, depth = self._seen(shapes.corners)
            visible = (depth > 0.02 * self.camera.distance).all(axis=1)
            order = np.flatnonzero(visible)[np.argsort(shapes.order[visible], kind="stable")]
            axes.add_collection(
                PolyCollection(
                    list(flat[order]),
                    facecolors=shapes.face[order],
                    edgecolors=shapes.edge[order],
                    linewidths=shapes.width[order] * 72.0 / DPI,
                    capstyle="round",
                    joinstyle="round",
                )
            )
        self._annotate(
            axes, float(np.interp(at, np.arange(len(self.film.times)), self.film.times))
        )
        return self.figure

    def pixels(self, at: float) -> NDArray[np.uint8]:
        """Return a moment as pixels, shape (height, width, 3)."""
        self.draw(at)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _layers(self, moment: Moment) -> Iterator[Shapes]:
        """Yield what is drawn, one layer over the other; within one by how near it is."""
        camera = self._at(moment)
        parts = [
            *self._skins(moment, camera),
            *self._tools(moment, camera),
            *self._marks(moment, camera),
        ]
        if not self.film.surfaces:
            parts.append(self._springs(moment, camera, threads=False))
        parts.append(self._springs(moment, camera, threads=True))
        if self.forces:
            parts.append(self._arrows(moment, camera))
        yield _joined([_padded(part) for part in parts])
        planes = [solid for solid in self.film.solids if solid.kind == "plane"]
        if planes:
            yield _joined([self._plane(moment, camera, solid) for solid in planes])

    def _at(self, moment: Moment) -> Camera:
        """Return the camera, which follows where the film asks for that."""
        if not self.framing.follows:
            return self.camera
        frames = np.arange(len(self.film.times))
        shift = [np.interp(moment.at, frames, column) for column in self.framing.middle.T]
        c = self.camera
        return Camera(c.target + shift, c.distance, c.azimuth, c.elevation, c.aspect)

    def _seen(self, corners: Floats) -> tuple[Floats, Floats]:
        """Return pixels and distances from the eye [m] of what the camera sees."""
        depth = self.camera.distance - corners[..., 2]
        scale = self.size[1] / 2.0 / half_height(self.camera.aspect)
        safe = np.maximum(depth, 1e-3 * self.camera.distance)[..., None]
        return np.array(self.size) / 2.0 + scale * corners[..., :2] / safe, depth

    def _pixel(self, length: float) -> float:
        """Return how many pixels a length [m] has at the target."""
        return (
            length
            * self.size[1]
            / 2.0
            / (half_height(self.camera.aspect) * self.camera.distance)
        )

    def _skins(self, moment: Moment, camera: Camera) -> Iterator[Shapes]:
        film, withdrawn = self.film, not self.film.surfaces and len(self.film.lines.ends) > 0
        outside = rgb(looks.SKIN) + (_PALER if withdrawn else 0.0) * (1.0 - rgb(looks.SKIN))
        shown = is_there(film.skin.life, moment.at) & ~film.skin.smooth
        yield _faces(camera, moment.position, film.skin.triangles[shown], outside)
        for pieces in film.surfaces.values():
            piece, position = _surface(pieces, moment.at)
            yield _faces(camera, position, piece.triangles, outside)

    def _springs(self, moment: Moment, camera: Camera, *, threads: bool) -> Shapes:
        lines = self.film.lines
        shown = is_there(lines.life, moment.at) & ((lines.radius > 0.0) == threads)
        corners = _into(camera, moment.position[lines.ends[shown]])
        if threads:
            colour = np.tile(rgb(looks.SILK), (len(corners), 1))
            width = np.array([2.0 * self._pixel(radius) for radius in lines.radius[shown]])
        else:
            value, colour = self._coloured(moment, shown)
            fine = min(1.0, 18.0 / np.sqrt(max(1, len(corners))))
            width = (0.55 + fine) * (0.75 + 0.75 * np.abs(value))
        ahead = self.framing.size * _NEARER
        order = corners[:, :, 2].mean(axis=1) + ahead
        fog = np.clip((-order / self.framing.size + 0.3) / 1.2, 0.0, 1.0)[:, None]
        colour = colour + 0.5 * fog * (rgb(looks.PAPER) - colour)
        none = np.zeros((len(corners), 4))
        return Shapes(corners, none, _opaque(colour), width, order)

    def _coloured(self, moment: Moment, shown: Mask) -> tuple[Floats, Floats]:
        """Return numbers from -1 to 1 and colours of some lines."""
        if self.colour == "law":
            table = np.array([rgb(text) for text in looks.SERIES])
            law = self.film.lines.law[shown]
            return np.zeros(len(law)), table[law % len(table)].reshape(-1, 3)
        number = moment.tension if self.colour == "tension" else moment.strain
        value = np.clip(number[shown] / (self._most[self.colour] or 1.0), -1.0, 1.0)
        return value, ramp(looks.TENSION, value)

    def _tools(self, moment: Moment, camera: Camera) -> Iterator[Shapes]:
        for solid in self.film.solids:
            first, second = moment.position[list(solid.points)]
            if solid.kind == "capsule":
                points, triangles = capsule(first, second, solid.radius)
                yield _faces(camera, points, triangles, rgb(looks.STEEL), turned=True)
            elif solid.kind == "opening":
                axis = (second - first) / np.linalg.norm(second - first)
                back = first - 0.3 * self.framing.size * axis
                points, triangles = capsule(back, first, solid.radius)
                yield _faces(camera, points, triangles, rgb(looks.STEEL), turned=True)

    def _marks(self, moment: Moment, camera: Camera) -> Iterator[Shapes]:
        """Yield nodes that are held, fixed ones as squares, and those that nothing touches."""
        film, size = self.film, 0.009 * self.framing.size
        held = is_there(film.held.life, moment.at)
        for nodes, sides, radius in (
            (film.held.of[held & film.fixed], 4, 0.9 * size),
            (film.held.of[held & ~film.fixed], 16, size),
            (film.dots.of[is_there(film.dots.life, moment.at)], 16, 0.7 * size),
        ):
            middle = _into(camera, moment.position[nodes])
            angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
            ring = radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
            corners = middle[:, None] + ring
            steel = np.tile(_opaque(rgb(looks.STEEL)[None]), (len(middle), 1))
            dark = steel * [0.6, 0.6, 0.6, 1.0]
            width = np.full(len(middle), 0.8)
            yield Shapes(corners, steel, dark, width, middle[:, 2] + radius)

    def _arrows(self, moment: Moment, camera: Camera) -> Shapes:
        foot = _into(camera, moment.position[: self.film.node_count])
        arrow = _into(camera, moment.force * self._reach, direction=True)
        length = np.linalg.norm(arrow, axis=1)
        seen = length > 2e-3 * self.framing.size
        foot, arrow = foot[seen], arrow[seen]
        tip = foot + arrow
        size = np.linalg.norm(arrow[:, :2], axis=1, keepdims=True)
        along = arrow / np.maximum(np.linalg.norm(arrow, axis=1, keepdims=True), 1e-300)
        flat = np.stack([-arrow[:, 1], arrow[:, 0], 0.0 * arrow[:, 0]], axis=1)
        side = flat / np.maximum(size, 1e-300)
        head = np.minimum(0.02 * self.framing.size, 0.5 * length[seen])[:, None]
        neck, wide = tip - head * along, 0.35 * head * side
        corners = np.stack([foot, neck, neck + wide, tip, neck - wide, neck], axis=1)
        colour = np.tile(_opaque(rgb(looks.SERIES[2])[None]), (len(foot), 1))
        width = np.full(len(foot), 1.6)
        return Shapes(corners, colour, colour, width, tip[:, 2] + self.framing.size)

    def _plane(self, moment: Moment, camera: Camera, solid: Solid) -> Shapes:
        first, second = moment.position[list(solid.points)]
        axis = (second - first) / np.linalg.norm(second - first)
        points = self.framing.points
        middle = (points.max(axis=0) + points.min(axis=0)) / 2.0
        foot = middle - axis * float((middle - first) @ axis)
        right, up = across(axis)
        corners = [foot + self.framing.size * 0.6 * (right * x + up * y)
                   for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]  # fmt: skip
        face = np.append(rgb(looks.STEEL), 0.35)[None]
        seen = _into(camera, np.array(corners)[None])
        return Shapes(seen, face, 0.0 * face, np.zeros(1), np.zeros(1))

    def _annotate(self, sheet, time: float) -> None:  # noqa: ANN001 (matplotlib is optional)
        width, height = self.size
        style = {"color": looks.INK, "va": "top", "fontsize": 11}
        sheet.text(14, height - 12, self.title, weight="bold", **style)
        size, unit = scaled(float(np.abs(self.film.times).max()), "s")
        sheet.text(width - 14, height - 12, f"{time / size:.4g} {unit}", ha="right", **style)
        length = near(110.0 / self._pixel(1.0))
        long = self._pixel(length)
        size, unit = scaled(length, "m")
        sheet.plot([14, 14, 14 + long, 14 + long], [22, 15, 15, 22], color=looks.INK, lw=1)
        sheet.text(22 + long, 11, f"{length / size:g} {unit}", color=looks.INK, fontsize=9)
        if not self.film.surfaces and len(self.film.lines.ends):
            self._legend(sheet, width)

    def _legend(self, sheet, width: int) -> None:  # noqa: ANN001
        long, style = 160.0, {"color": looks.INK, "fontsize": 9}
        left = width - 24 - long
        if self.colour == "law":
            for number, law in enumerate(self.film.laws[:6]):
                y = 16 + 16 * number
                sheet.plot([left, left + 22], [y, y], color=looks.SERIES[number % 7], lw=2)
                sheet.text(left + 30, y, law, va="center", **style)
            return
        shades = ramp(looks.TENSION, np.linspace(-1.0, 1.0, 128))[None]
        sheet.imshow(
            shades, extent=(left, left + long, 28, 38), aspect="auto", interpolation="bilinear"
        )
        sheet.set(xlim=(0, self.size[0]), ylim=(0, self.size[1]))
        most = self._most[self.colour]
        size, unit = scaled(most, "N") if self.colour == "tension" else (0.01, "%")
        for x, value in ((left, -most), (left + long / 2, 0.0), (left + long, most)):
            text = f"{value / size:g}".replace("-", "−")
            sheet.text(x, 24, text, ha="center", va="top", **style)
        sheet.text(
            left + long / 2, 42, f"{self.colour} of springs [{unit}]", ha="center", **style
        )


def across(axis: Floats) -> tuple[Floats, Floats]:
    """Return two directions at right angles to one, and to each other."""
    side = np.array([0.0, 0.0, 1.0] if abs(axis[2]) < 0.9 else [1.0, 0.0, 0.0])
    right = np.cross(side, axis)
    right /= np.linalg.norm(right)
    return right, np.cross(axis, right)


def capsule(first: Floats, second: Floats, radius: float) -> tuple[Floats, Indices]:
    """Return points, shape (point, 3), and triangles of a rod with round ends, or a sphere."""
    way = second - first
    length = float(np.linalg.norm(way))
    axis = way / length if length else np.array([0.0, 0.0, 1.0])
    right, up = across(axis)
    turn = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    circle = np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * up
    rings = []
    for number in range(_RINGS + 2):
        end = number > _RINGS // 2
        angle = np.pi * ((number - end) / _RINGS - 0.5)
        middle = second if end else first
        rings.append(middle + radius * (np.cos(angle) * circle + np.sin(angle) * axis))
    corner = np.arange(len(rings) * _SIDES).reshape(len(rings), _SIDES)
    a, b = corner[:-1], np.roll(corner, -1, axis=1)[:-1]
    c, d = corner[1:], np.roll(corner, -1, axis=1)[1:]
    triangles = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([b, d, c], axis=-1)])
    return np.concatenate(rings), triangles.reshape(-1, 3)


def _surface(pieces: list[Piece], at: float) -> tuple[Piece, Floats]:
    """Return which piece of a smooth surface is seen, and its points [m], (point, 3)."""
    piece = [one for one in pieces if one.frames[0] <= at + 1e-6 or one is pieces[0]][-1]
    place = float(np.interp(at, piece.frames, np.arange(len(piece.frames))))
    first = int(place)
    second = min(first + 1, len(piece.frames) - 1)
    part = place - first
    return piece, (1.0 - part) * piece.position[first] + part * piece.position[second]


def _into(camera: Camera, points: NDArray, *, direction: bool = False) -> Floats:
    """Return points, or directions, as the camera sees them, shape (…, 3)."""
    origin = 0.0 if direction else camera.target
    return (points - origin) @ axes(camera.azimuth, camera.elevation).T


def _faces(
    camera: Camera,
    position: Floats,
    triangles: Indices,
    outside: Floats,
    *,
    turned: bool = False,
) -> Shapes:
    """Return triangles in the light.

    Args:
        turned: Whether those whose back is seen are left out.
    """
    corners = _into(camera, position[triangles])
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    middle = corners.mean(axis=1)
    to_eye = np.array([0.0, 0.0, camera.distance]) - middle
    to_eye /= np.linalg.norm(to_eye, axis=1, keepdims=True)
    faces_us = (normal * to_eye).sum(axis=1) > 0.0
    if turned:
        kept = faces_us
        corners, normal, middle = corners[kept], normal[kept], middle[kept]
        to_eye, faces_us = to_eye[kept], faces_us[kept]
    base = np.where(faces_us[:, None], outside, rgb(looks.LUMEN))
    normal = np.where(faces_us[:, None], normal, -normal)
    colour = _opaque(lit(base, normal, to_eye, 0.25 if turned else 0.06))
    # Rims of the same colour close the gaps between neighbours.
    return Shapes(corners, colour, colour, np.full(len(corners), 0.6), middle[:, 2])


def lit(base: Floats, normal: Floats, to_eye: Floats, shine: float) -> Floats:
    """Return colours of faces in the light of the page, shape (face, 3)."""
    direct = np.maximum(normal @ _LAMP, 0.0)
    sky = 0.5 + 0.5 * normal[:, 1]
    facing = (normal * to_eye).sum(axis=1)
    rim = (1.0 - np.maximum(facing, 0.0)) ** 3
    mirrored = 2.0 * (normal @ _LAMP)[:, None] * normal - _LAMP
    spot = np.maximum((mirrored * to_eye).sum(axis=1), 0.0) ** 24
    light = 0.22 + 0.26 * sky + 0.7 * direct + 0.12 * rim
    return np.sqrt(np.clip(base**2 * light[:, None] + shine * spot[:, None], 0.0, 1.0))


def _opaque(colour: Floats) -> Floats:
    return np.concatenate([colour, np.ones((len(colour), 1))], axis=1)


def _padded(shapes: Shapes, corners: int = 16) -> Shapes:
    """Return shapes with so many corners, the last one repeated."""
    have = shapes.corners.shape[1]
    index = np.minimum(np.arange(corners), have - 1)
    return shapes._replace(corners=shapes.corners[:, index])


def _joined(parts: list[Shapes]) -> Shapes:
    return Shapes(*(np.concatenate(column) for column in zip(*parts, strict=True)))
