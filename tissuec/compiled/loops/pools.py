"""Loops over items in several passes: sums of groups, amounts that change, points that follow.

A kernel calls its passes, which are loops over items themselves, one after the other. What they
give each other is in room that is there during a call. The passes of a force are

    amounts: the amount at a time and its rate, from the profiles that it follows;
    carried: points that follow from nodes, and copies of nodes, where there are such points;
    sums, slopes: of each group the sums s, and λ = ∂U/∂s;
    forces: those on the corners of items;
    given back: those on points, to the nodes that these follow.

A group is a node of its own, whose three components are its sums, or numbers by these.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple, Self

import numpy as np

from tissuec.autodiff.derivatives import along
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.pools import TracedPool
from tissuec.autodiff.potentials import TracedItem, numbers_in
from tissuec.autodiff.tensors import dot
from tissuec.compiled.loops.items import (
    LANES,
    ItemLoop,
    ItemTable,
    LoopText,
    change_loop,
    force_loop,
    head,
    places_of_numbers,
)
from tissuec.compiled.loops.terms import OF_TERMS, term_at, terms_of
from tissuec.kernels.records import BoundaryConditions

#: Vectors of groups, and of items that are part of these, by the letters of their inputs.
_OF_GROUPS = {"s": "sums", "x": "x", "a": "amounts"}
_OF_ITEMS = {"x": "x", "l": "slopes"}


class PoolTable(NamedTuple):
    """Items as passes read them.

    Attributes:
        acts: The terms of the amount.
        carried: Parts of points that nodes carry; the nodes of each are a node and its point.
        points: Number of these points; 0 where corners of items are nodes.
        items: The corners of each, the point from which it is seen, and its group.
        groups: Itself, and the point from which it is seen.
    """

    acts: ItemTable
    carried: ItemTable
    points: int
    items: ItemTable
    groups: ItemTable

    @classmethod
    def of(cls, acts: BoundaryConditions, carried: ItemTable, points: int, items: ItemTable,
           groups: ItemTable) -> Self:  # fmt: skip
        """Return a table; arguments as the attributes.

        Args:
            acts: Of its only one, the first component is the amount.
        """
        columns = terms_of(acts)
        none = np.zeros((columns.shape[1], 0), dtype=np.int64)
        return cls(ItemTable.of(none, columns), carried, points, items, groups)


class Pass(NamedTuple):
    """A loop that is part of a kernel.

    Attributes:
        write: Returns it, given a name.
        items: The table that it reads, of ``PoolTable``.
        given: By name of its vectors, what it is given; the others have the same names there.
    """

    write: Callable[[str], LoopText]
    items: str
    given: Mapping[str, str] = {}


#: What passes give each other: by name, of how many there are three numbers, and whether for
#: each change.
_ROOMS = {
    "amounts": ("1", False), "spare": ("1", False),
    **dict.fromkeys(("sums", "slopes", "moved", "again"), ("%groups.size", False)),
    **dict.fromkeys(("ds", "dl"), ("%groups.size", True)),
    **dict.fromkeys(("x.here", "v.here", "f.here", "w.here"), ("%points", False)),
    **dict.fromkeys(("dx.here", "df.here"), ("%points", True)),
}  # fmt: skip


def kernel(name: str, vectors: Sequence[str], passes: Sequence[Pass]) -> LoopText:
    """Return a function that calls passes, one after the other.

    Args:
        vectors: Those that it takes.
        passes: What they are given is among these, or is room that is zero at first.
    """
    loops = [each.write(f"{name}_{k}") for k, each in enumerate(passes)]
    calls, rooms = list[str](), dict[str, str]()
    for each, loop in zip(passes, loops, strict=True):
        words = ["double %time"]
        for own in loop.vectors:
            vector = each.given.get(own, own)
            shape = f"%{vector}.shape"
            if vector not in vectors:
                shape, rooms[vector] = "0", vector
            words.append(f"ptr null, ptr null, i64 0, i64 0, ptr %{vector}, i64 {shape}, i64 0")
        call = f"@{name}_{len(calls)}({', '.join(words)}, ptr %{each.items})"
        calls.append(f"  call void {call}")
    lines = [*head(name, vectors, PoolTable), "  %start.0 = add i64 0, 0"]
    for k, room in enumerate(rooms):
        count, by_change = _ROOMS[room]
        lines.append(f"  %count.{k} = mul i64 {count}, 3")
        lines.append(f"  %size.{k} = mul i64 %count.{k}, {'%room.shape' if by_change else 1}")
        lines.append(f"  %start.{k + 1} = add i64 %start.{k}, %size.{k}")
    lines.append(f"  %memory = call ptr @calloc(i64 %start.{len(rooms)}, i64 8)")
    for k, room in enumerate(rooms):
        lines.append(f"  %{room} = getelementptr double, ptr %memory, i64 %start.{k}")
    lines += [*calls, "  call void @free(ptr %memory)", "  ret void", "}"]
    declared = {"declare ptr @calloc(i64, i64)": None, "declare void @free(ptr)": None}
    texts = list[str]()
    for loop in loops:
        own = loop.text.replace("define void", "define internal void", 1).splitlines()
        texts += [line for line in own if not line.startswith("declare")]
        declared |= dict.fromkeys(line for line in own if line.startswith("declare"))
    called = {each for loop in loops for each in loop.called}
    return LoopText(
        "\n".join([*lines, *texts, *declared, ""]), tuple(sorted(called)), tuple(vectors)
    )


def force_kernel(
    name: str, item: TracedItem, pool: TracedPool | None, carries: Sequence[str] = ()
) -> LoopText:
    """Return the loop that adds the forces of items, and their powers.

    Args:
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points, "x" and perhaps "v"; nothing without points.
    """
    here = {each: f"{each}.here" for each in (*carries, *(("f",) if carries else ()))}
    passes = _before(pool, here, carries)
    vectors = _OF_ITEMS if pool else {"x": "x", "v": "v", "a": "amounts"}
    forces = partial(force_loop, item=item, vectors=vectors)
    passes.append(Pass(forces, "items", here))
    if carries:
        back = partial(carrying_loop, vectors={"f.here": "f"}, back=True)
        passes.append(Pass(back, "carried"))
    return kernel(name, ("x", "v", "f", "power"), passes)


def _before(
    pool: TracedPool | None, here: Mapping[str, str], carries: Sequence[str]
) -> list[Pass]:
    """Return the passes before those over items.

    Args:
        here: By what passes take, where that is if nodes carry it to points.
        carries: What they carry.
    """
    found = [Pass(amounts_loop, "acts")]
    if carries:
        vectors = {each: here[each] for each in carries}
        found.append(Pass(partial(carrying_loop, vectors=vectors, back=False), "carried"))
    if pool:
        found.append(Pass(partial(sums_loop, pool=pool), "items", here))
        found.append(Pass(partial(slopes_loop, pool=pool), "groups", here))
    return found


def pull_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    Args:
        learnt: By name of a number of groups, whether it is the same one for all.
    """
    again = partial(force_loop, item=pool.item, vectors=_OF_ITEMS)
    passes = [
        *_before(pool, {"power": "spare"}, ()),
        Pass(partial(pull_items_loop, pool=pool), "items"),
        Pass(partial(pull_groups_loop, pool=pool, learnt=learnt), "groups"),
        Pass(again, "items", {"slopes": "again", "f": "by_x", "power": "spare"}),
    ]
    return kernel(name, ("x", "v", "weight", "by_x", "by_v", "by"), passes)


def push_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``; arguments as ``pull_kernel``."""
    passes = [
        *_before(pool, {"power": "spare"}, ()),
        Pass(partial(push_sums_loop, pool=pool), "items"),
        Pass(partial(push_groups_loop, pool=pool, learnt=learnt), "groups"),
        Pass(partial(push_items_loop, pool=pool), "items"),
    ]
    return kernel(name, ("x", "v", "dx", "dv", "dn", "df", "room"), passes)


# --- passes -----------------------------------------------------------------------------------


def amounts_loop(name: str) -> LoopText:
    """Return the loop that adds the amounts of terms, and their rates."""
    graph = Graph()
    numbers, p = numbers_in(graph, OF_TERMS)
    outputs = [term_at(p, graph)]
    outputs += along(outputs, {graph.input("time"): 1.0})
    loop = ItemLoop(graph, numbers, 0, 1)
    values, _ = loop.inputs(outputs, {}, [])
    room = loop.keep(loop.code.write(outputs, values))

    def write() -> None:
        for k in range(2):
            loop.add_to(loop.code.address("%amounts", k), loop.kept(room, k))

    loop.each_lane(write)
    return loop.text(name, ("amounts",))


def carrying_loop(name: str, vectors: Mapping[str, str], *, back: bool) -> LoopText:
    """Return the loop that adds what nodes carry to points, or gives what acts on these back.

    Args:
        vectors: What is carried, "x" if it is positions, and to what.
    """
    graph = Graph()
    numbers, p = numbers_in(graph, {"part": 9, "fixed": 3})
    loop = ItemLoop(graph, numbers, 2, LANES)
    start, end = (1, 0) if back else (0, 1)
    outputs: list[Number] = []
    for vector in vectors:
        own = [graph.input(f"{vector}.{start}.{axis}") for axis in range(3)]
        for i in range(3):
            row = p.part[i::3] if back else p.part[3 * i : 3 * i + 3]
            outputs.append(dot(row, own) + (p.fixed[i] if vector == "x" else 0.0))
    values, _ = loop.inputs(outputs, {each: each for each in vectors}, [])
    room = loop.keep(loop.code.write(outputs, values))
    targets = {to: 3 * k for k, to in enumerate(vectors.values())}
    loop.each_lane(lambda: loop.scatter(room, targets, [end]))
    return loop.text(name, (*vectors, *vectors.values()))


def sums_loop(name: str, pool: TracedPool) -> LoopText:
    """Return the loop that adds the shares of items to the sums of their groups."""
    loop = ItemLoop.of(pool.item, LANES)
    constants = [each.place for each in pool.item.constants]
    values, known = loop.inputs(pool.shares, {"x": "x"}, constants)
    room = loop.keep(loop.code.write(pool.shares, values, known))
    group, count = loop.corners - 1, len(pool.shares)
    loop.each_lane(lambda: loop.scatter(room, {"sums": 0}, [group], count))
    return loop.text(name, ("x", "sums"))


def slopes_loop(name: str, pool: TracedPool) -> LoopText:
    """Return the loop that adds λ of groups, and the power of their amounts."""
    loop, outputs = ItemLoop(pool.graph, pool.numbers, 2, LANES), [*pool.slopes, pool.supply]
    values, _ = loop.inputs(outputs, _OF_GROUPS, [])
    room, count = loop.keep(loop.code.write(outputs, values)), len(pool.slopes)

    def write() -> None:
        loop.scatter(room, {"slopes": 0}, [0], count)
        loop.add_to(loop.code.address("%power", 0), loop.kept(room, count))

    loop.each_lane(write)
    return loop.text(name, (*_OF_GROUPS.values(), "slopes", "power"))


def pull_items_loop(name: str, pool: TracedPool) -> LoopText:
    """Return the loop that adds the derivatives of Σ w·f by x, and by λ."""
    item, loop = pool.item, ItemLoop.of(pool.item, LANES)
    constants = [each.place for each in item.constants]
    vectors = _OF_ITEMS | {"w": "weight"}
    values, known = loop.inputs(pool.pulled, vectors, constants)
    room, corners = loop.keep(loop.code.write(pool.pulled, values, known)), item.corners

    def write() -> None:
        loop.scatter(room, {"by_x": 0}, range(corners))
        loop.scatter(room, {"moved": 3 * corners}, [corners + 1], len(pool.shares))

    loop.each_lane(write)
    return loop.text(name, (*vectors.values(), "by_x", "moved"))


def pull_groups_loop(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop that adds what ``TracedPool.pulled_back`` returns."""
    loop, outputs = ItemLoop(pool.graph, pool.numbers, 2, LANES), pool.pulled_back([*learnt])
    vectors, count = _OF_GROUPS | {"m": "moved"}, len(pool.slopes)
    values, _ = loop.inputs(outputs, vectors, [])
    room = loop.keep(loop.code.write(outputs, values))

    def write() -> None:
        loop.scatter(room, {"again": 0}, [0], count)
        for row, at in enumerate(places_of_numbers(loop, pool.widths, learnt), start=count):
            loop.add_to(loop.code.address("%by", at), loop.kept(room, row))

    loop.each_lane(write)
    return loop.text(name, (*vectors.values(), "again", "by"))


def push_sums_loop(name: str, pool: TracedPool) -> LoopText:
    """Return the loop that adds the changes of sums."""
    loop, item = ItemLoop.of(pool.item, 1), pool.item
    rates = [f"d{each.operation.detail}" for each in item.x]
    changes = {x: item.graph.input(rate) for x, rate in zip(item.x, rates, strict=True)}
    group = [(loop.corners - 1, k) for k in range(len(pool.shares))]
    return change_loop(
        name, loop, along(pool.shares, changes), rates, ("x", "dx", "ds", "room"), {"x": "x"},
        {"dx": list(np.ndindex(item.corners, 3))}, ("ds", group),
        [each.place for each in item.constants],
    )  # fmt: skip


def push_groups_loop(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop that adds the changes of λ."""
    loop = ItemLoop(pool.graph, pool.numbers, 2, 1)
    outputs, rates = pool.pushed([*learnt])
    group = [(0, k) for k in range(len(pool.slopes))]
    numbers = places_of_numbers(loop, pool.widths, learnt, "%first")
    return change_loop(
        name, loop, outputs, rates,
        (*_OF_GROUPS.values(), "ds", "dn", "dl", "room"), _OF_GROUPS,
        {"ds": group, "dn": numbers}, ("dl", group),
    )  # fmt: skip


def push_items_loop(name: str, pool: TracedPool) -> LoopText:
    """Return the loop that adds the changes of forces."""
    loop, item = ItemLoop.of(pool.item, 1), pool.item
    changed = [*item.x, *pool.steepness]
    rates = [f"d{each.operation.detail}" for each in changed]
    changes = {each: item.graph.input(rate) for each, rate in zip(changed, rates, strict=True)}
    nodes = list(np.ndindex(item.corners, 3))
    group = [(loop.corners - 1, k) for k in range(len(pool.shares))]
    return change_loop(
        name, loop, along(item.forces, changes), rates,
        (*_OF_ITEMS.values(), "dx", "dl", "df", "room"), _OF_ITEMS,
        {"dx": nodes, "dl": group}, ("df", nodes), [each.place for each in item.constants],
    )  # fmt: skip
