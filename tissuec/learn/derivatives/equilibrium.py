"""A net in equilibrium, and its derivatives by numbers and by positions of held nodes."""

from functools import cached_property

import numpy as np
from msgspec import Struct

from tissuec.kernels.derivative_records import Laws, NodeState, Seeds, Values
from tissuec.learn.derivatives.equilibria import EquilibriumStage
from tissuec.learn.derivatives.kernels import acceleration, pull_back, push_forward
from tissuec.learn.derivatives.matrices import derivatives
from tissuec.learn.derivatives.response import StaticResponse
from tissuec.learn.derivatives.stepping import LegForces, act_on
from tissuec.learn.derivatives.views import StateView
from tissuec.model.network import Floats


class Equilibrium(Struct, eq=False, dict=True):
    """A net in equilibrium, and how that changes."""

    stand: EquilibriumStage
    view: StateView
    laws: Laws

    @cached_property
    def act(self) -> LegForces:
        return act_on(self.stand.leg, self.laws, self.view.values, self.view.x)

    @cached_property
    def state(self) -> NodeState:
        """Return the state, with what rounding left of accelerations."""
        leg, view = self.stand.leg, self.view
        found = NodeState(view.x, view.v, np.empty_like(view.x))
        acceleration(
            self.act.forces, leg.start, leg.paths(np.array([leg.start])).load[0], found
        )
        return found

    @cached_property
    def resistance(self) -> StaticResponse:
        by_x, _, wide = derivatives(self.act, self.stand.time, self.state)
        mass, extent = self.view.values.mass, self.stand.leg.network.extent
        return StaticResponse(by_x, wide, mass, self.stand.free, extent)

    def move(self, tx: Floats, seeds: Seeds) -> None:
        """Replace the changes of free positions by those in equilibrium.

        Args:
            tx: Changes of positions [m per unit of the parameter], shape (3 node, change).
            seeds: Changes of the numbers.
        """
        if not len(self.stand.free):
            return
        ta = np.empty_like(tx)
        change = NodeState(tx.ravel(), np.zeros(tx.size), ta.ravel())
        push_forward(self.act.forces, self.stand.time, self.state, seeds, change)
        entries, weights = self.resistance.entries, self.resistance.weights
        tx[entries] += self.resistance.moved(weights[:, None] * ta[entries])

    def back(self, due: Floats) -> Values:
        """Convert derivatives by all positions to those by held ones; return those by numbers.

        Args:
            due: By positions [1/m], shape (3 node,); changed.
        """
        by = Values(*(np.zeros_like(part) for part in self.view.values))
        if not len(self.stand.free):
            return by
        entries, found = self.resistance.entries, NodeState(*np.zeros((3, len(due))))
        moved = self.resistance.moved(due[entries])
        found.a[entries] = self.resistance.weights * moved
        pull_back(self.act.forces, self.stand.time, self.state, found, by)
        due += found.x
        due[entries] = 0.0  # from wherever free nodes come, they come here
        return by
