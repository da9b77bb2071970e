"""What solids and walls of elements that yield are checked for in whole runs."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out, open_balance

FLOW = "yield stress = 500 Pa; flow viscosity = {} Pa*s; retardation time = 1 ms"
CLAY = FLOW.format(20)
SHEAR, BULK, LIMIT = 10e3 / 2.6, 10e3 / 1.2, 500.0  # of ν = 0.3 [Pa]


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


# --- closed forms -----------------------------------------------------------------------------


def follows_a_small_shear(time, stress):
    """Check the stress of an even shear of 0.2 ‰ in 0.1 s, of 0.2 Pa and 0.02 Pa s.

    Args:
        stress: In shear [Pa].
    """
    rate, limit = 2e-4 / 0.1, 0.2 / np.sqrt(3.0)  # of strain; Y/√3
    begins = limit / (SHEAR * rate)
    # Beyond it, τ' = μ (γ' - (τ - Y/√3) 3/η).
    pace, plateau = 3.0 * SHEAR / 0.02, 0.02 * rate / 3.0
    flowing = limit + plateau * (1.0 - np.exp(-pace * np.maximum(time - begins, 0.0)))
    expected = np.where(time < begins, SHEAR * rate * time, flowing)
    np.testing.assert_allclose(stress, expected, atol=2e-6 * limit)
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


def follows_a_large_shear_and_back(time, stress, law, *, close):
    """Check the stress of an even shear to 0.8 in 50 ms and back, of 20 Pa s.

    Args:
        stress: In shear [Pa].
        law: See ``sheared``.
        close: Difference that is allowed, relative to the largest.
    """

    def gamma(t):
        return (16.0 * t, 16.0) if t < 0.05 else (16.0 * (0.1 - t), -16.0)

    expected = sheared(time, gamma, 20.0, law)
    np.testing.assert_allclose(stress, expected, atol=close * np.abs(expected).max())
    # It has flowed: it is pushed back to its drawn shape.
    assert expected[-1] < -LIMIT / np.sqrt(3.0)


def drawn_by(nominal, time, viscosity):
    """Return the logarithms of length and plastic length of a bar under a constant force."""

    def elastic(plastic):
        def left(logs):
            a, b = np.exp(logs)  # elastic stretches along and across
            j = a * b * b
            part = SHEAR * j ** (-2.0 / 3.0) * (a * a - b * b)
            volume = BULK * np.log(j)
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


def flows_above_its_yield_stress(recording, logs):
    """Check what is pulled with 900 Pa for 0.3 s, of 400 Pa s, and is free afterwards.

    Args:
        logs: Logarithms of the stretches along and across, shape (frame, 2).
    """
    time, strain = recording.log_arrays("plastic strain of high")
    frames = recording.frame_arrays()[0]
    pulled = (time > 0.0) & (time < 0.301)
    expected, plastic = drawn_by(900.0, time[pulled], 400.0)
    # Inertia and the damping of the first swing are what is left.
    np.testing.assert_allclose(strain[pulled, 0], plastic, atol=0.02 * plastic[-1])
    along = logs[1:, 0][frames[1:] < 0.301]
    np.testing.assert_allclose(along[3:-1], expected[3:-1], atol=0.01)
    assert plastic[-1] > 0.3
    # Without the force, it keeps what it has flowed by, and is thinner by half of that.
    assert strain[-1, 0] == pytest.approx(strain[pulled][-1, 0], rel=0.02)
    left = strain[-1, 0] * np.array([1.0, -0.5])
    np.testing.assert_allclose(logs[-1], left, rtol=0.0, atol=2e-3)
    assert np.abs(balance(recording)).max() < 1e-6


def keeps_its_shape(text, elastic):
    """Check that a body flows by nothing, and moves as one that cannot flow.

    Args:
        text, elastic: Scenes of both.
    """
    text = text.replace("stress of high", "plastic strain of high")
    found = compiled_scene(text)
    _, recording = carried_out(found)
    assert not recording.log_arrays("plastic strain of high")[1].any()
    other = carried_out(compiled_scene(elastic))[1]
    one, two = (each.frame_arrays()[1] for each in (recording, other))
    np.testing.assert_allclose(one, two, atol=1e-8)


# --- events -----------------------------------------------------------------------------------


def settles_as_it_flowed(text, axis, kind, *points):
    """Check that a body that is released settles, and stays sheared along x.

    Args:
        axis: Along which its fixed side and its moved one are 5 mm apart.
        points: Of one element, if these have several.
    """
    outcome, _ = carried_out(compiled_scene(text))
    state, network = outcome.state, outcome.state.network
    (made,) = state.of_kind(kind)
    assert made.yielding.equivalent(state.velocity, *points).max() > 0.05
    drawn = network.position
    moved = state.position - drawn
    assert moved[drawn[:, axis] > 4.9e-3, 0].mean() > 3e-4
    found = validated(text)
    assert found.verdict == "kept"
    assert quantity(found, "position").error < 1e-5


def breaks_as_it_flows(text, *, borne):
    """Check that a body breaks at 37.5 ms, having flowed; return its outcome and force later.

    Args:
        borne: Force that it bears before [N].
    """
    outcome, recording, time, strain = measured(text, "plastic strain of high")
    assert [e for e in recording.events if "exceeded the breaking strain" in str(e)]
    force = recording.log_arrays("force of high")[1]
    # Held ends cannot become narrower: the mean stretch is that of the ends.
    assert np.abs(force[time < 0.0374]).max() > borne
    assert strain[time < 0.037][-1, 0] > 0.2
    assert np.abs(balance(recording)).max() < 1e-6
    return outcome, force[time > 0.0376]


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
