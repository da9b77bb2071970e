"""Scenes of one spring that remembers, written as a user would, and what came out."""

import numpy as np
from msgspec import Struct

from tests.validate.scenes import compiled_scene
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run

SCENE = """language 1
tissue gum {{ spring constant = 100 N/m; viscosity = {viscosity}; mass = 10 g; {memory} }}
body rod {{ mesh is explicit; tissue is gum{body} }}
table nodes of rod in mm with columns "id x" {{ 1 0; 2 {length} }}
table springs of rod in mm with columns "a b rest length" {{ 1 2 20 }}
set wall = nodes of rod in [1]
set bob = nodes of rod in [2]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix wall; {script} }}
simulate {{ duration = {duration}; {method} }}
output {{ trajectory every {every}; energy every {every}; tension of rod every {every}
          plastic elongation of rod every {every} }}
"""
STANDARD = "relaxing constant = 300 N/m; relaxation time = 20 ms"
PLASTIC = "yield force = 0.2 N; yield viscosity = 5 N*s/m"


def rod(
    *,
    memory=STANDARD,
    script="",
    duration="0.1 s",
    every="5 ms",
    viscosity="0 N*s/m",
    length=20,
    method="tolerance = 1e-10",
    body="",
):
    """Return the text of a spring of 20 mm between a wall and a mass of 10 g."""
    return SCENE.format(
        memory=memory, script=script, duration=duration, every=every, viscosity=viscosity,
        length=length, method=method, body=body,
    )  # fmt: skip


class Ran(Struct, frozen=True):
    """What a run recorded: times [s], extension [m], force [N] and energies [J]."""

    time: np.ndarray
    extension: np.ndarray
    tension: np.ndarray
    flow: np.ndarray
    energies: np.ndarray  # kinetic, elastic, gravity, work, dissipated, switched
    outcome: object

    @property
    def imbalance(self):
        """Return the energy that came or went for no reason [J], shape (row,)."""
        kinetic, elastic, gravity, work, lost, switched = self.energies.T
        held = kinetic + elastic + gravity
        return held - held[0] - (work - lost + switched - switched[0])

    @property
    def lost(self):
        """Return the dissipated energy [J], shape (row,)."""
        return self.energies[:, 4]


def ran(text, *, balance=1e-8, **more):
    """Return the run of a rod, whose energy balance may be open by that part."""
    compiled = compiled_scene(text)
    recording = MemoryRecording()
    network, plan = compiled.network, compiled.plan
    outcome = run(network, plan, Recorder(network, plan, recording), **more)
    assert outcome.kind == "done", outcome.message
    time, position, _, _, _, _ = recording.frame_arrays()
    extension = np.linalg.norm(position[:, 1] - position[:, 0], axis=1) - 0.02
    found = Ran(
        time,
        extension,
        recording.log_arrays("tension of rod")[1][:, 0],
        recording.log_arrays("plastic elongation of rod")[1][:, 0],
        recording.energy_arrays()[1],
        outcome,
    )
    size = np.abs(found.energies).max()
    assert np.abs(found.imbalance).max() <= balance * size, "what is lost is booked"
    return found
