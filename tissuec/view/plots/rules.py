"""Conclusions of rules from two properties, with the others at stated values."""

from collections import Counter
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.palette import AMOUNT, GRID, INK
from tissuec.core.scale import AxisUnit
from tissuec.core.units import show
from tissuec.fuzzy.hedges import hedged
from tissuec.fuzzy.rulebase import Inference
from tissuec.fuzzy.rules import atoms
from tissuec.fuzzy.scale import OutOfRange
from tissuec.model.network import Floats
from tissuec.view.plots import PLOTS
from tissuec.view.plots.axes import plain_ticks
from tissuec.view.plots.options import Option, reader
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.subjects import PlotSubject
from tissuec.view.plots.words import scale_along

if TYPE_CHECKING:
    from tissuec.scene.words.phrases import NamedScale
    from tissuec.scene.words.vocabulary import RulesBlock as RulesBlock
    from tissuec.scene.words.vocabulary import Vocabulary
    from tissuec.view.plots.drawing import Axes

WIDTH, ROW, AROUND = 180.0, 72.0, 4.0  # [mm]
_LINE = 46  # letters of a title
POINTS = 61  # of each axis
LEVELS = 12
_EVERYWHERE = 1e-9  # of the largest value: less than this is no change


class RuleSurface(NamedTuple):
    """Conclusions of rules on a quantity over two properties.

    Attributes:
        x, y: Values of the properties, shape (column,) and (row,).
        value: In SI units, shape (row, column); NaN where no rule speaks.
        is_fallback: Where the quantity's ``otherwise`` holds instead of rules.
        fixed: The other properties that count, with their values as people read them.
    """

    quantity: "NamedScale"
    along_x: "NamedScale"
    along_y: "NamedScale"
    x: Floats
    y: Floats
    value: Floats
    is_fallback: NDArray[np.bool_]
    fixed: Mapping[str, str]


@PLOTS.member("rules")
class Rules(Struct, frozen=True):
    """What rules conclude of two properties: contours, with the other properties stated.

    Attributes:
        of: Quantities; all that rules conclude if none is named.
        x, y: Properties; those that most rules use if not named.
        at: Of other properties, such as "hardness=0.5" or "hardness=very soft"; the middle of
            the range if not named.
    """

    takes: ClassVar[str] = "words"
    several: ClassVar[bool] = False

    of: Annotated[
        tuple[str, ...], Option("Only this quantity; may be repeated.", "QUANTITY")
    ] = ()
    x: Annotated[str | None, Option("Property on the horizontal axis.", "PROPERTY")] = None
    y: Annotated[str | None, Option("Property on the vertical axis.", "PROPERTY")] = None
    at: Annotated[
        tuple[str, ...],
        Option(
            "Value or word of another property, as in hardness=0.5 or hardness=soft; "
            "may be repeated.", "NAME=VALUE",
        ),
    ] = ()  # fmt: skip

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        surfaces = self.surfaces(subjects[0].content.vocabulary, subjects[0].name)
        columns = min(2, len(surfaces))
        rows = -(-len(surfaces) // columns)

        def draw(sheet: Canvas) -> None:
            grid = sheet.figure.subplots(rows, columns, squeeze=False).ravel()
            for axes, surface in zip(grid, surfaces, strict=False):
                _draw(sheet, axes, surface)
            for axes in grid[len(surfaces) :]:
                axes.remove()

        return Picture(WIDTH if columns == 2 else 0.62 * WIDTH, AROUND + rows * ROW, draw)

    def surfaces(self, vocabulary: "Vocabulary", name: str) -> list[RuleSurface]:
        """Return the surface of each requested quantity.

        Raises:
            TissueError: The vocabulary has no rules or no such quantity or property, both axes
                are one property, or a value is none of its property.
        """
        blocks = list(vocabulary.rules.values())
        if not blocks:
            raise TissueError(
                f'"{name}" has no rules; '
                '"tissuec plot fuzzy/soft_tissue --kind rules" shows the shipped rules'
            )
        concluded = {
            conclusion.quantity: block
            for block in reversed(blocks)
            for rule in block.base.rules
            for conclusion in rule.conclusions
        }
        known = [key for key in vocabulary.quantities if key in concluded]
        chosen = [_found(one, known, "quantity concluded by rules") for one in self.of]
        return [self._surface(vocabulary, concluded[key], key) for key in chosen or known]

    def _surface(
        self, vocabulary: "Vocabulary", block: "RulesBlock", quantity: str
    ) -> RuleSurface:
        properties = vocabulary.properties
        asked = _asked(block, quantity)
        given = [
            None if name is None else _found(name, properties, "property")
            for name in (self.x, self.y)
        ]
        spare = [key for key in (*asked, *properties) if key not in given]
        x, y = (key or (spare.pop(0) if spare else "") for key in given)
        if not y or x == y:
            raise TissueError("a surface needs two different properties")
        fixed = self._fixed(vocabulary)
        facts = {
            key: fixed.get(key, _middle(named))
            for key, named in properties.items()
            if key not in (x, y)
        }
        right, up = (_grid(properties[key]) for key in (x, y))
        value, is_fallback = _infer(block, quantity, (x, y), (right, up), facts)
        counted = {
            properties[key].name: show(facts[key], properties[key].dimension)
            for key in asked
            if key in facts
        }
        named = vocabulary.quantities[quantity].named
        along_x, along_y = properties[x], properties[y]
        return RuleSurface(named, along_x, along_y, right, up, value, is_fallback, counted)

    def _fixed(self, vocabulary: "Vocabulary") -> dict[str, float]:
        """Return the requested values of properties."""
        fixed: dict[str, float] = {}
        for text in self.at:
            name, is_given, written = text.partition("=")
            if not is_given:
                raise TissueError(
                    f'"{text}" does not have the form PROPERTY=VALUE, as in hardness=0.5'
                )
            key = _found(name, vocabulary.properties, "property")
            if key in (key_of(self.x or ""), key_of(self.y or "")):
                raise TissueError(
                    f'"{text}": {name.strip()} is on an axis and cannot have a fixed value'
                )
            fixed[key] = _value(vocabulary, key, written.strip())
        return fixed


def _found(name: str, known: Sequence[str] | Mapping[str, Any], what: str) -> str:
    if key_of(name) not in known:
        hint = alternatives(name, list(known), what="there are")
        raise TissueError(f'there is no {what} "{name.strip()}"; {hint}')
    return key_of(name)


def _asked(block: "RulesBlock", quantity: str) -> list[str]:
    """Return the properties that rules on a quantity use, the most used first."""
    counts = Counter(
        name
        for rule in block.base.rules
        if any(conclusion.quantity == quantity for conclusion in rule.conclusions)
        for name in {atom.property for atom in atoms(rule.condition)}
    )
    # Of those used alike, the first in the order of rules, not of a set.
    order = [atom.property for rule in block.base.rules for atom in atoms(rule.condition)]
    return sorted(counts, key=lambda key: (-counts[key], order.index(key)))


def _value(vocabulary: "Vocabulary", key: str, written: str) -> float:
    """Return the value of a number, or of a word with its hedges, in SI units."""
    named = vocabulary.properties[key]
    axis, words = named.scale.axis, named.scale.words
    parts = key_of(written).split(" ")
    for count in range(len(parts)):
        front, rest = parts[:count], " ".join(parts[count:])
        if rest in words and all(part in vocabulary.hedges for part in front):
            shape = hedged([vocabulary.hedges[part] for part in front], words[rest], axis)
            return axis.value_of(shape)
    try:
        value = reader(named.dimension)(written)
    except ValueError:
        hint = alternatives(written, words, what="words")
        message = f'"{written}" is neither a number nor a word for {named.name}'
        raise TissueError(f"{message}; {hint}") from None
    try:
        axis.to_scale(value)
    except OutOfRange as error:
        raise TissueError(str(error)) from error
    return value


def _middle(named: "NamedScale") -> float:
    axis = named.scale.axis
    return axis.from_scale(0.5 * sum(axis.bounds))


def _grid(named: "NamedScale") -> Floats:
    """Return values from end to end, evenly on the scale of the property."""
    axis = named.scale.axis
    return np.array([axis.from_scale(place) for place in np.linspace(*axis.bounds, POINTS)])


def _infer(
    block: "RulesBlock",
    quantity: str,
    names: tuple[str, str],
    axes: Sequence[Floats],
    facts: Mapping[str, float],
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return values and where they are fallbacks, shapes (row, column)."""
    x, y = axes
    value = np.full((len(y), len(x)), np.nan)
    fallback = np.zeros(value.shape, dtype=bool)
    for row, column in np.ndindex(value.shape):
        point = {names[0]: float(x[column]), names[1]: float(y[row])}
        answer = block.base.conclude(quantity, {**facts, **point})
        if isinstance(answer, Inference):
            value[row, column] = answer.value
            fallback[row, column] = answer.source == "otherwise"
    return value, fallback


def _draw(sheet: Canvas, axes: "Axes", surface: RuleSurface) -> None:
    x = scale_along(surface.along_x).of(surface.x)
    y = scale_along(surface.along_y).of(surface.y)
    axes.set_facecolor(GRID)
    axes.grid(visible=False)
    _hatch(axes, surface, x, y)
    value = np.ma.masked_invalid(scale_along(surface.quantity).of(surface.value))
    if value.count():
        _fill(sheet, axes, surface.quantity, x, y, value)
    _label(axes, surface)


def _fill(
    sheet: Canvas, axes: "Axes", named: "NamedScale", x: Floats, y: Floats, value: Any
) -> None:
    """Draw values, masked where there are none, as colours with contours and their scale."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize

    low, high, is_log = float(value.min()), float(value.max()), named.scale.axis.log
    is_flat = high - low <= _EVERYWHERE * abs(high)
    if is_flat:  # one value everywhere still has its colour and its number
        low, high = (low / 2.0, high * 2.0) if is_log else (low - 1.0, high + 1.0)
    filled = axes.pcolormesh(
        x, y, value, norm=(LogNorm if is_log else Normalize)(low, high),
        cmap=LinearSegmentedColormap.from_list("amount", AMOUNT),
        shading="nearest" if value.mask.any() else "gouraud", rasterized=True,
    )  # fmt: skip
    bar = sheet.figure.colorbar(filled, ax=axes, pad=0.02, aspect=25)
    bar.set_label(scale_along(named).label(named.name))
    if is_log:
        plain_ticks(bar.ax, "y")
    if not is_flat:
        levels = (np.geomspace if is_log else np.linspace)(low, high, LEVELS)[1:-1]
        axes.contour(x, y, value, levels=levels, colors="white", linewidths=0.5)
        bar.add_lines(levels, ["white"] * len(levels), [0.5] * len(levels))


def _hatch(axes: "Axes", surface: RuleSurface, x: Floats, y: Floats) -> None:
    """Say where no rule speaks, and what holds there."""
    for where, hatch, text in (
        (surface.is_fallback, "....", "no rule fires: fallback"),
        (np.isnan(surface.value), "////", "no rule fires: error"),
    ):
        if where.any():
            axes.contourf(
                x, y, where.astype(float), levels=[0.5, 1.5], colors="none",
                hatches=[hatch], zorder=3,
            )  # fmt: skip
            axes.plot([], [], "s", color=GRID, markeredgecolor=INK, label=f"{hatch[0]} {text}")
    if axes.get_lines():
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _label(axes: "Axes", surface: RuleSurface) -> None:
    for named, which in ((surface.along_x, "x"), (surface.along_y, "y")):
        scale, axis = scale_along(named), named.scale.axis
        low, high = scale.of([axis.low, axis.high])
        axes.set(**{f"{which}label": scale.label(named.name), f"{which}lim": (low, high)})
        if axis.log:
            axes.set(**{f"{which}scale": "log"})
            plain_ticks(axes, which)
        _name_words(axes, named, scale, which)
    stated = ", ".join(f"{name} = {value}" for name, value in surface.fixed.items())
    title = f"{surface.quantity.name}" + (f", at {stated}" if stated else "")
    axes.set_title("\n".join(wrap(title, _LINE)), fontsize=8.5)


def _name_words(axes: "Axes", named: "NamedScale", scale: AxisUnit, which: str) -> None:
    """Mark the values of the words of a property, at the other side of the axes."""
    other = axes.secondary_xaxis("top") if which == "x" else axes.secondary_yaxis("right")
    words = named.scale.words
    places = [float(scale.of(named.scale.axis.value_of(shape))) for shape in words.values()]
    turn: dict[str, Any] = {"rotation": 90, "va": "center"} if which == "y" else {}
    setter = other.set_xticks if which == "x" else other.set_yticks
    setter(places, list(words), fontsize=7, style="italic", **turn)
    other.tick_params(length=2)
    other.spines[["top" if which == "x" else "right"]].set_visible(False)
