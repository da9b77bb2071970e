"""A cut over an interval: blades that close along a line."""

import numpy as np
import pytest

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SHEET = """language 1
tissue skin {{ spring constant = 100 N/m; viscosity = 0 N*s/m; mass = 1 g }}
body sheet {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (80, 0, 0) mm; second edge = (0, 40, 0) mm
    rows = 5; columns = 9; diagonals is none
  }}
  tissue is skin
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 1 s }}
output {{ trajectory every 100 ms }}
"""
LINE = "along line from (-1, 15, 0) mm to (79, 15, 0) mm facing (0, 1, 0)"


def compiled(script):
    return compile_request(Request(Source("sheet.tis", SHEET.format(script=script))))[0]


def cuts(script):
    """Return times and springs of the cuts, and x where each spring was drawn."""
    scene, memory = compiled(script), MemoryRecording()
    network = scene.network
    outcome = run(network, scene.plan, Recorder(network, scene.plan, memory))
    assert outcome.kind == "done"
    middle = network.position[network.springs.ends].mean(axis=1)[:, 0]
    found = [event for event in memory.events if event.kind == "cut"]
    return [(event.time, event.springs, middle[list(event.springs)]) for event in found]


@pytest.mark.parametrize("profile", ["", " using smooth profile"])
def test_springs_are_cut_when_the_blades_come_to_them(profile):
    found = cuts(f"from 0.2 s to 0.6 s: cut sheet {LINE}{profile}")
    times = np.array([time for time, _, _ in found])
    places = np.array([x.mean() for _, _, x in found])
    assert [len(springs) for _, springs, _ in found] == [1] * 8
    part = (places + 1e-3) / 80e-3
    u = (times - 0.2) / 0.4
    come = u if not profile else u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    assert come == pytest.approx(part, abs=1e-9)  # times are found to rounding of the profile


def test_a_cut_at_once_and_one_over_an_interval_take_the_same_springs():
    (_, at_once, _), *others = cuts(f"at 0.2 s: cut sheet {LINE}")
    assert not others
    closing = cuts(f"from 0.2 s to 0.6 s: cut sheet {LINE}")
    assert sorted(at_once) == sorted(s for _, springs, _ in closing for s in springs)


def test_what_has_moved_is_cut_at_the_end_at_the_latest():
    script = f"""from 0.1 s to 0.5 s: cut sheet {LINE}
      from 0.1 s to 0.3 s: move sheet by (6, 0, 0) mm using smooth profile"""
    found = cuts(script)
    assert sum(len(springs) for _, springs, _ in found) == 8
    assert found[-1][0] <= 0.5


def test_blades_need_something_to_close_along():
    with pytest.raises(CompileError, match="needs a line or a stroke"):
        compiled(
            "from 0 s to 1 s: cut sheet along plane through (5, 15, 0) mm facing (0, 1, 0)"
        )
