"""Bending springs: which there are, what they are made of, and what they do in closed form."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.engine.running import EVERLASTING
from tests.hand_net import span
from tests.validate.scenes import compiled_scene
from tissuec.compiler.checks.nets import floppy
from tissuec.engine.execution.recorder import wishes
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.mechanics import observables
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.meshes.generators import MESHES
from tissuec.meshes.generators.joining import across_edges

FRAME = """language 1
tissue gum {{ spring constant = {constant}; viscosity = 0.01 N*s/m; mass = 10 mg; {tissue} }}
body part {{ mesh is {mesh}; tissue is gum; {body} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
output {{ trajectory every 1 ms }}
"""
TUBE = (
    "tube {{ axis from (0, 0, 0) mm to (64, 0, 0) mm; radius = 3 mm; rings = {}; sides = {}; "
    "diagonals is both }}"
)
STRIP = (
    "sheet { corner = (0, 0, 0) mm; first edge = (8, 0, 0) mm; second edge = (0, 1, 0) mm; "
    "columns = 9; rows = 2; diagonals is both }"
)
SPHERE = "sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }"


def scene(mesh=STRIP, body="bending = 20 %", constant="40 N/m", tissue=""):
    return FRAME.format(mesh=mesh, body=body, constant=constant, tissue=tissue)


def network(*arguments, **more):
    return compiled_scene(scene(*arguments, **more)).network


def start(net):
    return State.start(net, gravity=np.zeros(3), drag=0.0)


# --- which there are ------------------------------------------------------------------------


def test_without_a_word_the_published_tube_keeps_its_610_springs():
    for body in ("", "bending is none", "bending = 0 %"):
        net = network(TUBE.format(16, 10), body)
        assert (net.spring_count, int(net.bends.sum())) == (610, 0)


def test_bending_springs_come_last_and_reach_two_steps():
    plain, bent = network(TUBE.format(16, 10), ""), network(TUBE.format(16, 10))
    assert np.array_equal(bent.springs.ends[:610], plain.springs.ends)
    assert np.array_equal(bent.springs.ids, np.arange(1, 911))
    assert np.array_equal(bent.bends, np.arange(910) >= 610)
    rings, sides = np.divmod(bent.springs.ends[610:].astype(int), 10)
    down = rings[:, 1] - rings[:, 0]
    beside = np.minimum((sides[:, 1] - sides[:, 0]) % 10, (sides[:, 0] - sides[:, 1]) % 10)
    assert sorted(set(zip(down.tolist(), beside.tolist(), strict=True))) == [(0, 2), (2, 0)]
    assert (np.count_nonzero(down == 0), np.count_nonzero(down == 2)) == (160, 140)


def test_on_a_skin_of_triangles_they_cross_every_edge_once():
    net = network(SPHERE)
    # Each edge of a closed surface has two triangles, and no two nodes lie across two edges.
    assert int(net.bends.sum()) == 120
    assert (
        np.bincount(net.springs.ends[net.bends].ravel())
        == np.bincount(net.springs.ends[:120].ravel())
    ).all()


@pytest.mark.parametrize("sides", [3, 4, 5])
def test_no_spring_is_doubled_in_narrow_tubes(sides):
    net = network(TUBE.format(4, sides))
    assert len(np.unique(np.sort(net.springs.ends, axis=1), axis=0)) == net.spring_count
    # Two steps round three sides lead to a neighbour, and round four meet from both hands.
    assert int(net.bends.sum()) == {3: 0, 4: 8, 5: 20}[sides] + 2 * sides


def test_edges_on_the_rim_have_nobody_across():
    skin = MESHES["sheet"](
        corner=np.zeros(3), first_edge=np.array([1.0, 0, 0]), second_edge=np.array([0, 1.0, 0]),
        columns=2, rows=2,
    ).build().skin  # fmt: skip
    ((one, other),) = across_edges(skin).tolist()
    assert {one, other} == {1, 2}


def test_sets_can_choose_them_and_frames_leave_them_out():
    sets = "set hinges = springs of part where bending\n"
    sets += "set rest = springs of part where not bending"
    text = scene().replace("environment", f"{sets}\nenvironment")
    compiled = compiled_scene(text)
    net = compiled.network
    found = [compiled.groups.sets.find(name).indices for name in ("hinges", "rest")]
    assert np.array_equal(found[0], np.flatnonzero(net.bends))
    assert np.array_equal(found[1], np.flatnonzero(~net.bends))
    assert np.array_equal(wishes(net, compiled.plan).lines, np.flatnonzero(~net.bends))


# --- what they are made of ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "part"),
    [("bending is soft", 0.05), ("bending is medium", 0.2), ("bending is stiff", 1.0),
     ("bending = 3 %", 0.03)],
)  # fmt: skip
def test_they_are_a_part_as_stiff_as_springs_of_the_tissue(body, part):
    net = network(body=body, tissue="prestress = 4 %; spring law is toe { strain = 3 % }")
    drawn = np.linalg.norm(np.subtract(*net.position[net.springs.ends.T]), axis=1)
    assert net.springs.stiffness[net.bends] == pytest.approx(40.0 * part)
    assert net.springs.damping[net.bends] == pytest.approx(0.01 * part)
    assert net.springs.rest == pytest.approx(0.96 * drawn)
    assert (net.springs.law == np.where(net.bends, 0, 1)).all()
    assert net.provenance["stiffness"][net.spring_count - 1].how == "bending"


def test_of_a_constant_for_a_length_they_take_that_of_their_own():
    net = network(constant="40 N/m per 1 mm")
    assert net.springs.stiffness[net.bends] == pytest.approx(0.2 * 40.0 / 2.0)


@pytest.mark.parametrize("constant", ["40 N/m", "40 N/m per 1 mm"])
def test_a_chain_that_is_stretched_evenly_breaks_all_over_at_one_strain(constant):
    mesh = STRIP.replace("; diagonals is both", "").replace("(0, 1, 0)", "(0, 1e-3, 0)")
    net = network(mesh, "bending = 20 %; rupture is allowed", constant,
                  "breaking force = 1 N; crushing force = 2 N")  # fmt: skip
    along = np.abs(np.subtract(*net.position[net.springs.ends.T])[:, 0]) > 0.5e-3
    inner = np.abs(net.position[net.springs.ends, 0] - 4e-3).max(axis=1) < 3.5e-3
    for limit in (net.springs.strength, net.springs.crush):
        strain = limit / (net.springs.stiffness * net.springs.rest)
        own, bent = (strain[along & inner & side] for side in (~net.bends, net.bends))
        # The thin springs across count among the neighbours: a third of them, of no length.
        share = 1.5 if constant == "40 N/m" else 1.0
        assert bent == pytest.approx(share * own[0], rel=2e-3)


# --- what they do ---------------------------------------------------------------------------


def ovalisation(sides, part=1e-5):
    """Return the stiffness of a ring's softest deformation, and what theory makes of it."""
    net = network(TUBE.format(2, sides), f"bending = {part}")
    state = start(net)
    balance = Balance(state, np.ones(net.node_count, dtype=bool))
    matrix = balance.matrix(balance.bars(balance.start), exact=True).toarray()
    # Both rings alike and in their planes, so that nothing between them is strained.
    both = np.kron(np.vstack([np.eye(sides)] * 2), np.eye(3)[:, 1:]) / np.sqrt(2.0)
    values = np.linalg.eigvalsh(both.T @ matrix @ both)
    radius, hinge = 3e-3, np.sin(np.pi / sides)
    side = 2.0 * radius * hinge
    bending = 40.0 * part * side**3 * hinge**2  # EI: the hinges' moment by curvature
    # Love's inextensional ring, n = 2: m w² = EI l / R⁴ n² (n² - 1)² / (n² + 1).
    return values, bending * side / radius**4 * 36.0 / 5.0


def test_a_ring_of_hinges_resists_ovalisation_as_a_thin_ring_does():
    wrong = []
    # Links a hundred thousand times as stiff: what they give way is below these errors.
    for sides in (12, 24, 48):
        values, expected = ovalisation(sides)
        assert np.abs(values[:3]).max() < 1e-5 * expected  # it moves and turns freely
        assert values[3] == pytest.approx(values[4], rel=1e-6)
        wrong.append(abs(values[3] / expected - 1.0))
    assert wrong[2] < 0.006
    assert np.log2(wrong[0] / wrong[1]) == pytest.approx(2.0, abs=0.05)
    assert np.log2(wrong[1] / wrong[2]) == pytest.approx(2.0, abs=0.05)


def rolled(net, angle):
    """Return the strip bent so that it turns by an angle at each column."""
    side = 1e-3
    turns = angle * (np.arange(8) - 0.5)
    x = np.concatenate([[0.0], np.cumsum(side * np.cos(turns))])
    z = np.concatenate([[0.0], np.cumsum(side * np.sin(turns))])
    position = net.position.copy()
    column = np.rint(net.position[:, 0] / side).astype(int)
    position[:, 0], position[:, 2] = x[column], z[column]
    return position


def test_energy_of_a_flat_strip_that_is_rolled_up():
    net = network()
    for angle in (0.5, 0.1):
        found = observables.elastic_energy(start(net), rolled(net, angle), net.velocity)
        shorter = 2e-3 * (1.0 - np.cos(angle / 2.0))
        # The diagonals of its cells lie in one plane each and are not strained.
        assert found == pytest.approx(2 * 7 * 0.5 * 8.0 * shorter**2, rel=1e-9)
    small = [
        observables.elastic_energy(start(net), rolled(net, a), net.velocity)
        for a in (0.02, 0.01)
    ]
    assert small[0] / small[1] == pytest.approx(16.0, rel=1e-3)


def test_a_cantilever_hangs_as_one_of_stiff_links_and_hinges():
    part, force, side = 1e-4, 2e-8, 1e-3

    def energy(angles):
        turns = np.cumsum(angles)
        hinges = 0.5 * 40.0 * part * (2.0 * side * (1.0 - np.cos(angles / 2.0))) ** 2
        return 1e12 * (hinges.sum() - force * side * np.sin(turns).sum())

    expected = minimize(energy, np.full(7, 0.1), method="BFGS", options={"gtol": 1e-6}).x
    net = network(body=f"bending = {part}")
    state = start(net)
    state.holders["fix"] = np.flatnonzero(net.position[:, 0] < 1.5e-3)
    state.position[:, 2] = np.maximum(net.position[:, 0] - 1e-3, 0.0) * 0.1
    tip = np.flatnonzero(net.position[:, 0] > 7.5e-3)
    pull = LoadTerm(np.array([0.0, 0.0, force]), EVERLASTING)
    state.loads["push"] = Load(tip, (pull,), span())
    settle(state, np.ones(net.node_count, dtype=bool))
    found = state.position[tip, 2]
    high = side * np.sin(np.cumsum(expected)).sum()
    assert high > 0.3 * 7 * side
    # Links give way by a few parts in a thousand of what hinges do.
    assert found == pytest.approx(high, rel=3e-3)


def test_a_shell_without_springs_inside_is_floppy_no_more():
    mesh = TUBE.format(6, 8).replace("; diagonals is both", "; diagonals is one")
    said = [list(floppy(compiled_scene(scene(mesh, body)))) for body in ("", "bending is soft")]
    assert [finding.code for finding in said[0]] == ["W303"]
    assert said[1] == []


def test_springs_between_all_second_neighbours_leave_nothing_to_add():
    tetrahedron = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], dtype=np.int32)
    pairs = {tuple(sorted(pair)) for pair in across_edges(tetrahedron).tolist()}
    assert pairs == set(combinations(range(4), 2))
