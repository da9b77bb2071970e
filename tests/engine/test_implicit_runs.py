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
#: A wall that creeps, with a calcified part.
PLAQUE = """language 1
tissue wall { Young's modulus = 500 kPa; density = 1100 kg/m^3; retardation time = 2 ms }
tissue plaque like wall { Young's modulus = 300 MPa }
body artery {
  mesh is tube { axis from (0, 0, 0) mm to (10, 0, 0) mm; radius = 3 mm; rings = 6; sides = 8 }
  tissue is wall; thickness = 0.8 mm
  region lime where x between 3 mm and 7 mm and z > 1 mm { tissue is plaque }
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


def test_a_plaque_in_a_soft_wall_takes_few_steps_by_our_own_choice():
    outcome, _ = carried_out(compiled_scene(PLAQUE))
    statistics = outcome.statistics
    assert statistics.method == "esdirk43"
    assert any("the fastest motion is overdamped" in each.reason for each in statistics.changes)
    assert statistics.accepted < 120
    finer = PLAQUE.replace("tolerance = 1e-3", "tolerance = 1e-6; integrator is esdirk43")
    exact = carried_out(compiled_scene(finer))[0].state.position
    moved = np.abs(exact - outcome.state.network.position).max()
    assert np.abs(outcome.state.position - exact).max() < 1e-3 * moved


#: A strip with a weak middle, drawn out until it breaks.
BREAKING = """language 1
tissue gel {{ {matter}; {limit} }}
tissue tough like gel {{ {tough} }}
body strip {{
  mesh is {mesh}
  tissue is tough; rupture is allowed; {body}
  region middle where x between 9 mm and 16 mm {{ tissue is gel }}
}}
set low = nodes of strip where x < 0.1 mm
set high = nodes of strip where x > 24.9 mm
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 20 Hz }}
script {{
  at 0 s: fix low
  from 0 s to 40 ms: move high by (12, 1, 0) mm using smooth profile
}}
simulate {{ duration = 50 ms; {method} }}
output {{ trajectory every 5 ms }}
"""
PASCALS = "Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3; "
BOX = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (25, 5, 5) mm }"
STRIP = (
    "sheet { corner = (0, 0, 0) mm; first edge = (25, 0, 0) mm; second edge = (0, 5, 0) mm; "
    "columns = 6; rows = 2 }"
)
FLOWING = "yield stress = 400 Pa; flow viscosity = 20 Pa*s"
STRAINS = {"limit": "breaking strain = 30 %", "tough": "breaking strain = 300 %"}
STRANDS = "spring constant = 20 N/m; viscosity = 5 mN*s/m; mass = 20 mg"
BROKEN = {
    "a solid": STRAINS | {"matter": f"{PASCALS} retardation time = 3 ms", "mesh": BOX},
    "a solid that relaxes and yields": STRAINS | {
        "matter": f"{PASCALS} {RELAXING}; {FLOWING}", "mesh": BOX},
    "a wall that relaxes": STRAINS | {
        "matter": f"{PASCALS} {RELAXING}", "mesh": STRIP, "body": "thickness = 1 mm"},
    "springs": {
        "matter": STRANDS, "limit": "breaking force = 30 mN", "tough": "breaking force = 3 N",
        "mesh": BOX.replace("{", "{ kind is sodium chloride;"), "body": "interface is mean"},
    "springs that relax and yield": {
        "matter": f"{STRANDS}; relaxing constant = 15 N/m; relaxation time = 5 ms; "
                  "yield force = 20 mN; yield viscosity = 1 N*s/m",
        "limit": "breaking force = 30 mN", "tough": "breaking force = 3 N",
        "mesh": BOX.replace("{", "{ kind is sodium chloride;"), "body": "interface is mean"},
}  # fmt: skip


def broken(case, method):
    """Return the ends of ruptures with their springs, and where all nodes are at the end."""
    text = BREAKING.format(**{"body": ""} | BROKEN[case] | {"method": method})
    outcome, _ = carried_out(compiled_scene(text))
    assert outcome.kind == "done"
    found = [
        (t, event.springs) for t, event in outcome.logged_events if event.kind == "rupture"
    ]
    network = outcome.state.network
    return found, outcome.state.position, network.position, outcome.statistics.method


#: The others show alike that limits are met where something remembers.
SLOWLY_BROKEN = "a solid that relaxes and yields"


@pytest.mark.parametrize(
    "case",
    [pytest.param(c, marks=[pytest.mark.slow] * (c == SLOWLY_BROKEN)) for c in BROKEN],
)
def test_what_breaks_in_implicit_steps_breaks_as_in_explicit_ones(case):
    exact, position, drawn, _ = broken(case, "integrator is dop853; tolerance = 1e-9")
    assert len(exact) > 0
    found, there, _, method = broken(case, "integrator is esdirk43; tolerance = 1e-6")
    assert method == "esdirk43"
    assert [set(springs) for _, springs in found] == [set(springs) for _, springs in exact]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in exact], abs=1e-6)
    assert np.abs(there - position).max() < 2e-6 * np.abs(position - drawn).max()


FLOWS = f"{DAMPED}; yield stress = 100 Pa; flow viscosity = 20 Pa*s"


@pytest.mark.parametrize("memory", [FLOWS, f"{FLOWS}; relaxing share = 40 %; "
                                           "relaxation time = 5 ms"])  # fmt: skip
def test_solids_that_yield_keep_the_tolerance(memory):
    exact = ends("integrator is dop853; tolerance = 1e-9", memory).state
    outcome = ends("integrator is esdirk43; tolerance = 1e-5", memory)
    (made,) = outcome.state.of_kind("elements")
    assert made.yielding.equivalent(outcome.state.velocity, 8).max() > 0.01
    moved = np.abs(exact.position - exact.network.position).max()
    assert np.abs(outcome.state.position - exact.position).max() < 1e-5 * moved
