"""Meshes that are tied: the patch test, bending, conserved quantities, SciPy's solution."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.glue.blocks import CROSSED, TIED, WHOLE, glued, on_box, standing
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import same_when_resumed
from tissuec.engine.unknowns import joined_nodes
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.observables import inner_forces
from tissuec.mechanics.settling import settle

PULLED = "at 0 s: fix left; from 0 s to 1 s: move right by ({}) mm using constant speed"
GRADIENTS = {
    "tension": [[0.02, 0, 0], [0, -0.005, 0], [0, 0, -0.005]],
    "shear": [[0, 0.03, 0], [0, 0, 0], [0, 0, 0]],
    "all": [[0.01, 0.02, -0.01], [0.005, -0.02, 0.015], [0.01, 0, 0.01]],
}


@pytest.mark.parametrize("load", GRADIENTS)
def test_a_tie_passes_the_patch_test(load):
    """Newton's method ends at forces of 1e-12 of the largest, and so at places as exact."""
    state = standing(glued())
    drawn = state.network.position
    even = drawn + drawn @ np.array(GRADIENTS[load]).T
    outer = on_box(drawn)
    state.holders["box"] = np.flatnonzero(outer)
    state.position[outer] = even[outer]
    assert (~outer & state.free).sum() > 20
    settle(state, np.ones(len(drawn), dtype=bool))
    assert np.abs(state.position - even).max() < 1e-12 * np.ptp(drawn)


def test_the_stiffness_of_a_tie_is_the_derivative_of_its_forces():
    """Central differences of smooth forces of some mN are exact to 1e-7 of the stiffness."""
    state = standing(glued())
    state.holders["left"] = np.flatnonzero(state.network.position[:, 0] < 1e-4)
    balance = Balance(state, np.ones(len(state.position), dtype=bool))
    rng = np.random.default_rng(0)
    x = balance.start + 2e-4 * rng.standard_normal(balance.start.shape)
    way, h = rng.standard_normal(x.shape), 1e-7
    after, before = (balance.force(balance.bars(x + s * h * way)) for s in (1.0, -1.0))
    found = balance.matrix(balance.bars(x), exact=True)(way.ravel())
    slope = (before - after).ravel() / (2.0 * h)
    assert np.abs(found - slope).max() < 1e-6 * np.abs(slope).max()


def last_force(text):
    return tissuec.run(text, companion="off").logs["force of right"].value[-1]


@pytest.mark.parametrize(
    ("way", "axis", "within"), [("0.4, 0, 0", 0, 1e-6), ("0, 0, 1", 2, 0.02)]
)
def test_a_tie_is_as_stiff_as_one_mesh(way, axis, within):
    """Stretch is uniform but for the square of strain; bending is that of both cells."""
    tied, whole = (
        last_force(glued(text, poisson=0, script=PULLED.format(way))) for text in (TIED, WHOLE)
    )
    assert tied[axis] == pytest.approx(whole[axis], rel=within)


FREE = {
    "lag": "0 s", "duration": "20 ms", "method": "tolerance = 1e-9; integrator is dop853",
    "motion": "spin = (3, 20, 10) rad/s; velocity = (0.1, 0.2, 0.3) m/s",
    "output": "trajectory every 2 ms; energy every 2 ms",
}  # fmt: skip


@pytest.mark.parametrize("cells", ["lie in one another", "cross"])
def test_momentum_angular_momentum_and_energy_of_a_free_tie_are_kept(cells):
    """At a tolerance of 1e-9 of the motion; its speed changes by some 1e-10 of itself."""
    text = glued(**FREE)
    text = text.replace(*CROSSED) if cells == "cross" else text
    run, state = tissuec.run(text, companion="off"), standing(text)
    mass = state.inertia[: len(state.mass)]
    x, v = run.position[:], run.velocity[:]
    momentum = np.einsum("n,fnk->fk", mass, v)
    turning = np.einsum("n,fnk->fk", mass, np.cross(x, v))
    kinetic, elastic, *_ = run.energies.value.T
    assert np.ptp(run.position[:, :, 0]) > 1e-3
    for kept in (momentum, turning, kinetic + elastic):
        assert np.abs(kept - kept[0]).max() < 1e-10 * np.abs(kept[0]).max()
    embedding = state.embedding
    for each in x:
        followed = each.copy()
        embedding.follow(followed)
        assert np.abs(followed - each).max() < 1e-15


def test_masses_are_shared_and_none_is_lost():
    state = standing(glued())
    assert state.inertia.sum() == pytest.approx(state.mass.sum(), rel=1e-14)
    assert (state.inertia[state.embedding.nodes] == 0.0).all()
    assert state.mass.sum() == pytest.approx(1000 * 40e-3 * 1e-4, rel=1e-12)


SMALL = {
    "gravity": "(0, 0, -9.81)", "duration": "10 ms", "script": "at 0 s: fix left",
    "method": "tolerance = 1e-6; integrator is {}",
    "output": "trajectory every 2 ms; force(left) every 1 ms; energy every 1 ms",
}  # fmt: skip


def small(method="dop853"):
    text = glued(**SMALL).replace("{}", method)
    for old, new in (
        ("(20, 10,", "(20, 5,"),
        ("10)", "5)"),
        ("(40, 10,", "(30, 5,"),
        ("39.9", "29.9"),
    ):
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("method", ["dop853", "velocity verlet", "trbdf2"])
def test_scipy_finds_the_same_motion(method):
    found = validated(small(method).replace("1e-6", "1e-4"))
    for name in ("position", "energy balance", "force of left"):
        assert quantity(found, name).error < 1e-4


def test_scipy_finds_the_same_equilibrium():
    script = "fix left; at 2 ms: settle"
    text = small().replace("fix left", script)
    found = validated(text)
    assert quantity(found, "position").error < 1e-6


@pytest.mark.parametrize("method", ["dop853", "rkc2", "trbdf2"])
def test_a_resumed_run_is_the_same_to_the_last_bit(method):
    same_when_resumed(compiled_scene(small(method)), "force of left", 2, 3)


def test_forces_on_embedded_nodes_are_on_their_hosts():
    state = standing(glued())
    rng = np.random.default_rng(1)
    x = state.position + 2e-4 * rng.standard_normal(state.position.shape)
    state.embedding.follow(x)
    force = inner_forces(state, 0.0, x, np.zeros_like(x)).node
    assert (force[state.embedding.nodes] == 0.0).all()
    largest = np.abs(force).max()
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * largest * len(x)
    assert np.abs(np.cross(x, force).sum(axis=0)).max() < 1e-12 * largest * 0.04 * len(x)


def test_the_force_on_glued_nodes_is_what_the_glue_carries():
    of = ["force(face)", "torque(face)", "position(face)"]
    of += [each.replace("face", "right") for each in of]
    text = glued(
        script=PULLED.format("0.4, 0, 0.3"),
        output="; ".join(f"{each} every 1 s" for each in of),
    )
    run = tissuec.run(text, companion="off")
    last = {name: log.value[-1] for name, log in run.logs.items()}
    pulled = last["force of right"]
    assert last["force of face"] == pytest.approx(-pulled, rel=1e-9)
    arm = last["position of right"] - last["position of face"]
    turning = last["torque of right"] + np.cross(arm, pulled)
    assert last["torque of face"] == pytest.approx(-turning, abs=1e-9 * np.abs(turning).max())


@pytest.mark.parametrize("load", ["gravity = (0, 0, -9.81)", "push right with (0, 0, 1) N"])
def test_a_body_that_is_glued_to_a_held_one_is_held(load):
    def loose(held):
        text = glued(script=f"at 0 s: fix {held}" if held else "", output="")
        if load.startswith("push"):
            text = text.replace("script {", f"script {{ at 0 s: {load}")
        else:
            text = text.replace("gravity = (0, 0, 0)", load)
        return [one.message for one in tissuec.check(text) if one.code == "W310"]

    assert not loose("left") and not loose("right")
    assert len(loose("")) == 1 and loose("")[0].startswith("nothing holds coarse and fine")


def test_nodes_that_matrices_couple_are_foreseen():
    """The pattern from which memory and time are predicted is that of K, in blocks of 3 × 3."""
    state = standing(glued())
    state.holders["left"] = np.flatnonzero(state.network.position[:, 0] < 1e-4)
    balance = Balance(state, np.ones(len(state.position), dtype=bool))
    found = balance.matrix(balance.bars(balance.start), exact=True).sparse.tocoo()
    coupled = set(zip(found.row // 3, found.col // 3, strict=True))
    foreseen = joined_nodes(state.free, state.acting.springs.ends, state.fields).tocoo()
    assert coupled == set(zip(foreseen.row, foreseen.col, strict=True))


BONDED = TIED.replace("joint tie {{ glue from face to coarse }}", "JOINT")
SPRINGS = (
    "tissue bond {{ spring constant = 10 kN/m; viscosity = 1 N*s/m }}\n"
    "joint tie {{ springs from face to coarse; tissue is bond }}"
)
BARS = "joint tie {{ springs from face to coarse; tissue is gel; section = 25 mm^2 }}"


def test_springs_without_length_between_solids_are_told_of_glue():
    """They leave the nodes between those of the larger cells free: 25 % too soft."""
    found = tissuec.check(glued(BONDED.replace("JOINT", SPRINGS)))
    (finding,) = (one for one in found if one.code == "W304")
    assert finding.hint.endswith("write in the joint: glue from face to coarse")
    bars = finding_of(compiled_scene, glued(BONDED.replace("JOINT", BARS)))
    assert bars.hint.startswith("write glue from A to B in place of its springs, which ties A")
