"""Bodies whose volume is preserved, squeezed to half their height between planes."""

import pytest

from tissuec.core.source import Source
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

BALL = """body thing {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 8 mm; subdivisions = 2; interior is none }
  tissue is rubber; bending is medium }"""
BLOCK = """body thing {
  mesh is lattice { kind is sodium chloride; cell = 4 mm; reach is second neighbours
    box from (-8, -8, -8) mm to (8, 8, 8) mm }
  tissue is rubber }"""
SCENE = """language 1
tissue rubber {{ spring constant = 20 N/m; viscosity = 20 mN*s/m; mass = 0.1 g }}
{body}
tool top {{ kind is plane; point = (0, 0, 8.01) mm; normal = (0, 0, -1) }}
tool bottom {{ kind is plane; point = (0, 0, -8.01) mm; normal = (0, 0, 1) }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; damping = 1 mN*s/m
  contact stiffness = 10 N/mm }}
script {{
  at 0 s: preserve volume of thing with {firmness}
  from 0 s to 0.2 s: {{
    move top by (0, 0, -4) mm using smooth profile
    move bottom by (0, 0, 4) mm using smooth profile
  }}
}}
simulate {{ duration = 0.25 s; tolerance = 1e-3 }}
output {{ volume of thing every 5 ms; energy every 5 ms; force of top every 5 ms }}
expect volume(thing) between 0.999 * volume(thing, 0 s) and 1.001 * volume(thing, 0 s) over run
expect energy drift < 0.1 % from 20 ms to 250 ms  # before, there is only rounding
"""


@pytest.mark.parametrize(("body", "firmness"), [(BALL, "2 MPa"), (BLOCK, "20 MPa")])
def test_squeezed_to_half_its_height_a_body_keeps_its_volume_and_the_ledger_closes(
    body, firmness
):
    text = SCENE.format(body=body, firmness=firmness)
    compiled, warnings = compile_request(Request(Source("squeeze.tis", text)))
    assert not warnings
    memory, network = MemoryRecording(), compiled.network
    outcome = run(network, compiled.plan, Recorder(network, compiled.plan, memory))
    assert outcome.kind == "done" and not outcome.failures
    place = outcome.state.position[: network.body_nodes, 2]
    # Planes 8.02 mm apart; what presses through is at most a layer, a tenth of a spring.
    assert place.max() - place.min() < 9e-3
