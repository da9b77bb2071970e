"""The frame of loops over items that have a few nodes each.

Nodes are gathered, and forces are added up in the order of items. ``LANES`` items are computed
at a time; the last ones are repeated to fill them, and these copies are left out of all sums.

The loops are functions of time, of vectors and of a table, as those of fields are; see
``compiled.calls``. In their text, a vector is the address of its numbers, which has its name.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.potentials import TracedItem
from tissuec.compiled.loops.tables import LANES, ItemTable
from tissuec.compiled.record_tables import layout


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


SUFFIX = {1: "f64", 4: "v4f64", 8: "v8f64"}
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

    def row_of_blocks(self, array: str, rows: int, first: str = "") -> str:
        """Return where the first row of the items is in an array of blocks of LANES items."""
        code, first = self.code, first or self.first
        lane = code.add(f"urem i64 {first}, {LANES}")
        block = code.add(f"mul i64 {code.add(f'sub i64 {first}, {lane}')}, {rows}")
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


def transposed(code: Writer, square: Sequence[str]) -> list[str]:
    """Return as many vectors as they have lanes, transposed: lanes become vectors.

    Rows and columns whose numbers differ in one bit change places, bit by bit.
    """
    found, width = list(square), len(square)
    bit = 1
    while bit < width:
        for low in (k for k in range(width) if not k & bit):
            one, other = found[low], found[low | bit]
            lower = [k + width - bit if k & bit else k for k in range(width)]
            upper = [k + width if k & bit else k + bit for k in range(width)]
            found[low] = _shuffled(code, width, one, other, lower)
            found[low | bit] = _shuffled(code, width, one, other, upper)
        bit *= 2
    return found


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
    kind, suffix = kinds[lanes], SUFFIX[lanes]
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


def at_corners(vector: str, corners: int) -> list[Target]:
    """Return the components of a vector at the first corners of an item."""
    return [(vector, (corner, axis)) for corner in range(corners) for axis in range(3)]


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
