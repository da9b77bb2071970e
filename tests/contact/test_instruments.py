"""What every kind of tool keeps to, by one sample of its entries."""

import numpy as np
import pytest

from tests.contact.scenes import contact_of, play
from tests.validate.scenes import compiled_scene
from tissuec.mechanics.state import State
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.tools import TOOLS

#: A sample of each kind; ``SHAPED`` touch the block, from (0, 0, 0) to (20, 20, 10) mm.
SAMPLES = {
    "probe": "kind is probe; radius = 4 mm; axis from (0, 9, 13) mm to (20, 11, 13.5) mm",
    "hook": "kind is hook; radius = 2 mm; shaft from (10, 10, 40) mm to (10, 10, 11.5) mm"
    "; bend = (16, 10, 11) mm; tip = (18, 10, 13) mm",
    "plane": "kind is plane; point = (0, 0, 9.5) mm; normal = (0.1, 0, -1)",
    "forceps": "kind is forceps; radius = 2 mm"
    "; upper from (-5, 10, 11.5) mm to (9, 10, 11.5) mm"
    "; lower from (-5, 10, -1.5) mm to (9, 10, -1.5) mm",
    "scissors": "kind is scissors",
    "clamp": "kind is clamp; shaft = (1, 0, 1)",
    "needle": "kind is needle; size = 3 mm",
    "scalpel": "kind is scalpel; edge from (5, -5, 20) mm to (5, 25, 20) mm",
    "nozzle": "kind is nozzle; diameter = 2 mm; tip = (9, 9, 20) mm; direction = (0, 0, -1)",
}
NO_CONTACT = ("scissors", "clamp", "needle", "nozzle", "scalpel")
SHAPED = [name for name in SAMPLES if name not in NO_CONTACT]
SCENE = """language 1
tissue flesh {{ spring constant = 200 N/m; viscosity = 0.2 N*s/m; mass = 0.2 g }}
body block {{
  mesh is lattice {{ kind is sodium chloride; cell = 10 mm; reach is second neighbours
    box from (0, 0, 0) mm to (20, 20, 10) mm }}
  tissue is flesh
}}
tool thing {{ {entries} }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; contact layer = 1 mm }}
script {{
  from 0 s to 10 ms: move thing by (0.2, 0.1, -0.5) mm using smooth profile
  from 0 s to 10 ms: turn thing by 3 deg around (0, 1, 1) using smooth profile
}}
simulate {{ duration = 12 ms; tolerance = 1e-6 }}
output {{ trajectory every 1 ms; force of thing every 0.1 ms; energy every 1 ms }}
"""


def text(name):
    return SCENE.format(entries=SAMPLES[name])


def test_there_is_a_sample_of_every_kind():
    assert set(SAMPLES) == set(TOOLS)


@pytest.mark.parametrize("name", SHAPED)
def test_the_tool_touches_and_all_its_forces_are_answered(name):
    compiled = compiled_scene(text(name))
    network, total = compiled.network, np.zeros_like(compiled.network.position)
    contact_of(compiled).add_forces(0.0, network.position, np.zeros_like(total), total)
    (tool,) = network.tools
    assert np.abs(total[tool.nodes]).max() > 1e-3
    assert np.abs(total.sum(axis=0)).max() < 1e-14 * np.abs(total).sum()
    moments = np.cross(network.position, total)
    assert np.abs(moments.sum(axis=0)).max() < 1e-14 * np.abs(moments).sum()
    # What twists the tool is what its pressure does to the block about the same point.
    start = State.start(network, gravity=np.zeros(3), drag=0.0)
    block, about = slice(network.body_nodes), network.position[tool.nodes].mean(axis=0)
    expected = np.cross(network.position[block] - about, total[block]).sum(axis=0)
    thing = Subject("thing", np.arange(tool.nodes.start, tool.nodes.stop), np.zeros(0, int))
    twist = MEASURES["torque"].sample((thing,), Snapshot.of(start))
    assert twist == pytest.approx(expected, abs=1e-14 * np.abs(moments).sum())


@pytest.mark.parametrize("name", SHAPED)
def test_the_tool_moves_as_a_whole_and_its_work_is_accounted_for(name):
    played = play(text(name))
    (tool,) = played.compiled.network.tools
    place = played.position[:, tool.nodes]
    apart = np.linalg.norm(place[:, :, None] - place[:, None], axis=3)
    # Rigid to rounding, whatever it turns about.
    assert np.abs(apart - apart[0]).max() < 1e-14
    assert np.abs(place[-1] - place[0]).max() > 3e-4
    _, force = played.log("force of thing")
    steps = np.linalg.norm(np.diff(force, axis=0), axis=1)
    assert steps.max() < 0.2 * np.linalg.norm(force, axis=1).max()
    _, e = played.energies()
    stored = e["kinetic"] + e["elastic"]
    gap = stored - stored[0] - (e["work"] - e["dissipated"])
    assert np.abs(gap).max() < 1e-5 * stored.max()


def test_usual_names_of_instruments_lead_to_kinds():
    from tissuec.script.tools import KINDS_OF

    assert not KINDS_OF.keys() & set(TOOLS)
    assert {kind for kinds in KINDS_OF.values() for kind in kinds} <= set(TOOLS)
