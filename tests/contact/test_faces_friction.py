"""Friction of faces: bristles that are cut at the ends of steps."""

import numpy as np
import pytest

from tests.contact.scenes import play

STEEP = np.arctan(0.5)


def slide(degrees, duration, *, method="automatic", tolerance="1e-4", more=""):
    """Run a block of gel on a slope, by how much that is steeper than atan 0.5 [°]."""
    angle = STEEP + np.radians(degrees)
    x, z = 9.81 * np.sin(angle), 9.81 * np.cos(angle)
    return play(f"""language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3; retardation time = 10 ms
}}
body block {{
  mesh is lattice {{ cell = 20 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }}
  tissue is gel
}}
tool slope {{ kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }}
environment {{
  gravity = ({x:.12f}, 0, {-z:.12f}) m/s^2; contact is tools only; friction = 0.5
}}
script {{ {more} }}
simulate {{ duration = {duration} s; integrator is {method}; tolerance = {tolerance} }}
output {{ position of block every 10 ms }}
""")


def way(played):
    """Return times [s], and the way of the block along the slope [m]."""
    time, rows = played.log("position of block")
    return time, rows[:, 0] - rows[0, 0]


def test_a_block_on_a_slope_below_the_angle_of_friction_does_not_creep():
    time, moved = way(slide(-0.5, 10.0, tolerance="1e-3"))
    late = moved[time >= 1.0]
    assert np.ptp(late) < 1e-6 * 20e-3


@pytest.mark.parametrize("method", ["dop853", "velocity verlet", "rkc2"])
def test_above_the_angle_it_slides_as_coulomb_says(method):
    time, moved = way(slide(2.0, 0.4, method=method))
    late = time >= 0.2
    acceleration = 2.0 * np.polyfit(time[late], moved[late], 2)[0]
    angle = STEEP + np.radians(2.0)
    expected = 9.81 * (np.sin(angle) - 0.5 * np.cos(angle))
    assert acceleration == pytest.approx(expected, rel=2e-3)


def test_a_shaken_block_below_the_angle_stays():
    shake = "\n".join(
        f"from {1 + 0.05 * k:.2f} s to {1.025 + 0.05 * k:.3f} s: "
        "push block with (2, 0, 0) mN"
        for k in range(20)
    )
    time, moved = way(slide(-3.0, 2.0, more=shake))
    start = np.interp(1.0, time, moved)
    assert abs(np.interp(1.99, time, moved) - start) < 2e-6
