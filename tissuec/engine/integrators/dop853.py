"""DOP853 in Runge-Kutta-Nyström form: eighth order, accelerations only are stored.

With x' = v the stage velocities v_i = v + h Σ A_ij K_j need not be kept, because
x_i = x + h C_i v + h² Σ (A²)_ij K_j; likewise for result, error estimate and dense output.
Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (1993), II.5, II.6, II.14.
"""

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, explicit
from tissuec.engine.integrators.dop853_coefficients import E3, E5, RESULT, A, C, D
from tissuec.engine.integrators.tableaus import runge_kutta
from tissuec.kernels.records import Floats

TABLEAU = runge_kutta(A, E5, E3, nodes=C, result=RESULT)


def _dense(of_velocity: bool) -> Floats:
    """Return the dense output as powers of the step's part θ, shape (7, row).

    y(θ) = y + θ F0 + θ(1-θ) F1 + θ²(1-θ) F2 + … with F0 = y' - y, F1 = h f - F0,
    F2 = 2 F0 - h (f + f'), and F3 to F6 by the matrix D.
    """
    change = TABLEAU.for_v[RESULT] if of_velocity else TABLEAU.for_x[RESULT]
    start, result = np.zeros((2, len(change)))
    if of_velocity:
        start[1], result[1 + RESULT] = 1.0, 1.0
        further = np.hstack([np.zeros((4, 1)), D])
    else:
        start[0] = 1.0
        result = start + TABLEAU.for_v[RESULT]
        further = np.hstack([D.sum(axis=1, keepdims=True), D @ A])
    terms = [change, start - change, 2.0 * change - start - result, *further]
    powers, factor = np.zeros((7, len(change))), np.array([0.0, 1.0])
    for k, term in enumerate(terms):
        powers[: k + 1] += np.outer(factor[1:], term)
        factor = np.convolve(factor, [1.0, -1.0] if k % 2 == 0 else [0.0, 1.0])
    return powers


def _integrated(dense_v: Floats) -> Floats:
    """Return positions as powers of the step's part θ, shape (8, row): integrals of velocities.

    They end at the result of the step, and are an order better than those of a general
    y' = f(y), whose difference from them estimates the error.
    """
    powers = np.zeros((len(dense_v) + 1, dense_v.shape[1]))
    powers[0, 0] = 1.0  # θ h v
    powers[1:] = dense_v / np.arange(2.0, len(powers) + 1.0)[:, None]
    return powers


@INTEGRATORS.member("dop853")
class Dop853(explicit.Explicit):
    """DOP853 in Runge-Kutta-Nyström form: explicit, order 8, 12 evaluations per step.

    The method of Prince and Dormand as tuned by Hairer, Nørsett & Wanner (1993), with error
    estimates of orders 5 and 3 and dense output of order 7. Storing accelerations only halves
    the arithmetic. The method of choice for all but coarse tolerances.
    """

    order = 8
    control_order = 7.0
    safety = 30.0
    share = 0.004
    latitude = 150.0
    amplification = 0.1
    looks = 8
    nearness = 0.85
    tableau = TABLEAU
    prepare = staticmethod(explicit.prepare)
    dense_v = _dense(of_velocity=True)
    dense_x = _integrated(dense_v)
    embedded_x = np.pad(_dense(of_velocity=False), ((0, 1), (0, 0))) - dense_x
