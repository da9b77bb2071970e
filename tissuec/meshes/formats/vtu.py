"""VTK's XML formats of one file: unstructured grids (``.vtu``) and polygons (``.vtp``).

Arrays are text, or binary in base64 or raw, and may be compressed. Several pieces are put
together. Whole-numbered arrays of the cells number parts, as ``label 3``.
"""

import base64
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by, way_of
from tissuec.meshes.formats.numbers import as_floats, as_whole
from tissuec.meshes.formats.packed import Room, unpacked
from tissuec.meshes.formats.vtk import of_types
from tissuec.meshes.formats.xml import parse

_APPENDED = re.compile(rb"<AppendedData\b([^>]*)>\s*_")
_TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
_MOST_DIGITS = 18  # of a whole number
_METHODS: Mapping[str, str] = {
    "vtkZLibDataCompressor": "zlib",
    "vtkLZMADataCompressor": "LZMA",
}
#: Lists of cells of polygons in the order in which VTK numbers them, and their types.
_LISTS = {"Verts": 2, "Lines": 4, "Polys": 7, "Strips": 6}


@FORMATS.member(".vtu")
@known_by(holds=b'type="UnstructuredGrid"')
def read(data: bytes, path: Path) -> RawMesh:
    """Return the points and cells of an unstructured grid.

    Raises:
        FormatError: The file is no such file, or is cut off.
    """
    return _mesh(data, "UnstructuredGrid", path)


@FORMATS.member(".vtp")
@known_by(holds=b'type="PolyData"')
def read_polygons(data: bytes, path: Path) -> RawMesh:
    """Return the points and faces of polygons.

    Raises:
        FormatError: The file is no such file, or is cut off.
    """
    return _mesh(data, "PolyData", path)


def _mesh(data: bytes, kind: str, path: Path) -> RawMesh:
    try:
        return _XmlFile(data).mesh(kind, path)
    except FormatError:
        raise
    except (KeyError, ValueError) as error:  # an attribute that is missing or no number
        raise FormatError(f"it cannot be read: {error}") from None


class _XmlFile:
    """The elements of a file, and how its arrays are written."""

    def __init__(self, data: bytes):
        # Raw bytes after the elements are no XML.
        self.appended, self.is_raw = memoryview(b""), False
        if found := _APPENDED.search(data):
            self.appended, self.is_raw = memoryview(data)[found.end() :], b"raw" in found[1]
            data = data[: found.start()] + b"</VTKFile>"
        self.root = parse(data)
        if self.root.tag != "VTKFile":
            raise FormatError(f'its outermost element is "{self.root.tag}", not "VTKFile"')
        self.order = ">" if self.root.get("byte_order") == "BigEndian" else "<"
        self.head = np.dtype(self.order + _TYPES[self.root.get("header_type", "UInt32")])
        self.compressor = self.root.get("compressor")
        self.room = Room()  # for all arrays, many of which may lie at the same place

    def mesh(self, kind: str, path: Path) -> RawMesh:
        """Return all pieces as one mesh."""
        grid = self.root.find(kind)
        if grid is None:
            found = self.root.get("type", "")
            raise FormatError(f'it contains no "{kind}"', way_of(found, path))
        pieces = [self._piece(piece, kind) for piece in grid.findall("Piece")]
        if not pieces:
            raise FormatError("it contains no piece")
        position, flat, sizes, types, arrays = zip(*pieces, strict=True)
        start = np.cumsum([0, *map(len, position)])
        nodes = [one + first for one, first in zip(flat, start, strict=False)]
        names = set(arrays[0]).intersection(*arrays[1:])
        joined = {name: np.concatenate([one[name] for one in arrays]) for name in names}
        return of_types(
            np.concatenate(position),
            np.concatenate(nodes),
            np.concatenate(sizes),
            np.concatenate(types),
            dict(sorted(joined.items())),
        )

    def _piece(self, piece: Element, kind: str) -> tuple[Any, ...]:
        """Return points, corners, sizes, types and arrays of the cells of a piece."""
        points = piece.find("Points/DataArray")
        position = np.zeros((0, 3)) if points is None else self._array(points).reshape(-1, 3)
        if len(position) != _whole(piece, "NumberOfPoints"):
            raise FormatError(f"it is truncated: {len(position)} points were read")
        none = np.zeros(0, dtype=np.int64)
        flat, sizes, types = [none], [none], [none]
        for name, number in (_LISTS if kind == "PolyData" else {"Cells": 0}).items():
            arrays = {one.get("Name"): one for one in piece.findall(f"{name}/DataArray")}
            if not {"connectivity", "offsets"} <= set(arrays):
                continue
            corners, ends = (
                as_whole(self._array(arrays[n])) for n in ("connectivity", "offsets")
            )
            size = np.diff(ends, prepend=0)
            if (size < 0).any() or (len(ends) and ends[-1] != len(corners)):
                raise FormatError("the offsets of the cells do not match their corners")
            flat.append(corners)
            sizes.append(size)
            types.append(
                np.full(len(size), number) if number else as_whole(self._array(arrays["types"]))
            )
        found = np.concatenate(types)
        counts = ("Cells", *(f"{name}" for name in _LISTS))
        declared = sum(_whole(piece, f"NumberOf{name}") for name in counts)
        if len(found) != declared or sum(map(len, sizes)) != declared:
            raise FormatError(f"it is truncated: {len(found)} of {declared} cells were read")
        values = {
            one.get("Name", ""): self._array(one)
            for one in piece.findall("CellData/DataArray")
            if one.get("NumberOfComponents", "1") == "1" and one.get("type") in _TYPES
        }
        return position, np.concatenate(flat), np.concatenate(sizes), found, values

    def _array(self, element: Element) -> NDArray[Any]:
        kind, form = element.get("type", ""), element.get("format", "ascii")
        if kind not in _TYPES:
            raise FormatError(f'an array of type "{kind}" is not supported')
        text = (element.text or "").encode()
        if form == "ascii":
            return as_floats(text.split())
        if form == "appended":
            data, is_raw = self.appended[_whole(element, "offset") :], self.is_raw
        else:
            data, is_raw = memoryview(text.strip()), False
        try:
            values = self._decoded(data, is_raw)
            return np.frombuffer(values, self.order + _TYPES[kind])
        except (ValueError, IndexError) as error:
            reason = error if isinstance(error, FormatError) else "it is truncated"
            name = element.get("Name", "")
            raise FormatError(f'{reason}: the array "{name}" cannot be decoded') from None

    def _decoded(self, data: memoryview, is_raw: bool) -> bytes:
        """Return the bytes of an array, after their number or those of its blocks."""
        width = self.head.itemsize
        first = int(np.frombuffer(_bytes(data, width, is_raw), self.head, 1)[0])
        if self.compressor is None:
            size = self.room.take(first, "arrays")
            return _bytes(data, width + size, is_raw)[width:]
        if self.compressor not in _METHODS:
            raise FormatError(
                f'its arrays are compressed by "{self.compressor}", which is not supported',
                "save it with ZLib compression, or without compression",
            )
        length = self.room.take((3 + first) * width, "arrays")
        head = np.frombuffer(_bytes(data, length, is_raw), self.head).tolist()
        # In base64, the numbers are encoded apart from the blocks.
        data = data[length if is_raw else 4 * -(-length // 3) :]
        packed = _bytes(data, self.room.take(sum(head[3:]), "arrays"), is_raw)
        blocks: list[bytes] = []
        start = 0
        for size in head[3:]:
            block = packed[start : start + size]
            # No block holds more than is declared.
            blocks.append(unpacked(block, _METHODS[self.compressor], max(head[1], 1)))
            self.room.take(len(blocks[-1]), "arrays")
            start += size
        return b"".join(blocks)


def _whole(element: Element, name: str) -> int:
    """Return an attribute that is a whole number, 0 where it is missing."""
    text = element.get(name, "0").strip()
    if not (text.isascii() and text.isdecimal()) or len(text) > _MOST_DIGITS:
        raise FormatError(f'its {name} is "{text[:_MOST_DIGITS]}", which is not a whole number')
    return int(text)


def _bytes(data: memoryview, size: int, is_raw: bool) -> bytes:
    """Return the first bytes of raw data or of base64."""
    found = data[:size] if is_raw else base64.b64decode(data[: 4 * -(-size // 3)])[:size]
    if len(found) < size:
        raise ValueError
    return bytes(found)
