"""The words of a vocabulary, as sets over the range of a property or quantity."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT
from tissuec.core.scale import AxisUnit, scale_of
from tissuec.core.units import si_unit
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import Gaussian, Shape
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import plain_ticks
from tissuec.view.plots.options import Option
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from matplotlib.text import Text

    from tissuec.scene.words.phrases import NamedScale
    from tissuec.scene.words.vocabulary import Vocabulary
    from tissuec.view.plots.drawing import Axes

WIDTH, ROW, AROUND = 180.0, 36.0, 6.0  # [mm]


@PLOTS.member("words")
class Words(Struct, frozen=True):
    """The words of properties and quantities as sets.

    Attributes:
        of: Only these properties and quantities; all if none is named.
    """

    takes: ClassVar[str] = "words"
    several: ClassVar[bool] = False

    of: Annotated[
        tuple[str, ...], Option("Only this property or quantity; may be repeated.", "NAME")
    ] = ()

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        scales = self._chosen(subjects[0])
        columns = min(2, len(scales))
        rows = -(-len(scales) // columns)

        def draw(sheet: Canvas) -> None:
            # Side by side, more words have more room; in a table all have the same.
            room = [len(named.scale.words) for named in scales] if rows == 1 else None
            grid = sheet.figure.subplots(
                rows, columns, squeeze=False, sharey=True, width_ratios=room
            ).ravel()
            for axes, named in zip(grid, scales, strict=False):
                draw_partition(sheet, axes, named)
            for axes in grid[len(scales) :]:
                axes.remove()
            for axes in grid[::columns]:
                axes.set_ylabel("degree")

        return Picture(WIDTH if columns == 2 else 0.6 * WIDTH, AROUND + rows * ROW, draw)

    def _chosen(self, subject: PlotSubject) -> list["NamedScale"]:
        known = scales_of(subject.content.vocabulary)
        if not known:
            raise TissueError(
                f'"{subject.name}" has no words: it uses no vocabulary; '
                '"tissuec plot fuzzy/soft_tissue" shows the shipped vocabulary'
            )
        for name in self.of:
            if key_of(name) not in known:
                names = [named.name for named in known.values()]
                hint = alternatives(name, names, what="there are")
                raise TissueError(f'there is no property or quantity "{name}"; {hint}')
        return [known[key_of(name)] for name in self.of] or list(known.values())


def scales_of(vocabulary: "Vocabulary") -> dict[str, "NamedScale"]:
    """Return properties, and then quantities, by lower-case name."""
    quantities = {key: scale.named for key, scale in vocabulary.quantities.items()}
    return {**vocabulary.properties, **quantities}


_DARKEST, _LIGHTEST = 0.0, 0.6  # of AMOUNT: what paper does not swallow
_BELL_POINTS = 201
_ROWS = 3


def draw_partition(sheet: Canvas, axes: "Axes", named: "NamedScale") -> None:
    """Draw the set of every word under its name; the axis of a log scale is logarithmic."""
    axis, words = named.scale.axis, named.scale.words
    scale = scale_along(named)
    colours = amounts(len(words))
    names: list[Text] = []
    for number, (word, shape) in enumerate(words.items()):
        x, y = outline(axis, shape)
        axes.plot(
            scale.of(x), y, color=colours[number], label=word, linewidth=1.5,
            linestyle="-" if number % 2 == 0 else (0, (5, 1.5)),
        )  # fmt: skip
        names.append(_name(axes, axis, scale, word, shape, colours[number]))
    if axis.log:
        axes.set_xscale("log")
    low, high = scale.of([axis.low, axis.high])
    axes.set(xlabel=scale.label(named.name), xlim=(low, high), ylim=(0.0, 1.05))
    axes.set_yticks([0.0, 0.5, 1.0])
    if axis.log:
        plain_ticks(axes)
    sheet.later.append(lambda: _stagger(names))


def scale_along(named: "NamedScale") -> AxisUnit:
    """Return the scale that suits the range of a property or quantity."""
    axis = named.scale.axis
    ends = axis.low, axis.high
    typical = math.sqrt(axis.low * axis.high) if axis.log else max(map(abs, ends))
    return scale_of(si_unit(named.dimension), [typical])


def amounts(count: int) -> Sequence[tuple[float, ...]]:
    """Return colours from little to much that can be read on paper."""
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("amount", AMOUNT)
    shades: list[float] = np.linspace(_DARKEST, _LIGHTEST, max(count, 2)).tolist()
    return [colours(shade) for shade in shades]


def outline(axis: Axis, shape: Shape) -> tuple[Floats, Floats]:
    """Return a set as values in the unit of the axis, and degrees, shape (point,) each.

    Sets of straight lines are returned by their corners.
    """
    if not isinstance(shape, Gaussian):
        places, degrees = list(shape.xs), list(shape.ys)
    else:
        low, high = axis.bounds
        first, last = max(shape.support[0], low), min(shape.support[1], high)
        reach = 5.0 * shape.sigma
        places = np.linspace(
            max(first, shape.mean - reach), min(last, shape.mean + reach), _BELL_POINTS
        ).tolist()
        degrees = [shape.degree(place) for place in places]
    return np.array([axis.from_scale(place) for place in places]), np.array(degrees)


def _name(
    axes: "Axes",
    axis: Axis,
    scale: AxisUnit,
    word: str,
    shape: Shape,
    colour: tuple[float, ...],
) -> "Text":
    low, high = axis.bounds
    core_low, core_high = shape.core
    first, last = core_low <= low + axis.rounding, core_high >= high - axis.rounding
    side = "left" if first and not last else "right" if last and not first else "center"
    place = {"left": axis.low, "right": axis.high, "center": axis.value_of(shape)}[side]
    return axes.annotate(
        word, (float(scale.of(place)), 1.0), xycoords=("data", "axes fraction"),
        xytext=(0, 2), textcoords="offset points", ha=side, va="bottom", color=colour,
        fontsize=8, annotation_clip=False,
    )  # fmt: skip


def _stagger(names: Sequence["Text"]) -> None:
    """Lift names that would run into their neighbours."""
    ends = [-np.inf] * _ROWS
    boxes = [name.get_window_extent() for name in names]
    order = np.argsort([box.x0 for box in boxes], kind="stable")
    for number in order.tolist():
        box = boxes[int(number)]
        level = next((n for n, end in enumerate(ends) if box.x0 > end + 4.0), _ROWS - 1)
        ends[level] = box.x1
        names[number].xyann = (0, 2 + 10 * level)  # type: ignore[attr-defined]
