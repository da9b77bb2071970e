"""Label images: voxels with a whole number each, 0 outside of all that is labelled.

Positions are those of DICOM: x points to the left of the patient, y to the back, z to the head
(LPS). Surfaces that 3D Slicer saves have these coordinates, too. NIfTI and some NRRD files
count to the right and to the front; the readers change the signs.
"""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.hints import alternatives
from tissuec.meshes.formats import IMAGES, FormatError

Floats: TypeAlias = NDArray[np.float64]
Labels: TypeAlias = NDArray[np.integer]

TOO_FAR = 0.05  # part of the volume that may be missing, or too much, before it is reported
_TIE = 1e-4  # of a voxel: more than the rounding of single precision in headers
INSTALL = 'install it: pip install "tissuec[images]"'


def is_image(path: Path) -> bool:
    """Return whether a name of a file is that of an image."""
    return path.name.lower().endswith(IMAGES)


class LabelImage(Struct, frozen=True, eq=False, dict=True):
    """A label image in the coordinates of the patient.

    Attributes:
        labels: Of the voxels, shape (i, j, k).
        axes: From a voxel to the next one along i, j and k [m], in columns, shape (3, 3).
        origin: Centre of the first voxel [m], shape (3,).
        names: Of the labels that occur, by ascending label.
        count: Numbers of voxels of the labels that occur.
        remarks: What is to be reported about the file.
        digest: SHA-256 digest of all files of the image.
    """

    labels: Labels
    axes: Floats
    origin: Floats
    names: Mapping[int, str]
    count: Mapping[int, int]
    remarks: tuple[str, ...]
    digest: str

    def values_of(self, part: str | None) -> tuple[int, ...]:
        """Return the label of a name, or all labels.

        Raises:
            FormatError: No label has this name.
        """
        if part is None:
            return tuple(self.names)
        found = tuple(value for value, name in self.names.items() if name == part)
        if not found:
            hint = alternatives(part, self.names.values(), what="parts")
            raise FormatError(f'"{part}" is not a part of it', hint)
        return found

    def volume(self, values: tuple[int, ...]) -> float:
        """Return the volume of the voxels of some labels [m³]."""
        voxel = abs(float(np.linalg.det(self.axes)))
        return voxel * sum(self.count[value] for value in values)

    def require_resolution(self, resolution: float) -> None:
        """Refuse a resolution that the voxels do not have.

        Args:
            resolution: [m].

        Raises:
            FormatError: It is below the size of a voxel along each axis.
        """
        sides = np.linalg.norm(self.axes, axis=0)
        if resolution < sides.min() * (1.0 - _TIE):
            size = " x ".join(units.show(float(side), units.LENGTH) for side in sides)
            raise FormatError(
                f"the resolution is below the size of its voxels, {size}, and has no effect",
                "leave it out, or write a larger one",
            )

    def extent(self, values: tuple[int, ...]) -> tuple[slice, slice, slice]:
        """Return the smallest block of voxels that contains some labels."""
        along: list[NDArray[np.bool_]] = [np.zeros(n, dtype=bool) for n in self.labels.shape]
        for k, layer in enumerate(self.labels.T):  # one after another, for the sake of memory
            inside = np.isin(layer, values)
            along[0] |= inside.any(axis=0)
            along[1] |= inside.any(axis=1)
            along[2][k] = inside.any()
        ends = [np.flatnonzero(taken)[[0, -1]].tolist() for taken in along]
        i, j, k = (slice(low, high + 1) for low, high in ends)
        return i, j, k

    def placed(self, index: Floats) -> Floats:
        """Return positions [m] of places in the image, counted in voxels, shape (place, 3)."""
        return index @ self.axes.T + self.origin

    @cached_property
    def _inverse(self) -> Floats:
        return np.linalg.inv(self.axes).astype(np.float64)

    def labels_at(self, position: Floats) -> Labels:
        """Return the labels of the voxels at positions, 0 outside of the image.

        Args:
            position: [m], shape (place, 3).
        """
        # A bit lower, so that rounding decides nothing on the face between two voxels.
        nearest = np.rint((position - self.origin) @ self._inverse.T - _TIE).astype(np.int64)
        within = ((nearest >= 0) & (nearest < self.labels.shape)).all(axis=1)
        found = np.zeros(len(position), self.labels.dtype)
        found[within] = self.labels[tuple(nearest[within].T)]
        return found
