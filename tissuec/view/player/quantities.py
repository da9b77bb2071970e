"""Quantities that the page draws against one another: those of ``tissuec plot --x --y``."""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.scale import AxisUnit
from tissuec.results.recording import AXES, TENSOR
from tissuec.results.trajectory import Log, Trajectory
from tissuec.view.plots.logs import is_place
from tissuec.view.plots.quantities import PLACE, WAY, quantity, unit_of

#: What a curve shows first, by what its name contains.
_UP, _ACROSS = ("force of ", "pressure of ", "tension of "), (WAY, "volume of ", "length of ")


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
    """Return the numbers of what is shown first, upwards and across: a force over a way."""

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
