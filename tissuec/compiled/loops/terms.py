"""Amounts that change in time, as numbers of items: the terms of ``BoundaryConditions``.

For the curves between two knots of profiles, see ``kernels.boundary_conditions``.
"""

from collections.abc import Mapping

import numpy as np

from tissuec.autodiff.functions import sin
from tissuec.autodiff.graph import Graph, Number
from tissuec.autodiff.potentials import Numbers
from tissuec.kernels.records import BoundaryConditions, Floats
from tissuec.model.profiles import POWERS

#: Numbers of a term, with how many components each has.
OF_TERMS: Mapping[str, int] = {
    "amount": 1, "origin": 1, "amplitude": 1, "angular": 1, "powers": POWERS,
}  # fmt: skip


def term_at(p: Numbers, graph: Graph) -> Number:
    """Return the value of a term at the time of the input "time".

    Args:
        p: Its numbers.
        graph: That they are of.
    """
    since: Number = graph.input("time") - p.origin
    angle: Number = since * p.angular
    factor = graph.number(0.0)
    for power in p.powers[::-1]:
        factor = factor * since + power
    return p.amount * (factor + p.amplitude * sin(angle))


def terms_of(acts: BoundaryConditions) -> Floats:
    """Return the numbers of terms in SI units, shape (number, term).

    Args:
        acts: Of its only one, first components are amounts.
    """
    own = acts.term_curve
    curves = acts.origin[own], acts.amplitude[own], acts.angular[own], *acts.power[own].T
    return np.stack([acts.term_vector[:, 0], *curves])
