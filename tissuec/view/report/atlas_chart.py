"""Drawings of curves of the laboratory, as SVG: curve, closed form, scatter of sources."""

from collections.abc import Iterator
from math import ceil, floor, log10

import numpy as np
from msgspec import Struct

from tissuec.analysis.lab.rows import LabCurve
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.scene.tissues.known_curves import SHEAR, KnownCurve
from tissuec.view.report.markup import Html, element

WIDTH, HEIGHT = 340, 230
_LEFT, _RIGHT, _TOP, _BOTTOM = 54, 10, 12, 40
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)  # between ticks, times a power of ten
_TICKS = 5  # about
_COLOURS = ("warned", "good", "silk", "open")  # of sources, one after the other
_TIP = 3.5  # half the width of the ends of a bar


class ChartAxis(Struct, frozen=True):
    """An axis of a chart.

    Attributes:
        low, high: Its ends, in its unit.
        start, end: Coordinates of these in the drawing.
        ticks: Labelled values.
        is_log: Whether powers of ten are equally far apart.
    """

    low: float
    high: float
    start: float
    end: float
    ticks: tuple[float, ...]
    is_log: bool = False

    def place(self, value: float) -> float:
        """Return the coordinate of a value in the drawing."""
        low, high, value = (
            log10(max(one, 1e-300)) if self.is_log else one
            for one in (self.low, self.high, value)
        )
        part = (value - low) / (high - low)
        return self.start + min(max(part, -0.02), 1.02) * (self.end - self.start)


def even(low: float, high: float, start: float, end: float) -> ChartAxis:
    """Return an axis whose ends are ticks.

    Args:
        low, high: Values that it must include.
        start, end: Coordinates of its ends in the drawing.
    """
    size = max(high - low, 1e-300) / _TICKS
    power = 10.0 ** floor(log10(size))
    step = next(one * power for one in _STEPS if one * power >= size * (1.0 - 1e-9))
    first, last = floor(low / step + 1e-9), ceil(high / step - 1e-9)
    ticks = tuple(step * number for number in range(first, last + 1))
    return ChartAxis(ticks[0], ticks[-1], start, end, ticks)


def powers(low: float, high: float, start: float, end: float) -> ChartAxis:
    """Return an axis with powers of ten at equal distances.

    Args:
        low, high: Its ends, positive.
        start, end: Their coordinates in the drawing.
    """
    first, last = floor(log10(low) + 1e-9), ceil(log10(high) - 1e-9)
    ticks = tuple(10.0**number for number in range(first, last + 1))
    return ChartAxis(
        low, high, start, end, tuple(one for one in ticks if low <= one <= high), True
    )


def chart(curve: LabCurve, torn: tuple[float, float] | None = None) -> Html:
    """Return the drawing of a curve with its evidence, as a figure with a caption.

    Args:
        torn: Strain and stress [Pa] at which the tissue tears, to be marked.
    """
    across, up = _scales(curve)
    x, y = _axes(curve, across, up, torn)
    parts: list[Html] = [*_grid(x, y, across, up, curve)]
    for number, known in enumerate(curve.known):
        parts += _scatter(known, _COLOURS[number % len(_COLOURS)], x, y, across, up)
    begun = np.array([0.0]), np.array([0.0 if curve.mode else 1.0])
    place = np.append(begun[0], curve.place) if curve.mode else curve.place
    value = np.append(begun[1], curve.value) if curve.mode else curve.value
    check = np.append(begun[1], curve.check) if curve.mode else curve.check
    there = np.isfinite(check)
    parts.append(_line(place, value, "measured", x, y, across, up))
    if there[1:].any():
        parts.append(_line(place[there], check[there], "law", x, y, across, up))
    if torn is not None:
        at = x.place(float(across.of(torn[0]))), y.place(float(up.of(torn[1])))
        parts.append(
            element(
                "text", "×", x=_n(at[0]), y=_n(at[1] + 5.5), class_="torn", text_anchor="middle"
            )
        )
    title = curve.mode or "relaxation"
    about = "stress over strain" if curve.mode else "stress left over time"
    svg = element(
        "svg", *parts, viewBox=f"0 0 {WIDTH} {HEIGHT}", role="img",
        aria_label=f"{title}: {about}",
    )  # fmt: skip
    return element("figure", svg, element("figcaption", _caption(title, curve, torn)))


def _caption(title: str, curve: LabCurve, torn: tuple[float, float] | None) -> Html:
    keys = [element("b", title[:1].upper() + title[1:])]
    for number, known in enumerate(curve.known):
        colour = _COLOURS[number % len(_COLOURS)]
        mark = element("i", class_=f"key {colour}", aria_hidden="true")
        verified = "" if known.is_verified else " (unverified)"
        keys.append(element("span", mark, f"{known.source}{verified}", class_="source"))
    if torn is not None:
        keys.append(element("span", "× it tears", class_="source"))
    return Html(" ".join(keys))


def _scales(curve: LabCurve) -> tuple[AxisUnit, AxisUnit]:
    """Return the units of both axes."""
    limits = [one.high for one in curve.known]
    if not curve.mode:
        return scale_of("s", [curve.place]), PERCENT
    return PERCENT, scale_of("Pa", [curve.value, *limits])


def _axes(
    curve: LabCurve, across: AxisUnit, up: AxisUnit, torn: tuple[float, float] | None
) -> tuple[ChartAxis, ChartAxis]:
    places = [*curve.place, *(place for one in curve.known for place in one.places)]
    heights = [*curve.value, *(value for one in curve.known for value in one.high)]
    if torn is not None:
        places, heights = [*places, torn[0]], [*heights, torn[1]]
    ends = float(across.of(min(places))), float(across.of(max(places)))
    y = even(0.0, float(up.of(max(heights))), HEIGHT - _BOTTOM, _TOP)
    sides = _LEFT, WIDTH - _RIGHT
    if curve.mode:
        return even(0.0, ends[1], *sides), y
    return powers(*ends, *sides), y


def _grid(
    x: ChartAxis, y: ChartAxis, across: AxisUnit, up: AxisUnit, curve: LabCurve
) -> Iterator[Html]:
    """Yield lines of the grid, and labels."""
    for tick in x.ticks:
        at = _n(x.place(tick))
        yield element("line", x1=at, x2=at, y1=_n(y.start), y2=_n(y.end), class_="grid")
        yield element("text", f"{tick:.6g}", x=at, y=_n(y.start + 14), text_anchor="middle")
    for tick in y.ticks:
        at = _n(y.place(tick))
        yield element("line", x1=_n(x.start), x2=_n(x.end), y1=at, y2=at, class_="grid")
        yield element(
            "text",
            f"{tick:.6g}",
            x=_n(x.start - 5),
            y=_n(y.place(tick) + 3.5),
            text_anchor="end",
        )
    name = {"": "time", SHEAR: "amount of shear"}.get(curve.mode, "strain")
    middle = _n(0.5 * (x.start + x.end))
    yield element("text", across.label(name), x=middle, y=_n(HEIGHT - 6), text_anchor="middle")
    height = "stress" if curve.mode else "stress left"
    turned = f"translate(11 {_n(0.5 * (y.start + y.end))}) rotate(-90)"
    yield element("text", up.label(height), transform=turned, text_anchor="middle")


def _scatter(
    known: KnownCurve, colour: str, x: ChartAxis, y: ChartAxis, across: AxisUnit, up: AxisUnit
) -> Iterator[Html]:
    """Yield the band between the limits of a source, and a bar at each of its places."""
    low = [_at(*one, x, y, across, up) for one in zip(known.places, known.low, strict=True)]
    high = [_at(*one, x, y, across, up) for one in zip(known.places, known.high, strict=True)]
    if len(low) > 1:
        corners = " ".join(f"{_n(a)},{_n(b)}" for a, b in [*low, *reversed(high)])
        yield element("polygon", points=corners, class_=f"band {colour}")
    for (at, below), (_, above) in zip(low, high, strict=True):
        path = (
            f"M{_n(at)} {_n(below)}V{_n(above)}M{_n(at - _TIP)} {_n(below)}h{2 * _TIP}"
            f"M{_n(at - _TIP)} {_n(above)}h{2 * _TIP}"
        )
        yield element("path", d=path, class_=f"bar-of-source {colour}")


def _line(
    place: Floats,
    value: Floats,
    class_: str,
    x: ChartAxis,
    y: ChartAxis,
    across: AxisUnit,
    up: AxisUnit,
) -> Html:
    points = (_at(*one, x, y, across, up) for one in zip(place, value, strict=True))
    return element(
        "polyline", points=" ".join(f"{_n(a)},{_n(b)}" for a, b in points), class_=class_
    )


def _at(
    place: float, value: float, x: ChartAxis, y: ChartAxis, across: AxisUnit, up: AxisUnit
) -> tuple[float, float]:
    return x.place(float(across.of(place))), y.place(float(up.of(value)))


def _n(value: float) -> str:
    """Return a coordinate in tenths of a unit of the drawing."""
    return f"{value:.1f}".removesuffix(".0")


def thinned(curve: LabCurve, most: int) -> LabCurve:
    """Return a curve with fewer points, which are closer at its beginning.

    Args:
        most: Largest number of points that is needed.
    """
    count = len(curve.place)
    if count <= most:
        return curve
    chosen = np.unique(np.geomspace(1, count, most).round().astype(int) - 1)
    return LabCurve(
        curve.mode, curve.place[chosen], curve.value[chosen], curve.check[chosen], curve.known
    )
