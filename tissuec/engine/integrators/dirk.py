"""Diagonally implicit Runge-Kutta steps for x'' = a(x, v), solved for accelerations.

Stage i has v_i = v + h Σ A_ij a_j and x_i = x + h c_i v + h² Σ (A²)_ij a_j, and its a_i is the
acceleration there. Newton's method on a_i needs S = M + hγ D + (hγ)² K with one γ for all
stages: 3 unknowns a node, symmetric. S is kept from step to step as long as Newton's method
contracts well. (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 1996, IV.8.)
"""

from math import inf

from tissuec.engine.integrators.banded import assemble, solve
from tissuec.engine.integrators.tableaus import RungeKutta, enter_stage
from tissuec.forces.accelerations import force, place
from tissuec.forces.acting.embedding_kernel import follow
from tissuec.kernels.boundary_conditions import guide
from tissuec.kernels.records import LOOKED, Floats, Net, Work
from tissuec.kernels.stages import combine
from tissuec.kernels.vectors import accumulate, length, quadrature, scale, subtract

CONTROL_ORDER = 3.0  # of a member; bound to its own
ITERATIONS = 12
RENEWALS = 2  # of S within a stage, where a part of the net turned too far since it was made
SLOW = 0.5  # contraction from which S is made anew
HOPELESS = 0.9


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    h, made, stages = end - time, work.solver.made, work.tableau.for_x.shape[0]
    q = h * float(work.tableau.for_v[stages - 1, stages])
    if made[2] == 1.0 and made[0] == q:
        assemble(q, work.solver.at, work.solver.speed, net, work.solver)
    made[2] = 0.0
    fresh = made[0] != q
    near = False
    while True:
        if fresh:
            renew(time, q, work.x[current], work.v[current], work, net)
        made[1] = 0.0
        for stage in range(1, stages):
            if made[0] == q:
                a = work.a[1 - current] if stage + 1 == work.end_row else work.rows[stage + 1]
                near |= solve_stage(time, h, stage, current, a, fresh, work, net)
                if net.touched:
                    close_bristles(q, a, work.v[1 - current], net)
        if made[0] == q or fresh:
            break
        fresh = True
    if made[4] == 1.0 and made[0] == q:
        combine_errors(h, current, work)
        filter_errors(work, net)
    return near


def renew(time: float, q: float, x: Floats, v: Floats, work: Work, net: Net) -> None:
    """Set S at a state."""
    made = work.solver.made
    made[0], made[3] = q, time
    work.effort[1] += 1
    scale(1.0, x, work.solver.at)
    scale(1.0, v, work.solver.speed)
    if not assemble(q, x, v, net, work.solver):
        made[0] = 0.0


def solve_stage(
    time: float,
    h: float,
    stage: int,
    current: int,
    a: Floats,
    careful: bool,
    work: Work,
    net: Net,
) -> bool:
    """Set ``a`` to the accelerations of a stage; ``made[0]`` is 0 if this fails.

    Args:
        a: [m/s²], shape (3 node,).
        careful: Whether to begin where nodes are at the start of the step, and not with the
            accelerations of the stage before: of a sudden force, these may lead far away.
    """
    made, change = work.solver.made, work.trial_x
    x, v, q = work.x[1 - current], work.v[1 - current], made[0]
    then = begin_stage(time, h, stage, current, a, careful, work, net)
    before, renewals, near = 0.0, 0, False
    for _ in range(ITERATIONS):
        near = force(then, x, v, change, work.power[stage + 1], net)
        work.effort[0] += 1
        work.effort[2] += 1
        subtract(change, a, change)
        if not solve(change, net, work.solver):
            break
        accumulate(1.0, change, a)
        accumulate(q * q, change, x)
        accumulate(q, change, v)
        size = length(change, work.each, work.team)
        # The first change of a step does not yet indicate what is left.
        rate = made[1]
        if before > 0.0:
            rate = max(rate, size / before)
        known = before > 0.0 or rate > 0.0
        left = size * min(rate, HOPELESS) / (1.0 - min(rate, HOPELESS)) if known else size
        if q * q * left <= work.goal[0] and q * left <= work.goal[1]:
            made[1] = rate
            # Of what is remembered, only the velocities have been solved for.
            if net.internal_rows.size > 0 or net.inelastic:
                place(then, x, v, net)
            return near
        if not size < 1e300:
            break
        if before > 0.0 and size > SLOW * before:
            if renewals == RENEWALS:
                break
            renewals += 1
            renew(then, q, x, v, work, net)
            if made[0] == 0.0:
                break
            rate, size = 0.0, 0.0
        made[1], before = rate, size
    made[0] = 0.0
    return near


def begin_stage(
    time: float,
    h: float,
    stage: int,
    current: int,
    a: Floats,
    careful: bool,
    work: Work,
    net: Net,
) -> float:
    """Set ``a``, positions and velocities to the start of Newton's method; return the time.

    Args:
        time, h, stage, current, a, work, net: As of ``solve_stage``.
        careful: Whether Newton's method starts at the present positions, after it failed from
            those to which the previous accelerations lead.
    """
    x, v, q = work.x[1 - current], work.v[1 - current], work.solver.made[0]
    scale(1.0, work.a[current] if stage == 1 else work.rows[stage], a)
    if net.touched:
        open_bristles(q, a, net)
    then = time + h * float(work.tableau.for_x[stage, 0])
    enter_stage(then, h, stage, current, x, v, work, net)
    if careful and work.solver.made[4] == 1.0:
        stand_still(then, q, work.x[current], a, x, v, net)
    return then


def stand_still(
    then: float, q: float, start: Floats, a: Floats, x: Floats, v: Floats, net: Net
) -> None:
    """Change the accelerations of free nodes so that they are at the start of the step."""
    for node in range(net.inverse_mass.size):
        if net.inverse_mass[node] > 0.0:
            for i in range(3 * node, 3 * node + 3):
                change = (start[i] - x[i]) / q
                a[i] += change / q
                v[i] += change
                x[i] = start[i]
    if net.guided:  # what is held in some directions is where it is then
        guide(a, v, net.inverse_mass, net.guides)
        place(then, x, v, net)
    if net.embedded:
        follow(a, net.embedding)
        follow(x, net.embedding)
        follow(v, net.embedding)


def open_bristles(q: float, a: Floats, net: Net) -> None:
    """Have the forces of a stage solve for bristles, from what these are without its own rate.

    A bristle depends on the motion of its own node and of what that touches. So each is solved
    for by itself in every evaluation, and Newton's method only needs to find the motion.
    """
    net.touches.lag[0] = q
    for k in range(net.touches.memory.size):
        i = 3 * net.touches.memory[k]
        a[i] = a[i + 1] = a[i + 2] = 0.0


def close_bristles(q: float, a: Floats, v: Floats, net: Net) -> None:
    """Add the rates of bristles that a stage was solved with to it."""
    net.touches.lag[0] = 0.0
    for k in range(net.touches.memory.size):
        i = 3 * net.touches.memory[k]
        for c in range(3):
            a[i + c] = net.touches.bent[k, c]
            v[i + c] += q * net.touches.bent[k, c]


def combine_errors(h: float, current: int, work: Work) -> None:
    """Set the scratch vectors to estimates of the errors of positions and velocities."""
    for_x, for_v, none = work.tableau.error_x[0], work.tableau.error_v[0], work.zero
    combine(none, none, h, for_x, for_v, current, work.trial_x, work.trial_v, work)


def filter_errors(work: Work, net: Net) -> None:
    """Multiply the errors of velocities by S⁻¹ M, which leaves slow motions unchanged.

    Estimates are far too large for motions that are much faster than the step and that the
    method damps: of a flat tetrahedron, whose nodes follow all others. One of the frequency ω
    is divided by 1 + q² ω². (M. E. Hosea, L. F. Shampine, Appl. Numer. Math. 20:21, 1996.)
    """
    work.effort[2] += 1
    if not solve(work.trial_v, net, work.solver):
        work.solver.made[0] = 0.0


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the largest local errors, as ``Integrator.estimate`` does."""
    if work.solver.made[0] == 0.0:
        return inf, inf, inf  # Newton's method failed
    if work.solver.made[4] == 0.0:
        combine_errors(h, current, work)
    of_x, of_v, each, bodies = work.trial_x, work.trial_v, work.each, work.moving.size
    internal = length(of_v[3 * bodies :], each[bodies:], work.team)
    return length(of_x, work.moving, work.team), length(of_v, work.moving, work.team), internal


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, table = end - time, work.tableau
    booked, ledger = work.booked[0], work.ledger[1 - current]
    x, v, a, stages = work.inner[0], work.inner[1], work.inner[2], table.for_x.shape[0]
    for stage in range(1, stages):
        # Newton's method left the powers before its last change.
        then = time + h * table.for_x[stage, 0]
        enter_stage(then, h, stage, current, x, v, work, net)
        force(then, x, v, a, work.power[stage + 1], net)
    work.effort[LOOKED] += stages - 1
    quadrature(work.ledger[current], h, table.for_v[stages - 1], work.power, ledger)
    quadrature(work.zero[:2], h, table.error_v[0], work.power, booked)
    return max(abs(booked[0]), abs(booked[1]))


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Request a new S where Newton's method was slow."""
    if work.solver.made[1] > SLOW:
        work.solver.made[0] = 0.0
    return False


def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
    """Return the next step, memory and wait; the size is kept where a change gains little.

    S depends on the size and is kept with it.
    """
    factor = 0.9 * max(ratio, 1e-6) ** (-1.0 / CONTROL_ORDER)
    return (h if 1.0 <= factor < 1.3 else h * min(5.0, max(0.3, factor))), 0.0, 0


class Dirk(RungeKutta):
    """Common base of diagonally implicit members.

    The first stage of a tableau is explicit, the others have one diagonal, and the last one is
    the result.
    """

    implicit = True

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return infinity: no step is too large."""
        return inf
