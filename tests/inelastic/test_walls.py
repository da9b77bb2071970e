"""Walls of elements that relax, in whole runs."""

import numpy as np
import pytest

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
    relaxed,
    relaxes_when_held,
    the_reference_agrees,
)
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import carried_out, open_balance, same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.model.network import ELEMENTS

SCENE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = {density} kg/m^3
  {memory}
}}
body wall {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = ({side}, 0, 0) mm; second edge = (0, {side}, 0) mm
    columns = {count}; rows = {count}
  }}
  tissue is gel; thickness = 1 mm
  {body}
}}
set low = nodes of wall where x < 0.1 mm
set high = nodes of wall where x > {side} - 0.1 mm
set far = nodes of wall where y > {side} - 0.1 mm
set corner = nodes of wall where x > {side} - 0.1 mm and y > {side} - 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2; {environment} }}
script {{ {script} }}
simulate {{ duration = {duration}; {method} }}
output {{ trajectory every 5 ms; energy every 5 ms; force of high every 5 ms
          stress of high every 5 ms }}
"""


def scene(
    memory=PRONY, *, ratio=0.3, density=1000, side=5, cells=1, body="", environment="",
    script="at 0 s: fix low", duration="0.1 s", method="tolerance = 1e-8",
):  # fmt: skip
    text = SCENE.format(
        memory=memory, ratio=ratio, density=density, side=side, count=cells + 1, body=body,
        environment=environment, script=script, duration=duration, method=method,
    )  # fmt: skip
    return text.replace(f"> {side} - 0.1 mm", f"> {side - 0.1} mm")


def test_shares_are_parts_of_the_stress_at_once_of_which_the_modulus_stays():
    network = compiled_scene(scene()).network
    (made,) = network.of_kind("membranes")
    shear = 10e3 / 2.6
    np.testing.assert_allclose(made.shear, shear, rtol=1e-12)
    whole = made.shear + made.branches.sudden
    np.testing.assert_allclose(made.branches.shear[:, 0] / whole[0], SHARES, rtol=1e-12)
    np.testing.assert_allclose(made.branches.time[:, 0], TIMES)
    # Three branches of two triangles, of three numbers each.
    assert len(network.remembering(ELEMENTS)) == len(made.internal_rows) == 6
    assert network.node_count == 4


def test_a_wall_that_is_sheared_and_held_relaxes():
    script = """at 0 s: fix low
      from 0 s to 10 ms: move high by (0, 0.005, 0) mm using constant speed"""
    relaxes_when_held(scene(script=script), area=5e-6, along=1, shear=3, close=1e-5)


def test_a_wall_that_is_stretched_in_all_directions_and_held_relaxes():
    # Nearly nothing changes its volume: 6 G ε.
    script = """at 0 s: fix origin
      from 0 s to 10 ms: move right by (0.0005, 0, 0) mm using constant speed
      from 0 s to 10 ms: move up by (0, 0.0005, 0) mm using constant speed
      from 0 s to 10 ms: move corner by (0.0005, 0.0005, 0) mm using constant speed"""
    sets = """set origin = nodes of wall where x < 0.1 mm and y < 0.1 mm
set right = nodes of wall where x > 4.9 mm and y < 0.1 mm
set up = nodes of wall where x < 0.1 mm and y > 4.9 mm
environment"""
    text = scene(script=script, ratio=0.4999).replace("environment", sets, 1)
    _, recording = carried_out(compiled_scene(text))
    time, force = recording.log_arrays("force of high")
    expected = 5e-6 * 6.0 * relaxed(time, 0.01, 0.01, 10e3 / 2.9998)
    np.testing.assert_allclose(force[:, 0], expected, rtol=1.5e-3, atol=1e-9)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
def test_a_strip_creeps_under_a_steady_force(ratio):
    # ε = σ (J/3 + 1/9K) along it and σ (1/9K - J/6) across, J being the compliance in shear
    # of a spring beside another spring and a dashpot in a row.
    script = "at 0 s: push high with (2e-7, 0, 0) N"
    quarter = "symmetric about plane through (0, 0, 0) mm facing (1, 0, 0); "
    quarter += "symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)"
    memory = "relaxing share = 60 %; relaxation time = 20 ms; retardation time = 20 us"
    text = scene(memory, ratio=ratio, density=1, script=script, environment=quarter,
                 body="bending is none", method="tolerance = 1e-5")  # fmt: skip
    compiled = compiled_scene(text)
    _, recording = carried_out(compiled)
    time, position = recording.frame_arrays()[:2]
    corner = int(np.argmax(compiled.network.position[:4, :2].sum(axis=1)))
    strain = (position - compiled.network.position)[1:, corner, :2] / 5e-3
    shear, bulk, stress = 5e3 / (1.0 + ratio), 10e3 / (3.0 * (1.0 - 2.0 * ratio)), 2e-7 / 5e-6
    compliance = (1.0 - 0.6 * np.exp(-time[1:] * 0.4 / 0.02)) / shear
    along, across = compliance / 3.0 + 1.0 / (9.0 * bulk), 1.0 / (9.0 * bulk) - compliance / 6.0
    np.testing.assert_allclose(strain[:, 0], stress * along, rtol=2e-3)
    np.testing.assert_allclose(strain[:, 1], stress * across, atol=2e-3 * stress * along.max())


HALF = "\n  from 0 s to 20 ms: move high by (3, 0, 2) mm using smooth profile"


@pytest.mark.parametrize(
    "memory", [PRONY, ONE + "; solid law is yeoh { second = 2; third = 1 }"]
)
@pytest.mark.parametrize("haste", HASTES)
def test_the_reference_agrees_on_large_strains(memory, haste):
    text = scene(memory, ratio=0.45, side=10, cells=2, script=PULLED.splitlines()[0] + HALF,
                 duration="30 ms", method="tolerance = 1e-4")  # fmt: skip
    the_reference_agrees(hastened(text, haste), position=1e-5, balance=1e-5, force=1e-4)


def test_a_wall_that_is_drawn_stretched_relaxes_unless_it_settles_first():
    text = scene(ONE + "; prestress = 10 %", script="at 0 s: { fix low; fix high }",
                 side=10, cells=2, duration="0.3 s")  # fmt: skip
    _, recording = carried_out(compiled_scene(text))
    force = recording.log_arrays("force of high")[1][:, 0]
    assert abs(force[0]) > 1.7 * abs(force[-1])
    settled = text.replace("fix high }", "fix high; settle }")
    _, recording = carried_out(compiled_scene(settled))
    np.testing.assert_allclose(
        recording.log_arrays("force of high")[1][:, 0], force[-1], rtol=1e-4
    )


@pytest.mark.parametrize("haste", HASTES)
def test_settling_lets_branches_give_way_for_good(haste):
    text = scene(ONE, ratio=0.4, side=10, cells=2, script=SETTLED, duration="40 ms")
    text = hastened(text, haste)
    outcome, recording = carried_out(compiled_scene(text))
    branches_gave_way(outcome, recording, "membranes", since=0.0301 / haste, still=1e-10)
    assert validated(text.replace("tolerance = 1e-8", "tolerance = 1e-4")).verdict == "kept"


CUT = """at 0 s: fix low
  from 0 s to 20 ms: move high by (2, 0, 1) mm using smooth profile
  at 30 ms: cut wall along plane through (7.5, 0, 0) mm facing (1, 0, 0)"""


@pytest.mark.parametrize("haste", HASTES)
def test_what_is_cut_or_breaks_takes_its_branches_along(haste):
    limit = "; breaking strain = 30 %"
    torn = CUT.replace("(2, 0, 1)", "(5, 0, 1)")
    for memory, script, body in ((ONE, CUT, ""), (ONE + limit, torn, "rupture is allowed")):
        text = scene(memory, side=10, cells=2, script=script, body=body, duration="60 ms",
                     method="tolerance = 1e-6")  # fmt: skip
        text = hastened(text, haste)
        outcome, recording = carried_out(compiled_scene(text))
        made, *parts = outcome.state.of_kind("membranes")
        assert len(made.lost_items(outcome.state.alive))
        _, elastic, _, _, _, switched = recording.energy_arrays()[1].T
        if not body:  # what changes is bending at edges of the cut, which are free
            assert len(parts) and -1e-3 * elastic[3] < switched[-1] <= 0.0
        else:
            assert not parts and abs(switched[-1]) > 0.1 * elastic[3]
        assert np.abs(open_balance(recording)).max() < 1e-6
    text = scene(ONE, side=10, cells=2, script=CUT, duration="60 ms", method="tolerance = 1e-4")
    assert validated(hastened(text, haste)).verdict == "kept"


# --- methods ---

ORDERS = {"dop853": (8, (40, 52, 68)), "velocity verlet": (2, (256, 512, 1024)),
          "rkc2": (2, (1024, 2048, 4096)), "rkn4": (3, (192, 384, 768)),
          "esdirk43": (4, (48, 96)), "trbdf2": (2, (256, 512))}  # fmt: skip


@pytest.fixture(scope="module")
def swinging():
    """A free wall that begins to move because it is drawn stretched."""
    text = scene(ONE + "; prestress = 20 %", body="prestress along (1, 0, 0)", script="",
                 ratio=0.2)  # fmt: skip
    return compiled_scene(text).network


@pytest.mark.parametrize("method", ORDERS)
def test_methods_keep_their_order(swinging, method):
    declared, counts = ORDERS[method]
    observed = observed_order(swinging, method, counts)
    assert observed == pytest.approx(declared, abs=0.15 * max(declared, 2))


def test_statics_is_refused():
    with pytest.raises(CompileError) as caught:
        compiled_scene(scene(method="integrator is relaxation { threshold = 1 uN }"))
    error = caught.value.diagnostics[0]
    assert error.code == "TIS306"
    assert "does not support elements that relax or yield:" in error.message
    assert "dop853" in error.hint


def test_a_run_that_is_resumed_gives_the_same_bytes():
    text = scene(ONE, ratio=0.45, side=10, cells=2, script=PULLED)
    compiled = compiled_scene(text)
    _, (first, _) = same_when_resumed(compiled, "force of high", 6)
    assert 0.0 < first.state.time < 0.1


def test_threads_change_no_bit(threads_in_small_nets):
    script = """at 0 s: fix low
      from 0 s to 0.2 ms: move high by (0.5, 0, 0.2) mm using smooth profile"""
    text = scene(ONE, side=66, cells=46, script=script, duration="0.2 ms",
                 method="integrator is velocity verlet; step = 0.02 ms")  # fmt: skip
    compiled = compiled_scene(text.replace("every 5 ms", "every 0.2 ms"))
    same_on_two_threads(compiled, "force of high")


def test_nothing_that_relaxes_needs_no_variables():
    for memory in ("", "relaxing share = 0 %; relaxation time = 1 s",
                   "relaxing share = 20 %; relaxation time is none"):  # fmt: skip
        network = compiled_scene(scene(memory)).network
        (made,) = network.of_kind("membranes")
        assert made.branches is None
        assert network.internal_rows == slice(4, 4)
        assert made.loss == ""
