"""DOP853 in Runge-Kutta-Nyström form: eighth order, accelerations only are stored.

With x' = v the stage velocities v_i = v + h Σ A_ij K_j need not be kept, because
x_i = x + h C_i v + h² Σ (A²)_ij K_j; likewise for result, error estimate and dense output.
Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993), II.5, II.6, II.14.
"""

from math import sqrt

import numpy as np

from tissuec.integrators import INTEGRATORS
from tissuec.kernels.records import (
    LOOKED,
    Floats,
    Net,
    Work,
)
from tissuec.kernels.scalar import (
    blended_error,
    combine,
    force,
    place,
    quadrature,
    scale,
)
from tissuec.kernels.tableau853 import E3, E5, STAGES, A, C, D

ROWS = STAGES + 1
RESULT = 12  # the stage that is the step's result
ERROR = 2 * STAGES  # rows of the tableau: x by E5, x by E3, v by E5, v by E3
# Nodes of the stages; copied into the tableau's last row for the kernels.
NODES = ERROR + 4


def _tableau() -> Floats:
    """Return weights of the rows: positions, velocities, error estimates, nodes."""
    table = np.zeros((NODES + 1, ROWS))
    table[:STAGES, 0], table[:STAGES, 1:] = C, A @ A
    table[STAGES:ERROR, 1:] = A
    for row, weights in ((ERROR, E5), (ERROR + 1, E3)):
        table[row, 1:] = weights @ A
        table[row + 2, 1:] = weights
    table[NODES, 1:] = C
    return table


def _dense(of_velocity: bool) -> Floats:
    """Return the dense output as powers of the step's part θ, shape (7, row).

    y(θ) = y + θ F0 + θ(1-θ) F1 + θ²(1-θ) F2 + … with F0 = y' - y, F1 = h f - F0,
    F2 = 2 F0 - h (f + f'), and F3 to F6 by the matrix D.
    """
    table = _tableau()
    start, result = np.zeros(ROWS), np.zeros(ROWS)
    if of_velocity:
        change = table[STAGES + RESULT]
        start[1], result[1 + RESULT] = 1.0, 1.0
        further = np.hstack([np.zeros((4, 1)), D])
    else:
        change = table[RESULT]
        start[0] = 1.0
        result = start + table[STAGES + RESULT]
        further = np.hstack([D.sum(axis=1, keepdims=True), D @ A])
    terms = [change, start - change, 2.0 * change - start - result, *further]
    powers, factor = np.zeros((7, ROWS)), np.polynomial.Polynomial([0.0, 1.0])
    for k, term in enumerate(terms):
        powers[: k + 1] += np.outer(factor.coef[1:], term)
        factor *= np.polynomial.Polynomial([1.0, -1.0] if k % 2 == 0 else [0.0, 1.0])
    return powers


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the other half of the state to that at ``end``; tell if a spring came near."""
    h = end - time
    scale(1.0 / h, work.v[current], work.rows[0])
    scale(1.0, work.a[current], work.rows[1])
    work.effort[0] += RESULT - 1
    near = False
    for stage in range(1, RESULT):
        near |= evaluate_stage(time, h, stage, current, work, net)
    x, v, table = work.x[1 - current], work.v[1 - current], work.tableau
    rows, last = work.rows[: RESULT + 1], RESULT + 1
    for_x, for_v = table[RESULT, :last], table[STAGES + RESULT, :last]
    combine(work.x[current], h * h, for_x, work.v[current], h, for_v, rows, x, v, work.team)
    place(end, x, v, net)
    return near


def evaluate_stage(
    time: float, h: float, stage: int, current: int, work: Work, net: Net
) -> bool:
    """Fill the row of one stage from those before it."""
    table, rows = work.tableau, work.rows[: stage + 1]
    x, v, then = work.trial_x, work.trial_v, time + h * table[NODES, stage + 1]
    for_x, for_v = table[stage, : stage + 1], table[STAGES + stage, : stage + 1]
    combine(work.x[current], h * h, for_x, work.v[current], h, for_v, rows, x, v, work.team)
    place(then, x, v, net)
    return force(then, x, v, work.rows[stage + 1], work.power[stage + 1], net)


def estimate(h: float, current: int, work: Work) -> tuple[float, float]:
    """Return the largest local error of a node's position [m] and velocity [m/s]."""
    last, table = RESULT + 1, work.tableau
    rows, five, three, none = work.rows[:last], work.trial_x, work.trial_v, work.zero
    fifth, third = table[ERROR, :last], table[ERROR + 1, :last]
    combine(none, h * h, fifth, none, h * h, third, rows, five, three, work.team)
    position = blended_error(five, three, work.each, work.team)
    fifth, third = table[ERROR + 2, :last], table[ERROR + 3, :last]
    combine(none, h, fifth, none, h, third, rows, five, three, work.team)
    return position, blended_error(five, three, work.each, work.team)


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, table, power, nothing = end - time, work.tableau, work.power, work.zero[:2]
    five, three = work.booked[0], work.booked[1]
    quadrature(work.ledger[current], h, table[STAGES + RESULT], power, work.ledger[1 - current])
    quadrature(nothing, h, table[ERROR + 2], power, five)
    quadrature(nothing, h, table[ERROR + 3], power, three)
    worst = 0.0
    for k in range(2):
        below = sqrt(five[k] ** 2 + 0.01 * three[k] ** 2)
        if below > 0.0:
            worst = max(worst, five[k] ** 2 / below)
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Evaluate the end of an accepted step."""
    x, v, a = work.x[1 - current], work.v[1 - current], work.a[1 - current]
    near = force(end, x, v, a, work.power[1 + RESULT], net)
    work.effort[0] += 1
    scale(1.0, a, work.rows[1 + RESULT])
    return near


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Evaluate the three further stages of the dense output."""
    work.effort[LOOKED] += STAGES - RESULT - 1
    for stage in range(RESULT + 1, STAGES):
        evaluate_stage(time, end - time, stage, current, work, net)


def propose(h: float, ratio: float, memory: float, calm: int) -> tuple[float, float, int]:
    """Return the next step by proportional-integral control (Gustafsson)."""
    ratio = max(ratio, 1e-6)
    factor = (
        0.9 * ratio ** (-0.7 / 7.0) * memory ** (0.4 / 7.0)
        if memory
        else (0.9 * ratio ** (-1.0 / 7.0))
    )
    return h * min(6.0, max(0.3, factor)), ratio, 0


@INTEGRATORS.member("dop853")
class Dop853:
    """DOP853 in Runge-Kutta-Nyström form: explicit, order 8, 12 evaluations per step.

    The method of Prince and Dormand as tuned by Hairer, Nørsett & Wanner (1993), with error
    estimates of orders 5 and 3 and dense output of order 7. Storing accelerations only halves
    the arithmetic. The method of choice for all but coarse tolerances.
    """

    order = 8
    symplectic = False
    implicit = False
    conservative = False
    promises = True
    stabilised = False
    evaluations = 12
    rows = ROWS
    end_row = 1 + RESULT
    control_order = 7.0
    safety = 30.0
    share = 0.004
    looks = 8
    nearness = 0.85
    tableau = _tableau()
    dense_x = _dense(of_velocity=False)
    dense_v = _dense(of_velocity=True)

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    prepare = staticmethod(prepare)
    propose = staticmethod(propose)

    @staticmethod
    def stability_limit(omega: float, zeta: float) -> float:
        """Return 5.96 over the largest eigenvalue, where the stability polynomial leaves 1.

        That is its limit without damping; with damping it is larger, up to 6.39.
        """
        fastest = omega * (zeta + sqrt(zeta * zeta - 1.0) if zeta > 1.0 else 1.0)
        return 5.96 / fastest if fastest else np.inf
