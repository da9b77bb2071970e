"""Bodies on an elastic foundation, against closed forms, SciPy, and themselves resumed."""

import numpy as np
import pytest

import tissuec
from tests.hand_plan import carry_out
from tests.validate.scenes import compiled_scene, silent
from tests.whole_runs import AfterAsking
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.learn.derivatives.refusals import refusal_of_script
from tissuec.mechanics.settling import settle
from tissuec.validate.validation import validate

THICKNESS, DENSITY = 1e-3, 1000.0
STIFFNESS, DAMPING, G, AREA = 20e3, 4.0, 9.81, 6e-4
#: A sheet whose nodes all have the same mass by area: it sinks evenly, whatever its springs.
SHEET = """language 1
tissue skin {{ spring constant = 8 N/m; density = 1000 kg/m^3; retardation time = 1 ms }}
body sheet {{
  mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (30, 0, 0) mm
                  second edge = (0, 20, 0) mm; rows = 4; columns = 6; diagonals is both }}
  tissue is skin; thickness = 1 mm
}}
force bed {{ kind is foundation; acts on sheet; stiffness = 20 kPa/m
            damping = {damping} Pa*s/m }}
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 60 ms; tolerance = 1e-6 }}
output {{ trajectory every 2 ms; energy every 2 ms }}
"""


def sheet(damping=DAMPING, script=""):
    return SHEET.format(damping=damping, script=script)


def fall(time):
    """Return how a mass on a damped spring falls from rest to m g / c [m]."""
    mass = DENSITY * THICKNESS
    rate = DAMPING / (2.0 * mass)
    swing = np.sqrt(STIFFNESS / mass - rate**2)
    swung = np.cos(swing * time) + rate / swing * np.sin(swing * time)
    return -mass * G / STIFFNESS * (1.0 - np.exp(-rate * time) * swung)


@pytest.fixture(scope="module")
def sunk(tmp_path_factory):
    return tissuec.run(sheet(), out=tmp_path_factory.mktemp("sunk") / "sheet.vtkhdf")


def test_a_sheet_sinks_as_one_mass_on_a_damped_spring(sunk):
    expected = np.broadcast_to(fall(sunk.times)[:, None], sunk.position.shape[:2])
    assert sunk.position[..., 2] == pytest.approx(expected, abs=1e-6 * np.ptp(expected))
    # Nothing acts in the plane: steps at the limit of stability let roundings grow until the
    # control of errors sees them, far below the tolerance.
    assert beside(sunk) < 1e-2 * 1e-6 * np.ptp(expected)


def beside(result):
    """Return how far a node moves in the plane [m]."""
    return np.abs(result.position[..., :2] - result.position[0, :, :2]).max()


def test_a_sheet_that_sinks_stays_in_place():
    finer = sheet().replace("tolerance = 1e-6", "tolerance = 1e-7")
    assert beside(tissuec.run(finer, companion="off")) < 1e-12


def test_work_of_the_weight_is_stored_or_lost(sunk):
    stored = 0.5 * STIFFNESS * AREA * fall(sunk.energies.time) ** 2
    kinetic, elastic, height, work, lost, _ = sunk.energies.value.T
    # The force is known to 1e-6 of the largest displacement, the energy to twice as much.
    assert elastic == pytest.approx(stored, abs=2e-6 * stored.max())
    total = kinetic + elastic + height + lost
    assert total == pytest.approx(total[0], abs=2e-6 * stored.max())
    assert not work.any()


def test_at_rest_it_bears_the_weight():
    state = state_at_start(compiled_scene(sheet()))
    settle(state, np.ones(state.network.node_count, dtype=bool))
    depth = DENSITY * THICKNESS * G / STIFFNESS
    assert state.position[:, 2] == pytest.approx(-depth, rel=1e-9)


def test_modes_that_strain_no_spring_are_those_of_a_mass_on_a_damped_spring():
    """The sheet moved evenly, and out of its plane in any shape."""
    mass = DENSITY * THICKNESS
    own = np.sqrt(STIFFNESS / mass)
    text = sheet().replace("(0, 0, -9.81)", "(0, 0, 0)")
    for mode in tissuec.modes(text, count=8):
        assert mode.frequency == pytest.approx(own / (2.0 * np.pi), rel=1e-9)
        assert mode.damping_ratio == pytest.approx(DAMPING / (2.0 * mass * own), rel=1e-9)


def drawn_up_and_cut(integrator="dop853"):
    script = (
        "at 0 s: grasp edge with pin; "
        "from 0 s to 20 ms: move pin by (0, 0, 4) mm using smooth profile; "
        "at 30 ms: cut sheet along plane through (14, 0, 0) mm facing (1, 0, 0)"
    )
    text = sheet(script=script).replace("1e-6", f"1e-4; integrator is {integrator}")
    text += "tool pin { kind is forceps }\nset edge = nodes of sheet where x < 1 mm\n"
    return compiled_scene(text)


@pytest.mark.parametrize("integrator", ["dop853", "esdirk43", "velocity verlet"])
def test_scipy_agrees_on_a_sheet_that_is_drawn_up_and_cut(integrator):
    scene = drawn_up_and_cut(integrator)
    found = validate(scene, method="DOP853", rtol=None, progress=silent)
    assert found.verdict == "kept", found.reasons


def test_a_run_that_is_gone_on_with_keeps_the_force():
    compiled = drawn_up_and_cut()
    network, plan = compiled.network, compiled.plan
    whole, _ = carry_out(network, plan)
    first, before = carry_out(network, plan, interrupt=AfterAsking(2))
    assert first.kind == "interrupted" and 0.0 < first.state.time < 0.06
    rest, _ = carry_out(network, plan, resume=before.state)
    assert rest.kind == "done"
    assert np.array_equal(rest.state.position, whole.state.position)


def test_there_are_exact_derivatives():
    compiled = compiled_scene(sheet())
    assert not refusal_of_script(compiled.plan, compiled.network)


def test_a_force_may_have_the_name_of_another_effect():
    text = SHEET.format(damping=DAMPING, script="").replace("force bed", "force bending")
    text = text.replace("spring constant = 8 N/m", "Young's modulus = 20 kPa")
    text = text.replace("; diagonals is both", "")
    fields = state_at_start(compiled_scene(text)).named_fields
    assert {type(field).__name__ for field in fields.values()} == {"Membranes", "Plates", "Bed"}
