"""What is written on a picture: title, time, scales, legends, and resultant forces."""

from typing import Any

import numpy as np

from tissuec.core import palette
from tissuec.core.scale import scale_of
from tissuec.view.player.camera import Camera
from tissuec.view.player.facts import thinning
from tissuec.view.player.film import Resultant
from tissuec.view.player.legends import draw_field_legend, draw_spring_legend
from tissuec.view.player.moment import position_at
from tissuec.view.player.pace import near
from tissuec.view.player.picture_setting import PictureSetting
from tissuec.view.player.placing import Box, Placing
from tissuec.view.player.rules import RULES

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
        for resultant in self.setting.film.resultants:
            self._draw_resultant(resultant)

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
        text, most = scale.text(force), RULES.longest * film.most_force
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

    def _draw_resultant(self, one: Resultant) -> None:
        """Draw a resultant force as an arrow with its number; see ``web/pulls.js``."""
        from matplotlib.patheffects import withStroke

        film, size = self.setting.film, self.setting.size
        frames, most = np.arange(len(film.times)), film.most_resultant
        force = np.array([float(np.interp(self.at, frames, one.force[:, k])) for k in range(3)])
        strength = float(np.linalg.norm(force))
        if not one.life[0] <= self.at < one.life[1] or strength <= RULES.least * most:
            return
        foot = position_at(film, self.at)[one.point]
        tip = foot + RULES.pull * self.setting.framing.size / most * force
        seen, _ = self.camera.seen(np.stack([foot, tip]))
        start, stop = (1.0 + seen) / 2.0 * size
        inside = np.clip(stop, _EDGE, np.array(size) - _EDGE)
        style = {"color": palette.SERIES[2], "lw": 2, "mutation_scale": 14}
        shape = "-|>" if np.array_equal(inside, stop) else "->"
        self.sheet.annotate("", inside, start, arrowprops={"arrowstyle": shape, **style})
        text = self.sheet.text(
            0, 0, one.scale.text(strength), va="bottom", **_SMALL,
            path_effects=[withStroke(linewidth=2.5, foreground=palette.PAPER)],
        )  # fmt: skip
        left, low, right, top = self._box(text)
        x, y = map(float, inside)
        is_right = bool(inside[0] >= start[0])
        room = right - left, top - low
        text.set_position(self.placing.beside((x, y), room, right=is_right, gap=6.0))
