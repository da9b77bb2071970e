"""Fields whose items follow from a potential, of which everything else is derived.

A member states its potential, a function of the corners of an item as in
``autodiff.potentials``, and which of its attributes are numbers of the items. Forces, powers,
matrices, bounds, the derivatives for learning, and whether it holds nodes from outside follow;
nothing else is written by hand.
"""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.graph import TracingError
from tissuec.autodiff.potentials import PotentialFunction, TracedItem
from tissuec.autodiff.tracing import place_of
from tissuec.core.structs import replace
from tissuec.forces.effects import Resisting
from tissuec.forces.element_fields import ElementField
from tissuec.forces.matrices import (
    ForceDerivatives,
    as_operator,
    whole,
    without_negative,
)
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from tissuec.compiled.loops.tables import ItemTable
    from tissuec.forces.potential_kernels import PotentialKernels


_SECONDS = 1.7e-9  # of one evaluation, for each number of the items


class PotentialField(ElementField, frozen=True):
    """A field whose items follow from a potential.

    Attributes:
        item_potential: The potential of an item.
        columns: Attributes that are numbers of the items, shape (item,) or (item, …), or one
            number for all items.
        learnt: Those of them by which there are derivatives for learning.
    """

    item_potential: ClassVar[PotentialFunction]
    columns: ClassVar[tuple[str, ...]]
    learnt: ClassVar[tuple[str, ...]] = ()

    @property
    def traced(self) -> TracedItem:
        """Return an item as its potential was traced.

        Raises:
            TracingError: The potential cannot be traced.
        """
        return traced_item(type(self).item_potential, self.nodes.shape[1], self.widths)

    @property
    def widths(self) -> tuple[tuple[str, int], ...]:
        """Return how many components each number of an item has."""
        return tuple(
            (name, int(np.prod(np.shape(getattr(self, name))[1:], dtype=int)))
            for name in self.columns
        )

    def check(self, position: Floats) -> None:
        """Check that all that follows is finite where nodes are at rest.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Raises:
            TracingError: It is not, or the potential cannot be traced.
        """
        from tissuec.autodiff.probe import probe  # for fields of other packages

        probe(self.traced, self.inputs(position, np.zeros_like(position)))

    def inputs(self, position: Floats, velocity: Floats) -> dict[str, Floats]:
        """Return the inputs of all items as they were traced, by name, shape (item,) each.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        names = [str(each.operation.detail) for each in self.traced.numbers]
        found = dict(zip(names, self._numbers(), strict=True))
        for letter, vectors in (("x", position), ("v", velocity)):
            for corner, axis in np.ndindex(self.nodes.shape[1], 3):
                found[f"{letter}.{corner}.{axis}"] = vectors[self.nodes[:, corner], axis]
        return found

    def _numbers(self) -> Floats:
        """Return the numbers of the items, in SI units, shape (number, item)."""
        count, found = self.item_count, [np.zeros((0, self.item_count))]
        for name, width in self.traced.widths.items():
            if width:
                own = np.reshape(getattr(self, name), (-1, width))
                found.append(np.broadcast_to(own, (count, width)).T)
        return np.concatenate(found)

    @property
    def _kernels(self) -> "PotentialKernels":
        from tissuec.forces.potential_kernels import kernels_of  # which costs time

        shared = tuple((name, self._is_shared(name)) for name in self.learnt)
        return kernels_of(type(self).__name__.lower(), self.traced, shared)

    def _is_shared(self, name: str) -> bool:
        """Return whether all items share a number: one without axes, or with a single row."""
        shape = np.shape(getattr(self, name))
        return not shape or shape[0] < self.item_count

    def only(self, items: Indices) -> Self:
        """Return some items, by indices of shape (n,), with the walls of all."""
        names = set(self.__struct_fields__).intersection(("nodes", *self.columns))
        arrays = {name: getattr(self, name) for name in names if not self._is_shared(name)}
        return replace(self, **{name: array[items] for name, array in arrays.items()})

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return the nodes that are held from outside, shape (node,); see ``Effect``."""
        found = np.zeros(len(position), dtype=bool)
        if self.traced.is_held:
            found[self.nodes] = True
        return found

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]; see ``Field``."""
        return _SECONDS * self._numbers_kept

    # --- energies, matrices and bounds ----------------------------------------------------

    def energies(self, position: Floats) -> Floats:
        """Return the energy of each item [J], shape (…, item).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        shape = position.shape[:-2]
        found = np.zeros((*shape, self.item_count))
        table, still = self._table(_every(position)), np.zeros(3 * position.shape[-2])
        for state in np.ndindex(shape):
            x = _flat(position[state])
            found[state] = self._kernels.recorded("energy", x, still, table)[:, 0]
        return found

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        return self.energies(position).sum(axis=-1)

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each item [N/m], shape (item, corner, 3, corner, 3).

        Without ``exact``, negative eigenvalues count as zero.
        """
        found = self._symmetric("matrix", position, np.zeros_like(position))
        if not exact:
            size = 3 * self.nodes.shape[1]
            shape = found.shape
            found = without_negative(found.reshape(-1, size, size)).reshape(shape)
        return found

    @property
    def is_damped(self) -> bool:
        """Return whether any item dissipates."""
        return self.traced.is_damped

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return ∂²D/∂v∂v of each item at rest [N s/m], shape (item, corner, 3, corner, 3)."""
        return self._symmetric("damping_by_velocity", position, np.zeros_like(position))

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix] | None":
        """Return minus the derivatives of damping forces; see ``Field``."""
        if not self.is_damped:
            return None
        by_velocity = self._sum(
            lambda own: own._symmetric("damping_by_velocity", position, velocity), number, size
        )
        by_position = self._sum(
            lambda own: own._recorded("damping_by_position", position, velocity).reshape(
                own.item_count, *own._block
            ),
            number, size,
        )  # fmt: skip
        return by_position, by_velocity

    @property
    def _block(self) -> tuple[int, int, int, int]:
        corners = self.nodes.shape[1]
        return corners, 3, corners, 3

    def _symmetric(self, name: str, position: Floats, velocity: Floats) -> Floats:
        """Return matrices of items of which the lower half is recorded."""
        half = self._recorded(name, position, velocity)
        return whole(half).reshape(-1, *self._block)

    def _recorded(self, name: str, position: Floats, velocity: Floats) -> Floats:
        """Return numbers of each item in a state, shape (item, number)."""
        state = _flat(position), _flat(velocity)
        return self._kernels.recorded(name, *state, self._table(_every(position)))

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return ∂²E/∂x∂x as an operator [N/m]; see ``Effect``."""
        every, count = _every(position), len(position)
        return as_operator(lambda: self.matrix(time, position, every, count))

    # --- for the engine and for learning --------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the loop that adds forces and powers."""
        return self._kernels.forces

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> "ItemTable":
        """Return the items with other numbers of nodes."""
        return self._table(place)

    def _table(self, place: Indices) -> "ItemTable":
        return self._kernels.table(place[self.nodes], self._numbers(), self.internal_variables)

    @property
    def internal_variables(self) -> Indices | None:
        """Return the components of velocities that items remember, shape (item, slot)."""
        return None

    @property
    def derivatives(self) -> ForceDerivatives | str:
        """Return the derivatives of forces, also by what can be learnt."""
        if not self.learnt:
            return "have no exact derivatives"
        return self._kernels.derivatives(self.learnt)


def _every(position: Floats) -> Indices:
    return np.arange(position.shape[-2], dtype=np.int64)


def _flat(vectors: Floats) -> Floats:
    return np.ascontiguousarray(vectors, dtype=float).reshape(-1)


@cache
def traced_item(
    potential: PotentialFunction, corners: int, widths: tuple[tuple[str, int], ...],
    slots: int = 0,
) -> TracedItem:  # fmt: skip
    """Return ``TracedItem``, once for each; the arguments are its own.

    Raises:
        TracingError: The potential cannot be traced, or supplies power.
    """
    found = TracedItem(potential, corners, dict(widths), slots=slots)
    if found.supply.value != 0.0:
        raise TracingError(
            f"{place_of(potential)}: it supplies power, for which equilibria need more: write "
            "a Field of its own"
        )
    return found
