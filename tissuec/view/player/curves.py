"""What a page shows over time: curves, quantities against one another, marks of events."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from tissuec.core.errors import counted
from tissuec.core.scale import AxisUnit
from tissuec.model.network import Floats, Indices
from tissuec.results.recording import AXES, TENSOR, Event, concerned
from tissuec.results.trajectory import Log, Trajectory
from tissuec.view.plots.logs import is_place
from tissuec.view.plots.quantities import PLACE, WAY, quantity, unit_of

if TYPE_CHECKING:
    from tissuec.model.network import Network

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


#: What a curve shows first, by what its name contains.
_UP, _ACROSS = ("force of ", "pressure of ", "tension of "), (WAY, "volume of ", "length of ")
_APPLIED = "applied pressure of "
_WIDENED = ("distance of ", "volume of ", "length of ", PLACE, "force of ")


class OfferedQuantity(Struct, frozen=True):
    """A quantity of a menu.

    Attributes:
        name: As ``tissuec plot --x`` takes it.
        curve: Number of its curve.
        columns: Of it: one, or the components of a magnitude; none of times.
        is_displacement: Whether the first value is taken off.
        scale: The unit in which it is shown.
        extent: From its smallest to its largest value [SI unit].
    """

    name: str
    curve: int
    columns: tuple[int, ...]
    is_displacement: bool
    scale: AxisUnit
    extent: float


def read_quantities(trajectory: Trajectory) -> list[OfferedQuantity]:
    """Return all quantities of a result, and time in front of them."""
    logs = [log for log in trajectory.logs.values() if log.columns]
    if not logs:
        return []
    longest = max(range(len(logs)), key=lambda number: len(logs[number].time))
    found = [OfferedQuantity("time", longest, (), False, trajectory.clock, 0.0)]
    for number, log in enumerate(logs):
        if len(log.time):
            for name, columns, is_displacement in _named(log):
                logged = quantity(trajectory, name)
                known = logged.value[np.isfinite(logged.value)]
                extent = float(np.ptp(known)) if len(known) else 0.0
                found.append(
                    OfferedQuantity(
                        name, number, columns, is_displacement, unit_of([logged]), extent
                    )
                )
    return found


def first_pair(quantities: Sequence[OfferedQuantity]) -> tuple[int, int]:
    """Return the numbers of what is shown first, upwards and across.

    That is a force over a way, or what a pressure widens over the pressure that is applied.
    """

    def first(starts: Sequence[str], avoided: int) -> int:
        for start in starts:
            fitting = [
                number
                for number, one in enumerate(quantities)
                if one.name.startswith(start) and number != avoided
            ]
            if fitting:  # along the axis along which most happens
                return max(fitting, key=lambda number: quantities[number].extent)
        return 0

    if any(one.name.startswith(_APPLIED) for one in quantities):
        across = first((_APPLIED,), -1)
        return first(_WIDENED, across), across
    across = first(_ACROSS, -1)
    others = (number for number in reversed(range(len(quantities))) if number != across)
    return first(_UP, across) or next(others, 0), across


def _named(log: Log) -> Iterator[tuple[str, tuple[int, ...], bool]]:
    """Yield names, columns, and whether these are displacements."""
    if len(log.columns) == 1:
        yield log.name, (0,), False
    if log.columns == TENSOR:  # normal stresses
        yield from ((f"{log.name} along {axis}", (k,), False) for k, axis in enumerate(AXES))
    if log.columns != AXES:
        return
    every = tuple(range(len(AXES)))
    if is_place(log.name):
        way = WAY + log.name.removeprefix(PLACE)
        yield from ((f"{way} along {axis}", (k,), True) for k, axis in enumerate(AXES))
        yield f"magnitude of {way}", every, True
    else:
        yield f"magnitude of {log.name}", every, False
    yield from ((f"{log.name} along {axis}", (k,), False) for k, axis in enumerate(AXES))


#: Shape of the mark -> kinds of events; kinds that are not listed get a ring.
SIGNS = {
    "cross": ("cut",),
    "bolt": ("rupture", "crush"),
    "square": ("fix", "hold", "grasp", "seize", "pinch", "close", "preserve"),
    "hollow": ("free", "release", "open", "leak"),
    "arrow": (
        "move",
        "turn",
        "push",
        "press",
        "stroke",
        "tighten",
        "inflate",
        "irrigate",
        "settle",
    ),
    "diamond": ("tie", "slip"),
    "bar": ("end", "end the run", "stop"),
    "dot": ("trigger", "note", "change"),
}
BREAKING = {"rupture": "ruptured", "crush": "crushed"}
_MOST = 200


class Mark(Struct, frozen=True):
    """A mark on the timeline.

    Attributes:
        time: [s].
        kind: One word, such as "cut".
        sign: Name of its shape.
        text: What happened, as a sentence.
    """

    time: float
    kind: str
    sign: str
    text: str


def marks(events: Iterable[Event], duration: float, network: "Network") -> list[Mark]:
    """Return marks in order; springs or elements that break nearly together are one of them.

    Args:
        events: In the order of time.
        duration: Of the run [s].
    """
    found: list[tuple[Event, int, str]] = []
    for event in events:
        many, what = concerned(event.springs, network)
        last = found[-1][0] if found else None
        if (
            last is not None
            and (last.kind, found[-1][2]) == (event.kind, what)
            and event.kind in BREAKING
            and event.time - last.time < duration / _MOST
        ):
            found[-1] = last, found[-1][1] + many, what
        else:
            found.append((event, many, what))
    return [_mark(*one) for one in found]


def _mark(event: Event, many: int, what: str) -> Mark:
    sign = next((sign for sign, kinds in SIGNS.items() if event.kind in kinds), "ring")
    text = event.cause
    if event.kind in BREAKING:
        text = f"{counted(many, what)} {BREAKING[event.kind]}"
    elif event.kind == "cut":
        text = f"{text}: {counted(many, what)}"
    return Mark(event.time, event.kind, sign, text)
