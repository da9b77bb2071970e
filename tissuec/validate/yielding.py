"""Unknowns beside motion: elements that relax or yield, and springs that relax and flow.

The unknowns s of the living springs follow one another: first how far each branch has
given way, branch by branch, then by how much each rest length has flowed.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

if TYPE_CHECKING:
    from tissuec.model.inelastic import Inelastic
    from tissuec.validate.forces.elements import ElementSolid
    from tissuec.validate.forces.membranes import MembraneWall

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Derivatives(NamedTuple):
    """Derivatives of spring forces, as sparse matrices.

    Attributes:
        pull_by_variable: [N/m], shape (spring, variable).
        rate_by_stretch: [1/s], shape (variable, spring).
        rate_by_variable: [1/s], shape (variable, variable).
    """

    pull_by_variable: Any
    rate_by_stretch: Any
    rate_by_variable: Any


class Yielding:
    """Internal variables of some springs.

    Args:
        inelastic: Of all springs of the state; None if none remembers anything.
        springs: The living ones.

    Attributes:
        count: Number of unknowns.
        sudden: What branches add to the stiffness of each living spring [N/m].

    Shared arguments:
        stretch: L - L0 of the intact springs [m], shape (spring,).
        pull: Force of the intact springs [N], shape (spring,).
        given: The unknowns [m], shape (count,).
        velocity: Of all nodes [m/s], shape (node, 3).
    """

    def __init__(self, inelastic: "Inelastic | None", springs: Indices):
        self.springs, none = len(springs), np.zeros(0)
        self.branch: Indices = np.zeros(0, dtype=np.int64)  # living spring of each branch
        self.plastic: Indices = self.branch  # and of each rest length that flows
        self.constant = self.time = self.limit = self.viscosity = self._rate = none
        self._place: Indices = self.branch
        if inelastic is not None:
            self._fill(inelastic, springs)
        self.count = len(self.branch) + len(self.plastic)
        self.sudden = self._each(self.branch, self.constant)

    def _fill(self, inelastic: "Inelastic", springs: Indices) -> None:
        slot, rate = inelastic.slot[:, springs], inelastic.rate[:, springs]
        row, self.branch = np.nonzero(slot[:-1] >= 0)
        self.plastic = np.flatnonzero(slot[-1] >= 0)
        self.constant = inelastic.constant[row, springs[self.branch]]
        self.time = inelastic.time[row, springs[self.branch]]
        self.limit = inelastic.limit[springs[self.plastic]]
        self.viscosity = inelastic.viscosity[springs[self.plastic]]
        places = (slot[row, self.branch], slot[-1, self.plastic])
        rates = (rate[row, self.branch], rate[-1, self.plastic])
        self._place, self._rate = np.concatenate(places), np.concatenate(rates)

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns [m] from velocities of shape (node, 3)."""
        return velocity.ravel()[self._place] / self._rate

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns as velocities."""
        velocity.reshape(-1)[self._place] = given * self._rate

    def given_way(self, stretch: Floats, chosen: Any, velocity: Floats) -> Floats:
        """Return the unknowns at which branches of the chosen springs are without force [m].

        Args:
            chosen: Mask of the intact springs, shape (spring,).
        """
        given, branches = self.read(velocity), len(self.branch)
        own = np.where(chosen[self.branch], stretch[self.branch], given[:branches])
        return np.concatenate([own, given[branches:]])

    def flowed(self, given: Floats) -> Floats:
        """Return by how much rest lengths have flowed [m], shape (spring,)."""
        return self._each(self.plastic, given[len(self.branch) :])

    def _each(self, spring: Indices, values: Floats) -> Floats:
        """Return the sum of values for each living spring, shape (spring,)."""
        return np.bincount(spring, values, self.springs).astype(float)

    def _own(self, stretch: Floats, given: Floats) -> Floats:
        """Return how far the springs of branches are stretched [m], shape (branch,)."""
        return stretch[self.branch] - given[: len(self.branch)]

    def pull(self, stretch: Floats, given: Floats) -> Floats:
        """Return the tension of the branches [N], shape (spring,)."""
        return self._each(self.branch, self.constant * self._own(stretch, given))

    def energy(self, stretch: Floats, given: Floats) -> float:
        """Return the energy stored in branches [J]."""
        return 0.5 * float(self.constant @ self._own(stretch, given) ** 2)

    def rate(self, stretch: Floats, pull: Floats, given: Floats) -> tuple[Floats, float]:
        """Return the rates of the unknowns [m/s], and the power that they dissipate [W]."""
        own = self._own(stretch, given)
        force = pull[self.plastic]
        over = force - np.clip(force, -self.limit, self.limit)
        giving, flowing = own / self.time, over / self.viscosity
        lost = self.constant @ (own * giving) + force @ flowing
        return np.concatenate([giving, flowing]), float(lost)

    def derivatives(self, pull: Floats, steep: Floats) -> Derivatives:
        """Return how pulls and rates change with elongations and unknowns.

        Args:
            pull: Of springs with their branches [N], shape (spring,).
            steep: Stiffness of springs without them [N/m], shape (spring,).
        """
        branches, flows = len(self.branch), len(self.plastic)
        whole = steep + self.sudden
        variable = np.arange(self.count)
        spring = np.concatenate([self.branch, self.plastic])
        softer = np.concatenate([-self.constant, -whole[self.plastic]])
        by_variable = sparse.csr_matrix(
            (softer, (spring, variable)), shape=(self.springs, self.count)
        )
        fluid = (np.abs(pull[self.plastic]) > self.limit) / self.viscosity
        per = np.concatenate([1.0 / self.time, fluid * whole[self.plastic]])
        by_stretch = sparse.csr_matrix(
            (per, (variable, spring)), shape=(self.count, self.springs)
        )
        # A branch feels what its rest length flows; a flow feels all that changes the pull.
        here = sparse.csr_matrix(
            (np.ones(flows), (self.plastic, branches + np.arange(flows))),
            shape=(self.springs, self.count),
        )
        relaxing = sparse.diags(np.append(1.0 / self.time, np.zeros(flows)))
        flowing = sparse.diags(np.append(np.zeros(branches), fluid))
        joined = sparse.csr_matrix(
            (np.ones(self.count), (variable, spring)), shape=(self.count, self.springs)
        )
        itself = -relaxing - relaxing @ joined @ here + flowing @ joined @ by_variable
        return Derivatives(by_variable, by_stretch, sparse.csr_matrix(itself))


class RelaxingFields:
    """The unknowns of all fields with internal variables; see ``validate.forces.relaxing``.

    Args:
        fields: All of the net.

    Attributes:
        count: Number of unknowns.

    Shared arguments:
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        given: The unknowns, dimensionless, shape (count,).
    """

    def __init__(self, fields: "Sequence[ElementSolid | MembraneWall]"):
        self._fields = [field for field in fields if field.kept]
        self._kept = [kept for field in self._fields for kept in field.kept]
        self.count = sum(kept.count for kept in self._kept)

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns, dimensionless, shape (count,)."""
        return _joined([kept.read(velocity) for kept in self._kept])

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns, dimensionless, shape (count,), as velocities."""
        first = 0
        for kept in self._kept:
            kept.write(given[first : first + kept.count], velocity)
            first += kept.count

    def rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        return _joined([field.rates(position, velocity) for field in self._fields])

    def energy(self, position: Floats, velocity: Floats) -> float:
        """Return the energy that depends on unknowns, at positions of shape (node, 3) [J]."""
        return sum(field.remembered_energy(position, velocity) for field in self._fields)

    def let_relax(self, position: Floats, velocity: Floats, free: Indices) -> None:
        """Store that the branches of elements at free nodes gave way for good.

        Args:
            free: The free nodes, shape (free,).
        """
        for field in self._fields:
            field.give_way(position, velocity, free)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions [m], shape (count,)."""
        return _joined([kept.allowed(place) for kept in self._kept])

    @property
    def slowing(self) -> Floats:
        """Return about the derivatives of rates by their own unknowns [1/s], shape (count,)."""
        return _joined([kept.slowing for kept in self._kept])


def _joined(parts: list[Floats]) -> Floats:
    return np.concatenate([np.zeros(0), *parts])
