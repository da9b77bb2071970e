"""TR-BDF2: trapezoidal rule to γ h, then the two-step backward formula, as one implicit pair.

With γ = 2 - √2 both stages have the same diagonal γ/2, and the method is L-stable and of second
order with an embedded third-order formula. (R. E. Bank et al., IEEE Trans. CAD 4:436, 1985;
M. E. Hosea, L. F. Shampine, Appl. Numer. Math. 20:21, 1996.)
"""

from math import inf, sqrt

import numpy as np

from tissuec.integrators import INTEGRATORS, dirk, hermite

D, W = 1.0 - sqrt(0.5), sqrt(2.0) / 4.0
WEIGHTS = np.array([[0.0, 0.0, 0.0], [D, D, 0.0], [W, W, D]])
EMBEDDED = np.array([(1.0 - W) / 3.0, (3.0 * W + 1.0) / 3.0, D / 3.0])


def propose(h: float, ratio: float, memory: float, calm: int) -> tuple[float, float, int]:
    """Return the next step; kept where little is won, since S then is kept as well."""
    factor = 0.9 * max(ratio, 1e-6) ** (-1.0 / 2.0)
    return (h if 1.0 <= factor < 1.3 else h * min(5.0, max(0.3, factor))), 0.0, 0


@INTEGRATORS.member("trbdf2")
class TrBdf2:
    """TR-BDF2: implicit, L-stable, order 2, two solutions per step.

    The trapezoidal rule to γ h with γ = 2 - √2, then the backward formula through the three
    points (Bank et al. 1985, Hosea & Shampine 1996). For coarse tolerances of stiff nets: its
    steps follow the motion one sees and not the fastest one there is.
    """

    order = 2
    symplectic = False
    implicit = True
    conservative = False
    promises = True
    stabilised = False
    evaluations = 5
    rows = 6
    end_row = 3
    control_order = 2.0
    safety = 0.3
    share = 0.05
    looks = 4
    nearness = 0.9
    tableau = dirk.tableau(WEIGHTS, EMBEDDED)
    dense_x = hermite.dense_x(6, 3)
    dense_v = hermite.dense_v(6, 3)

    step = staticmethod(dirk.step)
    estimate = staticmethod(dirk.estimate)
    book = staticmethod(dirk.book)
    finish = staticmethod(dirk.finish)
    prepare = staticmethod(hermite.prepare)
    propose = staticmethod(propose)

    @staticmethod
    def stability_limit(omega: float, zeta: float) -> float:
        """Return infinity: no step is too large."""
        return inf
