"""Springs that relax and yield, against closed forms.

Tolerances: runs ask for 1e-10 of the largest displacement, and 1e-8 is what is claimed. Forces
are c times as wrong as elongations; the largest force here is of the order of c times these.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from tests.inelastic.scenes import PLASTIC, STANDARD, ran, rod

C, C1, TAU, MASS = 100.0, 300.0, 0.02, 0.01
CLAIM = 1e-8
PRONY = (
    "relaxing constant = 300 N/m; relaxation time = 5 ms; second relaxing constant = 80 N/m; "
    "second relaxation time = 20 ms; third relaxing constant = 20 N/m; "
    "third relaxation time = 0.1 s"
)  # fmt: skip
SERIES = ((300.0, 0.005), (80.0, 0.02), (20.0, 0.1))


def near(found, exact):
    assert np.abs(found - exact).max() <= CLAIM * np.abs(exact).max()


def held_ramp(time, speed, end, series):
    """Return the force of a spring that is drawn at a speed until a time, and held then."""
    drawn = np.minimum(time, end)
    force = C * speed * drawn
    for c1, tau in series:
        after = np.exp(-(time - drawn) / tau)
        force = force + c1 * speed * tau * (1.0 - np.exp(-drawn / tau)) * after
    return force


@pytest.mark.parametrize(
    ("memory", "series"), [(STANDARD, ((C1, TAU),)), (PRONY, SERIES)], ids=["standard", "prony"]
)
def test_a_spring_that_is_drawn_and_held_relaxes(memory, series):
    script = "from 0 s to 0.02 s: move bob by (2, 0, 0) mm using constant speed"
    found = ran(rod(memory=memory, script=script))
    near(found.tension, held_ramp(found.time, 0.1, 0.02, series))


def test_a_spring_that_is_held_from_the_start_relaxes():
    found = ran(rod(script="at 0 s: fix bob", length=22))
    near(found.tension, 0.002 * (C + C1 * np.exp(-found.time / TAU)))
    # All that the branch stored is lost in the end.
    lost = 0.5 * C1 * 0.002**2 * (1.0 - np.exp(-2.0 * found.time / TAU))
    near(found.lost, lost)


def linear(time, matrix, start):
    """Return what the linear system y' = A y makes of a start, shape (time, variable)."""
    return np.array([expm(matrix * t) @ start for t in time])


def swinging(*, omega=0.0, force=0.0):
    """Return A of y = (x, v, q, s, s') with a force F s on the mass, s' ' = -omega² s."""
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [-(C + C1) / MASS, 0.0, C1 / MASS, force / MASS, 0.0],
            [1.0 / TAU, 0.0, -1.0 / TAU, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, -(omega**2), 0.0],
        ]
    )


def test_a_mass_creeps_under_a_steady_force():
    script = "at 0 s: push bob with (0.1, 0, 0) N"
    found = ran(rod(script=script, duration="0.3 s"))
    exact = linear(found.time, swinging(force=0.1), np.array([0.0, 0.0, 0.0, 1.0, 0.0]))
    near(found.extension, exact[:, 0])
    near(found.tension, (C + C1) * exact[:, 0] - C1 * exact[:, 2])
    assert found.extension[-1] > 0.7 * 0.1 / C  # it was 0.25 at once, and has crept


def test_a_mass_under_a_harmonic_force_swings_as_known():
    omega = 2.0 * np.pi * 20.0
    script = "from 0 s to 0.3 s: push bob with (0.1, 0, 0) N using sine of 20 Hz"
    found = ran(rod(script=script, duration="0.3 s"))
    start = np.array([0.0, 0.0, 0.0, 0.0, omega])
    near(found.extension, linear(found.time, swinging(omega=omega, force=0.1), start)[:, 0])


@pytest.mark.parametrize("frequency", [1.0, 8.0, 60.0])
def test_storage_and_loss_stiffness(frequency):
    omega, size = 2.0 * np.pi * frequency, 1e-3
    length = 20 * TAU + 2.0 / frequency  # by then, nothing is left of how it began
    script = f"from 0 s to {length} s: move bob by (1, 0, 0) mm using sine of {frequency} Hz"
    found = ran(rod(script=script, duration=f"{length} s", every=f"{1 / (16 * frequency)} s"))
    late = found.time > 20 * TAU
    basis = np.array([np.sin(omega * found.time), np.cos(omega * found.time)])[:, late]
    storage, loss = np.linalg.lstsq(basis.T, found.tension[late] / size, rcond=None)[0]
    modulus = C + C1 * 1j * omega * TAU / (1.0 + 1j * omega * TAU)
    assert storage == pytest.approx(modulus.real, rel=CLAIM)
    assert loss == pytest.approx(modulus.imag, rel=10 * CLAIM)  # the smaller part of the force


# --- yield ------------------------------------------------------------------------------------

LIMIT, ETA = 0.2, 5.0


def test_a_spring_that_is_drawn_steadily_yields():
    speed, begin = 0.04, LIMIT / (C * 0.04)
    script = "from 0 s to 0.2 s: move bob by (8, 0, 0) mm using constant speed"
    found = ran(rod(memory=PLASTIC, script=script, duration="0.2 s"))
    beyond = np.maximum(found.time - begin, 0.0)
    exact = np.where(
        beyond > 0.0,
        LIMIT + ETA * speed * (1.0 - np.exp(-C * beyond / ETA)),
        C * speed * found.time,
    )
    near(found.tension, exact)
    near(found.flow, speed * found.time - exact / C)


def test_a_mass_that_is_pulled_above_the_yield_force_flows_and_keeps_its_length():
    # It begins in steady flow: drawn until the spring pulls as much, and as fast as that flows.
    force, speed = 0.5, (0.5 - LIMIT) / ETA
    script = f"""at 0 s: push bob with ({force}, 0, 0) N
      at 0 s: change velocity of bob to ({speed}, 0, 0) m/s
      at 0.05 s: {{ stop pushing bob; change damping to 2 N*s/m }}"""
    text = rod(memory=PLASTIC, script=script, length=25, duration="1 s")
    found = ran(text)
    flowing = found.time <= 0.05
    near(found.extension[flowing], 0.005 + speed * found.time[flowing])
    near(found.flow[flowing], speed * found.time[flowing])
    # Unloaded, it comes to rest at its new rest length, which it keeps.
    assert found.flow[-1] > speed * 0.05
    assert found.extension[-1] == pytest.approx(found.flow[-1], rel=1e-6)
    after = found.flow[found.time > 0.2]
    assert np.ptp(after) == 0.0


def test_without_a_yield_force_a_spring_is_a_fluid():
    script = "at 0 s: fix bob"
    memory = "yield force = 0 N; yield viscosity = 5 N*s/m"
    found = ran(rod(memory=memory, script=script, length=22))
    near(found.tension, 0.002 * C * np.exp(-C * found.time / ETA))


def test_pressure_makes_rest_lengths_shorter():
    found = ran(rod(memory=PLASTIC, script="at 0 s: fix bob", length=15))
    beyond = 0.005 * C - LIMIT
    near(found.tension, -LIMIT - beyond * np.exp(-C * found.time / ETA))
    assert (found.flow[1:] < 0.0).all()


def test_the_work_of_a_closed_cycle_is_what_it_dissipates():
    script = """from 0 s to 0.1 s: move bob by (6, 0, 0) mm using smooth profile
      from 0.1 s to 0.3 s: move bob by (-12, 0, 0) mm using smooth profile
      from 0.3 s to 0.4 s: move bob by (6, 0, 0) mm using smooth profile"""
    found = ran(rod(memory=PLASTIC, script=script, duration="0.4 s", every="0.2 ms"))
    kinetic, elastic, _, work, lost, _ = found.energies[-1]
    assert work - elastic - kinetic == pytest.approx(lost, rel=CLAIM)
    # The area of the loop in the recorded forces, by the trapezoidal rule (second order).
    area = np.sum(0.5 * (found.tension[1:] + found.tension[:-1]) * np.diff(found.extension))
    assert area == pytest.approx(work, rel=1e-5)
    assert lost > 4e-4


def test_branches_and_yield_together_store_and_lose_what_is_known():
    # Maxwell's branch beside a spring that flows without a limit: two rates, one matrix.
    memory = STANDARD + "; yield force = 0 N; yield viscosity = 5 N*s/m"
    found = ran(rod(memory=memory, script="at 0 s: fix bob", length=22))
    # y = (q, p), e = 2 mm - p, S = C e + C1 (e - q).
    matrix = np.zeros((3, 3))
    matrix[0] = [-1.0 / TAU, -1.0 / TAU, 0.002 / TAU]
    matrix[1] = [-C1 / ETA, -(C + C1) / ETA, (C + C1) * 0.002 / ETA]
    q, p, _ = linear(found.time, matrix, np.array([0.0, 0.0, 1.0])).T
    near(found.flow, p)
    near(found.tension, C * (0.002 - p) + C1 * (0.002 - p - q))
