"""Measured facts of a net and the choice of an integrator that follows from them."""

import subprocess
import sys

import numpy as np
import pytest

import tissuec
from tests.engine.running import block, chain, pair, tube
from tissuec.compiler.prediction import predict
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.structs import replace
from tissuec.engine import method_choice
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.layout import FEW, SMALL, order_nodes
from tissuec.engine.method import Method
from tissuec.engine.method_choice import choose, measured_facts
from tissuec.engine.spring_runs import places_of
from tissuec.engine.stability import (
    damping_radius,
    may_be_overdamped,
    spectral_radius,
    sums_at_nodes,
)
from tissuec.mechanics.state import State


def never():
    return False


def start(net, fixed=(), drag=0.0):
    state = State.start(net, gravity=np.zeros(3), drag=drag)
    state.holders["fix"] = np.array(fixed, dtype=np.int64)
    return state


def dense_radius(state):
    """Return the root of the largest eigenvalue of M^-1 K, from a full matrix."""
    net = state.network
    count = net.node_count
    matrix = np.zeros((3 * count, 3 * count))
    for (a, b), c, rest in zip(
        net.springs.ends, state.springs.stiffness, state.springs.rest, strict=True
    ):
        r = net.position[b] - net.position[a]
        length = np.linalg.norm(r)
        u = r / length
        along = np.outer(u, u)
        k = c * along + max(0.0, c * (length - rest) / length) * (np.eye(3) - along)
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            matrix[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] += sign * k
    free = np.repeat(~state.held, 3)
    root = np.repeat(1.0 / np.sqrt(state.mass), 3)
    matrix = root[:, None] * matrix * root
    return np.sqrt(np.linalg.eigvalsh(matrix[np.ix_(free, free)])[-1])


@pytest.mark.parametrize(
    "net", [tube(), block(), chain(12), pair()], ids=["tube", "block", "chain", "pair"]
)
def test_spectral_radius_is_a_close_bound_from_above(net):
    state = start(net, fixed=[0])
    exact = dense_radius(state)
    assert exact <= spectral_radius(state) <= 1.06 * exact


def test_damping_radius_of_a_pair_is_known():
    assert damping_radius(start(pair(damping=3.0))) == pytest.approx(1.05 * 6.0)
    assert damping_radius(start(pair(), drag=2.0)) == pytest.approx(1.05 * 2.0)
    assert damping_radius(start(pair())) == 0.0


NETS = [tube(damping=0.3), block(damping=0.1), chain(12, damping=2.0), pair(damping=3.0)]


@pytest.mark.parametrize("net", NETS, ids=["tube", "block", "chain", "pair"])
@pytest.mark.parametrize("fixed", [(), (0,)])
def test_sums_at_nodes_bound_frequency_and_damping_ratio(net, fixed):
    state = start(net, fixed=fixed)
    sums, exact = sums_at_nodes(state), dense_radius(state)
    assert exact <= sums.fastest * (1.0 + 1e-14)
    # What is measured is up to a twentieth too large for either.
    ratio = damping_radius(state) / 1.05 / (2.0 * exact)
    assert 0.0 < ratio <= sums.damping_ratio
    assert may_be_overdamped(state, sums, 0.99 * ratio)
    assert not may_be_overdamped(state, sums, sums.damping_ratio)


def test_drag_is_not_in_the_sums():
    state = start(pair(), drag=2.0)
    assert may_be_overdamped(state, sums_at_nodes(state), 100.0)


@pytest.mark.parametrize("tolerance", [5e-2, 1e-4])
def test_rates_are_not_measured_where_sums_decide(tolerance, monkeypatch):
    def never_measured(state):
        raise AssertionError("measured")

    monkeypatch.setattr(method_choice, "measured_facts", never_measured)
    choose(start(pair()), Method("automatic", tolerance, None, 1.0), never)
    with pytest.raises(AssertionError, match="measured"):
        choose(start(pair(damping=100.0)), Method("automatic", 5e-2, None, 1.0), never)
    with pytest.raises(AssertionError, match="measured"):
        choose(start(pair()), Method("automatic", 1e-4, None, 1e3), never)


@pytest.mark.parametrize(
    ("tolerance", "damping", "name"),
    [
        (5e-2, 0.0, "velocity verlet"),
        (1e-4, 0.0, "dop853"),
        (5e-2, 100.0, "dop853"),
        (None, 0.0, "dop853"),
    ],
)
def test_automatic_chooses_by_tolerance_and_damping_and_says_why(tolerance, damping, name):
    method = Method("automatic", tolerance, None, 1.0)
    choice = choose(start(pair(damping=damping)), method, never)
    assert choice.name == name
    assert choice == choose(start(pair(damping=damping)), method, never)
    assert len(choice.reason) > 20


@pytest.mark.parametrize(
    ("count", "tolerance", "damping", "radians", "name"),
    [
        (5000, None, 1.0, 100.0, "rkn4"),
        (5000, 1e-5, 1.0, 100.0, "rkn4"),
        (5000, 5e-6, 1.0, 100.0, "dop853"),  # order 8 pays
        (5000, 5e-6, 1.0, 2000.0, "rkn4"),  # its steps would not be stable
        (5000, 5e-7, 1.0, 2000.0, "dop853"),
        (4998, None, 1.0, 100.0, "dop853"),  # each step costs more than its forces
        (5000, None, 30.0, 100.0, "dop853"),  # damping limits the steps
        (5000, 0.1, 1.0, 100.0, "rkn4"),
        (5000, 0.1, 2.7, 100.0, "velocity verlet"),
        (4998, 0.1, 1.0, 100.0, "velocity verlet"),
        (5000, 0.1, 1.0, 2000.0, "velocity verlet"),  # its steps are stable for longest
    ],
)
def test_automatic_takes_order_4_for_large_nets_at_usual_tolerances(
    count, tolerance, damping, radians, name
):
    net = chain(count - 1, stiffness=100.0, mass=0.1, damping=damping)
    assert net.spring_count == count
    # By the bound ω² ≤ 2 Σ c / m, two springs of 100 N/m at each node.
    method = Method("automatic", tolerance, None, radians / np.sqrt(2 * 200.0 / 0.1))
    assert choose(start(net), method, never).name == name


def test_creeping_net_of_narrow_band_begins_with_implicit_steps():
    creeping, method = start(pair(damping=1e3)), Method("automatic", 1e-4, None, 100.0)
    assert choose(creeping, method, lambda: True).name == "esdirk43"
    assert choose(creeping, method, never).name == "dop853"
    # Neither where few explicit steps do it, nor where the damped part hardly matters.
    assert choose(creeping, replace(method, duration=1e-3), lambda: True).name == "dop853"
    assert choose(start(pair(damping=0.1)), method, lambda: True).name == "dop853"


GEL = """language 1
tissue gel {{ Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = {delay} }}
body pad {{
  mesh is lattice {{ cell = 2 mm; box from (0, 0, 0) mm to (8, 8, 8) mm }}; tissue is gel
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = {duration} }}
"""


@pytest.mark.parametrize(
    ("delay", "duration", "name"),
    [("1 s", "1 s", "rkc2"), ("1 s", "1 us", "dop853"), ("0.1 ms", "1 s", "dop853")],
)
def test_elements_that_are_braked_for_long_are_stepped_by_a_stabilised_method(
    delay, duration, name
):
    state = state_at_start(tissuec.compile(GEL.format(delay=delay, duration=duration)))
    seconds = 1.0 if duration == "1 s" else 1e-6
    chosen = choose(state, Method("automatic", 1e-4, None, seconds), never)
    assert chosen.name == name
    assert ("overdamped" in chosen.reason) == (name == "rkc2")


def test_automatic_with_a_step_takes_what_is_stable_at_it():
    state, limit = start(pair()), 2.0 / spectral_radius(start(pair()))
    for step, name in ((0.5 * limit, "velocity verlet"), (1.5 * limit, "dop853")):
        assert choose(state, Method("automatic", None, step, 1.0), never).name == name


def test_nodes_of_large_nets_are_numbered_so_that_neighbours_are_near():
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(*[np.arange(16.0)] * 3, indexing="ij"), -1).reshape(-1, 3)
    shuffled = rng.permutation(grid)
    none = np.zeros((0, 2), dtype=np.int32)
    order = order_nodes(shuffled, none).order
    assert np.array_equal(np.sort(order), np.arange(len(grid)))
    jumps = np.linalg.norm(np.diff(shuffled[order], axis=0), axis=1)
    assert jumps.mean() < 1.6 < 5.0 < np.linalg.norm(np.diff(shuffled, axis=0), axis=1).mean()
    assert np.array_equal(order_nodes(grid[:SMALL], none).order, np.arange(SMALL))


def test_nodes_whose_springs_lie_in_runs_keep_their_places():
    """A lattice is in good order as it is drawn; runs would be lost in any other."""
    grid = np.stack(np.meshgrid(*[np.arange(16.0)] * 3, indexing="ij"), -1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape(16, 16, 16)
    ends = np.stack([number[:, :, :-1].ravel(), number[:, :, 1:].ravel()], axis=1)
    assert np.array_equal(order_nodes(grid, ends).order, np.arange(len(grid)))


def tube(rings, sides):
    """Return the springs along a tube, around it and across, whose nodes go ring by ring."""
    number = np.arange(rings * sides).reshape(rings, sides)
    along = number[:-1], number[1:]
    around = number, np.roll(number, -1, axis=1)
    across = number[:-1], np.roll(number[1:], -1, axis=1)
    pairs = [np.stack([a.ravel(), b.ravel()], axis=1) for a, b in (along, around, across)]
    return np.concatenate(pairs).astype(np.int32)


def test_nodes_of_a_small_tube_are_numbered_so_that_runs_have_few_gaps():
    ends, count = tube(rings=16, sides=10), 160
    order = order_nodes(np.zeros((count, 3)), ends).order
    assert np.array_equal(np.sort(order), np.arange(count))
    place = np.argsort(order)
    drawn = places_of(*np.sort(ends, axis=1).T)
    found = places_of(*np.sort(place[ends], axis=1).T)
    # Along the tube, a gap comes after 15 springs; around it, the last side has longer ones.
    assert found.size <= 16 / 15 * len(ends) < drawn.size
    assert found.cost < drawn.cost


def test_springs_to_nodes_of_tools_change_no_order():
    ends, count = tube(rings=16, sides=10), 160
    order, runs = order_nodes(np.zeros((count, 3)), ends)
    more = np.append(ends, [[3, count + 7]], axis=0).astype(np.int32)
    found = order_nodes(np.zeros((count, 3)), more)
    assert np.array_equal(found.order, order)
    assert found.runs is not None and runs is not None


def test_nodes_of_a_large_tube_keep_their_places():
    ends, count = tube(rings=FEW // 10 + 1, sides=10), FEW + 10
    assert np.array_equal(order_nodes(np.zeros((count, 3)), ends).order, np.arange(count))


def test_nodes_of_a_small_net_in_runs_without_gaps_keep_their_places():
    ends = tube(rings=10, sides=16)[: 9 * 16]  # along it only
    assert np.array_equal(order_nodes(np.zeros((160, 3)), ends).order, np.arange(160))


def test_runs_import_no_compiler():
    code = (
        "import sys, numpy as np\n"
        "from tests.engine.running import lifted_tube\n"
        "ran = lifted_tube(0.1, tolerance=1e-4).run()\n"
        "assert ran.end.kind == 'reached'\n"
        "print([name for name in ('numba', 'scipy', 'h5py') if name in sys.modules])\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"


#: Springs that relax, in a viscous surrounding, held for minutes.
TENDON = """language 1
tissue tendon { spring constant = 20 kN/m; viscosity = 0 N*s/m; mass = 1 g
  relaxing constant = 10 kN/m; relaxation time = 30 s }
body strand { tissue is tendon
  mesh is thread { line from (0, 0, 0) mm to (50, 0, 0) mm; pieces = 10; thickness = 2 mm }
}
environment { gravity = (0, 0, 0) m/s^2; damping = 100 N*s/m }
simulate { duration = 300 s; tolerance = 1e-3 }
"""
#: A wall of elements that bends and creeps, with a calcified part.
CALCIFIED = """language 1
tissue wall { Young's modulus = 500 kPa; density = 1100 kg/m^3; retardation time = 2 ms }
tissue plaque like wall { Young's modulus = 300 MPa }
body artery {
  mesh is tube { axis from (0, 0, 0) mm to (10, 0, 0) mm; radius = 3 mm; rings = 6; sides = 8 }
  tissue is wall; thickness = 0.8 mm
  region lime where x between 3 mm and 7 mm and z > 1 mm { tissue is plaque }
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 20 ms; tolerance = 1e-3 }
"""
BENT = """language 1
tissue skin { Young's modulus = 10 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3
  retardation time = 20 ms }
body flap { tissue is skin; thickness = 1 mm
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (0, 0, 40) mm
    second edge = (40, 0, 0) mm; columns = 15; rows = 15 }
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 2 s; tolerance = 1e-3 }
"""
FILLED = """language 1
tissue parenchyma { Young's modulus = 5 kPa; Poisson's ratio = 0.45; density = 1060 kg/m^3
  retardation time = 50 ms }
body liver { tissue is parenchyma
  mesh is imported { file "meshes/liver.obj" in mm; filling is tetrahedra; cell = 20 mm }
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = DURATION; tolerance = 1e-3 }
"""


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (TENDON, "esdirk43"),
        (CALCIFIED, "esdirk43"),
        (BENT, "esdirk43"),
        (FILLED.replace("DURATION", "1.2 s"), "esdirk43"),
        (FILLED.replace("DURATION", "2 ms"), "rkc2"),
        (GEL.format(delay="1 s", duration="5 ms"), "rkc2"),  # too short for matrices
        (GEL.format(delay="20 ms", duration="2 s"), "esdirk43"),
    ],
)
def test_overdamped_scenes_begin_with_what_costs_less(text, name):
    chosen = predict(tissuec.compile(text))
    assert chosen.method == name
    assert "overdamped" in chosen.reason


def test_stages_are_counted_for_the_longest_steps_of_a_stabilised_method():
    """Where springs limit its steps, a long hold takes many of them."""
    compiled = tissuec.compile(TENDON)
    facts = measured_facts(state_at_start(compiled))
    assert 300.0 / INTEGRATORS["rkc2"].stability_limit(facts["omega"], facts["zeta"]) > 1e5
    # For as long as the common number of steps covers it, the stabilised method remains.
    short = TENDON.replace("duration = 300 s", "duration = 0.1 s")
    assert predict(tissuec.compile(short)).method == "rkc2"
