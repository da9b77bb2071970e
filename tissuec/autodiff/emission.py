"""Graphs as LLVM's intermediate representation, for several items in the lanes of vectors.

Products that are only added are fused with that sum explicitly, as in ``compiled.fusing``, so
that results have the same bits on every processor, and in any number of lanes.
"""

import struct
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import cast

from tissuec.autodiff.graph import Graph, Iteration, Number

#: Functions that are called, by operation: of ``compiled.mathematics``.
CALLED = {"exp": "exp", "log": "log", "sin": "sin", "cos": "cos", "power": "pow"}
_INSTRUCTIONS = {"sum": "fadd", "difference": "fsub", "product": "fmul", "quotient": "fdiv"}
_EXTREMES = {"maximum": "ogt", "minimum": "olt"}


class Writer:
    """Writes the instructions of a function.

    Attributes:
        lanes: Numbers side by side in each value.
        kind, condition: Types of values and of conditions.
        lines: The text so far.
        block: Label of the block that is written.
        called: Functions of ``compiled.mathematics`` that are called, each with its lanes.
    """

    def __init__(self, lanes: int, prefix: str = "v"):
        self.lanes, self.lines, self.block = lanes, list[str](), "entry"
        self.called: set[tuple[str, int]] = set()
        self._prefix, self._count = prefix, 0
        self.kind, self.condition = map(self._side_by_side, ("double", "i1"))
        self._suffix = "f64" if lanes == 1 else f"v{lanes}f64"

    # --- types and constants --------------------------------------------------------------

    def _side_by_side(self, kind: str) -> str:
        return kind if self.lanes == 1 else f"<{self.lanes} x {kind}>"

    @property
    def size(self) -> int:
        """Return the size of a value [byte]."""
        return 8 * self.lanes

    def constant(self, value: float) -> str:
        """Return a value that is the same in all lanes."""
        (word,) = struct.unpack("<Q", struct.pack("<d", value))
        return f"0x{word:016X}" if self.lanes == 1 else f"splat (double 0x{word:016X})"

    # --- instructions ---------------------------------------------------------------------

    def add(self, text: str) -> str:
        """Write an instruction; return the name of its result."""
        self._count += 1
        name = f"%{self._prefix}{self._count}"
        self.lines.append(f"  {name} = {text}")
        return name

    def line(self, text: str) -> None:
        """Write an instruction without a result."""
        self.lines.append(f"  {text}")

    def label(self, name: str) -> None:
        """Begin a block."""
        self.lines.append(f"{name}:")
        self.block = name

    def address(self, base: str, index: str | int, kind: str = "double") -> str:
        """Return where an element of an array is."""
        return self.add(f"getelementptr {kind}, ptr {base}, i64 {index}")

    def load(self, place: str, kind: str | None = None, align: int = 8) -> str:
        """Return the value at an address: by default, as many numbers as there are lanes."""
        return self.add(f"load {kind or self.kind}, ptr {place}, align {align}")

    def store(self, value: str, place: str, kind: str | None = None, align: int = 8) -> None:
        """Write what ``load`` reads."""
        self.line(f"store {kind or self.kind} {value}, ptr {place}, align {align}")

    def in_all_lanes(self, one: str, kind: str = "double") -> str:
        """Return a value from one number, or from one word or condition of another kind."""
        if self.lanes == 1:
            return one
        many = self._side_by_side(kind)
        first = self.add(f"insertelement {many} poison, {kind} {one}, i64 0")
        mask = f"<{self.lanes} x i32> zeroinitializer"
        return self.add(f"shufflevector {many} {first}, {many} poison, {mask}")

    def of_lane(self, value: str, lane: int) -> str:
        """Return the number of a lane."""
        if self.lanes == 1:
            return value
        return self.add(f"extractelement {self.kind} {value}, i64 {lane}")

    def total(self, value: str) -> str:
        """Return the sum of all lanes, from the first to the last."""
        found = self.of_lane(value, 0)
        for lane in range(1, self.lanes):
            found = self.add(f"fadd double {found}, {self.of_lane(value, lane)}")
        return found

    def fused(self, a: str, b: str, c: str) -> str:
        """Return a b + c, rounded once."""
        return self._intrinsic("fma", a, b, c)

    def _intrinsic(self, name: str, *values: str) -> str:
        return self.call(f"llvm.{name}.{self._suffix}", *values)

    def call(self, name: str, *values: str) -> str:
        """Return the result of a function of values."""
        given = ", ".join(f"{self.kind} {value}" for value in values)
        return self.add(f"call {self.kind} @{name}({given})")

    def select(self, test: str, one: str, other: str) -> str:
        """Return one value where a condition holds, and another one where not."""
        values = f"{self.kind} {one}, {self.kind} {other}"
        return self.add(f"select {self.condition} {test}, {values}")

    def any(self, condition: str) -> str:
        """Return whether a condition holds in any lane."""
        if self.lanes == 1:
            return condition
        bits = f"i{self.lanes}"
        each = self.add(f"bitcast {self.condition} {condition} to {bits}")
        return self.add(f"icmp ne {bits} {each}, 0")

    # --- graphs ---------------------------------------------------------------------------

    def write(
        self, outputs: Sequence[Number], values: Mapping[str, str],
        known: Mapping[int, str] | None = None,
    ) -> list[str]:  # fmt: skip
        """Write what computes outputs; return the names of their values.

        Args:
            outputs: Numbers of one graph.
            values: Names of the values of inputs.
            known: Names of the values of other operations, by their places.
        """
        if not outputs:
            return []
        graph = outputs[0].graph
        names = {_real(graph, place): name for place, name in (known or {}).items()}
        order = _in_order(graph, [each.place for each in outputs], names)
        fused = _fused(graph, [place for place in order if place not in names], outputs)
        swallowed = set(fused.values())
        for place in order:
            if place in names or place in swallowed:
                continue
            name, arguments, detail = graph.operations[place]
            if name == "constant":
                names[place] = self.constant(cast(float, detail))
            elif name == "input":
                names[place] = values[cast(str, detail)]
            elif name == "unknown":
                own = {each: names[_real(graph, each)] for each in arguments}
                names[place] = self._sought(cast(Iteration, detail), own)
            elif place in fused:
                names[place] = self._fused(graph, place, fused[place], names)
            else:
                names[place] = self._written(name, [names[_real(graph, k)] for k in arguments])
        return [names[_real(graph, each.place)] for each in outputs]

    def _sought(self, iteration: Iteration, known: Mapping[int, str]) -> str:
        """Write the loop that finds an unknown; lanes that have theirs wait for the others.

        Args:
            known: Names by place: of the start, and of all that stays the same.
        """
        self._count += 1
        before, loop = self.block, f"{self._prefix}{self._count}.loop"
        names = [str(each.operation.detail) for each in iteration.variables]
        self.line(f"br label %{loop}")
        self.label(loop)
        values = {name: f"%{loop}.{k}" for k, name in enumerate(names)}
        ends = [f"%{loop}.{k}.next" for k in range(len(names))]
        ways = list(zip(values.values(), ends, iteration.start, strict=True))
        end = f"{loop}.end"  # a block of its own, as another loop may be within this one
        for value, after, start in ways:
            self.line(
                f"{value} = phi {self.kind} [ {known[start.place]}, %{before} ], "
                f"[ {after}, %{end} ]"
            )
        every = "true" if self.lanes == 1 else "splat (i1 true)"
        self.line(
            f"%{loop}.open = phi {self.condition} [ {every}, %{before} ], "
            f"[ %{loop}.far, %{end} ]"
        )
        self.line(f"%{loop}.round = phi i64 [ 1, %{before} ], [ %{loop}.next, %{end} ]")
        step, *found = self.write([iteration.step, *iteration.following], values, known)
        for (value, after, _), new in zip(ways, found, strict=True):
            chosen = f"{self.kind} {new}, {self.kind} {value}"
            self.line(f"{after} = select {self.condition} %{loop}.open, {chosen}")
        size = self._intrinsic("fabs", step)
        is_far = self._compared("oge", size, self.constant(iteration.close))
        self.line(f"%{loop}.far = and {self.condition} {is_far}, %{loop}.open")
        some = self.any(f"%{loop}.far")
        few = self.add(f"icmp ult i64 %{loop}.round, {iteration.rounds}")
        again = self.add(f"and i1 {some}, {few}")
        self.line(f"br label %{end}")
        self.label(end)
        self.line(f"%{loop}.next = add i64 %{loop}.round, 1")
        self.line(f"br i1 {again}, label %{loop}, label %{loop}.out")
        self.label(f"{loop}.out")
        return ends[0]

    def _fused(self, graph: Graph, place: int, product: int, names: Mapping[int, str]) -> str:
        """Write a sum or a difference of which one side is a product that only it needs."""
        name, arguments, _ = graph.operations[place]
        left, right = (_real(graph, each) for each in arguments)
        a, b = (names[_real(graph, each)] for each in graph.operations[product].arguments)
        other = names[right if product == left else left]
        if name == "difference":
            if product == left:
                other = self.add(f"fneg {self.kind} {other}")
            else:
                a = self.add(f"fneg {self.kind} {a}")
        return self.fused(a, b, other)

    def _written(self, name: str, values: Sequence[str]) -> str:
        if name in _INSTRUCTIONS:
            return self.add(f"{_INSTRUCTIONS[name]} {self.kind} {values[0]}, {values[1]}")
        if name in _EXTREMES:
            test = self._compared(_EXTREMES[name], *values)
            return self.select(test, *values)
        if name in CALLED:
            self.called.add((CALLED[name], self.lanes))
            suffix = "" if self.lanes == 1 else f"_{self.lanes}"
            return self.call(f"exact_{CALLED[name]}{suffix}", *values)
        match name:
            case "negative":
                return self.add(f"fneg {self.kind} {values[0]}")
            case "sqrt":
                return self._intrinsic("sqrt", *values)
            case "greater":
                return self._compared("ogt", *values)
            case "where":
                return self.select(*values)
            case _:
                raise NotImplementedError(name)

    def _compared(self, how: str, one: str, other: str) -> str:
        return self.add(f"fcmp {how} {self.kind} {one}, {other}")


def _real(graph: Graph, place: int) -> int:
    """Return the place of a number itself, behind the rules of its derivatives."""
    while graph.operations[place].name == "ruled":
        place = graph.operations[place].arguments[0]
    return place


def _in_order(graph: Graph, outputs: Sequence[int], known: Mapping[int, str]) -> list[int]:
    """Return the places of all that is computed, each right after what it needs.

    So values are needed soon, which spares the processor's registers.
    """
    found, seen = list[int](), set[int]()
    for output in outputs:
        left = [(_real(graph, output), False)]
        while left:
            place, is_ready = left.pop()
            if is_ready:
                found.append(place)
            elif place not in seen:
                seen.add(place)
                left.append((place, True))
                if place not in known:
                    arguments = graph.operations[place].arguments
                    left += [(_real(graph, each), False) for each in reversed(arguments)]
    return found


def _fused(graph: Graph, order: Sequence[int], outputs: Sequence[Number]) -> dict[int, int]:
    """Return, by the place of a sum, that of a product of which it is the only use."""
    uses = Counter(_real(graph, each.place) for each in outputs)
    for place in order:
        uses.update(_real(graph, each) for each in graph.operations[place].arguments)
    found, computed = dict[int, int](), set(order)
    taken = {_real(graph, each.place) for each in outputs}
    for place in order:
        name, arguments, _ = graph.operations[place]
        if name not in ("sum", "difference"):
            continue
        for each in (_real(graph, argument) for argument in reversed(arguments)):
            is_product = each in computed and graph.operations[each].name == "product"
            if is_product and uses[each] == 1 and each not in taken:
                found[place] = each
                taken.add(each)
                break
    return found
