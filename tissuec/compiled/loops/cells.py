"""Loops over elements whose points are strained by all nodes together; see ``autodiff.cells``.

Points add up forces on the coefficients of strains, from which those on nodes follow. Rooms of
places and velocities contain z and dz/dt. Tables contain the places of points instead of
gradients of shape functions.
"""

from collections.abc import Mapping, Sequence, Set

from tissuec.autodiff.cells import TERMS, TracedCell
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
        self.cell, self.strained = cell, len(cell.strains)
        #: Places of the numbers as drawn, by their names.
        self._drawn = {str(each.operation.detail): k for k, each in enumerate(cell.drawn)}
        self._needed: Sequence[int] = ()
        self.at = self.flow = ""

    # --- points -----------------------------------------------------------------------------

    @property
    def row_shape(self) -> tuple[int, int]:
        return 3, 1

    @property
    def of_element(self) -> Sequence[Number]:
        return *self.cell.pull, *self.cell.strains

    def strain(self, needed: Set[str]) -> tuple[str, str]:
        """Return where strains are kept, and their rates; see ``PointLoop``."""
        own, also = set(self.point.needed_by(needed)), set(self.point.active)
        self._needed = sorted(own | also)
        strain = self._kept(self.cell.strains, self._needed)
        rate = self._kept(self.cell.rates, self._needed) if self.flow else ""
        if "swell" in needed:
            (self.values["swell"],) = self.of_cell([self.cell.swell])
        return strain, rate

    def _kept(
        self, outputs: Sequence[Number], strains: Sequence[int],
        given: Mapping[str, str] | None = None, /, **rooms: str,
    ) -> str:  # fmt: skip
        """Return where numbers that belong to coefficients are: those of some strains."""
        room = self.room_of(self.strained)
        some = [q for k in strains for q in self._coefficients(k)]
        values = self.of_cell([outputs[q] for q in some], given, **rooms)
        for q, value in zip(some, values, strict=True):
            self.put(value, room, q)
        return room

    def _coefficients(self, strain: int) -> range:
        begins = self.cell.begins
        return range(begins[strain], begins[strain + 1])

    def gathered(self, vector: str) -> str:
        """Return where z of a vector at the nodes is kept."""
        return self.vectors_of(super().gathered(vector))

    def vectors_of(self, room: str) -> str:
        """Return where z is, given where components of nodes are."""
        return self.keep(self.of_cell(self.cell.vectors, node=room))

    def slopes_at(self, q: str) -> tuple[list[list[str]], str]:
        """Return the ``TERMS`` at a point but for the first, which is 1; and its volume."""
        at, weight = super().slopes_at(q)
        terms = list[list[str]]()
        for first, *more in TERMS[1:]:
            value = at[first][0]
            for axis in more:
                value = self.code.add(f"fmul {self.code.kind} {value}, {at[axis][0]}")
            terms.append([value])
        return terms, weight

    def gradient_of(self, room: str, slopes: Sequence[Sequence[str]]) -> list[str]:
        """Return the strains of a point by kept coefficients; of those that matter."""
        found = [""] * self.components
        for k in self._needed:
            first, *more = self._coefficients(k)
            value = self.read(room, first)
            for q, (term,) in zip(more, slopes, strict=False):
                value = self.code.fused(self.read(room, q), term, value)
            found[k] = value
        return found

    def push(self, room: str, stress: Sequence[str], slopes: Sequence[Sequence[str]]) -> None:
        """Add forces on coefficients."""
        for k in self.point.active:
            first, *more = self._coefficients(k)
            self.add_up(stress[k], room, first)
            for q, (term,) in zip(more, slopes, strict=False):
                self.put(self.code.fused(stress[k], term, self.read(room, q)), room, q)

    # --- elements ---------------------------------------------------------------------------

    def of_cell(
        self, outputs: Sequence[Number], given: Mapping[str, str] | None = None, /, **rooms: str
    ) -> list[str]:
        """Return numbers of the whole element.

        Args:
            given: Values of further inputs.
            rooms: Where others than z and dz/dt are, by the first letters of their
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
        lost = self.code.add(
            f"fadd {self.code.kind} {self.read(pulls, self.strained)}, {alone}"
        )
        return self.keep([*self._spread(found), lost])

    def at_nodes(self, room: str) -> str:
        """Return where forces on nodes are, given where those on z are."""
        return self.keep(self._spread([self.read(room, k) for k in range(len(self.cell.x))]))

    def _spread(self, forces: Sequence[str]) -> list[str]:
        return self.of_cell(self.cell.spread, {f"push.{k}": f for k, f in enumerate(forces)})

    def carried(
        self, dx: str, dv: str = "", numbers: Sequence[Number] = (),
        given: Mapping[str, str] | None = None,
    ) -> str:  # fmt: skip
        """Return where the changes of strains are, or those of their rates."""
        outputs = self.cell.turned(numbers) if dv else self.cell.carried(numbers)
        return self._kept(outputs, self._needed, given, dx=dx, dv=dv)

    def pulls(self, stress: Sequence[Number]) -> str:
        """Return where the forces on strains by a stress are; see ``PointLoop``."""
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
        """Return where derivatives by places and velocities are; see ``PointLoop``."""
        rooms = {
            "pull": self.pulls(self.point.stress), "load": load,
            "by_q": by_q, "by_rate": by_rate,
        }  # fmt: skip
        every = self.of_cell(self.cell.pulled(numbers), **rooms)
        by_x, by_v, of_numbers = parted(every, len(self.cell.x), len(self.cell.v))
        for k, each in enumerate(of_numbers):
            self.add_up(each, by, k)
        return self.keep(self._spread(by_x)), self.keep(self._spread(by_v))

    def changed_forces(
        self, numbers: Sequence[Number], given: Mapping[str, str], **rooms: str
    ) -> str:
        """Return where the changes of forces on nodes are; see ``PointLoop``."""
        changed = self.of_cell(self.cell.pushed(numbers), given, **rooms)
        return self.at_nodes(self.keep(changed))
