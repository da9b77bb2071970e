"""Loops over items of groups in several passes: what they add to sums, and how these push them.

A kernel calls its passes, which are loops over items themselves, one after the other. What they
give each other is in room that is there during a call. The passes of a force are

    amounts: the amount at a time and its rate, from the profiles that it follows;
    carried: points that follow from nodes, and copies of nodes, where there are such points;
    parts: what items add to sums, and ∂q/∂x, which are stored;
    groups: of each the sums s, λ, and -Σ λ ∂q/∂x on the corners of its items;
    given back: those on points, to the nodes that these follow.

Threads may share the former, since all that is added up is added in the order of items.
A group is a node of its own, whose three components are its sums, or numbers by these. Items
without sums have the forces of ``loops.items`` instead of these passes.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tissuec.autodiff.derivatives import along
from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.pools import TracedPool
from tissuec.autodiff.potentials import TracedItem, numbers_in
from tissuec.autodiff.tensors import dot
from tissuec.compiled.loops.changes import change_loop
from tissuec.compiled.loops.frame import ItemLoop, LoopText, Target, at_corners, head
from tissuec.compiled.loops.groups import group_loop
from tissuec.compiled.loops.items import STATE, add_loop, force_loop, storing_loop
from tissuec.compiled.loops.tables import LANES, PoolTable
from tissuec.compiled.loops.terms import OF_TERMS, term_at

#: Vectors of groups, and of items that are part of these, by the letters of their inputs.
_OF_GROUPS = {"s": "sums", "x": "x", "a": "amounts"}
_OF_ITEMS = {"x": "x", "l": "factors"}


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
    **dict.fromkeys(("amounts", "passed", "spare"), ("1", False)),
    **dict.fromkeys(("sums", "factors", "moved", "again"), ("%groups.size", False)),
    **dict.fromkeys(("ds", "dl"), ("%groups.size", True)),
    **dict.fromkeys(("x.here", "v.here", "f.here", "w.here"), ("%points", False)),
    **dict.fromkeys(("dx.here", "df.here"), ("%points", True)),
}  # fmt: skip


def kernel(
    name: str, vectors: Sequence[str], passes: Sequence[Pass], after: Sequence[str] = ()
) -> LoopText:
    """Return a function that calls passes, one after the other.

    Args:
        vectors: Those that it takes.
        passes: What they are given is among these, in the table, or room that is zero at first.
        after: What is written after the calls.
    """
    calls, rooms = list[str](), dict[str, str]()
    for loop, items, given in passes:
        words = ["double %time"]
        for vector in (given.get(own, own) for own in loop.vectors):
            shape = f"%{vector}.shape" if vector in vectors else "0"
            if vector in _ROOMS:
                rooms[vector] = vector
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
    lines += [*calls, *after, "  call void @free(ptr %memory)", "  ret void", "}"]
    declared = {"declare ptr @calloc(i64, i64)": None, "declare void @free(ptr)": None}
    for loop, _, _ in passes:
        own = loop.text.replace("define void", "define internal void", 1).splitlines()
        lines += [line for line in own if not line.startswith("declare")]
        declared |= dict.fromkeys(line for line in own if line.startswith("declare"))
    called = {each for loop, _, _ in passes for each in loop.called}
    text = "\n".join([*lines, *declared, ""])
    return LoopText(text, tuple(sorted(called)), name, tuple(vectors))


def force_kernel(
    name: str, item: TracedItem, pool: TracedPool | None, carries: Sequence[str] = (),
    lanes: int = LANES,
) -> LoopText:  # fmt: skip
    """Return the loop that adds the forces of items, and their powers.

    Args:
        pool: Of the items; None if their energy does not depend on sums.
        carries: What nodes carry to points, "x" and perhaps "v"; nothing without points.
        lanes: Items that are computed at a time.
    """
    here = {each: f"{each}.here" for each in (*carries, *(("f",) if carries else ()))}
    passes, after = [_amounts()], list[str]()
    if carries:
        passes.append(_carrying({each: here[each] for each in carries}, back=False))
    if pool:
        passes += [
            _parts(pool, here, lanes),
            Pass(group_loop(pool, pushes=True), "groups", here),
        ]
        after = _counting() if pool.shares.bends is not None else []
    else:
        vectors = STATE | {"a": "amounts"}
        passes.append(Pass(force_loop("forces", item, lanes, vectors), "items", here))
    if carries:
        passes.append(_carrying({"f.here": "f"}, back=True))
    return kernel(name, ("x", "v", "f", "power"), passes, after)


def pull_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    Args:
        learnt: By name of a number of groups, whether it is the same one for all.
    """
    item = pool.item
    by_x, by_v = (at_corners(each, item.corners) for each in ("by_x", "by_v"))
    by, moved = _of_items("by", pool), _of_group("moved", pool, len(pool.given))
    of_items = _adding(
        "pull_items", pool, pool.pulled, _OF_ITEMS | {"w": "weight"}, [*by_x, *moved, *by]
    )
    of_groups = add_loop(
        "pull_groups", _groups(pool), pool.pulled_groups([*learnt]),
        _OF_GROUPS | {"m": "moved"}, _of_group("again", pool, pool.count, 0),
        learnt=(pool.widths, learnt),
    )  # fmt: skip
    of_sums = _adding(
        "pull_sums", pool, pool.pulled_sums, STATE | {"s": "sums", "b": "again"},
        [*by_x, *by_v, *by],
    )  # fmt: skip
    passes = [
        *_of_state(pool), Pass(of_items, "items"),
        Pass(of_groups, "groups"), Pass(of_sums, "items"),
    ]  # fmt: skip
    return kernel(name, ("x", "v", "weight", "by_x", "by_v", "by"), passes)


def push_kernel(name: str, pool: TracedPool, learnt: Mapping[str, bool]) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``; arguments as ``pull_kernel``."""
    item = pool.item
    dx, dv = (at_corners(each, item.corners) for each in ("dx", "dv"))
    dn, dl = _of_items("dn", pool), _of_group("dl", pool, len(pool.given))
    of_sums = change_loop(
        "push_sums", _items(pool, 1), *pool.pushed_sums, STATE | {"s": "sums"}, [*dx, *dv, *dn],
        _of_group("ds", pool, pool.count), item.constants,
    )  # fmt: skip
    of_groups = change_loop(
        "push_groups", _groups(pool, 1), *pool.pushed_groups([*learnt]), _OF_GROUPS,
        _of_group("ds", pool, pool.count, 0), _of_group("dl", pool, len(pool.given), 0),
        learnt=(pool.widths, learnt),
    )  # fmt: skip
    of_items = change_loop(
        "push_items", _items(pool, 1), *pool.pushed, _OF_ITEMS, [*dx, *dl, *dn],
        at_corners("df", item.corners), item.constants,
    )  # fmt: skip
    passes = [
        *_of_state(pool),
        Pass(of_sums, "items"), Pass(of_groups, "groups"), Pass(of_items, "items"),
    ]  # fmt: skip
    return kernel(name, ("x", "v", "dx", "dv", "dn", "df", "room"), passes)


# --- items and groups -------------------------------------------------------------------------


def _items(pool: TracedPool, lanes: int = LANES) -> ItemLoop:
    """Return a loop over items."""
    return ItemLoop(pool.item.graph, pool.item.numbers, pool.places, lanes)


def _groups(pool: TracedPool, lanes: int = LANES) -> ItemLoop:
    """Return a loop over groups."""
    return ItemLoop(pool.graph, pool.numbers, 2, lanes)


def _of_group(
    vector: str, pool: TracedPool, count: int, corner: int | None = None
) -> list[Target]:
    """Return where numbers of a group are, given its place among the corners of an item."""
    return [(vector, (pool.group if corner is None else corner, k)) for k in range(count)]


def _of_items(vector: str, pool: TracedPool) -> list[Target]:
    """Return where the learnt numbers of an item are."""
    return [(vector, (place, 0)) for place in range(pool.group + 1, pool.places)]


def _adding(
    name: str, pool: TracedPool, outputs: Sequence[Number], vectors: Mapping[str, str],
    targets: Sequence[Target],
) -> LoopText:  # fmt: skip
    """Return the loop that adds those of some numbers of items that are not always zero."""
    pairs = [pair for pair in zip(outputs, targets, strict=True) if pair[0].value != 0.0]
    return add_loop(
        name, _items(pool), [each for each, _ in pairs], vectors, [to for _, to in pairs],
        pool.item.constants, more=[to for to, _ in targets],
    )  # fmt: skip


# --- passes -----------------------------------------------------------------------------------


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


def _of_state(pool: TracedPool) -> list[Pass]:
    """Return the passes that find the sums and factors of groups."""
    given = {"power": "spare"}
    return [
        _amounts(), _parts(pool, {}),
        Pass(group_loop(pool, pushes=False), "groups", given),
    ]  # fmt: skip


def _parts(pool: TracedPool, here: Mapping[str, str], lanes: int = LANES) -> Pass:
    """Return the pass that stores the rows of items; those that do not act have the first."""
    loop, constants = _items(pool, lanes), pool.item.constants
    found = storing_loop("parts", loop, pool.rows, constants, pool.shares.acts)
    return Pass(found, "items", {**here, "out": "stored"})


def _counting() -> list[str]:
    """Return the code that says how many bends are passed: at the last look, least and most."""
    code = Writer(1, "c")
    code.line("%counts = icmp ne i64 %groups.size, 0")
    code.line("br i1 %counts, label %count, label %counted")
    code.label("count")
    passed = code.add(f"fptosi double {code.load('%passed')} to i64")
    for k, how in enumerate(("", "slt", "sgt")):
        place = code.address("%bends", k, "i64")
        found = passed
        if how:
            before = code.load(place, "i64")
            test = code.add(f"icmp {how} i64 {passed}, {before}")
            found = code.add(f"select i1 {test}, i64 {passed}, i64 {before}")
        code.store(found, place, "i64")
    code.line("br label %counted")
    code.label("counted")
    return code.lines
