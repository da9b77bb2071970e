"""Loops over elements, around the energy at one of their points.

``LANES`` elements are computed at a time, as in ``loops.frame``. Gradients of shape functions
are side by side for all lanes; blocks of elements that are alike share them.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.derivatives import gradient
from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.frame import (
    ItemLoop,
    LoopText,
    Target,
    at_corners,
    places_of_numbers,
    transposed,
)
from tissuec.compiled.loops.tables import LANES, blocked, filled
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
        targets: For ``matrix_loop``, ``BlockPattern.places``, flat.
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
        code, point = self.code, self.point
        pooled, slope = point.pooled, point.slope_of_mean
        self.values, _ = self.inputs([*outputs, pooled, slope, *point.scales], {}, [])
        self._forms, sums = map(self.room_of, (self.components * self.points, 2))
        self.sums, self._at = sums, self.gathered("x")
        needed = point.graph.inputs_of(outputs)
        self._pools = point.is_pooled and not needed.isdisjoint(("mean", "swell"))
        has_flow = any(each.startswith("g.") for each in needed)
        self._flow = self.gathered("v") if has_flow else ""
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

    def gathered(self, vector: str) -> str:
        """Return the address of a vector at the nodes of the elements, which is kept."""
        room = self.room_of(3 * self.nodes)
        for corner, place in enumerate(self.places()):
            for axis, value in enumerate(self.gather(vector, place)):
                self.put(value, room, 3 * corner + axis)
        return room

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
        found = dict[str, str]()
        for tensor, numbers in enumerate(self.kept_at(q, "v")):
            scaled = self.times(values[f"p.inverse_rate.{tensor}"], numbers)
            found |= {f"t.{tensor}.{k}": value for k, value in enumerate(scaled)}
        return found

    def kept_at(self, q: str, vector: str, change: str = "") -> list[list[str]]:
        """Return the components of a vector at the hidden nodes of a point, by tensors.

        Without a tensor, they have any value.

        Args:
            change: Which of the changes of a vector that has several; see ``push_loop``.
        """
        code, found = self.code, list[list[str]]()
        own = code.add(f"mul i64 {q}, {self.kept_numbers}") if self.point.tensors else ""
        for tensor in range(self.point.tensors):
            places: list[str] = []
            for lane in range(LANES):
                slot = self.slot(tensor, lane)
                test = code.add(f"icmp slt i64 {slot}, 0")
                there = code.add(f"add i64 {slot}, {own}")
                places.append(code.add(f"select i1 {test}, i64 0, i64 {there}"))
            if change:
                every = range(self.kept_numbers)
                found.append([self.strided(vector, places, k, change) for k in every])
                continue
            numbers = self.gather(vector, places)
            if self.kept_numbers > len(numbers):
                more = [code.add(f"add i64 {place}, 3") for place in places]
                numbers += self.gather(vector, more)
            found.append(numbers)
        return found

    def rates_of(self, values: Mapping[str, str]) -> list[str]:
        """Return the rates of tensors, 0 where there is no tensor."""
        code, zero, found = self.code, self.code.constant(0.0), list[str]()
        for tensor in range(self.point.tensors):
            rate, inverse = (values[f"p.{name}.{tensor}"] for name in ("rate", "inverse_rate"))
            test = code.add(f"fcmp ogt {code.kind} {inverse}, {zero}")
            choice = f"select {code.condition} {test}, {code.kind} {rate}"
            found.append(code.add(f"{choice}, {code.kind} {zero}"))
        return found

    def give(self, name: str, q: str, room: str, vector: str = "f", change: str = "") -> None:
        """Add stored numbers to a vector at the hidden nodes of each lane."""
        code, own = self.code, self.code.add(f"mul i64 {q}, {self.kept_numbers}")
        for tensor in range(self.point.tensors):
            loop = f"{name}.{tensor}"

            def write(lane: str, tensor: int = tensor, loop: str = loop) -> None:
                slot = self.slot(tensor, lane)
                code.line(f"%{loop}.has = icmp sge i64 {slot}, 0")
                code.line(f"br i1 %{loop}.has, label %{loop}.some, label %{loop}.end")
                code.label(f"{loop}.some")
                first = code.add(f"add i64 {slot}, {own}")
                for k in range(self.kept_numbers):
                    value = self.kept(room, self.kept_numbers * tensor + k, lane)
                    self.add_to(self.component(vector, first, k, change), value)

            self.repeat(loop, "%active", write)

    # --- matrices ---------------------------------------------------------------------------

    def turn(self, room: str, rows: int) -> None:
        """Transpose stored values in their places, LANES of them at a time, for ``turned``.

        Args:
            room: Where they are.
            rows: How many; a multiple of LANES.
        """
        code = self.code

        def turn(block: str) -> None:
            first = code.add(f"mul i64 {block}, {LANES}")
            every = [code.add(f"add i64 {first}, {k}") for k in range(LANES)]
            square = transposed(code, [self.read(room, row) for row in every])
            for row, value in zip(every, square, strict=True):
                self.put(value, room, row)

        self.repeat("turn", rows // LANES, turn)

    def turned(self, own: str, rows: Sequence[int]) -> str:
        """Return numbers of a lane, side by side.

        Args:
            own: Where the first number of the lane is.
            rows: Of the numbers.
        """
        code, kind = self.code, f"<{len(rows)} x double>"
        places = [LANES * LANES * (row // LANES) + row % LANES for row in rows]
        if places == list(range(places[0], places[0] + len(places))):
            return code.load(code.address(own, places[0]), kind)
        found = "poison"
        for k, place in enumerate(places):
            number = code.load(code.address(own, place), "double")
            found = code.add(f"insertelement {kind} {found}, double {number}, i64 {k}")
        return found

    # --- changes ----------------------------------------------------------------------------

    def component(self, vector: str, place: str, axis: int, change: str = "") -> str:
        """Return where a component of a vector is, or one of its changes."""
        code = self.code
        at = code.add(f"add i64 {place}, {axis}")
        if change:
            at = code.add(f"add i64 {code.add(f'mul i64 {at}, %room.shape')}, {change}")
        return code.address(f"%{vector}", at)

    def strided(self, vector: str, places: Sequence[str], axis: int, change: str) -> str:
        """Return one of the changes of a component of a vector, by lanes."""
        code, found = self.code, "poison"
        for lane, place in enumerate(places):
            value = code.load(self.component(vector, place, axis, change), "double")
            found = code.add(f"insertelement {code.kind} {found}, double {value}, i64 {lane}")
        return found

    def scatter_change(self, room: str, vector: str, change: str) -> None:
        """Add stored values of the present lane to one of the changes at its nodes."""
        code = self.code
        first = code.add(f"mul i64 %item, {self.nodes}")
        for corner in range(self.nodes):
            at = code.address("%places", code.add(f"add i64 {first}, {corner}"), "i64")
            node = code.load(at, "i64")
            for axis in range(3):
                place = self.component(vector, node, axis, change)
                self.add_to(place, self.kept(room, 3 * corner + axis))


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
    """Return the loop that adds ∂²E/∂x∂x of elements to the entries of a sparse matrix.

    They are Σ w ∂N/∂X ∂²W/∂F∂F ∂N/∂X + U''/V p pᵀ with p = Σ w ∂r/∂F ∂N/∂X; the arguments are
    those of ``force_loop``.
    """
    loop = _Points(point, nodes, points)
    code, width, rows = loop.code, point.directions, _rows(nodes)
    size = _filled_rows(len(rows))
    outputs = [*point.moduli, *(point.pooling if point.is_pooled else ())]
    loop.begin([*outputs, point.bend_of_mean])
    halves, swell = loop.room_of(size), loop.room_of(3 * nodes)
    loop.clear(halves, size)
    loop.clear(swell, 3 * nodes)

    def add(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        written = loop.times(weight, code.write(outputs, values))
        moduli, pooling = _split(written, len(point.moduli))
        if pooling:
            loop.push(swell, pooling, slopes)
        # All of a node, one node after the other, so that what is turned stays in registers.
        for a in range(nodes):
            turned = {
                (i, j): loop.inner(
                    slopes[a], [_of_half(moduli, width * i + k, j) for k in range(width)]
                )
                for i, j in product(range(3), range(3 * width))
            }
            for b, i, j in product(range(a + 1), range(3), range(3)):
                several, row = (
                    [turned[i, width * j + k] for k in range(width)],
                    rows[a, b, i, j],
                )
                loop.put(loop.inner(slopes[b], several, loop.read(halves, row)), halves, row)

    loop.each_point("add", add)
    if point.is_pooled:
        (bend,) = code.write([point.bend_of_mean], loop.values)
        rise = code.add(f"fdiv {code.kind} {bend}, {loop.read(loop.sums, 0)}")
        pushed = [loop.read(swell, k) for k in range(3 * nodes)]
        for (a, b, i, j), row in rows.items():
            (both,) = loop.times(rise, [pushed[3 * a + i]])
            value = code.fused(both, pushed[3 * b + j], loop.read(halves, row))
            loop.put(value, halves, row)
    loop.turn(halves, size)
    loop.each_lane(lambda: _add_blocks(loop, halves, rows))
    return loop.text(name, ("x", "v", "out"), PointTable)


def _add_blocks(
    loop: _Points, halves: str, rows: Mapping[tuple[int, int, int, int], int]
) -> None:
    """Add the matrix of the present lane to the entries of ``matrix_loop``.

    Args:
        halves: Where the lower halves of matrices are, turned.
        rows: Of their entries, by nodes and components.
    """
    code, nodes = loop.code, loop.nodes
    own = loop.row(halves, "%lane")
    first = code.add(f"mul i64 %item, {nodes * (nodes + 1)}")
    for b in range(nodes):
        places = code.add(f"add i64 {first}, {b * (nodes + 1)}")
        places = code.address("%targets", places, "i64")
        apart = code.load(code.address(places, nodes, "i64"), "i64")
        for a in range(nodes):
            place = code.load(code.address(places, a, "i64"), "i64")
            to = code.address("%out", place)
            for j in range(3):
                every = [rows[(a, b, i, j) if a >= b else (b, a, j, i)] for i in range(3)]
                # Two at once, and the third, since vectors have no three lanes.
                for part, at in ((every[:2], to), (every[2:], code.address(to, 2))):
                    kind = f"<{len(part)} x double>"
                    old, more = code.load(at, kind), loop.turned(own, part)
                    code.store(code.add(f"fadd {kind} {old}, {more}"), at, kind)
                to = code.address(to, apart)


def pull_loop(
    name: str, point: TracedPoint, learnt: Sequence[str], nodes: int, points: int
) -> LoopText:
    """Return the loop ``pull_back`` of ``forces.matrices``.

    With W = Σ w_a ⊗ ∂N_a/∂X and A = Σ w ∂r/∂F : W, the derivatives of Σ weight · f are those of
    -P : W + h · dT/dt - A U''/V r at all points, and -A ∂U'/∂p.

    Args:
        name: Of the function.
        point: Of the elements.
        learnt: Names of numbers.
        nodes, points: Of each element.
    """
    loop, outputs = _Points(point, nodes, points), point.pulled(learnt)
    code, numbers, kept = loop.code, point.of(learnt), loop.kept_numbers * point.tensors
    by_mean = gradient(point.slope_of_mean, numbers)
    loop.begin([*outputs, *by_mean, point.bend_of_mean])
    weights, turned = loop.gathered("load"), loop.room_of(1)
    by_x, by_v, by = map(loop.room_of, (3 * nodes, 3 * nodes, max(1, len(numbers))))
    by_kept = loop.room_of(max(1, kept))
    for room, rows in ((turned, 1), (by_x, 3 * nodes), (by_v, 3 * nodes), (by, len(numbers))):
        loop.clear(room, rows)

    share = _share_of_mean(loop, weights, turned) if point.is_pooled else code.constant(0.0)

    def pull(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        given = {f"w.{k}": one for k, one in enumerate(loop.gradient_of(weights, slopes))}
        rates = loop.rates_of(values)
        for tensor, heavy in enumerate(loop.kept_at(q, "load")):
            for k, one in enumerate(loop.times(rates[tensor], heavy)):
                given[f"h.{tensor}.{k}"] = code.add(f"fdiv {code.kind} {one}, {weight}")
        written = loop.times(weight, code.write(outputs, values | given | {"share": share}))
        of_f, of_rate, of_kept, of_numbers = _split(written, *[loop.components] * 2, kept)
        loop.push(by_x, of_f, slopes)
        loop.push(by_v, of_rate, slopes)
        for k, each in enumerate(of_numbers):
            loop.add_up(each, by, k)
        for k, each in enumerate(of_kept):
            inverse = values[f"p.inverse_rate.{k // loop.kept_numbers}"]
            loop.put(loop.times(inverse, [each])[0], by_kept, k)
        if kept:
            loop.give("give", q, by_kept, "by_v")

    loop.each_point("pull", pull)
    for k, each in enumerate(code.write(by_mean, loop.values) if point.is_pooled else ()):
        loop.add_up(
            code.add(f"fneg {code.kind} {loop.times(loop.read(turned, 0), [each])[0]}"), by, k
        )

    def write() -> None:
        loop.scatter(by_x, at_corners("by_x", nodes))
        loop.scatter(by_v, at_corners("by_v", nodes))
        every = dict.fromkeys(learnt, False)
        loop.scatter(by, [("by", at) for at in places_of_numbers(loop, point.widths, every)])

    loop.each_lane(write)
    return loop.text(name, ("x", "v", "load", "by_x", "by_v", "by"), PointTable)


def _share_of_mean(loop: _Points, weights: str, turned: str) -> str:
    """Return -A U''/V of ``pull_loop``, and store A.

    Args:
        weights: Where the weights of the nodes are.
        turned: Where A is stored.
    """
    code, point = loop.code, loop.point

    def turn(q: str) -> None:
        slopes, weight, values = loop.at_point(q)
        rise = loop.inner(code.write(point.pooling, values), loop.gradient_of(weights, slopes))
        loop.add_up(loop.times(weight, [rise])[0], turned, 0)

    loop.each_point("turn", turn)
    (bend,) = code.write([point.bend_of_mean], loop.values)
    (share,) = loop.times(bend, [code.add(f"fneg {code.kind} {loop.read(turned, 0)}")])
    return code.add(f"fdiv {code.kind} {share}, {loop.read(loop.sums, 0)}")


def push_loop(
    name: str, point: TracedPoint, learnt: Sequence[str], nodes: int, points: int
) -> LoopText:
    """Return the loop ``push_forward`` of ``forces.matrices``; see ``pull_loop``."""
    loop, outputs = _Points(point, nodes, points), point.pushed(learnt)
    code, kept = loop.code, loop.kept_numbers * point.tensors
    numbers = [str(each.operation.detail) for each in point.of(learnt)]
    of_mean, of_pooled = point.pushed_mean(learnt)
    loop.begin([*outputs, of_mean, of_pooled])
    dx, dv, df = (loop.room_of(3 * nodes) for _ in range(3))
    grown, rates = loop.room_of(1), loop.room_of(max(1, kept))

    def change(m: str) -> None:
        for corner, places in enumerate(loop.places()):
            for axis in range(3):
                for vector, room in (("dx", dx), ("dv", dv)):
                    loop.put(loop.strided(vector, places, axis, m), room, 3 * corner + axis)
        given = _changes_of_numbers(loop, learnt, numbers, m)
        loop.clear(df, 3 * nodes)
        loop.clear(grown, 1)

        def grow(q: str) -> None:
            slopes, weight, values = loop.at_point(q)
            values |= {f"df.{k}": one for k, one in enumerate(loop.gradient_of(dx, slopes))}
            (rise,) = code.write([of_pooled], values | given)
            loop.add_up(loop.times(weight, [rise])[0], grown, 0)

        if point.is_pooled:
            loop.each_point("grow", grow)
            mean = code.add(
                f"fdiv {code.kind} {loop.read(grown, 0)}, {loop.read(loop.sums, 0)}"
            )
            (given["dswell"],) = code.write([of_mean], loop.values | given | {"dmean": mean})

        def push(q: str) -> None:
            slopes, weight, values = loop.at_point(q)
            for letter, room in (("df", dx), ("dg", dv)):
                form = loop.gradient_of(room, slopes)
                values |= {f"{letter}.{k}": one for k, one in enumerate(form)}
            for tensor, moved in enumerate(loop.kept_at(q, "dv", m)):
                scaled = loop.times(values[f"p.inverse_rate.{tensor}"], moved)
                values |= {f"dt.{tensor}.{k}": one for k, one in enumerate(scaled)}
            stress, faster = _split(code.write(outputs, values | given), loop.components)
            minus = code.add(f"fneg {code.kind} {weight}")
            loop.push(df, loop.times(minus, stress), slopes)
            every = loop.rates_of(values)
            for k, each in enumerate(faster):
                loop.put(loop.times(every[k // loop.kept_numbers], [each])[0], rates, k)
            if kept:
                loop.give("give", q, rates, "df", m)

        loop.each_point("push", push)
        loop.each_lane(lambda: loop.scatter_change(df, "df", m))

    loop.repeat("changes", "%room.shape", change)
    return loop.text(name, ("x", "v", "dx", "dv", "dn", "df", "room"), PointTable)


def _changes_of_numbers(
    loop: _Points, learnt: Sequence[str], numbers: Sequence[str], change: str
) -> dict[str, str]:
    """Return one of the changes of the numbers of the elements, by the names of inputs."""
    code, found, lanes = loop.code, [""] * len(numbers), list[list[str]]()
    for lane in range(LANES):
        item = code.add(f"add i64 %first, {lane}")
        test, last = code.add(f"icmp ult i64 {item}, %size"), code.add("sub i64 %size, 1")
        item = code.add(f"select i1 {test}, i64 {item}, i64 {last}")
        lanes.append(
            places_of_numbers(loop, loop.point.widths, dict.fromkeys(learnt, False), item)
        )
    for k, places in enumerate(zip(*lanes, strict=True)):
        found[k] = loop.strided("dn", places, 0, change)
    return {f"d{name}": value for name, value in zip(numbers, found, strict=True)}


def _rows(nodes: int) -> dict[tuple[int, int, int, int], int]:
    """Return the entries of the lower half of a matrix, by nodes and components."""
    entries = (
        (a, b, i, j) for a in range(nodes) for b in range(a + 1)
        for i in range(3) for j in range(3)
    )  # fmt: skip
    return {entry: row for row, entry in enumerate(entries)}


def _filled_rows(count: int) -> int:
    """Return a number of rows that fills squares of lanes."""
    return -(-count // LANES) * LANES


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
