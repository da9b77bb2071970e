"""Contents of an image file, before they are known to be labels."""

from collections.abc import Mapping
from typing import Any

from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.meshes.formats import FormatError
from tissuec.meshes.formats.packed import Room
from tissuec.meshes.images import Floats


class RawImage(Struct, frozen=True, eq=False):
    """Contents of an image file.

    Attributes:
        values: Of the voxels, shape (i, j, k).
        axes: From a voxel to the next one along i, j and k in the unit of the file, one in each
            column, left, back and head being positive, shape (3, 3).
        origin: Centre of the first voxel, shape (3,).
        unit: Metres in the unit of the file; None where the file does not say.
        names: Of labels.
        remarks: What is to be reported about the file.
        more: Bytes of other files that belong to it.
    """

    values: NDArray[Any]
    axes: Floats
    origin: Floats
    unit: float | None = None
    names: Mapping[int, str] = field(default_factory=dict[int, str])
    remarks: tuple[str, ...] = ()
    more: bytes = b""


def require_size(shape: tuple[int, ...], itemsize: int) -> int:
    """Return how many bytes the voxels of an image take.

    Args:
        shape: Of the image.
        itemsize: Bytes of one voxel.

    Raises:
        FormatError: There are none, or too many.
    """
    if not shape or min(shape) < 1:
        raise FormatError(f"its size is {' x '.join(map(str, shape)) or 'missing'}")
    size = itemsize
    for length in shape:
        size *= int(length)
    return Room().take(size, "voxels")


def three_dimensional(values: NDArray[Any], others: Mapping[int, str]) -> NDArray[Any]:
    """Return an image of shape (i, j, k) without the axes that are no directions in space.

    Args:
        values: Of any unit, with all axes, shape (i, j, k, …), in any order.
        others: What those axes are along which nothing changes in space: "time step".

    Raises:
        FormatError: There are several values at one place, or there are not three directions.
    """
    for axis, what in others.items():
        if values.shape[axis] > 1:
            raise FormatError(
                f"it contains {counted(values.shape[axis], what)}, but one is needed",
                "in 3D Slicer, save the segmentation with a single layer, or one time step",
            )
    values = values.squeeze(axis=tuple(others))
    if values.ndim != 3:
        raise FormatError(f"it has {counted(values.ndim, 'direction')} in space, not 3")
    return values
