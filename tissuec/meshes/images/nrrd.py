"""NRRD files with their voxels (``.nrrd``) or beside them (``.nhdr``), read by pynrrd.

Teem's definition of the format, https://teem.sourceforge.net/nrrd/format.html. The names of
labels are those that 3D Slicer writes into the header of a segmentation: ``Segment0_Name`` and
``Segment0_LabelValue``.
"""

import re
from collections.abc import Mapping
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.files import read_bytes
from tissuec.core.units import LENGTH, Unit, UnitError, parse_unit
from tissuec.meshes.formats import FormatError
from tissuec.meshes.formats.packed import LARGEST, Room, unpacked
from tissuec.meshes.images import INSTALL, Floats
from tissuec.meshes.images.raw import RawImage, require_size, three_dimensional

#: How voxels are compressed, by their encoding.
_METHODS = {"gzip": "gzip", "gz": "gzip", "bzip2": "bzip2", "bz2": "bzip2"}
_LONGEST_HEADER = 1 << 20  # bytes
_END = re.compile(rb"\r?\n\r?\n")
#: Directions of the axes of a space, and how they count in the coordinates of the patient.
_SIGNS = {
    "left": 1.0, "right": -1.0, "posterior": 1.0, "anterior": -1.0, "superior": 1.0,
    "l": 1.0, "r": -1.0, "p": 1.0, "a": -1.0, "s": 1.0,
}  # fmt: skip
_ANATOMICAL = ("left-posterior-superior", "right-anterior-superior", "left-anterior-superior")
_NOT_ANATOMICAL = ("scanner-xyz", "3d-right-handed")
_AGAIN = "save the segmentation again in 3D Slicer"
_NO_ORIENTATION = "it does not state its orientation: its axes are used as x, y and z"


def read(data: bytes, path: Path) -> RawImage:
    """Return voxels, axes and names of labels.

    Args:
        data: Contents of the file.
        path: The file, beside which voxels may be.

    Raises:
        FormatError: The library is missing, the file is broken, or its axes are unknown.
    """
    header, voxels, more = _parts(data, path)
    directions, origin, remarks = _axes(header)
    values = _values(header, voxels)
    kinds = header.get("kinds", ["?"] * values.ndim)
    others = {
        axis: "layer" if kinds[axis].lower() in ("list", "vector", "?") else "component"
        for axis in np.flatnonzero(np.isnan(directions).any(axis=1)).tolist()
    }
    values = three_dimensional(values, others)
    axes = directions[~np.isnan(directions).any(axis=1)].T
    names, unnamed = _names(header)
    return RawImage(values, axes, origin, _unit(header), names, (*remarks, *unnamed), more)


def _parts(data: bytes, path: Path) -> tuple[dict[str, Any], bytes, bytes]:
    """Return the header, the bytes of the voxels, and those of another file."""
    if not data.startswith(b"NRRD"):
        raise FormatError('it does not begin with "NRRD"')
    try:
        library: Any = import_module("nrrd")
    except ImportError:
        raise FormatError("reading NRRD needs the optional package pynrrd", INSTALL) from None
    end = _END.search(data, 0, _LONGEST_HEADER)
    head, rest = (data[: end.start()], data[end.end() :]) if end else (data, b"")
    # The library itself drops all letters beyond ASCII, which names of segments may have.
    lines = head[:_LONGEST_HEADER].decode("utf-8", "replace").splitlines()
    try:
        header: dict[str, Any] = dict(library.read_header(lines))
    except Exception as error:  # whatever strange lines make it stumble over
        raise FormatError(f"its header cannot be read: {_reason(error)}") from None
    beside = header.pop("data file", None) or header.pop("datafile", None)
    if beside is None:
        return header, rest, b""
    more = _beside(path, str(beside))
    return header, more, more


def _beside(path: Path, name: str) -> bytes:
    """Return the contents of the file of the voxels."""
    if Path(name).name != name or name in ("LIST", "..", ".") or "%" in name or "\\" in name:
        raise FormatError(
            f'its voxels are in "{name}", which is not one file beside it',
            "save it as one file: .nrrd",
        )
    try:
        return read_bytes(path.with_name(name), LARGEST)
    except FileNotFoundError:
        raise FormatError(
            f'the file with its voxels is missing: "{name}"',
            "copy it to the same folder, or save the image as one file: .nrrd",
        ) from None
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise FormatError(
            f'the file with its voxels, "{name}", cannot be read: {reason}'
        ) from None


def _values(header: dict[str, Any], data: bytes) -> NDArray[Any]:
    """Return the voxels, the axes in the order of the header."""
    library: Any = import_module("nrrd")
    types: Mapping[str, str] = import_module("nrrd.reader")._TYPEMAP_NRRD2NUMPY
    kind = str(header.get("type", ""))
    if kind not in types or kind == "block":
        raise FormatError(f'its voxels are of the type "{kind}", which is not supported')
    shape = tuple(int(size) for size in header.get("sizes", ()))
    size = require_size(shape, np.dtype(types[kind]).itemsize)
    data = _skipped(header, data, size)
    try:
        return library.read_data(_without_skips(header), BytesIO(data))
    except Exception as error:  # whatever strange bytes make it stumble over
        reason = _reason(error)
        if (
            "Size of the data" in reason
            or "buffer size" in reason
            or "unexpected end" in reason
        ):
            reason = "it is truncated, or its sizes are not those of its voxels"
            raise FormatError(reason) from None
        raise FormatError(f"its voxels cannot be read: {reason}") from None


def _skipped(header: Mapping[str, Any], data: bytes, size: int) -> bytes:
    """Return the unpacked bytes of the voxels, after the lines and bytes that are skipped.

    Lines are skipped before and bytes after the data is unpacked. Skipping -1 bytes skips
    all but the last ones.

    Args:
        header: Of the file.
        data: What follows the header.
        size: Of the voxels [bytes].
    """
    lines = int(header.get("line skip", header.get("lineskip", 0)))
    skipped = int(header.get("byte skip", header.get("byteskip", 0)))
    if lines < 0 or skipped < -1:
        raise FormatError("its header skips a negative number of lines or bytes")
    start = 0
    for _ in range(lines):
        start = data.find(b"\n", start) + 1
        if not start:
            raise FormatError(f"its header skips {lines} lines, but there are fewer")
    data = data[start:]
    method = _METHODS.get(str(header.get("encoding")))
    if method is not None:
        # With one byte more than is needed, so that what checks the data is read, too.
        whole = LARGEST if skipped < 0 else min(size + skipped, LARGEST)
        data = unpacked(data, method, whole + 1)
        Room().take(len(data), "voxels")
    return data[-size:] if skipped < 0 else data[skipped:]


def _without_skips(header: Mapping[str, Any]) -> dict[str, Any]:
    """Return the header of unpacked data with nothing to skip."""
    skips = ("line skip", "lineskip", "byte skip", "byteskip")
    found = {key: value for key, value in header.items() if key not in skips}
    if header.get("encoding") in _METHODS:
        found["encoding"] = "raw"
    return found


def _axes(header: Mapping[str, Any]) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Return the step along each axis of the file, shape (axis, 3), and the first voxel.

    Steps along axes that are no directions in space are NaN.
    """
    count = len(header.get("sizes", ()))
    if "space directions" not in header:
        return _spacings(header, count)
    found = header["space directions"]
    rows = [np.full(3, np.nan) if row is None else np.asarray(row, float) for row in found]
    if len(rows) != count or any(len(row) != 3 for row in rows):
        raise FormatError('its "space directions" are not three numbers for each axis')
    signs, remarks = _signs(str(header.get("space", "")))
    origin = np.asarray(header.get("space origin", np.zeros(3)), float)
    if origin.shape != (3,):
        raise FormatError('its "space origin" is not three numbers')
    if "space origin" not in header:
        remarks = (
            *remarks,
            "it does not say where it is: its first voxel is placed at (0, 0, 0)",
        )
    return np.array(rows) * signs, origin * signs, remarks


def _spacings(header: Mapping[str, Any], count: int) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Return axes, origin and remarks of an image that states only the voxel size."""
    spacings = np.abs(np.asarray(header.get("spacings", ()), float))
    if len(spacings) != count or not np.isfinite(spacings).any():
        raise FormatError(
            "it does not say how large its voxels are",
            'save it with its voxel size: NRRD calls it "space directions"',
        )
    steps = np.full((count, 3), np.nan)
    spatial = np.flatnonzero(np.isfinite(spacings))[:3]
    steps[spatial] = np.eye(3)[: len(spatial)] * spacings[spatial, None]
    return steps, np.zeros(3), (_NO_ORIENTATION,)


def _signs(space: str) -> tuple[Floats, tuple[str, ...]]:
    """Return how coordinates of a space count in those of the patient, and remarks."""
    name = space.lower().removesuffix("-time")
    shorts = {"".join(word[0] for word in one.split("-")): one for one in _ANATOMICAL}
    name = shorts.get(name.removesuffix("t"), name)
    if name in _ANATOMICAL:
        return np.array([_SIGNS[word] for word in name.split("-")]), ()
    if not name or name in _NOT_ANATOMICAL:
        return np.ones(3), (_NO_ORIENTATION,)
    raise FormatError(
        f'its space is "{space}", which is not supported',
        f"save it in one of the spaces {', '.join(_ANATOMICAL)}",
    )


def _unit(header: Mapping[str, Any]) -> float | None:
    """Return metres in the unit of the coordinates, None if it is not said."""
    words = header.get("space units", header.get("units", []))
    words = {word for word in words if word and word not in ("none", "???")}
    if not words:
        return None
    try:
        found = {parse_unit(word) for word in words}
    except UnitError:
        found = set[Unit]()
    if len(found) != 1 or (unit := found.pop()).dimension != LENGTH:
        raise FormatError(
            f"the unit of its coordinates is unknown: {', '.join(sorted(words))}",
            'correct "space units" in its header, such as "mm" "mm" "mm", or remove this line',
        )
    return unit.factor


def _names(header: Mapping[str, Any]) -> tuple[dict[int, str], list[str]]:
    """Return the names that 3D Slicer gives to labels, and remarks on names without a label.

    Raises:
        FormatError: The label of a name is not a positive whole number, or has two names.
    """
    names: dict[int, str] = {}
    remarks: list[str] = []
    for key, name in header.items():
        found = re.fullmatch(r"(Segment\d+)_Name", key)
        if not found:
            continue
        entry = f"{found[1]}_LabelValue"
        if entry not in header:  # as in files of old versions
            remarks.append(f'the segment "{name}" is not used: it has no {entry}')
            continue
        value = _label(entry, str(header[entry]).strip())
        if names.get(value, name) != name:
            raise FormatError(
                f'the label {value} has two names, "{names[value]}" and "{name}"',
                f"correct {entry} in its header, or {_AGAIN}",
            )
        names[value] = str(name)
    return names, remarks


def _label(entry: str, written: str) -> int:
    """Return the label that an entry of the header gives; raises FormatError if it is none."""
    if not (written.isascii() and written.isdecimal()) or not int(written):
        raise FormatError(
            f'"{written}" is not a label, in {entry}: labels are whole numbers from 1 on',
            f"correct {entry} in its header, or {_AGAIN}",
        )
    return int(written)


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
