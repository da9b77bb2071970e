"""What loads and moves a net at some time, as text with numbers and places in the scene."""

from collections.abc import Iterator

import numpy as np

from tissuec.core.units import FORCE, PRESSURE, show
from tissuec.mechanics.state import State

MOST = 3  # that are named


def under(state: State) -> str:
    """Return " under …": the loads and motions of a state, or nothing without any."""
    found = list(_causes(state))
    text = " and ".join(found[:MOST])
    return f" under {text}" if found else ""


def _causes(state: State) -> Iterator[str]:
    for load in state.loads.values():
        size = float(np.linalg.norm(load.at(state.time).sum(axis=0)))
        if size > 0.0:
            yield f"a push of {show(size, FORCE)} ({load.span.place})"
    for block in state.present_blocks:
        if block.kind == "pressure" and block.span is not None:
            size = show(float(block.field.pressure(state.time)), PRESSURE)
            yield f"a pressure of {size} on {block.field.name} ({block.span.place})"
    for name, motion in state.motions.items():
        yield f"the motion of {name} ({motion.span.place})"
