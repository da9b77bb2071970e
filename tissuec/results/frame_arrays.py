"""Arrays over the frames of a result that are read when they are indexed."""

from collections.abc import Callable
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Indices
from tissuec.results.access import Dataset, attribute, damaged
from tissuec.results.finite import all_numbers
from tissuec.results.mesh import Cells

Numbers: TypeAlias = NDArray[np.floating]  # in single or double precision


class OverFrames:
    """An array whose first axis is that of the frames, read when indexed.

    Takes the indices that NumPy takes; only the frames that the first of them chooses are read.

    Attributes:
        shape: Frames first.
        dtype: Of the numbers, as they are stored.
        unit: Their unit.
    """

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype, unit: str):
        self.shape, self.dtype, self.unit = shape, dtype, unit

    @property
    def ndim(self) -> int:
        """Return the number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Numbers:
        several = isinstance(index, tuple) and len(cast("tuple[Any, ...]", index)) > 0
        first, *rest = cast("tuple[Any, ...]", index if several else (index,))
        if first is Ellipsis or first is None or isinstance(first, tuple):
            return self._read(0, len(self))[index]
        chosen = np.arange(len(self))[first]
        frames = self._gather(chosen.reshape(-1))
        if isinstance(first, slice):
            return frames[(slice(None), *rest)]
        return frames[(np.arange(chosen.size).reshape(chosen.shape)[()], *rest)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Numbers:
        return np.asarray(self[:], dtype=dtype)

    def __repr__(self) -> str:
        size = " x ".join(map(str, self.shape))
        return f"<{size} numbers [{self.unit}], {self.dtype}, read when indexed>"

    def _gather(self, chosen: Indices) -> Numbers:
        """Return frames by number, read at once where they lie close together."""
        low, high = (int(chosen.min()), int(chosen.max()) + 1) if chosen.size else (0, 0)
        if high - low <= 4 * chosen.size:
            return self._read(low, high)[chosen - low]
        return np.concatenate([self._read(frame, frame + 1) for frame in chosen])

    def _read(self, low: int, high: int) -> Numbers:
        """Return the frames from ``low`` to before ``high``."""
        raise NotImplementedError


class Frames(OverFrames):
    """Vectors at the recorded nodes over time, shape (frame, node, 3), read when indexed."""

    def __init__(self, dataset: Dataset, frames: int, nodes: int):
        unit = attribute(dataset, "unit", str)
        super().__init__((frames, nodes, 3), dataset.dtype, unit)
        self._dataset = dataset

    def _read(self, low: int, high: int) -> Numbers:
        nodes = self.shape[1]
        rows = self._dataset.finite(low * nodes, high * nodes)
        return rows.reshape(high - low, nodes, 3)


class Tensions(OverFrames):
    """Tensions of the recorded springs [N], shape (frame, spring), read when indexed.

    They are not a number (NaN) from the frame on in which a spring is gone.

    Args:
        dataset: The numbers of all cells of each frame, one frame after the other.
        first: Where those of each frame begin, shape (frame,).
        parts: The topology of each frame, ascending, shape (frame,).
        springs: Network numbers of the recorded springs, ascending.
        cells: Gives what a frame draws.
    """

    def __init__(
        self,
        dataset: Dataset,
        first: Indices,
        parts: Indices,
        springs: Indices,
        cells: Callable[[int], Cells],
    ):
        super().__init__((len(first), len(springs)), dataset.dtype, "N")
        self._dataset, self._springs, self._cells = dataset, springs, cells
        self._first, self._parts = first, parts

    def _read(self, low: int, high: int) -> Numbers:
        tension = np.full((high - low, self.shape[1]), np.nan, dtype=self.dtype)
        while low < high:
            # As many frames as have the same springs; their numbers stand in one piece.
            stop = min(
                high, int(np.searchsorted(self._parts, int(self._parts[low]), side="right"))
            )
            cells, start = self._cells(low), int(self._first[low])
            rows = self._dataset[start : start + (stop - low) * cells.total]
            alive = np.searchsorted(self._springs, cells.springs)
            place = slice(len(tension) - (high - low), len(tension) - (high - stop))
            lines = rows.reshape(stop - low, cells.total)[:, cells.line_rows]
            if not all_numbers(lines):
                damaged(self._dataset.file, f'"{self._dataset.path}" is incomplete')
            tension[place, alive] = lines
            low = stop
        return tension
