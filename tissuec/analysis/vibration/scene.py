"""The modes of a scene, or of one of its bodies, the report on them, and their motion.

Mode k plays from k-1 s to k s, however long its period is: the positions are those at rest and
A sin(2π t) times its shape. A is by definition such that the node that moves most moves by 5 %
of the size of the body that has most of the energy. Forces and tensions change linearly with
it.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.analysis.vibration.modes import Mode, Modes, modes_of
from tissuec.compiler.compile import Compiled
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core import arguments
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.core.report import Fact, FactTable, Part, Report
from tissuec.core.units import TIME, show
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import Floats, Network
from tissuec.results.fields import FIELDS, always_recorded
from tissuec.results.recording import Recording
from tissuec.results.writer import ResultWriter
from tissuec.script.measures.snapshot import Snapshot


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
    if not (chosen & state.free).any():
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


AMPLITUDE = 0.05  # of the diagonal of the body
STEPS = 24  # frames of a mode
SLIGHT = 1e-5  # of A: by this forces and tensions are differentiated


def write_modes(
    modes: Modes, compiled: Compiled, path: Path, manifest: Mapping[str, Any]
) -> Path:
    """Write modes as a result file and return its path.

    Args:
        compiled: The scene.
        path: Of the file.
        manifest: Facts about the scene.

    Raises:
        PlaceError: The file cannot be written there.
        ResultError: Writing failed later on.
    """
    network, text = compiled.network, compiled.scene.source.text
    facts = {**manifest, "method": "modes", "duration": float(len(modes))}
    recording = _recording(network, single=compiled.plan.output.single)
    groups = tuple(compiled.named_groups())
    place = compiled.plan.simulation.span.place
    with ResultWriter(path, network, recording, facts, text, groups) as writer:
        writer.topology(modes.state.alive)
        writer.holds(0.0, modes.state.holders)
        for mode in modes:
            start = mode.number - 1.0
            writer.event(start, "note", (), f"mode {mode.number}: {in_words(mode)}", place)
            for frame in _frames(modes, mode):
                writer.frames(*frame)
        return writer.close("all modes are written", finished=True, facts={"kind": "done"})


def in_words(mode: Mode) -> str:
    """Return a description of a mode, such as "12.3 Hz" or "rigid"."""
    if mode.frequency:
        return f"{mode.frequency:.4g} Hz"
    if mode.growth is not None:
        return f"unstable, grows by a factor e in {show(1.0 / mode.growth, TIME)}"
    return "rigid" if mode.kind == "rigid" else "no spring resists"


def _recording(network: Network, *, single: bool) -> Recording:
    """Return a recording with everything in frames and without logs."""
    lines = np.flatnonzero(network.shown_lines)
    nodes = np.arange(network.body_nodes)
    return Recording(nodes=nodes, lines=lines, single=single, logs=(), energies=False)


def _frames(
    modes: Modes, mode: Mode
) -> Iterator[tuple[Floats, Floats, Floats, dict[str, Floats]]]:
    """Yield times, positions, velocities and fields of frames."""
    # The last mode comes to its end, others to where the next one begins.
    count = STEPS + (mode.number == len(modes))
    state = modes.state.without_contact
    way = _amplitude(state.network, mode) * mode.shape
    before, after = (_fields(state, sign * SLIGHT * way) for sign in (-1.0, 1.0))
    here = _fields(state, 0.0 * way)
    changes = {name: (after[name] - before[name]) / (2.0 * SLIGHT) for name in here}
    for step in range(count):
        phase = 2.0 * np.pi * step / STEPS
        sine = np.sin(phase)
        yield (
            np.array([mode.number - 1.0 + step / STEPS]),
            (state.position + sine * way)[None],
            (2.0 * np.pi * np.cos(phase) * way)[None],
            {name: (here[name] + sine * changes[name])[None] for name in here},
        )


def _amplitude(network: Network, mode: Mode) -> float:
    """Return A for a shape [m kg^½]."""
    most = max(mode.shares, key=lambda name: mode.shares[name])
    body = network.body_named(most)
    size = topology.extents(network.position[body.nodes]).diagonal
    size = size or network.extent or 1.0  # a node alone has none
    return AMPLITUDE * size / float(np.sqrt((mode.shape**2).sum(axis=1).max()))


def _fields(state: State, shift: Floats) -> dict[str, Floats]:
    """Return the fields of frames beside the place of a state."""
    still = np.zeros_like(state.velocity)
    internal = state.network.internal_rows
    still[internal] = state.velocity[internal]
    none = np.zeros(state.network.entity_count, dtype=bool)
    there = Snapshot(state, state.time, state.position + shift, still, none)
    return {one.name: FIELDS[one.name].sample(there) for one in always_recorded()}
