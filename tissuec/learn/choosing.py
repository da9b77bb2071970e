"""Which method steps a motion that is to be derived, and how finely."""

from typing import NamedTuple

import numpy as np

from tissuec.engine.choice import measured_facts
from tissuec.integrators import esdirk43, tableau853, trbdf2
from tissuec.laws import Law
from tissuec.learn.kernels import Kernels
from tissuec.learn.stepping import Stepping
from tissuec.learn.stepping.explicit import Explicit
from tissuec.learn.stepping.implicit import Implicit
from tissuec.learn.stepping.matrices import Matrices
from tissuec.learn.stepping.tableau import Tableau
from tissuec.learn.stepping.verlet import Verlet
from tissuec.network import Network
from tissuec.plan import Plan

STAGES = 12  # of DOP853 that make its result
TABLEAUS = {
    "trbdf2": Tableau("trbdf2", trbdf2.WEIGHTS, trbdf2.WEIGHTS[-1]),
    "esdirk43": Tableau("esdirk43", esdirk43.WEIGHTS, esdirk43.WEIGHTS[-1]),
    "dop853": Tableau("dop853", tableau853.A[:STAGES, :STAGES], tableau853.B[:STAGES]),
}
AUTOMATIC = "automatic"
NAMES = (AUTOMATIC, "velocity verlet", *TABLEAUS)
# Steps in units of 1/ω, at which errors are near 1e-6 of the motion after some swings.
SWINGS = {"velocity verlet": 0.02, "dop853": 1.5}
IMPLICIT = {"trbdf2": 4000, "esdirk43": 800}  # how many steps a run is divided into
MOST = 50_000  # explicit steps above which a method is implicit


class Chosen(NamedTuple):
    """A method and its largest step [s]."""

    stepping: Stepping
    step: float


def choose(
    name: str, step: float | None, network: Network, *, plan: Plan, duration: float,
    laws: tuple[Law, ...], kernels: Kernels,
) -> Chosen:  # fmt: skip
    """Return how to step.

    Args:
        name: Of the integrator; "automatic" takes DOP853, or ESDIRK4(3) for stiff nets.
        step: [s]; None: so that errors are small against those of any measurement.
        network: With numbers in its laws.
        laws: With variables for what is learnt of them.
    """
    situation = plan.start(network)
    facts = measured_facts(situation)
    rate = facts["omega"] * max(1.0, 2.0 * facts["zeta"])
    if name == AUTOMATIC:
        explicit = duration * rate / SWINGS["dop853"] <= MOST
        name = "dop853" if explicit else "esdirk43"
    if step is None:
        if name in IMPLICIT:
            step = duration / IMPLICIT[name]
        else:
            step = SWINGS[name] / rate if rate else duration / 20
    step = min(step, duration) if np.isfinite(step) else duration
    if name == "velocity verlet":
        return Chosen(Verlet(kernels), step)
    tableau = TABLEAUS[name]
    if tableau.is_explicit:
        return Chosen(Explicit(tableau, kernels), step)
    return Chosen(Implicit(tableau, kernels, Matrices(laws)), step)
