"""Loads that are smaller than rounding errors of forces move thin bodies, and are reported."""

import pytest

import tissuec
from tests.engine.test_equilibria import carry_out
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.mechanics import newton
from tissuec.mechanics.settling import settle

LONG, WIDE, YOUNG = 40e-3, 10e-3, 1e6
STRIP = """language 1
tissue film {{ Young's modulus = 1 MPa; Poisson's ratio = 0; density = 1000 kg/m^3 }}
body strip {{
  mesh is lattice {{ cell = 2.5 mm; box from (0, 0, 0) mm to (40, 10, 2.5) mm }}
  scaled by (1, 1, {thin}); tissue is film
}}
set root = nodes of strip where x < 0.001 mm
set tip = nodes of strip where x > 39.999 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 0.5 s }}
output {{ position of tip every 0.5 s }}
"""


def strip(thick, load, script="at 0 s: {{ fix root; push tip with (0, 0, {load}) N }}"):
    script = script.replace("{{", "{").replace("}}", "}").replace("{load}", f"{load:.6g}")
    return tissuec.compile(STRIP.format(thin=thick / 2.5e-3, script=script))


def bent(thick, load):
    """Return the deflection of a cantilever [m]: F l^3/3 E I (Euler, Bernoulli)."""
    return load * LONG**3 / (3.0 * YOUNG * WIDE * thick**3 / 12.0)


def settled(thick, load):
    state = state_at_start(strip(thick, load))
    state.place_held()
    drawn = state.position.copy()
    remarks = settle(state, ~state.held)
    tip = drawn[:, 0] > LONG - 1e-6
    return (state.position - drawn)[tip, 2].mean(), [one.message for one in remarks]


@pytest.mark.parametrize("load", [1.25e-13, 1.25e-12, 1.25e-11])
def test_a_film_bends_by_loads_below_rounding_and_says_that_they_are(load):
    """Cells of 125 : 1 leave 5e-13 N at a node, where an eighth of the load acts."""
    moved, said = settled(0.02e-3, load)
    # Boxes are 0.1 % too stiff along 16 cells; the rest is geometry and rounding.
    assert moved == pytest.approx(bent(0.02e-3, load), rel=5e-3)
    assert "loads on strip are lost in rounding" in said


def test_loads_above_rounding_are_not_reported():
    moved, said = settled(0.5e-3, 1e-9)
    assert moved == pytest.approx(bent(0.5e-3, 1e-9), rel=5e-3)
    assert not said


def test_a_body_without_loads_is_not_reported(monkeypatch):
    asked = []
    given = newton.lost_in_rounding
    monkeypatch.setattr(
        newton, "lost_in_rounding", lambda *each: asked.append(given(*each)) or asked[-1]
    )
    moved, said = settled(0.02e-3, 0.0)
    assert abs(moved) < 1e-12
    assert "loads on strip are lost in rounding" not in said
    assert set(asked) == {None}


def test_a_static_run_reports_them_once():
    script = "at 0 s: fix root\n  from 0 s to 1 s: push tip with (0, 0, {load}) N using ramp"
    compiled = strip(0.02e-3, 1.25e-12, script)
    outcome, _ = carry_out(compiled.network, compiled.plan)
    (note,) = (one for one in outcome.notes if "lost in rounding" in one)
    assert "Use larger loads" in note and note.endswith("(first at 500 ms)")
