"""Whole runs of implicit methods with elements, hinges and what relaxes."""

import numpy as np
import pytest

from tests.engine.running import set_pace
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out, same_when_resumed

SOLID = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3; {memory}
}}
body bar {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (15, 5, 5) mm }}
  tissue is gel
}}
set root = nodes of bar where x < 0.1 mm
set tip = nodes of bar where x > 14.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix root
  from 0 s to 20 ms: push tip with (0, 0, 3) mN using sine of 20 Hz
}}
simulate {{ duration = 20 ms; {method} }}
output {{ trajectory every 1 ms; energy every 1 ms; force of root every 1 ms }}
"""
DAMPED = "retardation time = 3 ms"
RELAXING = f"{DAMPED}; relaxing share = 40 %; relaxation time = 5 ms"
#: A wall of springs and hinges that creeps, with a calcified part.
PLAQUE = """language 1
tissue wall { Young's modulus = 500 kPa; density = 1100 kg/m^3; retardation time = 2 ms }
tissue plaque like wall { Young's modulus = 300 MPa }
body artery {
  mesh is tube { axis from (0, 0, 0) mm to (10, 0, 0) mm; radius = 3 mm; rings = 6; sides = 8
    MORE
  }
  tissue is wall; thickness = 0.8 mm
  region lime where x between 3 mm and 7 mm and z > 1 mm { tissue is plaque }
  REST
}
set ends = nodes of artery where x < 0.1 mm or x > 9.9 mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz }
script {
  at 0 s: fix ends
  from 0 s to 20 ms: push artery with 1 mN along (0, 0, 1) using ramp
}
simulate { duration = 20 ms; tolerance = 1e-3 }
output { trajectory every 10 ms }
"""
OF_SPRINGS = "bending is elastic; made of springs; interface is softer"


def scene(method, memory=DAMPED):
    return compiled_scene(SOLID.format(method=method, memory=memory))


def ends(method, memory=DAMPED):
    outcome, _ = carried_out(scene(method, memory))
    assert outcome.kind == "done"
    return outcome


@pytest.mark.parametrize("memory", ["", DAMPED, RELAXING])
@pytest.mark.parametrize(("method", "order", "counts"), [
    ("esdirk43", 4, (40, 80)), ("trbdf2", 2, (80, 160)),
])  # fmt: skip
def test_orders_are_those_of_nets(method, order, counts, memory):
    exact = ends("integrator is dop853; tolerance = 1e-11", memory).state.position
    errors = [
        np.abs(ends(f"integrator is {method}; step = {20 / count} ms", memory).state.position
               - exact).max()
        for count in counts
    ]  # fmt: skip
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("method", ["esdirk43", "trbdf2"])
def test_solids_keep_the_tolerance(method):
    exact = ends("integrator is dop853; tolerance = 1e-10", RELAXING).state.position
    outcome = ends(f"integrator is {method}; tolerance = 1e-4", RELAXING)
    moved = np.abs(exact - outcome.state.network.position).max()
    assert np.abs(outcome.state.position - exact).max() < 1e-4 * moved


def test_a_run_that_is_resumed_gives_the_same_bytes(monkeypatch):
    set_pace(monkeypatch, "compiled", 10_000)
    compiled = scene("integrator is esdirk43; tolerance = 1e-8", RELAXING)
    _, (first, _) = same_when_resumed(compiled, "force of root", 3)
    assert 0.0 < first.state.time < 0.02


@pytest.mark.parametrize(
    ("mesh", "rest"), [("diagonals is both", OF_SPRINGS), ("", "made of elements")]
)
def test_a_plaque_in_a_soft_wall_takes_few_steps_by_our_own_choice(mesh, rest):
    text = PLAQUE.replace("MORE", mesh).replace("REST", rest)
    outcome, _ = carried_out(compiled_scene(text))
    statistics = outcome.statistics
    assert statistics.method == "esdirk43"
    assert any("the fastest motion is overdamped" in each.reason for each in statistics.changes)
    assert statistics.accepted < 120
    finer = text.replace("tolerance = 1e-3", "tolerance = 1e-6; integrator is esdirk43")
    exact = carried_out(compiled_scene(finer))[0].state.position
    moved = np.abs(exact - outcome.state.network.position).max()
    assert np.abs(outcome.state.position - exact).max() < 1e-3 * moved
