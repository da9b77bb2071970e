"""The propagation of Table 1: symplectic Euler whose step halves where forces rise.

A frame lasts t_Δ, the step of the scene. In it, beginning with t_c = t_Δ,

    v' = v + t_c a(x, v);  x' = x + t_c v'
    the greatest force at (x', v') is above the former one:  t_c := t_c / 2, again from (x, v)
    otherwise:  t := t + t_c;  t_c := 2 t_c;  the former force is the new one

until the frame is over. The force on a node is the sum of all on it, springs, loads, weight and
drag: the net input of the paper's acceleration neuron. "Former" is that of the state from which
the step was tried, whichever frame it was reached in. Forces rise whenever a net swings away
from its equilibrium, and no smaller step prevents that: below a part of t_Δ nothing is halved,
and each step that is taken there although forces rose is counted as a stall. t_c is clipped to
what is left of the frame. (A. Nürnberger, A. Radetzky, R. Kruse, SPIE Medical Imaging 1998,
section 3.1.4.)

That is so unless ``procedures`` says otherwise, by the first row of the tableau.
"""

from math import inf, sqrt

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, Integrator, hermite
from tissuec.forces.accelerations import force, greatest_force, greatest_inner_force, place
from tissuec.kernels.records import Floats, Net, Work
from tissuec.kernels.vectors import accumulate, length, scale

# Places in the choices, see ``procedures``.
FLOOR, GROWTH, INNER, FORGETS, REPEATS, GOES_ON, OPEN = range(7)
ROUNDING = 1e-12
STALLS = 3  # place in ``Work.effort``
# Rows after those of both ends of the frame: the state that the next step is tried from, and
# the rows of ``hermite``.
END, X, V, A = 2, 3, 4, 5
ROWS = 8
SCRATCH = 6  # which ``hermite`` fills later


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Carry out a frame; return whether a spring is near its strength."""
    x, v, a, frame = work.x[1 - current], work.v[1 - current], work.a[1 - current], end - time
    rule, start = work.choices, time
    begin(current, work)
    floor = rule[FLOOR] * frame * (1.0 + 1e-9)
    first = inf
    if rule[FORGETS] == 0.0:
        first = compared_force(time, work.v[current], work.a[current], work, net)
    former, pace, near = first, frame, False
    if rule[GOES_ON] != 0.0 and work.rate[0] > 0.0:
        pace = min(frame, 1.0 / work.rate[0])
    growth = 1.0 if rule[REPEATS] != 0.0 else rule[GROWTH]
    over = end if rule[OPEN] == 0.0 else end - 1e-9 * frame
    while time < over:
        size, then = pace, time + pace
        if rule[OPEN] == 0.0 and size >= (end - time) * (1.0 - 1e-9):
            size, then = end - time, end
        known = min(then, end)  # where what is prescribed is known
        propagate(known, size, x, v, work, net)
        close = force(known, x, v, a, work.power[END], net)
        work.effort[0] += 1
        now = compared_force(known, v, a, work, net)
        rounding = 0.0  # of what is left when weight and loads are taken off
        if rule[INNER] != 0.0:
            rounding = ROUNDING * greatest_force(a, net)
        if now > former + rounding:
            if size > floor:
                pace = 0.5 * size
                if rule[REPEATS] != 0.0:
                    begin(current, work)
                    time, former, near = start, first, False
                continue
            work.effort[STALLS] += 1
        keep(size, x, v, a, work, net)
        near |= close
        time, former, pace = then, now, growth * pace
    work.goal[0] = pace if rule[REPEATS] == 0.0 else rule[GROWTH] * pace
    return near


def compared_force(time: float, v: Floats, a: Floats, work: Work, net: Net) -> float:
    """Return the greatest of the compared forces on a node [N]."""
    if work.choices[INNER] == 0.0:
        return greatest_force(a, net)
    return greatest_inner_force(time, v, a, work.rows[SCRATCH], net)


def begin(current: int, work: Work) -> None:
    """Fill the rows with the state at the start of a frame."""
    rows = work.rows
    scale(1.0, work.x[current], rows[X])
    scale(1.0, work.v[current], rows[V])
    scale(1.0, work.a[current], rows[A])
    for k in range(2):
        work.booked[0, k] = work.power[1, k]
        work.booked[1, k] = 0.0


def propagate(then: float, size: float, x: Floats, v: Floats, work: Work, net: Net) -> None:
    """Set x and v to the result of a step from the state in the rows.

    Args:
        then: Time at the end of the step [s].
        size: Size of the step [s].
    """
    scale(1.0, work.rows[V], v)
    accumulate(size, work.rows[A], v)
    scale(1.0, work.rows[X], x)
    accumulate(size, v, x)
    place(then, x, v, net)


def keep(size: float, x: Floats, v: Floats, a: Floats, work: Work, net: Net) -> None:
    """Accept a step: copy its state to the rows and book its power.

    Args:
        size: Size of the step [s].
    """
    scale(1.0, x, work.rows[X])
    scale(1.0, v, work.rows[V])
    scale(1.0, a, work.rows[A])
    if net.ledger:
        for k in range(2):
            work.booked[1, k] += 0.5 * size * (work.booked[0, k] + work.power[END, k])
            work.booked[0, k] = work.power[END, k]


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the difference of a frame from the trapezoidal rule, of the worst node [m], [m/s].

    That is h²/2 a for a frame of one step. It has no effect on the run.
    """
    position = beside(h, work.x, work.v, current, work.moving, work)
    return position, beside(h, work.v, work.a, current, work.moving, work), 0.0


def beside(
    h: float, value: Floats, rate: Floats, current: int, each: Floats, work: Work
) -> float:
    """Return the largest |y' - y - h/2 (r + r')| over the nodes that ``each`` has room for.

    Args:
        value: y at both ends of the frame in any unit, shape (2, 3 node).
        rate: Its rate r at both ends, shape (2, 3 node).
        each: Scratch, shape (n,).
    """
    other, error = 1 - current, work.trial_x
    scale(1.0, value[other], error)
    accumulate(-1.0, value[current], error)
    accumulate(-0.5 * h, rate[current], error)
    accumulate(-0.5 * h, rate[other], error)
    return length(error, each, work.team)


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the end of the frame; return 0 J, because no error is estimated."""
    for k in range(2):
        work.ledger[1 - current, k] = work.ledger[current, k] + work.booked[1, k]
    return 0.0


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Store the last time step of a frame, from which the next frame may begin."""
    work.rate[0] = 1.0 / work.goal[0]
    return False


def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
    """Return the size of the frame unchanged."""
    return h, 0.0, 0


@INTEGRATORS.member("propagation")
class Propagation(Integrator):
    """Propagation: the published procedure, a frame of symplectic Euler steps.

    Its Table 1 taken at its word, for comparison: ``step`` is a frame, within which steps are
    halved as long as the greatest force on a node rises, down to a floor, and doubled again.
    First order; it estimates no error and promises nothing (Nürnberger et al. 1998).
    """

    order = 1
    promises = False
    evaluations = 55
    rows = ROWS
    end_row = END
    control_order = 1.0
    safety = 1.0
    share = 0.01
    looks = 8
    tableau = None
    dense_x = hermite.dense_x(ROWS, END)
    dense_v = hermite.dense_v(ROWS, END)
    embedded_x = np.zeros((0, ROWS))

    step = staticmethod(step)
    estimate = staticmethod(estimate)
    book = staticmethod(book)
    finish = staticmethod(finish)
    prepare = staticmethod(hermite.prepare)
    propose = staticmethod(propose)

    @classmethod
    def stability_limit(cls, omega: float, zeta: float) -> float:
        """Return 2 (√(1 + ζ²) - ζ) / ω, the limit of symplectic Euler with the old velocity."""
        return 2.0 * (sqrt(1.0 + zeta * zeta) - zeta) / omega if omega else np.inf
