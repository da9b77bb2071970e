"""Coupons: bars and strips of a tissue, with sets of nodes for loads and gauges, as text.

A coupon is twice as long as wide. An even stress σ acts on its faces with σ times the area that
each node represents: a whole cell inside of a face, half of one at an edge, a quarter at a
corner. Lengths are measured between two gauges, at a quarter of the length from either end.
"""

from collections.abc import Iterator, Sequence
from itertools import product

from msgspec import Struct

AXES = ("x", "y", "z")
SPRINGS = "kind is sodium chloride; reach is second neighbours; "  # of a lattice of them
BODY, FREE = "lab coupon", "lab free tissue"  # FREE: of prestress
FIRST, SECOND, FRONT, BACK = "lab first gauge", "lab second gauge", "lab front", "lab back"


class Coupon(Struct, frozen=True):
    """A bar with a square section, or a strip of a sheet.

    Attributes:
        cells: Across; with an odd number, there are no gauges.
        width: [m].
        thickness: Of a strip [m]; None of a bar.
        fibres: Along which axis they run, "x" or "y"; empty without any.
        of_springs: Whether it is a net of springs, and not of elements.
        prestressed: Whether its tissue has a prestress, which is removed from elements.
    """

    cells: int
    width: float
    thickness: float | None = None
    fibres: str = ""
    of_springs: bool = False
    prestressed: bool = False

    @property
    def cell(self) -> float:
        """Return the length of a cell [m]."""
        return self.width / self.cells

    @property
    def length(self) -> float:
        return 2.0 * self.width

    @property
    def section(self) -> float:
        """Return the area of the section [m²]."""
        return self.width * (self.width if self.thickness is None else self.thickness)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Return the lengths of its sides along x, y and, of a bar, z [m]."""
        sides = (self.length, self.width, self.width)
        return sides if self.thickness is None else sides[:2]

    def shown(self) -> str:
        """Return how many cells it has along its sides: ``4 x 2 x 2``."""
        return " x ".join(str(round(size / self.cell)) for size in self.sizes)

    # --- text ---------------------------------------------------------------------------------

    def body(self, tissue: str, *, tabs: str = "", rupture: bool = False) -> Iterator[str]:
        """Yield the body and its sets.

        Args:
            tissue: What it is made of.
            tabs: What it is made of beyond the gauges, if of another tissue.
            rupture: Whether it can break.
        """
        if self.prestressed and not self.of_springs:
            yield f"tissue {FREE} like {tissue} {{ prestress = 0 }}"
            tissue = FREE
        yield f"body {BODY} {{"
        yield f"  {self._mesh()}"
        yield f"  tissue is {tissue}"
        if self.thickness is not None:
            yield f"  thickness = {_si(self.thickness, 'm')}"
        if self.fibres:
            yield f"  fibres = ({', '.join(str(int(axis == self.fibres)) for axis in AXES)})"
        if tabs:
            low, high = (self._beside(part, side) for part, side in ((0.25, -1), (0.75, 1)))
            yield f"  region lab tabs where x < {low} or x > {high} {{ tissue is {tabs} }}"
            if self.of_springs:
                yield "  interface is mean"
        if rupture:
            yield "  rupture is allowed"
        yield "}"
        if self.cells % 2:
            return  # no node is at a gauge
        gauge = f"x between {self._beside(0.25, -1)} and {self._beside(0.75, 1)}"
        conditions = {
            FIRST: self._at(0.25),
            SECOND: self._at(0.75),
            FRONT: f"{gauge} and y < {self._beside(0.0, 1)}",
            BACK: f"{gauge} and y > {self._inner('y')[1]}",
        }
        for name, condition in conditions.items():
            yield f"set {name} = nodes of {BODY} where {condition}"

    def _mesh(self) -> str:
        sides = [_si(size, "m") for size in self.sizes]
        if self.thickness is None:
            return (
                f"mesh is lattice {{ {SPRINGS if self.of_springs else ''}"
                f"cell = {_si(self.cell, 'm')}; box from (0, 0, 0) m to ({', '.join(sides)}) }}"
            )
        columns, rows = (round(size / self.cell) + 1 for size in self.sizes)
        return (
            f"mesh is sheet {{ corner = (0, 0, 0) m; first edge = ({sides[0]}, 0, 0); "
            f"second edge = (0, {sides[1]}, 0); columns = {columns}; rows = {rows}"
            f"{'; diagonals is both' if self.of_springs else ''} }}"
        )

    def _at(self, part: float) -> str:
        return f"x between {self._beside(part, -1)} and {self._beside(part, 1)}"

    def _beside(self, part: float, side: int) -> str:
        """Return a place beside a part of the length, a quarter of a cell off."""
        return _si(part * self.length + 0.25 * side * self.cell, "m")

    def _inner(self, axis: str) -> tuple[str, str]:
        """Return between which places the inner nodes along an axis are."""
        size = self.sizes[AXES.index(axis)]
        return _si(0.25 * self.cell, "m"), _si(size - 0.25 * self.cell, "m")

    # --- loads --------------------------------------------------------------------------------

    def faces(self, *names: str) -> Iterator[str]:
        """Yield sets for the nodes of faces, as a whole and by the area of each node.

        Args:
            names: Such as "x0" for the face at the least x, and "y1" for that at the largest y.
        """
        for name in names:
            axis, others = name[0], [one for one in AXES[: len(self.sizes)] if one != name[0]]
            low, high = self._inner(axis)
            here = f"{axis} < {low}" if name[1] == "0" else f"{axis} > {high}"
            yield f"set lab {name} = nodes of {BODY} where {here}"
            for borders in product((False, True), repeat=len(others)):
                beside = [self._side(*one) for one in zip(others, borders, strict=True)]
                condition = " and ".join([here, *beside])
                yield f"set {_piece(name, borders)} = nodes of {BODY} where {condition}"

    def _side(self, axis: str, at_border: bool) -> str:
        low, high = self._inner(axis)
        if at_border:
            return f"({axis} < {low} or {axis} > {high})"
        return f"{axis} between {low} and {high}"

    def pushes(self, face: str, stress: Sequence[float]) -> Iterator[str]:
        """Yield the orders that let an even stress (x, y, z) [Pa] act on a face."""
        area = self.cell * (self.cell if self.thickness is None else self.thickness)
        for borders in product((False, True), repeat=len(self.sizes) - 1):
            share = area * 0.5 ** sum(borders)
            force = ", ".join(f"{share * one:.15g}" for one in stress)
            yield f"push {_piece(face, borders)} with ({force}) N on each node"

    def releases(self, face: str) -> Iterator[str]:
        """Yield the orders that end what acts on a face."""
        for borders in product((False, True), repeat=len(self.sizes) - 1):
            yield f"stop pushing {_piece(face, borders)}"

    def corner(self, y: int, z: int) -> str:
        """Return the node in a corner of the far end of a bar, each way at its start or end."""
        ends = [
            f"{axis} > {self._inner(axis)[1]}" if end else f"{axis} < {self._inner(axis)[0]}"
            for axis, end in zip(AXES, (1, y, z), strict=True)
        ]
        return f"nodes of {BODY} where {' and '.join(ends)}"


def _piece(face: str, borders: Sequence[bool]) -> str:
    return f"lab {face} " + "".join("b" if border else "i" for border in borders)


def _si(value: float, unit: str) -> str:
    return f"{value:.15g} {unit}"
