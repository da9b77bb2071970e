"""The reference's own formulas: against finite differences, and against those of a run."""

import numpy as np
import pytest

from tests.hand_net import chain, make_net, order, start
from tissuec.mechanics import observables
from tissuec.validate.equations import Equations, incidence_matrix

RNG = np.random.default_rng(7)


def tangle(*, damping=0.3):
    """Return a state of six nodes and nine random springs, two nodes held, under load."""
    ends = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (0, 3), (1, 4), (2, 5)]
    network = make_net(
        RNG.normal(size=(6, 3)),
        ends,
        mass=RNG.uniform(0.5, 2.0, 6),
        stiffness=RNG.uniform(1.0, 9.0, 9),
        damping=damping * RNG.uniform(0.5, 1.5, 9),
        rest=RNG.uniform(0.5, 1.5, 9),
        velocity=RNG.normal(size=(6, 3)),
    )
    state = start(network, gravity=(0.3, 0.0, -9.81), drag=0.2)
    groups = {"held": [1], "moved": [4], "pushed": [0, 3]}
    order("fix held", groups).apply(state, Silent())
    move = order("move moved", groups, duration=1.0, by=(1.0, 2.0, 3.0), using="smooth")
    move.apply(state, Silent())
    order("push pushed", groups, with_=(1.0, 0.0, 2.0)).apply(state, Silent())
    state.alive = np.arange(9) != 6
    return state


class Silent:
    """An queue that forgets."""

    def add(self, time, action): ...

    def land(self, times): ...


def unknowns(state, equations):
    return equations.gather(state.position, state.velocity, 0.0, 0.0)


def test_jacobian_is_the_derivative_of_the_rate():
    state = tangle()
    equations = Equations(state, 1.0)
    y, time, h = unknowns(state, equations), 0.4, 1e-6
    exact = equations.jacobian(time, y).toarray()[:-2]
    steps = h * np.eye(len(y))
    rates = [equations.rate(time, y + s) - equations.rate(time, y - s) for s in steps]
    central = (np.array(rates).T / (2.0 * h))[:-2]
    # Central differences: h² from truncation, 1e-16 / h from rounding.
    assert exact == pytest.approx(central, abs=1e-7)


def test_forces_are_minus_the_slope_of_the_elastic_energy():
    state = tangle(damping=0.0)
    equations = Equations(state, 1.0)
    moved, still = RNG.normal(size=(6, 3)), np.zeros((6, 3))
    forces = equations.node_forces(equations.pull(0.0, moved, still))
    h = 1e-6
    for node in range(6):
        for axis in range(3):
            shift = np.zeros((6, 3))
            shift[node, axis] = h
            rise = [equations.energies(0.0, moved + s, still).elastic for s in (shift, -shift)]
            slope = (rise[0] - rise[1]) / (2.0 * h)
            assert forces[node, axis] == pytest.approx(-slope, abs=1e-7)


def test_independent_formulas_agree_with_those_of_logs():
    state = tangle()
    equations = Equations(state, 1.0)
    moved = state.position - state.network.position
    springs = equations.pull(0.0, moved, state.velocity)
    theirs = observables.inner_forces(state, 0.0, state.position, state.velocity).node
    assert equations.node_forces(springs) == pytest.approx(theirs, rel=1e-12, abs=1e-12)
    ours = equations.energies(state.time, moved, state.velocity)
    assert ours == pytest.approx(
        observables.energies(state, state.time, state.position, state.velocity),
        rel=1e-12,
    )


def test_energy_rises_by_work_less_what_is_lost():
    """d/dt (kinetic + elastic + gravity) along the motion is exactly dW/dt - dD/dt."""
    state = tangle()
    equations = Equations(state, 1.0)
    y, time, h = unknowns(state, equations), 0.4, 1e-5

    def total(t, z):
        return equations.energies(t, *equations.spread(t, z)).total

    rate = equations.rate(time, y)
    slope = (total(time + h, y + h * rate) - total(time - h, y - h * rate)) / (2.0 * h)
    assert slope == pytest.approx(rate[-2] - rate[-1], rel=1e-6)  # h² and rounding over h


def test_a_spring_of_no_length_pulls_nowhere():
    network = make_net([[0, 0, 0], [0, 0, 0]], [[0, 1]], rest=1.0, damping=1.0)
    equations = Equations(start(network), 1.0)
    rate = equations.rate(0.0, unknowns(start(network), equations))
    assert not rate.any()
    assert np.isfinite(equations.jacobian(0.0, np.zeros(14)).toarray()).all()


def test_incidence_matrix_takes_differences_along_springs():
    network = chain(4)
    b = incidence_matrix(network.springs.ends, 4)
    assert (b @ network.position).tolist() == [[1.0, 0.0, 0.0]] * 3


def test_far_from_the_origin_no_digits_are_lost():
    """The same net, a million lengths away: positions round there, displacements do not."""
    rates = []
    for offset in (0.0, 2.0**20):
        network = chain(3, spacing=1.0)
        moved = make_net(network.position + offset, network.springs.ends)
        equations = Equations(start(moved), 1.0)
        y = np.zeros(20)
        y[3] = 1e-9
        rates.append(equations.rate(0.0, y))
    assert (rates[0] == rates[1]).all()
    assert rates[0].any()
