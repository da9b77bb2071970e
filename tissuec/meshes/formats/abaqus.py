"""The mesh of an Abaqus model: copies of parts at their places, and sets of all of them."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.meshes.formats import CORNERS, Floats, FormatError, Indices, MeshCells, RawMesh
from tissuec.meshes.formats.packed import Room

#: Types of elements by their beginning, the number of their nodes, and the letters after it.
_SOLIDS = re.compile(r"[A-Z]{0,2}C3D(\d+)[A-UW-Z]*")
_FACES = re.compile(r"(S|STRI|DS|M3D|SFM3D|R3D|CPS|[AD]C2D)([34689])[A-Z]*5?")
_KINDS = {
    4: "tetra", 10: "tetra", 5: "pyramid", 13: "pyramid", 6: "wedge", 15: "wedge",
    8: "hexahedron", 20: "hexahedron", 27: "hexahedron",
}  # fmt: skip
_RIGID = "R3D"
_DRAWN = ("CPS", "AC2D", "DC2D")  # faces of solids in files of mesh programs, such as Gmsh
NONE: Indices = np.zeros(0, dtype=np.int64)
_COPIED = 1 << 27  # bytes of nodes and elements that small files may repeat


class NumberSet(NamedTuple):
    """A set of nodes or elements, by numbers of its scope and by other sets.

    Attributes:
        kind: "NSET" or "ELSET".
        name: Its name.
        numbers: Of nodes or elements.
        ranges: Rows of first and last number, and step, shape (range, 3).
        names: Other sets of the same kind, or "instance.set", or "instance.number".
        instance: The instance whose numbers these are, or empty.
        elements: Of nodes, the element set whose nodes they are, or empty.
    """

    kind: str
    name: str
    numbers: Indices
    ranges: Indices
    names: tuple[str, ...] = ()
    instance: str = ""
    elements: str = ""

    def error(self, reason: str) -> FormatError:
        """Return why the set cannot be read."""
        return FormatError(f'the set "{self.name}" cannot be read: {reason}')


class PartContents(Struct):
    """Contents of a part, of an instance, or of the rest of the file, with own numbers.

    Attributes:
        nodes: Their numbers, and their positions in the unit of the file, shape (node, 3).
        elements: Their types, and in rows their number and their nodes.
        left_out: How many elements of each type are not read.
        sets: Of nodes and of elements.
    """

    nodes: list[tuple[Indices, Floats]] = field(default_factory=list[tuple[Indices, Floats]])
    elements: list[tuple[str, Indices]] = field(default_factory=list[tuple[str, Indices]])
    left_out: Counter[str] = field(default_factory=Counter[str])
    sets: list[NumberSet] = field(default_factory=list[NumberSet])

    def with_all_of(self, other: "PartContents") -> "PartContents":
        """Return this scope with all of another one."""
        return PartContents(
            self.nodes + other.nodes,
            self.elements + other.elements,
            self.left_out + other.left_out,
            self.sets + other.sets,
        )


class Instance(NamedTuple):
    """A part at a place.

    Attributes:
        name: Of the instance.
        part: Of the part, in capitals; empty if all is its own.
        own: Its contents that are not those of its part.
        place: A shift (3 numbers), and a rotation: two points of its axis, and an angle in
            degrees (7 numbers).
    """

    name: str
    part: str
    own: PartContents
    place: list[Floats]


class _Numbers(NamedTuple):
    """Numbers of nodes or elements in the file, ascending, and in the mesh."""

    known: Indices
    numbers: Indices

    @classmethod
    def of(cls, known: Indices, first: int, what: str) -> "_Numbers":
        order = np.argsort(known, kind="stable")
        ordered = known[order]
        if (again := ordered[1:] == ordered[:-1]).any():
            raise FormatError(f"duplicate {what} {ordered[1:][again][0]}")
        return cls(ordered, first + order)

    def find(self, wanted: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        """Return the numbers in the mesh, and which of them there are."""
        if not len(self.known):
            return np.zeros_like(wanted), np.zeros(len(wanted), dtype=bool)
        place = np.searchsorted(self.known, wanted).clip(max=len(self.known) - 1)
        return self.numbers[place], self.known[place] == wanted

    def between(self, first: int, last: int, step: int) -> Indices:
        """Return the numbers in the mesh of every step-th number of the file."""
        low, high = np.searchsorted(self.known, [first, last + 1]).tolist()
        every = (self.known[low:high] - first) % step == 0
        return self.numbers[low:high][every]


class PlacedPart(NamedTuple):
    """A scope in the mesh, with its sets, by their keyword and their name in capitals."""

    nodes: _Numbers
    elements: _Numbers
    sets: dict[tuple[str, str], Indices]


class ModelMesh:
    """The mesh, to which one scope after another is added.

    Args:
        room: What the file takes without copies of its parts [bytes].
    """

    def __init__(self, room: int) -> None:
        self.position: list[Floats] = []
        self.cells: list[tuple[str, MeshCells]] = []  # with all their nodes, by type
        self.left_out: Counter[str] = Counter()
        self.sets: dict[tuple[str, str], tuple[str, list[Indices]]] = {}
        self.count = {"NSET": 0, "ELSET": 0}
        self._room = Room(room + _COPIED)

    def place(
        self,
        scope: PartContents,
        place: Sequence[Floats] = (),
        copies: Mapping[str, PlacedPart] | None = None,
    ) -> PlacedPart:
        """Add the nodes, elements and sets of a scope.

        Args:
            scope: What is added.
            place: See ``Instance``.
            copies: Instances to which its sets may refer, by their names in capitals.

        Raises:
            FormatError: There is no room, a number is there twice, or what elements and sets
                refer to is not there.
        """
        known = np.concatenate([NONE, *(numbers for numbers, _ in scope.nodes)])
        position = np.concatenate([np.zeros((0, 3)), *(rows for _, rows in scope.nodes)])
        size = position.nbytes + sum(rows.nbytes for _, rows in scope.elements)
        self._room.take(size, "instances")
        nodes = _Numbers.of(known, self.count["NSET"], "node")
        self.position.append(_moved(position, place))
        self.count["NSET"] += len(known)
        first = self.count["ELSET"]
        for name, rows in scope.elements:
            element = self.count["ELSET"] + np.arange(len(rows))
            self.count["ELSET"] += len(rows)
            corners, found = nodes.find(rows[:, 1:].ravel())
            if not found.all():
                lost = rows[:, 1:].ravel()[~found][0]
                raise FormatError(
                    f"an element of type {name} has node {lost}, which does not exist"
                )
            corners = corners.reshape(rows[:, 1:].shape)
            kind, _ = shape_of(name) or ("", 0)
            self.cells.append((name, MeshCells(kind, corners, element)))
        known = np.concatenate([NONE, *(rows[:, 0] for _, rows in scope.elements)])
        copy = PlacedPart(nodes, _Numbers.of(known, first, "element"), {})
        self.left_out += scope.left_out
        for block in scope.sets:
            self._read_set(block, copy, copies or {})
        return copy

    def join(self, kind: str, name: str, rows: Indices) -> None:
        """Add nodes or elements to a set of the mesh."""
        if len(rows):
            self._room.take(rows.nbytes, "sets")
            self.sets.setdefault((kind, name.upper()), (name, []))[1].append(rows)

    def _read_set(
        self, one: NumberSet, copy: PlacedPart, copies: Mapping[str, PlacedPart]
    ) -> None:
        of = copy
        if one.instance:
            if one.instance.upper() not in copies:
                raise one.error(f'there is no instance "{one.instance}"')
            of = copies[one.instance.upper()]
        found = [_numbered(of, one, one.numbers)]
        if one.elements:
            found.append(self._nodes_of(_named(of, "ELSET", one.elements, one)))
        table = of.nodes if one.kind == "NSET" else of.elements
        for row in one.ranges.tolist():
            found.append(table.between(*row))
            self._room.take(found[-1].nbytes, "sets")
        for name in one.names:
            instance, _, inner = name.rpartition(".")
            other = copies.get(instance.upper())
            other, inner = (of, name) if other is None else (other, inner)
            if inner.isdecimal():
                found.append(_numbered(other, one, np.array([int(inner[:18])])))
            else:
                found.append(_named(other, one.kind, inner, one))
            self._room.take(found[-1].nbytes, "sets")
        key = one.kind, one.name.upper()
        rows = np.unique(np.concatenate(found))
        copy.sets[key] = np.union1d(copy.sets.get(key, NONE), rows)
        self.join(one.kind, one.name, rows)

    def _nodes_of(self, elements: Indices) -> Indices:
        rows = [c.nodes[np.isin(c.element, elements)].ravel() for _, c in self.cells]
        return np.unique(np.concatenate([NONE, *rows]))

    def result(self, remarks: Sequence[str]) -> RawMesh:
        """Return the whole mesh."""
        if any(not name.startswith(_RIGID) for name, _ in self.cells):
            for name, cells in self.cells:
                if name.startswith(_RIGID):
                    self.left_out[name] += len(cells.nodes)
            self.cells = [one for one in self.cells if not one[0].startswith(_RIGID)]
        curved, found = 0, list[MeshCells]()
        for name, cells in self.cells:
            corners = CORNERS[cells.kind]
            curved += len(cells.nodes) * (cells.nodes.shape[1] > corners)
            is_wall = cells.kind in ("triangle", "quad") and not name.startswith(_DRAWN)
            label = f"{name} element" if is_wall else ""
            found.append(MeshCells(cells.kind, cells.nodes[:, :corners], cells.element, label))
        parts, groups = (
            {
                name: np.unique(np.concatenate(rows))
                for (kind, _), (name, rows) in self.sets.items()
                if kind == wanted
            }
            for wanted in ("ELSET", "NSET")
        )
        is_read = np.zeros(self.count["ELSET"], dtype=bool)
        for cells in found:
            is_read[cells.element] = True
        parts = {name: rows for name, rows in parts.items() if is_read[rows].any()}
        ignored = {f"{name} element": many for name, many in self.left_out.items()}
        remarks = (*remarks, *(f"{counted(n, what)} left out" for what, n in ignored.items()))
        position = np.concatenate(self.position)
        return RawMesh(position, tuple(found), parts, groups, ignored, curved, remarks)


def shape_of(name: str) -> tuple[str, int] | None:
    """Return the kind of cells that a type of elements has, and its number of nodes.

    Args:
        name: Of the type, in capitals.
    """
    if found := _SOLIDS.fullmatch(name):
        kind = _KINDS.get(int(found[1]), "")
        return (kind, int(found[1])) if kind else None
    if found := _FACES.fullmatch(name):
        return ("triangle" if found[2] in "36" else "quad"), int(found[2])
    return None


def _moved(position: Floats, place: Sequence[Floats]) -> Floats:
    """Return positions in the unit of the file, shifted, and then turned about an axis.

    Args:
        position: Shape (node, 3).
        place: See ``Instance``.
    """
    shift, turn = (*place, None, None)[:2]
    if shift is not None:
        if len(shift) != 3:
            raise FormatError("the shift of an instance does not have three numbers")
        position = position + shift
    if turn is not None:
        if len(turn) != 7:
            raise FormatError("the rotation of an instance does not have seven numbers")
        start, axis, angle = turn[:3], turn[3:6] - turn[:3], np.radians(turn[6])
        if not (length := float(np.linalg.norm(axis))) > 0.0:
            raise FormatError("the axis of an instance has no length")
        axis = axis / length
        arm = position - start
        position = (
            start
            + arm * np.cos(angle)
            + np.cross(axis, arm) * np.sin(angle)
            + np.outer(arm @ axis, axis) * (1.0 - np.cos(angle))
        )
    return position


def _numbered(copy: PlacedPart, one: NumberSet, wanted: Indices) -> Indices:
    """Return the numbers in the mesh of nodes or elements, without elements left out."""
    rows, found = (copy.nodes if one.kind == "NSET" else copy.elements).find(wanted)
    if one.kind == "NSET" and not found.all():
        raise one.error(f"there is no node {wanted[~found][0]}")
    return rows[found]


def _named(copy: PlacedPart, kind: str, name: str, one: NumberSet) -> Indices:
    """Return the numbers in the mesh of the members of another set."""
    if (kind, name.upper()) not in copy.sets:
        raise one.error(f'there is no set "{name}"')
    return copy.sets[kind, name.upper()]
