"""Meshes that are tied: the patch test, bending, conserved quantities, SciPy's solution."""

import numpy as np
import pytest

import tissuec
from tests.engine.test_team import shaken
from tests.findings import finding_of
from tests.glue.blocks import (
    CROSSED,
    TIED,
    WHOLE,
    at_ends,
    error_of_even_motion,
    glued,
    on_box,
    standing,
)
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import same_when_resumed
from tissuec.engine.unknowns import joined_nodes
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.observables import inner_forces

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
    outer = on_box(drawn)
    assert (~outer & state.free).sum() > 20
    error = error_of_even_motion(state, GRADIENTS[load], outer)
    assert error < 1e-12 * np.ptp(drawn)


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


def test_scipy_finds_the_same_motion_where_glued_elements_relax():
    text = small().replace("1e-6", "1e-4")
    relaxing = "relaxing share = 30 %; relaxation time = 5 ms\n  retardation time"
    found = validated(text.replace("retardation time", relaxing))
    assert quantity(found, "position").error < 1e-4


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


ORDERS = {
    "pushed": "from 0 s to 2 ms: push face with (1, 0, 2) mN using smooth profile",
    "pressed": "from 0 s to 2 ms: press top with 500 Pa",
    "moved": "from 0 s to 2 ms: move both by (0, 0, 1) mm using smooth profile\n"
    "at 3 ms: free both",
    "guest cut": "at 2 ms: cut fine along plane through (21, 0, 0) mm facing (1, 0, 0)",
    "host cut": "at 2 ms: cut coarse along plane through (17, 0, 0) mm facing (1, 0, 0)",
    "heavier": "at 2 ms: change mass of face by 3",
}
SETS = """set top = nodes of [fine, coarse] where z > 4.9 mm
set both = nodes of [fine, coarse] where x between 14.9 mm and 20.1 mm
"""


@pytest.mark.parametrize("order", ORDERS)
def test_scipy_finds_the_same_motion_under_orders(order):
    text = small().replace("1e-6", "1e-4").replace("10 ms", "5 ms")
    script = f"script {{ at 0 s: fix left; {ORDERS[order]} }}"
    text = text.replace("script { at 0 s: fix left }", script) + SETS
    found = validated(text)
    for name in ("position", "energy balance", "force of left"):
        assert quantity(found, name).error < 1e-4


def test_a_plane_of_symmetry_through_glued_faces_bears_the_other_half():
    """Both come to rest to 1e-9 of the largest force."""
    whole = glued(script=PULLED.format("0.4, 0, 1"))
    half = whole.replace("10, 10) mm", "5, 10) mm")
    plane = "symmetric about plane through (0, 5, 0) mm facing (0, -1, 0)"
    half = half.replace("environment {", f"environment {{ {plane};")
    assert 2.0 * last_force(half)[[0, 2]] == pytest.approx(last_force(whole)[[0, 2]], rel=1e-8)


@pytest.mark.parametrize("method", ["dop853", "velocity verlet"])
def test_threads_change_no_bit(method, threads_in_small_nets):
    network = standing(glued().replace("2.5 mm", "1 mm")).network
    (one, first), (two, second) = (shaken(network, method, n, steps=1) for n in (1, 2))
    assert first.statistics.threads == 1 and second.statistics.threads == 2
    assert all(np.array_equal(*each) for each in zip(one, two, strict=True))


@pytest.mark.parametrize("cells", [("3.33333333333 mm", "2.5 mm"), ("2.5 mm", "2 mm")])
def test_three_blocks_in_a_row_stretch_evenly(cells):
    """By a millionth, which the law bends by less of itself; glue is read from either end."""
    text = glued(poisson=0).replace("2.5 mm", cells[0])
    end = (
        "body last { mesh is lattice { cell = @ mm; box from (40, 0, 0) mm to (50, 10, 10) mm }"
    )
    more = (
        end.replace("@ mm", cells[1])
        + "; tissue is gel }\nset far = nodes of last where x < 40.1 mm"
    )
    more += "\njoint bond { glue from far to fine }\njoint tie"
    state = standing(text.replace("joint tie", more))
    ends, strain = at_ends(state.network.position), 1e-6
    error = error_of_even_motion(state, np.diag([strain, 0.0, 0.0]), ends)
    assert error < 2e-6 * strain * 5e-3
