"""Explicit Runge-Kutta steps for x'' = a(x, v), by any tableau.

Stage i has v_i = v + h Σ A_ij a_j and x_i = x + h c_i v + h² Σ (A²)_ij a_j, and its a_i is the
acceleration there: that of velocities only is stored. One stage is the result of the step; any
after it serve the dense output. (E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary
Differential Equations I, 1993, II.14.)
"""

from math import sqrt

import numpy as np

from tissuec.engine.integrators.tableaus import RungeKutta, enter_stage
from tissuec.forces.accelerations import force
from tissuec.kernels.records import LOOKED, Net, Work
from tissuec.kernels.stages import blended_errors
from tissuec.kernels.vectors import quadrature

# Of a member; bound to its own.
CONTROL_ORDER = 7.0
FINE = 1e-3  # on the way to the limit of stability, |h λ|


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    h, result = end - time, work.tableau.result
    work.effort[0] += result - 1
    near = False
    for stage in range(1, result):
        near |= evaluate_stage(time, h, stage, current, work, net)
    enter_stage(end, h, result, current, work.x[1 - current], work.v[1 - current], work, net)
    if needs_end(work):
        near |= evaluate_end(end, current, work, net)
    return near


def needs_end(work: Work) -> bool:
    """Return whether estimates combine the acceleration at the end as well."""
    return work.tableau.error_v[0, work.end_row] != 0.0


def evaluate_stage(
    time: float, h: float, stage: int, current: int, work: Work, net: Net
) -> bool:
    """Set the row of one stage from the previous ones."""
    x, v, then = work.trial_x, work.trial_v, time + h * work.tableau.for_x[stage, 0]
    enter_stage(then, h, stage, current, x, v, work, net)
    a = work.a[1 - current] if stage + 1 == work.end_row else work.rows[stage + 1]
    return force(then, x, v, a, work.power[stage + 1], net)


def evaluate_end(end: float, current: int, work: Work, net: Net) -> bool:
    """Set the accelerations at the end of the step."""
    x, v, a = work.x[1 - current], work.v[1 - current], work.a[1 - current]
    work.effort[0] += 1
    return force(end, x, v, a, work.power[work.end_row], net)


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the largest local errors, as ``Integrator.estimate`` does."""
    bodies = work.moving.size
    blended_errors(h, current, work.each[bodies:], bodies, work)
    internal = work.errors[1]
    blended_errors(h, current, work.moving, 0, work)
    return work.errors[0], work.errors[1], internal


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, table, ledger = end - time, work.tableau, work.ledger[1 - current]
    quadrature(work.ledger[current], h, table.for_v[table.result], work.power, ledger)
    return largest_of_booked(h, work)


def largest_of_booked(h: float, work: Work) -> float:
    """Return the largest local error of the entries of the ledger [J]."""
    table, power, nothing = work.tableau, work.power, work.zero[:2]
    five, three = work.booked[0], work.booked[1]
    quadrature(nothing, h, table.error_v[0], power, five)
    quadrature(nothing, h, table.error_v[1], power, three)
    worst = 0.0
    for k in range(2):
        below = sqrt(five[k] ** 2 + 0.01 * three[k] ** 2)
        if below > 0.0:
            worst = max(worst, five[k] ** 2 / below)
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Evaluate the end of an accepted step, unless its error already needed that."""
    if needs_end(work):
        return False
    return evaluate_end(end, current, work, net)


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Evaluate the stages after the result, for the dense output."""
    stages = work.tableau.for_x.shape[0]
    work.effort[LOOKED] += stages - work.end_row
    for stage in range(work.end_row, stages):
        evaluate_stage(time, end - time, stage, current, work, net)


def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
    """Return the next step by proportional-integral control (Gustafsson 1991)."""
    ratio = max(ratio, 1e-6)
    factor = (
        0.9 * ratio ** (-0.7 / CONTROL_ORDER) * memory ** (0.4 / CONTROL_ORDER)
        if memory
        else (0.9 * ratio ** (-1.0 / CONTROL_ORDER))
    )
    return h * min(6.0, max(0.3, factor)), ratio, 0


class Explicit(RungeKutta):
    """Common base of explicit members."""

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return where |1 + Σ zᵏ b Aᵏ⁻¹ 1| passes 1 on the ray to the fastest eigenvalue."""
        fastest = zeta + np.emath.sqrt(zeta * zeta - 1.0)
        if omega == 0.0:
            return float(np.inf)
        tableau = cls.tableau
        assert tableau is not None, "explicit members have one"
        result = tableau.result
        weights = tableau.for_v[: result + 1, 1 : result + 1]
        before, after = 0.0, 2.0 * result
        for spacing in (10.0 * FINE, FINE):
            reach = np.arange(before + spacing, after + 0.5 * spacing, spacing)
            z = -reach * fastest / abs(fastest)
            value, term = np.ones_like(z), np.ones(result)
            for power in range(1, result + 1):
                value = value + z**power * (weights[-1] @ term)
                term = weights[:-1] @ term
            after = float(reach[np.flatnonzero(np.abs(value) > 1.0 + 1e-9)[0]])
            before = after - spacing
        return after / (omega * abs(fastest))
