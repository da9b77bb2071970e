"""Springs that remember in whole runs: orders, files, ruptures, settling, friction."""

import numpy as np
import pytest

from tests.engine.running import Bench, accelerated
from tests.hand_net import make_net, order, start
from tests.inelastic.scenes import PLASTIC, STANDARD, ran, rod
from tests.validate.scenes import compiled_scene, quantity, validated
from tissuec.compiler.materials.internal_variables import with_memory
from tissuec.core.structs import replace
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.stability import damping_radius, spectral_radius
from tissuec.forces.springs.springs import flat
from tissuec.mechanics import observables
from tissuec.mechanics.settling import settle
from tissuec.model.inelastic import Inelastic
from tissuec.validate.equations import Equations

RNG = np.random.default_rng(3)


def remembering(net, *, constant=(), time=(), limit=np.inf, viscosity=np.inf):
    """Return a net all of whose springs relax and yield alike."""
    count = net.spring_count
    rows = len(constant)
    inelastic = Inelastic(
        constant=np.array(constant, dtype=float).reshape(-1, 1) * np.ones(count),
        time=np.array(time, dtype=float).reshape(-1, 1) * np.ones(count),
        limit=np.full(count, limit),
        viscosity=np.full(count, viscosity),
        slot=np.full((rows + 1, count), -1),
        rate=np.ones((rows + 1, count)),
    )
    return with_memory(replace(net, springs=replace(net.springs, inelastic=inelastic)))


def tangle(**memory):
    """Return six nodes and nine springs that swing through one another."""
    ends = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (0, 3), (1, 4), (2, 5)]
    random = np.random.default_rng(7)
    net = make_net(
        random.normal(size=(6, 3)),
        ends,
        mass=random.uniform(0.5, 2.0, 6),
        stiffness=random.uniform(5.0, 9.0, 9),
        rest=random.uniform(0.5, 1.5, 9),
        velocity=0.3 * random.normal(size=(6, 3)),
    )
    return remembering(net, **memory)


BRANCHES = {"constant": (6.0, 2.0), "time": (0.3, 0.05)}
BOTH = BRANCHES | {"limit": 1.0, "viscosity": 20.0}


def random_state(net):
    """Return a state of a net in which everything is somewhere, with what it remembers."""
    state = start(net)
    random = np.random.default_rng(5)
    rows = net.internal_rows
    state.velocity[rows] = random.normal(size=state.velocity[rows].shape)
    state.position += 0.2 * random.normal(size=state.position.shape)
    return state


# --- equations ---


def test_forces_are_minus_the_slope_of_the_energy_at_what_is_remembered():
    state = random_state(tangle(**BOTH))
    velocity = state.velocity.copy()
    velocity[:6] = 0.0
    force = observables.inner_forces(state, 0.0, state.position, velocity).node
    for node in range(6):
        for axis in range(3):
            step = np.zeros_like(state.position)
            step[node, axis] = 1e-5
            ahead, behind = (
                observables.elastic_energy(state, state.position + s, velocity)
                for s in (step, -step)
            )
            # Central difference: step² times a third derivative, and rounding over the step.
            assert force[node, axis] == pytest.approx((behind - ahead) / 2e-5, abs=1e-7)


def test_power_of_the_forces_is_what_energy_and_losses_take():
    """-F·v = d(energy)/dt + lost, with rates of all that is remembered, by differences."""
    net = tangle(**BOTH)
    state = random_state(net)
    memory, position, velocity = net.springs.inelastic, state.position, state.velocity
    moving = velocity[: net.node_count]
    has = memory.slot >= 0
    rates, (_, lost) = accelerated(state)
    rates = rates.ravel()
    assert lost > 0.0
    assert (rates[memory.slot[-1][has[-1]]] != 0.0).any()
    energies = []
    for sign in (1.0, -1.0):
        there = velocity.copy()
        there.reshape(-1)[memory.slot[has]] += sign * 1e-6 * rates[memory.slot[has]]
        at = position + sign * 1e-6 * moving
        energies.append(observables.elastic_energy(state, at, there))
    gained = (energies[0] - energies[1]) / 2e-6
    force = observables.inner_forces(state, 0.0, position, velocity).node
    assert -np.vdot(force, moving) == pytest.approx(gained + lost, rel=1e-7)


def test_the_reference_has_the_same_forces_energies_and_rates():
    net = tangle(**BOTH)
    state = random_state(net)
    equations = Equations(state, 1.0)
    y = equations.gather(state.position, state.velocity, 0.0, 0.0)
    moved, velocity = equations.spread(0.0, y)
    assert velocity[net.internal_rows] == pytest.approx(
        state.velocity[net.internal_rows], rel=1e-14
    )
    springs = equations.pull(0.0, moved, velocity)
    tension = observables.tension(state, state.position, state.velocity)
    assert springs.tension == pytest.approx(tension, rel=1e-12)
    energies = observables.energies(state, 0.0, state.position, state.velocity)
    own = equations.energies(0.0, moved, velocity)
    assert own.elastic == pytest.approx(float(energies.elastic), rel=1e-13)
    memory, rate = net.springs.inelastic, equations.rate(0.0, y)
    rates, (_, lost) = accelerated(state)
    rates = rates.ravel()
    has = memory.slot >= 0
    assert rate[36:-2] == pytest.approx(rates[memory.slot[has]] / memory.rate[has], rel=1e-11)
    assert rate[-1] == pytest.approx(lost, rel=1e-12)


def test_jacobian_of_the_reference_is_the_derivative_of_its_rates():
    state = random_state(tangle(**BOTH))
    equations = Equations(state, 1.0)
    y = equations.gather(state.position, state.velocity, 0.0, 0.0)
    matrix = equations.jacobian(0.0, y).toarray()
    step = 1e-6
    differences = np.array(
        [
            (equations.rate(0.0, y + step * e) - equations.rate(0.0, y - step * e)) / (2 * step)
            for e in np.eye(len(y))
        ]
    ).T
    rows = slice(0, len(y) - 2)  # work and losses act on nothing
    assert np.abs(matrix[rows] - differences[rows]).max() < 1e-6 * np.abs(matrix).max()


def test_rates_of_a_mass_on_a_wall():
    net = make_net([[0.0, 0, 0], [1.0, 0, 0]], [[0, 1]], mass=0.5, stiffness=8.0)
    state = start(remembering(net, constant=(10.0,), time=(0.02,)))
    state.holders["fix"] = np.array([0])
    # 5 % is added to what power iterations find.
    assert spectral_radius(state) == pytest.approx(np.sqrt(1.05 * 18.0 / 0.5), rel=1e-6)
    assert damping_radius(state) == pytest.approx(50.0)
    state.holders["fix"] = np.array([0, 1])
    assert spectral_radius(state) == pytest.approx(25.0)


# --- methods ---

ORDERS = {"dop853": (8, (10, 14, 20)), "velocity verlet": (2, (128, 256, 512)),
          "rkc2": (2, (128, 256, 512)), "rkn4": (3, (48, 96, 192)),
          "propagation": (1, (64, 128, 256)),
          "esdirk43": (4, (48, 96, 192)), "trbdf2": (2, (128, 256, 512))}  # fmt: skip


def stepped(net, method, count):
    found = Bench(net, 1.0, method=method, step=1.0 / count, times=[1.0]).run()
    assert found.end.kind == "reached"
    return np.concatenate([found.position[0, :6], found.velocity[0, :6]])


@pytest.mark.parametrize("method", ORDERS)
def test_methods_keep_their_order_with_branches(method):
    net, (declared, counts) = tangle(**BRANCHES), ORDERS[method]
    exact = stepped(net, "dop853", 400)
    errors = [np.abs(stepped(net, method, count) - exact).max() for count in counts]
    observed = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert observed == pytest.approx(declared, abs=0.15 * max(declared, 2))


def test_the_symplectic_method_gives_way_to_one_that_can():
    found = Bench(tangle(**BRANCHES), 1.0, method="srkn11", tolerance=1e-6).run()
    assert found.engine.choice.name == "dop853"
    assert found.engine.choice.reason.startswith("there are springs that relax or flow")


def test_automatic_stays_explicit_however_fast_springs_relax():
    text = rod(memory="relaxing constant = 300 N/m; relaxation time = 1 us", duration="4 ms",
               method="tolerance = 1e-4", length=21)  # fmt: skip
    found = ran(text)
    assert {change.method for change in found.outcome.statistics.changes} == {"dop853"}
    # So fast that the branch is a dashpot of 0.3 mN*s/m: a damped oscillator.
    gamma, omega = 3e-4 / (2 * 0.01), np.sqrt(100.0 / 0.01)
    exact = 1e-3 * np.exp(-gamma * found.time) * np.cos(omega * found.time)
    assert np.abs(found.extension - exact).max() < 1e-3 * 1e-3


def test_methods_of_second_order_keep_the_tolerance():
    text = rod(script="at 0 s: push bob with (0.1, 0, 0) N", duration="25 ms")
    exact = ran(text).extension
    for method in ("velocity verlet", "rkc2"):
        rough = ran(text.replace("tolerance = 1e-10", f"integrator is {method}"), balance=1e-4)
        assert np.abs(rough.extension - exact).max() < 1e-4 * np.abs(exact).max()


# --- runs ---

TORN = """language 1
tissue gum {{
  spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 1 g; breaking force = 0.12 N; {law}
  relaxing constant = 60 N/m; relaxation time = 30 ms
  yield force = 60 mN; yield viscosity = 4 N*s/m }}
body rod {{ mesh is explicit; tissue is gum; rupture is allowed }}
table nodes of rod in mm with columns "id x y" {{ 1 0 0; 2 10 0; 3 20 1; 4 30 0; 5 40 0 }}
table springs of rod with columns "a b" {{ 1 2; 2 3; 3 4; 4 5; 2 4 }}
set left = nodes of rod in [1]
set right = nodes of rod in [5]
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{
  at 0 s: fix left
  from 0.02 s to 0.2 s: move right by (14, 0, 0) mm using smooth profile
  at 60 ms: change relaxation time of rod by 50 %
  at 70 ms: change yield force of rod to 50 mN
}}
simulate {{ duration = 0.2 s; tolerance = {tolerance} }}
output {{ trajectory every 10 ms; tension of rod every 10 ms; energy every 10 ms
          plastic elongation of rod every 10 ms; force of right every 10 ms }}
"""


# A reference that is known well enough from the outset is solved once.
@pytest.mark.parametrize(
    ("law", "rtol"),
    [
        ("", 1e-12),
        ("viscous force of e and w = d * exp(20 * e / rest length) * w", 1e-10),
        pytest.param(
            "spring law is exponential { stiffening = 2 }", None, marks=pytest.mark.slow
        ),
    ],
    ids=["linear", "dashpots of elongation", "exponential"],
)
def test_the_reference_agrees_on_springs_that_yield_relax_and_tear(law, rtol):
    found = validated(TORN.format(law=law, tolerance="1e-6"), rtol=rtol)
    assert found.comparison.ruptures.run == found.comparison.ruptures.reference == 2
    assert found.comparison.ruptures.error < 1e-6
    assert found.verdict == "kept"
    assert quantity(found, "position").error < 1e-6
    assert quantity(found, "energy balance").error < 1e-6
    assert quantity(found, "force of right").error < 1e-5


def test_a_spring_that_relaxes_to_its_yield_force_takes_few_steps():
    """Drawn out and held it yields, and relaxes towards the force where that ends."""
    script = "from 0 s to 0.1 s: move bob by (4, 0, 0) mm using smooth profile"
    texts = (
        rod(memory=f"{STANDARD}; {PLASTIC}", script=script, duration="1 s", method=method)
        for method in ("tolerance = 1e-4", "tolerance = 1e-8")
    )
    few, many = (ran(text, balance=1e-3).outcome.statistics.accepted for text in texts)
    # Order 8: a tolerance 1e4 times finer needs steps 3.2 times as many, and some at corners.
    assert few < 300
    assert many < 4 * few


def test_the_branch_counts_when_a_spring_ruptures():
    limit = "; breaking force = 0.15 N"
    script = "from 0 s to 10 ms: move bob by (2, 0, 0) mm using constant speed"
    text = rod(memory=STANDARD + limit, script=script, body="; rupture is allowed")
    found = ran(text)
    (time,) = [t for t, h in found.outcome.logged_events if h.kind == "rupture"]
    # 0.15 N = v (c t + c1 τ (1 - exp(-t/τ))), by Newton's method; c alone would reach 0.2 N.
    t = 1e-3
    for _ in range(20):
        excess = 0.2 * (100.0 * t + 6.0 * (1.0 - np.exp(-t / 0.02))) - 0.15
        t -= excess / (0.2 * (100.0 + 300.0 * np.exp(-t / 0.02)))
    assert time == pytest.approx(t, rel=1e-9)
    assert (found.tension[found.time > time] == 0.0).all()
    stored = found.energies[found.time > time, 1]
    assert (stored == 0.0).all(), "a dead spring loses its branch"


def test_a_run_that_is_resumed_gives_the_same_bytes():
    compiled = compiled_scene(TORN.format(law="", tolerance="1e-5"))
    network, plan = compiled.network, compiled.plan
    whole, before, after = (MemoryRecording() for _ in range(3))
    run(network, plan, Recorder(network, plan, whole))
    calls = iter([False] * 9 + [True] * 1000)
    stopped = run(network, plan, Recorder(network, plan, before), interrupt=lambda: next(calls))
    assert stopped.kind == "interrupted"
    assert 0.07 <= stopped.state.time < 0.2  # after the changes
    resumed = run(network, plan, Recorder(network, plan, after), resume=before.state)
    assert resumed.kind == "done"
    one, two = whole.frame_arrays(), after.frame_arrays()
    for name in range(3):
        assert np.array_equal(one[name][-len(two[0]) :], two[name])
    later = after.log_arrays("plastic elongation of rod")[1]
    assert np.array_equal(
        whole.log_arrays("plastic elongation of rod")[1][-len(later) :], later
    )


def test_what_springs_remember_is_seen_nowhere(tmp_path):
    from tissuec.core.source import Source
    from tissuec.pipeline import compile_request, simulate
    from tissuec.results.info import summary
    from tissuec.results.trajectory import Trajectory
    from tissuec.scene.request import Request

    request = Request(Source("scene.tis", TORN.format(law="", tolerance="1e-4")))
    compiled, _ = compile_request(request)
    assert compiled.network.row_count > compiled.network.node_count == 5
    result = simulate(compiled, tmp_path / "a.vtkhdf", request=request)
    with Trajectory.open(result.path) as read:
        assert read.position.shape[1:] == (5, 3)
        assert summary(read)["network"]["nodes"] == 5
        saved = read.network.springs.inelastic
        assert np.array_equal(saved.constant, compiled.network.springs.inelastic.constant)
        assert np.array_equal(saved.slot, compiled.network.springs.inelastic.slot)


def test_scenes_without_memory_have_none():
    network = compiled_scene(rod(memory="")).network
    assert network.springs.inelastic is None
    assert network.internal_rows == slice(2, 2)


# --- settling ---


def test_settling_relaxes_branches_and_keeps_what_flowed():
    script = """from 0 s to 20 ms: move bob by (6, 0, 0) mm using constant speed
      at 50 ms: release bob
      at 50 ms: push bob with (0.1, 0, 0) N
      at 50 ms: settle"""
    found = ran(rod(memory=STANDARD + "; " + PLASTIC, script=script, viscosity="1 N*s/m"))
    after = found.time > 0.0501
    flow = found.flow[after][0]
    assert flow > 1e-4
    assert np.abs(found.flow[after] - flow).max() == 0.0
    assert found.extension[after] == pytest.approx(flow + 0.1 / 100.0, rel=1e-9)
    assert found.tension[after] == pytest.approx(0.1, rel=1e-9)


def test_the_reference_settles_at_the_same_place():
    script = """from 0 s to 20 ms: move bob by (6, 0, 0) mm using constant speed
      at 50 ms: release bob
      at 50 ms: push bob with (0.1, 0, 0) N
      at 50 ms: settle
      at 60 ms: stop pushing bob"""
    text = rod(memory=STANDARD + "; " + PLASTIC, script=script, method="tolerance = 1e-8")
    found = validated(text)
    assert found.verdict == "kept"
    assert quantity(found, "energy balance").error < 1e-8


def test_only_springs_of_what_settles_relax():
    net = make_net(
        [[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [3.0, 0, 0]], [[0, 1], [1, 2], [2, 3]],
        stiffness=8.0, rest=0.9,
    )  # fmt: skip
    state = start(remembering(net, constant=(10.0,), time=(0.02,)))
    state.holders["fix"] = np.array([0, 3])
    settle(state, np.isin(np.arange(state.network.node_count), [1]))
    memory = state.springs.inelastic
    q = memory.variables(flat(state.velocity))[0]
    assert q[2] == 0.0
    assert q[:2] == pytest.approx([0.1, 0.1])


# --- with friction ---

PRESSED = """language 1
tissue gum { spring constant = 60 N/m; viscosity = 20 mN*s/m; mass = 1 g
  relaxing constant = 90 N/m; relaxation time = 30 ms
  yield force = 30 mN; yield viscosity = 2 N*s/m }
body pad {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0, 10, 0) mm
                  columns = 3; rows = 3; diagonals is both }
  tissue is gum
}
set rim = nodes of pad where x < 0.1 mm or x > 9.9 mm
tool finger { kind is probe; radius = 3 mm; centre = (5, 5, 3.2) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only; friction = 0.4 }
script {
  at 0 s: fix rim
  from 0 s to 20 ms: move finger by (0.5, 0, -3) mm using smooth profile
}
simulate { duration = 25 ms; tolerance = 1e-4 }
output { trajectory every 5 ms; energy every 5 ms; force of finger every 5 ms }
"""


def test_springs_and_friction_remember_side_by_side():
    compiled = compiled_scene(PRESSED)
    network = compiled.network
    assert [part.name for part in network.internal] == ["friction", "springs"]
    friction, springs = (network.remembering(name) for name in ("friction", "springs"))
    assert len(friction) == 9
    assert springs[0] == friction[-1] + 1
    assert springs[-1] == network.row_count - 1
    assert len(springs) == np.ceil(2 * network.spring_count / 3)
    recorder = Recorder(network, compiled.plan, recording := MemoryRecording())
    assert run(network, compiled.plan, recorder).kind == "done"
    kinetic, elastic, gravity, work, lost, switched = recording.energy_arrays()[1].T
    open_by = kinetic + elastic + gravity - (work - lost + switched)
    assert np.abs(open_by - open_by[0]).max() < 1e-5 * work.max()
    assert lost[-1] > 0.01 * work[-1]


@pytest.mark.slow
def test_the_reference_agrees_on_springs_and_friction():
    found = validated(PRESSED)
    assert found.verdict == "kept"
    assert quantity(found, "energy balance").error < 1e-4


# --- orders ---


def test_changes_reach_what_springs_remember():
    net = remembering(
        make_net([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]], [[0, 1], [1, 2]]),
        constant=(10.0,), time=(0.02,),
    )  # fmt: skip
    state = start(net)
    groups = {"first": [0]}
    change = order("change relaxing constant", groups, of="first", to=4.0)
    change.apply(state, None)
    assert state.springs.inelastic.constant.tolist() == [[4.0, 10.0]]
    assert net.springs.inelastic.constant.tolist() == [[10.0, 10.0]]
    order("change relaxation time", groups, of="first", by=0.5).apply(state, None)
    assert state.springs.inelastic.time.tolist() == [[0.01, 0.02]]
    missing = order("change yield force", groups, of="first", to=4.0)
    expected = "1 spring of first has no yield force and yield viscosity at the start; "
    assert missing.flaw(net).startswith(expected)
