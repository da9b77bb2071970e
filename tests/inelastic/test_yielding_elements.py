"""Solid elements that yield, in whole runs."""

import numpy as np
import pytest

from tests.engine.running import Bench
from tests.inelastic.elements import (
    HASTES,
    PULLED,
    hastened,
    observed_order,
    scene,
    the_reference_agrees,
)
from tests.inelastic.test_elements import ORDERS
from tests.inelastic.yielding import (
    CLAY,
    FLOW,
    MISTAKES,
    SHEAR,
    balance,
    breaks_as_it_flows,
    flows_above_its_yield_stress,
    follows_a_large_shear_and_back,
    follows_a_small_shear,
    keeps_its_shape,
    settles_as_it_flowed,
)
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out, same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.network import ELEMENTS

BOX = {"size": "10, 10, 10", "top": "9.9 mm"}


def test_tissues_tell_how_elements_yield():
    body = "region top where z > 5 mm { tissue is stiff }"
    text = scene(CLAY, size="5, 5, 10", top="9.9 mm", body=body)
    stiff = "tissue stiff { Young's modulus = 30 kPa; density = 1000 kg/m^3 }\nbody"
    network = compiled_scene(text.replace("body", stiff, 1)).network
    (made,) = network.of_kind("elements")
    assert made.yielding.limit.tolist() == [500.0, np.inf]
    assert made.yielding.viscosity.tolist() == [20.0, np.inf]
    # Six numbers at eight points, three to a node.
    assert len(network.remembering(ELEMENTS)) == len(made.internal_rows) == 16
    for memory in ("", "yield stress is none; flow viscosity = 2 Pa*s",
                   "yield stress = 1 kPa; flow viscosity is none"):  # fmt: skip
        network = compiled_scene(scene(memory)).network
        (made,) = network.of_kind("elements")
        assert made.yielding is None
        assert network.internal_rows == slice(8, 8)
        assert made.loss == ""


# --- closed forms -----------------------------------------------------------------------------


def test_a_small_shear_bears_the_yield_stress_over_the_root_of_three_and_what_flow_adds():
    script = """at 0 s: fix low
      from 0 s to 100 ms: move high by (1e-3, 0, 0) mm using constant speed"""
    soft = FLOW.format(0.02).replace("500 Pa", "0.2 Pa").replace("retardation time = 1 ms", "")
    _, recording = carried_out(compiled_scene(scene(soft, script=script)))
    time, force = recording.log_arrays("force of high")
    follows_a_small_shear(time, force[:, 0] / 25e-6)


@pytest.mark.parametrize("law", ["", "; solid law is mooney rivlin { share = 0.4 }"])
def test_a_large_shear_and_back_is_that_of_the_equation_in_space(law):
    script = """at 0 s: fix low
      from 0 s to 50 ms: move high by (4, 0, 0) mm using constant speed
      from 50 ms to 100 ms: move high by (-4, 0, 0) mm using constant speed"""
    memory = FLOW.format(20).replace("retardation time = 1 ms", "") + law
    _, recording = carried_out(compiled_scene(scene(memory, script=script)))
    time, force = recording.log_arrays("force of high")
    parts = (0.6 * SHEAR, 0.4 * SHEAR) if law else (SHEAR, 0.0)
    follows_a_large_shear_and_back(time, force[:, 0] / 25e-6, parts, close=1e-6)
    assert np.abs(balance(recording)).max() < 1e-7


PLANES = """symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"""


def bar(memory, script, duration="0.4 s"):
    """Return a scene of an eighth of a cube, whose sides are free."""
    text = scene(memory, script=script, duration=duration, method="tolerance = 1e-6")
    return text.replace("environment {", f"environment {{ {PLANES}; damping = 0.0005 N*s/m;")


def test_a_bar_flows_above_its_yield_stress_and_stays_longer():
    # 900 Pa on 25 mm² are 22.5 mN.
    script = """at 0 s: push high with (0, 0, 22.5) mN
      at 0.3 s: stop pushing high"""
    fluid = FLOW.format(400).replace("; retardation time = 1 ms", "")
    text = bar(fluid, script, "1 s").replace("every 5 ms", "every 20 ms")
    text = text.replace("stress of high", "plastic strain of high")
    # Corners of a single cell are lighter than their part of the load; without much mass, that
    # counts as little.
    text = text.replace("density = 1000 kg/m^3", "density = 100 kg/m^3")
    outcome, recording = carried_out(compiled_scene(text))
    position = recording.frame_arrays()[1]
    flows_above_its_yield_stress(recording, np.log(position[:, 7, [2, 0]] / 5e-3))
    assert outcome.kind == "done"


def test_a_bar_below_its_yield_stress_keeps_its_shape():
    script = "at 0 s: push high with (0, 0, 5) mN; at 0.3 s: stop pushing high"
    keeps_its_shape(bar(CLAY, script), bar("retardation time = 1 ms", script))


# --- other forces, statics, events ------------------------------------------------------------

MIXED = (
    CLAY
    + """; relaxing share = 40 %; relaxation time = 10 ms
  solid law is yeoh { second = 2; third = 1 }; fibre modulus = 20 kPa"""
)


@pytest.mark.parametrize("haste", HASTES)
def test_the_reference_agrees_on_large_strains(haste):
    script = PULLED.replace("(3, 0, 2)", "(4, 0, 3)")
    text = scene(MIXED, ratio=0.45, script=script, body="fibres = (1, 0, 1)",
                 duration="80 ms", method="tolerance = 5e-4")  # fmt: skip
    the_reference_agrees(hastened(text, haste), position=1e-5, balance=1e-5, force=1e-4)


def test_settling_keeps_what_has_flowed():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (3, 0, 1) mm using smooth profile
      at 21 ms: { release high; settle }"""
    text = scene(CLAY, ratio=0.4, script=script, duration="22 ms", method="tolerance = 1e-4")
    settles_as_it_flowed(text.replace("every 5 ms", "every 1 ms"), 2, "elements", 8)


def test_what_is_cut_or_broken_takes_its_flow_along():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (2, 0, 4) mm using smooth profile
      at 30 ms: cut block along plane through (0, 0, 7.5) mm facing (0, 0, 1)"""
    text = scene(CLAY, size="10, 10, 15", top="14.9 mm", script=script,
                 method="tolerance = 1e-6")  # fmt: skip
    outcome, recording = carried_out(compiled_scene(text))
    whole, parts = (each.intact(outcome.state.alive) for each in outcome.state.elements)
    assert (whole.item_count, parts.item_count) == (8, 8)
    rows = np.concatenate([whole.internal_rows, parts.internal_rows])
    assert len(np.unique(rows)) == len(rows) == 16 * 16
    assert np.abs(balance(recording)).max() < 1e-6


def test_elements_that_yield_break_at_a_strain_that_includes_the_plastic_one():
    script = """at 0 s: fix low
      from 0 s to 0.1 s: move high by (0, 0, 8) mm using constant speed"""
    memory = CLAY + "; breaking strain = 60 %"
    text = scene(memory, script=script, body="rupture is allowed", duration="0.11 s")
    outcome, later = breaks_as_it_flows(text, borne=1e-3)
    assert not later.any()
    assert not outcome.state.fields or outcome.state.fields[0].item_count == 0


@pytest.mark.parametrize("memory", MISTAKES)
def test_mistakes_are_refused(memory):
    limited = "strength" in memory or "toughness" in memory
    text = scene(memory, body="rupture is allowed" if limited else "")
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    found = caught.value.diagnostics
    assert MISTAKES[memory] in [f"{one.code}: {one.message}" for one in found]


# --- methods ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swinging():
    """A free block that flows at once, because it is drawn stretched and yields at nothing."""
    memory = "yield stress = 0 Pa; flow viscosity = 60 Pa*s; prestress = 20 %"
    text = scene(memory, body="prestress along (1, 0, 0)", script="", ratio=0.2)
    return compiled_scene(text).network


@pytest.mark.parametrize("method", ORDERS)
def test_methods_keep_their_order(swinging, method):
    declared, counts = ORDERS[method]
    counts = counts[:2] if INTEGRATORS[method].implicit else counts
    observed = observed_order(swinging, method, counts)
    assert observed > declared - 0.15 * max(declared, 2)


def test_symplectic_methods_give_way(swinging):
    found = Bench(swinging, 0.02, method="srkn11", tolerance=1e-6).run()
    assert found.engine.choice.name == "dop853"
    assert found.engine.choice.reason.startswith("there are elements that yield")


def test_a_run_that_is_resumed_gives_the_same_bytes():
    text = scene(MIXED, ratio=0.45, script=PULLED, body="fibres = (1, 0, 1)", **BOX)
    compiled = compiled_scene(text)
    same_when_resumed(compiled, "force of high", 6)


def test_threads_change_no_bit(threads_in_small_nets):
    script = """at 0 s: fix low
      from 0 s to 0.2 ms: move high by (3, 0, 2) mm using smooth profile"""
    text = scene(MIXED, size="60, 60, 60", top="59.9 mm", script=script, duration="0.2 ms",
                 body="fibres = (1, 0, 1)",
                 method="integrator is velocity verlet; step = 0.02 ms")  # fmt: skip
    compiled = compiled_scene(text.replace("every 5 ms", "every 0.2 ms"))
    one = same_on_two_threads(compiled, "force of high")
    (made,) = one.state.of_kind("elements")
    assert made.yielding.equivalent(one.state.velocity, 8).max() > 1e-3
