"""The common parts of loops over elements whose points have an energy.

``LANES`` elements are computed at a time, as in ``loops.frame``. Gradients of shape functions
are stored side by side for all lanes, once for all blocks of elements that are alike.
"""

from collections.abc import Callable, Mapping, Sequence, Set
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.frame import ItemLoop
from tissuec.compiled.loops.tables import LANES, blocked, filled
from tissuec.kernels.records import Floats, Integers


class PointTable(NamedTuple):
    """Elements as loops read them.

    Attributes:
        size: Number of elements.
        places: Three times the nodes, element by element, filled up to whole blocks of lanes.
        numbers: Numbers of the elements, blocked as those of an ``ItemTable``.
        key: Of the gradients of each block.
        gradients: ∂N/∂X [1/m], flat, shape (key, point, node, direction, lane); or where points
            of a cell are, shape (key, point, 3, lane).
        weight: Volume of each point [m³], flat, shape (key, point, lane).
        slots: Where the first number of a tensor is among velocities; -1 without one; flat,
            shape (block, tensor, lane).
        targets: For ``matrix_loop``, ``BlockPattern.places``, flat.
        drawn: Numbers of cells as drawn, or φ_k at points where there are several functions,
            flat, shape (key, number, lane).
    """

    size: int
    places: Integers
    numbers: Floats
    key: Integers
    gradients: Floats
    weight: Floats
    slots: Integers
    targets: Integers = np.zeros(0, dtype=np.int64)
    drawn: Floats = np.zeros(0)

    @classmethod
    def of(
        cls,
        nodes: NDArray[np.integer],
        columns: Floats,
        row: NDArray[np.integer],
        gradients: Floats,
        weight: Floats,
        slots: NDArray[np.integer],
        drawn: Floats | None = None,
    ) -> Self:
        """Return a table.

        Args:
            nodes: Of the elements, shape (element, node).
            columns: Numbers of the elements, in any unit, shape (number, element).
            row: Of each element in the following two, shape (element,).
            gradients: ∂N/∂X [1/m], shape (row, point, node, direction).
            weight: Volume of each point [m³], shape (row, point).
            slots: As the attribute, shape (tensor, element).
            drawn: As the attribute, shape (row, number).
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
            drawn=np.zeros(0) if drawn is None else drawn[keys].swapaxes(1, 2).ravel(),
        )


class PointLoop(ItemLoop):
    """Writes one loop over elements, whose points are strained by gradients.

    Args:
        point: Of the elements.
        nodes, points: Of each element.

    Attributes:
        components: How many numbers the strain of a point has.
        kept_numbers: How many each of its tensors has.
        strained: How many numbers are added up at points, to be forces of nodes.
    """

    def __init__(self, point: TracedPoint, nodes: int, points: int):
        super().__init__(point.graph, point.numbers, nodes, LANES)
        self.point, self.nodes, self.points = point, nodes, points
        self.components, self.kept_numbers = len(point.f), len(point.places)
        self.strained = 3 * nodes

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

    def inner(self, one: Sequence[str], other: Sequence[str], more: str = "") -> str:
        """Return a sum of products, and of one value more."""
        code, found = self.code, more
        for a, b in zip(one, other, strict=True):
            found = code.fused(a, b, found) if found else code.add(f"fmul {code.kind} {a}, {b}")
        return found

    def times(self, factor: str, values: Sequence[str]) -> list[str]:
        """Return products with one factor."""
        return [self.code.add(f"fmul {self.code.kind} {factor}, {each}") for each in values]

    # --- points -----------------------------------------------------------------------------

    def begin(self, outputs: Sequence[Number], *, moves: bool = False) -> None:
        """Write what comes before the points that outputs are of: F of all, and its mean.

        Args:
            moves: Whether velocities are needed in any case.
        """
        code, point = self.code, self.point
        pooled, slope = point.pooled, point.slope_of_mean
        every = [*outputs, *self.of_element, pooled, slope, *point.scales]
        self.values, _ = self.inputs(every, {}, [])
        several = point.functions if point.functions > 1 else 0
        rooms = self.components * self.points, 1 + point.functions
        self._forms, sums = map(self.room_of, rooms)
        code.line("%own.key = getelementptr i64, ptr %key, i64 %block")
        code.line("%row = load i64, ptr %own.key, align 8")
        self.sums, self.at = sums, self.gathered("x")
        needed = point.graph.inputs_of(outputs)
        self._pools = point.is_pooled and not needed.isdisjoint(("mean", "swell"))
        has_flow = any(each.startswith("g.") for each in needed)
        self.flow = self.gathered("v") if has_flow or moves else ""
        self._strain, self._rate = self.strain(needed)
        if not self._pools:
            return
        self.clear(sums, 1 + point.functions)

        def deform(q: str) -> None:
            slopes, weight = self.slopes_at(q)
            form = self.gradient_of(self._strain, slopes)
            first = code.add(f"mul i64 {q}, {self.components}")
            for k, value in enumerate(form):
                self.put(value, self._forms, code.add(f"add i64 {first}, {k}"))
            given = self.values | {f"f.{k}": value for k, value in enumerate(form)}
            (share,) = code.write([pooled], given)
            self.add_up(weight, sums, 0)
            if several:
                self._project(q, self.times(weight, [share])[0], sums, 1)
                return
            self.put(code.fused(weight, share, self.read(sums, 1)), sums, 1)

        self.each_point("deform", deform)
        if several:
            self._projected(slope)
            return
        mean = code.add(f"fdiv {code.kind} {self.read(sums, 1)}, {self.read(sums, 0)}")
        self.values["mean"] = mean
        (self.values["swell"],) = code.write([slope], self.values)

    def functions_at(self, q: str) -> list[str]:
        """Return φ_k of all functions at a point."""
        code, count = self.code, self.point.functions
        place = code.add(f"add i64 {code.add(f'mul i64 %row, {self.points}')}, {q}")
        base = code.address("%drawn", code.add(f"mul i64 {place}, {count * LANES}"))
        return [code.load(code.address(base, k * LANES)) for k in range(count)]

    def _project(self, q: str, value: str, room: str, first: int) -> None:
        """Add products of a value and φ_k at a point to rows of a room from the first on."""
        for k, each in enumerate(self.functions_at(q)):
            row = first + k
            self.put(self.code.fused(value, each, self.read(room, row)), room, row)

    def _projected(self, slope: Number) -> None:
        """Write projections of what is pooled and of a slope by it; see ``autodiff.points``.

        Args:
            slope: U'(M).
        """
        code, count = self.code, self.point.functions
        volume = self.read(self.sums, 0)
        self._means, self._slopes = self.room_of(count), self.room_of(count)
        for k in range(count):
            mean = code.add(f"fdiv {code.kind} {self.read(self.sums, 1 + k)}, {volume}")
            self.put(mean, self._means, k)
        self.clear(self._slopes, count)

        def press(q: str) -> None:
            _, weight = self.slopes_at(q)
            given = self.values | {"mean": self._at_place(q, self._means)}
            (rise,) = code.write([slope], given)
            part = code.add(f"fdiv {code.kind} {weight}, {volume}")
            self._project(q, self.times(part, [rise])[0], self._slopes, 0)

        self.each_point("project", press)

    def _at_place(self, q: str, room: str) -> str:
        """Return the sum of φ_k at a point times the rows of a room."""
        every = self.functions_at(q)
        return self.inner(every, [self.read(room, k) for k in range(len(every))])

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
            form = self.gradient_of(self._strain, slopes)
        values |= {f"f.{k}": value for k, value in enumerate(form)}
        if self._pools and self.point.functions > 1:
            values["mean"] = self._at_place(q, self._means)
            values["swell"] = self._at_place(q, self._slopes)
        if self._rate:
            moved = self.gradient_of(self._rate, slopes)
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
        """Return ∂N/∂X of each node at a point, or where it is; and its volume."""
        code = self.code
        place = code.add(f"add i64 {code.add(f'mul i64 %row, {self.points}')}, {q}")
        count, width = self.row_shape
        base = code.address("%gradients", code.add(f"mul i64 {place}, {width * count * LANES}"))
        weight = code.load(code.address("%weight", code.add(f"mul i64 {place}, {LANES}")))
        return [
            [code.load(code.address(base, (width * a + k) * LANES)) for k in range(width)]
            for a in range(count)
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

    # --- elements ---------------------------------------------------------------------------

    @property
    def row_shape(self) -> tuple[int, int]:
        """Return the shape of what tables have of a point."""
        return self.nodes, self.point.directions

    @property
    def of_element(self) -> Sequence[Number]:
        """Return numbers of the whole element on which forces depend."""
        return ()

    def strain(self, needed: Set[str]) -> tuple[str, str]:
        """Return where that is kept which strains the points, and its rate; empty without one.

        Args:
            needed: Names of the inputs that are used.
        """
        return self.at, self.flow

    def whole(self, outputs: Sequence[Number], given: Mapping[str, str]) -> list[str]:
        """Return numbers of the whole element, given values of inputs."""
        return self.code.write(outputs, self.values | dict(given))

    def forces(self, pulls: str) -> str:
        """Return where forces on nodes and the lost power are, given what points add up."""
        return pulls

    def vectors_of(self, room: str) -> str:
        """Return where that is kept which strains points, given components of nodes."""
        return room

    def at_nodes(self, room: str) -> str:
        """Return where forces on nodes are, given those on ``vectors_of`` them."""
        return room

    def pulls(self, stress: Sequence[Number]) -> str:
        """Return where the forces on strains by a stress are, all points added up.

        It is empty where forces on nodes are linear in them, with constant factors.
        """
        return ""

    def derivatives(
        self, load: str, by_q: str, by_rate: str, by: str, numbers: Sequence[Number]
    ) -> tuple[str, str]:
        """Return where derivatives by places and velocities are; see ``TracedCell.pulled``.

        Args:
            load: Where the weights of ``vectors_of`` nodes are.
            by_q, by_rate: Where derivatives by strains and their rates are.
            by: Where those by numbers are, which are added to.
            numbers: What these are by.
        """
        return by_q, by_rate

    def changed_forces(
        self, numbers: Sequence[Number], given: Mapping[str, str], **rooms: str
    ) -> str:
        """Return where the changes of forces on nodes are; see ``TracedCell.pushed``.

        Args:
            numbers: Of elements, which change.
            given: Their changes.
            rooms: Where ``pulls`` are, "pull", and where the changes of ``vectors_of`` nodes,
                of their velocities, and of what points add up are, "dx", "dv" and "dpull".
        """
        return rooms["dpull"]

    def carried(
        self, dx: str, dv: str = "", numbers: Sequence[Number] = (),
        given: Mapping[str, str] | None = None,
    ) -> str:  # fmt: skip
        """Return where the changes of what strains the points are, or those of its rates.

        Args:
            dx, dv: Where the changes of places and velocities are; without the second, those of
                strains are returned.
            numbers: That change, too.
            given: Their changes, by the names of inputs.
        """
        return dv or dx

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
        """Return the components of a vector that are variables of a point, by tensors.

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
        """Add stored numbers to the variables of each lane in a vector."""
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


def parted(values: Sequence[str], *counts: int) -> tuple[Sequence[str], ...]:
    """Return values in parts of so many, and the rest."""
    found, start = list[Sequence[str]](), 0
    for count in counts:
        found.append(values[start : start + count])
        start += count
    return *found, values[start:]
