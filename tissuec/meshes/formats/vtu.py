"""VTK's XML formats of one file: unstructured grids (``.vtu``) and polygons (``.vtp``).

Arrays are text, or binary in base64 or raw, and may be compressed. Several pieces are put
together. Whole-numbered arrays of the cells number parts, as ``label 3``.
"""

import base64
import lzma
import re
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from tissuec.meshes.formats import FORMATS, FormatError, RawMesh, known_by, way_of
from tissuec.meshes.formats.numbers import as_floats, as_whole
from tissuec.meshes.formats.vtk import of_types
from tissuec.meshes.formats.xml import parse

_APPENDED = re.compile(rb"<AppendedData\b([^>]*)>\s*_")
_TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
_DECOMPRESSORS: Mapping[str, Callable[[], Any]] = {
    "vtkZLibDataCompressor": zlib.decompressobj,
    "vtkLZMADataCompressor": lzma.LZMADecompressor,
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
        self.appended, self.is_raw = b"", False
        if found := _APPENDED.search(data):
            self.appended, self.is_raw = data[found.end() :], b"raw" in found[1]
            data = data[: found.start()] + b"</VTKFile>"
        self.root = parse(data)
        if self.root.tag != "VTKFile":
            raise FormatError(f'its outermost element is "{self.root.tag}", not "VTKFile"')
        self.order = ">" if self.root.get("byte_order") == "BigEndian" else "<"
        self.head = np.dtype(self.order + _TYPES[self.root.get("header_type", "UInt32")])
        self.compressor = self.root.get("compressor")

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
        if len(position) != int(piece.get("NumberOfPoints", "0")):
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
        declared = sum(int(piece.get(f"NumberOf{name}", "0")) for name in counts)
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
        text = (element.text or "").encode()
        if kind not in _TYPES:
            raise FormatError(f'an array of type "{kind}" is not supported')
        if form == "ascii":
            return as_floats(text.split())
        if form == "appended":
            text, is_raw = self.appended[int(element.get("offset", "0")) :], self.is_raw
        else:
            text, is_raw = text.strip(), False
        try:
            values = self._decoded(text, is_raw)
            return np.frombuffer(values, self.order + _TYPES[kind])
        except FormatError:
            raise
        except (ValueError, IndexError, zlib.error, lzma.LZMAError):
            name = element.get("Name", "")
            raise FormatError(
                f'it is truncated: the array "{name}" cannot be decoded'
            ) from None

    def _decoded(self, data: bytes, is_raw: bool) -> bytes:
        """Return the bytes of an array, after their number or those of its blocks."""
        width = self.head.itemsize
        if self.compressor is None:
            size = int(np.frombuffer(_bytes(data, width, is_raw), self.head, 1)[0])
            return _bytes(data, width + size, is_raw)[width:]
        if self.compressor not in _DECOMPRESSORS:
            raise FormatError(
                f'its arrays are compressed by "{self.compressor}", which is not supported',
                "save it with ZLib compression, or without compression",
            )
        blocks = int(np.frombuffer(_bytes(data, width, is_raw), self.head, 1)[0])
        length = (3 + blocks) * width
        head = np.frombuffer(_bytes(data, length, is_raw), self.head).astype(np.int64)
        # In base64, the numbers are encoded apart from the blocks.
        data = data[length if is_raw else 4 * -(-length // 3) :]
        ends = np.cumsum(head[3:]).tolist()
        packed = _bytes(data, ends[-1] if ends else 0, is_raw)
        unpack, most = _DECOMPRESSORS[self.compressor], max(int(head[1]), 1)
        parts = zip([0, *ends], ends, strict=False)
        # No block holds more than is declared, so that few bytes do not unfold into gigabytes.
        return b"".join(unpack().decompress(packed[a:b], most) for a, b in parts)


def _bytes(data: bytes, size: int, is_raw: bool) -> bytes:
    """Return the first bytes of raw data or of base64."""
    found = data[:size] if is_raw else base64.b64decode(data[: 4 * -(-size // 3)])[:size]
    if len(found) < size:
        raise ValueError
    return found
