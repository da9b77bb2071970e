"""Choice of the method and step of a motion with derivatives."""

from math import factorial
from typing import NamedTuple

import numpy as np

from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method_choice import measured_facts
from tissuec.kernels.derivative_records import Laws
from tissuec.learn.derivatives.implicit import ImplicitStepping
from tissuec.learn.derivatives.stepping import Stepping
from tissuec.learn.derivatives.tableaus import ExplicitStepping
from tissuec.learn.parameters.fields import starting_state
from tissuec.model.inelastic import VISCOSITY
from tissuec.model.network import Network
from tissuec.script.plan import AUTOMATIC, Plan

# Errors of a step h of order p are about (h ω)ᵖ / (p + 1)!: at this, they are near 1e-6 of the
# motion after some swings.
FINE = 1 / 15_000
YIELDING = 4.0  # times as fine where springs yield: steps do not end where they begin to
MOST = 50_000  # explicit steps above which a method is implicit


class ChosenMethod(NamedTuple):
    """A method and its largest step [s]."""

    stepping: Stepping
    step: float


def choose(
    name: str, step: float | None, network: Network, plan: Plan, *, duration: float, laws: Laws,
) -> ChosenMethod:  # fmt: skip
    """Return the method and step of a motion.

    Args:
        name: Of an integrator with a tableau; "automatic" chooses DOP853, or ESDIRK4(3) for
            stiff nets.
        step: Step size [s]; None: so that errors are small compared with those of any
            measurement.
        network: With numbers in its laws.
        plan: The plan of the experiment, with numbers in its forces.
        duration: Of the experiment [s].
        laws: With variables for the constants that are learnt.
    """
    state = starting_state(plan, network)
    facts = measured_facts(state)
    rate = facts["omega"] * max(1.0, 2.0 * facts["zeta"])
    rate = max(rate, state.acting.giving(state.position))
    if name == AUTOMATIC:
        explicit = duration * rate / swing(INTEGRATORS["dop853"].order) <= MOST
        explicit |= network.springs.inelastic is not None or network.contact is not None
        name = "dop853" if explicit else "esdirk43"
    member = INTEGRATORS[name]
    if step is None:
        if member.implicit:
            step = duration / (160 * 5 ** (4 / member.order))
        else:
            step = swing(member.order) / rate if rate else duration / 20
            if (
                network.springs.inelastic is not None
                and network.springs.inelastic.has(VISCOSITY).any()
            ):
                step /= YIELDING
    step = min(step, duration) if np.isfinite(step) else duration
    stepping = ImplicitStepping if member.implicit else ExplicitStepping
    return ChosenMethod(stepping(name, laws), step)


def swing(order: int) -> float:
    """Return the steps of explicit methods in units of 1/ω, to two digits."""
    return float(f"{(FINE * factorial(order + 1)) ** (1 / order):.2g}")
