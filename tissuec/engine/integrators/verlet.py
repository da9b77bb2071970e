"""Velocity Verlet with predicted velocity: one force per step, second order.

x' = x + h v + h²/2 a(x, v);  ṽ = v + h a;  a' = a(x', ṽ);  v' = v + h/2 (a + a').
R. D. Groot, P. B. Warren, J. Chem. Phys. 107:4423 (1997), with λ = 1 for the prediction from
the step's start, which is λ = ½ after the first half kick. A force that saw the velocity of the
half step would be of first order.
"""

from math import sqrt

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, Integrator
from tissuec.engine.integrators.constant_steps import propose
from tissuec.engine.integrators.tableaus import nystrom
from tissuec.forces.accelerations import force, place
from tissuec.kernels.records import LOOKED, Net, Work
from tissuec.kernels.vectors import correct, drift, quadrature

RESULT = 2  # stages are both ends, the velocity of the second one predicted
FOR_X = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
FOR_V = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 0.0]])


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    x, v, a = work.x[1 - current], work.v[1 - current], work.a[1 - current]
    h = end - time
    drift(work.x[current], work.v[current], work.a[current], h, x, v, work.team)
    place(end, x, v, net)
    # Row 1 of the powers belongs to the start, row 2 to the end, as in ``prepare``.
    near = force(end, x, v, a, work.power[2], net)
    work.effort[0] += 1
    before, split = work.a[current], 3 * work.moving.size
    # Hidden nodes are apart in the estimates. Driven ones have no acceleration.
    internal = work.each[work.moving.size :]
    change = correct(before, a, h, v, work.moving, work.team)
    of_internal = correct(before[split:], a[split:], h, v[split:], internal, work.team)
    work.errors[0], work.errors[1] = h * h / 6.0 * change, h / 6.0 * of_internal
    return near


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the largest local errors, as ``Integrator.estimate`` does; 0 for velocities."""
    return work.errors[0], 0.0, work.errors[1]


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J].

    The error of the trapezoidal rule is h³/12 P''. With the rate of P in the step before, that
    is h²/12 times the change of that rate if both steps are equal, and less after a longer one.
    """
    h, x, v = end - time, work.x[1 - current], work.v[1 - current]
    weights = work.tableau.for_v[RESULT, : RESULT + 1]
    quadrature(work.ledger[current], h, weights, work.power, work.ledger[1 - current])
    worst = 0.0
    for k in range(2):
        # Not a number, and so no larger, where no step came before.
        change = abs((work.power[2, k] - work.power[1, k]) / h - work.trend[k])
        if change > worst:
            worst = change
    # The next step begins with the corrected velocity; powers of predicted ones would jump.
    force(end, x, v, work.trial_x, work.power[2], net)
    work.effort[LOOKED] += 1
    for k in range(2):
        work.trend[k] = (work.power[2, k] - work.power[1, k]) / h
    return h * h / 12.0 * worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Complete an accepted step; nothing is left to do."""
    return False


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Leave it at the rows that are known: velocity and accelerations at both ends."""


@INTEGRATORS.member("velocity verlet")
class VelocityVerlet(Integrator):
    """Velocity Verlet: symplectic without viscosity, one force evaluation per step.

    x' = x + h v + h²/2 a and v' = v + h/2 (a + a'), where a' sees the predicted velocity
    v + h a (Groot & Warren 1997), so that it stays of second order with viscosity. Cheapest
    for coarse tolerances; for fine ones its small steps cost more than a high order.
    """

    order = 2
    symplectic = True
    evaluations = 1
    rows = 3
    end_row = 2
    control_order = 2.0
    safety = 0.5
    share = 0.0125
    looks = 2
    nearness = 0.97
    tableau = nystrom(FOR_X, FOR_V, FOR_V.sum(axis=1), carries=True)
    # Cubic Hermite interpolation of x through x, v and of v through v, a at both ends.
    dense_x = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -0.5], [0.0, -0.5, 0.5]])
    dense_v = np.array([[0.0, 1.0, 0.0], [0.0, -0.5, 0.5], [0.0, 0.0, 0.0]])
    embedded_x = np.zeros((0, rows))

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    prepare = staticmethod(prepare)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return 2 (√(1 + 4ζ²) - 2ζ) / ω, the limit of a damped oscillator."""
        return 2.0 * (sqrt(1.0 + 4.0 * zeta * zeta) - 2.0 * zeta) / omega if omega else np.inf
