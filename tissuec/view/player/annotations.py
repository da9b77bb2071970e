"""What a picture of a moment shows, and what is written on it: title, time, scales, legends."""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.core.scale import PERCENT, AxisUnit, scale_of, snapped
from tissuec.model.network import Floats
from tissuec.view.player.camera import Camera, Framing, fitted, framing, half_height, outermost
from tissuec.view.player.facts import near, thinning
from tissuec.view.player.film import PlayerData, Resultant, position_at
from tissuec.view.player.node_values import FieldValues, shades_of
from tissuec.view.player.options import Colour, Options
from tissuec.view.player.rules import RULES, ramp
from tissuec.view.plots.projection import viewpoint


class PictureSetting(Struct, frozen=True, eq=False, dict=True):
    """What a picture of a moment shows, and how.

    Attributes:
        film: What there is.
        options: How it is seen.
        size: Width and height [px].
        title: Above the picture.
        forces: Whether forces on nodes are drawn.
        field: What colours the skin; its tissues if None.
    """

    film: PlayerData
    options: Options
    size: tuple[int, int]
    title: str
    forces: bool = False
    field: FieldValues | None = None

    @cached_property
    def framing(self) -> Framing:
        return framing(self.film)

    @cached_property
    def home(self) -> Camera:
        """The camera; it follows what flies away from here."""
        points = self.framing.points
        angles = self.options.view or viewpoint(points)
        if self.forces:
            points = np.concatenate([points, *self._tips()])
        return fitted(points, *angles, self.size[0] / self.size[1])

    @cached_property
    def mean_rest(self) -> float:
        """The mean rest length of springs [m]."""
        rests = self.film.lines.rest[self.film.lines.rest > 0.0]
        return float(rests.mean()) if len(rests) else self.framing.size / 20.0

    @property
    def colour(self) -> Colour:
        """What colours springs, unless a field does."""
        return self.options.colour or "tension"

    @cached_property
    def most(self) -> float:
        """The number at the end of the colours of springs, in its SI unit."""
        film = self.film
        ends = {"tension": film.most_tension, "strain": film.most_strain, "law": 1.0}
        return ends[self.colour]

    @property
    def shows_springs(self) -> bool:
        return self.film.shows_springs(self.options.colour)

    @property
    def colours_skin(self) -> bool:
        """Whether the colours of the skin are those of a field."""
        return self.field is not None and bool(len(self.film.skin.triangles))

    @property
    def spring_field(self) -> FieldValues | None:
        """The field that colours springs, as there is no skin."""
        return None if self.colours_skin else self.field

    def pixels(self, length: float) -> float:
        """Return how many pixels a length [m] has at the target."""
        seen = half_height(self.home.aspect) * self.home.distance
        return length * self.size[1] / 2.0 / seen

    @cached_property
    def reach(self) -> float:
        """The length of the arrow of a force on a node over the force [m/N]."""
        return self.framing.size * RULES.arrow / (self.film.most_force or 1.0)

    def arrow(self, force: Floats) -> Floats:
        """Return the arrows of forces [N], shape (node, 3), as they are drawn [m]."""
        most = RULES.longest * (self.film.most_force or 1.0)
        size = np.linalg.norm(force.astype(float), axis=1, keepdims=True)
        return force * (self.reach * np.where(size > most, most / np.maximum(size, most), 1.0))

    def _tips(self) -> list[Floats]:
        """Return where arrows of nodes in the picture end, in each frame [m]."""
        low, high = self.framing.points.min(axis=0), self.framing.points.max(axis=0)
        near = 1e-6 * self.framing.size
        found: list[Floats] = []
        for row, force in enumerate(self.film.force):
            foot = self.film.position[row, : self.film.node_count]
            foot = foot - self.framing.middle[row] * self.framing.follows
            held = ((foot >= low - near) & (foot <= high + near)).all(axis=1)
            found.append(outermost(foot[held] + self.arrow(force[held])))
        return found


Box = tuple[float, float, float, float]
"""Left, bottom, right and top [px]."""

EDGE = 4.0  # [px]: between labels and the rim of the picture
_STEPS = 6  # up to how many lines a label gives way, either way


class Placing:
    """The room for labels in a picture.

    Args:
        size: Width and height of the picture [px].
    """

    def __init__(self, size: tuple[float, float]):
        self.size = size
        self.taken: list[Box] = []
        self.rivals: list[tuple[float, float]] = []  # other points that have labels

    def take(self, box: Box) -> None:
        """Keep labels out of a box."""
        self.taken.append(box)

    def beside(
        self, point: tuple[float, float], room: tuple[float, float], *, right: bool, gap: float
    ) -> tuple[float, float]:
        """Take the best place for a label beside a point, and return its left and bottom [px].

        Args:
            point: From the left and the bottom of the picture [px].
            room: Width and height of the label [px].
            right: The side on which it is placed if there is room.
            gap: Between point and label [px].
        """
        places = self._places(point, room, right=right, gap=gap)
        best = min(places, key=lambda box: self._covered(box) + self._strays(box, point))
        self.take(best)
        return best[0], best[1]

    def _places(
        self, point: tuple[float, float], room: tuple[float, float], *, right: bool, gap: float
    ) -> Iterator[Box]:
        """Yield places, the best ones first."""
        (x, y), (wide, high) = point, room
        sides = (x + gap, x - gap - wide)
        for step in sorted(range(-_STEPS, _STEPS + 1), key=abs):
            for left in sides if right else sides[::-1]:
                inside = min(max(left, EDGE), self.size[0] - EDGE - wide)
                # A label that the rim moves over the point is placed above or below it.
                lines = step if inside == left else step + (1 if step >= 0 else -1)
                low = y - high / 2.0 + lines * high
                low = min(max(low, EDGE), self.size[1] - EDGE - high)
                yield inside, low, inside + wide, low + high

    def _strays(self, box: Box, point: tuple[float, float]) -> float:
        """Return a small cost of a box that is nearer to another point than its own [px²]."""
        left, low, right, top = box

        def away(other: tuple[float, float]) -> float:
            return float(np.hypot(max(left - other[0], 0.0, other[0] - right),
                                  max(low - other[1], 0.0, other[1] - top)))  # fmt: skip

        nearest = min(map(away, self.rivals), default=np.inf)
        return 0.0 if away(point) < nearest else 1.0

    def _covered(self, box: Box) -> float:
        """Return the area of a box that others have [px²]."""
        left, low, right, top = box
        return sum(
            max(0.0, min(right, b[2]) - max(left, b[0]))
            * max(0.0, min(top, b[3]) - max(low, b[1]))
            for b in self.taken
        )


_EDGE = RULES.edge
_RULER = 110.0  # [px]: the most that the scale of lengths has
_SMALL = {"color": palette.INK, "fontsize": 9, "parse_math": False}


class Annotations:
    """Writes on the picture of a moment.

    Args:
        sheet: Axes in pixels.
        setting: Of the picture.
        camera: Of the moment.
        at: The moment, in frames.
    """

    def __init__(self, sheet: Any, setting: PictureSetting, camera: Camera, at: float):
        self.sheet, self.setting, self.camera, self.at = sheet, setting, camera, at
        self.placing = Placing(setting.size)

    def draw(self) -> None:
        """Write everything; resultant forces last, clear of the rest."""
        self._draw_head()
        self._draw_ruler()
        if self.setting.forces and self.setting.film.most_force:
            self._draw_force_ruler()
        self._draw_legends()
        arrows = list(self._resultants())
        for number, arrow in enumerate(arrows):
            others = arrows[:number] + arrows[number + 1 :]
            self.placing.rivals = [(float(x), float(y)) for _, _, _, (x, y), _ in others]
            self._draw_resultant(*arrow)

    def _write(self, x: float, y: float, text: str, **style: Any) -> None:
        """Write where no other label may be."""
        self.placing.take(self._box(self.sheet.text(x, y, text, **style)))

    def _box(self, text: Any) -> Box:
        box = text.get_window_extent()
        return float(box.x0), float(box.y0), float(box.x1), float(box.y1)

    def _draw_head(self) -> None:
        width, height = self.setting.size
        style = _SMALL | {"va": "top", "fontsize": 11}
        self._write(_EDGE, height - 12, self.setting.title, weight="bold", **style)
        film, plane = self.setting.film, self.setting.options.section
        text = film.clock.text(film.time_at(self.at), digits=4)
        self._write(width - _EDGE, height - 12, text, ha="right", **style)
        notes = [f"section {plane.text}" if plane is not None else "", thinning(film)]
        for line, note in enumerate(filter(None, notes)):
            self._write(_EDGE, height - 30 - 14 * line, note, **_SMALL, va="top")

    def _draw_ruler(self) -> None:
        setting = self.setting
        length = near(_RULER / setting.pixels(1.0))
        end = _EDGE + setting.pixels(length)
        place = [_EDGE, _EDGE, end, end]
        self.sheet.plot(place, [22, 15, 15, 22], color=palette.INK, lw=1)
        self.placing.take((_EDGE, 12.0, end, 25.0))
        self._write(end + 8, 11, scale_of("m", [length]).text(length), **_SMALL)

    def _draw_force_ruler(self) -> None:
        """Draw how long the arrow of a round force is."""
        film, setting = self.setting.film, self.setting
        force = near(0.7 * film.most_force)
        end, scale = _EDGE + setting.pixels(force * setting.reach), scale_of("N", [force])
        self.sheet.plot([_EDGE, end], [40, 40], color=palette.SERIES[2], lw=2)
        self.sheet.plot([end], [40], ">", color=palette.SERIES[2], markersize=6)
        self.placing.take((_EDGE, 35.0, end, 45.0))
        text, most = f"{scale.text(force)} at a node", RULES.longest * film.most_force
        if max(float(np.linalg.norm(row, axis=1).max()) for row in film.force) > most:
            text += f"; arrows end at {scale.text(most)}"
        self._write(end + 10, 36, text, **_SMALL)

    def _draw_legends(self) -> None:
        setting, above = self.setting, 0.0
        if setting.shows_springs and setting.spring_field is None:
            left, above = draw_spring_legend(
                self.sheet, setting.film.laws, setting.colour, setting.most, setting.size
            )
            self.placing.take((left, 0.0, setting.size[0], above))
        if setting.field is not None:
            left, top = draw_field_legend(self.sheet, setting.field, setting.size, above)
            self.placing.take((left, above, setting.size[0], top))

    def _resultants(self) -> Iterator[tuple[Resultant, float, Floats, Floats, bool]]:
        """Yield resultant forces, their sizes [N], where arrows begin and end [px], if whole.

        See ``web/pulls.js``.
        """
        film, size = self.setting.film, self.setting.size
        frames, most = np.arange(len(film.times)), film.most_resultant
        place = position_at(film, self.at)
        for one in film.resultants:
            force = np.array([np.interp(self.at, frames, one.force[:, k]) for k in range(3)])
            strength = float(np.linalg.norm(force))
            if not one.life[0] <= self.at < one.life[1] or strength <= RULES.least * most:
                continue
            tip = place[one.point] + RULES.pull * self.setting.framing.size / most * force
            seen, _ = self.camera.seen(np.stack([place[one.point], tip]))
            start, stop = (1.0 + seen) / 2.0 * size
            inside = np.clip(stop, _EDGE, np.array(size) - _EDGE)
            yield one, strength, start, inside, np.array_equal(inside, stop)

    def _draw_resultant(
        self, one: Resultant, strength: float, start: Floats, inside: Floats, is_whole: bool
    ) -> None:
        """Draw a resultant force as an arrow with its name and number; see ``_resultants``."""
        from matplotlib.patheffects import withStroke

        style = {"color": palette.SERIES[2], "lw": 2, "mutation_scale": 14}
        shape = "-|>" if is_whole else "->"
        self.sheet.annotate("", inside, start, arrowprops={"arrowstyle": shape, **style})
        text = self.sheet.text(
            0, 0, f"{one.name} {one.scale.text(strength)}", va="bottom", **_SMALL,
            path_effects=[withStroke(linewidth=2.5, foreground=palette.PAPER)],
        )  # fmt: skip
        left, low, right, top = self._box(text)
        x, y = map(float, inside)
        is_right = bool(inside[0] >= start[0])
        room = right - left, top - low
        text.set_position(self.placing.beside((x, y), room, right=is_right, gap=6.0))


_LONG = 160.0  # [px]: of the colours
_LETTER = 8.0  # [px]: width of a letter, at most on average
_LINE = 14.0  # [px]: height of a line
_WORDS = {"color": palette.INK, "fontsize": 9, "parse_math": False}


def draw_spring_legend(
    sheet: Any, laws: Sequence[str], colour: Colour, most: float, size: tuple[int, int]
) -> tuple[float, float]:
    """Draw the colours of springs into the lower right corner; return its left and top [px].

    Args:
        sheet: Axes in pixels.
        laws: Names of the laws.
        colour: What colours the springs.
        most: The number at the end of the colours, in its SI unit.
        size: Width and height of the picture [px].
    """
    left = size[0] - 24 - _LONG
    if colour == "law":
        laws = laws[:6]
        left = max(14.0, size[0] - 44 - _LETTER * max(_LONG / _LETTER, *map(len, laws), 0))
        for number, law in enumerate(laws):
            y = 16 + 16 * number
            sheet.plot([left, left + 22], [y, y], color=palette.SERIES[number % 7], lw=2)
            sheet.text(left + 30, y, law, va="center", **_WORDS)
        return left, 24.0 + 16.0 * len(laws)
    _draw_ramp(sheet, palette.TENSION, left, 28.0, size)
    scale = scale_of("N", [most]) if colour == "tension" else PERCENT
    for x, value in ((left, -most), (left + _LONG / 2, 0.0), (left + _LONG, most)):
        text = f"{scale.of(value) + 0.0:g}".replace("-", "−")
        sheet.text(x, 24, text, ha="center", va="top", **_WORDS)
    name = scale.label(f"{colour} of springs")
    sheet.text(left + _LONG / 2, 42, name, ha="center", **_WORDS)
    return left - _LETTER, 58.0


def draw_field_legend(
    sheet: Any, values: FieldValues, size: tuple[int, int], above: float
) -> tuple[float, float]:
    """Draw the colours of a field into the lower right corner; return its left and top [px].

    Args:
        sheet: Axes in pixels.
        size: Width and height of the picture [px].
        above: Height of what is below it [px].
    """
    left, y, scale = size[0] - 30.0 - _LONG, above, values.scale
    shades = _draw_ramp(sheet, shades_of(values), left, y + 28, size)
    for x, mark, colour, is_beyond in (
        (left - 5, "<", shades[0, 0], values.beyond[0]),
        (left + _LONG + 5, ">", shades[0, -1], values.beyond[1]),
    ):
        if is_beyond:
            sheet.plot([x], [y + 33], mark, color=tuple(colour), markersize=7, mew=0)
    low, high = values.low, values.high
    for part, value in ((0.0, low), (0.5, values.middle), (1.0, high)):
        digits = 2 if values.logarithmic and part == 0.5 else 4
        text = f"{scale.of(snapped(value, high - low)):.{digits}g}".replace("-", "−")
        sheet.text(left + part * _LONG, y + 24, text, ha="center", va="top", **_WORDS)
    lines = [*_beyond(values, scale)[::-1], scale.label(values.field.title)]
    for number, line in enumerate(lines):
        sheet.text(left + _LONG / 2, y + 43 + _LINE * number, line, ha="center", **_WORDS)
    return left - 2 * _LETTER, y + 45 + _LINE * len(lines)


def _beyond(values: FieldValues, scale: AxisUnit) -> list[str]:
    """Return lines that name the numbers that colours do not distinguish."""
    lines: list[str] = []
    if values.is_usual and any(values.beyond) and not values.logarithmic:
        lines.append("covers 98 % of the values")
    if values.beyond[1]:
        lines.append(f"largest: {scale.text(values.most)}")
    if values.beyond[0]:
        lines.append(f"smallest: {scale.text(snapped(values.least, values.most))}")
    return [line.replace("-", "−") for line in lines]


def _draw_ramp(
    sheet: Any, colours: tuple[str, ...], left: float, low: float, size: tuple[int, int]
) -> NDArray[Any]:
    """Draw colours from left to right, and return them, shape (1, number, 3)."""
    shades: NDArray[Any] = ramp(colours, np.linspace(-1.0, 1.0, 128))[None]
    sheet.imshow(
        shades, extent=(left, left + _LONG, low, low + 10), aspect="auto",
        interpolation="bilinear",
    )  # fmt: skip
    sheet.set(xlim=(0, size[0]), ylim=(0, size[1]))
    return shades
