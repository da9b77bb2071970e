"""A net in equilibrium, and how that changes with numbers and with the places of held nodes."""

from functools import cached_property

import numpy as np
from msgspec import Struct

from tissuec.kernels.sensitivity import Links, Seeds, Values
from tissuec.learn.kernels import Kernels
from tissuec.learn.resistance import Resistance
from tissuec.learn.stands import Stand
from tissuec.learn.stepping import Act
from tissuec.learn.stepping.matrices import Matrices
from tissuec.learn.views import View
from tissuec.network import Floats


class Equilibrium(Struct, eq=False, dict=True):
    """A net in equilibrium, and how that changes."""

    stand: Stand
    view: View
    kernels: Kernels
    matrices: Matrices

    @cached_property
    def links(self) -> Links:
        return self.stand.leg.links(self.view.values)

    @cached_property
    def acceleration(self) -> Floats:
        """Return what rounding left of accelerations, and those of nodes that stay."""
        leg, (_, values, x, v) = self.stand.leg, self.view
        load = leg.paths(np.array([leg.start])).load[0]
        found = np.empty_like(x)
        self.kernels.acceleration(x, v, load, self.links, values, found)
        return found

    @cached_property
    def resistance(self) -> Resistance:
        leg, (_, values, x, v) = self.stand.leg, self.view
        by_x, _ = self.matrices.derivatives(Act(leg, self.links, values), x, v)
        return Resistance(by_x, values.mass, self.stand.free, leg.network.extent)

    def move(self, tx: Floats, seeds: Seeds) -> None:
        """Change the changes of free places to those in equilibrium, shape (3 node, change)."""
        if not len(self.stand.free):
            return
        _, values, x, v = self.view
        ta, part = np.empty_like(tx), np.empty(tx.shape[1])
        self.kernels.push_forward(
            x, v, self.acceleration, tx, np.zeros_like(tx), self.links, values, seeds, part, ta
        )
        entries, weights = self.resistance.entries, self.resistance.weights
        tx[entries] += self.resistance.moved(weights[:, None] * ta[entries])

    def back(self, due: Floats) -> Values:
        """Turn derivatives by all places into those by held places; return those by numbers.

        Args:
            due: By places, shape (3 node,); changed.
        """
        _, values, x, v = self.view
        by = Values(*(np.zeros_like(part) for part in values))
        if not len(self.stand.free):
            return by
        entries, weight = self.resistance.entries, np.zeros_like(due)
        moved = self.resistance.moved(due[entries])
        weight[entries] = self.resistance.weights * moved
        by_x, by_v = np.zeros((2, len(due)))
        self.kernels.pull_back(
            x, v, self.acceleration, weight, self.links, values, by_x, by_v, by
        )
        due += by_x
        due[entries] = 0.0  # from wherever free nodes come, they come here
        return by
