"""Walls of elements that yield, in whole runs."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from tests.inelastic.elements import (
    HASTES,
    PULLED,
    hastened,
    observed_order,
    the_reference_agrees,
)
from tests.inelastic.test_walls import ORDERS, scene
from tests.inelastic.yielding import (
    BULK,
    CLAY,
    FLOW,
    LIMIT,
    MISTAKES,
    SHEAR,
    balance,
    breaks_as_it_flows,
    flows_above_its_yield_stress,
    follows_a_large_shear_and_back,
    follows_a_small_shear,
    keeps_its_shape,
    measured,
    settles_as_it_flowed,
)
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out, same_on_two_threads, same_when_resumed
from tissuec.compiler.anatomy import anatomy_of
from tissuec.core.errors import CompileError
from tissuec.model.network import ELEMENTS

#: A quarter of a strip or a sheet, whose other half is its mirror image.
QUARTER = """symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)"""
AREA = 5e-6  # of a section of 5 x 1 mm [m²]


def test_tissues_tell_how_walls_yield():
    text = scene(
        CLAY, side=10, cells=2, body="region stiffer where x > 5 mm { tissue is stiff }"
    )
    stiff = "tissue stiff { Young's modulus = 30 kPa; density = 1000 kg/m^3 }\nbody"
    network = compiled_scene(text.replace("body", stiff, 1)).network
    (made,) = network.of_kind("membranes")
    assert sorted(set(made.yielding.limit.tolist())) == [500.0, np.inf]
    flows = np.isfinite(made.yielding.limit)
    assert made.yielding.viscosity[flows].tolist() == [20.0] * 4
    # Three numbers for a triangle, which is one node.
    assert len(network.remembering(ELEMENTS)) == len(made.internal_rows) == 4
    assert made.loss == "there are elements that yield"
    for memory in ("", "yield stress is none; flow viscosity = 2 Pa*s",
                   "yield stress = 1 kPa; flow viscosity is none"):  # fmt: skip
        network = compiled_scene(scene(memory)).network
        (made,) = network.of_kind("membranes")
        assert made.yielding is None
        assert network.internal_rows == slice(4, 4)


# --- closed forms -----------------------------------------------------------------------------


def test_a_small_shear_bears_the_yield_stress_over_the_root_of_three_and_what_flow_adds():
    script = """at 0 s: fix low
      from 0 s to 100 ms: move high by (0, 1e-3, 0) mm using constant speed"""
    soft = "yield stress = 0.2 Pa; flow viscosity = 0.02 Pa*s"
    _, recording = carried_out(compiled_scene(scene(soft, script=script)))
    time, force = recording.log_arrays("force of high")
    follows_a_small_shear(time, force[:, 1] / AREA)


def test_a_large_shear_and_back_is_that_of_the_equation_in_space():
    # In plane stress, shear thins a wall only where its law has a second invariant.
    script = """at 0 s: fix low
      from 0 s to 50 ms: move high by (0, 4, 0) mm using constant speed
      from 50 ms to 100 ms: move high by (0, -4, 0) mm using constant speed"""
    memory = "yield stress = 500 Pa; flow viscosity = 20 Pa*s"
    text = scene(memory, script=script, ratio=0.4999, density=1)
    _, recording = carried_out(compiled_scene(text))
    time, force = recording.log_arrays("force of high")
    follows_a_large_shear_and_back(time, force[:, 1] / AREA, (10e3 / 2.9998, 0.0), close=3e-4)
    assert np.abs(balance(recording)).max() < 1e-7


def drawn_sheet(time, stretches, viscosity):
    """Return the stress of a sheet whose principal stretches change at a time.

    Args:
        stretches: Both in the plane, a function of time.

    Returns:
        Forces per drawn section along both [Pa], shape (time, 2), and plastic strains.
    """

    def stress(t, plastic):
        a, b = stretches(t) * np.exp(-plastic)  # elastic

        def principal(c):
            j = a * b * c
            squares = np.array([a * a, b * b, c * c])
            part = SHEAR * j ** (-2.0 / 3.0) * (squares - squares.mean())
            return part + BULK * np.log(j)

        c = root(lambda c: principal(c[0])[2:], [1.0], tol=1e-13).x[0]
        return principal(c)[:2]

    def rate(t, plastic):
        kirchhoff = stress(t, plastic)
        size = np.sqrt(kirchhoff @ kirchhoff - kirchhoff.prod())
        pace = max(size - LIMIT, 0.0) / viscosity
        part = kirchhoff - kirchhoff.sum() / 3.0
        return 1.5 * pace * part / size if pace else 0.0 * part

    found = solve_ivp(rate, (0.0, time[-1]), [0.0] * 2, "DOP853", time, rtol=1e-10,
                      atol=1e-12, max_step=1e-3)  # fmt: skip
    pairs = zip(time, found.y.T, strict=True)
    p, q = found.y
    strain = np.sqrt(2.0 / 3.0 * (p * p + q * q + (p + q) ** 2))
    return np.array([stress(t, each) / stretches(t) for t, each in pairs]), strain


FLUID = "yield stress = 500 Pa; flow viscosity = 20 Pa*s"


def test_a_band_that_cannot_become_narrower_follows_its_equation():
    script = """at 0 s: fix low
      from 0 s to 100 ms: move high by (4, 0, 0) mm using constant speed"""
    text = scene(FLUID, script=script, density=1, method="tolerance = 1e-6")
    _, recording, time, strain = measured(text, "plastic strain of high")
    force = recording.log_arrays("force of high")[1][:, 0] / AREA
    expected, plastic = drawn_sheet(time, lambda t: np.array([1.0 + 8.0 * t, 1.0]), 20.0)
    np.testing.assert_allclose(force, expected[:, 0], atol=2e-4 * expected.max())
    np.testing.assert_allclose(strain[:, 0], plastic, atol=2e-5 * plastic[-1])
    # A band bears 2/√3 times the stress of a strip, and flows at 2/√3 times its rate.
    wide = 2.0 / np.sqrt(3.0)
    due = wide * (LIMIT + wide * 20.0 * 8.0 / 1.8)
    assert force[-1] * 1.8 == pytest.approx(due, rel=0.01)


def test_a_sheet_that_is_drawn_in_both_directions_flows_at_twice_the_rate():
    script = """from 0 s to 100 ms: move right by (4, 0, 0) mm using constant speed
      from 0 s to 100 ms: move up by (0, 4, 0) mm using constant speed
      from 0 s to 100 ms: move corner by (4, 4, 0) mm using constant speed"""
    sets = """set right = nodes of wall where x > 4.9 mm and y < 0.1 mm
set up = nodes of wall where x < 0.1 mm and y > 4.9 mm
environment"""
    text = scene(FLUID, script=script, density=1, environment=QUARTER, body="bending is none",
                 method="tolerance = 1e-6").replace("environment", sets, 1)  # fmt: skip
    _, recording, time, strain = measured(text, "plastic strain of high")
    force = recording.log_arrays("force of high")[1][:, 0] / AREA
    expected, plastic = drawn_sheet(time, lambda t: np.full(2, 1.0 + 8.0 * t), 20.0)
    np.testing.assert_allclose(force, expected[:, 0], atol=2e-4 * expected.max())
    np.testing.assert_allclose(strain[:, 0], plastic, atol=1e-5 * plastic[-1])
    # The thickness loses what both directions gain.
    assert force[-1] * 1.8 == pytest.approx(LIMIT + 20.0 * 2.0 * 8.0 / 1.8, rel=0.02)
    assert np.abs(balance(recording)).max() < 1e-6


def test_a_strip_flows_above_its_yield_stress_and_stays_longer():
    # 900 Pa on 5 mm² are 4.5 mN.
    script = """at 0 s: push high with (4.5, 0, 0) mN
      at 0.3 s: stop pushing high"""
    text = scene(FLOW.format(400).replace("; retardation time = 1 ms", ""), script=script,
                 duration="0.5 s", environment=QUARTER + "; damping = 0.0004 N*s/m",
                 density=100, body="bending is none", method="tolerance = 1e-6")  # fmt: skip
    text = text.replace("every 5 ms", "every 20 ms").replace(
        "stress of high", "plastic strain of high"
    )
    compiled = compiled_scene(text)
    _, recording = carried_out(compiled)
    corner = int(np.argmax(compiled.network.position[:4, :2].sum(axis=1)))
    position = recording.frame_arrays()[1]
    flows_above_its_yield_stress(recording, np.log(position[:, corner, :2] / 5e-3))


def test_a_wall_below_its_yield_stress_keeps_its_shape():
    script = "at 0 s: fix low; at 0 s: push high with (1, 0, 0) mN; at 50 ms: stop pushing high"
    elastic = scene("retardation time = 1 ms", script=script)
    keeps_its_shape(scene(CLAY, script=script), elastic)


# --- other forces, statics, events ------------------------------------------------------------

MIXED = (
    CLAY
    + """; relaxing share = 40 %; relaxation time = 10 ms
  solid law is yeoh { second = 2; third = 1 }; fibre modulus = 20 kPa; fibre dispersion = 0.1"""
)
FIBRED = "fibres = (1, 1, 0)"


@pytest.mark.parametrize("haste", HASTES)
def test_the_reference_agrees_on_large_strains(haste):
    script = PULLED.replace("(3, 0, 2)", "(4, 0, 3)")
    text = scene(MIXED, ratio=0.45, side=10, cells=2, script=script, body=FIBRED,
                 duration="30 ms", method="tolerance = 1e-4")  # fmt: skip
    the_reference_agrees(hastened(text, haste), position=1e-5, balance=1e-5, force=1e-4)


def test_settling_keeps_what_has_flowed():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (3, 1, 0) mm using smooth profile
      at 21 ms: { release high; settle }"""
    text = scene(CLAY, ratio=0.4, script=script, duration="22 ms", method="tolerance = 1e-4")
    settles_as_it_flowed(text.replace("every 5 ms", "every 1 ms"), 0, "membranes")


CUT = """at 0 s: fix low
  from 0 s to 20 ms: move high by (4, 0, 1) mm using smooth profile
  at 30 ms: cut wall along plane through (7.5, 0, 0) mm facing (1, 0, 0)"""


def test_what_is_cut_takes_its_flow_along():
    text = scene(CLAY, side=10, cells=2, script=CUT, method="tolerance = 1e-6")
    outcome, recording = carried_out(compiled_scene(text))
    every = [each.intact(outcome.state.alive) for each in outcome.state.of_kind("membranes")]
    rows = np.concatenate([each.internal_rows for each in every])
    assert every[-1].is_cut and len(np.unique(rows)) == len(rows)
    assert np.abs(balance(recording)).max() < 1e-6


def test_walls_that_yield_break_at_a_strain_that_includes_the_plastic_one():
    script = """at 0 s: fix low
      from 0 s to 0.1 s: move high by (8, 0, 0) mm using constant speed"""
    memory = CLAY + "; breaking strain = 60 %"
    text = scene(memory, script=script, body="rupture is allowed", duration="0.11 s")
    # Both triangles are stretched alike.
    _, later = breaks_as_it_flows(text, borne=1e-4)
    assert np.abs(later[:, 0]).max() < 1e-9


@pytest.mark.parametrize("memory", MISTAKES)
def test_mistakes_are_refused(memory):
    limited = "strength" in memory or "toughness" in memory
    text = scene(memory, body="rupture is allowed" if limited else "")
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert [f"{one.code}: {one.message}" for one in caught.value.diagnostics] == [
        MISTAKES[memory]
    ]


def test_blocks_have_no_stress_of_walls_that_yield():
    found = anatomy_of(compiled_scene(scene(CLAY)))
    assert found.matter == {}
    reason = "stress depends on how far its elements have yielded"
    assert found.notes == (f"wall has no strain and stress: {reason}",)


# --- methods ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swinging():
    """A free wall that flows at once, because it is drawn stretched and yields at nothing."""
    memory = "yield stress = 0 Pa; flow viscosity = 60 Pa*s; prestress = 20 %"
    text = scene(memory, body="prestress along (1, 0, 0)", script="", ratio=0.2)
    return compiled_scene(text).network


@pytest.mark.parametrize("method", ORDERS)
def test_methods_keep_their_order(swinging, method):
    declared, counts = ORDERS[method]
    observed = observed_order(swinging, method, counts)
    assert observed > declared - 0.15 * max(declared, 2)


def test_a_run_that_is_resumed_gives_the_same_bytes():
    text = scene(MIXED, ratio=0.45, side=10, cells=2, script=PULLED, body=FIBRED)
    same_when_resumed(compiled_scene(text), "force of high", 6)


def test_threads_change_no_bit(threads_in_small_nets):
    script = """at 0 s: fix low
      from 0 s to 0.2 ms: move high by (0.5, 0, 0.2) mm using smooth profile"""
    memory = MIXED.replace("500 Pa", "10 Pa")
    text = scene(memory, side=66, cells=46, script=script, duration="0.2 ms", body=FIBRED,
                 method="integrator is velocity verlet; step = 0.02 ms")  # fmt: skip
    compiled = compiled_scene(text.replace("every 5 ms", "every 0.2 ms"))
    one = same_on_two_threads(compiled, "force of high")
    (made,) = one.state.of_kind("membranes")
    assert made.yielding.equivalent(one.state.velocity).max() > 1e-4
