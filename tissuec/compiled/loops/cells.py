"""Loops over elements whose points are strained by all nodes together; see ``autodiff.cells``.

What points add up are forces on these strains, of which those on nodes follow. Tables have
where points are in the place of gradients of shape functions.
"""

from collections.abc import Mapping, Sequence, Set

from tissuec.autodiff.cells import TracedCell
from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.point_frame import PointLoop, parted
from tissuec.compiled.loops.tables import LANES


def point_loop(point: TracedPoint, nodes: int, points: int) -> PointLoop:
    """Return a writer of one loop over elements.

    Args:
        point: Of the elements.
        nodes, points: Of each element.
    """
    if point.cell is None:
        return PointLoop(point, nodes, points)
    return CellLoop(point, point.cell, nodes, points)


class CellLoop(PointLoop):
    """Writes one loop over such elements.

    Args:
        point: Of the elements.
        cell: What strains it.
        nodes, points: Of each element.
    """

    def __init__(self, point: TracedPoint, cell: TracedCell, nodes: int, points: int):
        super().__init__(point, nodes, points)
        self.cell, self.strained = cell, self.components
        #: Places of the numbers as drawn, by their names.
        self._drawn = {str(each.operation.detail): k for k, each in enumerate(cell.drawn)}

    # --- points -----------------------------------------------------------------------------

    @property
    def row_shape(self) -> tuple[int, int]:
        return len(self.point.at), 1

    @property
    def of_element(self) -> Sequence[Number]:
        return *self.cell.pull, *self.cell.strains

    def strain(self, needed: Set[str]) -> tuple[str, str]:
        """Return where strains are kept, and their rates; see ``PointLoop``."""
        strain = self.keep(self.of_cell(self.cell.strains))
        rate = self.keep(self.of_cell(self.cell.rates)) if self.flow else ""
        if "swell" in needed:
            (self.values["swell"],) = self.of_cell([self.cell.swell])
        return strain, rate

    def at_point(self, q: str) -> tuple[list[list[str]], str, dict[str, str]]:
        """Return where a point is, its volume, and the values of all inputs."""
        place, weight, values = super().at_point(q)
        return place, weight, values | {f"at.{k}": value for k, (value,) in enumerate(place)}

    def gradient_of(self, room: str, slopes: Sequence[Sequence[str]]) -> list[str]:
        """Return strains that are kept: those of a point are those of its element."""
        return [self.read(room, k) for k in range(self.components)]

    def push(self, room: str, stress: Sequence[str], slopes: Sequence[Sequence[str]]) -> None:
        """Add forces on strains."""
        for k, value in enumerate(stress):
            self.add_up(value, room, k)

    # --- elements ---------------------------------------------------------------------------

    def of_cell(
        self, outputs: Sequence[Number], given: Mapping[str, str] | None = None, /, **rooms: str
    ) -> list[str]:
        """Return numbers of the whole element.

        Args:
            given: Values of further inputs.
            rooms: Where others than places and velocities are, by the first letters of their
                names.
        """
        code, places = self.code, self._drawn
        values, rooms = self.values | dict(given or {}), {"x": self.at, "v": self.flow} | rooms
        base = code.address("%drawn", code.add(f"mul i64 %row, {LANES * len(places)}"))
        for name in sorted(self.graph.inputs_of(outputs) - values.keys()):
            letter, _, number = name.rpartition(".")
            if name in places:
                values[name] = code.load(code.address(base, LANES * places[name]))
            elif rooms.get(letter):
                values[name] = self.read(rooms[letter], int(number))
        return code.write(outputs, values)

    def whole(self, outputs: Sequence[Number], given: Mapping[str, str]) -> list[str]:
        return self.of_cell(outputs, given)

    def forces(self, pulls: str) -> str:
        """Return where forces on nodes and the lost power are; see ``PointLoop``."""
        *found, alone = self.of_cell([*self.cell.pull, self.cell.power], pull=pulls)
        lost = self.read(pulls, self.strained)
        return self.keep([*found, self.code.add(f"fadd {self.code.kind} {lost}, {alone}")])

    def carried(
        self, dx: str, dv: str = "", numbers: Sequence[Number] = (),
        given: Mapping[str, str] | None = None,
    ) -> str:  # fmt: skip
        """Return where the changes of strains are, or those of their rates."""
        outputs = self.cell.turned(numbers) if dv else self.cell.carried(numbers)
        return self.keep(self.of_cell(outputs, given, dx=dx, dv=dv))

    def pulls(self, stress: Sequence[Number]) -> str:
        """Return where the forces on strains by a stress are, all points added up."""
        room = self.room_of(self.strained)
        self.clear(room, self.strained)

        def add(q: str) -> None:
            slopes, weight, values = self.at_point(q)
            minus = self.code.add(f"fneg {self.code.kind} {weight}")
            self.push(room, self.times(minus, self.code.write(stress, values)), slopes)

        self.each_point("pulls", add)
        return room

    def derivatives(
        self, load: str, by_q: str, by_rate: str, by: str, numbers: Sequence[Number]
    ) -> tuple[str, str]:
        """Return where derivatives by places and velocities are; see ``TracedCell.pulled``.

        Args:
            load: Where the weights of the nodes are.
            by_q, by_rate: Where derivatives by strains and their rates are.
            by: Where those by numbers are, which are added to.
            numbers: What these are by.
        """
        rooms = {
            "pull": self.pulls(self.point.stress), "load": load,
            "by_q": by_q, "by_rate": by_rate,
        }  # fmt: skip
        every = self.of_cell(self.cell.pulled(numbers), **rooms)
        by_x, by_v, of_numbers = parted(every, 3 * self.nodes, 3 * self.nodes)
        for k, each in enumerate(of_numbers):
            self.add_up(each, by, k)
        return self.keep(by_x), self.keep(by_v)
