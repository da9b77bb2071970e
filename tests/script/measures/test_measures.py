"""Measures against numbers worked out by hand."""

import numpy as np
import pytest

import tissuec
from tests.hand_net import chain, make_net, start
from tissuec.core.structs import replace
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.positions import FEW, smallest_gaps
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot

NOTHING = np.zeros(0, dtype=np.int64)


def nodes(*numbers, network=None):
    found = np.array(numbers, dtype=np.int64)
    springs = (
        NOTHING
        if network is None
        else np.flatnonzero(np.isin(network.springs.ends, found).all(axis=1))
    )
    return Subject("some nodes", found, springs)


def springs(*numbers):
    return Subject("some springs", NOTHING, np.array(numbers, dtype=np.int64), is_springs=True)


def tool(name):
    return Subject(name, None, NOTHING)


def sample(name, snapshot, *subjects):
    return MEASURES[name].sample(subjects, snapshot)


def value(name, snapshot, *subjects):
    return MEASURES[name].value(sample(name, snapshot, *subjects))


@pytest.fixture
def snapshot():
    """A chain of four, spread to x = 0, 2, 3, 5: the springs are stretched by 1, 0 and 1."""
    network = chain(4, mass=[1, 2, 3, 4], stiffness=[10, 20, 30], damping=[0, 0, 2])
    state = start(network)
    state.position[:, 0] = [0, 2, 3, 5]
    state.velocity[3] = (1.0, 0.0, 2.0)
    state.holders["forceps"] = np.array([2, 3])
    return Snapshot.of(state)


def test_nodes_of_sets_and_of_grips_are_counted(snapshot):
    assert value("nodes", snapshot, nodes(0, 1, 3)) == 3
    assert value("nodes", snapshot, tool("forceps")) == 2
    assert value("nodes", snapshot, tool("empty")) == 0


def test_only_springs_that_are_left_are_counted(snapshot):
    snapshot.state.alive = np.array([True, False, True])
    assert value("springs", snapshot, springs(0, 1)) == 1
    assert value("springs", snapshot, tool("forceps")) == 1


def test_pieces_are_counted_through_the_whole_net(snapshot):
    assert value("pieces", snapshot, nodes(0, 3)) == 1
    snapshot.state.alive = np.array([True, False, True])
    whole = Snapshot.of(snapshot.state)
    assert value("pieces", whole, nodes(0, 3)) == 2
    assert value("pieces", whole, nodes(0, 1)) == 1


def test_the_support_force_is_minus_the_pull_of_the_springs(snapshot):
    # Spring 2 pulls node 3 back with c e + d w = 30 · 1 + 2 · 1 = 32.
    assert sample("force", snapshot, nodes(3)).tolist() == [32.0, 0.0, 0.0]
    assert value("force", snapshot, nodes(3)) == 32.0
    # Inside the grip springs cancel; spring 1 is at rest.
    assert sample("force", snapshot, tool("forceps")) == pytest.approx(np.zeros(3))
    # On nodes 1 and 2 together spring 0 pulls with -10 and spring 2 with 32.
    assert sample("force", snapshot, nodes(1, 2)).tolist() == [-22.0, 0.0, 0.0]
    assert MEASURES["force"].columns((), snapshot) == ("x", "y", "z")


def test_the_support_torque_is_that_of_the_forces_of_springs_about_the_middle():
    # A bar of nodes 1 and 2 along x; springs to nodes 0 and 3 pull its ends up and down.
    network = make_net(
        [(0, 0, 3), (0, 0, 0), (2, 0, 0), (2, 0, -4)], [(0, 1), (1, 2), (2, 3)],
        stiffness=[10, 50, 20], rest=[2.0, 1.0, 3.0],
    )  # fmt: skip
    still = Snapshot.of(start(network))
    bar = nodes(1, 2)
    # Forces on it: (0, 0, 10) at x = -1 and (0, 0, -20) at x = 1 about its middle.
    assert sample("force", still, bar).tolist() == [0.0, 0.0, 10.0]
    assert sample("torque", still, bar) == pytest.approx([0.0, -30.0, 0.0])
    assert value("torque", still, bar) == pytest.approx(30.0)
    assert sample("torque", still, tool("empty")).tolist() == [0.0, 0.0, 0.0]


def test_the_force_on_an_empty_grip_is_none(snapshot):
    assert sample("force", snapshot, tool("empty")).tolist() == [0, 0, 0]


def test_length_strain_and_tension_are_those_of_live_springs(snapshot):
    assert value("length", snapshot, springs(0, 1, 2)) == 5.0
    assert value("strain", snapshot, springs(0, 1, 2)) == 1.0
    assert sample("tension", snapshot, springs(0, 1, 2)).tolist() == [10.0, 0.0, 32.0]
    assert value("tension", snapshot, springs(0, 1, 2)) == 32.0
    assert MEASURES["tension"].columns((springs(0, 2),), snapshot) == (
        "spring 500",
        "spring 502",
    )
    snapshot.state.alive = np.array([False, True, True])
    assert value("length", snapshot, springs(0, 1, 2)) == 3.0
    assert sample("tension", snapshot, springs(0)).tolist() == [0.0]
    assert value("strain", snapshot, springs(0, 1)) == 0.0


def test_strain_counts_compression_and_passes_over_rest_lengths_of_zero():
    state = start(chain(3, rest=[4.0, 0.0]))
    assert value("strain", Snapshot.of(state), springs(0, 1)) == 0.75


def test_place_distance_and_speed(snapshot):
    assert sample("position", snapshot, nodes(1, 3)).tolist() == [3.5, 0, 0]
    assert value("distance", snapshot, nodes(0, 1), tool("forceps")) == 3.0
    assert value("speed", snapshot, nodes(0, 1, 2, 3)) == pytest.approx(np.sqrt(5))
    assert value("speed", snapshot, tool("empty")) == 0.0
    assert np.isnan(value("distance", snapshot, nodes(0), tool("empty")))


def test_energies_are_of_free_nodes_and_live_springs(snapshot):
    network = snapshot.state.network
    assert value("elastic energy", snapshot, springs(0, 1, 2)) == 20.0
    assert value("kinetic energy", snapshot, nodes(2, 3)) == 0.0  # both are held
    snapshot.state.holders.clear()
    everything = nodes(0, 1, 2, 3, network=network)
    assert value("kinetic energy", Snapshot.of(snapshot.state), everything) == 0.5 * 4 * 5
    assert value("energy", Snapshot.of(snapshot.state), everything) == 30.0


def test_ruptured_counts_springs_that_broke_by_themselves(snapshot):
    broken = replace(snapshot, ruptured=np.array([True, False, True]))
    assert value("ruptured", broken, springs(0, 1, 2)) == 2
    assert value("ruptured", broken, springs(1)) == 0


def test_energy_drift_is_what_is_missing_over_the_largest_energy(snapshot):
    snapshot.state.holders.clear()
    energy = 30.0
    ledger = EnergyBalance(initial=10.0, work=25.0, dissipated=3.0, switched=-4.0, scale=50.0)
    drift = value("energy drift", replace(snapshot, ledger=ledger))
    assert drift == pytest.approx(abs(energy - (10 + 25 - 3 - 4)) / 50)
    assert value("energy drift", replace(snapshot, ledger=EnergyBalance())) == 0.0
    with pytest.raises(ValueError, match="not integrated"):
        value("energy drift", snapshot)


def test_the_gap_is_the_smallest_distance_between_pieces_and_none_for_one_piece():
    position = [(0, 0, 0), (1, 0, 0), (1, 3, 4), (2, 3, 4), (50, 0, 0)]
    network = make_net(position, [(0, 1), (2, 3)])
    snapshot = Snapshot.of(start(network))
    assert value("gap", snapshot, nodes(0, 1, 2, 3, 4)) == 5.0
    assert value("gap", snapshot, nodes(0, 1)) == 0.0
    assert value("gap", snapshot, nodes(0, 4)) == 50.0


@pytest.mark.parametrize("count", [3, 65, FEW, FEW + 1, 1000])
def test_the_gap_is_found_whatever_the_order_of_the_nodes(count):
    random = np.random.default_rng(count)
    position = random.normal(size=(count, 3)) * [1, 20, 1]
    piece = random.integers(0, 3, count).astype(np.int32)
    piece[:2] = [0, 1]
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    expected = apart[piece[:, None] != piece[None]].min()
    states = np.stack([position, 2.0 * position])
    assert smallest_gaps(states, piece) == pytest.approx([expected, 2.0 * expected], rel=1e-14)


@pytest.mark.parametrize("name", sorted(MEASURES))
def test_a_batch_of_snapshots_gives_what_each_of_them_gives(name):
    network = chain(5, stiffness=3.0, damping=0.5)
    state = start(network, gravity=(0, 0, -9.81))
    state.alive = np.array([True, False, True, True])
    random = np.random.default_rng(4)
    motion = random.normal(size=(3, 5, 3)), random.normal(size=(3, 5, 3))
    ledger = EnergyBalance(
        1.0, np.array([1.0, 2, 3]), np.array([0.5, 1, 2]), 0.3, np.array([4.0, 5, 6])
    )
    ruptured = np.zeros(4, dtype=bool)
    batch = Snapshot(state, np.array([1.0, 2, 3]), *motion, ruptured, ledger)
    everything = nodes(*range(5), network=network)
    subjects = (everything, nodes(1, 2))[: MEASURES[name].subjects]
    rows = MEASURES[name].sample(subjects, batch)
    assert rows.shape == (3, len(MEASURES[name].columns(subjects, batch)))
    for number in range(3):
        single = MEASURES[name].sample(subjects, batch.pick(number))
        value = MEASURES[name].value(single)
        assert value.shape == () and value == MEASURES[name].value(rows)[number]
        assert rows[number] == pytest.approx(single, rel=1e-14)
    assert np.array_equal(
        MEASURES[name].sample(subjects, batch.pick(np.array([0, 2]))), rows[[0, 2]]
    )


@pytest.mark.parametrize("name", sorted(MEASURES))
def test_a_measure_of_nothing_has_its_columns(name):
    # As of a tool before it grasps: positions are not numbers then, and sums are 0.
    network = chain(5, stiffness=3.0, damping=0.5)
    still = np.zeros((5, 3))
    ledger = EnergyBalance(1.0, 1.0, 0.5, 0.3, 4.0)
    snapshot = Snapshot(
        start(network, gravity=(0, 0, -9.81)), 1.0, still, still, np.zeros(4, bool), ledger
    )
    subjects = (nodes(network=network), nodes(network=network))[: MEASURES[name].subjects]
    found = MEASURES[name].sample(subjects, snapshot)
    assert found.shape == (len(MEASURES[name].columns(subjects, snapshot)),)
    assert MEASURES[name].value(found).shape == ()


@pytest.mark.parametrize("name", sorted(MEASURES))
def test_every_measure_says_how_it_is_written_and_what_it_is(name):
    measure = MEASURES[name]
    assert measure.__doc__
    assert measure.takes in (
        "nodes", "springs", "any", "body", "solid", "cut faces", "jaws"
    )  # fmt: skip
    assert name in measure.form
    assert measure.form.count(",") == max(measure.subjects - 1, 0)


def rope_that_is_fixed_when(condition):
    return f"""language 1
    tissue cord {{ mass = 1 g; viscosity = 1 mN*s/m; spring constant = 50 N/m; yield force = 1 N
      yield viscosity = 1 N*s/m; breaking force = 5 N }}
    body rope {{ mesh is thread {{ line from (0, 0, 0) mm to (50, 0, 0) mm; pieces = 5
      thickness = 1 mm }}; tissue is cord; rupture is allowed }}
    environment {{ gravity = (0, 0, 0) m/s^2 }}
    simulate {{ duration = 1 ms }}
    script {{ when {condition}: fix rope }}
    """


def test_counts_are_conditions_by_themselves():
    tissuec.compile(rope_that_is_fixed_when("ruptured(rope)"))


@pytest.mark.parametrize("name", ["tension", "plastic elongation", "strain"])
def test_other_measures_are_not_conditions_by_themselves(name):
    with pytest.raises(tissuec.CompileError, match="is not a condition"):
        tissuec.compile(rope_that_is_fixed_when(f"{name}(rope)"))


WALL_AND_BLOCK = """
language 1
tissue gel {
  Young's modulus = 20 kPa; Poisson's ratio = 0.4; density = 1000 kg/m^3
  retardation time = 1 ms; relaxing share = 50 %; relaxation time = 20 ms
}
tissue spring { spring constant = 20 N/m; viscosity = 10 mN*s/m; mass = 10 mg }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }
  tissue is gel; velocity = (0, 0, 1) m/s; spin = (0, 40, 0) rad/s
}
set half = nodes of block where x < 5.1 mm
set other = nodes of block where x > 4.9 mm
body wall {
  mesh is sheet {
    corner = (0, 20, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 5; rows = 3
  }
  tissue is gel; thickness = 2 mm; made of elements; spin = (0, 60, 10) rad/s
}
joint tie { springs from block to wall; reach = 21 mm; tissue is spring }
set edge = nodes of wall where x < 5.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix edge
  at 5 ms: cut block along plane through (7.5, 0, 0) mm facing (1, 0, 0)
}
simulate { duration = 10 ms }
output {
  elastic energy(block) every 1 ms; elastic energy(half) every 1 ms
  elastic energy(other) every 1 ms; elastic energy(wall) every 1 ms
  elastic energy(tie) every 1 ms; energy(wall) every 1 ms
  kinetic energy(wall) every 1 ms; energy every 1 ms
}
"""


def test_energies_of_bodies_of_elements_add_up_to_that_of_the_scene():
    with tissuec.run(WALL_AND_BLOCK, companion="off") as run:
        logs = {name: log.value[:, 0] for name, log in run.logs.items()}
        block, wall, tie = (
            logs[f"elastic energy of {name}"] for name in ("block", "wall", "tie")
        )
        total = run.energies.value[:, 1]
    assert np.allclose(block + wall + tie, total, rtol=1e-12, atol=1e-18)
    assert min(part[1:].min() for part in (block, wall, tie)) > 1e-9
    halves = logs["elastic energy of half"] + logs["elastic energy of other"]
    assert np.allclose(block, halves, rtol=1e-12, atol=1e-18)
    assert np.allclose(logs["energy of wall"], wall + logs["kinetic energy of wall"])
