"""Whole runs in which something is touched: resumed, judged by SciPy, settled, and skipped."""

import numpy as np
import pytest

import tissuec
from tests.contact.scenes import bodies, play
from tests.engine.running import set_pace
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import AfterAsking, carried_out, same_when_resumed
from tissuec.compiler.prediction import skipped
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.mechanics.state import State

PRESSED = """language 1
tissue flesh {{ spring constant = 200 N/m; viscosity = {viscosity}; mass = 0.2 g }}
body block {{
  mesh is lattice {{ kind is sodium chloride; cell = 10 mm; reach is second neighbours
    box from (0, 0, 0) mm to (20, 20, 10) mm }}
  tissue is flesh
}}
set base = nodes of block where z < 0.1 mm
{tool}
environment {{ gravity = (0, 0, 0) m/s^2; contact is {contact} }}
script {{
  at 0 s: fix base
  {script}
}}
simulate {{ duration = {duration}; tolerance = 1e-5 }}
output {{ trajectory every 5 ms; force of base every 1 ms; energy every 5 ms }}
"""
PROBE = "tool probe { kind is probe; radius = 8 mm; centre = (11, 9, 19) mm }"
STROKE = """from 0 s to 50 ms: move probe by (0, 0, -3) mm using smooth profile
  from 50 ms to 100 ms: move probe by (2, 0.5, 0) mm using smooth profile"""


def pressed(
    *,
    contact="tools only; friction = 0.3",
    tool=PROBE,
    script=STROKE,
    duration="0.1 s",
    viscosity="50 mN*s/m",
):
    """Return the text of a small block that a probe presses and strokes."""
    return PRESSED.format(
        contact=contact, tool=tool, script=script, duration=duration, viscosity=viscosity
    )


@pytest.mark.parametrize("count", [2, 3])
def test_a_run_that_is_resumed_in_mid_stroke_gives_the_same_bytes(count):
    compiled = compiled_scene(pressed())
    _, (first, _) = same_when_resumed(compiled, "force of base", count)
    assert 0.0 < first.state.time < 0.1


FAR = """from 0 s to 50 ms: move probe by (0, 0, -5) mm using smooth profile
  from 50 ms to 100 ms: move probe by (8, 2, 0) mm using smooth profile
  from 0 s to 100 ms: move base by (-8, -5, 3) mm using smooth profile"""


@pytest.mark.parametrize("count", [4, 8, 12])
def test_a_run_resumed_between_two_lists_of_what_is_near_counts_its_steps_the_same(
    count, monkeypatch
):
    # Methods contend by these counts, so what is resumed must not list at other times.
    set_pace(monkeypatch, "compiled", 50_000)
    compiled = compiled_scene(pressed(script=FAR, viscosity="0.2 N*s/m"))
    whole, _ = carried_out(compiled)
    first, before = carried_out(compiled, interrupt=AfterAsking(count))
    assert first.kind == "interrupted"
    second, _ = carried_out(compiled, resume=before.state)
    assert second.statistics == whole.statistics


def test_scipy_agrees_on_a_block_that_is_pressed_stroked_and_settled_and_it_is_said():
    stroke = STROKE.replace("100 ms", "20 ms").replace("50 ms", "10 ms")
    found = validated(pressed(script=f"{stroke}\n  at 20 ms: settle", duration="23 ms"))
    assert found.verdict == "kept", found.reasons
    assert quantity(found, "position").error < 1e-5
    assert quantity(found, "energy balance").error < 1e-5
    probe = quantity(found, "force of probe")
    assert probe.scale > 0.1  # [N]
    assert probe.error < 1e-5
    # What positions can do to it is not known from springs, and so not foretold.
    assert probe.expected is None


PRESS = "from 0 s to 0.1 s: move probe by (0, 0, -3) mm using smooth profile"
SETTLED = f"{PRESS}\n  at 0.1 s: settle"


def test_what_a_probe_is_pressed_into_settles_where_a_damped_run_comes_to():
    smooth = {"contact": "tools only"}
    settled = play(pressed(script=SETTLED, duration="0.11 s", **smooth))
    waited = play(pressed(script=PRESS, duration="1 s", **smooth))
    (_, force), (_, later) = settled.log("force of base"), waited.log("force of base")
    here, there = (p.position[-1, bodies(p)] for p in (settled, waited))
    moved = np.abs(there - waited.position[0, bodies(waited)]).max()
    assert here == pytest.approx(there, abs=2e-5 * moved)  # twice the tolerance
    assert np.abs(later[-1]).max() > 0.1
    assert force[-1] == pytest.approx(later[-1], abs=2e-5 * np.abs(later[-1]).max())


def test_what_is_settled_stays_and_friction_begins_anew():
    script = f"{STROKE}\n  at 100 ms: settle"
    scene = pressed(script=script, duration="0.12 s")
    played = play(scene.replace("tolerance = 1e-5", "tolerance = 1e-6"))
    _, force = played.log("force of base")
    assert np.abs(force[99] - force[-1]).max() > 0.01  # what friction held
    after = played.time > 0.1
    place = played.position[after][:, bodies(played)]
    assert np.abs(place - place[0]).max() < 1e-9
    # Stroked at 60 mm/s, with a tolerance of 1e-6: a few tolerances are left.
    assert np.abs(played.velocity[after][:, bodies(played)]).max() < 1e-6


def test_a_scene_without_contact_pays_nothing():
    without = compiled_scene(pressed(contact="off", tool="", script="").replace("probe", ""))
    plan, network = without.plan, without.network
    assert network.contact is None
    assert network.row_count == network.body_nodes == network.node_count
    state = State.start(network, gravity=plan.gravity, drag=plan.drag)
    assert state.fields == ()
    layout = KernelInputs(network, watched=False, ledger=False)
    layout.update(state)
    assert not layout.features.touched
    assert layout.fields().address.size == 0
    assert "contact: nothing can be in contact" in list(skipped(without))


def test_without_friction_nothing_is_remembered():
    compiled = compiled_scene(pressed(contact="tools only"))
    network = compiled.network
    assert network.row_count == network.node_count == network.body_nodes + 2
    assert "friction: none" in list(skipped(compiled))
    rubbed = compiled_scene(pressed()).network
    assert rubbed.row_count == rubbed.node_count + rubbed.body_nodes
    assert rubbed.node_count == network.node_count


FALLEN = """language 1
tissue jelly {{ spring constant = 500 N/m; viscosity = 50 mN*s/m; mass = 1 g }}
body lower {{
  mesh is lattice {{
    kind is sodium chloride; cell = 1 cm; box from (0, 0, 0) cm to (4, 4, 4) cm
  }}
  tissue is jelly
}}
body upper {{
  mesh is lattice {{
    kind is sodium chloride; cell = 1 cm; box from (0.3, 0.4, 4.2) cm to (4.3, 4.4, 8.2) cm
  }}
  tissue is jelly
}}
environment {{
  gravity = (0, 0, -9.81) m/s^2; contact is bodies too; contact thickness = 1.9 mm
  friction = {friction}
}}
set ground = nodes of lower where z < 1 mm
script {{ at 0 s: fix ground }}
simulate {{ duration = 50 ms; tolerance = {tolerance}; integrator is dop853 }}
output {{ trajectory every 10 ms }}
"""


def fallen(friction, tolerance):
    """Return the positions of a block that falls on another, and the evaluations they took."""
    run = tissuec.run(FALLEN.format(friction=friction, tolerance=tolerance), companion="off")
    return run.position[:], run.manifest["statistics"]["evaluations"]


def test_bristles_are_as_accurate_as_positions_have_to_be_and_not_more():
    fine, _ = fallen(0.3, 1e-6)
    found, rubbing = fallen(0.3, 1e-3)
    _, sliding = fallen(0.0, 1e-3)
    moved = np.linalg.norm(fine - fine[0], axis=-1).max()
    assert np.linalg.norm(found - fine, axis=-1).max() < 1e-3 * moved
    # 2.5 times as many; 13 times if errors of bristles counted as those of velocities do.
    assert rubbing < 4 * sliding
