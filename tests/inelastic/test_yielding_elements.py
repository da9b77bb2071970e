"""Solid elements that yield, in whole runs."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from tests.engine.running import Bench
from tests.inelastic.elements import PULLED, observed_order, scene, the_reference_agrees
from tests.inelastic.test_elements import ORDERS
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out, open_balance, same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.engine import threads
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.network import ELEMENTS

FLOW = "yield stress = 500 Pa; flow viscosity = {} Pa*s; retardation time = 1 ms"
CLAY = FLOW.format(20)
SHEAR, BULK, LIMIT = 10e3 / 2.6, 10e3 / 1.2, 500.0  # of ν = 0.3 [Pa]
BOX = {"size": "10, 10, 10", "top": "9.9 mm"}


def balance(recording):
    lost = recording.energy_arrays()[1][:, 4]
    assert (np.diff(lost) > -1e-12 * lost.max()).all()
    return open_balance(recording)


def measured(text, measure, **more):
    """Return times and the numbers of a log that is added to a scene."""
    text = text.replace("stress of high every 5 ms", f"{measure} every 5 ms")
    outcome, recording = carried_out(compiled_scene(text), **more)
    time, values = recording.log_arrays(measure)
    return outcome, recording, time, values


def test_tissues_tell_how_elements_yield():
    body = "region top where z > 5 mm { tissue is stiff }"
    text = scene(CLAY, size="5, 5, 10", top="9.9 mm", body=body)
    stiff = "tissue stiff { Young's modulus = 30 kPa; density = 1000 kg/m^3 }\nbody"
    network = compiled_scene(text.replace("body", stiff, 1)).network
    (made,) = network.of_kind("elements")
    assert made.yielding.limit.tolist() == [500.0, np.inf]
    assert made.yielding.viscosity.tolist() == [20.0, np.inf]
    # Six numbers at eight points, three to a node.
    assert len(network.remembering(ELEMENTS)) == len(made.hidden) == 16
    for memory in ("", "yield stress is none; flow viscosity = 2 Pa*s",
                   "yield stress = 1 kPa; flow viscosity is none"):  # fmt: skip
        network = compiled_scene(scene(memory)).network
        (made,) = network.of_kind("elements")
        assert made.yielding is None
        assert network.memory == slice(8, 8)
        assert made.loss == ""


# --- closed forms -----------------------------------------------------------------------------


def test_a_small_shear_bears_the_yield_stress_over_the_root_of_three_and_what_flow_adds():
    script = """at 0 s: fix low
      from 0 s to 100 ms: move high by (1e-3, 0, 0) mm using constant speed"""
    soft = FLOW.format(0.02).replace("500 Pa", "0.2 Pa").replace("retardation time = 1 ms", "")
    _, recording = carried_out(compiled_scene(scene(soft, script=script)))
    time, force = recording.log_arrays("force of high")
    rate, limit = 2e-4 / 0.1, 0.2 / np.sqrt(3.0)  # of strain; Y/√3
    begins = limit / (SHEAR * rate)
    # Beyond it, τ' = μ (γ' - (τ - Y/√3) 3/η).
    pace = 3.0 * SHEAR / 0.02
    plateau = 0.02 * rate / 3.0
    flowing = limit + plateau * (1.0 - np.exp(-pace * np.maximum(time - begins, 0.0)))
    expected = np.where(time < begins, SHEAR * rate * time, flowing)
    np.testing.assert_allclose(force[:, 0] / 25e-6, expected, atol=2e-6 * limit)
    assert expected[-1] == pytest.approx(limit, rel=2e-4)


def sheared(time, gamma, viscosity, law):
    """Return the shear stress of a point that yields, by be = Fe Feᵀ in space.

    Args:
        gamma: Shear at a time, and its rate.
        law: Coefficients of dev b and dev b⁻¹ in the stress [Pa].
    """
    one = np.eye(3)

    def stress(b):
        s = law[0] * b - law[1] * np.linalg.inv(b)
        return s - np.trace(s) / 3.0 * one

    def change(t, y):
        b = y.reshape(3, 3)
        rate = np.zeros((3, 3))
        rate[0, 2] = gamma(t)[1]
        s = stress(b)
        size = np.sqrt(1.5 * (s * s).sum())
        pace = 1.5 * max(size - LIMIT, 0.0) / viscosity / size if size > 0.0 else 0.0
        return (rate @ b + b @ rate.T - pace * (s @ b + b @ s)).ravel()

    found = solve_ivp(change, (0.0, time[-1]), one.ravel(), "DOP853", time, rtol=1e-11,
                      atol=1e-13, max_step=1e-3)  # fmt: skip
    return np.array([stress(b)[0, 2] for b in found.y.T.reshape(-1, 3, 3)])


@pytest.mark.parametrize("law", ["", "; solid law is mooney rivlin { share = 0.4 }"])
def test_a_large_shear_and_back_is_that_of_the_equation_in_space(law):
    script = """at 0 s: fix low
      from 0 s to 50 ms: move high by (4, 0, 0) mm using constant speed
      from 50 ms to 100 ms: move high by (-4, 0, 0) mm using constant speed"""
    memory = FLOW.format(20).replace("retardation time = 1 ms", "") + law
    _, recording = carried_out(compiled_scene(scene(memory, script=script)))
    time, force = recording.log_arrays("force of high")

    def gamma(t):
        return (16.0 * t, 16.0) if t < 0.05 else (16.0 * (0.1 - t), -16.0)

    parts = (0.6 * SHEAR, 0.4 * SHEAR) if law else (SHEAR, 0.0)
    expected = sheared(time, gamma, 20.0, parts)
    found = force[:, 0] / 25e-6
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    # It has flowed: it is pushed back to its drawn shape.
    assert expected[-1] < -LIMIT / np.sqrt(3.0)
    assert np.abs(balance(recording)).max() < 1e-7


PLANES = """symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"""


def bar(memory, script, duration="0.4 s"):
    """Return a scene of an eighth of a cube, whose sides are free."""
    text = scene(memory, script=script, duration=duration, method="tolerance = 1e-6")
    return text.replace("environment {", f"environment {{ {PLANES}; damping = 0.0004 N*s/m;")


def drawn_by(nominal, time, viscosity):
    """Return the logarithms of length and plastic length of a bar under a constant force."""

    def elastic(plastic):
        def left(logs):
            a, b = np.exp(logs)  # elastic stretches along and across
            j = a * b * b
            part = SHEAR * j ** (-2.0 / 3.0) * (a * a - b * b)
            volume = BULK * (j - 1.0) * j
            along = nominal * a * np.exp(plastic)
            return [(2.0 / 3.0 * part + volume - along) / SHEAR, (volume - part / 3.0) / SHEAR]

        found = root(left, [0.0, 0.0], tol=1e-12)
        assert np.abs(left(found.x)).max() < 1e-9
        return found.x

    def rate(_, plastic):
        stress = nominal * np.exp(elastic(plastic[0])[0] + plastic[0])
        return [max(stress - LIMIT, 0.0) / viscosity]

    found = solve_ivp(rate, (0.0, time[-1]), [0.0], "DOP853", time, rtol=1e-10, atol=1e-12)
    plastic = found.y[0]
    return np.array([elastic(p)[0] + p for p in plastic]), plastic


def test_a_bar_flows_above_its_yield_stress_and_stays_longer():
    # 900 Pa on 25 mm² are 22.5 mN.
    script = """at 0 s: push high with (0, 0, 22.5) mN
      at 0.3 s: stop pushing high"""
    fluid = FLOW.format(400).replace("; retardation time = 1 ms", "")
    text = bar(fluid, script, "1 s").replace("every 5 ms", "every 20 ms")
    text = text.replace("stress of high", "plastic strain of high")
    outcome, recording = carried_out(compiled_scene(text))
    time, strain = recording.log_arrays("plastic strain of high")
    frames, position = recording.frame_arrays()[:2]
    length = np.log(position[:, 7, 2] / 5e-3)
    pulled = (time > 0.0) & (time < 0.301)
    logs, plastic = drawn_by(900.0, time[pulled], 400.0)
    # Inertia and the damping of the first swing are what is left.
    np.testing.assert_allclose(strain[pulled, 0], plastic, atol=0.02 * plastic[-1])
    np.testing.assert_allclose(length[1:][frames[1:] < 0.301][3:-1], logs[3:-1], atol=0.01)
    assert plastic[-1] > 0.3
    # Without the force, the bar keeps what it has flowed by.
    assert strain[-1, 0] == pytest.approx(strain[pulled][-1, 0], rel=0.02)
    assert length[-1] == pytest.approx(strain[-1, 0], abs=2e-3)
    width = np.log(position[-1, 7, 0] / 5e-3)
    assert width == pytest.approx(-0.5 * strain[-1, 0], abs=2e-3)
    assert np.abs(balance(recording)).max() < 1e-6
    assert outcome.kind == "done"


def test_a_bar_below_its_yield_stress_keeps_its_shape():
    script = "at 0 s: push high with (0, 0, 5) mN; at 0.3 s: stop pushing high"
    text = bar(CLAY, script).replace("stress of high", "plastic strain of high")
    _, recording = carried_out(compiled_scene(text))
    assert not recording.log_arrays("plastic strain of high")[1].any()
    elastic = carried_out(compiled_scene(bar("retardation time = 1 ms", script)))[1]
    one, two = (each.frame_arrays()[1][:, :8] for each in (recording, elastic))
    np.testing.assert_allclose(one, two, atol=1e-8)


# --- other forces, statics, events ------------------------------------------------------------

MIXED = (
    CLAY
    + """; relaxing share = 40 %; relaxation time = 10 ms
  solid law is yeoh { second = 2; third = 1 }; fibre modulus = 20 kPa"""
)


def test_the_reference_agrees_on_large_strains():
    script = PULLED.replace("(3, 0, 2)", "(4, 0, 3)")
    text = scene(MIXED, ratio=0.45, script=script, body="fibres = (1, 0, 1)",
                 method="tolerance = 1e-5")  # fmt: skip
    the_reference_agrees(text, position=1e-6, balance=1e-6, force=1e-5)


def test_settling_keeps_what_has_flowed():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (3, 0, 1) mm using smooth profile
      at 21 ms: { release high; settle }"""
    text = scene(CLAY, ratio=0.4, script=script, duration="22 ms", method="tolerance = 1e-4")
    text = text.replace("every 5 ms", "every 1 ms")
    outcome, _ = carried_out(compiled_scene(text))
    state, drawn = outcome.state, outcome.state.network.position
    (made,) = state.of_kind("elements")
    assert made.yielding.plastic(state.velocity, 8).equivalent.max() > 0.05
    top = drawn[:8, 2] > 4.9e-3
    assert (state.position - drawn)[:8][top, 0].mean() > 3e-4
    found = validated(text)
    assert found.verdict == "kept"
    assert quantity(found, "position").error < 1e-5


def test_what_is_cut_or_broken_takes_its_flow_along():
    script = """at 0 s: fix low
      from 0 s to 20 ms: move high by (2, 0, 4) mm using smooth profile
      at 30 ms: cut block along plane through (0, 0, 7.5) mm facing (0, 0, 1)"""
    text = scene(CLAY, size="10, 10, 15", top="14.9 mm", script=script,
                 method="tolerance = 1e-6")  # fmt: skip
    outcome, recording = carried_out(compiled_scene(text))
    (made,) = outcome.state.fields
    assert made.item_count == 8
    assert len(made.hidden) == 8 * 16
    assert np.abs(balance(recording)).max() < 1e-6


def test_elements_that_yield_break_at_a_strain_that_includes_the_plastic_one():
    script = """at 0 s: fix low
      from 0 s to 0.1 s: move high by (0, 0, 8) mm using constant speed"""
    memory = CLAY + "; breaking strain = 60 %"
    text = scene(memory, script=script, body="rupture is allowed", duration="0.11 s")
    outcome, recording, time, strain = measured(text, "plastic strain of high")
    broke = [e for e in recording.events if "exceeded the breaking strain" in str(e)]
    assert broke
    force = recording.log_arrays("force of high")[1]
    # One element, whose ends cannot become narrower: its mean stretch is that of its ends.
    assert np.abs(force[time < 0.0374]).max() > 1e-3
    assert not force[time > 0.0376].any()
    assert strain[time < 0.037][-1, 0] > 0.2
    assert np.abs(balance(recording)).max() < 1e-6
    assert not outcome.state.fields or outcome.state.fields[0].item_count == 0


MISTAKES = {
    "yield stress = 1 kPa": "TIS304: a yield stress needs a flow viscosity",
    "flow viscosity = 1 Pa*s": "TIS304: a flow viscosity needs a yield stress",
    CLAY + "; strength = 2 kPa":
        "TIS306: a strength is not available for elements that yield: flow limits what they "
        "bear",
    CLAY + "; toughness = 20 J/m^2":
        "TIS306: a toughness is not available for elements that yield: flow limits what they "
        "bear",
}  # fmt: skip


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


def test_threads_change_no_bit(monkeypatch):
    monkeypatch.setattr(threads, "LEAST_SPRINGS", 5000)
    script = """at 0 s: fix low
      from 0 s to 0.2 ms: move high by (3, 0, 2) mm using smooth profile"""
    text = scene(MIXED, size="100, 95, 85", top="84.9 mm", script=script, duration="0.2 ms",
                 body="fibres = (1, 0, 1)",
                 method="integrator is velocity verlet; step = 0.02 ms")  # fmt: skip
    compiled = compiled_scene(text.replace("every 5 ms", "every 0.2 ms"))
    one = same_on_two_threads(compiled, "force of high")
    (made,) = one.state.of_kind("elements")
    assert made.yielding.plastic(one.state.velocity, 8).equivalent.max() > 1e-3
