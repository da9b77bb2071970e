"""Runs that are static for an interval and dynamic besides."""

import numpy as np
import pytest

import tissuec
from tests.engine.running import set_pace
from tests.engine.test_equilibria import FEET, LIMIT, LINE, dome, pressed
from tests.hand_net import make_net
from tests.hand_plan import carry_out, event, make_plan
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import carried_out, open_balance, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace

SHEET = """language 1
tissue gum {{ spring constant = 100 N/m; viscosity = {viscosity}; mass = 1 g; {tissue} }}
body sheet {{
  mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
    second edge = (0, 10, 0) mm; columns = 5; rows = 3; diagonals is both }}
  tissue is gum
}}
set left = nodes of sheet where x < 0.1 mm
set right = nodes of sheet where x > 19.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  {script}
}}
simulate {{ duration = {duration}; {method} }}
output {{ trajectory every 50 ms; energy every 50 ms; force of left every 50 ms }}
"""
RAMP = "from 0.1 s to 0.6 s: move right by (6, 2, 0) mm using smooth profile"
STILL = f"from 0 s to 0.7 s: settle; {RAMP}; at 0.8 s: free right"


def scene(script=STILL, *, viscosity="0.2 N*s/m", tissue="", duration="1 s", method=""):
    return SHEET.format(
        script=script.replace("; ", "\n  "), viscosity=viscosity, tissue=tissue,
        duration=duration, method=method,
    )  # fmt: skip


def seen(text):
    outcome, recording = carried_out(compiled_scene(text))
    assert outcome.kind == "done"
    return outcome, recording, *recording.frame_arrays()[:3]


def test_ramps_are_those_of_small_steps_of_settle():
    """At each sample, the net is where it settles in that moment."""
    *_, time, position, velocity = seen(scene())
    moments = "; ".join(f"at {0.05 * k:.2f} s: settle" for k in range(15))
    *_, there, _ = seen(scene(f"{RAMP}; {moments}; at 0.8 s: free right"))
    still = time < 0.69
    # Samples at these times show the net after it settled.
    assert position[still] == pytest.approx(there[still], abs=1e-12)
    middle = np.abs(position[0, :, 0] - 0.01) < 0.009
    assert not velocity[still][:, middle].any()


def test_ramps_are_those_of_a_slow_overdamped_run():
    *_, time, position, _ = seen(scene())
    slow = RAMP.replace("0.1 s", "10 s").replace("0.6 s", "60 s")
    text = scene(slow, duration="61 s").replace("every 50 ms", "every 5 s")
    *_, there, _ = seen(text)
    moved = np.abs(position - position[0]).max()
    for one, other in ((0.3, 30.0), (0.5, 50.0), (0.6, 60.0)):
        ours, theirs = position[round(one / 0.05)], there[round(other / 5.0)]
        assert np.abs(ours - theirs).max() < 2e-3 * moved
    assert time[-1] == 1.0


def test_what_is_let_go_swings_from_its_last_equilibrium():
    """A mass between two springs, which is pushed aside slowly, swings as a cosine."""
    place = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]])
    network = make_net(place, np.array([[0, 1], [1, 2]]), stiffness=10.0, mass=0.05, rest=0.05)
    sets = {"ends": [0, 2], "mass": [1]}
    plan = make_plan(
        network, 2.0,
        [
            event(0.0, "fix ends", sets),
            event(0.0, "settle", sets, duration=1.0),
            event(0.0, "push mass", sets, with_=(0.2, 0, 0), duration=1.0),
        ],
        tolerance=1e-8, every=0.05, energy=0.05,
    )  # fmt: skip
    outcome, recording = carry_out(network, plan)
    time, position, velocity, *_ = recording.frame_arrays()
    aside, stiff = position[:, 1, 0] - 0.1, network.springs.stiffness.sum()
    swings = np.sqrt(stiff / network.mass[1])
    expected = 0.2 / stiff * np.cos(swings * np.maximum(time - 1.0, 0.0))
    assert aside == pytest.approx(expected, abs=1e-9)
    assert velocity[time <= 1.0][:, 1] == pytest.approx(0.0, abs=1e-15)
    assert [(each.time, each.method) for each in outcome.statistics.changes] == [
        (0.0, "equilibrium"), (1.0, outcome.statistics.method)]  # fmt: skip
    assert outcome.statistics.method == "dop853"
    assert "asks for equilibrium" in outcome.statistics.changes[0].reason


def test_the_ledger_is_that_of_the_whole_run():
    """What moves when an interval begins loses its kinetic energy to the event."""
    pulled = "from 0 s to 0.2 s: move right by (3, 0, 0) mm using constant speed"
    _, recording, *_ = seen(scene(
        f"{pulled}; from 0.3 s to 0.6 s: settle; "
        "from 0.4 s to 0.5 s: move right by (3, 2, 0) mm using smooth profile; "
        "at 0.8 s: free right", viscosity="0.02 N*s/m", method="tolerance = 1e-7"))  # fmt: skip
    assert np.abs(open_balance(recording)).max() < 1e-6
    rows = recording.energy_arrays()[1]
    work, dissipated, switched = rows[:, 3], rows[:, 4], rows[:, 5]
    # In the interval, work is stored, and nothing is dissipated but by the first equilibrium.
    assert dissipated[7:13] == pytest.approx(dissipated[7], abs=1e-12)
    assert work[11] > work[7]
    assert switched[7] < 0.0


def test_limit_points_are_passed_and_remarked():
    network, plan = dome(
        event(0.0, "settle", FEET, duration=0.6),
        event(0.0, "push apex", FEET, with_=(0, 0, -4.0), using=(LINE,), duration=0.6),
    )
    simulation = replace(plan.simulation, integrator="dop853", step=None, tolerance=1e-6)
    outcome, recording = carry_out(network, replace(plan, simulation=simulation))
    time, position, *_ = recording.frame_arrays()
    load = -LIMIT.fun
    (note,) = (note for note in outcome.notes if "snapped to another equilibrium" in note)
    snapped = 1e-3 * float(note.split()[1])
    assert snapped == pytest.approx(load / 4.0, abs=2e-6)
    z = position[time < 0.49, 4, 2]
    assert pressed(z) == pytest.approx(4.0 * time[time < 0.49], abs=1e-8)
    # The push ends with the interval, and the net swings from its last equilibrium.
    assert position[-1, 4, 2] != pytest.approx(z[-1], abs=1e-4)


def test_a_run_that_is_resumed_gives_the_same_bytes(monkeypatch):
    set_pace(monkeypatch, "compiled", 2_000)
    compiled = compiled_scene(scene())
    whole, *parts = same_when_resumed(compiled, "force of left", 3, 6)
    assert len(parts) == 2
    for first, second in parts:
        assert 0.0 < first.state.time < 1.0
        assert second.statistics.changes == whole.statistics.changes


def test_the_reference_knows_static_intervals():
    assert validated(scene(method="tolerance = 1e-5")).verdict == "kept"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tissue": "relaxing constant = 50 N/m; relaxation time = 1 s"},
         "springs that relax or yield cannot settle over an interval"),
        ({"method": "integrator is equilibrium"},
         "settle over an interval has no effect: equilibrium is always static"),
        ({"script": "from 0 s to 0.7 s: settle right"},
         "a part of the scene cannot settle over an interval"),
    ],
)  # fmt: skip
def test_what_cannot_be_static_is_refused(changes, message):
    with pytest.raises(CompileError) as caught:
        compiled_scene(scene(**changes))
    assert message in caught.value.diagnostics[0].message
    assert "settle" in caught.value.diagnostics[0].span.text


def test_sentences_of_a_session_may_be_static():
    """What no plan foresees is as if it were in the script, from any time on."""
    sim = tissuec.start(scene("at 0 s: free right"))
    sim.fix("left")
    sim.step("0.05 s")
    sim.settle(over="0.65 s")
    sim.step("0.05 s")
    sim.order("move right by (6, 2, 0) mm using smooth profile", over="0.5 s")
    sim.step("0.23 s")
    assert not sim.velocity[sim.nodes_of("sheet")[6]].any()
    sim.run_until("0.8 s")
    sim.free("right")
    sim.run_until("1 s")
    found = tissuec.run(sim.script(), companion="off")
    methods = [each["method"] for each in found.manifest["statistics"]["changes"]]
    assert methods == ["dop853", "equilibrium", "dop853"]
    assert np.array_equal(sim.position, found.position[-1])
