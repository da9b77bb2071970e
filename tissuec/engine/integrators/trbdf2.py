"""TR-BDF2: trapezoidal rule to γ h, then the two-step backward formula, as one implicit pair.

With γ = 2 - √2 both stages have the same diagonal γ/2, and the method is L-stable and of second
order with an embedded third-order formula. (R. E. Bank et al., IEEE Trans. CAD 4:436, 1985;
M. E. Hosea, L. F. Shampine, Appl. Numer. Math. 20:21, 1996.)
"""

from math import sqrt

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, dirk
from tissuec.engine.integrators.tableaus import runge_kutta

D, W = 1.0 - sqrt(0.5), sqrt(2.0) / 4.0
WEIGHTS = np.array([[0.0, 0.0, 0.0], [D, D, 0.0], [W, W, D]])
EMBEDDED = np.array([(1.0 - W) / 3.0, (3.0 * W + 1.0) / 3.0, D / 3.0])


@INTEGRATORS.member("trbdf2")
class TrBdf2(dirk.Dirk):
    """TR-BDF2: implicit, L-stable, order 2, two solutions per step.

    The trapezoidal rule to γ h with γ = 2 - √2, then the backward formula through the three
    points (Bank et al. 1985, Hosea & Shampine 1996). For coarse tolerances of stiff nets: its
    steps follow the motion one sees and not the fastest one there is.
    """

    order = 2
    evaluations = 5
    control_order = 2.0
    safety = 0.3
    share = 0.05
    looks = 4
    tableau = runge_kutta(WEIGHTS, WEIGHTS[-1] - EMBEDDED)
