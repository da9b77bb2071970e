"""The plan of static runs foretells how many equilibria there are and what they cost."""

from time import process_time

import pytest

import tissuec
from tests.counting import counted
from tissuec.compiler.checks import starts
from tissuec.compiler.prediction import predict
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.engine.static_cost import NEAR
from tissuec.mechanics import settling
from tissuec.mechanics.inverses import Inverses

BLOCK = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = {cell}; box from (0, 0, 0) mm to (20, 20, 20) mm }}; tissue is gel
}}
set base = nodes of block where z < 0.1 mm
set top = nodes of block where z > 19.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix base; from 0 s to 1 s: move top by (0, 0, -2) mm using constant speed }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 0.25 s }}
output {{ force(top) every {every} }}
"""


@pytest.mark.parametrize("every", ["0.25 s", "0.1 s"])
def test_equilibria_and_steps_are_foretold_within_a_factor_of_two(every, monkeypatch):
    solved = counted(monkeypatch, Inverses, "of")
    text = BLOCK.format(cell="10 mm", every=every)
    static = predict(tissuec.compile(text)).static
    done = tissuec.run(text, companion="off").manifest["statistics"]["accepted"]
    assert abs(static.equilibria - done) <= 1
    assert 0.5 < static.steps / len(solved) < 2.0


def test_the_time_of_a_run_grows_with_the_body_as_foretold():
    """Ratios of processor time are the same on every machine within a factor of two."""

    def times(cell: str) -> tuple[float, float]:
        text = BLOCK.format(cell=cell, every="1 s")
        foretold, began = predict(tissuec.compile(text)), process_time()
        tissuec.run(text, companion="off")
        return foretold.static.seconds, process_time() - began

    small, large = times("5 mm"), times("2 mm")
    foretold, measured = (b / a for a, b in zip(small, large, strict=True))
    assert measured > 3.0
    assert 0.5 < foretold / measured < 2.0


SETTLED = """language 1
tissue gel {{ Young's modulus = 20 kPa; Poisson's ratio = 0.4; density = 1000 kg/m^3 }}
body part {{ mesh is {mesh}; tissue is gel{wall} }}
set base = nodes of part where x < 0.1 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: {{ fix base; settle }} }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 1 s }}
output {{ force(base) every 1 s }}
"""
SHAPES = {
    "a block": ("lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }", ""),
    "a beam": ("lattice { cell = 3 mm; box from (0, 0, 0) mm to (60, 6, 6) mm }", ""),
    "a flap": (
        "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
        "second edge = (0, 20, 0) mm; columns = 9; rows = 5 }",
        "; thickness = 1 mm; bending is elastic",
    ),
}


@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_slender_bodies_take_more_steps_to_settle(shape, monkeypatch):
    """They are 3 or 4 in a block, and about 20 in what bends far."""
    mesh, wall = SHAPES[shape]
    compiled = tissuec.compile(SETTLED.format(mesh=mesh, wall=wall))
    static, solved = predict(compiled).static, counted(monkeypatch, Inverses, "of")
    state = state_at_start(compiled)
    state.place_held()
    settling.settle(state, ~state.held)
    near = NEAR * (static.equilibria - 1)
    assert 0.5 < (static.steps - near) / len(solved) < 2.0


def test_settle_is_a_part_of_the_plan_of_a_run_that_moves():
    moving = BLOCK.format(cell="10 mm", every="1 s").replace(
        "integrator is equilibrium; step = 0.25 s", "tolerance = 1e-3"
    )
    settled = moving.replace("fix base;", "fix base; at 0 s: settle;")
    before, after = (predict(tissuec.compile(text)) for text in (moving, settled))
    assert before.static.equilibria == 0
    assert after.static.equilibria == 1
    assert after.seconds - before.seconds == pytest.approx(after.static.seconds, rel=1e-12)
    interval = moving.replace("fix base;", "fix base; from 0 s to 0.5 s: settle;")
    assert predict(tissuec.compile(interval)).static.equilibria in range(20, 25)


def test_a_static_run_of_more_than_a_minute_is_announced():
    text = BLOCK.format(cell="2.5 mm", every="1 ms")  # 1000 equilibria
    (found,) = (one for one in tissuec.check(text) if one.code == "W413")
    assert "for 100" in found.message and "mainly for block" in found.message
    assert "fewer outputs" in found.hint
    fewer = BLOCK.format(cell="2.5 mm", every="0.1 s")
    assert "W413" not in {one.code for one in tissuec.check(fewer)}


def warned(text):
    return [one for one in tissuec.check(text) if one.code == "W413"]


def test_the_larger_part_of_a_long_run_is_named(monkeypatch):
    monkeypatch.setattr(starts, "LONG", 0.46)  # [s]; of 0.44 s to settle, and 0.75 s for 1 s
    text = BLOCK.format(cell="2 mm", every="0.1 s")
    text = text.replace(
        "move top by (0, 0, -2) mm using constant speed", "push top with (0, 0, -1) mN"
    )
    moving = text.replace("integrator is equilibrium; step = 0.25 s", "integrator is rkn4")
    settled = moving.replace("fix base;", "fix base; at 0 s: settle;")
    (steps,) = warned(settled)
    assert "at the steps that it needs" in steps.message
    (equilibrium,) = warned(settled.replace(" 1 s", " 0.05 s"))  # neither part alone is long
    assert "for 1 equilibrium" in equilibrium.message
    assert "outputs" not in equilibrium.hint
    assert not warned(moving.replace(" 1 s", " 0.05 s"))
