"""Reading a result file: nothing is loaded before it is asked for."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from tissuec.core.source import Source
from tissuec.network import Floats, Indices, Network
from tissuec.results import access
from tissuec.results.arrays import RECORDING, read_network
from tissuec.results.checkpoint import Checkpoint, read_checkpoint
from tissuec.results.layout import open_result
from tissuec.results.manifest import SCENE, read_manifest
from tissuec.results.mesh import Cells
from tissuec.results.parts import read_cells
from tissuec.results.recording import Event
from tissuec.results.surface_series import Surfaces
from tissuec.results.tables import ENERGY_PATH, read_channel, read_channels, read_events


class Log:
    """A logged quantity.

    Attributes:
        name: What the scene calls it.
        columns: What the numbers of a row are: axes or ids.
        unit: Their unit.
        description: One sentence.
    """

    def __init__(self, file: h5py.File, path: str):
        channel = read_channel(file, path)
        self.name, self.columns = channel.name, channel.columns
        self.unit, self.description = channel.unit, channel.description
        self._group = access.group(file, path)

    @cached_property
    def time(self) -> Floats:
        """The moments [s], shape (moment,)."""
        return access.array(self._group, "time")

    @cached_property
    def value(self) -> Floats:
        """The rows [unit], shape (moment, column)."""
        return access.array(self._group, "value")


class Logs(Mapping[str, Log]):
    """All logs of a file by name, in the order of the scene."""

    def __init__(self, file: h5py.File):
        self._file = file
        self._paths = read_channels(file)

    def __getitem__(self, name: str) -> Log:
        return Log(self._file, self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


class Frames:
    """Vectors at the recorded nodes over time, shape (frame, node, 3), read when indexed.

    Takes the indices that NumPy takes; only the frames that the first of them chooses are read.
    """

    def __init__(self, dataset: h5py.Dataset, frames: int, nodes: int):
        self._dataset = dataset
        self.shape = (frames, nodes, 3)
        self.dtype: np.dtype = dataset.dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> NDArray:
        first, rest = (
            (index[0], index[1:]) if isinstance(index, tuple) and index else (index, ())
        )
        if first is Ellipsis or first is None or isinstance(first, tuple):
            return self._read(0, len(self))[index]
        chosen = np.arange(len(self))[first]
        frames = self._gather(chosen.reshape(-1))
        if isinstance(first, slice):
            return frames[(slice(None), *rest)]
        return frames[(np.arange(chosen.size).reshape(chosen.shape)[()], *rest)]

    def _gather(self, chosen: Indices) -> NDArray:
        """Return frames by number, read at once where they lie close together."""
        low, high = (int(chosen.min()), int(chosen.max()) + 1) if chosen.size else (0, 0)
        if high - low <= 4 * chosen.size:
            return self._read(low, high)[chosen - low]
        return np.concatenate([self._read(frame, frame + 1) for frame in chosen])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray:
        return np.asarray(self[:], dtype=dtype)

    def _read(self, low: int, high: int) -> NDArray:
        nodes = self.shape[1]
        return self._dataset[low * nodes : high * nodes].reshape(high - low, nodes, 3)


class Trajectory:
    """A result file, finished or not; use it in a ``with`` statement, or `close` it.

    Frames number the recorded nodes from 0; `nodes` and `springs` are their numbers in the
    network and `node_ids` and `spring_ids` those of the scene.

    Args:
        path: The file.

    Raises:
        ResultError: There is none, or it is truncated, or no result, or of another layout.
    """

    def __init__(self, path: Path):
        self.path = Path(path)
        self._file = open_result(self.path)

    @classmethod
    def open(cls, path: Path) -> Self:
        """Return the result file at ``path``; the errors are those of the class."""
        return cls(path)

    def close(self) -> None:
        """Close the file; what was not read yet can no longer be."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @cached_property
    def _frame_count(self) -> int:
        return int(access.attribute(access.group(self._file, "VTKHDF/Steps"), "NSteps"))

    @cached_property
    def times(self) -> Floats:
        """Times of the frames [s], shape (frame,)."""
        return access.dataset(self._file, "VTKHDF/Steps/Values")[: self._frame_count]

    @property
    def position(self) -> Frames:
        """Positions [m], shape (frame, node, 3)."""
        return self._frames("Points")

    @property
    def velocity(self) -> Frames:
        """Velocities [m/s], shape (frame, node, 3)."""
        return self._frames("PointData/velocity")

    @property
    def force(self) -> Frames:
        """Sums of the spring forces on the nodes [N], shape (frame, node, 3)."""
        return self._frames("PointData/force")

    def _frames(self, name: str) -> Frames:
        return Frames(
            access.dataset(self._file, f"VTKHDF/{name}"), self._frame_count, len(self.nodes)
        )

    def cells(self, frame: int) -> Cells:
        """Return what frame number ``frame`` draws."""
        return read_cells(self._file, self._step("PartOffsets", frame))

    def spring_force(self, frame: int) -> tuple[Floats, Indices]:
        """Return the tensions [N] in a frame, and whose they are as rows of `ends`.

        Both have shape (alive,). A frame number may count from the end, as in NumPy.
        """
        cells = self.cells(frame)
        first = self._step("CellDataOffsets/spring_force", frame)
        tension = access.dataset(self._file, "VTKHDF/CellData/spring_force")[
            first : first + cells.total
        ]
        return tension[cells.line_rows], np.searchsorted(self.springs, cells.springs)

    def _step(self, name: str, frame: int) -> int:
        count = self._frame_count
        if not -count <= frame < count:
            raise IndexError(f"frame {frame} of {count}")
        return int(access.dataset(self._file, f"VTKHDF/Steps/{name}")[frame % count])

    @cached_property
    def nodes(self) -> Indices:
        """Network numbers of the recorded nodes, ascending, shape (node,)."""
        return access.array(self._file, f"{RECORDING}/nodes")

    @cached_property
    def springs(self) -> Indices:
        """Network numbers of the recorded springs, ascending, shape (spring,)."""
        return access.array(self._file, f"{RECORDING}/springs")

    @property
    def node_ids(self) -> Indices:
        """Ids of the recorded nodes, shape (node,)."""
        return self.network.node_ids[self.nodes]

    @property
    def spring_ids(self) -> Indices:
        """Ids of the recorded springs, shape (spring,)."""
        return self.network.spring_ids[self.springs]

    @cached_property
    def ends(self) -> Indices:
        """Node pairs of the recorded springs, numbered as in the frames, shape (spring, 2)."""
        return np.searchsorted(self.nodes, self.network.ends[self.springs]).reshape(-1, 2)

    @cached_property
    def network(self) -> Network:
        """The whole network as it was before the run, without its provenance."""
        return read_network(self._file, Source(self.path.name, self.text))

    @cached_property
    def logs(self) -> Logs:
        """All logs by name."""
        return Logs(self._file)

    @cached_property
    def surfaces(self) -> Surfaces:
        """All smooth surfaces by the names of their bodies."""
        return Surfaces(self._file)

    @cached_property
    def energies(self) -> Log | None:
        """The energies over time [J]; None if they were not recorded."""
        return Log(self._file, ENERGY_PATH) if ENERGY_PATH in self._file else None

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Everything that happened, in order."""
        return read_events(self._file)

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """Where the result comes from: versions, method, digest, outcome, …"""
        return read_manifest(self._file)

    @property
    def outcome(self) -> str:
        """How the run ended, as a sentence."""
        return self.manifest["outcome"]

    @property
    def finished(self) -> bool:
        """Whether the run went to its end."""
        return self.manifest["finished"]

    def checkpoint(self) -> Checkpoint | None:
        """Return the state to resume from; None if the run never kept one."""
        return read_checkpoint(self._file)

    @cached_property
    def text(self) -> str:
        """The scene as it was run."""
        return access.text(self._file, SCENE)
