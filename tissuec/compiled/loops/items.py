"""Loops over items that have a few nodes each, such as hinges or triangles.

Nodes are gathered, and forces are added up in the order of items. ``LANES`` items are computed
at a time; the last ones are repeated to fill them, and these copies are left out of all sums.

The loops are functions of time, of vectors and of a table, as those of fields are; see
``compiled.calls``. In their text, a vector is the address of its numbers, which has its name.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.derivatives import along
from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.record_tables import layout
from tissuec.kernels.records import Floats, Integers

Indices = NDArray[np.int64]

LANES = 8  # fill the vectors of AVX-512; those of AVX2 need two instructions for each


class ItemTable(NamedTuple):
    """Items as loops read them.

    Attributes:
        size: Number of items.
        places: Three times the nodes, then the components of velocities that are internal
            variables, item by item, filled up to whole blocks of lanes.
        numbers: Numbers of the items: block by block, and in each one number of all its lanes
            after the other.
    """

    size: int
    places: Integers
    numbers: Floats

    @classmethod
    def of(
        cls, nodes: NDArray[np.integer], columns: Floats, slots: Indices | None = None
    ) -> Self:
        """Return a table.

        Args:
            nodes: Of the items, shape (item, corner).
            columns: Numbers of the items, in any unit, shape (number, item).
            slots: Components of velocities that are internal variables, shape (item, slot).
        """
        every = filled(len(nodes))
        places = 3 * nodes[every].astype(np.int64)
        if slots is not None:
            places = np.hstack([places, slots[every]])
        return cls(len(nodes), places.ravel(), blocked(columns, every))


def filled(count: int) -> Indices:
    """Return the numbers of items, and the last one as often as fills a block, shape (n,)."""
    return np.minimum(np.arange(_filled(count)), count - 1)


def _filled(count: int) -> int:
    """Return the number of items that fill blocks."""
    return -(-count // LANES) * LANES


def blocked(columns: NDArray[Any], every: Indices) -> NDArray[Any]:
    """Return columns block by block, and in each a column of all its lanes after the other.

    Args:
        columns: In any unit, shape (number, item).
        every: Numbers of the items that fill blocks, shape (block · lane,).
    """
    blocks = columns[:, every].reshape(len(columns), len(every) // LANES, LANES).swapaxes(0, 1)
    return np.ascontiguousarray(blocks).ravel()


def room_for(outputs: int | tuple[int, int], count: int) -> Floats:
    """Return room for the numbers of a ``record_loop``, in any unit.

    Args:
        outputs: Numbers of an item; or points of an item, and numbers of each.
        count: Number of items.

    Returns:
        Zeros of the shape (block, *outputs, lane).
    """
    each = outputs if isinstance(outputs, tuple) else (outputs,)
    return np.zeros((_filled(count) // LANES, *each, LANES))


def recorded(room: Floats, count: int) -> Floats:
    """Return the numbers in the room of a ``record_loop``, in any unit.

    The shape is (item, output), or (item, point, output).
    """
    return np.moveaxis(room, -1, 1).reshape(_filled(count), *room.shape[1:-1])[:count]


class LoopText(NamedTuple):
    """A function in LLVM's intermediate representation.

    Attributes:
        text: The function, and the intrinsic functions that it calls.
        called: Functions of ``compiled.mathematics`` that it calls, each with its lanes.
        name: Of the function.
        vectors: Names of those that it takes.
    """

    text: str
    called: tuple[tuple[str, int], ...]
    name: str
    vectors: tuple[str, ...]


_SUFFIX = {1: "f64", 4: "v4f64", 8: "v8f64"}
#: Reads three numbers into four lanes, and nothing after them.
_TRIPLE = "<4 x i1> <i1 true, i1 true, i1 true, i1 false>"


#: Where a number is in a vector: by corner of an item and component, or by its place.
Place: TypeAlias = tuple[int, int] | int | str
#: A vector, and where in it something is added.
Target: TypeAlias = tuple[str, Place]


class ItemLoop:
    """Writes one loop over items.

    Attributes:
        graph: Of what is computed.
        code: Writes it, of all lanes.
        corners: Nodes and internal variables of an item.
        room: Allocations in memory.
        first, active: The first item that is computed, and how many items are.
    """

    def __init__(self, graph: Graph, numbers: Sequence[Number], corners: int, lanes: int):
        self.graph, self.code, self.corners = graph, Writer(lanes), corners
        self.code.block = "body"
        self._numbers = [str(each.operation.detail) for each in numbers]
        self.room: list[str] = []  # allocations
        self.first, self.active = "%first", "%active"

    @classmethod
    def of(cls, item: TracedItem, lanes: int) -> "ItemLoop":
        """Return a loop over items whose potential was traced."""
        return cls(item.graph, item.numbers, item.corners + item.seen + item.slots, lanes)

    # --- reading ----------------------------------------------------------------------------

    def places(self) -> list[list[str]]:
        """Return three times the nodes, by corner and lane."""
        code, corners = self.code, self.corners
        first = code.add(f"mul i64 {self.first}, {corners}")
        base = code.address("%places", first, "i64")
        return [
            [
                code.load(code.address(base, lane * corners + corner, "i64"), "i64")
                for lane in range(code.lanes)
            ]
            for corner in range(corners)
        ]

    def gather(self, vector: str, places: Sequence[str]) -> list[str]:
        """Return the three components of a vector at one node of each lane.

        Args:
            vector: Its name.
            places: Three times the nodes of all lanes.
        """
        code = self.code
        at = [code.address(f"%{vector}", place) for place in places]
        if code.lanes == 1:
            return [code.load(code.address(at[0], axis)) for axis in range(3)]
        call = "call <4 x double> @llvm.masked.load.v4f64.p0"
        rows = [
            code.add(f"{call}(ptr {place}, i32 8, {_TRIPLE}, <4 x double> zeroinitializer)")
            for place in at
        ]
        fours = [self._transposed(rows[k : k + 4]) for k in range(0, code.lanes, 4)]
        if len(fours) == 1:
            return fours[0]
        return [
            _shuffled(code, 4, low, high, range(8)) for low, high in zip(*fours, strict=True)
        ]

    def gather_slot(self, vector: str, places: Sequence[str]) -> str:
        """Return one component of a vector for each lane."""
        code = self.code
        numbers = [code.load(code.address(f"%{vector}", each), "double") for each in places]
        if code.lanes == 1:
            return numbers[0]
        found = "poison"
        for lane, number in enumerate(numbers):
            found = code.add(f"insertelement {code.kind} {found}, double {number}, i64 {lane}")
        return found

    def _transposed(self, rows: Sequence[str]) -> list[str]:
        """Return three vectors of four lanes from four rows of three components."""
        code, (a, b, c, d) = self.code, rows
        halves = (a, b), (c, d)
        x_and_z = [_shuffled(code, 4, p, q, (0, 4, 2, 6)) for p, q in halves]
        y = [_shuffled(code, 4, p, q, (1, 5, 3, 7)) for p, q in halves]
        low, high = (0, 1, 4, 5), (2, 3, 6, 7)
        return [
            _shuffled(code, 4, one, other, order)
            for (one, other), order in ((x_and_z, low), (y, low), (x_and_z, high))
        ]

    def inputs(
        self, outputs: Sequence[Number], vectors: Mapping[str, str], known: Sequence[int]
    ) -> tuple[dict[str, str], dict[int, str]]:
        """Return the names of the inputs that outputs need, and of constants of the items.

        Args:
            vectors: By the letter of inputs, the vector that they are of; a.0 and a.1 are in
                one that all items share. There is also "time".
            known: Places of the constants, which numbers of the table have after its own.
        """
        needed = self.graph.inputs_of(outputs)
        values, places = dict[str, str](), None
        code, names = self.code, self._numbers
        for letter, vector in vectors.items():
            for corner in range(self.corners):
                if any(name.startswith(f"{letter}.{corner}.") for name in needed):
                    places = places or self.places()
                    for axis, value in enumerate(self.gather(vector, places[corner])):
                        values[f"{letter}.{corner}.{axis}"] = value
                name = f"{letter}.slot.{corner}"
                if name in needed:
                    places = places or self.places()
                    values[name] = self.gather_slot(vector, places[corner])
            for name in sorted(needed.intersection(("a.0", "a.1")) if letter == "a" else ()):
                one = code.load(code.address(f"%{vector}", name[2:]), "double")
                values[name] = code.in_all_lanes(one)
        if "time" in needed:
            values["time"] = code.in_all_lanes("%time")
        base = self.row_of_blocks("numbers", len(names) + len(known))
        for k, name in enumerate(names):
            if name in needed:
                values[name] = code.load(code.address(base, k * LANES))
        constants = {
            place: code.load(code.address(base, (len(names) + k) * LANES))
            for k, place in enumerate(known)
        }
        return values, constants

    def row_of_blocks(self, array: str, rows: int) -> str:
        """Return where the first row of the items is in an array of blocks of LANES items."""
        code = self.code
        lane = code.add(f"urem i64 {self.first}, {LANES}")
        block = code.add(f"mul i64 {code.add(f'sub i64 {self.first}, {lane}')}, {rows}")
        return code.address(f"%{array}", code.add(f"add i64 {block}, {lane}"))

    # --- writing ----------------------------------------------------------------------------

    def room_of(self, rows: int) -> str:
        """Return the address of memory for some values."""
        name = f"%room.{len(self.room)}"
        self.room.append(f"  {name} = alloca [{rows} x {self.code.kind}], align 64")
        return name

    def row(self, room: str, index: str | int) -> str:
        """Return the address of a value in memory."""
        return self.code.address(room, index, self.code.kind)

    def put(self, value: str, room: str, index: str | int) -> None:
        """Store a value in memory."""
        self.code.store(value, self.row(room, index), align=self.code.size)

    def keep(self, values: Sequence[str]) -> str:
        """Return the address of values that are stored, for ``kept`` to read."""
        room = self.room_of(len(values))
        for k, value in enumerate(values):
            self.put(value, room, k)
        return room

    def repeat(self, name: str, count: str | int, write: Callable[[str], None]) -> None:
        """Write a loop.

        Args:
            name: Of the loop; its label NAME.end ends a round.
            count: How often it runs, at least once.
            write: Writes a round, given its number.
        """
        code, before = self.code, self.code.block
        code.line(f"br label %{name}")
        code.label(name)
        code.line(f"%{name}.k = phi i64 [ 0, %{before} ], [ %{name}.next, %{name}.end ]")
        write(f"%{name}.k")
        code.line(f"br label %{name}.end")
        code.label(f"{name}.end")
        code.line(f"%{name}.next = add i64 %{name}.k, 1")
        code.line(f"%{name}.more = icmp ult i64 %{name}.next, {count}")
        code.line(f"br i1 %{name}.more, label %{name}, label %{name}.out")
        code.label(f"{name}.out")

    def each_lane(self, write: Callable[[], None]) -> None:
        """Write a loop over the lanes that are items; %lane is its number, %item the item."""

        def of_lane(lane: str) -> None:
            self.code.line(f"%lane = add i64 {lane}, 0")
            self.code.line(f"%item = add i64 {self.first}, %lane")
            write()

        self.repeat("lanes", self.active, of_lane)

    def kept(self, room: str, row: int, lane: str = "%lane") -> str:
        """Return the number of a lane in a stored value."""
        code = self.code
        index = code.add(f"add i64 {lane}, {row * code.lanes}")
        return code.load(code.address(room, index), "double")

    def add_to(self, place: str, value: str) -> None:
        """Add a number to one in memory."""
        code = self.code
        sum_ = code.add(f"fadd double {code.load(place, 'double')}, {value}")
        code.store(sum_, place, "double")

    def scatter(self, room: str, targets: Sequence["Target"]) -> None:
        """Add stored values of the present lane, one after the other, where targets are."""
        code, first = self.code, self.code.add(f"mul i64 %item, {self.corners}")
        bases = dict[tuple[str, int], str]()
        nodes = dict[int, str]()
        for row, (vector, at) in enumerate(targets):
            if isinstance(at, tuple):
                corner, at = at
                if corner not in nodes:
                    own = code.address("%places", code.add(f"add i64 {first}, {corner}"), "i64")
                    nodes[corner] = code.load(own, "i64")
                if (vector, corner) not in bases:
                    bases[vector, corner] = code.address(f"%{vector}", nodes[corner])
                place = code.address(bases[vector, corner], at)
            else:
                place = code.address(f"%{vector}", at)
            self.add_to(place, self.kept(room, row))

    # --- the function -----------------------------------------------------------------------

    def text(
        self, name: str, vectors: Sequence[str], record: type[Any] = ItemTable, *,
        items: tuple[str, str] = ("0", "%size"), after: Sequence[str] = (),
    ) -> LoopText:  # fmt: skip
        """Return the function.

        Args:
            name: Of it.
            vectors: Their names.
            record: Class of its table.
            items: The first item, and the one after the last.
            after: What is written after the loop.
        """
        code, (begin, end) = self.code, items
        lines = [
            *head(name, vectors, record),
            *self.room,
            f"  %block.first = udiv i64 {begin}, {code.lanes}",
            f"  %beyond = add i64 {end}, {code.lanes - 1}",
            f"  %blocks = udiv i64 %beyond, {code.lanes}",
            "  br label %head",
            "head:",
            "  %block = phi i64 [ %block.first, %entry ], [ %block.next, %end ]",
            "  %more = icmp ult i64 %block, %blocks",
            "  br i1 %more, label %body, label %done",
            "body:",
            f"  %first = mul i64 %block, {code.lanes}",
            "  %left = sub i64 %size, %first",
            f"  %few = icmp ult i64 %left, {code.lanes}",
            f"  %active = select i1 %few, i64 %left, i64 {code.lanes}",
            *code.lines,
            "  br label %end",
            "end:",
            "  %block.next = add i64 %block, 1",
            "  br label %head",
            "done:",
            *after,
            "  ret void",
            "}",
            *declarations(code.lanes),
        ]
        called = tuple(sorted(code.called))
        return LoopText("\n".join(lines) + "\n", called, name, tuple(vectors))


def _shuffled(code: Writer, width: int, one: str, other: str, order: Sequence[int]) -> str:
    kind, mask = f"<{width} x double>", ", ".join(f"i32 {k}" for k in order)
    return code.add(
        f"shufflevector {kind} {one}, {kind} {other}, <{len(order)} x i32> <{mask}>"
    )


def head(name: str, vectors: Sequence[str], record: type[Any]) -> list[str]:
    """Return the head of a function, and what reads its table.

    Of a record in it, %NAME is its address, and %NAME.size what comes first in it.
    """
    parts = [
        f"ptr %{each}.m, ptr %{each}.p, i64 %{each}.n, i64 %{each}.s, ptr noalias %{each}, "
        f"i64 %{each}.shape, i64 %{each}.stride"
        for each in vectors
    ]
    lines = [f"define void @{name}({', '.join(['double %time', *parts, 'ptr %table'])}) {{"]
    lines.append("entry:")
    for field, words in layout(record)[0].items():
        at, to, kind = f"word.{field}", field, "i64" if words.kind is int else "ptr"
        if words.kind is not int and words.dtype is None:
            at, to, kind = field, f"{field}.size", "i64"
        lines.append(f"  %{at} = getelementptr i64, ptr %table, i64 {words.place}")
        lines.append(f"  %{to} = load {kind}, ptr %{at}, align 8")
    return lines


def declarations(lanes: int) -> list[str]:
    """Return the declarations of the intrinsic functions that loops call."""
    kinds = {1: "double"} | {k: f"<{k} x double>" for k in (4, 8)}
    kind, suffix = kinds[lanes], _SUFFIX[lanes]
    bits, four = f"<{lanes} x i1>", "<4 x double>"
    found = [
        f"declare {kind} @llvm.fma.{suffix}({kind}, {kind}, {kind})",
        f"declare {kind} @llvm.sqrt.{suffix}({kind})",
        f"declare {kind} @llvm.fabs.{suffix}({kind})",
        f"declare {four} @llvm.masked.load.v4f64.p0(ptr, i32, <4 x i1>, {four})",
    ]
    if lanes == 8:
        found.append(f"declare {kind} @llvm.masked.load.v8f64.p0(ptr, i32, {bits}, {kind})")
    if lanes > 1:
        found.append(f"declare void @llvm.masked.store.{suffix}.p0({kind}, ptr, i32, {bits})")
    return found


# --- the loops --------------------------------------------------------------------------------

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


def at_corners(vector: str, corners: int) -> list[Target]:
    """Return the components of a vector at the first corners of an item."""
    return [(vector, (corner, axis)) for corner in range(corners) for axis in range(3)]


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
    loop = ItemLoop.of(item, lanes)
    code = loop.code
    values, known = loop.inputs(outputs, STATE, [each.place for each in constants])
    base = loop.row_of_blocks("out", len(outputs))
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


def places_of_numbers(
    loop: ItemLoop, widths: Mapping[str, int], learnt: Mapping[str, bool], item: str = "%item"
) -> list[str]:
    """Return where the numbers of an item are among all learnt ones.

    Args:
        learnt: By name of a number, whether it is the same one for all items.
    """
    code, found, start = loop.code, list[str](), "0"
    for name, is_shared in learnt.items():
        width = widths[name]
        own = start
        if not is_shared:
            own = code.add(f"add i64 {start}, {code.add(f'mul i64 {item}, {width}')}")
        found += [code.add(f"add i64 {own}, {k}") for k in range(width)]
        size = str(width) if is_shared else code.add(f"mul i64 %size, {width}")
        start = code.add(f"add i64 {start}, {size}")
    return found


class Changes(Writer):
    """Writes a loop over changes, which are in the lanes, within a loop over single items."""

    def __init__(self, loop: ItemLoop):
        super().__init__(LANES, "m")
        self._loop, self._outer, self.lines = loop, loop.code, loop.code.lines

    # --- before the loop, or between its rounds -----------------------------------------------

    def apart(
        self, outputs: Sequence[Number], changing: Iterable[Number], state: Mapping[str, str],
        constants: Sequence[int] = (), more: Mapping[str, str] | None = None,
    ) -> dict[int, str]:  # fmt: skip
        """Write what outputs need and what does not depend on changes; return it by places.

        Args:
            state, constants: As ``vectors`` and ``known`` of ``ItemLoop.inputs``.
            more: Names of the values of further inputs.
        """
        still = self._loop.graph.apart_from(outputs, changing)
        values, known = self._loop.inputs(still, state, constants)
        written = self._outer.write(still, {**values, **(more or {})}, known)
        return {
            each.place: self.in_all_lanes(value, "i1" if each.is_condition else "double")
            for each, value in zip(still, written, strict=True)
        }

    def rows(self, targets: Sequence[Target]) -> list[tuple[str, str]]:
        """Return vectors and where the changes of numbers begin in them; of the item."""
        code, nodes = self._outer, [place for (place,) in self._loop.places()]

        def row(at: Place) -> str:
            own = code.add(f"add i64 {nodes[at[0]]}, {at[1]}") if isinstance(at, tuple) else at
            return code.add(f"mul i64 {own}, %room.shape")

        return [(vector, row(at)) for vector, at in targets]

    # --- in the loop ------------------------------------------------------------------------

    def begin(self) -> None:
        """Begin the loop."""
        before, lanes = self._outer.block, ", ".join(f"i64 {k}" for k in range(LANES))
        self.line("br label %changes")
        self.label("changes")
        self.line(f"%change = phi i64 [ 0, %{before} ], [ %change.next, %changes.end ]")
        self.line("%change.left = sub i64 %room.shape, %change")
        whole = f"<{LANES} x i64>"
        left = self.in_all_lanes("%change.left", "i64")
        self.line(f"%mask = icmp ugt {whole} {left}, <{lanes}>")
        self._outer.block = self.block

    def given(
        self, outputs: Sequence[Number], rates: Iterable[str], rows: Sequence[tuple[str, str]]
    ) -> dict[str, str]:
        """Return the changes that outputs need, by the names of their inputs in order."""
        needed = self._loop.graph.inputs_of(outputs)
        pairs = zip(rates, rows, strict=True)
        return {rate: self._masked(self._at(*row)) for rate, row in pairs if rate in needed}

    def add_to_rows(self, rows: Sequence[tuple[str, str]], values: Sequence[str]) -> None:
        """Add values to changes."""
        for row, value in zip(rows, values, strict=True):
            place = self._at(*row)
            total = self.add(f"fadd {self.kind} {self._masked(place)}, {value}")
            given = f"{self.kind} {total}, ptr {place}, i32 8, {self.condition} %mask"
            self.line(f"call void @llvm.masked.store.{_SUFFIX[LANES]}.p0({given})")

    def _at(self, vector: str, row: str) -> str:
        return self.address(f"%{vector}", self.add(f"add i64 {row}, %change"))

    def _masked(self, place: str) -> str:
        given = f"ptr {place}, i32 8, {self.condition} %mask, {self.kind} zeroinitializer"
        name = f"llvm.masked.load.{_SUFFIX[LANES]}.p0"
        return self.add(f"call {self.kind} @{name}({given})")

    def end(self) -> None:
        """End the loop."""
        self.line("br label %changes.end")
        self.label("changes.end")
        self.line(f"%change.next = add i64 %change, {LANES}")
        self.line("%change.more = icmp ult i64 %change.next, %room.shape")
        self.line("br i1 %change.more, label %changes, label %changes.out")
        self.label("changes.out")
        self._outer.block = self.block
        self._outer.called |= self.called


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


def change_loop(
    name: str, loop: ItemLoop, outputs: Sequence[Number], rates: Iterable[str],
    vectors: Mapping[str, str], sources: Sequence[Target], targets: Sequence[Target],
    constants: Sequence[Number] = (), *,
    learnt: tuple[Mapping[str, int], Mapping[str, bool]] = ({}, {}),
) -> LoopText:  # fmt: skip
    """Return a loop that adds changes, which are in its lanes.

    Args:
        loop: Over single items.
        rates: Inputs that are changes, in the order of their sources.
        sources: Where changes are; the last ones, those of numbers, are in "dn".
        vectors, targets, constants, learnt: As those of ``add_loop``.
    """
    rates, many = tuple(rates), Changes(loop)
    known = [each.place for each in constants]
    spread = many.apart(outputs, map(loop.graph.input, rates), vectors, known)
    numbers = places_of_numbers(loop, *learnt, "%first")
    sources = [*sources, *(("dn", at) for at in numbers)]
    given, to = many.rows(sources), many.rows(targets)
    many.begin()
    many.add_to_rows(to, many.write(outputs, many.given(outputs, rates, given), spread))
    many.end()
    named = (*vectors.values(), *(each for each, _ in (*sources, *targets)), "room")
    return loop.text(name, tuple(dict.fromkeys(named)))


def product_loop(
    name: str, item: TracedItem, slopes: Sequence[Number], by: Sequence[Number],
    lanes: int = LANES,
) -> LoopText:  # fmt: skip
    """Return the loop that adds a matrix times a vector: how slopes change along it.

    Args:
        slopes: Of the nodes of an item, such as ∂E/∂x, shape (3 corner,).
        by: By what they are differentiated, such as x, shape (3 corner,).
        lanes: Items that are computed at a time.
    """
    outputs = along(slopes, dict(zip(by, item.weights, strict=True)))
    return add_loop(
        name,
        ItemLoop.of(item, lanes),
        outputs,
        STATE | {"w": "weight"},
        at_corners("f", item.corners),
        item.constants,
    )
