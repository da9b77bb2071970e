"""Abaqus input files: nodes, elements, sets, and instances of parts.

A type of elements is known by its shape and its number of nodes, whatever letters follow
(hybrid, reduced, modified, thermal, …). Types without such a shape, and rigid ones beside
others, are left out and counted. Element sets and instances are parts, node sets are groups.
Nothing is read but the file itself: what refers to other files is refused.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from tissuec.meshes.formats import FORMATS, Floats, FormatError, Indices, RawMesh, known_by
from tissuec.meshes.formats.abaqus import (
    NONE,
    Instance,
    ModelMesh,
    NumberSet,
    PartContents,
    shape_of,
)
from tissuec.meshes.formats.numbers import as_floats, as_whole

#: Keywords that make nodes or elements of others, or change what coordinates mean.
_MAKING = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"}
_WRITE_OUT = "write the mesh node by node, such as with a job that Abaqus/CAE writes"
_READ = {"NODE", "ELEMENT", "NSET", "ELSET", "PART", "INSTANCE"}


class _Block(Struct, frozen=True):
    """A keyword with its lines of data.

    Attributes:
        keyword: In capitals, without blanks and stars.
        options: Their values, by their names in capitals; empty where there is none.
        lines: Without comments and empty ones.
        number: Of the line of the keyword, from 1.
    """

    keyword: str
    options: Mapping[str, str]
    lines: list[str]
    number: int

    def fields(self) -> list[str]:
        """Return the entries between commas, of all lines."""
        return [word for line in self.lines for word in map(str.strip, line.split(",")) if word]


@FORMATS.member(".inp")
@known_by(holds=b"\n*NODE")
def read(data: bytes, path: Path) -> RawMesh:
    """Return nodes and elements.

    Raises:
        FormatError: The file is broken, refers to another one, or makes nodes or elements of
            others.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    file = _AbaqusModel()
    for block in _blocks(text):
        file.take(block)
    return file.mesh(len(data))


def _blocks(text: str) -> Iterator[_Block]:
    """Yield the keywords of a file with their data; raises FormatError at other files."""
    head, number = "", 0
    lines: list[str] = []
    for at, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("**"):
            continue
        if line.startswith("*"):
            if head:
                yield _block(head, lines, number)
            head, number, lines = line, at, []
        elif head.endswith(",") and not lines and line[0].isalpha():
            head += line  # the options of a keyword continue
        elif head:
            lines.append(line)
    if head:
        yield _block(head, lines, number)


def _block(head: str, lines: list[str], number: int) -> _Block:
    keyword, *options = head.replace("*", "").split(",")
    keyword = "".join(keyword.split()).upper()
    found = dict[str, str]()
    for option in options:
        name, _, value = option.partition("=")
        found["".join(name.split()).upper()] = value.strip().strip('"')
    if keyword == "INCLUDE" or (found.get("INPUT") and keyword in _READ):
        raise FormatError(
            f"it includes another file, in line {number}, which is not supported",
            "join the files",
        )
    if keyword in _MAKING or found.get("SYSTEM", "R").upper() != "R":
        raise FormatError(f"*{keyword} in line {number} is not supported", _WRITE_OUT)
    return _Block(keyword, found, lines, number)


class _AbaqusModel:
    """The contents of a file, by parts and instances."""

    def __init__(self) -> None:
        self.rest, self.assembly = PartContents(), PartContents()
        self.parts: dict[str, tuple[str, PartContents]] = {}  # by their names in capitals
        self.instances: list[Instance] = []
        self._open = self.rest

    def take(self, block: _Block) -> None:
        """Read a keyword; unknown ones are no part of a mesh."""
        name = block.options.get("NAME", "")
        match block.keyword:
            case "NODE":
                self._open.nodes.append(_nodes(block))
                self._name(block, "NSET", self._open.nodes[-1][0])
            case "ELEMENT":
                self._elements(block)
            case "NSET" | "ELSET":
                self._open.sets.append(_set(block))
            case "PART":
                self._open = PartContents()
                self.parts[name.upper()] = name, self._open
            case "INSTANCE":
                part = block.options.get("PART", "")
                if part and part.upper() not in self.parts:
                    raise FormatError(f'there is no part "{part}" for the instance "{name}"')
                self._open = PartContents()
                place = [as_floats(line.replace(",", " ").split()) for line in block.lines]
                self.instances.append(Instance(name, part.upper(), self._open, place))
            case "ASSEMBLY" | "ENDINSTANCE":
                self._open = self.assembly
            case "ENDPART" | "ENDASSEMBLY":
                self._open = self.rest
            case _:
                pass

    def _elements(self, block: _Block) -> None:
        name = block.options.get("TYPE", "").upper()
        shape = shape_of(name)
        if shape is None:
            self._open.left_out[name] += _element_count(block.lines)
            return
        values = as_whole(as_floats(block.fields()))
        width = 1 + shape[1]
        if len(values) % width:
            raise FormatError(
                f"the elements of type {name} below line {block.number} cannot be read: they "
                f"do not have {shape[1]} nodes each"
            )
        rows = values.reshape(-1, width)
        self._open.elements.append((name, rows))
        self._name(block, "ELSET", rows[:, 0])

    def _name(self, block: _Block, kind: str, numbers: Indices) -> None:
        """Enter a set that the keyword of its nodes or elements names."""
        if name := block.options.get(kind):
            self._open.sets.append(NumberSet(kind, name, numbers, NONE.reshape(0, 3)))

    def mesh(self, size: int) -> RawMesh:
        """Return the mesh of all instances, or of all parts of a file without instances.

        Args:
            size: Of the file [bytes].
        """
        mesh = ModelMesh(8 * size)  # a number takes up to eight bytes, and a digit one
        mesh.place(self.rest)
        if not self.instances:
            for _, scope in self.parts.values():
                mesh.place(scope)
        copies = {
            one.name.upper(): mesh.place(
                self.parts[one.part][1].with_all_of(one.own) if one.part else one.own, one.place
            )
            for one in self.instances
        }
        if len(copies) > 1:
            for one in self.instances:
                mesh.join("ELSET", one.name, copies[one.name.upper()].elements.numbers)
        mesh.place(self.assembly, copies=copies)
        used = {one.part for one in self.instances}
        remarks = [
            f'the part "{name}" has no instance and is left out'
            for key, (name, _) in self.parts.items()
            if self.instances and key not in used
        ]
        return mesh.result(remarks)


def _element_count(lines: Sequence[str]) -> int:
    """Return how many elements lines describe; a comma at the end continues the element."""
    return sum(not before.endswith(",") for before in ("", *lines[:-1])) if lines else 0


def _nodes(block: _Block) -> tuple[Indices, Floats]:
    """Return the numbers and the positions of nodes; directions after them are left out."""
    rows: list[list[str]] = []
    for line in block.lines:
        words = line.split(",")
        if len(words) < 4 or not all(words[:4]):
            raise FormatError(
                f'"{line[:40]}" below line {block.number} cannot be read as a node with three '
                "coordinates"
            )
        rows.append(words[:4])
    # Fortran writes exponents with a D, too.
    values = as_floats([word.replace("D", "E") for row in rows for word in row])
    values = values.reshape(-1, 4)
    return as_whole(values[:, 0]), values[:, 1:]


def _set(block: _Block) -> NumberSet:
    kind, options = block.keyword, block.options
    found = NumberSet(
        kind,
        options.get(kind, ""),
        NONE,
        NONE.reshape(0, 3),
        instance=options.get("INSTANCE", ""),
        elements=options.get("ELSET", "") if kind == "NSET" else "",
    )
    if "GENERATE" in options:
        rows: list[list[int]] = []
        for line in dict.fromkeys(block.lines):
            words = [word for word in line.split(",") if word.strip()]
            row = as_whole(as_floats(words)).tolist()
            row = [*row, 1] if len(row) == 2 else row
            if len(row) != 3 or row[2] < 1:
                raise found.error(f'"{line[:40]}" is not first, last and step')
            rows.append(row)
        return found._replace(ranges=as_whole(np.array(rows)).reshape(-1, 3))
    fields = block.fields()
    names = tuple(dict.fromkeys(word for word in fields if not word.isdecimal()))
    numbers = as_whole(as_floats([word for word in fields if word.isdecimal()]))
    return found._replace(numbers=numbers, names=names)
