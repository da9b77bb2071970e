"""Reading of label images, and what is refused."""

from collections.abc import Mapping
from hashlib import sha256
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import parse_unit
from tissuec.meshes.formats import FormatError
from tissuec.meshes.images import LabelImage, Labels
from tissuec.meshes.images.raw import RawImage

MOST_LABELS = 256  # more different values are those of a picture
_FEW = 1 << 16  # below, numbers are counted faster than they are sorted
_FLATTEST = 1e-6  # of the product of the lengths of the axes: volume of a voxel
_UNITS = ("mm", "cm", "um", "m", "nm", "km", "dm", "pm")  # of length, usual ones first
_SEGMENT = (
    "segment it first, such as in 3D Slicer or ITK-SNAP, and save the segmentation as .nrrd or "
    ".nii.gz"
)


def read(data: bytes, path: Path, factor: float) -> LabelImage:
    """Return a label image.

    Args:
        data: Contents of the file.
        path: The file.
        factor: Metres in the unit that the scene gives.

    Raises:
        FormatError: The file is broken or no label image, has another unit, or does not say
            how large its voxels are.
    """
    if not data:
        raise FormatError("the file is empty")
    if path.name.lower().endswith((".nii", ".nii.gz")):
        from tissuec.meshes.images.nifti import read as read_format
    else:
        from tissuec.meshes.images.nrrd import read as read_format
    with np.errstate(all="ignore"):  # numbers out of range are found below
        raw = read_format(data, path)
    _require_axes(raw)
    _require_unit(raw, factor)
    labels = _whole(raw.values)
    count = _counted(labels)
    names, remarks = _named(raw, count)
    digest = sha256(data + raw.more).hexdigest()
    axes, origin = raw.axes * factor, raw.origin * factor
    return LabelImage(labels, axes, origin, names, count, (*raw.remarks, *remarks), digest)


def _require_axes(raw: RawImage) -> None:
    """Refuse voxels without a size."""
    lengths = np.linalg.norm(raw.axes, axis=0)
    if not np.isfinite(raw.axes).all() or not np.isfinite(raw.origin).all():
        raise FormatError("the size or the place of its voxels is not finite")
    if not lengths.all():
        raise FormatError("the size of its voxels is 0", "save it again with its voxel size")
    if abs(np.linalg.det(raw.axes / lengths)) < _FLATTEST:
        raise FormatError("the axes of its voxels lie in one plane")


def _require_unit(raw: RawImage, given: float) -> None:
    """Refuse another unit than that of the file, if it states one.

    Args:
        given: Metres in the unit that the scene gives.
    """
    if raw.unit is not None and not isclose(raw.unit, given):
        own, other = _unit_of(raw.unit), _unit_of(given)
        raise FormatError(f"the unit of its coordinates is {own}, not {other}", unit=own)


def _unit_of(factor: float) -> str:
    """Return a unit of length by its metres."""
    names = (name for name in _UNITS if isclose(parse_unit(name).factor, factor))
    return next(names, f"{factor:.9g} m")


def _whole(values: NDArray[Any]) -> Labels:
    """Return labels as whole numbers in the byte order of this machine."""
    if values.dtype.kind == "b":
        return values.view(np.uint8)
    if values.dtype.kind in "iu":
        return values.astype(values.dtype.newbyteorder("="), copy=False)
    if values.dtype.kind != "f":
        raise FormatError("its voxels are not numbers, but colours or vectors", _SEGMENT)
    found = np.zeros(values.shape, np.int32, order="F")
    for into, layer in zip(found.T, values.T, strict=True):
        if not np.isfinite(layer).all():
            raise FormatError("some of its voxels are not finite, so they are not labels")
        if np.any(layer != np.rint(layer)) or np.abs(layer).max(initial=0.0) >= 2.0**31:
            raise FormatError(
                "its voxels are not whole numbers, so they are not labels", _SEGMENT
            )
        into[:] = layer
    return found


def _counted(labels: Labels) -> dict[int, int]:
    """Return the number of voxels of each label but 0, by ascending label."""
    count: dict[int, int] = {}
    for layer in labels.T:  # one after another: no copy of the whole image
        if layer.min() >= 0 and layer.max() < _FEW:
            numbers = np.bincount(layer.ravel())
            values = np.flatnonzero(numbers)
            numbers = numbers[values]
        else:
            values, numbers = np.unique(layer, return_counts=True)
        for value, many in zip(values.tolist(), numbers.tolist(), strict=True):
            count[value] = count.get(value, 0) + many
        if len(count) > MOST_LABELS:
            raise FormatError(
                f"it contains more than {MOST_LABELS} different values: it is a picture, not "
                "an image of labels",
                _SEGMENT,
            )
    count.pop(0, None)
    if not count:
        raise FormatError("it contains no labelled voxel: all of them are 0", _SEGMENT)
    if min(count) < 0:
        raise FormatError(f"it contains the label {min(count)}, but labels are positive")
    return dict(sorted(count.items()))


def _named(raw: RawImage, count: Mapping[int, int]) -> tuple[dict[int, str], list[str]]:
    """Return names of the labels that occur, and remarks on those that do not.

    Raises:
        FormatError: Two of them have the same name, which would have two meanings.
    """
    names: dict[int, str] = {}
    for value in count:
        # No text can contain the sign that ends it.
        name = " ".join(raw.names.get(value, "").replace('"', "'").split())
        names[value] = name or f"label {value}"
    named = {name: value for value, name in names.items()}
    for value, name in names.items():
        if (other := named[name]) != value:
            raise FormatError(
                f'the labels {value} and {other} have the same name, "{name}"',
                "rename one of them in 3D Slicer, and save the segmentation again",
            )
    empty = [f'"{name}"' for value, name in raw.names.items() if value not in count]
    remarks = [f"no voxel is labelled {', '.join(empty)}"] if empty else []
    return names, remarks
