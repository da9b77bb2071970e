"""Forceps with jaws: how hard they press, and what they hold by friction."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tissuec.core.source import Source
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

GRIP = "grip of clamp"
STRUT = """language 1
tissue strut {{ spring constant = 100 N/m; viscosity = 2 N*s/m; mass = 1 g }}
body bar {{ mesh is explicit; tissue is strut }}
table nodes of bar in mm with columns "id x y z" {{
1 0 0 -5
2 0 0 5
}}
table springs of bar with columns "id a b" {{
1 1 2
}}
tool clamp {{ kind is forceps; radius = 2 mm
  upper from (0, -5, 8) mm to (0, 5, 8) mm; lower from (0, -5, -8) mm to (0, 5, -8) mm }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; damping = 0.05 N*s/m
  friction = {friction}; contact stiffness = 1 N/mm; contact layer = 0.1 mm }}
script {{ {script} }}
simulate {{ duration = {duration}; tolerance = 1e-6 }}
output {{ {output} }}
"""


def logged(script, *, duration="2 s", friction=0.0, output="grip of clamp every 10 ms"):
    """Return time and values of each log of a strut between jaws."""
    text = STRUT.format(script=script, duration=duration, friction=friction, output=output)
    compiled, _ = compile_request(Request(Source("strut.tis", text)))
    memory = MemoryRecording()
    outcome = run(
        compiled.network,
        compiled.plan,
        Recorder(compiled.network, compiled.plan, memory),
    )
    assert outcome.kind == "done"
    return memory, outcome


def test_jaws_press_as_the_strut_between_them_and_both_contacts_allow():
    closing = "from 0 s to 0.2 s: close clamp by 4 mm using smooth profile"
    memory, _ = logged(closing, duration="0.5 s")
    # Jaws 16 mm apart, 12 mm between their surfaces, then 8 mm: the strut of 10 mm and two
    # contacts, N = k (δ - w/2) beyond the layer, take up 2 mm together.
    stiffness, layer, strut = 1e3, 1e-4, 100.0
    force = brentq(lambda n: n / strut + 2.0 * (n / stiffness + layer / 2.0) - 2e-3, 0.0, 1.0)
    last = memory.log_arrays(GRIP)[1][-1, 0]
    assert last == pytest.approx(force, rel=1e-6)


def test_jaws_that_open_again_press_on_nothing():
    both = """from 0 s to 0.2 s: close clamp by 4 mm using smooth profile
      from 0.3 s to 0.5 s: open clamp by 4 mm using smooth profile"""
    memory, _ = logged(both, duration="0.7 s")
    assert memory.log_arrays(GRIP)[1][-1, 0] == 0.0
    assert memory.log_arrays(GRIP)[1][:, 0].max() > 0.1


@pytest.mark.parametrize(("way", "told"), [(12, []), (14, ["2 mm"])])
def test_jaws_that_would_pass_through_each_other_say_so(way, told):
    closing = f"from 0 s to 0.2 s: close clamp by {way} mm using smooth profile"
    # Without the strut: its nodes stand beside the jaws, which are 12 mm apart.
    memory, _ = logged(f"at 0 s: change velocity of bar to (9, 0, 0) m/s; {closing}")
    notes = [event.cause for event in memory.events if event.kind == "note"]
    assert [cause.rpartition("by ")[2] for cause in notes] == told


def test_what_jaws_hold_follows_them_and_slips_where_friction_ends():
    pulled = """from 0 s to 50 ms: close clamp by 4 mm using smooth profile
      from 100 ms to 250 ms: move clamp by (0, 4, 0) mm using smooth profile"""
    moved, outcome = logged(pulled, duration="0.3 s", friction=0.5)
    nodes = outcome.state.position[:2]
    # Drag alone pulls back, and ends with the motion: nothing may slip.
    assert np.abs(nodes[:, 1] - 4e-3).max() < 0.05 * 4e-3
    held = pulled.split("\n")[0] + "\n      at 100 ms: push bar with (0, {}, 0) N"
    grip = moved.log_arrays(GRIP)[1][9, 0]
    for share, slips, duration in ((0.8, False, "0.2 s"), (1.2, True, "0.12 s")):
        load = share * 2.0 * 0.5 * grip  # shared by both nodes
        _, outcome = logged(held.format(f"{load:.9f}"), duration=duration, friction=0.5)
        speed = np.abs(outcome.state.velocity[:2, 1]).max()
        assert (speed > 1e-3) == slips
