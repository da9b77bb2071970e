"""Derivatives of the motion are those of what is computed, steps and all."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse

from tests.learn.precise import LONG, positions
from tests.learn.trials import difference, sheet
from tests.learn.tubes import tube
from tissuec.compiler.compile import Compiled
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.dirk import Dirk
from tissuec.engine.integrators.explicit import Explicit
from tissuec.engine.integrators.tableaus import runge_kutta
from tissuec.learn.derivatives.event_recording import EventRecorder
from tissuec.learn.derivatives.methods import choose
from tissuec.learn.derivatives.motion import Motion
from tissuec.learn.parameters.numbers import NETWORK, STATE, NumberOrder, every_field

METHODS = {
    "velocity verlet": 1e-3, "rkn4": 2e-3, "trbdf2": 2e-3, "esdirk43": 2e-3, "dop853": 5e-3,
    "classical runge-kutta": 2e-3, "alexander": 2e-3,
}  # fmt: skip
DIAGONAL = 1.0 - np.sqrt(0.5)


class ClassicalRungeKutta(Explicit):
    """Kutta's method of fourth order, as it would be added: a tableau and what it costs."""

    order = 4
    tableau = runge_kutta(
        np.array(
            [
                [0, 0, 0, 0, 0], [1 / 2, 0, 0, 0, 0], [0, 1 / 2, 0, 0, 0], [0, 0, 1, 0, 0],
                [1 / 6, 1 / 3, 1 / 3, 1 / 6, 0],
            ]
        )
    )  # fmt: skip


class Alexander(Dirk):
    """Alexander's implicit method of second order, whose first stage is implicit, too.

    R. Alexander, SIAM J. Numer. Anal. 14:1006 (1977).
    """

    order = 2
    tableau = runge_kutta(np.array([[DIAGONAL, 0.0], [1.0 - DIAGONAL, DIAGONAL]]))


@pytest.fixture(autouse=True)
def with_methods_of_ones_own(monkeypatch):
    """Add two methods of which nothing but their tableaus is known."""
    dict(INTEGRATORS)  # its own members
    own = {"classical runge-kutta": ClassicalRungeKutta, "alexander": Alexander}
    monkeypatch.setattr(INTEGRATORS, "_members", {**INTEGRATORS._members, **own})


@pytest.fixture(scope="module")
def scene():
    return tube()


def motion_of(
    scene: Compiled, name: str, step: float, times: NDArray[np.float64], stop: float = 0.05
) -> tuple[Motion, NDArray[np.float64]]:
    network = scene.network
    fields = every_field(scene.plan, network)
    order = NumberOrder.of(network, 0, fields)
    vector = order.vector(network, fields)
    chosen = choose(name, step, network, plan=scene.plan, duration=stop)
    schedule = EventRecorder(scene.plan, chosen.stepping, order, step).schedule(
        network, vector, stop
    )
    return Motion(schedule, chosen.stepping, order, step, times), vector


def apart_from_long_doubles(scene: Compiled, directions: int) -> NDArray[np.float64]:
    """Return how far derivatives by all numbers are from differences, shape (direction,).

    1990 masses, spring constants, viscosities and rest lengths; 1000 steps with a moved and a
    released end, a cut and a change. Differences of 64-bit mantissas with a step of 1e-6 are
    good to about 1e-11 of the derivative.
    """
    times = np.array([0.0, 10e-3, 24.95e-3, 30e-3, 45e-3, 50e-3])
    motion, vector = motion_of(scene, "velocity verlet", 50e-6, times)
    assert motion.steps == 1000
    random = np.random.default_rng(1)
    target = motion.forward(vector).x + 1e-3 * random.standard_normal((len(times), 480))
    left = motion.forward(vector).x - target
    gradient = motion.backward(left, np.zeros_like(left))
    counts = [round((leg.stop - leg.start) / 50e-6) for leg in motion.schedule.legs]

    def error(moved):
        numbers = {n: motion.order.array(moved, n) for n in motion.order.sizes}
        found = positions(motion.schedule, numbers, counts, times)
        return 0.5 * ((found.reshape(len(times), -1) - target.astype(LONG)) ** 2).sum()

    inner, found = np.arange(1990), []
    for _ in range(directions):
        way = np.zeros(len(vector), dtype=LONG)
        way[inner] = vector[inner] * random.standard_normal(len(inner)) * 0.1
        step = LONG(1e-6)
        difference = (error(vector + step * way) - error(vector - step * way)) / (2 * step)
        found.append(abs(float(gradient @ way) / float(difference) - 1.0))
    return np.array(found)


@pytest.mark.skipif(np.finfo(LONG).eps > 1e-18, reason="long doubles are doubles here")
def test_the_gradient_by_all_numbers_agrees_with_differences_of_long_doubles(scene):
    assert apart_from_long_doubles(scene, 20).max() < 1e-6


@pytest.mark.parametrize("name", METHODS)
def test_adjoint_and_changes_are_transposes(scene, name):
    # Both are exact up to rounding, which 100 steps of a net with 480 unknowns enlarge.
    times = np.array([3.3e-3, 20e-3, 25e-3, 33.3e-3, 50e-3])
    motion, vector = motion_of(scene, name, METHODS[name], times)
    random = np.random.default_rng(2)
    motion.forward(vector)
    by_x, by_v = random.standard_normal((2, len(times), 480))
    gradient = motion.backward(by_x, by_v)
    some = random.standard_normal((len(vector), 4)) * np.abs(vector)[:, None]
    total = np.zeros(4)

    def visit(sample, tx, tv):
        total[:] += by_x[sample] @ tx + by_v[sample] @ tv

    motion.forward_with(vector, sparse.csr_matrix(some), visit)
    assert total == pytest.approx(gradient @ some, rel=1e-10)


@pytest.mark.parametrize("name", METHODS)
def test_every_array_has_its_derivative(scene, name):
    check_derivatives(scene, name)


@pytest.mark.parametrize("name", ["velocity verlet", "esdirk43"])
def test_dashpots_of_elongation_and_speed_have_their_derivatives(name):
    check_derivatives(
        sheet(
            "  from 0 s to 20 ms: move right by (2, 3, 1) mm using smooth profile",
            tissue="; viscous force of e and w = d * exp(5 * e / rest length) * w",
        ),
        name,
    )


def check_derivatives(scene, name):
    # Sixth-order differences with a step of 1e-3: h^6 and rounding over h leave 1e-8 or so.
    times = np.array([3.3e-3, 27e-3, 50e-3])
    motion, vector = motion_of(scene, name, METHODS[name], times)
    random = np.random.default_rng(3)
    weight = random.standard_normal((len(times), scene.network.position.size))
    motion.forward(vector)
    gradient = motion.backward(weight, np.zeros_like(weight))
    for array in (*NETWORK, *STATE):
        part = motion.order.places[array]
        way = np.zeros_like(vector)
        size = {"rest": 0.02, "position": 0.005, "velocity": 0.05}.get(array, 1.0)
        typical = float(np.abs(vector[part]).max()) or 1.0
        way[part] = size * typical * random.standard_normal(part.stop - part.start) * 0.1
        found = difference(motion, vector, way, weight, step=1e-2)
        assert gradient @ way == pytest.approx(found, rel=2e-6), array


def test_memory_grows_with_the_root_of_the_steps(scene):
    motion, vector = motion_of(scene, "velocity verlet", 12.5e-6, np.array([50e-3]))
    motion.forward(vector)
    assert motion.steps == 4001  # one of them after what happens at the end
    assert len(motion._kept) <= 64 + len(motion.schedule.legs)
    assert max(len(stretch.times) for stretch in motion.stretches) <= 65


def test_methods_agree_on_the_motion(scene):
    times = np.linspace(0.0, 50e-3, 11)
    found = {}
    steps = {
        "dop853": 1e-3, "velocity verlet": 25e-6, "esdirk43": 5e-4,
        "classical runge-kutta": 5e-4, "alexander": 1e-4,
    }  # fmt: skip
    for name, step in steps.items():
        motion, vector = motion_of(scene, name, step, times)
        found[name] = motion.forward(vector).x
    moved = np.abs(found["dop853"] - found["dop853"][0]).max()
    # Errors of Verlet are (h ω)² / 24 a swing, with h ω = 2e-3; those of ESDIRK h³.
    limits = {
        "velocity verlet": 1e-5, "esdirk43": 1e-4,
        "classical runge-kutta": 1e-4, "alexander": 1e-4,
    }  # fmt: skip
    for name, allowed in limits.items():
        assert np.abs(found[name] - found["dop853"]).max() < allowed * moved
