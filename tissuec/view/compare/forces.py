"""Differences of ``force`` blocks: which there are, what they act on, and their numbers."""

from collections.abc import Iterator, Mapping

import numpy as np

from tissuec.scene.force_numbers import ForceEntry, ForceNumbers
from tissuec.view.compare.parameters import (
    ROUNDING,
    QuantityDifference,
    SourcePlace,
    relative_difference,
    shortened,
)
from tissuec.view.compare.sides import Side

FORCE = "force"


def forces_alone(a: Side, b: Side) -> Iterator[tuple[str, str]]:
    """Yield the side and the name of each ``force`` block that the other side does not have."""
    if a.forces is None or b.forces is None:
        return
    for which, here, there in (("a", a.forces, b.forces), ("b", b.forces, a.forces)):
        yield from ((which, name) for name in here if name not in there)


def compare_forces(a: Side, b: Side) -> Iterator[QuantityDifference]:
    """Yield the differences of the ``force`` blocks that both sides have.

    A result of an earlier version does not contain these numbers, and is not compared.
    """
    if a.forces is None or b.forces is None:
        return
    for name, here in a.forces.items():
        there = b.forces.get(name)
        if there is None:
            continue
        for what, one, other in (
            ("kind", here.kind, there.kind),
            ("target", here.acts_on, there.acts_on),
        ):
            if one != other:
                yield _difference(what, name, _said(one, here), _said(other, there))
        yield from _numbers(name, here.entries, there.entries)


def _said(text: str, block: ForceNumbers) -> ForceEntry:
    return ForceEntry(text, None, "written", block.place, text)


def _numbers(
    name: str, here: Mapping[str, ForceEntry], there: Mapping[str, ForceEntry]
) -> Iterator[QuantityDifference]:
    """Yield the entries that differ, of those that both kinds of force have."""
    for quantity, one in here.items():
        other = there.get(quantity)
        if other is None or one.value == other.value:
            continue
        found = _difference(quantity, name, one, other)
        if found.relative > ROUNDING:
            yield found


def _difference(
    quantity: str, name: str, one: ForceEntry, other: ForceEntry
) -> QuantityDifference:
    a, b = _value(one), _value(other)
    relative, ranges, dimension = 1.0, ((), ()), None
    if isinstance(a, float) and isinstance(b, float):
        relative = float(relative_difference(np.array([a]), np.array([b]))[0])
        ranges, dimension = ((a, a), (b, b)), one.dimension
    return QuantityDifference(
        quantity, name, FORCE, 1, 1, relative, name, a, b, *ranges, dimension,
        (_place(one),), (_place(other),),
    )  # fmt: skip


def _value(entry: ForceEntry) -> float | str:
    is_number = isinstance(entry.value, int | float) and entry.dimension is not None
    return float(entry.value) if is_number else entry.shown


def _place(entry: ForceEntry) -> SourcePlace:
    return SourcePlace(entry.place, entry.how, shortened(entry.text))
