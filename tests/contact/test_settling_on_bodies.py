"""Bodies at rest on others: they are set down, and slide or are held by friction."""

import numpy as np
import pytest

from tests.contact.scenes import play

LYING = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms }}
body low {{ mesh is lattice {{ cell = 10 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }}
  tissue is gel }}
body high like low {{ moved by (0, 0, {height}) mm }}
set base = nodes of low where z < 0.1 mm
environment {{ gravity = {gravity} m/s^2; contact is bodies too; friction = {friction} }}
script {{ at 0 s: {{ fix base; settle }} }}
simulate {{ duration = 1 us }}
output {{ force(high) every 1 us; trajectory every 1 us }}
"""
LEVEL = "(0, 0, -9.81)"
SLOPE = "(1.96, 0, -9.61)"  # a tangent of 0.204
WEIGHT = 4e-6 * 1000.0 * 9.81  # [N]


def settled(height=10, gravity=LEVEL, friction=0.0):
    return play(LYING.format(height=height, gravity=gravity, friction=friction))


def notes(played):
    return " ".join(event.cause for _, event in played.outcome.logged_events)


@pytest.mark.parametrize("height", [10, 11, 25])
@pytest.mark.parametrize("friction", [0, 0.3])
def test_a_block_that_can_slide_is_set_down_and_rests_with_its_weight(height, friction):
    played = settled(height, friction=friction)
    assert played.outcome.kind == "done", played.outcome.message
    # Newton's method leaves 1e-12 of the forces; the first step of 1 us changes less than 1e-9.
    force = played.log("force of high")[1][0]
    assert np.abs(force) == pytest.approx([0.0, 0.0, WEIGHT], abs=1e-6 * WEIGHT)
    slides = "high can slide freely at right angles to (0, 0, 1)" in notes(played)
    assert slides == (friction == 0)
    high = played.compiled.network.bodies[1].nodes
    moved = played.position[0, high] - played.compiled.network.position[high]
    assert np.abs(moved[:, :2].mean(axis=0)).max() < 1e-6
    assert moved[:, 2].mean() == pytest.approx((10 - height) * 1e-3, abs=3e-4)


def test_on_a_slope_friction_holds_what_it_bears():
    assert settled(gravity=SLOPE, friction=0.3).outcome.kind == "done"


@pytest.mark.parametrize(
    ("friction", "said"), [(0.0, "there is no friction"), (0.1, "friction bears 3.8")]
)
def test_what_slides_down_a_slope_is_named(friction, said):
    outcome = settled(gravity=SLOPE, friction=friction).outcome
    assert outcome.kind == "stuck"
    assert "high can slide" in outcome.message
    assert said in outcome.message
