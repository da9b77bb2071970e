"""Fields whose groups of items store an energy of sums over these, such as of a volume.

A member states the share of an item in the sums, and the energy of a group by its sums, as in
``autodiff.pools``. Forces, powers, matrices and bounds follow, also where an amount in the
energy changes in time, and where corners of items are points that nodes carry.

The matrix has a column for each pivot of ∂²U/∂s∂s, which couples all nodes of a group.
"""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Number
from tissuec.autodiff.pools import ShareFunction, StoringPool, WholeFunction
from tissuec.forces.effects import Resisting
from tissuec.forces.fields import Field, Items, WalledField
from tissuec.forces.grouped_items import GroupedItems, as_rows, inputs
from tissuec.forces.matrices import ForceDerivatives, whole
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix

    from tissuec.compiled.loops.tables import PoolTable
    from tissuec.forces.potential_kernels import PotentialKernels

LARGE = 96  # unknowns that a group acts on: its part of a sparse matrix would fill it


class GroupedField(Field, frozen=True, dict=True):
    """A field of items in groups, with loops in several passes."""

    @cached_property
    @abstractmethod
    def grouped(self) -> GroupedItems:
        """Return the items."""

    @property
    @abstractmethod
    def _kernels(self) -> "PotentialKernels":
        """Return the kernels of the items."""

    @property
    def _row_count(self) -> int:
        """Return how many numbers of an item are stored between passes."""
        return 0

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the loops that add forces and powers."""
        return self._kernels.forces

    @cached_property
    def _made(self) -> "dict[bytes, PoolTable]":
        return {}

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> "PoolTable":
        """Return the items with other numbers of nodes."""
        from tissuec.forces.pooled_kernels import pool_table  # which costs time

        return pool_table(self._made, self.grouped, self._kernels, place, acts, self._row_count)


class PooledField(GroupedField, WalledField, frozen=True, dict=True):
    """A field whose groups of items store energies.

    Attributes:
        item_shares: Shares of an item in the sums of its group.
        group_energy: Energy of a group.
        learnt: Numbers of groups, which are attributes, by which there are derivatives for
            learning.
    """

    item_shares: ClassVar[ShareFunction]
    group_energy: ClassVar[WholeFunction]
    learnt: ClassVar[tuple[str, ...]] = ()

    @property
    def pool(self) -> StoringPool:
        """Return an item and a group as their functions were traced."""
        own, items = type(self), self.grouped
        numbers, corners = (items.numbers, items.of_groups), items.corners.shape[1]
        widths = (
            tuple((name, len(rows)) for name, rows in as_rows(each).items()) for each in numbers
        )
        return _traced(own.item_shares, own.group_energy, corners, *widths)

    def amount(self, time: Floats | float) -> Floats:
        """Return the sum of the ``changes``, dimensionless, shape (…)."""
        times = np.asarray(time, dtype=float)
        parts = [amount * np.asarray(curve.at(times)[0]) for amount, curve in self.changes]
        return np.asarray(sum(parts, np.zeros(times.shape)))

    # --- sums and energies --------------------------------------------------------------------

    def sums(self, position: Floats) -> Sequence[Floats]:
        """Return the sums of the groups, shape (…, group) each.

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        first = self.grouped.first
        found = evaluate(self.pool.shares.summed, self.grouped.inputs(position))
        # In order in memory, so that a sum does not depend on how many there are.
        return [np.add.reduceat(np.ascontiguousarray(s), first[:-1], axis=-1) for s in found]

    def _of_groups(self, time: Floats | float, position: Floats) -> dict[str, Floats]:
        """Return the inputs of groups, shape (…, group) or (1,) each."""
        items, found = self.grouped, inputs(self.grouped.of_groups)
        found["a.0"] = self.amount(time)[..., None]
        found |= {f"s.0.{k}": each for k, each in enumerate(self.sums(position))}
        seen = items.points.and_nodes(position)[..., items.seen, :]
        return found | {f"x.1.{axis}": seen[..., axis] for axis in range(3)}

    def _in_groups(
        self, outputs: Sequence[Number], time: Floats | float, position: Floats
    ) -> list[Floats]:
        """Return numbers of groups, shape (…, group) each."""
        values = self._of_groups(time, position)
        shape = np.broadcast_shapes(*(each.shape for each in values.values()))
        return [np.broadcast_to(each, shape) for each in evaluate(outputs, values)]

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        return self._in_groups([self.pool.energy], time, position)[0].sum(axis=-1)

    # --- matrices -----------------------------------------------------------------------------

    def bending(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> "csr_matrix":
        """Return Σ λ ∂²s/∂x∂x [N/m], shape (3 size, 3 size); arguments as of ``matrix``."""
        from scipy.sparse import csr_matrix

        pool, items = self.pool, self.grouped
        values, (count, corners) = items.inputs(position), items.corners.shape
        for name, slope in zip(
            pool.given, self._in_groups(pool.whole.factors, time, position), strict=True
        ):
            values[str(name.operation.detail)] = slope[items.owner]
        both = whole(items.each(list(pool.item.matrix.values()), values))
        blocks = both.reshape(count, corners, 3, corners, 3)
        return csr_matrix(items.points.assembled(blocks, items.corners, number, size))

    def slopes_of_sums(
        self, position: Floats, number: Indices, size: int
    ) -> "list[csr_matrix]":
        """Return ∂s/∂x of the groups for each sum, shape (3 size, group).

        Args:
            position: Of all nodes [m], shape (node, 3).
            number: Of each node of the scene among those that may move, -1 for others.
            size: Number of nodes that may move.
        """
        from scipy.sparse import csr_matrix

        pool, items = self.pool, self.grouped
        values, found = self.grouped.inputs(position), list[csr_matrix]()
        places = items.points.numbers(items.corners, number, size)
        rows = (3 * places[:, :, None] + np.arange(3)).reshape(len(places), -1)
        groups = np.broadcast_to(items.owner[:, None], rows.shape)
        shape = 3 * (size + items.points.count), len(items.seen)
        for slopes in pool.slopes:
            each = items.each(slopes, values)
            moves = (rows >= 0) & (each != 0.0)
            found.append(csr_matrix((each[moves], (rows[moves], groups[moves])), shape=shape))
        if items.points.count:
            follow = items.points.follow(number, size)
            found = [csr_matrix(follow.T @ each) for each in found]
        return found

    def columns(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix]":
        """Return P and N of Σ ∂s/∂x ∂²U/∂s∂s ∂s/∂x = P Pᵀ - N Nᵀ [(N/m)^½].

        They have columns for the positive and for the negative pivots. Arguments are those of
        ``matrix``, and the shapes (3 size, n).
        """
        from scipy.sparse import csc_matrix, diags, hstack

        ways = self.slopes_of_sums(position, number, size)
        found = [csc_matrix((3 * size, 0))], [csc_matrix((3 * size, 0))]
        for pivot, slope in self._pivots(time, position):
            parts = [way @ diags(slope[:, j]) for j, way in enumerate(ways)]
            column = csc_matrix(sum(parts[1:], parts[0]) @ diags(np.sqrt(np.abs(pivot))))
            for sign, part in zip((1.0, -1.0), found, strict=True):
                part.append(column[:, sign * pivot > 0.0])
        positive, negative = (csc_matrix(hstack(part)) for part in found)
        return positive, negative

    def _pivots(self, time: float, position: Floats) -> list[tuple[Floats, Floats]]:
        """Return D and L of ∂²U/∂s∂s = Σ D L Lᵀ, shapes (group,) and (group, sum)."""
        bend = whole(np.stack(self._in_groups(self.pool.bend, time, position), axis=-1))
        found = list[tuple[Floats, Floats]]()
        for k in range(bend.shape[-1]):
            pivot, column = bend[:, k, k], bend[:, k]
            slope, is_some = np.zeros_like(column), pivot[:, None] != 0.0
            np.divide(column, pivot[:, None], out=slope, where=is_some)
            slope[:, :k] = 0.0
            bend = bend - pivot[:, None, None] * slope[:, :, None] * slope[:, None, :]
            found.append((pivot, slope))
        return found

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return the second derivative of the energy [N/m]; see ``Effect``."""
        from scipy.sparse import csc_matrix

        positive, negative = self.columns(time, position, number, size)
        total = positive @ positive.T
        if exact:
            total = total - negative @ negative.T + self.bending(time, position, number, size)
        return csc_matrix(total)

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[csc_matrix, Floats]":
        """Return ``matrix`` with large groups apart, each as one column; see ``Effect``.

        Of these, the columns of negative pivots are left out, which are small beside the
        others: of a fluid, their ratio to the weight is that of its pressure to K.
        """
        from scipy.sparse import csc_matrix

        positive, negative = self.columns(time, position, number, size)
        is_large = np.diff(positive.indptr) > LARGE
        total = positive[:, ~is_large] @ positive[:, ~is_large].T
        if exact:
            small = negative[:, np.diff(negative.indptr) <= LARGE]
            total = total - small @ small.T + self.bending(time, position, number, size)
        return csc_matrix(total), positive[:, is_large].toarray()

    # --- bounds -------------------------------------------------------------------------------

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return a bound on the negative eigenvalues that ``bending`` may cause [N/m]."""
        return float(abs(self.bending(time, position, number, size)).sum(axis=1).max())

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the columns of positive pivots as an operator [N/m]; see ``Effect``."""
        every, count = np.arange(len(position)), len(position)
        columns = cache(lambda: self.columns(time, position, every, count)[0])

        def resist(moved: Floats, to: Floats) -> None:
            to += (columns() @ (columns().T @ moved.ravel())).reshape(-1, 3)

        return resist

    def spread(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of the energy [J]; see ``Effect``."""
        pool = self.pool
        energy, *slopes = self._in_groups([pool.energy, *pool.whole.factors], time, position)
        parts = (np.abs(a * b) for a, b in zip(slopes, self.sums(position), strict=True))
        return float((np.abs(energy) + sum(parts)).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of forces [N]; see ``Effect``."""
        pool, values, found = self.pool, self.grouped.inputs(position), [0.0]
        bend = whole(np.stack(self._in_groups(pool.bend, time, position), axis=-1))
        for k, (slopes, total) in enumerate(zip(pool.slopes, self.sums(position), strict=True)):
            steep = np.abs(self.grouped.each(slopes, values)).max()
            found.append(float(steep * np.abs(bend[:, k, k] * total).max()))
        return max(found)

    # --- for the engine and for learning --------------------------------------------------

    @property
    def _kernels(self) -> "PotentialKernels":
        from tissuec.forces.pooled_kernels import kernels_of  # which costs time

        name, pool, items = type(self).__name__.lower(), self.pool, self.grouped
        shared = tuple((each, np.ndim(items.of_groups[each]) == 0) for each in self.learnt)
        return kernels_of(name, pool.item, pool, ("x",) if items.carries else (), shared)

    @property
    def _row_count(self) -> int:
        return len(self.pool.rows)

    def items(self, place: Indices) -> Items:
        """Return the nodes of the groups; those that carry points have to be among them."""
        items = self.grouped
        nodes = np.where(items.corners < 0, items.corners.max(axis=1)[:, None], items.corners)
        return Items(place[nodes].ravel(), nodes.shape[1] * items.first)

    @property
    def derivatives(self) -> ForceDerivatives | str:
        """Return the derivatives of forces, also by what can be learnt."""
        if not self.learnt:
            return "has no exact derivatives"
        return self._kernels.derivatives(self.learnt)


@cache
def _traced(
    share: ShareFunction, whole: WholeFunction, corners: int,
    columns: tuple[tuple[str, int], ...], widths: tuple[tuple[str, int], ...],
) -> StoringPool:  # fmt: skip
    """Return ``StoringPool``, once for each; the arguments are its own."""
    return StoringPool(share, whole, corners, dict(columns), dict(widths))
