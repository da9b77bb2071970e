"""The modes of a scene, or of one of its bodies, at 0 s."""

import numpy as np
from numpy.typing import NDArray

from tissuec.analysis.vibration.modes import Modes, modes_of
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core import arguments
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
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
