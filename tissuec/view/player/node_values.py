"""Fields in all rows of a film, with the ranges of their colours."""

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.errors import TissueError
from tissuec.core.scale import PERCENT, AxisUnit, scale_of
from tissuec.model.network import Floats
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import TISSUE, NodeField, fields_of
from tissuec.view.player.film import usual_end
from tissuec.view.player.options import Options

MOST_VALUES = 4_000_000
"""Nodes times rows up to which pages contain all fields, and not only the chosen one."""
_ROUNDING = 1e-6  # of the range of colours
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
        usual: The range of the colours unless another one is chosen.
    """

    field: NodeField
    value: Floats
    low: float
    high: float
    least: float
    most: float
    usual: tuple[float, float]

    @classmethod
    def of(cls, field: NodeField, value: Floats) -> "FieldValues":
        """Return the values of a field with their ranges.

        Args:
            field: The field.
            value: In its unit, NaN where it is unknown, shape (row, node).
        """
        known = [row[np.isfinite(row)] for row in value]
        top, bottom = usual_end(known), usual_end(-row for row in known)
        least = min((float(row.min()) for row in known if len(row)), default=0.0)
        most = max((float(row.max()) for row in known if len(row)), default=0.0)
        high = max(top, bottom) or 1.0
        low = -high if field.signed and bottom > _SIGNED * top else 0.0
        return cls(field, value, low, high, least, most, (low, high))

    def ranged(self, given: tuple[float, float] | None) -> "FieldValues":
        """Return this with another range of colours; without one, as it is."""
        if given is None:
            return self
        return replace(self, low=given[0], high=given[1])

    @property
    def is_usual(self) -> bool:
        """Return whether nobody has chosen another range of colours."""
        return (self.low, self.high) == self.usual

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
        options: Options of the player.

    Raises:
        TissueError: The result has no such field.
    """
    if options.field in (None, TISSUE):
        return None
    return read_field(nodes, options.field).ranged(options.range)


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
