"""The modes of a scene, or of one of its bodies, at 0 s, and the report on them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.analysis.vibration.frames import in_words
from tissuec.analysis.vibration.modes import Mode, Modes, modes_of
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core import arguments
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.report import Fact, FactTable, Part, Report
from tissuec.core.units import TIME, show
from tissuec.model.network import Network


def scene_modes(
    compiled: Compiled,
    *,
    body: str | None = None,
    count: int = 10,
    above: float | None = None,
) -> Modes:
    """Return the lowest modes of a scene after the events of the script at 0 s.

    Args:
        compiled: The scene.
        body: The only body that moves; all other nodes are held.
        count: Number of modes, if there are as many.
        above: Leave out the modes at and below this frequency [Hz].

    Raises:
        SimulationError: An event at 0 s ends the run, or the modes could not be computed.
        TissueError: There is no such body, or nothing can move.
    """
    chosen = _nodes(compiled.network, body)
    state = state_at_start(compiled, settles=True)
    state.place_held()
    if not (chosen & ~state.held).any():
        what = "the scene" if body is None else f'"{body}"'
        raise TissueError(f"no node of {what} can move: all nodes are held at 0 s")
    return modes_of(state, chosen, count=count, above=above)


def _nodes(network: Network, body: str | None) -> NDArray[np.bool_]:
    """Return which nodes may move, shape (node,); those of all bodies without a name."""
    parts = {key_of(part.name): part for part in network.bodies}
    if body is not None and key_of(arguments.text(body, "body")) not in parts:
        names = [part.name for part in network.bodies]
        hint = alternatives(body, names, what="bodies")
        raise TissueError(f'there is no body "{body}"; {hint}')
    chosen = np.zeros(network.node_count, dtype=bool)
    for part in parts.values() if body is None else [parts[key_of(body)]]:
        chosen[part.nodes] = True
    return chosen


HEAD = ("mode", "frequency", "period", "damping ratio", "kinetic energy")


def modes_report(modes: Modes, file: Path | None = None) -> Report:
    """Return the report on modes.

    Args:
        modes: The modes.
        file: The result file that shows them, if one was written.
    """
    parts: list[Part] = [FactTable(HEAD, [*map(_row, modes)], least=(6, 12, 10, 15))]
    parts += [Fact("note", note, "remark") for note in modes.notes]
    if file is not None:
        parts.append(Fact("", f"wrote {file}", "remark"))
    return Report(parts, {**as_dict(modes), "file": file})


def _row(mode: Mode) -> tuple[str, ...]:
    # Rounding leaves next to nothing of what is not damped.
    ratio = "" if mode.damping_ratio is None else f"{round(mode.damping_ratio, 12):.3g}"
    period = "" if mode.period is None else show(mode.period, TIME)
    return str(mode.number), in_words(mode), period, ratio, _shares(mode.shares)


def _shares(shares: Mapping[str, float]) -> str:
    """Return the bodies with a per cent of the energy or more, the largest share first."""
    ranked = sorted(shares.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in ranked if share >= 0.005)


def as_dict(modes: Modes) -> dict[str, Any]:
    """Return modes as plain data in SI units, without their shapes."""
    return {
        "free_nodes": modes.free_nodes,
        "modes": [
            {
                "mode": mode.number,
                "kind": mode.kind,
                "frequency": mode.frequency,
                "period": mode.period,
                "growth": mode.growth,
                "damping_ratio": mode.damping_ratio,
                "shares": dict(mode.shares),
            }
            for mode in modes
        ],
        "notes": list(modes.notes),
    }
