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
    """Numbers of what is in all frames, such as nodes, over time, read when indexed.

    Args:
        dataset: The numbers, one frame after the other.
        frames: How many frames there are.
        nodes: How many rows each of them has.
        row: Shape of a row.
    """

    def __init__(self, dataset: Dataset, frames: int, nodes: int, row: tuple[int, ...] = (3,)):
        unit = attribute(dataset, "unit", str)
        super().__init__((frames, nodes, *row), dataset.dtype, unit)
        self._dataset = dataset

    def _read(self, low: int, high: int) -> Numbers:
        nodes = self.shape[1]
        rows = self._dataset.finite(low * nodes, high * nodes)
        return rows.reshape(high - low, *self.shape[1:])


class CellFrames(OverFrames):
    """Numbers of springs or triangles, shape (frame, item), read when indexed.

    They are not a number (NaN) from the frame on in which a spring or triangle is gone.

    Args:
        dataset: The numbers of all cells of each frame, one frame after the other.
        first: Where those of each frame begin, shape (frame,).
        parts: The topology of each frame, ascending, shape (frame,).
        items: How many springs or triangles are recorded.
        cells: Gives what a frame draws.
        drawn: From that to the rows of the cells, and which of the items these are.
    """

    def __init__(
        self,
        dataset: Dataset,
        first: Indices,
        parts: Indices,
        items: int,
        cells: Callable[[int], Cells],
        drawn: Callable[[Cells], tuple[slice, Indices]],
    ):
        unit = attribute(dataset, "unit", str)
        super().__init__((len(first), items), dataset.dtype, unit)
        self._dataset, self._cells, self._drawn = dataset, cells, drawn
        self._first, self._parts = first, parts

    def shown(self, frame: int) -> tuple[Numbers, Indices]:
        """Return the numbers of what a frame shows, and whose they are, shape (shown,) each.

        Args:
            frame: Its number, which may count from the end.
        """
        rows, items = self._drawn(self._cells(frame))
        first = int(self._first[frame])
        return self._dataset.finite(first + rows.start, first + rows.stop), items

    def _read(self, low: int, high: int) -> Numbers:
        found = np.full((high - low, self.shape[1]), np.nan, dtype=self.dtype)
        while low < high:
            # As many frames as have the same cells; their numbers are contiguous.
            stop = min(
                high, int(np.searchsorted(self._parts, int(self._parts[low]), side="right"))
            )
            cells, start = self._cells(low), int(self._first[low])
            rows = self._dataset[start : start + (stop - low) * cells.total]
            own, there = self._drawn(cells)
            place = slice(len(found) - (high - low), len(found) - (high - stop))
            numbers = rows.reshape(stop - low, cells.total)[:, own]
            if not all_numbers(numbers):
                damaged(self._dataset.file, f'"{self._dataset.path}" is incomplete')
            found[place, there] = numbers
            low = stop
        return found
