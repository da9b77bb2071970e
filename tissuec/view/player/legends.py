"""Legends of pictures: of the field on the skin, and of springs; see ``web/legend.js``."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.core.scale import PERCENT, AxisUnit, scale_of, snapped
from tissuec.view.player.field_colours import shades_of
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Colour
from tissuec.view.player.strokes import ramp

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
        values: The field.
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
    for part, value in ((0.0, low), (0.5, 0.5 * (low + high)), (1.0, high)):
        text = f"{scale.of(snapped(value, high - low)):.4g}".replace("-", "−")
        sheet.text(left + part * _LONG, y + 24, text, ha="center", va="top", **_WORDS)
    lines = [*_beyond(values, scale)[::-1], scale.label(values.field.name)]
    for number, line in enumerate(lines):
        sheet.text(left + _LONG / 2, y + 43 + _LINE * number, line, ha="center", **_WORDS)
    return left - 2 * _LETTER, y + 45 + _LINE * len(lines)


def _beyond(values: FieldValues, scale: AxisUnit) -> list[str]:
    """Return which numbers the colours do not tell apart, in lines."""
    lines: list[str] = []
    if values.is_usual and any(values.beyond):
        lines.append("covers 98 % of the values")
    if values.beyond[1]:
        lines.append(f"largest: {scale.text(values.most)}")
    if values.beyond[0]:
        lines.append(f"smallest: {scale.text(values.least)}")
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
