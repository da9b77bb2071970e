"""The measurements of one experiment, in SI units, and the nodes of a fit."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.fit_problem import Data, Fit
from tissuec.script.measures import Subject


class Series(Struct, frozen=True, eq=False):
    """Measurements for one ``fit``.

    Attributes:
        times: Of the rows [s], ascending, shape (row,); on an axis without time the
            displacements [m], among which some may be equal.
        nodes: Of positions: numbers of the network, ascending, shape (node,); None of others.
        values: In SI units; NaN where nothing was measured. Of positions: shape
            (row, node, 3). Of a position, and of a force with three columns: (row, 3). Of all
            that is one number, also of lengths and of what is along something: (row,).
    """

    fit: Fit
    times: Floats
    nodes: Indices | None
    values: Floats

    @property
    def known(self) -> NDArray[np.bool_]:
        """Return which rows hold a value, shape (row,)."""
        other_axes = tuple(range(1, self.values.ndim))
        return np.asarray(~np.isnan(self.values).all(axis=other_axes))

    def at(self, rows: Indices | NDArray[np.bool_]) -> "Series":
        """Return some rows, by indices of shape (n,) or a mask of shape (row,)."""
        return replace(self, times=self.times[rows], values=self.values[rows])


class Experiment(Struct, frozen=True, eq=False):
    """One file of data.

    Attributes:
        name: Of the file.
        digest: SHA-256 of its bytes.
        series: Of each fit, in their order.
        timed: Whether there is a time; otherwise rows have displacements.
    """

    name: str
    digest: str
    series: tuple[Series, ...]
    data: Data
    timed: bool = True

    @property
    def duration(self) -> float:
        """Return the last time [s]; 0 without rows."""
        return max((float(one.times[-1]) for one in self.series if len(one.times)), default=0.0)

    def of(self, data: Data, fits: Sequence[Fit]) -> "Experiment":
        """Return the same for the sentences of another text with the same learn block.

        Args:
            data: The sentence of the file.
            fits: Of the block, in their order.
        """
        pairs = zip(self.series, fits, strict=True)
        series = tuple(replace(one, fit=fit) for one, fit in pairs)
        return replace(self, data=data, series=series)

    def split(self, last_part: float) -> "tuple[Experiment, Experiment]":
        """Return the experiment to learn from, and its end that is held out.

        Each series is parted by itself: by the time between its first and its last value, or
        by the number of rows where there is no time. A series of one value is not parted.

        Args:
            last_part: From 0, which holds out nothing, to below 1.
        """
        parts = [
            _parted(one, last_part, by_time=self.timed) if last_part > 0.0 else len(one.times)
            for one in self.series
        ]
        pairs = list(zip(self.series, parts, strict=True))
        first = tuple(one.at(np.arange(part)) for one, part in pairs)
        last = tuple(one.at(np.arange(part, len(one.times))) for one, part in pairs)
        held_out = replace(self.data, held_out=True)
        return replace(self, series=first), replace(self, series=last, data=held_out)


def _parted(one: Series, last_part: float, *, by_time: bool) -> int:
    """Return the first row that is held out, or the number of rows."""
    rows = np.flatnonzero(one.known)
    if len(rows) < 2:
        return len(one.times)
    if by_time:
        first, last = one.times[rows[0]], one.times[rows[-1]]
        cut = last - last_part * (last - first)
        held = int(np.searchsorted(one.times[rows], cut, side="right"))
    else:
        held = len(rows) - round(last_part * len(rows))
    # At least one value to learn from, and one to judge by.
    return int(rows[min(max(held, 1), len(rows) - 1)])


def nodes_of(subjects: Sequence[Subject]) -> Indices:
    """Return the nodes of all subjects, ascending, shape (node,); tools have none."""
    parts = [one.nodes for one in subjects if one.nodes is not None]
    return np.unique(np.concatenate(parts)) if parts else np.zeros(0, dtype=np.int64)


def owners(network: Network, nodes: Indices) -> list[BodyPart]:
    """Return the bodies that contain some of the nodes, given by indices of shape (n,)."""
    return [
        body
        for body in network.bodies
        if ((nodes >= body.nodes.start) & (nodes < body.nodes.stop)).any()
    ]
