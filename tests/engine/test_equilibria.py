"""Statics along a path: limit points, ruptures and conditions are found where they are."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import tissuec
from tests.counting import counted
from tests.engine.test_quasistatic import DRAWN, drawn_out
from tests.hand_net import make_net, table
from tests.hand_plan import carry_out, event, make_plan, when
from tests.mechanics.test_settling import residual
from tests.validate.scenes import compiled_scene
from tests.whole_runs import AfterAsking
from tissuec.core.structs import replace
from tissuec.engine.execution import companion
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.finer_run import Allowance
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.integrators import INTEGRATORS
from tissuec.mechanics import newton
from tissuec.results.promise import Promise
from tissuec.script.plan import EQUILIBRIUM, STATIC
from tissuec.validate.engine_run import observe
from tissuec.validate.reference import reference

C, WIDE, HIGH = 1000.0, 0.1, 0.03  # spring constant and drawn place of the apex of a dome
LONG = np.hypot(WIDE, HIGH)
LINE = table([0.0, 1.0], [0.0, 1.0])
FEET = {"dome": [0, 1, 2, 3, 4], "feet": [0, 1, 2, 3], "apex": [4]}


def static(network, plan, **more):
    """Return a plan of the same events that is static."""
    simulation = replace(plan.simulation, integrator=EQUILIBRIUM, **more)
    return network, replace(plan, simulation=simulation)


def dome(*events, every=0.05):
    """Return four springs that meet above a plane, and a plan with their feet fixed."""
    place = np.array(
        [[WIDE, 0, 0], [-WIDE, 0, 0], [0, WIDE, 0], [0, -WIDE, 0], [0, 0, HIGH]], dtype=float
    )
    ends = np.array([[k, 4] for k in range(4)])
    network = make_net(place, ends, stiffness=C, mass=1e-3, damping=0.1)
    plan = make_plan(
        network, 1.0, [event(0.0, "fix feet", FEET), *events], integrator=EQUILIBRIUM,
        tolerance=None, step=0.05, every=every, energy=every,
    )  # fmt: skip
    return network, plan


def pressed(z):
    """Return the force that presses the apex down to a height [N]."""
    return 4.0 * C * (LONG - np.hypot(WIDE, z)) * z / np.hypot(WIDE, z)


def stored(z):
    return 2.0 * C * (LONG - np.hypot(WIDE, z)) ** 2


LIMIT = minimize_scalar(lambda z: -pressed(z), bounds=(0.0, HIGH), method="bounded")


def test_static_methods_are_no_integrators():
    assert not set(STATIC) & set(INTEGRATORS)


def test_a_stretched_chain_shares_the_stretch():
    outcome, recording = carry_out(*static(*drawn_out()))
    time, position, velocity, *_ = recording.frame_arrays()
    expected = np.arange(4) * (0.01 + 0.02 * time[:, None] / 3)
    assert outcome.kind == "done"
    assert position[:, :, 0] == pytest.approx(expected, abs=1e-14)
    assert not velocity[:, 1:3].any()
    _, rows = recording.energy_arrays()
    assert rows[:, 3] == pytest.approx(0.5 * 40.0 / 3.0 * (0.02 * time) ** 2, abs=1e-12)
    assert not rows[:, 4].any()


def test_a_dome_that_is_moved_passes_its_limit_points():
    """With the apex moved, every state has an equilibrium; forces even change their sign."""
    down = event(0.0, "move apex", FEET, by=(0, 0, -2.2 * HIGH), using=(LINE,), duration=1.0)
    outcome, recording = carry_out(*dome(down))
    time, position, *_ = recording.frame_arrays()
    z = HIGH * (1.0 - 2.2 * time)
    assert position[:, 4, 2] == pytest.approx(z, abs=1e-15)
    _, rows = recording.energy_arrays()
    assert rows[:, 1] == pytest.approx(stored(z), abs=1e-12)
    assert not rows[:, 4].any()
    assert outcome.kind == "done"
    assert not outcome.notes


def test_a_dome_that_is_pressed_snaps_at_its_limit_load():
    push = event(0.0, "push apex", FEET, with_=(0, 0, -4.0), using=(LINE,), duration=1.0)
    outcome, recording = carry_out(*dome(push))
    load = -LIMIT.fun
    after = brentq(lambda z: pressed(z) - load, -2.0 * HIGH, -HIGH)
    lost = stored(LIMIT.x) - stored(after) + load * (LIMIT.x - after)
    time, position, *_ = recording.frame_arrays()
    there = [
        brentq(lambda z, t=t: pressed(z) - 4.0 * t, *((LIMIT.x, HIGH) if t < load / 4.0
               else (-2.0 * HIGH, -HIGH)))
        for t in time
    ]  # fmt: skip
    assert position[:, 4, 2] == pytest.approx(there, abs=1e-12)
    _, rows = recording.energy_arrays()
    # The time is found within a millionth of the duration, 4e-6 N of the load.
    assert rows[-2, 4] == pytest.approx(lost, rel=2e-4)
    (note,) = outcome.notes
    assert float(note.split()[1]) == pytest.approx(1e3 * load / 4.0, abs=2e-3)
    assert "snapped to another equilibrium" in note


#: Two soft blocks, of which one comes down on the other.
MEETING = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body lower { mesh is lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }
  tissue is gel }
body upper {
  mesh is lattice { cell = 6 mm; box from (3.3, 4.1, 11.1) mm to (15.3, 16.1, 17.1) mm }
  tissue is gel
}
set base = nodes of lower where z < 0.1 mm
set top = nodes of upper where z > 17 mm
environment { gravity = (0, 0, 0) m/s^2; contact is bodies too; contact thickness = 1 mm }
script {
  at 0 s: fix base
  from 0 s to 1 s: move top by (0, 0, -2 mm) using constant speed
}
simulate { duration = 1 s; integrator is equilibrium }
output { force(top) every 100 ms }
"""


def test_a_first_touch_is_no_jump_and_costs_few_steps():
    compiled = compiled_scene(MEETING)
    outcome, _ = carry_out(compiled.network, compiled.plan)
    assert not outcome.notes
    # 10 steps of the output, at most as many until the touch is found, and as many doubled
    # steps from there on.
    assert outcome.statistics.accepted + outcome.statistics.rejected <= 30


def test_without_another_equilibrium_the_run_ends_with_the_time(tmp_path):
    """A thread whose force falls beyond a stretch bears no more than its largest force."""
    scene = """language 1
    let long = 10 mm
    law weak { spring force of e = c * e * exp(-e / long) }
    tissue gum { spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 1 g }
    body line { mesh is explicit; tissue is gum }
    table nodes of line in mm with columns "id x" { 1 0; 2 10 }
    table springs of line with columns "a b law" { 1 2 weak }
    set nail = nodes of line where x < 1 mm
    set hand = nodes of line where x > 9 mm
    environment { gravity = (0, 0, 0) m/s^2 }
    script { at 0 s: fix nail
      from 0 s to 1 s: push hand with 1 N along (1, 0, 0) using ramp }
    simulate { duration = 1 s; integrator is equilibrium }
    output { position of hand every 0.1 s }
    """
    (tmp_path / "weak.tis").write_text(scene, encoding="utf-8")
    with pytest.raises(tissuec.SimulationError) as failure:
        tissuec.run(tmp_path / "weak.tis", strict=True, companion="off")
    # The largest force is 100 N/m 10 mm / e = 0.367879 N.
    assert "stopped at 367.8" in str(failure.value)
    assert "there is no equilibrium near the previous one" in str(failure.value)


def test_a_search_beyond_a_limit_point_ends_soon(monkeypatch):
    """A balloon of neo-Hookean rubber bears 2 G t/R (7^(-1/6) - 7^(-7/6)), and no more."""
    scene = """language 1
    tissue rubber { Young's modulus = 100 kPa; Poisson's ratio = 0.49
      density = 1000 kg/m^3 }
    body balloon { mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
      tissue is rubber; thickness = 0.1 mm }
    environment { gravity = (0, 0, 0) m/s^2; contact is off }
    script { from 0 s to 1 s: press inside of balloon with 1 kPa using ramp }
    simulate { duration = 1 s; integrator is equilibrium }
    """
    steps = counted(monkeypatch, newton, "tangent_at")
    compiled = compiled_scene(scene)
    outcome, _ = carry_out(compiled.network, compiled.plan)
    shear = 100e3 / (2.0 * 1.49)
    most = 2.0 * shear * 0.1 / 10.0 * (7.0 ** (-1 / 6) - 7.0 ** (-7 / 6))
    # The surface of the mesh is 7 % smaller than the sphere, and flat triangles bear more.
    assert outcome.state.time * 1e3 == pytest.approx(most, rel=0.08)
    # About 20 halvings lead there; the last search is a patient one.
    taken = outcome.statistics.accepted + outcome.statistics.rejected
    assert len(steps) <= 10 * taken + 100


def test_springs_rupture_when_their_tension_reaches_the_strength():
    outcome, _ = carry_out(*static(*drawn_out(strength=0.2)))
    torn = [t for t, h in outcome.logged_events if h.kind == "rupture"]
    assert torn[0] == pytest.approx(0.75, abs=2e-6)


def test_any_number_of_ruptures_in_succession_is_closed_in_on():
    """Steps that only close in on them are not lost equilibria, which end a run."""
    count, line = 14, table([0.0, 1.0], [0.0, 1.0])
    times = 0.5 + 1.5e-3 * np.arange(count)
    place = [(0.01 * k, 0.01 * row, 0.0) for row in range(count) for k in range(3)]
    ends = [(3 * row + k, 3 * row + k + 1) for row in range(count) for k in range(2)]
    strength = np.full((count, 2), np.inf)
    strength[:, 0] = 40.0 * 0.01 * times  # each spring has half of 2 cm in 1 s
    network = make_net(place, ends, stiffness=40.0, mass=0.01, strength=strength.ravel())
    sides = {"nails": range(0, 3 * count, 3), "hands": range(2, 3 * count, 3)}
    groups = {name: list(nodes) for name, nodes in sides.items()}
    moved = event(0.0, "move hands", groups, by=(0.02, 0, 0), using=(line,), duration=1.0)
    plan = make_plan(
        network, 1.0, [event(0.0, "fix nails", groups), moved], integrator=EQUILIBRIUM,
        tolerance=None, step=0.05,
    )  # fmt: skip
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "done"
    torn = [t for t, h in outcome.logged_events if h.kind == "rupture"]
    assert torn == pytest.approx(times, abs=2e-6)


def test_conditions_are_closed_in_on():
    def stretched(snapshot):
        return snapshot.position[3, 0] > 0.0399

    network, plan = drawn_out(triggers=[when(stretched, event(0.0, "fix hand", DRAWN))])
    outcome, _ = carry_out(*static(network, plan))
    (fired,) = [t for t, h in outcome.logged_events if h.kind == "trigger"]
    assert fired == pytest.approx(0.495, abs=2e-6)


def accompanied(network, plan):
    """Run a plan with a companion; return its statistics, its estimate, and whose steps."""
    beside = Companion(network, plan, "inline")
    ran = run(
        network, plan, Recorder(network, plan, MemoryRecording(), tap=beside.tap)
    ).statistics
    return ran, beside.estimate(ran)


def test_equilibria_that_do_not_depend_on_the_way_are_confirmed_by_a_few(monkeypatch):
    moved = (
        event(0.0, "hold apex", FEET),
        event(0.0, "move apex", FEET, by=(0, 0, -0.01), using=(LINE,), duration=1.0),
    )
    network, plan = dome(*moved)
    accepted = []
    watch = Allowance.watch
    monkeypatch.setattr(
        Allowance,
        "watch",
        lambda self, time, ran: (watch(self, time, ran), accepted.append(ran.accepted)),
    )
    ran, estimate = accompanied(network, plan)
    assert estimate.error < 1e-9 and estimate.steps == 0.25
    assert max(accepted) < 0.5 * ran.accepted
    same, other = (
        Promise.of({"promise": estimate.as_dict() | {"error": error}}).sentence
        for error in (0.0, 2e-10)
    )
    beside = "a run with 4 times the step (no tolerance)"
    assert same == f"equal to {beside}"
    assert other == f"differs by 2.0e-10 of the largest displacement from {beside}"


def test_where_long_steps_find_other_equilibria_shorter_ones_decide(snapping, monkeypatch):
    network, plan, *_ = snapping
    monkeypatch.setattr(companion, "SAME_STATE", -1.0)
    _, estimate = accompanied(network, plan)
    assert estimate.steps == 2.0 and estimate.error < 1e-6
    assert len(estimate.times) == 21  # all


def test_what_hangs_is_balanced():
    outcome, _ = carry_out(*static(*drawn_out(gravity=(0.0, 0.0, -9.81))))
    assert outcome.kind == "done"
    assert residual(outcome.state) < 1e-12


@pytest.fixture(scope="module")
def snapping():
    """Return a dome that snaps, its plan, and a run that nothing interrupts."""
    push = event(0.0, "push apex", FEET, with_=(0, 0, -4.0), using=(LINE,), duration=1.0)
    network, plan = dome(push)
    return network, plan, *carry_out(network, plan)


@pytest.mark.parametrize("count", [1, 12, 18])
def test_a_run_that_is_resumed_gives_the_same_bytes(count, snapping):
    network, plan, whole, undisturbed = snapping
    first, before = carry_out(network, plan, interrupt=AfterAsking(count))
    assert first.kind == "interrupted"
    recording = MemoryRecording()
    second = run(network, plan, Recorder(network, plan, recording), resume=before.state)
    assert (second.kind, second.notes) == ("done", whole.notes)
    for get in (lambda r: r.frame_arrays()[1], lambda r: r.energy_arrays()[1]):
        assert np.array_equal(np.concatenate([get(before), get(recording)]), get(undisturbed))


@pytest.mark.parametrize("strength", [np.inf, np.array([0.3, 0.25, 0.3])])
def test_the_reference_finds_the_same_equilibria(strength):
    network, plan = static(*drawn_out(strength=strength, gravity=(0.0, 0.0, -9.81)))
    run_ = observe(network, plan, np.linspace(0.0, 1.0, 11), lambda time: None)
    found = reference(network, plan, run_.times)
    assert run_.position == pytest.approx(found.position, abs=1e-9)
    assert run_.force == pytest.approx(found.force, abs=1e-9)
    ours, theirs = ([one.time for one in of.breaks] for of in (run_, found))
    assert len(ours) == len(theirs) == (0 if np.isinf(strength).all() else 1)
    assert ours == pytest.approx(theirs, abs=2e-6)


BAG = """language 1
tissue rubber { spring constant = 100 N/m; viscosity = 0.2 N*s/m; mass = 0.1 g }
body bag { mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is rubber }
set base = nodes of bag where z < -9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: { fix base; FIRST }
  from 0 s to 1 s: THEN using ramp }
simulate { duration = 1 s; integrator is equilibrium }
output { energy every 0.5 s; volume of bag every 0.5 s }
"""


def bag(tmp_path, first, then, more=None):
    """Return the rows of energies and the volumes of a bag."""
    path, text = tmp_path / "bag.tis", BAG.replace("FIRST", first).replace("THEN", then)
    for old, now in (more or {}).items():
        text = text.replace(old, now)
    path.write_text(text, encoding="utf-8")
    tissuec.run(path, out=tmp_path / "bag.vtkhdf", companion="off")
    with tissuec.load(tmp_path / "bag.vtkhdf") as run_:
        energies = run_.energies
        rows = [dict(zip(energies.columns, row, strict=True)) for row in energies.value]
        return rows, run_.logs["volume of bag"].value[:, 0]


@pytest.mark.parametrize(
    ("first", "then"),
    [
        ("preserve volume of bag with 1 MPa", "inflate bag to 6 ml"),
        ("settle", "press bag with 1 kPa"),
    ],
)
def test_pumps_and_pressures_do_work(tmp_path, first, then):
    """On a smooth path all of it is stored, also in the equilibrium at the end."""
    (_, middle, end), volume = bag(tmp_path, first, then)
    for row in (middle, end):
        assert row["work"] == pytest.approx(row["elastic"], rel=1e-9)
        assert abs(row["dissipated"]) < 1e-12 * row["work"]
    assert middle["elastic"] > 0.0
    assert volume[2] > volume[1]


def test_a_pressure_that_ends_before_the_run_lets_its_work_go(tmp_path):
    change = {"duration = 1 s": "duration = 1.5 s"}
    rows, volume = bag(tmp_path, "settle", "press bag with 1 kPa", change)
    assert rows[3]["dissipated"] == pytest.approx(rows[3]["work"], rel=1e-6)
    assert volume[3] == pytest.approx(volume[0], rel=1e-6)


@pytest.mark.parametrize("method", [EQUILIBRIUM, "relaxation"])
def test_what_lasts_until_the_end_acts_in_the_last_sample(tmp_path, method):
    change = {
        "integrator is equilibrium": f"integrator is {method}; step = 50 ms",
        "from 0 s": "from 0.25 s", "using ramp": "using constant",
    }  # fmt: skip
    _, volume = bag(tmp_path, "settle", "press bag with 1 kPa", change)
    assert volume[2] == pytest.approx(volume[1], rel=1e-9)
    assert volume[2] > 1.001 * volume[0]


def test_a_body_that_is_moved_without_load_is_no_reason_for_short_steps(tmp_path):
    """Energies are rounding errors there, and so are their differences."""
    scene = """language 1
    tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 10 ms }
    body block { tissue is gel
      mesh is lattice { cell = 5 mm; box from (0, 0, 12) mm to (10, 10, 22) mm } }
    set top = nodes of block where z == 22 mm
    environment { gravity = (0, 0, 0) m/s^2 }
    script { from 0 s to 0.1 s: move top by (0, 0, -4) mm using smooth profile }
    simulate { duration = 0.1 s; integrator is equilibrium }
    output { force of top every 50 ms }
    """
    (tmp_path / "free.tis").write_text(scene, encoding="utf-8")
    run_ = tissuec.run(tmp_path / "free.tis", companion="off")
    assert run_.manifest["statistics"]["accepted"] < 30
    assert np.abs(run_.logs["force of top"].value).max() < 1e-12


APART = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3 }
body block {
  mesh is lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }; tissue is gel
}
set base = nodes of block where z == 0 mm
set top = nodes of block where z == 20 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix base
  from 0 s to 0.3 s: move top by (0, 0, -2) mm using constant speed
  from 0.3 s to 0.7 s: move top by (0, 0, 1) mm using constant speed
}
simulate { duration = 1 s; integrator is equilibrium; step = 0.1 s }
output { force(top) every 0.1 s }
"""


def test_times_that_differ_by_rounding_are_one():
    """Three times 0.1 s is 0.30000000000000004 s, which is no step after 0.3 s."""
    run = tissuec.run(APART, companion="off")
    statistics = run.manifest["statistics"]
    assert statistics["smallest"] > 0.099
    # Ten steps, and once more after what happens at 0 s, 0.3 s and 0.7 s.
    assert statistics["accepted"] == 10 + 3
    force = run.logs["force of top"].value[:, 2]
    assert len(force) == 11
    half = [force[time] for time in (7, 8, 9, 10)]
    # At rest from 0.7 s on: the residual of settling is far below.
    np.testing.assert_allclose(half, half[0], rtol=1e-6)
