"""ESDIRK4(3): six stages, the first explicit, one diagonal of a quarter.

The implicit half of ARK4(3)6L[2]SA. (C. A. Kennedy, M. H. Carpenter, Appl. Numer. Math. 44:139,
2003.)
"""

import numpy as np

from tissuec.engine.integrators import INTEGRATORS, dirk
from tissuec.engine.integrators.tableaus import runge_kutta

WEIGHTS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 4, 1 / 4, 0.0, 0.0, 0.0, 0.0],
        [8611 / 62500, -1743 / 31250, 1 / 4, 0.0, 0.0, 0.0],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4, 0.0, 0.0],
        [
            15267082809 / 155376265600,
            -71443401 / 120774400,
            730878875 / 902184768,
            2285395 / 8070912,
            1 / 4,
            0.0,
        ],
        [82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4],
    ]
)
EMBEDDED = np.array(
    [
        4586570599 / 29645900160,
        0.0,
        178811875 / 945068544,
        814220225 / 1159782912,
        -3700637 / 11593932,
        61727 / 225920,
    ]
)


@INTEGRATORS.member("esdirk43")
class Esdirk43(dirk.Dirk):
    """ESDIRK4(3)6L[2]SA: implicit, L-stable, order 4, five solutions per step.

    The implicit half of ARK4(3)6L[2]SA by Kennedy & Carpenter (2003), with an error estimate of
    order 3. For stiff nets: overdamped tissue, or a few springs much harder than the rest.
    """

    order = 4
    evaluations = 15
    control_order = 3.0
    safety = 0.4
    share = 0.05
    looks = 8
    tableau = runge_kutta(WEIGHTS, WEIGHTS[-1] - EMBEDDED)
