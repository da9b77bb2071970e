"""Fields in all rows of a film, with their ranges and colours (``web/shared.glsl``)."""

import numpy as np
from msgspec import Struct

from tissuec.core import palette
from tissuec.core.errors import TissueError
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.core.structs import replace
from tissuec.model.network import Floats
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import TISSUE, NodeField, fields_of
from tissuec.view.player.film import SURE, usual_end
from tissuec.view.player.options import Options
from tissuec.view.player.rules import RULES, ramp

MOST_VALUES = 4_000_000
"""Nodes times rows up to which pages contain all fields, and not only the chosen one."""
_ROUNDING = 1e-6  # of the range of colours
_DECADES = 4  # of a logarithmic scale, at most
_SIGNED = 0.05
"""Part of the largest number by which others are below 0, in a field with a sign."""


class FieldValues(Struct, frozen=True, eq=False):
    """A field in all rows of a film.

    Attributes:
        field: The field.
        value: In its unit, NaN where it is unknown, shape (row, node).
        low, high: The range of the colours, within which at least 98 % of the nodes are in
            each row.
        least, most: The range of all numbers.
        usual: The range of linear colours unless another one is chosen.
        logarithmic: Whether colours follow the logarithms of numbers.
    """

    field: NodeField
    value: Floats
    low: float
    high: float
    least: float
    most: float
    usual: tuple[float, float]
    logarithmic: bool = False

    @classmethod
    def of(cls, field: NodeField, value: Floats) -> "FieldValues":
        """Return the values of a field with their ranges.

        Args:
            value: In its unit, NaN where it is unknown, shape (row, node).
        """
        known = [row[np.isfinite(row)] for row in value]
        top, bottom = usual_end(known), usual_end(-row for row in known)
        least = min((float(row.min()) for row in known if len(row)), default=0.0)
        most = max((float(row.max()) for row in known if len(row)), default=0.0)
        high = max(top, bottom) or 1.0
        low = -high if field.signed and bottom > _SIGNED * top else 0.0
        return cls(field, value, low, high, least, most, (low, high))

    @property
    def decades(self) -> tuple[float, float] | None:
        """Return the usual range of a logarithmic scale; None where numbers are below 0.

        It has all but the smallest 2 % of the numbers above 0, and at most ``_DECADES``.
        """
        low, high = self.usual
        positive = self.value[self.value > 0.0]  # not those that are unknown
        if low < 0.0 or not len(positive):
            return None
        least = max(float(np.quantile(positive, 1.0 - SURE)), high * 10.0**-_DECADES)
        return min(float(f"{least:.1e}"), 0.1 * high), high

    def on_logarithms(self) -> "FieldValues":
        """Return this with colours that follow the logarithms of numbers.

        Raises:
            TissueError: Numbers are below 0.
        """
        if self.decades is None:
            raise TissueError(
                f"{self.field.name} has numbers below 0, for which there is no logarithmic "
                "scale; omit --scale log"
            )
        low, high = self.decades
        return replace(self, low=low, high=high, logarithmic=True)

    def part(self, number: Floats) -> Floats:
        """Return where numbers lie in the range of the colours, in their shape.

        Dimensionless, from 0 to 1.

        Args:
            number: In the unit of the field.
        """
        if not self.logarithmic:
            return np.clip((number - self.low) / (self.high - self.low), 0.0, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(np.maximum(number, 0.0) / self.low) / np.log(self.high / self.low)
        return np.clip(ratio, 0.0, 1.0)

    @property
    def middle(self) -> float:
        """Return the number in the middle of the colours, in the unit of the field."""
        mean = 0.5 * (self.low + self.high)
        return float(np.sqrt(self.low * self.high)) if self.logarithmic else mean

    def ranged(self, given: tuple[float, float] | None) -> "FieldValues":
        """Return this with another range of colours; without one, as it is."""
        if given is None:
            return self
        return replace(self, low=given[0], high=given[1])

    @property
    def is_usual(self) -> bool:
        """Return whether nobody has chosen another range of colours."""
        return (self.low, self.high) == (self.decades if self.logarithmic else self.usual)

    @property
    def is_signed(self) -> bool:
        """Return whether colours distinguish numbers below 0 from those above it."""
        return self.low < 0.0

    @property
    def beyond(self) -> tuple[bool, bool]:
        """Return whether numbers are below and above the range, by more than rounding."""
        near = _ROUNDING * (self.high - self.low)
        return self.least < self.low - near, self.most > self.high + near

    @property
    def scale(self) -> AxisUnit:
        """Return the unit in which it is shown."""
        return PERCENT if not self.field.unit else scale_of(self.field.unit, [self.high])


def chosen_field(nodes: DrawnNodes, options: Options) -> FieldValues | None:
    """Return the field of the options, in their range; None for the tissues.

    Args:
        nodes: Of the film.

    Raises:
        TissueError: The result has no such field, or it has no logarithms.
    """
    if options.field in (None, TISSUE):
        return None
    found = read_field(nodes, options.field)
    found = found.on_logarithms() if options.logarithmic else found
    if options.logarithmic and options.range is not None and not options.range[0] > 0.0:
        raise TissueError("a range of a logarithmic scale begins above 0: change --range")
    return found.ranged(options.range)


def read_field(nodes: DrawnNodes, name: str) -> FieldValues:
    """Return one field.

    Raises:
        TissueError: The result has no such field; says which it has.
    """
    fields = {one.name: one for one in fields_of(nodes.trajectory)}
    if name in fields and (value := fields[name].value(nodes)) is not None:
        return FieldValues.of(fields[name], value)
    others = [
        one.name for one in fields.values() if one.name != name and one.value(nodes) is not None
    ]
    why = f" ({nodes.unknown_stress})" if name == "stress" and nodes.unknown_stress else ""
    if name in fields and nodes.film.node_count < nodes.film.recorded[0]:
        why = " where it is simplified; omit --nodes"
    if name not in fields:
        why = f"; a scene records it by: trajectory with {name}"
    raise TissueError(
        f'"{nodes.trajectory.path}" has no {name}{why}; fields of this result: '
        f"{', '.join(others)}"
    )


def read_fields(nodes: DrawnNodes, chosen: FieldValues | None) -> list[FieldValues]:
    """Return all fields of a result; of very large films, those that pages derive and one.

    Args:
        nodes: Of the film.
        chosen: The one that is there in any case, as it is; None for none.
    """
    fits = nodes.film.node_count * len(nodes.film.times) <= MOST_VALUES
    found: list[FieldValues] = []
    for field in fields_of(nodes.trajectory):
        if chosen is not None and field.name == chosen.field.name:
            found.append(chosen)
        elif (fits or field.derived) and (value := field.value(nodes)) is not None:
            found.append(FieldValues.of(field, value))
    return found


def field_colours(values: FieldValues, numbers: Floats) -> Floats:
    """Return the colours of numbers of a field, from 0 to 1, shape (…, 3).

    Args:
        numbers: In its unit, NaN where it is unknown, shape (…).
    """
    part = values.part(numbers)
    known = np.isfinite(part)
    found = ramp(shades_of(values), 2.0 * np.where(known, part, 0.0).ravel() - 1.0)
    return np.where(known[..., None], found.reshape(*numbers.shape, 3), RULES.unknown)


def between_rows(values: FieldValues, at: float) -> Floats:
    """Return the numbers at a moment, in the unit of the field, shape (node,).

    Args:
        at: Moment, in rows of the film.
    """
    first = int(at)
    second, part = min(first + 1, len(values.value) - 1), at - first
    return (1.0 - part) * values.value[first] + part * values.value[second]


def readable(colour: Floats, normal: Floats, to_eye: Floats) -> Floats:
    """Return colours with so little shade that they can be compared, shape (…, 3).

    Args:
        colour: From 0 to 1, shape (…, 3).
        normal: Of one unit, as the camera sees it, shape (…, 3).
        to_eye: Direction to the eye, shape (…, 3).
    """
    facing = np.abs((normal * to_eye).sum(axis=-1, keepdims=True))
    return np.asarray(colour * (RULES.lit + (1.0 - RULES.lit) * facing), dtype=float)


def shades_of(values: FieldValues) -> tuple[str, ...]:
    """Return the colours between which the numbers of a field lie, the lowest first."""
    return palette.TENSION if values.is_signed else palette.AMOUNT
