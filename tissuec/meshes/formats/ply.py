"""PLY, the Stanford format, as text or binary: vertices and faces with properties.

The header says which elements follow, and of each the properties: numbers, or lists of numbers
with their lengths. Whole-numbered properties of the faces number parts, as ``label 3``; colours
and texture coordinates are left out.
"""

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.meshes.formats import (
    FORMATS,
    FormatError,
    Indices,
    RawMesh,
    faces,
    known_by,
    numbered_parts,
)
from tissuec.meshes.formats.numbers import NumberStream, as_whole

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
    "int64": "i8", "uint64": "u8", "long": "i8", "ulong": "u8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_HEAD = re.compile(rb"end_header[ \t]*\r?\n")
_CORNERS = ("vertex_indices", "vertex_index")
_COLOURS = {"red", "green", "blue", "alpha"}


class _Property(NamedTuple):
    """A property of an element; ``length`` is the type of the length of a list, or empty."""

    name: str
    type: str
    length: str


class _Element(NamedTuple):
    name: str
    rows: int
    properties: list[_Property]


class _List(NamedTuple):
    """The lists of all rows, one after the other, and their lengths."""

    flat: NDArray[Any]
    sizes: Indices


@FORMATS.member(".ply")
@known_by(begins=b"ply")
def read(data: bytes, path: Path) -> RawMesh:
    """Return vertices and faces.

    Raises:
        FormatError: The header is missing or unknown, or elements are missing.
    """
    end = _HEAD.search(data)
    if not data.startswith(b"ply") or end is None:
        raise FormatError('it does not begin with a header from "ply" to "end_header"')
    order, elements = _header(data[: end.start()].decode("ascii", "replace"))
    numbers = NumberStream(data[end.end() :], order)
    found: dict[str, dict[str, Any]] = {}
    for element in elements:
        try:
            found[element.name] = _columns(element, numbers)
        except FormatError as error:
            raise FormatError(f"in its {element.name} elements: {error}") from None
    if not order and numbers.left:
        raise FormatError(f"there are {numbers.left} numbers more than its header declares")
    return _mesh(found, {element.name: element.rows for element in elements})


def _header(text: str) -> tuple[str, list[_Element]]:
    """Return how numbers are written, "" for text, and the elements."""
    order: str | None = None
    elements: list[_Element] = []
    for line in text.splitlines()[1:]:
        words = line.split()
        try:
            match words[:1]:
                case ["format"]:
                    order = _ORDERS[words[1]]
                case ["element"]:
                    elements.append(_Element(words[1], int(words[2]), []))
                case ["property"] if words[1] == "list":
                    length, kind = _TYPES[words[2]], _TYPES[words[3]]
                    elements[-1].properties.append(_Property(words[4], kind, length))
                case ["property"]:
                    elements[-1].properties.append(_Property(words[2], _TYPES[words[1]], ""))
                case _:  # comments
                    pass
        except (IndexError, KeyError, ValueError):
            raise FormatError(f'"{line.strip()[:40]}" in its header cannot be read') from None
    if order is None:
        raise FormatError("its header does not say the format of its numbers")
    return order, elements


def _columns(element: _Element, numbers: NumberStream) -> dict[str, Any]:
    """Return the values of each property: an array, or a ``_List``."""
    properties, count = element.properties, element.rows
    if count and not properties:
        raise FormatError("they have no properties")
    if not any(one.length for one in properties):
        values = numbers.table(count, [(one.type, 1) for one in properties])
        return {one.name: column[:, 0] for one, column in zip(properties, values, strict=True)}
    if count:
        place = numbers.used
        sizes = [int(_row(numbers, one)[0]) if one.length else 1 for one in properties]
        numbers.used = place
        uniform = _uniform(element, numbers, sizes)
        if uniform is not None:
            return uniform
        numbers.used = place
    return _row_by_row(element, numbers)


def _row(numbers: NumberStream, one: _Property) -> tuple[int, NDArray[Any]]:
    """Return the length of the next list, and its values."""
    size = numbers.one(one.length)
    return size, numbers.take(size, one.type)


def _uniform(
    element: _Element, numbers: NumberStream, sizes: list[int]
) -> dict[str, Any] | None:
    """Return the properties if the lists of all rows are as long as those of the first."""
    record: list[tuple[str, int]] = []
    for one, size in zip(element.properties, sizes, strict=True):
        record += [(one.length, 1)] if one.length else []
        record.append((one.type, size))
    try:
        columns = iter(numbers.table(element.rows, record))
    except FormatError:
        return None
    found: dict[str, Any] = {}
    for one, size in zip(element.properties, sizes, strict=True):
        if not one.length:
            found[one.name] = next(columns)[:, 0]
            continue
        if (next(columns) != size).any():
            return None
        lengths = np.full(element.rows, size, dtype=np.int64)
        found[one.name] = _List(next(columns).ravel(), lengths)
    return found


def _row_by_row(element: _Element, numbers: NumberStream) -> dict[str, Any]:
    parts: dict[str, list[NDArray[Any]]] = {one.name: [] for one in element.properties}
    for _ in range(element.rows):
        for one in element.properties:
            values = _row(numbers, one)[1] if one.length else numbers.take(1, one.type)
            parts[one.name].append(values)
    found: dict[str, Any] = {}
    for one in element.properties:
        flat = np.concatenate([np.zeros(0), *parts[one.name]])
        sizes = np.array([len(part) for part in parts[one.name]], dtype=np.int64)
        found[one.name] = _List(flat, sizes) if one.length else flat
    return found


def _mesh(found: dict[str, dict[str, Any]], counts: dict[str, int]) -> RawMesh:
    vertex = found.get("vertex", {})
    if not {"x", "y", "z"} <= set(vertex):
        raise FormatError("its vertices have no x, y and z")
    position = np.stack([vertex[axis].astype(float) for axis in "xyz"], axis=1)
    face = found.get("face", {})
    lists = next((face[name] for name in _CORNERS if name in face), None)
    if not isinstance(lists, _List):
        if "tristrips" in found:
            raise FormatError(
                "it contains strips of triangles, which are not supported",
                "save it as single triangles in the program that made it",
            )
        lists = _List(np.zeros(0, np.int64), np.zeros(0, np.int64))
    if short := int((lists.sizes < 3).sum()):
        raise FormatError(f"{short} faces have fewer than three corners")
    parts: dict[str, Indices] = {}
    for name, values in face.items():
        if not isinstance(values, _List) and name not in _COLOURS:
            parts |= numbered_parts(name, values)
    cells = faces(as_whole(lists.flat), lists.sizes, np.arange(len(lists.sizes)))
    ignored = {"line": counts["edge"]} if counts.get("edge") else {}
    return RawMesh(position, cells, parts, {}, ignored)
