"""RKC2: a stabilised explicit method for nets that dashpots brake more than springs drive.

The second-order Runge-Kutta-Chebyshev method with damping 2/13: s stages are stable along
0.65 s² of the negative real axis, so that work grows with the root of the fastest rate only.
State and ledger go through the same recursion. (B. P. Sommeijer, L. F. Shampine, J. G. Verwer,
J. Comput. Appl. Math. 88:315, 1998.)
"""

from math import exp, log, sqrt

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, Integrator, hermite
from tissuec.forces.accelerations import force, place
from tissuec.kernels.records import Floats, Net, Work
from tissuec.kernels.vectors import accumulate, length, scale

DAMPING = 2.0 / 13.0
MOST_STAGES = 250
# Rows after those of both ends: the last two stages of x and of v with what the next one
# gains, and the rows of ``hermite``.
END, LAST_X, LAST_V, BEFORE_X, BEFORE_V, GAIN_X, GAIN_V, MEAN, RISE = range(2, 11)
ROWS = 11


def stages_for(reach: float) -> int:
    """Return how many stages are stable for h times the fastest rate."""
    return min(MOST_STAGES, 1 + int(sqrt(1.54 * reach + 1.0)) + 1)


def step(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Set the state at ``end``; return whether a spring is near its strength."""
    h, rows, ledger = end - time, work.rows, work.booked
    x, v = work.x[1 - current], work.v[1 - current]
    stages = stages_for(h * work.rate[0])
    w0 = 1.0 + DAMPING / (stages * stages)
    root = sqrt(w0 * w0 - 1.0)
    growth = exp(stages * log(w0 + root))
    sinh, cosh = 0.5 * (growth - 1.0 / growth), 0.5 * (growth + 1.0 / growth)
    w1 = sinh * root * root / (cosh * stages * root - w0 * sinh)
    b_last = b_before = 1.0 / (4.0 * w0 * w0)
    shift = w1 * b_last
    begin(h * shift, current, work)
    now, before = shift, 0.0
    z, z_before, dz, dz_before, d2z, d2z_before = w0, 1.0, 1.0, 0.0, 0.0, 0.0
    near = False
    for _ in range(2, stages + 1):
        z, z_before = 2.0 * w0 * z - z_before, z
        dz, dz_before = 2.0 * w0 * dz - dz_before + 2.0 * z_before, dz
        d2z, d2z_before = 2.0 * w0 * d2z - d2z_before + 4.0 * dz_before, d2z
        b = d2z / (dz * dz)
        less = 1.0 - z_before * b_last
        mu, nu = 2.0 * w0 * b / b_last, -b / b_before
        shift = mu * w1 / w0
        then = time + h * now
        place(then, rows[LAST_X], rows[LAST_V], net)
        near |= force(then, rows[LAST_X], rows[LAST_V], rows[GAIN_V], work.power[2], net)
        work.effort[0] += 1
        # x_j = (1 - μ - ν) x + μ x_(j-1) + ν x_(j-2) + h μ̃ (v_(j-1) - less v), likewise v.
        scale(h * shift, rows[LAST_V], rows[GAIN_X])
        scale(h * shift, rows[GAIN_V], rows[GAIN_V])
        blend(mu, nu, h * shift * less, work.x[current], work.v[current], LAST_X, work)
        blend(mu, nu, h * shift * less, work.v[current], work.a[current], LAST_V, work)
        if net.ledger:
            for k in range(2):
                gain = work.power[2, k] - less * work.power[1, k]
                ledger[0, k], ledger[1, k] = (
                    ledger[1, k],
                    mu * ledger[1, k] + nu * ledger[0, k] + h * shift * gain,
                )
        now, before = mu * now + nu * before + shift * (1.0 - less), now
        b_before, b_last = b_last, b
    scale(1.0, rows[LAST_X], x)
    scale(1.0, rows[LAST_V], v)
    place(end, x, v, net)
    near |= force(end, x, v, work.a[1 - current], work.power[END], net)
    work.effort[0] += 1
    # For the estimate, to which accelerations of driven nodes are zero: they go back.
    scale(1.0, v, rows[GAIN_V])
    place(time, rows[GAIN_X], rows[GAIN_V], net)
    return near


def begin(h: float, current: int, work: Work) -> None:
    """Set stages 0 and 1, which is at μ̃₁ times the step [s], and their ledgers."""
    rows, ledger = work.rows, work.booked
    scale(1.0, work.x[current], rows[BEFORE_X])
    scale(1.0, work.v[current], rows[BEFORE_V])
    scale(1.0, work.x[current], rows[LAST_X])
    scale(1.0, work.v[current], rows[LAST_V])
    accumulate(h, work.v[current], rows[LAST_X])
    accumulate(h, work.a[current], rows[LAST_V])
    for k in range(2):
        ledger[0, k] = 0.0
        ledger[1, k] = h * work.power[1, k]


def blend(
    mu: float, nu: float, less: float, start: Floats, slope: Floats, last: int, work: Work
) -> None:
    """Replace the last two stages of x or v by the next one and the last.

    Args:
        mu, nu: Coefficients μ and ν of the recursion.
        less: Coefficient γ̃ of the slope at the start, times the step [s].
        start: x or v at the start [m] or [m/s], shape (3 node,).
        slope: Its rate at the start, shape (3 node,).
        last: Row of the last stage.
    """
    rows = work.rows
    here, before, gain = rows[last], rows[last + 2], rows[last + 4]
    scale(nu, before, before)
    accumulate(mu, here, before)
    accumulate(1.0 - mu - nu, start, before)
    accumulate(1.0, gain, before)
    accumulate(-less, slope, before)
    scale(1.0, here, gain)
    scale(1.0, before, here)
    scale(1.0, gain, before)


def estimate(h: float, current: int, work: Work) -> tuple[float, float, float]:
    """Return the largest local errors, as ``Integrator.estimate`` does.

    They are 0.8 (y - y') + 0.4 h (f + f'), of third order.
    """
    other, error = 1 - current, work.trial_x
    scale(0.8, work.x[current], error)
    accumulate(-0.8, work.x[other], error)
    accumulate(0.4 * h, work.v[current], error)
    accumulate(0.4 * h, work.v[other], error)
    position = length(error, work.moving, work.team)
    scale(0.8, work.v[current], error)
    accumulate(-0.8, work.rows[GAIN_V], error)
    accumulate(0.4 * h, work.a[current], error)
    accumulate(0.4 * h, work.a[other], error)
    bodies = work.moving.size
    internal = length(error[3 * bodies :], work.each[bodies:], work.team)
    return position, length(error, work.moving, work.team), internal


def book(time: float, end: float, current: int, work: Work, net: Net) -> float:
    """Set the ledger at the step's end; return the largest local error of its entries [J]."""
    h, worst = end - time, 0.0
    for k in range(2):
        gained = work.booked[1, k]
        work.ledger[1 - current, k] = work.ledger[current, k] + gained
        mean = 0.5 * h * (work.power[1, k] + work.power[END, k])
        worst = max(worst, 0.8 * abs(mean - gained))
    return worst


def finish(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Complete an accepted step; nothing is left to do."""
    return False


def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
    """Return the next step; the error per unit step is of second order in its size."""
    return h * min(5.0, max(0.3, 0.9 * max(ratio, 1e-6) ** -0.5)), 0.0, 0


@INTEGRATORS.member("rkc2")
class Rkc2(Integrator):
    """RKC2: explicit, order 2, as many evaluations per step as stability requires.

    Runge-Kutta-Chebyshev (Sommeijer, Shampine & Verwer 1998). For large nets whose dashpots set
    the fastest rate: twice as many stages allow four times the step, without any matrix.
    """

    order = 2
    stabilised = True
    evaluations = 20
    rows = ROWS
    end_row = END
    control_order = 2.0
    safety = 0.2
    share = 0.05
    looks = 4
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
        """Return the step at which the most stages are needed, or 2 τ = 4 ζ/ω if that is less.

        Modes that both swing and are braked lie on a circle |λ + 1/τ| = 1/τ where dashpots are
        τ times springs; up to 2 τ it fits into the stable region. What swings unbraked grows
        so slowly up to h ω = 1/2 that the error estimate has time to see it.
        """
        if not omega:
            return np.inf
        fastest = omega * (zeta + sqrt(zeta * zeta - 1.0)) if zeta > 1.0 else omega
        return min(0.65 * MOST_STAGES**2 / fastest, max(4.0 * zeta, 0.5) / omega)
