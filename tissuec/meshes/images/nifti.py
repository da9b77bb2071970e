"""NIfTI files of version 1 and 2 (``.nii``, ``.nii.gz``), read by nibabel.

Their coordinates count to the right, to the front and to the head; the first two change sign.
The matrix of the header (sform) counts before its quaternion (qform), as in most programs.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.meshes.formats import FormatError
from tissuec.meshes.formats.packed import GZIP, LARGEST, unpacked
from tissuec.meshes.images import INSTALL
from tissuec.meshes.images.raw import RawImage, require_size, three_dimensional

_TO_PATIENT = np.diag([-1.0, -1.0, 1.0])
_UNITS = {"meter": 1.0, "mm": 1e-3, "micron": 1e-6}
_HEADER = 1 << 24  # bytes: more than header and extensions take
_AXES = ("time step", "component", "component", "component")
_NO_ORIENTATION = (
    "it does not say where right, front and head are: its axes are taken as x, y and z"
)


def read(data: bytes, path: Path) -> RawImage:
    """Return voxels and axes.

    Args:
        data: Contents of the file, compressed or not.
        path: The file.

    Raises:
        FormatError: The library is missing, the file is broken, or its voxels have no size.
    """
    if data.startswith(GZIP):
        data = unpacked(data, "gzip", LARGEST + _HEADER)
    try:
        library: Any = import_module("nibabel")
    except ImportError:
        raise FormatError("reading NIfTI needs the optional package nibabel", INSTALL) from None
    version = _version(data)
    try:
        # The library also prints the findings on the header that it raises.
        with library.imageglobals.LoggingOutputSuppressor():
            image = getattr(library, f"Nifti{version}Image").from_bytes(data)
    except Exception as error:  # whatever strange bytes make it stumble over
        raise FormatError(f"its header cannot be read: {_reason(error)}") from None
    values = _values(image)
    axes, origin, remarks = _axes(image)
    unit = _UNITS.get(_unit_name(image))
    return RawImage(values, axes, origin, unit, remarks=remarks)


def _version(data: bytes) -> int:
    """Return the version of a file, from the size of its header; refuse voxels without a size.

    The library would take those for voxels of one millimetre.
    """
    for version, size, place, kind in ((1, 348, 76, "f4"), (2, 540, 104, "f8")):
        for order in "<>":
            if len(data) < size or np.frombuffer(data, f"{order}i4", 1)[0] != size:
                continue
            steps = np.frombuffer(data, order + kind, 4, place)[1:]
            if not (np.isfinite(steps).all() and (steps > 0.0).all()):
                raise FormatError(
                    "it does not say how large its voxels are",
                    'save it with its voxel size: NIfTI calls it "pixdim"',
                )
            return version
    raise FormatError("it does not begin with the header of a NIfTI file")


def _values(image: Any) -> Any:
    shape = tuple(map(int, image.shape))
    require_size(shape, image.get_data_dtype().itemsize)
    slope, shift = float(image.dataobj.slope), float(image.dataobj.inter)
    try:
        values = image.dataobj.get_unscaled()
    except Exception as error:  # whatever strange bytes make it stumble over
        if "bytes" in str(error):
            reason = "it is truncated: some of its voxels are missing"
        else:
            reason = f"its voxels cannot be read: {_reason(error)}"
        raise FormatError(reason) from None
    if values.dtype.kind in "iuf" and (slope, shift) != (1.0, 0.0):
        values = values * np.float32(slope) + np.float32(shift)
    return three_dimensional(values, dict(enumerate(_AXES[: values.ndim - 3], 3)))


def _axes(image: Any) -> tuple[Any, Any, tuple[str, ...]]:
    header = image.header
    if int(header["sform_code"]) > 0 or int(header["qform_code"]) > 0:
        affine = np.asarray(header.get_best_affine(), float)
        return _TO_PATIENT @ affine[:3, :3], _TO_PATIENT @ affine[:3, 3], ()
    return np.diag(np.asarray(header["pixdim"][1:4], float)), np.zeros(3), (_NO_ORIENTATION,)


def _unit_name(image: Any) -> str:
    try:
        return str(image.header.get_xyzt_units()[0])
    except KeyError:  # a number that means nothing
        return ""


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
