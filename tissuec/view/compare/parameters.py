"""Differences of the numbers of nodes, springs and ``force`` blocks, by quantity and by part.

A relative difference is |b - a| / max(|a|, |b|): the same from either side, 1 between something
and nothing, and 1 between a limit and none. What differs by less than ``ROUNDING`` is the same,
since processors may round otherwise.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.model.inelastic import CONSTANTS, LIMIT, TIMES, VISCOSITY
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.force_numbers import ForceEntry, ForceNumbers
from tissuec.view.compare.matching import MatchedIndices, SideParts
from tissuec.view.compare.sides import Side

ROUNDING = 1e-12
MOST_ORIGINS = 3  # that are named for one change
#: What the arrays of a network are called, and what they measure.
OF_SPRINGS = {
    "stiffness": ("spring constant", units.STIFFNESS),
    "damping": ("viscosity", units.VISCOSITY),
    "rest": ("rest length", units.LENGTH),
    "strength": ("breaking force", units.FORCE),
    "crush": ("crushing force", units.FORCE),
}


class SourcePlace(Struct, frozen=True):
    """A place of a text that gave a number."""

    place: str
    how: str
    text: str


class QuantityDifference(Struct, frozen=True):
    """A quantity that differs in a part of a body.

    Attributes:
        quantity: Such as "spring constant".
        part: Such as "oviduct", "scar of liver", or "liver | scar of liver" between these; of a
            ``force`` block its name.
        what: "node", "spring" or "force".
        count: How many differ.
        total: How many there are in both.
        relative: Largest relative difference.
        worst: The node or spring where it is: "14 of oviduct".
        a, b: The numbers there; three for vectors, and for laws and words their names.
        range_a, range_b: Least and largest of those that differ; empty for vectors and laws.
        dimension: Of the numbers; None for laws and words.
        from_a, from_b: What gave them, at most ``MOST_ORIGINS`` places.
    """

    quantity: str
    part: str
    what: str
    count: int
    total: int
    relative: float
    worst: str
    a: float | str | tuple[float, ...]
    b: float | str | tuple[float, ...]
    range_a: tuple[float, ...]
    range_b: tuple[float, ...]
    dimension: Dimension | None
    from_a: tuple[SourcePlace, ...] = ()
    from_b: tuple[SourcePlace, ...] = ()


class _Column(Struct, frozen=True, eq=False):
    """Numbers of the same things in both networks.

    Attributes:
        array: The array of the network, whose origins are known.
        a, b: Shape (thing,), or (thing, 3) for vectors.
        floor: Below, sizes count as this much: a place is compared with the drawing.
    """

    quantity: str
    array: str
    dimension: Dimension
    a: Floats
    b: Floats
    floor: float = 0.0


def compare_parameters(
    a: Side, b: Side, nodes: MatchedIndices, springs: MatchedIndices
) -> Iterator[QuantityDifference]:
    """Yield the differences, nodes first, the largest difference of each quantity first."""
    places = SideParts(a), SideParts(b)
    for what, pairs, columns in (
        ("node", nodes, _of_nodes(a.network, b.network, nodes)),
        ("spring", springs, _of_springs(a.network, b.network, springs)),
    ):
        groups, names = _grouped(places, pairs, what)
        for column in columns:
            yield from _changes(column, what, pairs, groups, names, a, b, places[0])
    yield from _laws(a.network, b.network, springs, places)


def relative_difference(a: Floats, b: Floats, floor: float = 0.0) -> Floats:
    """Return |b - a| / max(|a|, |b|), from 0 to 2, dimensionless, shape (n,).

    Args:
        a, b: Numbers of shape (n,) or vectors of shape (n, 3), in any unit.
        floor: Smallest denominator, in the same unit.
    """
    if a.ndim > 1:
        size = np.maximum(np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1))
        apart = np.linalg.norm(b - a, axis=1)
    else:
        with np.errstate(invalid="ignore"):
            apart, size = np.abs(b - a), np.maximum(np.abs(a), np.abs(b))
    size = np.maximum(size, floor)
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = np.where(apart > 0.0, apart / size, 0.0)
    one_is_none = np.isinf(a) != np.isinf(b) if a.ndim == 1 else np.zeros(len(a), dtype=bool)
    return np.where(one_is_none, 1.0, relative)


def _of_nodes(a: Network, b: Network, pairs: MatchedIndices) -> Iterator[_Column]:
    extent = max(a.extent, b.extent)
    yield _Column("mass", "mass", units.MASS, a.mass[pairs.a], b.mass[pairs.b])
    here, there = a.position[pairs.a], b.position[pairs.b]
    yield _Column("drawn position", "position", units.LENGTH, here, there, extent)
    here, there = a.velocity[pairs.a], b.velocity[pairs.b]
    yield _Column("initial velocity", "velocity", units.VELOCITY, here, there)


def _of_springs(a: Network, b: Network, pairs: MatchedIndices) -> Iterator[_Column]:
    for array, (name, dimension) in OF_SPRINGS.items():
        here, there = a.array(array)[pairs.a], b.array(array)[pairs.b]
        yield _Column(name, array, dimension, here, there)
    here, there = _inelastic(a, pairs.a), _inelastic(b, pairs.b)
    for name in here if a.springs.inelastic or b.springs.inelastic else ():
        (values, dimension), (others, _) = here[name], there[name]
        yield _Column(name, name, dimension, values, others)


def _inelastic(network: Network, springs: Indices) -> dict[str, tuple[Floats, Dimension]]:
    """Return arrays of relaxation and flow by name; those of no effect where there is none."""
    memory, count = network.springs.inelastic, len(springs)
    nothing, never = np.zeros(count), np.full(count, np.inf)
    found: dict[str, tuple[Floats, Dimension]] = {}
    for row, (constant, time) in enumerate(zip(CONSTANTS, TIMES, strict=True)):
        values, times = nothing, never
        if memory is not None and row < len(memory.constant):
            values, times = memory.constant[row, springs], memory.time[row, springs]
        found[constant] = values, units.STIFFNESS
        found[time] = times, units.TIME
    found[LIMIT] = memory.limit[springs] if memory else never, units.FORCE
    found[VISCOSITY] = memory.viscosity[springs] if memory else never, units.VISCOSITY
    return found


def _grouped(
    places: tuple[SideParts, SideParts], pairs: MatchedIndices, what: str
) -> tuple[Indices, list[str]]:
    """Return a number for the part that each pair belongs to, and the names of the parts."""
    keys: list[Indices] = []
    for side, numbers in zip(places, (pairs.a, pairs.b), strict=True):
        part = side.of_nodes[:, None] if what == "node" else side.of_springs
        keys.append(part[numbers])
    width = keys[0].shape[1]
    rows, group = np.unique(np.concatenate(keys, axis=1), axis=0, return_inverse=True)
    names: list[str] = []
    for row in rows:
        here, there = places[0].named(row[:width]), places[1].named(row[width:])
        names.append(here if here == there else f"{here} (b: {there})")
    return group.reshape(-1), names


def _changes(
    column: _Column, what: str, pairs: MatchedIndices, groups: Indices, names: list[str],
    a: Side, b: Side, places: SideParts,
) -> Iterator[QuantityDifference]:  # fmt: skip
    """Yield the changes of one quantity, a part at a time."""
    relative = relative_difference(column.a, column.b, column.floor)
    different = relative > ROUNDING
    found: list[QuantityDifference] = []
    for group in np.unique(groups[different]).tolist():
        inside = groups == group
        rows = np.flatnonzero(inside & different)
        worst = rows[np.argmax(relative[rows])]
        called = places.node if what == "node" else places.spring
        found.append(
            QuantityDifference(
                column.quantity, names[int(group)], what, len(rows), int(inside.sum()),
                float(relative[worst]), called(int(pairs.a[worst])),
                _plain(column.a[worst]), _plain(column.b[worst]),
                _range(column.a[rows]), _range(column.b[rows]), column.dimension,
                _origins(a, column.array, pairs.a[rows]),
                _origins(b, column.array, pairs.b[rows]),
            )
        )  # fmt: skip
    yield from sorted(found, key=lambda change: -change.relative)


def _laws(
    a: Network, b: Network, pairs: MatchedIndices, places: tuple[SideParts, SideParts]
) -> Iterator[QuantityDifference]:
    """Yield parts whose springs or dashpots follow other laws."""
    codes = [
        [f"{law.elastic.code()}; {law.viscous.code()}" for law in network.springs.laws]
        for network in (a, b)
    ]
    number = {code: place for place, code in enumerate(dict.fromkeys([*codes[0], *codes[1]]))}
    here = np.array([number[code] for code in codes[0]])[a.springs.law[pairs.a]]
    there = np.array([number[code] for code in codes[1]])[b.springs.law[pairs.b]]
    groups, names = _grouped(places, pairs, "spring")
    for group in np.unique(groups[here != there]).tolist():
        inside = groups == group
        rows = np.flatnonzero(inside & (here != there))
        first = rows[0]
        laws = (
            a.springs.laws[a.springs.law[pairs.a[first]]],
            b.springs.laws[b.springs.law[pairs.b[first]]],
        )
        yield QuantityDifference(
            "law", names[int(group)], "spring", len(rows), int(inside.sum()), 1.0,
            places[0].spring(int(pairs.a[first])), laws[0].name, laws[1].name, (), (), None,
        )  # fmt: skip


def _plain(value: Floats) -> float | tuple[float, ...]:
    return tuple(value.tolist()) if value.ndim else float(value)


def _range(values: Floats) -> tuple[float, ...]:
    return (float(values.min()), float(values.max())) if values.ndim == 1 else ()


def _origins(side: Side, array: str, entries: Indices) -> tuple[SourcePlace, ...]:
    """Return the places that gave some entries of an array, those of most entries first."""
    provenance = side.provenance.get(array)
    if provenance is None:
        return ()
    rows, counts = np.unique(provenance.index[entries], return_counts=True)
    order: list[int] = rows[np.argsort(-counts, kind="stable")].tolist()
    chosen = [provenance.origins[row] for row in order]
    given = (SourcePlace(o.span.place, o.how, shortened(o.span.one_line)) for o in chosen)
    return tuple(dict.fromkeys(given))[:MOST_ORIGINS]


def shortened(text: str, most: int = 72) -> str:
    """Return a text that fits on a line."""
    return text if len(text) <= most else f"{text[: most - 1]}…"


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
