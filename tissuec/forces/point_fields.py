"""Elements around points whose energy is written once, of solids and of walls.

Forces, rates of what is remembered, powers, matrices, stresses, tangents and energies follow
from a ``autodiff.points.TracedPoint`` and ∂N/∂X; see ``solids.elements`` and
``surfaces.membranes``.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.calls import kernel_on
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.point_derivatives import pull_loop, push_loop
from tissuec.compiled.loops.point_frame import PointTable
from tissuec.compiled.loops.point_matrices import matrix_loop
from tissuec.compiled.loops.points import force_loop
from tissuec.compiled.loops.tables import recorded, room_for
from tissuec.core.arrays import irregular
from tissuec.core.keeping import kept_on_owner
from tissuec.core.structs import replace
from tissuec.forces.element_fields import ElementField
from tissuec.forces.matrices import BlockPattern, ForceDerivatives, whole, without_negative
from tissuec.forces.memory import TANGENT_SECONDS, MemoryTangents
from tissuec.forces.moduli import young_of
from tissuec.forces.point_kernels import Tracing, kernel_of, limit_kernel, record_kernel
from tissuec.forces.solids.element_limits import BreakableElements, ElementLimits
from tissuec.forces.solids.element_memory import Branches, ElementYield, StoredTensors
from tissuec.forces.solids.solid_point import SolidKind
from tissuec.forces.solids.solid_strain import SolidFibres
from tissuec.kernels.records import BoundaryConditions
from tissuec.laws.solid import SolidLaw
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

ALIKE = 1e-9  # of the size of elements: differences of places that are rounding
MANY = 2000  # energies of elements, from which on a kernel finds them: it takes time to make
NEVER = 1e300  # a yield stress instead of an infinite one [Pa]
# Of a matrix, and of the damping of viscous elements, over an evaluation without tensors.
_MAKING, _DAMPING = 17.0, 120.0


class PointField(ElementField, frozen=True, dict=True):
    """Elements that follow laws of solids; one that loses an edge or breaks is removed.

    ``walls`` are the elements themselves, as entities of the network.

    Attributes:
        columns, parts: Attributes with a row for each element, and others of all elements.
        name: Of the body.
        limits: At which they break; None where nothing may break.
        laws: That they follow.
        shear, viscosity: μ [Pa] and η [Pa s], shape (element,).
        law: Number of the law, shape (element,).
        fibres: Families of fibres, without stress; there may be none.
        branches: That relax; None without any.
        yielding: Their yield stresses and flow; None where nothing yields.
        recalled: Velocities followed by internal variables, which elements remember, shape (…,
            row, 3); energies, matrices and stresses include it. Without,
            they are those without branches and before any flow.
        constants: Of laws, which have variables in their places; see ``points_derivatives``;
            shape (element, constant).
        stretches: F0, row by row, where it is not part of ∂N/∂X, shape (element, 9), and for
            walls the ratio of volumes without stress to ``weights``, which then are as drawn,
            shape (element, 5); without, shape (element, 0).
    """

    directions: ClassVar[int] = 3
    is_cut: ClassVar[bool] = False  # whether they are parts of cells
    traced: ClassVar[Tracing]
    columns: ClassVar[tuple[str, ...]] = (
        "nodes", "shear", "viscosity", "law", "constants", "stretches",
    )  # fmt: skip
    parts: ClassVar[tuple[str, ...]] = ("fibres", "limits", "branches", "yielding")
    name: str
    limits: ElementLimits | None
    laws: tuple[SolidLaw, ...]
    shear: Floats
    viscosity: Floats
    law: Indices
    fibres: SolidFibres
    branches: Branches | None
    yielding: ElementYield | None
    recalled: Floats | None
    constants: Floats
    stretches: Floats

    # --- what elements have -------------------------------------------------------------------

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,), with the walls of all."""
        some: dict[str, Any] = {name: getattr(self, name)[items] for name in self.columns}
        for name in self.parts:
            part = getattr(self, name)
            some[name] = part and part.some(items)
        return replace(self, **some)

    @property
    @abstractmethod
    def edges(self) -> Indices:
        """Return the nodes of the edges of each element, shape (element, edge, 2)."""

    @property
    @abstractmethod
    def faces(self) -> Indices:
        """Return the triangles of the surface of each element, shape (element, triangle, 3)."""

    @property
    @abstractmethod
    def shares(self) -> Floats:
        """Return the drawn volumes of points that nodes have [m³].

        The shape is (element, point, node).
        """

    @abstractmethod
    def stresses(self, position: Floats) -> Floats:
        """Return the Cauchy stress at all points [Pa], shape (element, point, 3, 3).

        It has no viscous part.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """

    def principal_stretches(self, position: Floats) -> Floats:
        """Return principal stretches of points from the shape without stress, descending.

        They are those of the places between nodes, which cells that bend strain further. Those
        of walls are in their plane.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Returns:
            Dimensionless, shape (element, point, direction).
        """
        return np.linalg.svd(PointField.deformations(self, position), compute_uv=False)

    @property
    def plastic_strains(self) -> Floats:
        """Return equivalent plastic strains as recalled [1], shape (element, point)."""
        if self.yielding is None or self.recalled is None:
            return np.zeros((self.item_count, self.points))
        return self.yielding.equivalent(self.recalled, self.points)

    @property
    def node_volumes(self) -> Floats:
        """Return the drawn volume of each node of each element [m³], shape (element, node)."""
        return self.shares.sum(axis=1)

    @property
    @abstractmethod
    def measures(self) -> tuple[Floats, Floats, Indices]:
        """Return ∂N/∂X and volumes of points, and the row of each element among these.

        Returns:
            [1/m], shape (row, point, node, direction); [m³], shape (row, point); and shape
            (element,).
        """

    @property
    @abstractmethod
    def bulk_modulus(self) -> Floats:
        """Return K [Pa], shape (element,)."""

    @property
    @abstractmethod
    def sizes(self) -> Floats:
        """Return the sizes of elements as drawn [m], shape (element,)."""

    @abstractmethod
    def volumetric(self) -> dict[str, Floats]:
        """Return the moduli of volume [Pa], by the names of ``SolidKind.widths``.

        Each has the shape (element,).
        """

    @property
    def points(self) -> int:
        """Return the number of points of an element."""
        return self.measures[1].shape[1]

    @property
    def weights(self) -> Floats:
        """Return the volumes of points without stress [m³], shape (element, point)."""
        _, weight, row = self.measures
        return weight[row]

    @property
    def steepness(self) -> Floats:
        """Return ∂N/∂X [1/m], shape (element, point, node, direction)."""
        gradients, _, row = self.measures
        return gradients[row]

    @property
    @abstractmethod
    def with_stretches(self) -> Self:
        """Return the elements with ``stretches``."""

    def deformations(self, position: Floats) -> Floats:
        """Return F, with prestretch, at all points, shape (…, element, point, 3, direction).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        places = position[..., self.nodes, :].swapaxes(-1, -2)[..., None, :, :]
        return np.asarray(places @ self.steepness)

    @property
    def young(self) -> Floats:
        """Return Young's modulus at rest, without fibres [Pa], shape (element,)."""
        return young_of(self.shear, self.bulk_modulus)

    @property
    def fibre_lines(self) -> tuple[Floats, Floats]:
        """Return ∂N/∂X · a of families of fibres at points, and the volumes of these.

        They refer to the shape without stress; shapes (element, line, node) [1/m] and (element,
        line) [m³], a line being a family at a point.
        """
        slopes = np.einsum("eqak,efk->eqfa", self.steepness, self.fibres.along)
        shape = (self.item_count, -1, self.nodes.shape[1])
        count = self.fibres.along.shape[1]
        return slopes.reshape(shape), np.repeat(self.weights, count, axis=1)

    def invariants(self, position: Floats) -> tuple[Floats, Floats]:
        """Return both isochoric invariants, shape (element, point).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        first, second = self.seen("invariants", position)
        return first, second

    # --- energy and matrix --------------------------------------------------------------------

    def energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], shape (…, element).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        if position.ndim == 2 and not self._present.tensors:
            self._asked[0] += self.item_count
            if self._asked[0] >= MANY:
                return self._measure_energy(len(position))(position.ravel())
        return self._energies(position)

    def _energies(self, position: Floats) -> Floats:
        """Return ``energies`` by NumPy."""
        found = np.empty((*position.shape[:-2], self.item_count))
        for part, own in self.in_blocks():
            kind, _ = own._stiffened
            point, weight = self.traced(kind), own.weights
            outputs = [point.state.energy, point.pooled]
            values = own._values(position, outputs, kind)
            stored, pooled = evaluate(outputs, values)
            total = (weight * stored).sum(axis=-1)
            found[..., part] = total + own._alone(point, pooled, values)
        return found

    @cached_property
    def _asked(self) -> list[int]:
        """Return how many energies have been asked for, one number."""
        return [0]

    @kept_on_owner(1)
    def _measure_energy(self, nodes: int) -> Callable[[Floats], Floats]:
        """Return the kernel of energies of elements [J] at places of so many nodes."""
        measure = self.measuring(("energy",), np.arange(nodes))
        volume = self.weights.sum(axis=1)
        return lambda x: volume * measure(x)[:, 0]

    def _alone(
        self, point: TracedPoint, pooled: Floats, values: dict[str, Floats]
    ) -> Floats | float:
        """Return the energy that elements store besides their points [J], shape (…, element).

        Args:
            point: The traced one of their kind.
            pooled: r of their points, shape (…, element, point).
            values: As of ``_values``, for energies; those of means are added.
        """
        return 0.0

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        return self.energies(position).sum(axis=-1)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size); see ``Effect``."""
        if not exact or not (number[self.nodes] >= 0).any():
            return super().matrix(time, position, number, size, exact=exact)
        pattern, kernel, table = self._matrix_table(number.astype(np.int64).tobytes(), size)
        room = pattern.room
        self._run(kernel, position, room, table)
        return pattern.matrix(room)

    def alike(self, position: Floats) -> tuple[Indices, Indices]:
        """Return elements with the same matrices; see ``ElementField``.

        Alike are those of the same numbers whose nodes have the same places relative to the
        first, but for rounding.
        """
        kind, count = self._present, self.item_count
        if not count or kind.tensors:
            return super().alike(position)
        own = position[self.nodes]
        own = own - own[:, :1]
        unit = ALIKE * float(np.abs(own).max()) or 1.0
        columns = [np.round(own / unit), self.measures[2], *self._columns(kind).values()]
        flat = [np.asarray(each, dtype=float).reshape(count, -1) for each in columns]
        found: Floats = np.concatenate(flat, axis=1)
        # By a sum of irregular parts; others that have the same one are none that are alike.
        mixed = (found * irregular(len(found.T))).sum(axis=1)
        first, kinds = np.unique(mixed, return_index=True, return_inverse=True)[1:]
        if (found != found[first[kinds]]).any():
            return super().alike(position)
        return first, kinds

    @kept_on_owner(1)
    def _matrix_table(
        self, number: bytes, size: int
    ) -> tuple[BlockPattern, GeneratedKernel, PointTable]:
        """Return pattern, kernel and table of the matrix of elements at free nodes."""
        numbers = np.frombuffer(number, np.int64)[self.nodes]
        own = self.only(np.flatnonzero((numbers >= 0).any(axis=1)))
        kind, points = own._stiffened  # laws are numbered among these
        pattern = BlockPattern.of(numbers[(numbers >= 0).any(axis=1)], size)
        kernel = kernel_of(matrix_loop, own.traced, kind, own.nodes.shape[1], points)
        table = own._table(kind, own.nodes, own.slots)
        return pattern, kernel, table._replace(targets=pattern.places.ravel())

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each element [N/m], shape (element, node, 3, node, 3).

        Without ``exact``, negative eigenvalues of ∂P/∂F at each point count as zero. (J. Teran,
        E. Sifakis, G. Irving, R. Fedkiw, Symp. Computer Animation 2005, p. 181.)
        """
        stiff = whole(self._recorded("moduli", position))
        if not exact:
            stiff = without_negative(stiff)
        return self._between_nodes(stiff)

    def _between_nodes(self, moduli: Floats) -> Floats:
        """Return Σ w ∂N/∂X A ∂N/∂X of each element, shape (element, node, 3, node, 3).

        Args:
            moduli: A at the points, in any unit, shape (element, point, row, row) by the rows
                and columns of F.
        """
        weight, slopes = self.weights, self.steepness
        elements, points, count, width = slopes.shape
        # By component and node instead of component and direction: first of one end, then of
        # the other.
        moduli = weight[..., None, None] * moduli
        moduli = moduli.reshape(elements, points, 3, width, 3 * width)
        half = (slopes[:, :, None] @ moduli).reshape(elements, points, 9 * count, width)
        half = half.swapaxes(1, 2).reshape(elements, 9 * count, points * width)
        every = slopes.swapaxes(-1, -2).reshape(elements, points * width, count)
        values = (half @ every).reshape(elements, 3, count, 3, count)
        return values.transpose(0, 2, 1, 4, 3)

    @property
    def is_damped(self) -> bool:
        """Return whether any element is viscous."""
        return bool(self.viscosity.any())

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of viscous forces by velocities; see ``ElementField``."""
        return self._between_nodes(whole(self._recorded("viscous_moduli", position)))

    def piola(self, position: Floats) -> Floats:
        """Return P without its viscous part [Pa], shape (element, point, 3, direction).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        found = self._recorded("elastic_stress", position)
        return found.reshape(*found.shape[:2], 3, self.directions)

    def around(self, nodes: Indices) -> tuple[Self, Indices]:
        """Return the elements at some nodes, and all nodes of these.

        Args:
            nodes: Indices, shape (n,).

        Returns:
            The elements, with the places of their nodes among the second, which are ascending.
        """
        return self._renumbered(np.isin(self.nodes, nodes).any(axis=1))

    def inside(self, nodes: Indices) -> tuple[Self, Indices]:
        """Return the elements all of whose nodes are among some; see ``around``.

        Args:
            nodes: Indices, shape (n,).
        """
        return self._renumbered(np.isin(self.nodes, nodes).all(axis=1))

    def _renumbered(self, chosen: NDArray[np.bool_]) -> tuple[Self, Indices]:
        own = self.only(np.flatnonzero(chosen))
        used, place = np.unique(own.nodes, return_inverse=True)
        return replace(own, nodes=place.reshape(own.nodes.shape)), used

    def node_stress(self, position: Floats) -> tuple[Floats, Floats]:
        """Return sums of stress over the shares of nodes, and these shares.

        The mean stress of a node is the first divided by the second, without viscous stress.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Returns:
            Σ w σ [J], shape (node, 3, 3), and Σ w [m³], shape (node,).
        """
        total, volume = np.zeros((len(position), 3, 3)), np.zeros(len(position))
        for _, own in self.in_blocks():
            share = own.shares
            stress = np.einsum("eqa,eqxy->eaxy", share, own.stresses(position))
            np.add.at(volume, own.nodes, share.sum(axis=1))
            np.add.at(total, own.nodes, stress)
        return total, volume

    def mean_stress(self, position: Floats) -> Floats:
        """Return the mean Cauchy stress of each element [Pa], shape (element, 3, 3).

        Places count by their drawn volume; viscous stress is left out.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        found = np.zeros((self.item_count, 3, 3))
        for items, own in self.in_blocks():
            weight = own.shares.sum(axis=2)
            weight /= weight.sum(axis=1, keepdims=True)
            found[items] = np.einsum("eq,eqxy->exy", weight, own.stresses(position))
        return found

    # --- bounds -------------------------------------------------------------------------------

    @property
    def rigidity(self) -> Floats:
        """Return moduli times volumes [J], shape (element,)."""
        _, weight, row = self.measures
        sudden = 0.0 if self.branches is None else self.branches.sudden
        every = self.shear + sudden + self.bulk_modulus + self.fibres.modulus
        return every * weight.sum(axis=1)[row]

    @property
    def steepest(self) -> Floats:
        """Return the largest gradient of a shape function [1/m], shape (element,)."""
        gradients, _, row = self.measures
        return np.abs(gradients).max(axis=(1, 2, 3))[row]

    def fastest(self, mass: Floats) -> float:
        """Return about the largest angular frequency of the elements [1/s].

        Args:
            mass: Of all nodes [kg], shape (node,).
        """
        gradients, weight, row = self.measures
        steep = weight[..., None] * (gradients**2).sum(axis=-1)
        steep = steep.sum(axis=1) / weight.sum(axis=1)[:, None]
        each = self.rigidity[:, None] * steep[row]
        joined = np.bincount(self.nodes.ravel(), each.ravel(), len(mass))
        return float(np.sqrt(2.0 * (joined / mass).max()))

    def spread(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of the energy [J]; see ``Effect``."""
        return float(self.rigidity.sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of forces [N]; see ``Effect``."""
        # Places are rounded to a part of their size, and not to one of the size of elements.
        size = float(np.abs(position[self.nodes]).max(initial=0.0))
        each = self.rigidity * self.steepest * (1.0 + size * self.steepest)
        return float(each.max(initial=0.0))

    @property
    def stiffest(self) -> float:
        """Return about the largest stiffness of an element [N/m]."""
        return float((self.rigidity * self.steepest**2).max(initial=0.0))

    # --- memory -------------------------------------------------------------------------------

    def placed(self, node: int, entity: int) -> Self:
        """Return the same elements behind other nodes and entities."""
        return replace(self, nodes=self.nodes + node, walls=self.walls + entity)

    @property
    def stored_tensors(self) -> tuple[StoredTensors, ...]:
        """Return the tensors of branches, and that of plastic strain."""
        return tuple(each for each in (self.branches, self.yielding) if each is not None)

    @property
    def remembers(self) -> bool:
        """Return whether any element relaxes or yields."""
        return bool(self.stored_tensors)

    @property
    def internal_rows(self) -> Indices:
        """Return the rows of branches and of plastic strain; see ``Field``."""
        none = np.zeros(0, dtype=np.int64)
        return np.concatenate([none, *(each.rows(self.points) for each in self.stored_tensors)])

    @property
    def yields(self) -> NDArray[np.bool_]:
        """Return which elements yield, shape (element,)."""
        if self.yielding is None:
            return np.zeros(self.item_count, dtype=bool)
        return self.yielding.keeps[0]

    @property
    def loss(self) -> str:
        """Return why energy is not conserved; see ``Effect``."""
        if self.branches is not None:
            return "there are elements that relax"
        return "" if self.yielding is None else "there are elements that yield"

    @property
    def relaxed(self) -> Self:
        """Return the elements without branches, which no longer flow; see ``Effect``."""
        if not self.remembers:
            return self  # with the tables that it keeps
        yielding = self.yielding and self.yielding.stopped
        return replace(self, branches=None, yielding=yielding)

    def stored(self, first: int, fastest: float) -> Self:
        """Return the elements with rows of velocities for their internal variables.

        Args:
            first: Number of the first of these rows.
            fastest: A bound of the angular frequencies of the net [1/s].
        """
        sizes, found = self.sizes, self
        if self.branches is not None:
            branches = self.branches.stored(3 * first, self.points, fastest, sizes)
            found = replace(found, branches=branches)
            first += len(branches.rows(self.points))
        if self.yielding is not None:
            yielding = self.yielding.stored(3 * first, self.points, fastest, sizes)
            found = replace(found, yielding=yielding)
        return found

    def recalling(self, velocity: Floats) -> Self:
        """Return the elements with the present internal variables; see ``Effect``."""
        return replace(self, recalled=velocity) if self.remembers else self

    def giving(self, position: Floats, velocity: Floats) -> float:
        """Return a bound of the rates at which elements relax and flow [1/s]; see ``Field``."""
        fastest = 0.0
        for _, own in self.recalling(velocity).in_blocks() if self.remembers else ():
            rates = own.seen("paces", position)
            fastest = max(fastest, *(float(each.max(initial=0.0)) for each in rates))
        return fastest

    def memory_tangents(self, position: Floats, velocity: Floats) -> MemoryTangents | None:
        """Return the derivatives of branches and plastic strain, by points; see ``Field``."""
        if not self.remembers or not len(self.internal_rows):
            return None
        stored, points = self._stored, self.points
        width = len(self.traced(self.kind).f)
        flat = self.recalling(velocity)._recorded("tangents", position)
        own = stored[0].numbers
        every = own * sum(len(each.slot) for each in stored)
        by_tensors = flat[..., : every * (width + every)].reshape(
            -1, points, every, width + every
        )
        by_strain = flat[..., every * (width + every) :].reshape(-1, points, width, every)
        has = self.slots >= 0
        rate = np.where(has, np.concatenate([each.rate for each in stored]), 0.0)
        # Variables have the unit of velocities; those that do not exist take no part.
        to_own = np.repeat(rate.T, own, axis=1)[:, None]
        from_own = np.divide(1.0, to_own, where=to_own > 0.0, out=np.zeros_like(to_own))
        pull = from_own[..., None] * by_tensors[..., :width]
        slopes = self.strain_slopes(position)
        giving = from_own[..., None] * by_tensors[..., width:] * to_own[..., None, :]
        by_position = np.einsum("eqsv,eqsax->eqvax", by_strain * to_own[:, :, None], slopes)
        push = -np.einsum("eq,eqvs,eqsax->eqaxv", self.weights, pull, slopes)
        places = np.concatenate([each.places(points) for each in stored])
        slots = np.moveaxis(np.where(has[..., None, None], places, -1), 0, 2)
        return MemoryTangents(
            slots=slots.reshape(-1, every),
            nodes=np.repeat(self.nodes, points, axis=0),
            giving=-giving.swapaxes(-1, -2).reshape(-1, every, every),
            by_position=by_position.reshape(-1, every, *by_position.shape[3:]),
            pull=push.reshape(-1, *push.shape[2:]),
        )

    def strain_slopes(self, position: Floats) -> Floats:
        """Return the derivatives of the strains of points by positions [1/m].

        The shape is (element, point, strain, node, 3), or with one point for all.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        slopes = self.steepness.swapaxes(-1, -2)  # element, point, direction, node
        shape = (*slopes.shape[:2], 3 * self.directions, slopes.shape[-1], 3)
        return np.einsum("xy,eqka->eqxkay", np.eye(3), slopes).reshape(shape)

    def let_relax(self, velocity: Floats, position: Floats, moved: NDArray[np.bool_]) -> None:
        """Make branches give way for good; see ``Field``."""
        if self.branches is None:
            return
        for part, _ in self.in_blocks():
            items = part[moved[self.nodes[part]].any(axis=1)]
            own = self.only(items).relaxed.recalling(velocity)
            numbers = np.stack(own.seen("isochoric", position), axis=-1)
            self.branches.keep(velocity, self.branches.filled(numbers), items)

    # --- limits -------------------------------------------------------------------------------

    @property
    def breakable(self) -> BreakableElements | None:
        """Return the elements that have a limit; None without any."""
        if self.limits is None or not len(able := self.limits.finite):
            return None
        return BreakableElements(self.only(able), self.limits.some(able), self.walls[able])

    @property
    @abstractmethod
    def crack_areas(self) -> Floats:
        """Return the areas of cracks through single elements [m²], shape (element,)."""

    def measuring(
        self, names: tuple[str, ...], place: Indices
    ) -> Callable[[Floats], Floats]:  # fmt: skip
        """Return the function that finds what limits are of; see ``element_limits``."""
        kind = self.kind._replace(branches=0, is_yielding=False, is_viscous=False)
        point, count, still = self.traced(kind), self.item_count, np.zeros(0)
        if "energy" in names and point.graph.has("array", [point.state.energy]):
            return self._measuring_energy(names, place)
        kernel = limit_kernel(self.traced, kind, names, self.nodes.shape[1], self.points)
        room = room_for(len(names), count)
        call = kernel_on(kernel, self._table(kind, place[self.nodes], self.slots[:0]), 3)

        def measure(x: Floats) -> Floats:
            call(0.0, x, still, room.reshape(-1))
            return recorded(room, count)

        return measure

    def _measuring_energy(
        self, names: tuple[str, ...], place: Indices
    ) -> Callable[[Floats], Floats]:  # fmt: skip
        """Return ``measuring`` for energies of which no kernel can be made."""
        others = self.measuring(names[:-1], place) if len(names) > 1 else None
        volume = self.weights.sum(axis=1)

        def measure(x: Floats) -> Floats:
            # Nodes of elements keep their places.
            position = x.reshape(-1, 3).take(place, axis=0, mode="clip")
            energy = (self._energies(position) / volume)[:, None]
            return energy if others is None else np.append(others(x), energy, axis=1)

        return measure

    # --- for learning -------------------------------------------------------------------------

    @property
    def derivatives(self) -> ForceDerivatives | str:
        """Return the derivatives of forces by positions, velocities and numbers."""
        kind, points = self._forced
        names, shape = (
            tuple(name for name in kind.widths if name != "law"),
            (self.nodes.shape[1], points),
        )
        pull, push = (
            kernel_of(each, self.traced, kind, names, *shape) for each in (pull_loop, push_loop)
        )
        return ForceDerivatives(names, pull, push)

    def column(self, name: str) -> Floats:
        """Return numbers of the elements, shape (element, number); see ``Field``."""
        return self._columns(self.kind)[name]

    def with_columns(self, columns: Mapping[str, Floats]) -> Self:
        """Return elements with other numbers; see ``Field``."""
        own = {name: each[:, 0] for name, each in columns.items()}
        found = self._with_volumetric(own)
        found |= {name: own[name] for name in ("shear", "viscosity") if name in own}
        if "constant" in columns:
            found["constants"] = columns["constant"]
        if "stretch" in columns:
            found["stretches"] = columns["stretch"]
        if "along" in columns:
            found["fibres"] = SolidFibres(
                columns["along"].reshape(self.fibres.along.shape),
                own["fibre_stiffness"], own["fibre_stiffening"], own["dispersion"],
            )  # fmt: skip
        with np.errstate(divide="ignore"):  # what never relaxes or flows
            if self.branches is not None:
                shear, pace = columns["branch_shear"].T, columns["branch_pace"].T
                found["branches"] = replace(self.branches, shear=shear, time=1.0 / pace)
            if self.yielding is not None:
                limit, viscosity = own["yield_stress"], 1.0 / own["yield_pace"]
                found["yielding"] = replace(self.yielding, limit=limit, viscosity=viscosity)
        return replace(self, **found)

    @abstractmethod
    def _with_volumetric(self, numbers: Mapping[str, Floats]) -> dict[str, Any]:
        """Return the attributes that follow from the numbers of ``volumetric``."""

    def damping_derivatives(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix] | None":
        """Return minus the derivatives of viscous forces, all of them; see ``Field``."""
        if not self.is_damped:
            return None
        slow = self._slow(position, number, size)
        by_strain = self._sum(
            lambda own: own.braking_by_position(position, velocity), number, size,
        )  # fmt: skip
        return by_strain, slow

    def braking_by_position(self, position: Floats, velocity: Floats) -> Floats:
        """Return minus the derivative of viscous forces by positions [N/m].

        The shape is (element, node, 3, node, 3).

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        flat = self._recorded("viscous_by_strain", position, velocity)
        side = 3 * self.directions
        return self._between_nodes(flat.reshape(*flat.shape[:2], side, side))

    # --- for the engine -----------------------------------------------------------------------

    @property
    @abstractmethod
    def _bare_seconds(self) -> float:
        """Return an estimate of the time of an evaluation of what nothing remembers [s]."""

    @property
    def matrix_seconds(self) -> float:
        """Return an estimate of the time of making their matrix [s]."""
        damping = _DAMPING if self.is_damped else 0.0
        tangents = TANGENT_SECONDS * len(self.internal_rows)
        return (_MAKING + damping) * self._bare_seconds + tangents

    @property
    def kernel(self) -> GeneratedKernel:
        """Return the loop that adds forces, rates and powers."""
        kind, points = self._forced
        return kernel_of(force_loop, self.traced, kind, self.nodes.shape[1], points)

    @property
    def kind(self) -> SolidKind:
        """Return the kind of the points, of which forces are."""
        laws = tuple(self.laws[int(k)] for k in np.unique(self.law).tolist())
        branches = 0 if self.branches is None else len(self.branches.slot)
        return SolidKind(
            laws or self.laws[:1], self.fibres.along.shape[1], branches,
            self.yielding is not None, self.is_damped, self.directions,
            self.constants.shape[1], self.stretches.size > 0,
        )  # fmt: skip

    @property
    def _present(self) -> SolidKind:
        """Return the kind of the points, of which energies and matrices are."""
        kind = self.kind
        if self.recalled is None:
            kind = kind._replace(branches=0, is_yielding=False)
        return kind

    @property
    def _forced(self) -> tuple[SolidKind, int]:
        """Return the kind and number of points of which forces are."""
        return self._counted(self.kind)

    @property
    def _stiffened(self) -> tuple[SolidKind, int]:
        """Return the kind and number of points of which matrices are."""
        return self._counted(self._present)

    def _counted(self, kind: SolidKind) -> tuple[SolidKind, int]:
        """Return the kind that kernels use for a kind, and their number of points."""
        return kind, self.points

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> PointTable:
        """Return the record of the kernel, which is valid at any position."""
        (kind, _), slots = self._forced, self.slots
        moved = np.where(slots >= 0, 3 * place[np.maximum(slots, 0) // 3], -1)
        return self._table(kind, place[self.nodes], moved)

    def _table(self, kind: SolidKind, nodes: Indices, slots: Indices) -> PointTable:
        gradients, volume, rows = self.measures
        used, row = np.unique(rows, return_inverse=True)
        return PointTable.of(
            nodes, self._numbers(kind), row.reshape(-1), gradients[used], volume[used],
            slots[: kind.tensors],
        )  # fmt: skip

    def _numbers(self, kind: SolidKind) -> Floats:
        """Return the numbers of elements as tables have them, shape (number, element)."""
        columns = self._columns(kind)
        return np.concatenate([columns[name].T for name in self.traced(kind).widths])

    def with_slots(self, slots: Indices) -> Self:
        """Return the elements with other places of their tensors.

        Args:
            slots: As ``slots`` has them, shape (tensor, element).
        """
        found, first = dict[str, Any](), 0
        for name in ("yielding", "branches"):
            if (own := getattr(self, name)) is not None:
                found[name] = replace(own, slot=slots[first : first + len(own.slot)])
                first += len(own.slot)
        return replace(self, **found)

    @property
    def tensor_size(self) -> int:
        """Return how many numbers a tensor has at all points of an element."""
        return self.points * max((each.numbers for each in self._stored), default=0)

    @property
    def slots(self) -> Indices:
        """Return where tensors are kept, shape (tensor, element); see ``StoredTensors``."""
        none = np.zeros((0, self.item_count), dtype=np.int64)
        return np.concatenate([none, *(each.slot for each in self._stored)])

    @property
    def _stored(self) -> list[StoredTensors]:
        """Return the tensors that a point keeps: plastic strain first, and then branches."""
        return [each for each in (self.yielding, self.branches) if each is not None]

    def _columns(self, kind: SolidKind) -> dict[str, Floats]:
        """Return the numbers of elements, shape (element, number) each."""
        found = {"shear": self.shear} | self.volumetric()
        if len(kind.laws) > 1:
            found["law"] = np.unique(self.law, return_inverse=True)[1].astype(float)
        if kind.constants:
            found["constant"] = self.constants
        if kind.is_stretched:
            found["stretch"] = self.stretches
        if kind.is_viscous:
            found["viscosity"] = self.viscosity
        if kind.families:
            fibres = self.fibres
            found |= {
                "fibre_stiffness": fibres.stiffness, "fibre_stiffening": fibres.stiffening,
                "dispersion": fibres.dispersion, "along": fibres.along,
            }  # fmt: skip
        if kind.branches:
            assert self.branches is not None
            found |= {
                "branch_shear": self.branches.shear.T,
                "branch_pace": self.branches.pace.T,
            }
        if kind.is_yielding:
            assert self.yielding is not None
            found["yield_stress"] = np.minimum(self.yielding.limit, NEVER)
            flows = np.isfinite(self.yielding.limit)
            found["yield_pace"] = np.where(flows, 1.0 / self.yielding.viscosity, 0.0)
        if kind.tensors:
            rate = np.concatenate([each.rate for each in self._stored])
            inverse = np.where(self.slots >= 0, 1.0 / rate, 0.0)
            found |= {"rate": rate.T, "inverse_rate": inverse.T}
        shapes = {name: max(1, each[:1].size) for name, each in found.items()}
        return {name: np.reshape(each, (-1, shapes[name])) for name, each in found.items()}

    def _values(
        self, position: Floats, outputs: Sequence[Number], kind: SolidKind | None = None
    ) -> dict[str, Floats]:
        """Return the inputs of outputs of a point, by name, shape (…, element, point).

        Args:
            kind: Of the point; by default, the present one.
        """
        kind = kind or self._present
        values: dict[str, Floats] = {}
        for name, each in self._columns(kind).items():
            values |= {f"p.{name}.{k}": each[:, k, None] for k in range(each.shape[1])}
        values |= self._strains(position, outputs, kind, values)
        if kind.tensors:
            assert self.recalled is not None
            parts = [each.told(self.recalled, self.points) for each in self._stored]
            tensors = np.concatenate(parts, axis=-4)
            for t, k in np.ndindex(kind.tensors, tensors.shape[-1]):
                values[f"t.{t}.{k}"] = tensors[..., t, :, :, k]
        return values

    def _strains(
        self, position: Floats, outputs: Sequence[Number], kind: SolidKind,
        numbers: Mapping[str, Floats],
    ) -> dict[str, Floats]:  # fmt: skip
        """Return inputs that are strains; see ``_values``.

        Args:
            numbers: Of elements, by the names of inputs.
        """
        f, width = self.deformations(position), self.directions
        return {f"f.{k}": f[..., k // width, k % width] for k in range(3 * width)}

    def seen(self, name: str, position: Floats) -> list[Floats]:
        """Return numbers that points have beside energies, shape (…, element, point) each.

        Args:
            name: Among those of ``PointState.seen``.
            position: Of all nodes [m], shape (…, node, 3).
        """
        numbers = self.traced(self._present).state.seen[name]
        return evaluate(numbers, self._values(position, numbers)) if numbers else []

    def _recorded(self, name: str, position: Floats, velocity: Floats | None = None) -> Floats:
        """Return numbers of each point in a state, shape (element, point, number)."""
        kind, shape = self._present, (self.nodes.shape[1], self.points)
        kernel, size = record_kernel(self.traced, kind, name, *shape)
        return self._recorded_by(kernel, kind, (self.points, size), position, velocity)

    def _recorded_by(
        self, kernel: GeneratedKernel, kind: SolidKind, shape: tuple[int, ...],
        position: Floats, velocity: Floats | None = None,
    ) -> Floats:  # fmt: skip
        """Return the numbers that the kernel of a kind records, shape (element, *shape)."""
        room = room_for(shape, self.item_count)
        table = self._table(kind, self.nodes, self.slots)
        self._run(kernel, position, room, table, velocity)
        return recorded(room, self.item_count)

    def _run(
        self, kernel: GeneratedKernel, position: Floats, room: Floats, table: PointTable,
        velocity: Floats | None = None,
    ) -> None:  # fmt: skip
        """Run a loop that writes numbers of elements in a state."""
        # Nodes may be numbered among some of all, unlike rows of internal variables.
        if velocity is None:
            velocity = np.zeros(position.shape) if self.recalled is None else self.recalled
        velocity = self.read_rows(velocity, len(position))
        state = (np.ravel(each).astype(float) for each in (position, velocity))
        kernel(0.0, *state, room.reshape(-1), table)
