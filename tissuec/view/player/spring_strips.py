"""Springs of a picture as strips that face the eye; see ``web/lines.glsl``."""

import numpy as np

from tissuec.core import palette
from tissuec.model.network import Floats, Indices
from tissuec.view.player.field_colours import between_rows, field_colours
from tissuec.view.player.moment import InterpolatedFrame
from tissuec.view.player.picture_setting import PictureSetting
from tissuec.view.player.projected import ProjectedTriangles
from tissuec.view.player.rules import RULES
from tissuec.view.player.shading import Shading
from tissuec.view.player.strokes import dashed, ramp, rgb

_USUAL = 1000  # [px]: of a picture, in which lines are as wide as on the page


def spring_strips(
    setting: PictureSetting, shading: Shading, moment: InterpolatedFrame, chosen: Indices
) -> ProjectedTriangles:
    """Return springs as strips; those that are pressed are dashed.

    Args:
        setting: Of the picture.
        shading: Of the moment.
        moment: The moment.
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
