"""Modes in motion: a result file that plays one period of each after another.

Mode k plays from k-1 s to k s, however long its period is: the positions are those at rest and
A sin(2π t) times its shape. A is by definition such that the node that moves most moves by 5 %
of the size of the body that has most of the energy. Forces and tensions change linearly with
it.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.analysis.vibration.modes import Mode, Modes
from tissuec.compiler.compile import Compiled
from tissuec.core.units import TIME, show
from tissuec.mechanics.state import State
from tissuec.model import topology
from tissuec.model.network import Floats, Network
from tissuec.results.fields import FIELDS, always_recorded
from tissuec.results.recording import Recording
from tissuec.results.writer import ResultWriter
from tissuec.script.measures.snapshot import Snapshot

AMPLITUDE = 0.05  # of the diagonal of the body
STEPS = 24  # frames of a mode
SLIGHT = 1e-5  # of A: by this forces and tensions are differentiated


def write_modes(
    modes: Modes, compiled: Compiled, path: Path, manifest: Mapping[str, Any]
) -> Path:
    """Write modes as a result file and return its path.

    Args:
        modes: The modes.
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
    springs = np.flatnonzero(network.shown_springs)
    nodes = np.arange(network.body_nodes)
    return Recording(nodes=nodes, springs=springs, single=single, logs=(), energies=False)


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
    body = next(body for body in network.bodies if body.name == most)
    size = topology.extents(network.position[body.nodes]).diagonal
    size = size or network.extent or 1.0  # a node alone has none
    return AMPLITUDE * size / float(np.sqrt((mode.shape**2).sum(axis=1).max()))


def _fields(state: State, shift: Floats) -> dict[str, Floats]:
    """Return the fields of frames beside the place of a state."""
    still = np.zeros_like(state.velocity)
    memory = state.network.memory
    still[memory] = state.velocity[memory]
    none = np.zeros(state.network.spring_count, dtype=bool)
    there = Snapshot(state, state.time, state.position + shift, still, none)
    return {one.name: FIELDS[one.name].sample(there) for one in always_recorded()}
