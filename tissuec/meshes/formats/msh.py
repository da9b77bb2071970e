"""MSH, the format of Gmsh: versions 1, 2, 4.0 and 4.1, as text or binary.

Sections are between ``$Name`` and ``$EndName``. Physical groups number the elements in
versions 1 and 2; from version 4 on they belong to the entities of the geometry, and each block
of elements names its entity. An entity may have no group, or several.
"""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tissuec.meshes.formats import (
    CORNERS,
    FORMATS,
    Floats,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    known_by,
)
from tissuec.meshes.formats.numbers import NumberStream, as_floats, as_whole

#: Numbers of element types -> kind and number of nodes, of which the first are the corners.
_KINDS = {
    1: ("line", 2), 8: ("line", 3), 26: ("line", 4), 27: ("line", 5), 28: ("line", 6),
    2: ("triangle", 3), 9: ("triangle", 6), 20: ("triangle", 9), 21: ("triangle", 10),
    22: ("triangle", 12), 23: ("triangle", 15), 24: ("triangle", 15), 25: ("triangle", 21),
    3: ("quad", 4), 10: ("quad", 9), 16: ("quad", 8), 36: ("quad", 16), 37: ("quad", 25),
    4: ("tetra", 4), 11: ("tetra", 10), 29: ("tetra", 20), 30: ("tetra", 35),
    31: ("tetra", 56), 5: ("hexahedron", 8), 12: ("hexahedron", 27), 17: ("hexahedron", 20),
    92: ("hexahedron", 64), 93: ("hexahedron", 125), 6: ("wedge", 6), 13: ("wedge", 18),
    18: ("wedge", 15), 7: ("pyramid", 5), 14: ("pyramid", 14), 19: ("pyramid", 13),
    15: ("point", 1),
}  # fmt: skip
_SECTION = re.compile(rb"^[ \t]*\$(\w+)[ \t\r]*(?:\n|\Z)", re.MULTILINE)
_OLD = {b"NOD": b"Nodes", b"ELM": b"Elements"}  # sections of version 1


@FORMATS.member(".msh")
@known_by(begins=(b"$MeshFormat", b"$NOD"))
def read(data: bytes, path: Path) -> RawMesh:
    """Return nodes and elements; physical groups are parts, by name where they have one.

    Raises:
        FormatError: The file is no MSH file, or a section is missing or cut off.
    """
    reader = _MshReader()
    place = 0
    while found := _SECTION.search(data, place):
        name = found[1]
        if not reader.version:
            reader.begin(name, data[found.end() :])
        place = reader.section(_OLD.get(name, name), name, data, found.end())
    if not reader.version:
        raise FormatError('it does not begin with "$MeshFormat"')
    return reader.mesh()


class _MshReader:
    """What has been read of a file.

    Attributes:
        version: Of the format; 0.0 before it is known.
        order: Of bytes in binary files; "" for text.
    """

    def __init__(self) -> None:
        self.version, self.order = 0.0, ""
        self.names: dict[tuple[int, int], str] = {}
        self.physical: dict[tuple[int, int], tuple[int, ...]] = {}  # groups of an entity
        self.tags, self.position = np.zeros(0, np.int64), np.zeros((0, 3))
        # Of each kind: blocks of corners, and the numbers of the elements.
        self.blocks: list[tuple[str, Indices, Indices]] = []
        self.members: dict[tuple[int, int], list[Indices]] = {}  # elements of a group
        self.declared, self.count, self.curved = 0, 0, 0
        self.seen: set[bytes] = set()

    def begin(self, name: bytes, rest: bytes) -> None:
        """Find out the version and how numbers are written."""
        if name in _OLD:
            self.version = 1.0
        elif name == b"MeshFormat":
            words = rest[:100].split(b"\n", 1)[0].split()
            try:
                self.version, binary = float(words[0]), int(words[1])
            except (IndexError, ValueError):
                raise FormatError('the version after "$MeshFormat" cannot be read') from None
            if not 2.0 <= self.version < 5.0:
                raise FormatError(f"version {self.version:g} of the format is not supported")
            one = rest.partition(b"\n")[2][:4]  # the number 1, from which the order follows
            self.order = ("<" if one == b"\1\0\0\0" else ">") if binary else ""

    def section(self, name: bytes, written: bytes, data: bytes, place: int) -> int:
        """Read a section and return the place after it."""
        readers: dict[bytes, Callable[[NumberStream], None]] = {
            b"Nodes": self._nodes_4 if self.version >= 4.0 else self._nodes,
            b"Elements": self._elements_4 if self.version >= 4.0 else self._elements,
            b"Entities": self._entities,
        }
        if name in readers and self.order:
            if self.version < 4.0:  # the count is text
                line, _, _ = data[place : place + 32].partition(b"\n")
                self.declared, place = NumberStream(line).one(), place + len(line) + 1
            numbers = NumberStream(data[place:], self.order)
            readers[name](numbers)
            place += numbers.used
        end = re.compile(rb"\$END%s\b" % re.escape(written), re.IGNORECASE)
        stop = end.search(data, place)
        if stop is None:
            if name in (*readers, b"PhysicalNames", b"ParametricNodes"):
                raise FormatError(f"it is truncated: $End{name.decode()} is missing")
            return place
        content = data[place : stop.start()]
        if name == b"PhysicalNames":
            self._names(content)
        elif name == b"ParametricNodes":
            self._parametric(content)
        elif name in readers and not self.order:
            numbers = NumberStream(content)
            if self.version < 4.0:
                self.declared = numbers.one()
            readers[name](numbers)
            if numbers.left:
                raise FormatError(f"${name.decode()} has {numbers.left} numbers too many")
        self.seen.add(b"Nodes" if name == b"ParametricNodes" else name)
        return stop.end()

    def _names(self, content: bytes) -> None:
        found = re.findall(rb'^\s*(\d+)\s+(-?\d+)\s+"(.*)"', content, re.MULTILINE)
        for dimension, tag, name in found:
            self.names[int(dimension), int(tag)] = name.decode("utf-8", "replace")

    # --- nodes --------------------------------------------------------------------------------

    def _nodes(self, numbers: NumberStream) -> None:
        tags, places = numbers.table(self.declared, [("i4", 1), ("f8", 3)])
        self._enter(as_whole(tags[:, 0]), places)

    def _parametric(self, content: bytes) -> None:
        """Read nodes that are followed by their parameters on curves and surfaces."""
        lines = content.split(b"\n")
        rows = [line.split()[:4] for line in lines[1:] if line.strip()]
        if len(rows) != as_whole(as_floats(lines[0].split()))[0] or {*map(len, rows)} - {4}:
            raise FormatError("$ParametricNodes is truncated")
        values = as_floats([word for row in rows for word in row]).reshape(-1, 4)
        self._enter(as_whole(values[:, 0]), values[:, 1:])

    def _nodes_4(self, numbers: NumberStream) -> None:
        size = "u8"
        blocks = numbers.one(size)
        numbers.take(1 if self.version < 4.1 else 3, size)  # the count, and extreme tags
        tags: list[Indices] = [np.zeros(0, np.int64)]
        places: list[Floats] = [np.zeros((0, 3))]
        for _ in range(blocks):
            head = numbers.whole(3)
            dimension = int(head[1] if self.version < 4.1 else head[0])
            count, width = numbers.one(size), 3 + (dimension if head[2] else 0)
            if self.version < 4.1:
                found, rows = numbers.table(count, [("i4", 1), ("f8", width)])
            else:
                found = numbers.take(count, size)
                rows = numbers.take(width * count, "f8").reshape(count, width)
            tags.append(as_whole(found).ravel())
            places.append(rows[:, :3])
        self._enter(np.concatenate(tags), np.concatenate(places))

    def _enter(self, tags: Indices, position: Floats) -> None:
        order = np.argsort(tags, kind="stable")
        self.tags, self.position = tags[order], position[order].astype(float)
        twice = np.flatnonzero(self.tags[1:] == self.tags[:-1])
        if len(twice):
            raise FormatError(f"duplicate node {self.tags[twice[0]]}")

    # --- elements -----------------------------------------------------------------------------

    def _elements(self, numbers: NumberStream) -> None:
        """Read the elements of versions 1 and 2; the first of the tags of each is a group."""
        if self.order:
            while self.count < self.declared:
                kind, many, tags = (numbers.one() for _ in range(3))
                width = 1 + tags + self._kind(kind)[1]
                rows = numbers.whole(many * width).reshape(-1, width)
                groups = rows[:, 1] if tags else np.zeros(many, np.int64)
                self._grouped(kind, rows[:, 1 + tags :], self.count + np.arange(many), groups)
            return
        values = numbers.whole(numbers.left).tolist()
        found: dict[int, list[tuple[int, int, list[int]]]] = {}
        at = 0
        for element in range(self.declared):
            kind = group = start = 0
            try:
                kind = values[at + 1]
                tags, first = (2, 2) if self.version < 2.0 else (values[at + 2], 3)
                group = values[at + first] if tags else 0
                # Version 1 has two tags, and then the number of nodes.
                start = at + first + tags + (self.version < 2.0)
                at = start + self._kind(kind)[1]
            except IndexError:
                at = len(values) + 1
            if at > len(values):
                raise FormatError(f"it is truncated: element {element + 1} is cut off")
            found.setdefault(kind, []).append((element, group, values[start:at]))
        if at != len(values):
            raise FormatError(f"$Elements has {len(values) - at} numbers too many")
        for kind, rows in found.items():
            elements, groups, nodes = (np.array(column) for column in zip(*rows, strict=True))
            self._grouped(kind, nodes, elements, groups)

    def _grouped(self, kind: int, nodes: Indices, elements: Indices, groups: Indices) -> None:
        """Enter elements of one kind, of which each belongs to a group, or to none (0)."""
        for group in np.unique(groups[groups != 0]).tolist():
            members = self.members.setdefault((self._dimension(kind), abs(group)), [])
            members.append(elements[groups == group])
        self._add(kind, nodes, elements)

    def _entities(self, numbers: NumberStream) -> None:
        counts = numbers.whole(4, "u8").tolist()
        for dimension, count in enumerate(counts):
            for _ in range(count):
                tag = numbers.one()
                # Version 4.1 has a place instead of a box for points.
                numbers.take(3 if dimension == 0 and self.version >= 4.1 else 6, "f8")
                groups = numbers.whole(numbers.one("u8")).tolist()
                self.physical[dimension, tag] = tuple(abs(group) for group in groups)
                if dimension:
                    numbers.take(numbers.one("u8"), "i4")  # the entities that bound it

    def _elements_4(self, numbers: NumberStream) -> None:
        size = "u8"
        blocks = numbers.one(size)
        numbers.take(1 if self.version < 4.1 else 3, size)
        for _ in range(blocks):
            head = numbers.whole(3).tolist()
            entity = (head[1], head[0]) if self.version < 4.1 else (head[0], head[1])
            count, width = numbers.one(size), 1 + self._kind(head[2])[1]
            kind = "i4" if self.version < 4.1 else size
            rows = numbers.whole(count * width, kind).reshape(-1, width)
            elements = self.count + np.arange(count)
            for group in self.physical.get(entity, ()):
                self.members.setdefault((entity[0], group), []).append(elements)
            self._add(head[2], rows[:, 1:], elements)

    def _kind(self, number: int) -> tuple[str, int]:
        if number not in _KINDS:
            raise FormatError(f"elements of type {number} are not supported")
        return _KINDS[number]

    def _dimension(self, kind: int) -> int:
        name = self._kind(kind)[0]
        return {"point": 0, "line": 1, "triangle": 2, "quad": 2}.get(name, 3)

    def _add(self, kind: int, nodes: Indices, elements: Indices) -> None:
        name, count = self._kind(kind)
        corners = CORNERS.get(name, count)
        self.count += len(elements)
        self.curved += len(elements) * (name in CORNERS and count > corners)
        self.blocks.append((name, nodes[:, :corners], elements))

    # --- all of it ----------------------------------------------------------------------------

    def mesh(self) -> RawMesh:
        for name in (b"Nodes", b"Elements"):
            if name not in self.seen:
                raise FormatError(f"it contains no ${name.decode()}")
        cells: list[MeshCells] = []
        ignored: dict[str, int] = {}
        for name, nodes, elements in self.blocks:
            if name in CORNERS:
                cells.append(MeshCells(name, self._rows(nodes, elements), elements))
            else:
                ignored[name] = ignored.get(name, 0) + len(elements)
        parts: dict[str, Indices] = {}
        for group, found in self.members.items():
            name = self.names.get(group, f"physical {group[1]}")
            former = [parts[name]] if name in parts else []
            parts[name] = np.unique(np.concatenate([*former, *found]))
        return RawMesh(self.position, tuple(cells), parts, {}, ignored, self.curved)

    def _rows(self, nodes: Indices, elements: Indices) -> Indices:
        """Return nodes by their numbers from 0 instead of their tags."""
        rows = np.minimum(np.searchsorted(self.tags, nodes), max(len(self.tags) - 1, 0))
        wrong = self.tags[rows] != nodes if len(self.tags) else np.ones(nodes.shape, bool)
        if wrong.any():
            row = int(np.flatnonzero(wrong.any(axis=1))[0])
            raise FormatError(
                f"element {elements[row] + 1} uses node {nodes[row][wrong[row]][0]}, which "
                "does not exist"
            )
        return rows
