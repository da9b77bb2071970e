"""Loops over elements, around the energy at one of their points.

``LANES`` elements are computed at a time, as in ``loops.items``. Gradients of shape functions
are side by side for all lanes; blocks of elements that are alike share them.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.items import (
    LANES,
    ItemLoop,
    LoopText,
    Target,
    at_corners,
    blocked,
    filled,
)
from tissuec.kernels.records import Floats, Integers


class PointTable(NamedTuple):
    """Elements as loops read them.

    Attributes:
        size: Number of elements.
        places: Three times the nodes, element by element, filled up to whole blocks of lanes.
        numbers: Numbers of the elements, blocked as those of an ``ItemTable``.
        key: Of the gradients of each block.
        gradients: ∂N/∂X [1/m], flat, shape (key, point, node, direction, lane).
        weight: Volume of each point [m³], flat, shape (key, point, lane).
        slots: Where the first number of a tensor is among velocities; -1 without one; flat,
            shape (block, tensor, lane).
        targets: For ``matrix_loop``, the place of the block of each pair of nodes; flat, shape
            (element, node, node).
    """

    size: int
    places: Integers
    numbers: Floats
    key: Integers
    gradients: Floats
    weight: Floats
    slots: Integers
    targets: Integers = np.zeros(0, dtype=np.int64)

    @classmethod
    def of(
        cls,
        nodes: NDArray[np.integer],
        columns: Floats,
        row: NDArray[np.integer],
        gradients: Floats,
        weight: Floats,
        slots: NDArray[np.integer],
    ) -> Self:
        """Return a table.

        Args:
            nodes: Of the elements, shape (element, node).
            columns: Numbers of the elements, in any unit, shape (number, element).
            row: Of each element in the following two, shape (element,).
            gradients: ∂N/∂X [1/m], shape (row, point, node, direction).
            weight: Volume of each point [m³], shape (row, point).
            slots: As the attribute, shape (tensor, element).
        """
        every = filled(len(nodes))
        lanes = row[every].reshape(len(every) // LANES, LANES)
        keys, key = np.unique(lanes, axis=0, return_inverse=True)
        rows, points, count, width = gradients.shape
        steep = gradients.reshape(rows, points, count * width)[keys]
        return cls(
            len(nodes),
            (3 * nodes[every].astype(np.int64)).ravel(),
            blocked(columns, every),
            key.reshape(-1).astype(np.int64),
            np.ascontiguousarray(np.moveaxis(steep, 1, -1)).ravel(),
            np.ascontiguousarray(np.moveaxis(weight[keys], 1, -1)).ravel(),
            blocked(slots, every).astype(np.int64),
        )


class _Points(ItemLoop):
    """Writes one loop over elements."""

    def __init__(self, point: TracedPoint, nodes: int, points: int):
        super().__init__(point.graph, point.numbers, nodes, LANES)
        self.point, self.nodes, self.points = point, nodes, points
        self.components, self.kept_numbers = len(point.f), len(point.places)

    # --- memory of a block ------------------------------------------------------------------

    def read(self, room: str, index: str | int) -> str:
        """Return a value from memory."""
        return self.code.load(self.row(room, index), align=self.code.size)

    def add_up(self, value: str, room: str, index: str | int) -> None:
        """Add to a value in memory."""
        total = self.code.add(f"fadd {self.code.kind} {self.read(room, index)}, {value}")
        self.put(total, room, index)

    def clear(self, room: str, rows: int) -> None:
        """Set values in memory to zero."""
        for k in range(rows):
            self.put(self.code.constant(0.0), room, k)

    # --- points -----------------------------------------------------------------------------

    def begin(self, outputs: Sequence[Number]) -> None:
        """Write what comes before the points that outputs are of: F of all, and its mean."""
        code, point, rows = self.code, self.point, 3 * self.nodes
        pooled, slope = point.pooled, point.slope_of_mean
        self.values, _ = self.inputs([*outputs, pooled, slope, *point.scales], {}, [])
        self._at, self._forms, sums = map(
            self.room_of, (rows, self.components * self.points, 2)
        )
        self.sums = sums
        needed = point.graph.inputs_of(outputs)
        self._pools = point.is_pooled and not needed.isdisjoint(("mean", "swell"))
        self._flow = self.room_of(rows) if any(each.startswith("g.") for each in needed) else ""
        for corner, place in enumerate(self.places()):
            for room, vector in ((self._at, "x"), (self._flow, "v")):
                for axis, value in enumerate(self.gather(vector, place) if room else ()):
                    self.put(value, room, 3 * corner + axis)
        code.line("%own.key = getelementptr i64, ptr %key, i64 %block")
        code.line("%row = load i64, ptr %own.key, align 8")
        if not self._pools:
            return
        self.clear(sums, 2)

        def deform(q: str) -> None:
            slopes, weight = self.slopes_at(q)
            form = self.gradient_of(self._at, slopes)
            first = code.add(f"mul i64 {q}, {self.components}")
            for k, value in enumerate(form):
                self.put(value, self._forms, code.add(f"add i64 {first}, {k}"))
            given = self.values | {f"f.{k}": value for k, value in enumerate(form)}
            (share,) = code.write([pooled], given)
            self.add_up(weight, sums, 0)
            self.put(code.fused(weight, share, self.read(sums, 1)), sums, 1)

        self.each_point("deform", deform)
        mean = code.add(f"fdiv {code.kind} {self.read(sums, 1)}, {self.read(sums, 0)}")
        self.values["mean"] = mean
        (self.values["swell"],) = code.write([slope], self.values)

    def at_point(self, q: str) -> tuple[list[list[str]], str, dict[str, str]]:
        """Return ∂N/∂X of the nodes at a point, its volume, and the values of all inputs."""
        slopes, weight = self.slopes_at(q)
        values = dict(self.values)
        if self._pools:
            first = self.code.add(f"mul i64 {q}, {self.components}")
            every = range(self.components)
            places = [self.code.add(f"add i64 {first}, {k}") for k in every]
            form = [self.read(self._forms, place) for place in places]
        else:
            form = self.gradient_of(self._at, slopes)
        values |= {f"f.{k}": value for k, value in enumerate(form)}
        if self._flow:
            moved = self.gradient_of(self._flow, slopes)
            values |= {f"g.{k}": value for k, value in enumerate(moved)}
        return slopes, weight, values | self.tensors_at(q, values)

    def each_point(self, name: str, write: Callable[[str], None]) -> None:
        """Write a loop over the points of an element.

        Args:
            name: Of the loop.
            write: Writes what is done, given the number of the point.
        """
        self.repeat(name, self.points, write)

    def slopes_at(self, q: str) -> tuple[list[list[str]], str]:
        """Return ∂N/∂X of each node at a point, and its volume."""
        code = self.code
        place = code.add(f"add i64 {code.add(f'mul i64 %row, {self.points}')}, {q}")
        width = self.point.directions
        base = code.address(
            "%gradients", code.add(f"mul i64 {place}, {width * self.nodes * LANES}")
        )
        weight = code.load(code.address("%weight", code.add(f"mul i64 {place}, {LANES}")))
        return [
            [code.load(code.address(base, (width * a + k) * LANES)) for k in range(width)]
            for a in range(self.nodes)
        ], weight

    def gradient_of(self, room: str, slopes: Sequence[Sequence[str]]) -> list[str]:
        """Return Σ x_a ⊗ ∂N_a/∂X of a vector that is kept, row by row."""
        code, found = self.code, [""] * self.components
        for a, slope in enumerate(slopes):
            for i in range(3):
                x = self.read(room, 3 * a + i)
                for k in range(len(slope)):
                    place = len(slope) * i + k
                    found[place] = (
                        code.fused(x, slope[k], found[place])
                        if a
                        else code.add(f"fmul {code.kind} {x}, {slope[k]}")
                    )
        return found

    def push(self, room: str, stress: Sequence[str], slopes: Sequence[Sequence[str]]) -> None:
        """Add Σ P ∂N/∂X to the rows of the nodes of an element."""
        for a, slope in enumerate(slopes):
            for i in range(3):
                value = self.read(room, 3 * a + i)
                for k, steep in enumerate(slope):
                    value = self.code.fused(stress[len(slope) * i + k], steep, value)
                self.put(value, room, 3 * a + i)

    def inner(self, one: Sequence[str], other: Sequence[str], more: str = "") -> str:
        """Return a sum of products, and of one value more."""
        code, found = self.code, more
        for a, b in zip(one, other, strict=True):
            found = code.fused(a, b, found) if found else code.add(f"fmul {code.kind} {a}, {b}")
        return found

    def times(self, factor: str, values: Sequence[str]) -> list[str]:
        """Return products with one factor."""
        return [self.code.add(f"fmul {self.code.kind} {factor}, {each}") for each in values]

    # --- tensors ----------------------------------------------------------------------------

    def slot(self, tensor: int, lane: str | int) -> str:
        """Return where the first number of a tensor of a lane is; -1 without one."""
        code = self.code
        row = code.add(f"mul i64 %block, {self.point.tensors * LANES}")
        row = code.add(f"add i64 {row}, {tensor * LANES}")
        return code.load(
            code.address("%slots", code.add(f"add i64 {row}, {lane}"), "i64"), "i64"
        )

    def tensors_at(self, q: str, values: Mapping[str, str]) -> dict[str, str]:
        """Return the numbers of T - 1 of all tensors at a point."""
        code, found = self.code, dict[str, str]()
        own = code.add(f"mul i64 {q}, {self.kept_numbers}") if self.point.tensors else ""
        for tensor in range(self.point.tensors):
            places: list[str] = []
            for lane in range(LANES):
                slot = self.slot(tensor, lane)
                test = code.add(f"icmp slt i64 {slot}, 0")
                there = code.add(f"add i64 {slot}, {own}")
                places.append(code.add(f"select i1 {test}, i64 0, i64 {there}"))
            numbers = self.gather("v", places)
            if self.kept_numbers > len(numbers):
                more = [code.add(f"add i64 {place}, 3") for place in places]
                numbers += self.gather("v", more)
            scaled = self.times(values[f"p.inverse_rate.{tensor}"], numbers)
            found |= {f"t.{tensor}.{k}": value for k, value in enumerate(scaled)}
        return found

    def give(self, name: str, q: str, room: str) -> None:
        """Add stored rates to those of the hidden nodes of each lane."""
        code, own = self.code, self.code.add(f"mul i64 {q}, {self.kept_numbers}")
        for tensor in range(self.point.tensors):
            loop = f"{name}.{tensor}"

            def write(lane: str, tensor: int = tensor, loop: str = loop) -> None:
                slot = self.slot(tensor, lane)
                code.line(f"%{loop}.has = icmp sge i64 {slot}, 0")
                code.line(f"br i1 %{loop}.has, label %{loop}.some, label %{loop}.end")
                code.label(f"{loop}.some")
                base = code.address("%f", code.add(f"add i64 {slot}, {own}"))
                for k in range(self.kept_numbers):
                    value = self.kept(room, self.kept_numbers * tensor + k, lane)
                    self.add_to(code.address(base, k), value)

            self.repeat(loop, "%active", write)


def force_loop(name: str, point: TracedPoint, nodes: int, points: int) -> LoopText:
    """Return the loop that adds forces, rates of what is remembered, and powers.

    Args:
        name: Of the function.
        point: Of the elements.
        nodes, points: Of each element.
    """
    loop = _Points(point, nodes, points)
    code, is_lossy = loop.code, point.power.value != 0.0
    outputs = [*point.pull, point.power, *point.rates]
    loop.begin(outputs)
    pushed = loop.room_of(3 * nodes + 1)
    rates = loop.room_of(len(point.rates)) if point.rates else ""
    loop.clear(pushed, 3 * nodes + 1)

    def press(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        values["pull"] = code.add(f"fneg {code.kind} {weight}")
        pull, (lost,), changes = _split(code.write(outputs, values), loop.components, 1)
        loop.push(pushed, pull, slopes)
        if is_lossy:
            row = 3 * nodes
            loop.put(code.fused(weight, lost, loop.read(pushed, row)), pushed, row)
        for k, change in enumerate(changes):
            rate = values[f"p.rate.{k // loop.kept_numbers}"]
            loop.put(code.add(f"fmul {code.kind} {rate}, {change}"), rates, k)
        if changes:
            loop.give("give", q, rates)

    loop.each_point("press", press)

    lost: list[Target] = []
    if is_lossy:
        lost = [("power", 0 if point.state.is_supplied else 1)]
    loop.each_lane(lambda: loop.scatter(pushed, [*at_corners("f", nodes), *lost]))
    return loop.text(name, ("x", "v", "f", "power"), PointTable)


def record_loop(
    name: str, point: TracedPoint, outputs: Sequence[Number], nodes: int, points: int
) -> LoopText:
    """Return the loop that writes numbers of each point, for ``recorded`` to read.

    Args:
        name: Of the function.
        nodes, points: Of each element.
    """
    loop = _Points(point, nodes, points)
    code = loop.code
    loop.begin(outputs)
    size = len(outputs) * LANES

    def write(q: str) -> None:
        _, _, values = loop.at_point(q)
        place = code.add(f"add i64 {code.add(f'mul i64 %block, {points}')}, {q}")
        base = code.address("%out", code.add(f"mul i64 {place}, {size}"))
        for k, value in enumerate(code.write(outputs, values)):
            code.store(value, code.address(base, k * LANES))

    loop.each_point("write", write)
    return loop.text(name, ("x", "v", "out"), PointTable)


def mean_loop(
    name: str, point: TracedPoint, outputs: Sequence[Number], nodes: int, points: int
) -> LoopText:
    """Return the loop that writes numbers of each element, for ``recorded`` to read.

    They may depend on ``TracedPoint.mean_of`` numbers of points; the arguments are those of
    ``record_loop``.
    """
    loop, averaged = _Points(point, nodes, points), point.averaged(outputs)
    code, count = loop.code, len(averaged)
    loop.begin([*averaged.values(), *outputs])
    sums = loop.room_of(count + 1)
    loop.clear(sums, count + 1)

    def add(q: str) -> None:
        _, weight, values = loop.at_point(q)
        for k, value in enumerate(code.write(list(averaged.values()), values)):
            loop.put(code.fused(weight, value, loop.read(sums, k)), sums, k)
        loop.add_up(weight, sums, count)

    loop.each_point("add", add)
    volume = loop.read(sums, count)
    means = {
        each: code.add(f"fdiv {code.kind} {loop.read(sums, k)}, {volume}")
        for k, each in enumerate(averaged)
    }
    base = loop.row_of_blocks("out", len(outputs))
    for k, value in enumerate(code.write(outputs, loop.values | means)):
        code.store(value, code.address(base, k * LANES))
    return loop.text(name, ("x", "v", "out"), PointTable)


def matrix_loop(name: str, point: TracedPoint, nodes: int, points: int) -> LoopText:
    """Return the loop that adds ∂²E/∂x∂x of elements to blocks of 3 x 3 of a matrix.

    They are Σ w ∂N/∂X ∂²W/∂F∂F ∂N/∂X + U''/V p pᵀ with p = Σ w ∂r/∂F ∂N/∂X; the arguments are
    those of ``force_loop``.
    """
    loop = _Points(point, nodes, points)
    code, width, entries = loop.code, point.directions, _entries(nodes)
    outputs = [*point.moduli, *(point.pooling if point.is_pooled else ())]
    loop.begin([*outputs, point.bend_of_mean])
    halves, swell = loop.room_of(len(entries)), loop.room_of(3 * nodes)
    loop.clear(halves, len(entries))
    loop.clear(swell, 3 * nodes)

    def add(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        written = loop.times(weight, code.write(outputs, values))
        moduli, pooling = _split(written, len(point.moduli))
        if pooling:
            loop.push(swell, pooling, slopes)
        turned: dict[tuple[int, int, int], str] = {}  # by node, component, and component of F
        for a, i, j in product(range(nodes), range(3), range(3 * width)):
            rows = [_of_half(moduli, width * i + k, j) for k in range(width)]
            turned[a, i, j] = loop.inner(slopes[a], rows)
        for row, (a, b, i, j) in enumerate(entries):
            several = [turned[a, i, width * j + k] for k in range(width)]
            loop.put(loop.inner(slopes[b], several, loop.read(halves, row)), halves, row)

    loop.each_point("add", add)
    if point.is_pooled:
        (bend,) = code.write([point.bend_of_mean], loop.values)
        rise = code.add(f"fdiv {code.kind} {bend}, {loop.read(loop.sums, 0)}")
        pushed = [loop.read(swell, k) for k in range(3 * nodes)]
        for row, (a, b, i, j) in enumerate(entries):
            (both,) = loop.times(rise, [pushed[3 * a + i]])
            value = code.fused(both, pushed[3 * b + j], loop.read(halves, row))
            loop.put(value, halves, row)
    rows = {entry: row for row, entry in enumerate(entries)}

    def write() -> None:
        first = code.add(f"mul i64 %item, {nodes * nodes}")
        for a, b in product(range(nodes), range(nodes)):
            at = code.address("%targets", code.add(f"add i64 {first}, {a * nodes + b}"), "i64")
            base = code.address("%out", code.add(f"mul i64 {code.load(at, 'i64')}, 9"))
            for i, j in product(range(3), range(3)):
                row = rows[(a, b, i, j) if a >= b else (b, a, j, i)]
                loop.add_to(code.address(base, 3 * i + j), loop.kept(halves, row))

    loop.each_lane(write)
    return loop.text(name, ("x", "v", "out"), PointTable)


def _entries(nodes: int) -> list[tuple[int, int, int, int]]:
    """Return nodes and components of the entries of the lower half of a matrix, by blocks."""
    return [
        (a, b, i, j) for a in range(nodes) for b in range(a + 1)
        for i in range(3) for j in range(3)
    ]  # fmt: skip


def _of_half(values: Sequence[str], row: int, column: int) -> str:
    """Return an entry of a symmetric matrix whose lower half is given row by row."""
    high, low = max(row, column), min(row, column)
    return values[high * (high + 1) // 2 + low]


def _split(values: Sequence[str], *counts: int) -> tuple[Sequence[str], ...]:
    """Return values in parts of so many, and the rest."""
    found, start = list[Sequence[str]](), 0
    for count in counts:
        found.append(values[start : start + count])
        start += count
    return *found, values[start:]
