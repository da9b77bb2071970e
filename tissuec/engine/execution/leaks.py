"""Sentences about volumes that leak: which cells are torn, and what tore them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.units import TIME, show
from tissuec.mechanics.state import State
from tissuec.model.network import Indices
from tissuec.script.verbs import LoggedEvent

if TYPE_CHECKING:  # annotations only: scenes without them load faster
    from tissuec.forces.kept_volumes import KeptVolumes

Log = Sequence[tuple[float, LoggedEvent]]

#: Kinds of events that take springs away, and how they do before and after the time.
_TEARING = {
    "cut": ("torn", " by:"),
    "rupture": ("ruptured", ", as"),
    "crush": ("crushed", ", as"),
}


def leaking(enclosure: "KeptVolumes", cells: int, state: State, log: Log) -> str:
    """Describe the leak of an enclosure, with the event that tore it.

    Args:
        enclosure: As it was before.
        cells: Number of torn cells.
        state: The present state.
        log: What has happened until now, with times [s].
    """
    torn = torn_by(enclosure.lost_walls(state.alive), state.time, log)
    if enclosure.item_count == 1:
        return f"the surface of {enclosure.name} is torn and no longer holds pressure{torn}"
    if enclosure.block.kind == "fluid":
        which = "1 cavity" if cells == 1 else f"{cells} cavities"
        return f"{which} of {enclosure.name} {'leaks' if cells == 1 else 'leak'}{torn}"
    verb, holds = ("is", "holds") if cells == 1 else ("are", "hold")
    which = counted(cells, "cell")
    return f"{which} of {enclosure.name} {verb} torn and no longer {holds} pressure{torn}"


def torn_by(springs: Indices, time: float, log: Log) -> str:
    """Name the last event that removed any of the springs: "; torn by: cut … (scene.tis:7)".

    It includes the time of the event unless that is the present one. It is empty if no event
    in the log removed one of them.

    Args:
        springs: Indices, shape (n,).
        time: The present time [s].
        log: What has happened until now, with times [s].
    """
    for when, event in reversed(log):
        if event.kind in _TEARING and np.isin(springs, list(event.springs)).any():
            at = "" if when == time else f" at {show(when, TIME, digits=6)}"
            verb, joint = _TEARING[event.kind]
            return f"; {verb}{at}{joint} {event.cause} ({event.span.place})"
    return ""
