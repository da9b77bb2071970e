"""Loops over pairs in groups, such as a node and the faces of a surface; see ``TracedPair``.

``LANES`` groups are computed at a time, pair by pair: first what is pooled, then what depends
on it. Groups are sorted by their numbers of pairs, so that few lanes are empty.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Number
from tissuec.autodiff.groups import TracedPair
from tissuec.compiled.loops.items import (
    LANES,
    STATE,
    Changes,
    ItemLoop,
    LoopText,
    at_corners,
    blocked,
)
from tissuec.kernels.records import Floats, GroupTable, Integers


def grouped(
    group: NDArray[np.integer],
    nodes: NDArray[np.integer],
    columns: Floats,
    own: NDArray[np.integer],
    bends: Integers,
) -> GroupTable:
    """Return a table.

    Args:
        group: Of each pair; those of a group are in succession, shape (pair,).
        nodes: Of the pairs, shape (pair, corner).
        columns: Numbers of the pairs, in any unit, shape (number, pair).
        own: Place of the learnt number of each, shape (pair,).
        bends: Where those that are passed are counted, shape (3,).
    """
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    counts = np.diff(begins, append=len(group))
    order = np.argsort(-counts, kind="stable")
    begins, counts = begins[order], counts[order]
    rows = counts[::LANES]
    first = np.cumsum(rows) - rows
    each = np.arange(len(counts)).repeat(counts)  # place of the group of each pair
    rank = np.arange(len(each)) - (np.cumsum(counts) - counts)[each]
    slot = (first[each // LANES] + rank) * LANES + each % LANES
    pair = np.full(int(rows.sum()) * LANES, -1)
    pair[slot] = begins[each] + rank
    # Empty lanes have the nodes of some pair, on which nothing acts.
    numbers = np.where(pair >= 0, columns[:, pair], 0.0) if len(pair) else columns
    return GroupTable(
        len(counts),
        (3 * nodes[pair].astype(np.int64)).ravel(),
        blocked(numbers, np.arange(len(pair))),
        counts.astype(np.int64),
        first.astype(np.int64),
        np.count_nonzero(pair.reshape(-1, LANES) >= 0, axis=1).astype(np.int64),
        own[pair].astype(np.int64),
        press_first=0,
        press_end=len(counts),
        add_first=0,
        add_end=len(counts),
        pushed=np.zeros(len(pair) * (1 + 3 * nodes.shape[1])),
        sums=np.zeros(3 * LANES * len(rows)),
        bends=bends,
    )


def in_parts(table: GroupTable, parts: int) -> list[list[GroupTable]]:
    """Return tables that compute forces of about equally many rows, and one that adds them."""
    rows = len(table.widths)
    blocks = np.searchsorted(table.rows, np.linspace(0, rows, parts + 1)[:-1])
    cuts = [*np.minimum(LANES * blocks, table.size).tolist(), table.size]
    pressing = [
        table._replace(press_first=first, press_end=end, add_end=0)
        for first, end in pairwise(cuts)
    ]
    return [pressing, [table._replace(press_end=0)]]


class _Groups(ItemLoop):
    """Writes one loop over groups; with one lane, over single ones."""

    def __init__(self, pair: TracedPair, lanes: int):
        super().__init__(pair.graph, pair.numbers, pair.corners, lanes)
        self.pair, code = pair, self.code
        block = code.add(f"udiv i64 %first, {LANES}")
        self._lane = code.add(f"urem i64 %first, {LANES}")
        self._row = code.load(code.address("%rows", block, "i64"), "i64")
        self._rows = code.load(code.address("%counts", "%first", "i64"), "i64")
        self._go_to("0")

    def _go_to(self, k: str) -> None:
        code = self.code
        row = code.add(f"add i64 {self._row}, {k}")
        first = code.add(f"mul i64 {row}, {LANES}")
        self.first = code.add(f"add i64 {first}, {self._lane}")
        self.active = code.load(code.address("%widths", row, "i64"), "i64")

    def each_pair(self, name: str, write: Callable[[], None]) -> None:
        """Write a loop over the pairs of a group; its name is that of its blocks."""

        def of_pair(k: str) -> None:
            self._go_to(k)
            write()

        self.repeat(name, self._rows, of_pair)

    def own(self, item: str) -> str:
        """Return the place of the learnt number of a pair."""
        return self.code.load(self.code.address("%own", item, "i64"), "i64")

    def pool(
        self, vectors: Mapping[str, str], names: Sequence[str],
        write: Callable[[dict[str, str]], None] | None = None,
    ) -> dict[str, str]:  # fmt: skip
        """Write what is pooled; return it, and the damping of the group, as values of inputs.

        Args:
            vectors: As for ``inputs``.
            names: Of what is added up.
            write: Writes more of each pair, given the values of inputs.
        """
        code, pair = self.code, self.pair
        values, _ = self.inputs(pair.pace, {}, [])
        room = self.keep([code.constant(0.0)] * len(names))

        def read() -> dict[str, str]:
            rows = (self.row(room, k) for k in range(len(names)))
            loads = [code.load(row, align=code.size) for row in rows]
            return {f"g.{name}": value for name, value in zip(names, loads, strict=True)}

        def add() -> None:
            outputs = [pair.added(name) for name in names]
            given, _ = self.inputs([*outputs, *pair.stored], vectors, [])
            if write:
                write(given)
            for k, value in enumerate(code.write(outputs, given | read())):
                self.put(value, room, k)

        self.each_pair("pool", add)
        return values | read()

    def paced(self, pooled: dict[str, str]) -> dict[str, str]:
        """Return pooled quantities together with the pace that follows from them."""
        names = ("g.factor", "g.by_steady", "g.by_closing")
        pace = self.code.write(self.pair.pace, pooled)
        return pooled | dict(zip(names, pace, strict=True))


def force_loop(name: str, pair: TracedPair, lanes: int = LANES) -> LoopText:
    """Return the loop that adds the forces of pairs, and the power that groups dissipate.

    Parts of the groups store what they do, and then all is added in the order of rows, so that
    sums do not depend on parts. Pairs that do not touch cost their depth alone.

    Args:
        lanes: Groups that are computed at a time.
    """
    loop, size = _Groups(pair, lanes), 1 + 3 * pair.corners
    code, names = loop.code, ["pressure", "most", "bends"]
    if pair.has_pace:
        names.append("closing")

    def store(given: dict[str, str]) -> None:
        depth, touches = code.write([pair.depth, pair.depth > 0.0], given)
        base = loop.row_of_blocks("pushed", size)
        code.store(depth, base)
        code.line(f"br i1 {code.any(touches)}, label %pool.some, label %pool.end")
        code.label("pool.some")
        for k, value in enumerate(code.write(pair.stored, given)):
            code.store(value, code.address(base, (k + 1) * LANES))

    pooled = loop.pool(STATE, names, store)
    loop.first = "%first"
    base = loop.row_of_blocks("sums", 3)
    for k, value in enumerate(code.write(pair.ends, pooled)):
        code.store(value, code.address(base, k * LANES))
    after = _adding(loop, size)
    groups = "%press_first", "%press_end"
    return loop.text(name, ("x", "v", "f", "power"), GroupTable, items=groups, after=after)


def _adding(loop: _Groups, size: int) -> list[str]:
    """Return the code that adds up the forces that ``force_loop`` has stored.

    Args:
        size: Stored rows of each pair.
    """
    pressing, loop.code = loop.code, Writer(1, "a")
    code, corners = loop.code, loop.corners
    code.block = "done"
    lost, bends = (loop.keep([code.constant(0.0)]) for _ in range(2))
    code.line("%adds = icmp ult i64 %add_first, %add_end")
    code.line("br i1 %adds, label %adding, label %added")
    code.label("adding")
    begin = code.add(f"udiv i64 %add_first, {LANES}")
    end = code.add(f"udiv i64 {code.add(f'add i64 %add_end, {LANES - 1}')}, {LANES}")

    def of_block(k: str) -> None:
        block = code.add(f"add i64 {begin}, {k}")
        sums = code.address("%sums", code.add(f"mul i64 {block}, {3 * LANES}"))
        for total, row in ((lost, 1), (bends, 2)):
            for lane in range(LANES):
                loop.add_to(total, code.load(code.address(sums, row * LANES + lane)))
        first = code.load(code.address("%rows", block, "i64"), "i64")
        group = code.add(f"mul i64 {block}, {LANES}")
        count = code.load(code.address("%counts", group, "i64"), "i64")
        loop.repeat(
            "add.rows", count, lambda j: of_row(code.add(f"add i64 {first}, {j}"), sums)
        )

    def of_row(row: str, sums: str) -> None:
        pushed = code.address("%pushed", code.add(f"mul i64 {row}, {size * LANES}"))
        pair = code.add(f"mul i64 {row}, {LANES}")
        active = code.load(code.address("%widths", row, "i64"), "i64")
        loop.repeat("add.lanes", active, lambda lane: of_pair(lane, pair, pushed, sums))

    def of_pair(lane: str, pair: str, pushed: str, sums: str) -> None:
        own = code.address(pushed, lane)
        touches = code.add(f"fcmp ogt double {code.load(own)}, {code.constant(0.0)}")
        code.line(f"br i1 {touches}, label %add.pair, label %add.lanes.end")
        code.label("add.pair")
        factor = code.load(code.address(sums, lane))
        first = code.add(f"mul i64 {code.add(f'add i64 {pair}, {lane}')}, {corners}")
        for corner in range(corners):
            at = code.address("%places", code.add(f"add i64 {first}, {corner}"), "i64")
            base = code.address("%f", code.load(at, "i64"))
            for axis in range(3):
                slope = code.load(code.address(own, (1 + 3 * corner + axis) * LANES))
                place = code.address(base, axis)
                code.store(code.fused(factor, slope, code.load(place)), place)

    loop.repeat("add.blocks", code.add(f"sub i64 {end}, {begin}"), of_block)
    loop.add_to(code.address("%power", 1), code.load(lost))
    _count(code, bends)
    code.line("br label %added")
    code.label("added")
    loop.code = pressing
    return code.lines


def _count(code: Writer, bends: str) -> None:
    """Write how many bends are passed: at the last look, least and most."""
    passed = code.add(f"fptosi double {code.load(bends)} to i64")
    for k, how in enumerate(("", "slt", "sgt")):
        place = code.address("%bends", k, "i64")
        found = passed
        if how:
            before = code.load(place, "i64")
            test = code.add(f"icmp {how} i64 {passed}, {before}")
            found = code.add(f"select i1 {test}, i64 {passed}, i64 {before}")
        code.store(found, place, "i64")


def pull_loop(name: str, pair: TracedPair, learnt: str, lanes: int = LANES) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    Args:
        learnt: The number of pairs by which there are derivatives.
        lanes: Groups that are computed at a time.
    """
    loop, outputs = _Groups(pair, lanes), pair.pulled((learnt,))
    vectors = STATE | {"w": "weight"}
    pooled = loop.paced(loop.pool(vectors, ("pressure", "most", "closing", "work")))

    def pull() -> None:
        values, _ = loop.inputs(outputs, vectors, [])
        room = loop.keep(loop.code.write(outputs, values | pooled))

        def write() -> None:
            by = [*at_corners("by_x", pair.corners), *at_corners("by_v", pair.corners)]
            loop.scatter(room, [*by, ("by", loop.own("%item"))])

        loop.each_lane(write)

    loop.each_pair("pull", pull)
    return loop.text(name, ("x", "v", "weight", "by_x", "by_v", "by"), GroupTable)


def push_loop(name: str, pair: TracedPair, learnt: str) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``, with changes in the lanes.

    The arguments are those of ``pull_loop``.
    """
    loop = _Groups(pair, 1)
    many = Changes(loop)
    outputs, rates = pair.pushed((learnt,))
    pooled = loop.paced(loop.pool(STATE, ("pressure", "most", "closing")))
    total = loop.room_of(LANES)
    many.begin()
    many.store(many.constant(0.0), total, align=many.size)

    def changed(outputs: Sequence[Number], more: dict[str, str]) -> list[str]:
        changing = [*rates.values(), pair.pooled("change")]
        spread = many.apart(outputs, changing, STATE, more=pooled)
        moves = [*at_corners("dx", pair.corners), *at_corners("dv", pair.corners)]
        rows = many.rows([*moves, ("dn", loop.own(loop.first))])
        return many.write(outputs, many.given(outputs, rates, rows) | more, spread)

    def pace() -> None:
        (value,) = changed(outputs[-1:], {})
        before = many.load(total, align=many.size)
        many.store(many.add(f"fadd {many.kind} {before}, {value}"), total, align=many.size)

    def push() -> None:
        more = {"g.change": many.load(total, align=many.size)}
        to = many.rows(at_corners("df", pair.corners))
        many.add_to_rows(to, changed(outputs[:-1], more))

    loop.each_pair("pace", pace)
    loop.each_pair("push", push)
    many.end()
    return loop.text(name, ("x", "v", "dx", "dv", "dn", "df", "room"), GroupTable)
