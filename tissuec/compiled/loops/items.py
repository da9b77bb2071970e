"""Loops over items that follow from a potential, such as hinges or triangles."""

from collections.abc import Mapping, Sequence

from tissuec.autodiff.graph import Number
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.loops.changes import change_loop
from tissuec.compiled.loops.frame import (
    ItemLoop,
    LoopText,
    Target,
    at_corners,
    places_of_numbers,
)
from tissuec.compiled.loops.tables import LANES

STATE = {"x": "x", "v": "v"}


def add_loop(
    name: str, loop: ItemLoop, outputs: Sequence[Number], vectors: Mapping[str, str],
    targets: Sequence[Target], constants: Sequence[Number] = (), *,
    learnt: tuple[Mapping[str, int], Mapping[str, bool]] = ({}, {}), more: Sequence[str] = (),
) -> LoopText:  # fmt: skip
    """Return a loop that adds numbers of each item.

    Args:
        loop: Over the items.
        vectors: As those of ``ItemLoop.inputs``.
        targets: Where outputs are added; the last ones to those by numbers, "by".
        constants: What the table has beside the numbers of the items.
        learnt: Widths of the numbers of an item, and by name of those that are learnt, whether
            all items share it.
        more: Further vectors of the function.
    """
    values, known = loop.inputs(outputs, vectors, [each.place for each in constants])
    room = loop.keep(loop.code.write(outputs, values, known))
    named = (
        *vectors.values(),
        *(to for to, _ in targets),
        *(("by",) if learnt[1] else ()),
        *more,
    )

    def write() -> None:
        numbers = places_of_numbers(loop, *learnt)
        loop.scatter(room, [*targets, *(("by", at) for at in numbers)])

    loop.each_lane(write)
    return loop.text(name, tuple(dict.fromkeys(named)))


def at_places(vector: str, item: TracedItem) -> list[Target]:
    """Return the components of a vector at the corners of an item, and in its slots."""
    slots: list[Target] = [(vector, (place, 0)) for place in item.places_of_slots]
    return at_corners(vector, item.corners) + slots


def force_loop(
    name: str, item: TracedItem, lanes: int = LANES, vectors: Mapping[str, str] = STATE
) -> LoopText:
    """Return the loop that adds the forces of items, and the powers of these.

    Args:
        lanes: Items that are computed at a time.
        vectors: As those of ``ItemLoop.inputs``.
    """
    powers = [(k, p) for k, p in enumerate((item.supply, item.power)) if p.value != 0.0]
    targets = [*at_places("f", item), *(("power", k) for k, _ in powers)]
    return add_loop(
        name, ItemLoop.of(item, lanes), [*item.forces, *(p for _, p in powers)], vectors,
        targets, item.constants, more=("power",),
    )  # fmt: skip


def record_loop(
    name: str, item: TracedItem, outputs: Sequence[Number], constants: Sequence[Number],
    lanes: int = LANES,
) -> LoopText:  # fmt: skip
    """Return the loop that writes numbers of each item, for ``recorded`` to read.

    Args:
        constants: What the table has beside the numbers of the items.
        lanes: Items that are computed at a time.
    """
    return storing_loop(name, ItemLoop.of(item, lanes), outputs, constants)


def storing_loop(
    name: str, loop: ItemLoop, outputs: Sequence[Number], constants: Sequence[Number],
    acts: Number | None = None,
) -> LoopText:  # fmt: skip
    """Return ``record_loop``.

    Args:
        loop: Over the items.
        acts: The first output, if items where it is not positive need no others.
    """
    code = loop.code
    values, known = loop.inputs(outputs, STATE, [each.place for each in constants])
    base = loop.row_of_blocks("out", len(outputs))
    if acts is not None:
        known[acts.place], some = code.write([acts, acts > 0.0], values, known)
        code.store(known[acts.place], base)
        code.line(f"br i1 {code.any(some)}, label %some, label %end")
        code.label("some")
    for k, value in enumerate(code.write(outputs, values, known)):
        code.store(value, code.address(base, k * LANES))
    return loop.text(name, ("x", "v", "out"))


def pull_loop(
    name: str, item: TracedItem, learnt: Mapping[str, bool], lanes: int = LANES
) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    Args:
        learnt: By name of a number, whether it is the same one for all items.
        lanes: Items that are computed at a time.
    """
    targets = [*at_corners("by_x", item.corners), *at_places("by_v", item)]
    return add_loop(
        name, ItemLoop.of(item, lanes), item.pulled(tuple(learnt)), STATE | {"w": "weight"},
        targets, item.constants, learnt=(item.widths, learnt),
    )  # fmt: skip


def push_loop(name: str, item: TracedItem, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``, with changes in the lanes.

    What does not depend on the changes is computed once for an item. The arguments are those of
    ``pull_loop``.
    """
    outputs, rates = item.pushed(tuple(learnt))
    return change_loop(
        name, ItemLoop.of(item, 1), outputs, rates, STATE,
        [*at_corners("dx", item.corners), *at_places("dv", item)],
        at_places("df", item), item.constants, learnt=(item.widths, learnt),
    )  # fmt: skip
