"""STL: triangles one by one, as text or in 50 bytes each.

Every triangle writes its corners anew. Corners that are equal to the last bit are one node
here, which loses nothing; those that are only nearly equal are for the repair to judge.
"""

import re
from pathlib import Path

import numpy as np

from tissuec.meshes.formats import (
    FORMATS,
    Floats,
    FormatError,
    Indices,
    MeshCells,
    RawMesh,
    known_by,
)
from tissuec.meshes.formats.numbers import as_floats

_HEAD = 84  # bytes before the triangles: 80 of a remark, 4 of their number
_FACET = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)[ \t]*$", re.MULTILINE)
_SOLID = re.compile(rb"^[ \t]*solid\b[ \t]*([^\n]*)", re.MULTILINE | re.IGNORECASE)
_FACETS = re.compile(rb"^[ \t]*(end[ \t]*)?facet\b", re.MULTILINE)
_END = re.compile(rb"^[ \t]*end[ \t]*solid\b", re.MULTILINE)


@FORMATS.member(".stl")
@known_by(begins=b"solid")
def read(data: bytes, path: Path) -> RawMesh:
    """Return the triangles; of a text with several solids, the nodes of each by its name.

    Raises:
        FormatError: The file is no STL, or is cut off.
    """
    count = int.from_bytes(data[80:_HEAD], "little")
    start = data[:4096].lstrip(b"\xef\xbb\xbf \r\n\t").lower()
    is_text = start.startswith(b"solid") and b"facet" in start
    if is_text and len(data) != _HEAD + 50 * count:
        return _read_text(data)
    if len(data) < _HEAD or not count:
        raise FormatError(f"it is not an STL file: it has {len(data)} bytes and no triangle")
    if len(data) < _HEAD + 50 * count:
        whole = max(0, len(data) - _HEAD) // 50
        raise FormatError(
            f"it is truncated: it declares {count} triangles, but contains {whole}"
        )
    facets = np.frombuffer(data, _FACET, count, _HEAD)
    return _mesh(facets["corner"].astype(float).reshape(-1, 3), {})


def _read_text(data: bytes) -> RawMesh:
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    text = data.lower()
    facets = [bool(end) for end in _FACETS.findall(text)]
    begin, end = facets.count(False), facets.count(True)
    found = _VERTEX.findall(text)
    if begin != end or len(found) != 3 * begin:
        raise FormatError(
            f"it is truncated or invalid: {begin} triangles begin, {end} end, and "
            f"{len(found)} corners can be read"
        )
    remarks: tuple[str, ...] = ()
    if not _END.search(text[-1024:]):
        remarks = ('the file does not end with "endsolid"; part of it may be missing',)
    corners = as_floats([word for corner in found for word in corner]).reshape(-1, 3)
    # Each solid reaches to the next; its own are those of the corners before its end.
    starts = [(place.start(), place[1]) for place in _SOLID.finditer(data)]
    places = [place.start() for place in _VERTEX.finditer(text)] if starts[1:] else []
    bounds = np.searchsorted(places, [start for start, _ in starts]).tolist()
    names: dict[str, Indices] = {}
    for (_, name), low, high in zip(starts, bounds, [*bounds[1:], len(corners)], strict=True):
        key = name.decode("utf-8", "replace").strip()
        if key:
            former = names.get(key, np.zeros(0, dtype=np.int64))
            names[key] = np.concatenate([former, np.arange(int(low) // 3, int(high) // 3)])
    return _mesh(corners, names, remarks)


def _mesh(corners: Floats, parts: dict[str, Indices], remarks: tuple[str, ...] = ()) -> RawMesh:
    node, number = one_each(corners)
    cells = MeshCells("triangle", number.reshape(-1, 3), np.arange(len(number) // 3))
    return RawMesh(node, (cells,), parts, remarks=remarks)


def one_each(points: Floats) -> tuple[Floats, np.ndarray]:
    """Return each distinct point once, and the number of the point of each input.

    Args:
        points: Coordinates in any unit, shape (n, 3).

    Returns:
        Distinct points in order of appearance, shape (distinct, 3), and numbers, shape (n,).
    """
    order = np.lexsort(points.T)
    first = np.ones(len(points), dtype=bool)
    first[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    lowest = np.minimum.reduceat(order, np.flatnonzero(first)) if len(order) else order
    # Numbered by the first of each run in the file, so that nodes keep its order.
    rank = np.argsort(np.argsort(lowest))
    number = np.empty(len(points), dtype=np.int64)
    number[order] = rank[np.cumsum(first) - 1]
    return points[np.sort(lowest)], number
