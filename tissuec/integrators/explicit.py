"""Explicit Runge-Kutta steps for x'' = a(x, v), by any tableau.

Stage i has v_i = v + h Σ A_ij a_j and x_i = x + h c_i v + h² Σ (A²)_ij a_j, and its a_i is the
acceleration there: that of velocities only is stored. One stage is the result of the step; any
behind it serve the dense output. (E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary
Differential Equations I, 1993, II.14.)
"""

from collections.abc import Sequence
from math import sqrt
from typing import ClassVar

import numpy as np

from tissuec.forces.accelerations import force, place
from tissuec.kernels.records import (
    LOOKED,
    Floats,
    Net,
    Work,
)
from tissuec.kernels.vectors import blended_error, combine, quadrature, scale

# Of a member; bound to its own.
END_ROW = 13
CONTROL_ORDER = 7.0
ERRORS = 4  # rows of the tableau: x by both estimates, v by both
FINE = 1e-3  # on the way to the limit of stability, |h λ|


def tableau(
    weights: Floats, estimates: Sequence[Floats], rows: int, nodes: Floats | None = None
) -> Floats:
    """Return weights of the rows: positions and velocities of stages, of errors, and nodes.

    Args:
        weights: A, of the result and what is behind it too, shape (stage, stage).
        estimates: Weights of one or two estimates of the error, shape (stage,) each. Of two,
            e5 and e3, the error is e5² / √(e5² + 0.01 e3²), as in DOP853.
        rows: Of ``Work.rows``: the velocity, the stages, and what dense output needs besides.
        nodes: c, if the sums of the weights are wrong by rounding, shape (stage,).
    """
    stages = len(weights)
    table = np.zeros((2 * stages + ERRORS + 1, rows))
    inner = slice(1, stages + 1)
    nodes = weights.sum(axis=1) if nodes is None else nodes
    table[:stages, 0], table[:stages, inner] = nodes, weights @ weights
    table[stages : 2 * stages, inner] = weights
    for row, estimate in enumerate(estimates, start=2 * stages):
        table[row, inner], table[row + 2, inner] = estimate @ weights, estimate
    table[-1, inner] = nodes
    return table


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the other half of the state to that at ``end``; tell if a spring came near."""
    h, table, result = end - time, work.tableau, END_ROW - 1
    scale(1.0 / h, work.v[current], work.rows[0])
    scale(1.0, work.a[current], work.rows[1])
    work.effort[0] += result - 1
    near = False
    for stage in range(1, result):
        near |= evaluate_stage(time, h, stage, current, work, net)
    x, v, rows = work.x[1 - current], work.v[1 - current], work.rows[:END_ROW]
    for_x, for_v = table[result, :END_ROW], table[stages_of(table) + result, :END_ROW]
    combine(work.x[current], h * h, for_x, work.v[current], h, for_v, rows, x, v, work.team)
    place(end, x, v, net)
    if needed_rows(table) > END_ROW:
        near |= evaluate_end(end, current, work, net)
    return near


def stages_of(table: Floats) -> int:
    """Return how many stages a tableau has."""
    return (table.shape[0] - ERRORS - 1) // 2


def needed_rows(table: Floats) -> int:
    """Return how many rows estimates combine: with or without the acceleration at the end."""
    return END_ROW + 1 if table[2 * stages_of(table) + 2, END_ROW] != 0.0 else END_ROW


def evaluate_stage(
    time: float, h: float, stage: int, current: int, work: Work, net: Net
) -> bool:
    """Fill the row of one stage from those before it."""
    table, rows = work.tableau, work.rows[: stage + 1]
    nodes = table[table.shape[0] - 1]
    x, v, then = work.trial_x, work.trial_v, time + h * nodes[stage + 1]
    for_x, for_v = table[stage, : stage + 1], table[stages_of(table) + stage, : stage + 1]
    combine(work.x[current], h * h, for_x, work.v[current], h, for_v, rows, x, v, work.team)
    place(then, x, v, net)
    return force(then, x, v, work.rows[stage + 1], work.power[stage + 1], net)


def evaluate_end(end: float, current: int, work: Work, net: Net) -> bool:
    """Set the accelerations at the end of the step."""
    x, v, a = work.x[1 - current], work.v[1 - current], work.a[1 - current]
    near = force(end, x, v, a, work.power[END_ROW], net)
    work.effort[0] += 1
    scale(1.0, a, work.rows[END_ROW])
    return near


def estimate(h: float, current: int, work: Work) -> tuple[float, float]:
    """Return the largest local error of a node's position [m] and velocity [m/s]."""
    table = work.tableau
    errors, last = 2 * stages_of(table), needed_rows(table)
    rows, five, three, none = work.rows[:last], work.trial_x, work.trial_v, work.zero
    fifth, third = table[errors, :last], table[errors + 1, :last]
    combine(none, h * h, fifth, none, h * h, third, rows, five, three, work.team)
    position = blended_error(five, three, work.each, work.team)
    fifth, third = table[errors + 2, :last], table[errors + 3, :last]
    combine(none, h, fifth, none, h, third, rows, five, three, work.team)
    return position, blended_error(five, three, work.each, work.team)


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, table, power, nothing = end - time, work.tableau, work.power, work.zero[:2]
    stages, five, three = stages_of(table), work.booked[0], work.booked[1]
    result = table[stages + END_ROW - 1]
    quadrature(work.ledger[current], h, result, power, work.ledger[1 - current])
    quadrature(nothing, h, table[2 * stages + 2], power, five)
    quadrature(nothing, h, table[2 * stages + 3], power, three)
    worst = 0.0
    for k in range(2):
        below = sqrt(five[k] ** 2 + 0.01 * three[k] ** 2)
        if below > 0.0:
            worst = max(worst, five[k] ** 2 / below)
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Evaluate the end of an accepted step, unless its error already needed that."""
    if needed_rows(work.tableau) > END_ROW:
        return False
    return evaluate_end(end, current, work, net)


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Evaluate the stages behind the result, for the dense output."""
    stages = stages_of(work.tableau)
    work.effort[LOOKED] += stages - END_ROW
    for stage in range(END_ROW, stages):
        evaluate_stage(time, end - time, stage, current, work, net)


def propose(h: float, ratio: float, memory: float, calm: int) -> tuple[float, float, int]:
    """Return the next step by proportional-integral control (Gustafsson)."""
    ratio = max(ratio, 1e-6)
    factor = (
        0.9 * ratio ** (-0.7 / CONTROL_ORDER) * memory ** (0.4 / CONTROL_ORDER)
        if memory
        else (0.9 * ratio ** (-1.0 / CONTROL_ORDER))
    )
    return h * min(6.0, max(0.3, factor)), ratio, 0


class Explicit:
    """What explicit members with a ``tableau`` have in common."""

    symplectic = False
    implicit = False
    conservative = False
    promises = True
    stabilised = False
    nearness = 0.9
    end_row: ClassVar[int]
    tableau: ClassVar[Floats]

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    prepare = staticmethod(prepare)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return where |1 + Σ zᵏ b Aᵏ⁻¹ 1| passes 1 on the ray to the fastest eigenvalue."""
        fastest = zeta + np.emath.sqrt(zeta * zeta - 1.0)
        if omega == 0.0:
            return float(np.inf)
        stages, result = stages_of(cls.tableau), cls.end_row - 1
        weights = cls.tableau[stages : stages + result + 1, 1 : result + 1]
        reach = np.arange(FINE, 2.0 * result, FINE)
        z = -reach * fastest / abs(fastest)
        value, term = np.ones_like(z), np.ones(result)
        for power in range(1, result + 1):
            value = value + z**power * (weights[-1] @ term)
            term = weights[:-1] @ term
        passed = np.flatnonzero(np.abs(value) > 1.0 + 1e-9)
        return float(reach[passed[0]] / (omega * abs(fastest)))
