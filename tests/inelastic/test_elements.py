"""Solid elements that relax, in whole runs."""

import numpy as np
import pytest
from scipy.linalg import expm

from tests.engine.running import Bench
from tests.inelastic.elements import (
    HASTES,
    ONE,
    PRONY,
    PULLED,
    SETTLED,
    SHARES,
    TIMES,
    branches_gave_way,
    hastened,
    observed_order,
    relaxes_when_held,
    scene,
    the_reference_agrees,
)
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out, open_balance, same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.model.network import ELEMENTS


def test_shares_are_parts_of_the_stress_at_once_of_which_the_modulus_stays():
    network = compiled_scene(scene()).network
    (made,) = network.of_kind("elements")
    shear = 10e3 / 2.6
    np.testing.assert_allclose(made.shear, shear, rtol=1e-12)
    whole = made.shear + made.branches.sudden
    np.testing.assert_allclose(made.branches.shear[:, 0] / whole, SHARES, rtol=1e-12)
    np.testing.assert_allclose(made.branches.time[:, 0], TIMES)
    # Three branches of six numbers at eight points, three to a node.
    assert len(network.remembering(ELEMENTS)) == len(made.internal_rows) == 3 * 6 * 8 // 3
    assert network.node_count == 8


def test_a_block_that_is_sheared_and_held_relaxes():
    script = """at 0 s: fix low
      from 0 s to 10 ms: move high by (0.005, 0, 0) mm using constant speed"""
    # Of a shear of a thousandth, terms of the third order are below a millionth.
    relaxes_when_held(
        scene(script=script, method="tolerance = 2e-9"),
        area=25e-6,
        along=0,
        shear=5,
        close=1e-6,
    )


def linear(time, matrix, start):
    return np.array([expm(matrix * t) @ start for t in time])


def test_a_block_creeps_under_a_steady_force():
    # A force for strains of some millionths.
    text = scene(ONE, script="at 0 s: fix low; at 0 s: push high with (4e-9, 0, 0) N")
    compiled = compiled_scene(text)
    network = compiled.network
    (made,) = network.of_kind("elements")
    free = np.flatnonzero(network.position[:8, 2] > 1e-3)
    number = np.full(network.node_count, -1)
    number[free] = np.arange(len(free))
    still = np.zeros_like(network.position)
    size, drawn = 3 * len(free), network.position
    k = made.matrix(0.0, drawn, number, len(free)).toarray()
    k1 = made.recalling(still).matrix(0.0, drawn, number, len(free)).toarray() - k
    _, d = (m.toarray() for m in made.damping_matrices(drawn, still, number, len(free)))
    inverse = np.diag(np.repeat(1.0 / network.mass[free], 3))
    # Of y = (u, v, q, 1), q being what the dashpots gave way by.
    matrix = np.zeros((3 * size + 1, 3 * size + 1))
    u, v, q = (slice(n * size, (n + 1) * size) for n in range(3))
    matrix[u, v] = np.eye(size)
    matrix[v, u], matrix[v, v], matrix[v, q] = -inverse @ (k + k1), -inverse @ d, inverse @ k1
    matrix[q, u], matrix[q, q] = np.eye(size) / 0.02, -np.eye(size) / 0.02
    push = np.zeros((len(free), 3))
    push[:, 0] = 1e-9
    matrix[v, -1] = inverse @ push.ravel()
    start = np.zeros(3 * size + 1)
    start[-1] = 1.0
    _, recording = carried_out(compiled)
    time, position = recording.frame_arrays()[:2]
    moved = (position - drawn)[:, free].reshape(len(time), -1)
    exact = linear(time, matrix, start)[:, u]
    assert np.abs(moved - exact).max() < 1e-5 * np.abs(exact).max()
    # At once it gives way by about two fifths of what it does in the end.
    assert np.abs(exact[3]).max() < 0.8 * np.abs(exact[-1]).max()


@pytest.mark.parametrize(
    "memory", [PRONY, ONE + "; solid law is yeoh { second = 2; third = 1 }"]
)
@pytest.mark.parametrize("haste", HASTES)
def test_the_reference_agrees_on_large_strains(memory, haste):
    text = scene(memory, ratio=0.45, size="10, 10, 10", top="9.9 mm", script=PULLED,
                 duration="80 ms", method="tolerance = 3e-5")  # fmt: skip
    the_reference_agrees(hastened(text, haste), position=1e-5, balance=1e-5, force=1e-4)


def test_a_block_that_is_drawn_stretched_relaxes_unless_it_settles_first():
    body = "prestress along (0, 0, 1)"
    text = scene(ONE + "; prestress = 10 %", body=body, size="5, 5, 10", top="9.9 mm",
                 script="at 0 s: { fix low; fix high }", duration="0.3 s")  # fmt: skip
    _, recording = carried_out(compiled_scene(text))
    force = recording.log_arrays("force of high")[1][:, 2]
    assert force[0] > 1.8 * force[-1]
    settled = text.replace("fix high }", "fix high; settle }")
    _, recording = carried_out(compiled_scene(settled))
    np.testing.assert_allclose(
        recording.log_arrays("force of high")[1][:, 2], force[-1], rtol=1e-5
    )


@pytest.mark.parametrize("haste", HASTES)
def test_settling_lets_branches_give_way_for_good(haste):
    text = scene(ONE, ratio=0.4, size="10, 10, 10", top="9.9 mm", script=SETTLED,
                 duration="40 ms")  # fmt: skip
    text = hastened(text, haste)
    outcome, recording = carried_out(compiled_scene(text))
    branches_gave_way(outcome, recording, "elements", since=0.0301 / haste, still=1e-12)
    found = validated(text.replace("tolerance = 1e-8", "tolerance = 1e-4"))
    assert found.verdict == "kept"
    assert quantity(found, "position").error < 1e-5


CUT = """at 0 s: fix low
  from 0 s to 20 ms: move high by (2, 0, 1) mm using smooth profile
  at 30 ms: cut block along plane through (0, 0, 7.5) mm facing (0, 0, 1)"""


@pytest.mark.parametrize("haste", HASTES)
def test_what_is_cut_takes_its_branches_along(haste):
    text = scene(ONE, size="5, 5, 15", top="14.9 mm", script=CUT, duration="60 ms",
                 method="tolerance = 1e-6")  # fmt: skip
    text = hastened(text, haste)
    outcome, recording = carried_out(compiled_scene(text))
    whole, parts = (each.intact(outcome.state.alive) for each in outcome.state.elements)
    assert (whole.item_count, parts.item_count) == (2, 2)
    _, elastic, _, _, _, switched = recording.energy_arrays()[1].T
    # Whole cells bend otherwise than parts do: that is all that a cut changes of the energy.
    assert 0.0 < abs(switched[-1]) < 0.01 * elastic[5]
    assert np.abs(open_balance(recording)).max() < 1e-7
    assert validated(text.replace("tolerance = 1e-6", "tolerance = 1e-4")).verdict == "kept"


# --- methods ---

ORDERS = {"dop853": (8, (40, 52, 68)), "velocity verlet": (2, (256, 512, 1024)),
          "rkc2": (2, (256, 512, 1024)), "rkn4": (3, (96, 192, 384)),
          "esdirk43": (4, (48, 96, 192)), "trbdf2": (2, (256, 512, 1024))}  # fmt: skip


@pytest.fixture(scope="module")
def swinging():
    """A free block that begins to move because it is drawn stretched."""
    text = scene(ONE + "; prestress = 20 %", body="prestress along (1, 0, 0)", script="",
                 ratio=0.2)  # fmt: skip
    return compiled_scene(text).network


@pytest.mark.parametrize("method", ORDERS)
def test_methods_keep_their_order(swinging, method):
    declared, counts = ORDERS[method]
    observed = observed_order(swinging, method, counts)
    assert observed == pytest.approx(declared, abs=0.15 * max(declared, 2))


def test_what_gave_way_keeps_its_volume():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (1, 0, 3) mm using smooth profile"""
    outcome, _ = carried_out(compiled_scene(scene(ONE, script=script)))
    (made,) = outcome.state.of_kind("elements")
    tensors = made.branches.tensors(outcome.state.velocity, 8)
    assert np.abs(tensors - np.eye(3)).max() > 0.5
    assert np.abs(np.linalg.det(tensors) - 1.0).max() < 1e-6


def test_a_long_hold_takes_few_implicit_steps():
    script = """at 0 s: fix low
      from 0 s to 100 ms: move high by (0, 0, 0.5) mm using smooth profile"""
    text = scene("relaxing share = 40 %; relaxation time = 2 s", script=script,
                 method="integrator is esdirk43; tolerance = 1e-3",
                 duration="300 s")  # fmt: skip
    outcome, recording = carried_out(compiled_scene(text.replace("every 5 ms", "every 1 s")))
    assert outcome.statistics.accepted < 300
    force = recording.log_arrays("force of high")[1][:, 2]
    # In the end, it is that of the same block that never relaxed.
    plain = scene("retardation time = 1 ms", script=script, duration="1 s",
                  method="integrator is esdirk43; tolerance = 1e-6")  # fmt: skip
    _, recording = carried_out(compiled_scene(plain))
    assert force[-1] == pytest.approx(recording.log_arrays("force of high")[1][-1, 2], rel=1e-4)
    assert force[1] > 1.1 * force[-1]


def test_a_method_without_time_is_refused_in_scenes():
    with pytest.raises(CompileError) as caught:
        compiled_scene(scene(method="integrator is relaxation { threshold = 1 uN }"))
    error = caught.value.diagnostics[0]
    assert error.code == "TIS306"
    assert "does not support elements that relax or yield" in error.message


def test_the_symplectic_method_gives_way_to_one_that_can(swinging):
    found = Bench(swinging, 0.02, method="srkn11", tolerance=1e-6).run()
    assert found.engine.choice.name == "dop853"
    assert found.engine.choice.reason.startswith("there are elements that relax")


# --- whole runs -------------------------------------------------------------------------------


def test_a_run_that_is_resumed_gives_the_same_bytes():
    text = scene(ONE, ratio=0.45, size="10, 10, 10", top="9.9 mm", script=PULLED)
    compiled = compiled_scene(text)
    _, (first, _) = same_when_resumed(compiled, "force of high", 6)
    assert 0.0 < first.state.time < 0.1


def test_threads_change_no_bit(threads_in_small_nets):
    script = """at 0 s: fix low
      from 0 s to 0.2 ms: move high by (0.5, 0, 0.2) mm using smooth profile"""
    text = scene(ONE, size="60, 60, 60", top="59.9 mm", script=script, duration="0.2 ms",
                 method="integrator is velocity verlet; step = 0.02 ms")  # fmt: skip
    compiled = compiled_scene(text.replace("every 5 ms", "every 0.2 ms"))
    same_on_two_threads(compiled, "force of high")


def test_regions_relax_each_in_its_own_way():
    body = "region top where z > 5 mm { tissue is stiff }"
    text = scene(ONE, size="5, 5, 10", top="9.9 mm", body=body)
    stiff = "tissue stiff { Young's modulus = 30 kPa; density = 1000 kg/m^3 }\nbody"
    network = compiled_scene(text.replace("body", stiff, 1)).network
    (made,) = network.of_kind("elements")
    assert (made.branches.shear[0] > 0.0).tolist() == [True, False]
    assert len(made.internal_rows) == 16
    whole = compiled_scene(text.replace("tissue is stiff", "tissue is gel")).network
    assert len(whole.remembering(ELEMENTS)) == 32


HALVES = {
    "relaxing share = 20 %": "TIS304: a relaxing share needs a relaxation time",
    "relaxation time = 1 s": "TIS304: a relaxation time needs a relaxing share",
    "relaxing share = 60 %; relaxation time = 1 s; second relaxing share = 50 %; "
    "second relaxation time = 2 s":
        "TIS309: the shares that relax make up 110 % of the modulus",
    "relaxing constant = 1 N/m; relaxation time = 1 s":
        "TIS306: relaxing constant is not available for elements",
}  # fmt: skip


@pytest.mark.parametrize("memory", HALVES)
def test_mistakes_are_refused(memory):
    with pytest.raises(CompileError) as caught:
        compiled_scene(scene(memory))
    found = caught.value.diagnostics[0]
    assert f"{found.code}: {found.message}" == HALVES[memory]


def test_nothing_that_relaxes_needs_no_variables():
    for memory in ("", "relaxing share = 0 %; relaxation time = 1 s",
                   "relaxing share = 20 %; relaxation time is none"):  # fmt: skip
        network = compiled_scene(scene(memory)).network
        (made,) = network.of_kind("elements")
        assert made.branches is None
        assert network.internal_rows == slice(8, 8)
        assert replace(made, branches=None).loss == ""
