"""Logs and energies as curves that are small enough for a page."""

import numpy as np
from msgspec import Struct

from tissuec.core.scale import AxisUnit
from tissuec.model.network import Floats, Indices
from tissuec.results.trajectory import Log, Trajectory

MOST_MOMENTS = 1200  # of a curve: more than a chart has columns of pixels
_MOST_COLUMNS = 60


class LogCurve(Struct, frozen=True, eq=False):
    """A logged quantity, or the energies.

    Attributes:
        name: What the scene calls it.
        scale: The unit in which its numbers are shown.
        columns: What the numbers of a row are.
        time: [s], shape (moment,).
        value: Shape (moment, column); numbers that are none stay so.
        left_out: How many further columns there are.
    """

    name: str
    scale: AxisUnit
    columns: tuple[str, ...]
    time: Floats
    value: Floats
    left_out: int = 0


def read_curves(trajectory: Trajectory) -> list[LogCurve]:
    """Return all logs of a result in the order of the scene, and the energies behind them."""
    logs = list(trajectory.logs.values())
    if trajectory.energies is not None:
        logs.append(trajectory.energies)
    return [_curve(log) for log in logs if log.columns]


def _curve(log: Log) -> LogCurve:
    columns = tuple(map(str, log.columns[:_MOST_COLUMNS]))
    time, value = log.with_jumps()
    value = value[:, :_MOST_COLUMNS]
    kept = outline(value)
    left_out = len(log.columns) - len(columns)
    return LogCurve(log.name, log.scale, columns, time[kept], value[kept], left_out)


def outline(value: Floats, most: int = MOST_MOMENTS) -> Indices:
    """Return the rows to keep so that a curve looks the same, shape (n,).

    From each interval of rows, those with the smallest or largest number of some column are
    kept.

    Args:
        value: In any unit, shape (row, column).
        most: How many rows are kept, except for extremes of further columns.
    """
    rows = len(value)
    if rows <= most:
        return np.arange(rows)
    size = -(-rows // (most // 2))
    padded = np.full((-(-rows // size) * size, value.shape[1]), np.nan)
    padded[:rows] = value
    blocks = padded.reshape(-1, size, value.shape[1])
    starts = size * np.arange(len(blocks))[:, None]
    low = np.where(np.isnan(blocks), np.inf, blocks).argmin(axis=1) + starts
    high = np.where(np.isnan(blocks), -np.inf, blocks).argmax(axis=1) + starts
    # Where a column begins or ends to be numbers, it does so in the picture too.
    edges = np.flatnonzero(np.diff(np.isnan(value).any(axis=1).astype(int)))
    kept = np.unique(
        np.concatenate([[0, rows - 1], low.ravel(), high.ravel(), edges, edges + 1])
    )
    return kept[kept < rows]
