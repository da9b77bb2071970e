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

from collections.abc import Mapping, Sequence
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
    Target,
    add_loop,
    at_corners,
    change_loop,
    force_loop,
    head,
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

    def at(self, acts: BoundaryConditions) -> Self:
        """Return the same with the terms of other acts, of which there is one."""
        columns = terms_of(acts)
        none = np.zeros((columns.shape[1], 0), dtype=np.int64)
        return self._replace(acts=ItemTable.of(none, columns))


class Pass(NamedTuple):
    """A loop that is part of a kernel.

    Attributes:
        loop: Its text.
        items: The table that it reads, of ``PoolTable``.
        given: By name of its vectors, what it is given; the others have the same names there.
    """

    loop: LoopText
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
    calls, rooms = list[str](), dict[str, str]()
    for loop, items, given in passes:
        words = ["double %time"]
        for vector in (given.get(own, own) for own in loop.vectors):
            shape = f"%{vector}.shape"
            if vector not in vectors:
                shape, rooms[vector] = "0", vector
            words.append(f"ptr null, ptr null, i64 0, i64 0, ptr %{vector}, i64 {shape}, i64 0")
        calls.append(f"  call void @{loop.name}({', '.join(words)}, ptr %{items})")
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
    for loop, _, _ in passes:
        own = loop.text.replace("define void", "define internal void", 1).splitlines()
        lines += [line for line in own if not line.startswith("declare")]
        declared |= dict.fromkeys(line for line in own if line.startswith("declare"))
    called = {each for loop, _, _ in passes for each in loop.called}
    text = "\n".join([*lines, *declared, ""])
    return LoopText(text, tuple(sorted(called)), name, tuple(vectors))


def force_kernel(
    name: str, item: TracedItem, pool: TracedPool | None, carries: Sequence[str] = ()
) -> LoopText:
    """Return the loop that adds the forces of items, and their powers.

    Args:
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points, "x" and perhaps "v"; nothing without points.
    """
    here = {each: f"{each}.here" for each in (*carries, *(("f",) if carries else ()))}
    vectors = _OF_ITEMS if pool else {"x": "x", "v": "v", "a": "amounts"}
    passes = [_amounts()]
    if carries:
        passes.append(_carrying({each: here[each] for each in carries}, back=False))
    if pool:
        passes += [_sums(pool, here), _slopes(pool, here)]
    passes.append(Pass(force_loop("forces", item, vectors=vectors), "items", here))
    if carries:
        passes.append(_carrying({"f.here": "f"}, back=True))
    return kernel(name, ("x", "v", "f", "power"), passes)


def pull_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    Args:
        learnt: By name of a number of groups, whether it is the same one for all.
    """
    item, given = pool.item, {"power": "spare"}
    by = [*at_corners("by_x", item.corners), *_of_group("moved", pool, item.corners + 1)]
    of_items = add_loop(
        "pull_items", ItemLoop.of(item, LANES), pool.pulled, _OF_ITEMS | {"w": "weight"}, by,
        item.constants,
    )  # fmt: skip
    of_groups = add_loop(
        "pull_groups", _groups(pool), pool.pulled_back([*learnt]), _OF_GROUPS | {"m": "moved"},
        _of_group("again", pool, 0), learnt=(pool.widths, learnt),
    )  # fmt: skip
    again = {"slopes": "again", "f": "by_x", "power": "spare"}
    passes = [
        _amounts(), _sums(pool, {}), _slopes(pool, given), Pass(of_items, "items"),
        Pass(of_groups, "groups"),
        Pass(force_loop("forces", item, vectors=_OF_ITEMS), "items", again),
    ]  # fmt: skip
    return kernel(name, ("x", "v", "weight", "by_x", "by_v", "by"), passes)


def push_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``; arguments as ``pull_kernel``."""
    item, moves = pool.item, at_corners("dx", pool.item.corners)
    group = item.corners + 1

    def changes(
        outputs: Sequence[Number], by: Sequence[Number]
    ) -> tuple[list[Number], list[str]]:
        names = [f"d{each.operation.detail}" for each in by]
        rates = (item.graph.input(each) for each in names)
        return along(outputs, dict(zip(by, rates, strict=True))), names

    of_sums = change_loop(
        "push_sums", ItemLoop.of(item, 1), *changes(pool.shares, item.x), {"x": "x"}, moves,
        _of_group("ds", pool, group), item.constants,
    )  # fmt: skip
    of_groups = change_loop(
        "push_groups", _groups(pool, 1), *pool.pushed([*learnt]), _OF_GROUPS,
        _of_group("ds", pool, 0), _of_group("dl", pool, 0), learnt=(pool.widths, learnt),
    )  # fmt: skip
    of_items = change_loop(
        "push_items", ItemLoop.of(item, 1), *changes(item.forces, [*item.x, *pool.steepness]),
        _OF_ITEMS, [*moves, *_of_group("dl", pool, group)], at_corners("df", item.corners),
        item.constants,
    )  # fmt: skip
    passes = [
        _amounts(), _sums(pool, {}), _slopes(pool, {"power": "spare"}),
        Pass(of_sums, "items"), Pass(of_groups, "groups"), Pass(of_items, "items"),
    ]  # fmt: skip
    return kernel(name, ("x", "v", "dx", "dv", "dn", "df", "room"), passes)


# --- passes -----------------------------------------------------------------------------------


def _groups(pool: TracedPool, lanes: int = LANES) -> ItemLoop:
    """Return a loop over groups."""
    return ItemLoop(pool.graph, pool.numbers, 2, lanes)


def _of_group(vector: str, pool: TracedPool, corner: int) -> list[Target]:
    """Return where numbers by the sums of a group are, given its place among corners."""
    return [(vector, (corner, k)) for k in range(len(pool.shares))]


def _amounts() -> Pass:
    """Return the pass that adds the amounts of terms, and their rates."""
    graph = Graph()
    numbers, p = numbers_in(graph, OF_TERMS)
    outputs = [term_at(p, graph)]
    outputs += along(outputs, {graph.input("time"): 1.0})
    to: list[Target] = [("amounts", 0), ("amounts", 1)]
    return Pass(add_loop("amounts", ItemLoop(graph, numbers, 0, 1), outputs, {}, to), "acts")


def _carrying(vectors: Mapping[str, str], *, back: bool) -> Pass:
    """Return the pass that adds what nodes carry to points, or gives what acts on these back.

    Args:
        vectors: What is carried, "x" if it is positions, and to what.
    """
    graph = Graph()
    numbers, p = numbers_in(graph, {"part": 9, "fixed": 3})
    start, end, outputs = (1, 0, list[Number]()) if back else (0, 1, list[Number]())
    for vector in vectors:
        own = [graph.input(f"{vector}.{start}.{axis}") for axis in range(3)]
        for i in range(3):
            row = p.part[i::3] if back else p.part[3 * i : 3 * i + 3]
            outputs.append(dot(row, own) + (p.fixed[i] if vector == "x" else 0.0))
    targets: list[Target] = [(to, (end, k)) for to in vectors.values() for k in range(3)]
    given, name = {each: each for each in vectors}, "give" if back else "carry"
    loop = add_loop(name, ItemLoop(graph, numbers, 2, LANES), outputs, given, targets)
    return Pass(loop, "carried")


def _sums(pool: TracedPool, here: Mapping[str, str]) -> Pass:
    """Return the pass that adds the shares of items to the sums of their groups."""
    to, loop = _of_group("sums", pool, pool.item.corners + 1), ItemLoop.of(pool.item, LANES)
    found = add_loop("sums", loop, pool.shares, {"x": "x"}, to, pool.item.constants)
    return Pass(found, "items", here)


def _slopes(pool: TracedPool, here: Mapping[str, str]) -> Pass:
    """Return the pass that adds λ of groups, and the power of their amounts."""
    targets = [*_of_group("slopes", pool, 0), ("power", 0)]
    outputs = [*pool.slopes, pool.supply]
    found = add_loop("slopes", _groups(pool), outputs, _OF_GROUPS, targets)
    return Pass(found, "groups", here)
