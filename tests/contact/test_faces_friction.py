"""Friction of faces: bristles that are cut at the ends of steps."""

import numpy as np
import pytest

from tests.contact.scenes import evaluated, gap_of_balance, play
from tests.validate.scenes import compiled_scene, silent
from tests.whole_runs import same_on_threads, same_when_resumed
from tissuec.forces.contact.contact import Contact
from tissuec.validate.validation import validate

STEEP = np.arctan(0.5)


def slide(degrees, duration, *, method="automatic", tolerance="1e-4", cell="20 mm", more=""):
    """Run a block of gel on a slope, by how much that is steeper than atan 0.5 [°]."""
    return play(
        on_slope(degrees, duration, method=method, tolerance=tolerance, cell=cell, more=more)
    )


def on_slope(degrees, duration, *, method="automatic", tolerance="1e-4", cell="20 mm", more=""):
    """Return the text of that."""
    angle = STEEP + np.radians(degrees)
    x, z = 9.81 * np.sin(angle), 9.81 * np.cos(angle)
    return f"""language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 10 ms
}}
body block {{
  mesh is lattice {{ cell = {cell}; box from (0, 0, 0) mm to (20, 20, 20) mm }}
  tissue is gel
}}
tool slope {{ kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }}
environment {{
  gravity = ({x:.12f}, 0, {-z:.12f}) m/s^2; contact is tools only; friction = 0.5
}}
script {{ {more} }}
simulate {{ duration = {duration} s; integrator is {method}; tolerance = {tolerance} }}
output {{ position of block every 10 ms }}
"""


def way(played):
    """Return times [s], and the way of the block along the slope [m]."""
    time, rows = played.log("position of block")
    return time, rows[:, 0] - rows[0, 0]


RUBBED = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms
}
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 5) mm }; tissue is gel
}
set base = nodes of block where z == 0 mm
tool ball { kind is probe; radius = 6 mm; centre = (4.5, 5, 11.1) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only; friction = 0.3 }
script {
  at 0 s: fix base
  from 0 s to 10 ms: move ball by (0, 0, -0.6) mm using smooth profile
  from 10 ms to 20 ms: move ball by (1, 0.3, 0) mm using smooth profile
  from 20 ms to 30 ms: move ball by (-0.5, 0.3, 0) mm using smooth profile
}
simulate { duration = 30 ms; tolerance = 1e-4 }
output { force of ball every 1 ms; energy every 1 ms }
"""


def test_the_energy_balance_closes_while_a_ball_rubs_back_and_forth():
    played = play(RUBBED)
    assert gap_of_balance(played) < 1e-5
    _, energies = played.energies()
    assert energies["dissipated"][-1] > 1e-7


def test_parts_of_threads_do_the_same_to_the_last_bit(monkeypatch):
    monkeypatch.setattr("tissuec.forces.contact.contact.WORTHWHILE", 1)
    network = compiled_scene(RUBBED).network
    contact, chance = network.contact, np.random.default_rng(4)
    position = network.position + 1e-4 * chance.standard_normal(network.position.shape)
    position[network.tools[0].nodes, 2] -= 1e-3
    velocity = chance.standard_normal((network.row_count, 3))
    place, found = np.arange(len(velocity)), []
    for parts in (1, 2, 3):
        table = contact.table(place, None, position)
        every = [part for group in contact.in_parts(table, parts) for part in group]
        forces, power = evaluated(contact, every, position, velocity)
        found.append((forces.tobytes(), power.tobytes(), table.touches.bent.tobytes()))
    assert np.abs(forces).max() > 1e-3
    assert len(set(found)) == 1


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_run_that_is_resumed_while_faces_rub_gives_the_same_bytes(count):
    compiled = compiled_scene(RUBBED.replace("output {", "output { trajectory every 2 ms;"))
    _, (first, _) = same_when_resumed(compiled, "force of ball", count)
    assert 0.0 < first.state.time < 0.03


def test_a_run_on_two_threads_gives_the_same_bytes(monkeypatch):
    # Elements alone have one thread, however many there are.
    monkeypatch.setattr("tissuec.forces.contact.contact.WORTHWHILE", 1)
    monkeypatch.setattr("tissuec.engine.layout._threads", lambda _, permitted, *__: permitted)
    parts, in_parts = set(), Contact.in_parts

    def counted(self, table, count):
        groups = in_parts(self, table, count)
        parts.add(max(map(len, groups)))
        return groups

    monkeypatch.setattr(Contact, "in_parts", counted)
    run = same_on_threads(RUBBED.replace("output {", "output { trajectory every 1 ms;"), 2)
    assert len(run.position) > 20 and max(parts) > 1


def test_a_block_on_a_slope_below_the_angle_of_friction_does_not_creep():
    time, moved = way(slide(-0.5, 10.0))
    late = time >= 2.0  # until then, what is left of the first swings fades
    assert np.ptp(moved[late]) < 1e-6 * 20e-3
    creep = moved[time >= 9.0].mean() - moved[late & (time < 3.0)].mean()
    assert abs(creep) < 1e-8 * 20e-3


@pytest.mark.parametrize(
    ("tolerance", "duration"),
    [
        ("1e-3", 0.01),
        *(pytest.param(rtol, 0.05, marks=pytest.mark.slow) for rtol in ("1e-3", "1e-5")),
    ],
)
def test_a_block_that_swings_below_the_angle_keeps_its_promise(tolerance, duration):
    """Its points begin and end to slip, in 50 ms some hundred times."""
    compiled = compiled_scene(on_slope(-0.5, duration, tolerance=tolerance))
    found = validate(compiled, method="DOP853", rtol=None, progress=silent)
    assert found.verdict == "kept", found.reasons


@pytest.mark.parametrize(
    ("method", "tolerance", "duration", "close"),
    [
        ("dop853", "1e-4", 0.4, 2e-3),
        ("velocity verlet", "1e-4", 0.4, 2e-3),
        ("rkc2", "1e-3", 0.2, 6e-3),  # until then, the first swings fade
        pytest.param("rkc2", "1e-4", 0.4, 2e-3, marks=pytest.mark.slow),
    ],
)
def test_above_the_angle_it_slides_as_coulomb_says(method, tolerance, duration, close):
    time, moved = way(slide(2.0, duration, method=method, tolerance=tolerance))
    late = time >= 0.5 * duration
    acceleration = 2.0 * np.polyfit(time[late], moved[late], 2)[0]
    angle = STEEP + np.radians(2.0)
    expected = 9.81 * (np.sin(angle) - 0.5 * np.cos(angle))
    assert acceleration == pytest.approx(expected, rel=close)


def test_points_that_slide_evenly_take_no_short_steps():
    """Their bristles neither grow nor turn, so that only rounding is left of their rates."""
    played = slide(2.0, 0.4, tolerance="1e-3", cell="10 mm")
    assert played.outcome.statistics.accepted < 2000  # and not 200,000


@pytest.mark.parametrize(("push", "share"), [(0.2, 5e-4), (2.0, 2.5e-3)])
def test_a_block_that_is_shaken_below_the_angle_hardly_walks(push, share):
    """Where pressures change, points slip or bend less, so that each shake leaves a part."""
    order = f"push block with ({push}, 0, 0) mN"
    shake = "\n".join(
        f"from {1 + 0.05 * k:.2f} s to {1.025 + 0.05 * k:.3f} s: {order}" for k in range(10)
    )
    time, moved = way(slide(-3.0, 2.5, more=shake, cell="10 mm"))
    shaken = np.ptp(moved[time > 1.0])
    assert shaken > 1e-6
    walked = abs(moved[-1] - np.interp(0.99, time, moved))
    assert walked < 10 * share * shaken
    # It stops with the shaking; what is left of that swings by less than 2 nm.
    assert np.ptp(moved[time > 2.3]) < 4e-9
