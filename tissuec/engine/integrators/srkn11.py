"""SRKN 11(6): a symplectic Runge-Kutta-Nyström method of sixth order for a(x).

Twelve kicks and eleven drifts in turn, the last kick of a step serving the next as well:

    v += B_i h a(x, t + c_i h),  x += A_i h v,  c_i = A_1 + … + A_(i-1)

Symmetric and symplectic, so that without viscosity energies do not drift and phases err in
proportion to time only. (S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142:313, 2002.)
"""

from math import inf

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, Integrator
from tissuec.engine.integrators.constant_steps import propose
from tissuec.engine.integrators.tableaus import nystrom
from tissuec.forces.accelerations import force, place
from tissuec.kernels.records import LOOKED, Floats, Net, Tableau, Work
from tissuec.kernels.stages import blended_errors
from tissuec.kernels.vectors import accumulate, between, scale

KICKS = 12
HALF_KICKS = (
    0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807,
    -0.0115113874206879,
)  # fmt: skip
HALF_DRIFTS = (
    0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075,
    0.357208872795928,
)  # fmt: skip
# Rows of ``Work.rows`` after the start: end, middle, and what v and x gain until either.
END, MIDDLE, MEAN, RISE, HALF_MEAN, HALF_RISE = range(KICKS, KICKS + 6)
ROWS = KICKS + 6
# h ω up to which oscillators stay bounded. Within 5e-4 of π and 1e-3 of 6.348 the trace of the
# step's matrix is beyond ±2 by less than 5e-7: resonances that need thousands of steps to show.
STABLE = 9.07


def coefficients() -> tuple[Floats, Floats]:
    """Return kicks B, shape (12,), and drifts A, shape (11,), dimensionless palindromes."""
    kicks = (*HALF_KICKS, 0.5 - sum(HALF_KICKS))
    drifts = (*HALF_DRIFTS, 1.0 - 2.0 * sum(HALF_DRIFTS))
    return np.array([*kicks, *kicks[::-1]]), np.array([*drifts, *drifts[-2::-1]])


def _tableau() -> Tableau:
    """Return the coefficients: a stage for each kick, and one after the last."""
    kicks, drifts = coefficients()
    nodes = np.concatenate([[0.0], np.cumsum(drifts), [1.0]])
    for_x, for_v = np.zeros((2, KICKS + 1, KICKS + 1))
    for_v[:, :KICKS] = np.tril(np.ones((KICKS + 1, KICKS)), -1) * kicks
    for_x[:, :KICKS] = (nodes[:, None] - nodes[:KICKS]) * for_v[:, :KICKS]
    errors = _estimates(for_x[:KICKS, :KICKS], nodes[:KICKS])
    return nystrom(for_x, for_v, nodes, errors, carries=True)


def _estimates(inner: Floats, c: Floats) -> list[tuple[Floats, Floats]]:
    """Return combinations of the stages that vanish but for errors of order 5 and 4.

    Orthogonal to what the order conditions of velocities up to 4, or 3, take their sums over
    (Hairer, Nørsett & Wanner 1993, II.14), and of all such as large as can be in the next ones.
    """
    one, two, three = inner.sum(axis=1), inner @ c, inner @ c**2
    third = [np.ones(KICKS), c, c**2, one]
    fourth = [c**3, c * one, two]
    fifth = [c**4, c**2 * one, c * two, one**2, three, inner @ one]
    chosen: list[tuple[Floats, Floats]] = []
    for known, following in (([*third, *fourth], fifth), (third, fourth)):
        null = np.linalg.svd(np.array(known))[2][len(known) :]
        strongest = np.linalg.svd(np.array(following) @ null.T)[2][0]
        chosen.append((np.zeros(KICKS + 1), np.append(strongest @ null, 0.0)))
    return chosen


def _dense(of_velocity: bool) -> Floats:
    """Return the polynomial of degree 8 through x, v and a at start, middle and end.

    Shape (8, row) in powers of the step's part θ, in units of h² for positions and h for
    velocities, which are its derivative.
    """
    conditions, data = np.zeros((6, 6)), np.zeros((6, ROWS))
    powers = np.arange(3, 9)
    for k, (at, rise, mean, a) in enumerate(
        ((0.5, HALF_RISE, HALF_MEAN, MIDDLE), (1.0, RISE, MEAN, END))
    ):
        conditions[3 * k] = at**powers
        conditions[3 * k + 1] = powers * at ** (powers - 1)
        conditions[3 * k + 2] = powers * (powers - 1) * at ** (powers - 2)
        data[3 * k, [rise, 1]] = 1.0, -0.5 * at**2
        data[3 * k + 1, [mean, 1]] = 1.0, -at
        data[3 * k + 2, [a, 1]] = 1.0, -1.0
    table = np.zeros((8, ROWS))
    table[2:] = np.linalg.solve(conditions, data)
    table[1, 1] = 0.5
    if of_velocity:
        derivative = np.arange(1, 9)[:, None] * table
        return np.vstack([derivative[1:], np.zeros(ROWS)])
    table[0, 0] = 1.0
    return table


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    x, v = work.x[1 - current], work.v[1 - current]
    work.effort[0] += KICKS - 1
    return compose(time, end - time, current, x, v, work.a[1 - current], work, net)


def compose(
    time: float,
    h: float,
    current: int,
    x: Floats,
    v: Floats,
    a: Floats,
    work: Work,
    net: Net,
) -> bool:
    """Set a state, and its acceleration, to those after h."""
    kicks, nodes = work.tableau.for_v[KICKS], work.tableau.for_x[:, 0]
    near, pull = False, work.a[current]
    scale(1.0, work.x[current], x)
    scale(1.0, work.v[current], v)
    for kick in range(1, KICKS):
        accumulate(h * kicks[kick], pull, v)
        accumulate(h * (nodes[kick] - nodes[kick - 1]), v, x)
        then, pull = time + h * nodes[kick], a if kick == KICKS - 1 else work.rows[kick + 1]
        place(then, x, v, net)
        near |= force(then, x, v, pull, work.power[kick + 1], net)
    accumulate(h * kicks[KICKS], a, v)
    place(time + h, x, v, net)
    return near


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the largest local errors, as ``Integrator.estimate`` does."""
    blended_errors(h, current, work.each, 0, work)
    return h * work.errors[1], work.errors[1], 0.0


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Copy the ledger; return 0 J if no work is done, else infinity.

    The stages give no estimate of the work.
    """
    worst = 0.0
    for k in range(2):
        work.ledger[1 - current, k] = work.ledger[current, k]
        for row in range(1, END + 1):
            if work.power[row, k] != 0.0:
                worst = inf
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Complete an accepted step; nothing is left to do."""
    return False


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Step to the middle, and fill the rows that the polynomials combine."""
    h, other, rows = end - time, 1 - current, work.rows
    x, v = work.trial_x, work.trial_v
    compose(time, 0.5 * h, current, x, v, rows[MIDDLE], work, net)
    work.effort[LOOKED] += KICKS - 1
    between(work.v[current], work.v[other], 1.0 / h, rows[MEAN])
    between(work.v[current], v, 1.0 / h, rows[HALF_MEAN])
    between(work.x[current], work.x[other], 1.0 / (h * h), rows[RISE])
    accumulate(-1.0 / h, work.v[current], rows[RISE])
    between(work.x[current], x, 1.0 / (h * h), rows[HALF_RISE])
    accumulate(-0.5 / h, work.v[current], rows[HALF_RISE])


@INTEGRATORS.member("srkn11")
class Srkn11(Integrator):
    """SRKN 11(6): symplectic, order 6, 11 evaluations per step; not for viscosity.

    The Runge-Kutta-Nyström splitting method of Blanes & Moan (2002). Energies do not drift and
    errors grow in proportion to time, so that it is the method for long undamped motions.
    """

    order = 6
    symplectic = True
    conservative = True
    evaluations = 11
    rows = ROWS
    end_row = END
    control_order = 6.0
    safety = 1000.0
    share = 1.0
    looks = 8
    nearness = 0.85
    tableau = _tableau()
    dense_x = _dense(of_velocity=False)
    dense_v = _dense(of_velocity=True)
    embedded_x = np.zeros((0, ROWS))

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    prepare = staticmethod(prepare)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return where the trace of the step's matrix for an oscillator leaves ±2 for good."""
        return STABLE / omega if omega else np.inf
