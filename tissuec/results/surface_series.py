"""Reading a smooth surface from a result file."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import h5py
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.hdf5 import copy_to
from tissuec.results.surface_table import read_surfaces, read_triangles


class SurfaceSeries:
    """A smooth surface over time.

    Attributes:
        name: The body.
        kind: How it is drawn, such as "loop subdivision".
        entries: What the scene says about it, or leaves to the kind: subdivisions, …
        path: Its group in the file.
    """

    def __init__(self, file: ResultGroup, path: str):
        channel = read_surfaces(file)[path]
        self.name, self.kind = channel.body, channel.kind
        self.entries, self.path = channel.entries, path
        self._file = file
        self._steps: dict[str, Indices] = {}

    @cached_property
    def times(self) -> Floats:
        """Times of the frames [s], shape (frame,)."""
        steps = access.group(self._file, f"{self.path}/Steps")
        return access.array(steps, "Values")[: access.attribute(steps, "NSteps", int)]

    @cached_property
    def parts(self) -> Indices:
        """Number of the topology of each frame, shape (frame,); it only ascends."""
        return access.array(self._file, f"{self.path}/Steps/PartOffsets")[: len(self)]

    def __len__(self) -> int:
        return len(self.times)

    def position(self, frame: int) -> NDArray[Any]:
        """Return the points in a frame [m], shape (point, 3)."""
        first, part = self._step("PointOffsets", frame), self._step("PartOffsets", frame)
        count = int(access.array(self._file, f"{self.path}/NumberOfPoints")[part])
        return access.dataset(self._file, f"{self.path}/Points").finite(first, first + count)

    def triangles(self, frame: int) -> Indices:
        """Return the triangles in a frame, as its points, shape (triangle, 3)."""
        return read_triangles(self._file, self.path, self._step("PartOffsets", frame))

    def copy_to(self, file: h5py.File, name: str) -> None:
        """Copy all frames into another file."""
        with access.reading(self._file.file, self.path):
            copy_to(self._file.raw, self.path, file, name)

    def _step(self, name: str, frame: int) -> int:
        if not -len(self) <= frame < len(self):
            raise IndexError(f"frame {frame} of {len(self)}")
        if name not in self._steps:
            self._steps[name] = access.array(self._file, f"{self.path}/Steps/{name}")
        return int(self._steps[name][frame % len(self)])


class Surfaces(Mapping[str, SurfaceSeries]):
    """All smooth surfaces of a file by the names of their bodies, in the order of the scene."""

    def __init__(self, file: ResultGroup):
        self._file = file
        self._paths = {channel.body: path for path, channel in read_surfaces(file).items()}

    def __getitem__(self, name: str) -> SurfaceSeries:
        return SurfaceSeries(self._file, self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)
