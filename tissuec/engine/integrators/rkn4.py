"""RKN4: a Runge-Kutta-Nyström method of fourth order with long stable steps.

Three evaluations of the forces per step: the last stage is at the end of the step, with a
velocity that is predicted, and is the first stage of the next step, as in velocity Verlet.

The nodes are 0, 4/5, 1/2 and 1. Velocities are those of Kutta's family of four stages whose
weights are Simpson's, so that the stage at 4/5 only feeds others. The conditions of order 4 for
positions leave two numbers free, that node and the 1/8 of its stage, which were chosen for long
stable steps: an oscillator stays bounded up to h ω = √12, and at damping ratios of .1 and .3 up
to 3.1 and 2.4.

Of order 4 for forces that depend on positions and time. The predicted velocity of the carried
stage makes that order 3 for forces that depend on velocities; as dashpots brake slow motions
the least, their part in the error is small.
"""

import numpy as np

from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.integrators.explicit import Explicit, evaluate_stage, largest_of_booked
from tissuec.engine.integrators.tableaus import enter_stage, nystrom
from tissuec.forces.accelerations import force
from tissuec.kernels.records import LOOKED, Floats, Net, Tableau, Work
from tissuec.kernels.vectors import quadrature

RESULT = 4  # stages before it are evaluated; the last of them is at the end, too
FINE = 1e-2  # on the way to the limit of stability, h ω
FOR_X = np.array([
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [1 / 8, 0.0, 0.0, 0.0, 0.0],
    [19 / 192, 5 / 192, 0.0, 0.0, 0.0],
    [1 / 6, 0.0, 1 / 3, 0.0, 0.0],
    [1 / 6, 0.0, 1 / 3, 0.0, 0.0],
])  # fmt: skip
FOR_V = np.array([
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [4 / 5, 0.0, 0.0, 0.0, 0.0],
    [11 / 32, 5 / 32, 0.0, 0.0, 0.0],
    [-3 / 8, -5 / 8, 2.0, 0.0, 0.0],
    [1 / 6, 0.0, 2 / 3, 1 / 6, 0.0],
])  # fmt: skip
# Without their factors, for linear forces, h³ a''' / 24 and h² a'' / 4. The factors were fitted
# to the errors of steps of oscillators.
THIRD = 0.01 * np.array([9.0, 10.0, -22.0, 3.0, 0.0])
SECOND = 0.018 * np.array([1.0, 0.0, -2.0, 1.0, 0.0])


def _tableau() -> Tableau:
    """Return the coefficients."""
    errors = [(THIRD, THIRD), (np.zeros(5), SECOND)]
    return nystrom(FOR_X, FOR_V, FOR_V.sum(axis=1), errors, carries=True)


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    h, near = end - time, False
    for stage in range(1, RESULT):
        near |= evaluate_stage(time, h, stage, current, work, net)
    work.effort[0] += RESULT - 1
    enter_stage(end, h, RESULT, current, work.x[1 - current], work.v[1 - current], work, net)
    return near


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, x, v = end - time, work.x[1 - current], work.v[1 - current]
    ledger = work.ledger[1 - current]
    quadrature(work.ledger[current], h, work.tableau.for_v[RESULT], work.power, ledger)
    worst = largest_of_booked(h, work)
    # The next step begins with the corrected velocity; powers of predicted ones would jump.
    force(end, x, v, work.trial_x, work.power[RESULT], net)
    work.effort[LOOKED] += 1
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Complete an accepted step; nothing is left to do."""
    return False


@INTEGRATORS.member("rkn4")
class Rkn4(Explicit):
    """RKN4: explicit, order 4, 3 evaluations per step, with long stable steps.

    A Runge-Kutta-Nyström method whose last stage is the first one of the next step. It stays
    stable up to 1.15 radians of the fastest motion per evaluation, against 0.5 with DOP853, and
    so is the cheapest method where stability and not accuracy limits the steps.
    """

    order = 4
    order_with_dashpots = 3
    control_order = 4.0
    safety = 0.5
    fading = 4.0
    share = 0.03
    looks = 4
    tableau = _tableau()

    step = staticmethod(step)
    book = staticmethod(book)
    finish = staticmethod(finish)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return where a mode of a damped oscillator, stepped from rest on, begins to grow."""
        if omega == 0.0:
            return float(np.inf)
        fastest = zeta + abs(np.emath.sqrt(zeta * zeta - 1.0)) if zeta > 1.0 else 1.0
        angles = np.arange(FINE, 2.0 * RESULT, FINE) / fastest
        grows = np.abs(np.linalg.eigvals(_steps(angles, zeta))).max(axis=1) > 1.0 + 1e-9
        return float(angles[np.flatnonzero(grows)[0]] / omega)


def _steps(angles: Floats, zeta: float) -> Floats:
    """Return the matrices of steps of an oscillator, by x, h v and h² a, shape (step, 3, 3).

    Args:
        angles: h ω, shape (step,).
        zeta: Damping ratio.
    """
    tableau = _tableau()
    of_x, of_v = tableau.for_x, tableau.for_v[:, 1:]
    start, speed, a = np.eye(3)
    stages, z = [np.broadcast_to(a, (len(angles), 3))], angles[:, None]
    x = v = start
    for stage in range(1, RESULT + 1):
        known = np.stack(stages)
        x = start + of_x[stage, 0] * speed + np.tensordot(of_x[stage, 1 : stage + 1], known, 1)
        v = speed + np.tensordot(of_v[stage, :stage], known, 1)
        stages.append(-z * z * x - 2.0 * zeta * z * v)
    return np.stack([x, v, stages[RESULT - 1]], axis=1)
