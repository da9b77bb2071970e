"""Cells that end where regions do: sheets of nodes are moved to borders of regions.

A comparison in the condition of a region, such as ``z > 7 mm``, has a border where both sides
are equal. If it crosses all lines of nodes of a block of cells between the same two sheets, and
at the same fraction of the way, one of these two is moved there along the lines; no cell
becomes thinner than a quarter of what it was. Cells cannot follow other borders, such as those
of balls; ``region_sizes`` gives the volumes that regions then have.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.compiler.selections import PointScope
from tissuec.core.arrays import SAME_PLACE, largest_side
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.meshes.elements import volumes_of_nodes
from tissuec.meshes.generators import Mesh
from tissuec.meshes.quadratic import with_middles_between
from tissuec.model.network import Floats, Indices
from tissuec.scene.model import Body
from tissuec.scene.reading.expressions import Scope

THINNEST = 0.25  # least part of a cell that remains
_SAME = 1e-6  # of a cell: places this close are the same
_HALVINGS = 60  # of the way between two sheets

#: Two sides of a comparison.
Sides = tuple[s.Expression, s.Expression]


class BorderCrossing(NamedTuple):
    """Where a border crosses lines of nodes.

    Attributes:
        below: The sheet before it.
        part: Of the way to the next sheet, shape (line,).
    """

    below: int
    part: Floats

    @property
    def place(self) -> float:
        """Return its place in numbers of sheets, usually not a whole number."""
        return self.below + float(self.part.mean())


def at_borders(body: Body, mesh: Mesh, scope: Scope) -> Mesh:
    """Return a mesh whose cells end at the borders of the regions, as far as they can.

    Args:
        body: With regions.
        mesh: With elements.
    """
    sides = [pair for region in body.regions for pair in _compared(region.where)]
    if not (mesh.sheets and sides):
        return mesh
    position, size = mesh.position.copy(), largest_side(mesh.position)
    every = [position] if mesh.on_shape is None else [position, mesh.on_shape.copy()]
    for sheets in mesh.sheets:
        lines = every[-1][sheets]
        found = [one for pair in sides for one in _crossings(pair, lines, size, scope)]
        chosen = list(_chosen(found, len(sheets)))
        for places in every:
            lines = places[sheets]
            for sheet, border in chosen:
                way = lines[border.below + 1] - lines[border.below]
                places[sheets[sheet]] = lines[border.below] + border.part[:, None] * way
    if np.array_equal(position, mesh.position):
        return mesh
    position = with_middles_between(mesh, position)
    volume = None if mesh.volume is None else volumes_of_nodes(position, mesh.elements)
    return replace(mesh, position=position, volume=volume, on_shape=None)


def _compared(condition: s.Expression) -> Iterator[Sides]:
    """Yield the sides of the comparisons of a condition that have a border."""
    for part in walk(condition):
        match part:
            case s.Compare(left=left, sign="<" | "<=" | ">" | ">=", right=right):
                yield left, right
            case s.Between(subject=subject, low=low, high=high):
                yield subject, low
                yield subject, high
            case _:
                pass


def _crossings(
    sides: Sides, lines: Floats, size: float, scope: Scope
) -> Iterator[BorderCrossing]:
    """Yield where the border of a comparison crosses lines, if it crosses all of them alike.

    Args:
        sides: Of the comparison.
        lines: Places of nodes, sheet by sheet [m], shape (sheet, line, 3).
        size: Largest side of the mesh [m].
    """

    def excess(places: Floats) -> Floats:
        """Return the difference of both sides in its unit, shape (place,)."""
        points = PointScope(scope, places, size=size)
        left, right = (points.number(side).amount for side in sides)
        return np.broadcast_to(left - right, len(places)).astype(float)

    value = excess(lines.reshape(-1, 3)).reshape(lines.shape[:2])
    rounding = SAME_PLACE * np.abs(value).max(initial=0.0)
    sign = np.where(np.abs(value) <= rounding, 0.0, np.sign(value))
    if not (sign == sign[:, :1]).all():
        return
    sign, count = sign[:, 0], lines.shape[1]
    for sheet in np.flatnonzero(sign == 0.0).tolist():
        if 0 < sheet < len(sign) - 1:
            yield BorderCrossing(sheet, np.zeros(count))
    for sheet in np.flatnonzero(sign[:-1] * sign[1:] < 0.0).tolist():
        start, way = lines[sheet], lines[sheet + 1] - lines[sheet]
        # Exact where the sides are linear in the place.
        part = value[sheet] / (value[sheet] - value[sheet + 1])
        if np.abs(excess(start + part[:, None] * way)).max() > rounding:
            low, high = np.zeros(count), np.ones(count)
            for _ in range(_HALVINGS):
                part = 0.5 * (low + high)
                is_behind = excess(start + part[:, None] * way) * sign[sheet] > 0.0
                low, high = np.where(is_behind, part, low), np.where(is_behind, high, part)
        if np.ptp(part) <= _SAME:
            yield BorderCrossing(sheet, part)


def _chosen(
    found: Sequence[BorderCrossing], sheets: int
) -> Iterator[tuple[int, BorderCrossing]]:
    """Yield the sheets that are moved, and where to.

    Args:
        found: In any order.
        sheets: How many there are; the outer ones stay.
    """
    borders: list[BorderCrossing] = []
    for one in sorted(found, key=lambda one: one.place):
        if not borders or one.place - borders[-1].place > _SAME:
            borders.append(one)
    while borders:
        places = np.array([one.place for one in borders])
        moved, chosen = np.arange(sheets, dtype=float), _nearest(places, sheets)
        if len(chosen):
            moved[chosen] = places
            if np.diff(moved).min() >= THINNEST:
                yield from zip(chosen.tolist(), borders, strict=True)
                return
        away = places - (chosen if len(chosen) else np.rint(places))
        del borders[int(np.argmax(np.abs(away)))]


def _nearest(places: Floats, sheets: int) -> Indices:
    """Return inner sheets, one for each place, the sum of whose squared distances is least.

    Args:
        places: Ascending, shape (place,).
        sheets: How many there are.

    Returns:
        Ascending, shape (place,); empty if there are fewer sheets.
    """
    inner = np.arange(1, sheets - 1)
    if len(places) > len(inner):
        return inner[:0]
    sums, least = list[Floats](), np.zeros(len(inner) + 1)
    for place in places:
        sums.append(least[:-1] + (inner - place) ** 2)
        least = np.concatenate([[np.inf], np.minimum.accumulate(sums[-1])])
    found, end = list[int](), len(inner)
    for each in reversed(sums):
        end = int(np.argmin(each[:end]))
        found.append(end)
    return inner[found[::-1]]
