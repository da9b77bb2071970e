"""A recording in memory, for use from Python without a result file."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import Event, EventSide


class RecordedRows(Struct, frozen=True, eq=False):
    """What a recording holds: batches of rows by table, events, and which springs exist."""

    tables: Mapping[str, tuple[tuple[NDArray[Any], ...], ...]] = {}
    events: tuple[Event, ...] = ()
    alive: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))


class MemoryRecording:
    """Stores the output of a recorder as arrays.

    Attributes:
        events: Everything that happened, in order.
        state: The last checkpoint; None before the first.
    """

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.state: Mapping[str, Any] | None = None
        self._rows: dict[str, list[tuple[NDArray[Any], ...]]] = {}
        self._alive: NDArray[np.bool_] = np.zeros(0, dtype=bool)

    def topology(self, alive: NDArray[np.bool_], cut_cells: CutCells | None = None) -> None:
        """Set which springs exist in the frames to come, shape (spring,)."""
        self._alive = alive.copy()

    def holds(self, time: float, holders: Mapping[str, Indices]) -> None:
        """Ignore which nodes are held, ``holders`` of shape (n,): only files record it."""

    def frames(
        self, time: Floats, position: Floats, velocity: Floats, fields: Mapping[str, Floats]
    ) -> None:
        alive = np.broadcast_to(self._alive, (len(time), len(self._alive)))
        self._add("frames", time, position, velocity, *fields.values(), alive)

    def awaits_sides(self, time: float, apart: float) -> bool:
        """Return False: both sides of an event at ``time`` [s] are not needed."""
        return False

    def sides(self, before: EventSide, after: EventSide) -> None:
        """Ignore the net on both sides of an event: only files record it."""

    def surface(self, body: str, time: Floats, position: Floats) -> None:
        """Ignore smooth surfaces: only files record them.

        Args:
            body: Name of the body.
            time: Times [s], shape (frame,).
            position: Of all nodes [m], shape (frame, node, 3).
        """

    def log(self, channel: str, time: Floats, rows: Floats) -> None:
        self._add(f"log {channel}", time, rows)

    def log_jump(self, channel: str, time: float, before: Floats, after: Floats) -> None:
        self._add(f"jumps of {channel}", np.array([time]), before[None], after[None])

    def energies(self, time: Floats, rows: Floats) -> None:
        self._add("energies", time, rows)

    def energy_jump(self, time: float, before: Floats, after: Floats) -> None:
        self._add("jumps of energies", np.array([time]), before[None], after[None])

    def errors(self, time: Floats, rows: Floats) -> None:
        self._add("errors", time, rows)

    def event(
        self, time: float, kind: str, springs: tuple[int, ...], cause: str, place: str
    ) -> None:
        self.events.append(Event(time, kind, springs, cause, place))

    def checkpoint(self, saved: Mapping[str, Any]) -> None:
        """Keep a checkpoint in place of the previous one."""
        self.state = dict(saved)

    def rows(self) -> RecordedRows:
        """Return the records so far."""
        tables = {name: tuple(batches) for name, batches in self._rows.items()}
        return RecordedRows(tables, tuple(self.events), self._alive)

    def bring_back(self, rows: RecordedRows) -> None:
        """Hold what was recorded at some time, and nothing else."""
        self._rows = {name: list(batches) for name, batches in rows.tables.items()}
        self.events, self._alive = list(rows.events), rows.alive

    def frame_arrays(self) -> tuple[NDArray[Any], ...]:
        """Return time [s], position [m], velocity [m/s], force [N], tension [N] and alive.

        The shapes are (frame,), (frame, node, 3) three times, and (frame, spring) twice. The
        fields that a scene requests follow the tension.
        """
        return self._joined("frames")

    def log_arrays(self, channel: str) -> tuple[Floats, Floats]:
        """Return times [s], shape (row,), and rows of a log, shape (row, column)."""
        time, rows = self._joined(f"log {channel}")
        return time, rows

    def energy_arrays(self) -> tuple[Floats, Floats]:
        """Return times [s], shape (row,), and energies [J] as in a result file, (row, 6)."""
        time, rows = self._joined("energies")
        return time, rows

    def jump_arrays(self, channel: str) -> tuple[Floats, Floats, Floats]:
        """Return times of jumps [s], shape (jump,), and the rows on both sides, (jump, column).

        Args:
            channel: A log, or "energies".
        """
        time, before, after = self._joined(f"jumps of {channel}")
        return time, before, after

    def _add(self, table: str, *columns: NDArray[Any]) -> None:
        self._rows.setdefault(table, []).append(tuple(np.array(c) for c in columns))

    def _joined(self, table: str) -> tuple[NDArray[Any], ...]:
        """Return the columns of a table.

        Raises:
            KeyError: Nothing was recorded under that name.
        """
        parts = self._rows[table]
        return tuple(np.concatenate(column) for column in zip(*parts, strict=True))
