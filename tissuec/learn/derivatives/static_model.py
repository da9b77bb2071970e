"""An experiment without time: equilibria, one per row, with exact derivatives.

With A(x, θ) = 0 the accelerations of free nodes in equilibrium, ∂A/∂x δx + ∂A/∂x_held δx_held +
∂A/∂θ δθ = 0 gives the change of the equilibrium. What holds nodes carries along how these were
changed when they were taken hold of.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from msgspec import Struct
from scipy import sparse

from tissuec.compiler.learning.displacements import rows_of
from tissuec.core.units import LENGTH, show
from tissuec.kernels.derivative_records import NodeState, Seeds, Values
from tissuec.learn.derivatives.equilibria import (
    EquilibriumStage,
    StaticResponse,
    Unbalanced,
    UnresistedMotion,
    stands,
)
from tissuec.learn.derivatives.matrices import (
    acceleration,
    derivatives,
    pull_back,
    push_forward,
)
from tissuec.learn.derivatives.model import measured, slots_of
from tissuec.learn.derivatives.observables import Observable, StateView, pull, push
from tissuec.learn.derivatives.stepping import LegForces, act_on
from tissuec.learn.parameters.numbers import in_rows
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.measurements.experiment import Series
from tissuec.model.network import Floats
from tissuec.script.fit_problem import DataAxis


class Equilibrium(Struct, eq=False, dict=True):
    """A net in equilibrium, and how that changes."""

    stand: EquilibriumStage
    view: StateView

    @cached_property
    def values(self) -> Values:
        return self.stand.leg.present(self.view.vector)

    @cached_property
    def act(self) -> LegForces:
        return act_on(self.stand.leg, self.values, self.view.x)

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
        mass, extent = self.values.mass, self.stand.leg.network.extent
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
        by = self.stand.leg.nothing
        if not len(self.stand.free):
            return by
        entries, found = self.resistance.entries, NodeState(*np.zeros((3, len(due))))
        moved = self.resistance.moved(due[entries])
        found.a[entries] = self.resistance.weights * moved
        pull_back(self.act.forces, self.stand.time, self.state, found, by)
        due += found.x
        due[entries] = 0.0  # from wherever free nodes come, they come here
        return by


CHANGES = 256  # that are carried from equilibrium to equilibrium at once


class StaticModel:
    """Predictions of a net at rest.

    Args:
        looks: What each series is of.
        axis: The moved nodes whose displacement rows are sorted by.

    Attributes:
        notes: What is to be known of the equilibria, as sentences.

    Raises:
        CompileError: The script does not move the nodes as far as a row says.
    """

    name = "exact derivatives of every equilibrium"

    def __init__(
        self,
        shaping: Parametrisation,
        series: tuple[Series, ...],
        looks: tuple[Observable, ...],
        axis: DataAxis,
    ):
        self.shaping, self.series, self.looks = shaping, series, looks
        self.slots, self.size = slots_of(series), len(measured(series))
        self.notes: tuple[str, ...] = ()
        self._times, self._rows = rows_of(shaping.compiled, series, axis)
        self._theta: Floats | None = None  # at which everything is frozen
        self._stands: list[EquilibriumStage] = []
        self._looked: list[int] = []
        self._known: tuple[bytes, list[Equilibrium]] | None = None

    def freeze(self, theta: Floats) -> None:
        """Go through the script once; which springs break and who is held stays so.

        Raises:
            Unbalanced: The net has no equilibrium in a row.
        """
        if self._theta is not None and np.array_equal(theta, self._theta):
            return
        present = self.shaping.present(theta)
        found = list(stands(present.network, present.plan, self._times, self.shaping.order))
        self._stands = [stand for stand, _ in found]
        self._looked = [k for k, (_, is_row) in enumerate(found) if is_row]
        self.notes, self._known, self._theta = self._remarks(), None, theta.copy()

    def limit(self, stop: float) -> None:
        """Do nothing: rows have no time."""

    def predict(self, theta: Floats) -> Floats:
        """Return the predictions; raises Unbalanced."""
        found = np.zeros(self.size)
        for balanced, parts in self._measured(theta):
            for look, part in parts:
                found[part] = look.at(balanced.view)
        return found

    def gradient(self, theta: Floats, weights: Floats) -> Floats:
        """Return the derivatives of Σ weights · predictions, from the last row to the first."""
        order = self.shaping.order
        every = list(self._measured(theta))
        free = [balanced for balanced, _ in every if len(balanced.stand.free)]
        if not all(balanced.resistance.sound for balanced in free):
            # What is undetermined along a mechanism is found by forward derivatives only.
            return self.jacobian(theta).T @ weights
        due, direct = np.zeros(order.sizes["position"]), np.zeros(order.size)
        for balanced, parts in reversed(every):
            for look, part in parts:
                slope = pull(look, balanced.view, weights[part])
                due += slope.x
                if slope.numbers is not None:
                    direct += slope.numbers
            direct += balanced.stand.leg.past(balanced.back(due))
        order.array(direct, "position")[:] += due
        return np.asarray(self.shaping.change(theta).T @ direct)

    def jacobian(self, theta: Floats) -> Floats:
        """Return the derivatives of all predictions, by changes carried from row to row.

        Raises:
            Unbalanced: The net could move without any force, and something acts that way.
        """
        order, change = self.shaping.order, self.shaping.change(theta)
        count = self.shaping.size
        found = np.zeros((self.size, count))
        for first in range(0, count, CHANGES):
            columns = slice(first, min(first + CHANGES, count))
            some = sparse.csr_matrix(change[:, columns])
            start = sparse.csr_matrix(some[order.places["position"]])
            tx = np.ascontiguousarray(start.toarray())
            still = np.zeros_like(tx)
            for balanced, parts in self._measured(theta):
                self._move(balanced, some, tx)
                for look, part in parts:
                    found[part, columns] = push(look, balanced.view, tx, still, some)
        return found

    def step_error(self, theta: Floats) -> Floats:
        """Return 0: an equilibrium is found to rounding."""
        return np.zeros(self.size)

    # --- parts --------------------------------------------------------------------------------

    def _measured(
        self, theta: Floats
    ) -> Iterator[tuple[Equilibrium, list[tuple[Observable, slice]]]]:
        """Yield all equilibria in order, with the observations in each and their places."""
        parts: list[list[tuple[Observable, slice]]] = [[] for _ in self._stands]
        for look, slot, rows in zip(self.looks, self.slots, self._rows, strict=True):
            for row, time in enumerate(rows):
                parts[self._looked[int(time)]].append((look, slot.of(row)))
        yield from zip(self._balanced(theta), parts, strict=True)

    def _balanced(self, theta: Floats) -> list[Equilibrium]:
        """Return the equilibria."""
        assert self._stands, "freeze comes first"
        key = theta.tobytes()
        if self._known is None or self._known[0] != key:
            order, network = self.shaping.order, self.shaping.network(theta)
            vector = self.shaping.vector(theta)
            found: list[Equilibrium] = []
            places = order.array(vector, "position").reshape(-1, 3)[: network.node_count]
            is_frozen = self._theta is not None and np.array_equal(theta, self._theta)
            for stand in self._stands:
                places = stand.places if is_frozen else stand.balanced(network, vector, places)
                here = in_rows(places, network).ravel()
                view = StateView(stand.leg, vector, here, np.zeros_like(here), stand.time)
                found.append(Equilibrium(stand, view))
            self._known = key, found
        return self._known[1]

    def _move(self, balanced: Equilibrium, change: sparse.csr_matrix, tx: Floats) -> None:
        """Carry changes of places from one equilibrium to the next."""
        try:
            leg = balanced.stand.leg
            seeds = self.shaping.order.seeds(change, leg.factors, leg.acting.numbers)
            balanced.move(tx, seeds)
        except UnresistedMotion as failure:
            stand = balanced.stand
            node = stand.leg.network.node_ids[stand.free[failure.args[0]]]
            message = (
                f"{self._where(stand)} node {node} can move along the forces without "
                "resistance, so derivatives are not defined"
            )
            raise Unbalanced(stand.time, message) from failure

    def _where(self, stand: EquilibriumStage) -> str:
        """Return how the place of an equilibrium in the experiment is called."""
        time = int(np.argmin(np.abs(self._times - stand.time)))
        for one, rows in zip(self.series, self._rows, strict=True):
            for row in np.flatnonzero(rows == time):
                return f"at a displacement of {show(float(one.times[row]), LENGTH)}"
        raise AssertionError("every time is that of a row")

    def _remarks(self) -> tuple[str, ...]:
        """Return each remark once, with where it is first made."""
        found: dict[str, str] = {}
        for stand in self._stands:
            ids = stand.leg.network.node_ids
            for remark in stand.remarks:
                at = "" if remark.node is None else f", mainly at node {ids[remark.node]}"
                text = f"{remark.message}{at}{remark.numbers}"
                found.setdefault(remark.message, f"{self._where(stand)}, {text}")
        return tuple(found.values())
