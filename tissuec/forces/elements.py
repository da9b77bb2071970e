"""Solid elements: finite elements that follow laws of solids at any strain.

An element has nodes at x_a, drawn at X_a, and points of quadrature of the volume w (see
``geometry.elements``). With F = Σ x_a ⊗ ∂N_a/∂X and J = det F at each point, it stores

    E = Σ w (μ ψ(g I1, g² I2) + K0/2 (J - 1)²) + (K - K0) V/2 (M - 1)²,    M = Σ w J / V,

where g = J^(-2/3), I1 = tr FᵀF, I2 = |cof F|², and ψ is the law of the solid
(``laws.solid``). The volumetric term acts on the mean of an element, so that nearly
incompressible elements do not lock (J. C. Simo, R. L. Taylor, K. S. Pister, Comput. Meth. Appl.
Mech. Eng. 51:177, 1985). A mean alone would leave bending of tetrahedra without resistance, and
that of hexahedra, whose gradients deviate less from their mean than those of their shape
functions (``geometry.elements``), with too little. K0 is the smaller of K and 2 μ in
tetrahedra, and of K and 3/8 μ in hexahedra; it is 0 in wedges. Below J = 1/5, g is its
parabola there: elements that are turned inside out have an energy and push back.

The forces on nodes are -Σ w P ∂N_a/∂X with

    P = s F + t cof F - 2 μ g² ψ2 F FᵀF,    s = 2 μ (g ψ1 + g² ψ2 I1),
    t = μ g' (ψ1 I1 + 2 g ψ2 I2) + (K - K0)(M - 1) + K0 (J - 1),

ψ1 and ψ2 being the derivatives of ψ, and g' = dg/dJ. Each family of fibres that is stretched
along a, a unit vector as drawn, adds

    E = Σ w k1/2k2 (exp(k2 e²) - 1),    e = κ (g I1 - 3) + (1 - 3 κ) (|F a|² - 1) > 0,

κ being the dispersion, from 0 where all fibres are parallel to 1/3 where they have no direction
(T. C. Gasser, R. W. Ogden, G. A. Holzapfel, J. R. Soc. Interface 3:15, 2006; |F a| includes the
change of volume: D. R. Nolan et al., J. Mech. Behav. Biomed. Mater. 39:48, 2014). Viscosity is
that of a liquid under the stress 2 η D, D being the rate of strain without its trace:

    P = 2 η/J' dev sym(Ḟ cof Fᵀ) cof F,    J' = max(J, 1/5).

In elements with prestretch F0 (``forces.solid_strain``), F is (Σ x_a ⊗ ∂N_a/∂X) F0, and P
acts on nodes by (∂N_a/∂X) F0; so F0 is part of the gradients that are kept. Branches that relax
and yielding are in ``forces.solid_memory``.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.autodiff.evaluation import evaluate
from tissuec.compiled.generated import GeneratedKernel
from tissuec.compiled.loops.points import (
    MatrixTable,
    PointTable,
    force_loop,
    matrix_loop,
    record_loop,
    recorded,
    room_for,
)
from tissuec.core.source import Span
from tissuec.forces import Items
from tissuec.forces.element_fields import MaterialField, numbered_laws, young_of
from tissuec.forces.element_limits import ElementLimits, LimitColumns
from tissuec.forces.element_limits_kernel import LimitTable, burden_elements
from tissuec.forces.element_memory import COLUMNS, ROWS, SIX, StoredTensors
from tissuec.forces.elements_kernel import STATE, ElementTable
from tissuec.forces.matrices import BlockPattern, without_negative
from tissuec.forces.memory import TANGENT_SECONDS, MemoryTangents
from tissuec.forces.solid_memory import NEVER, SolidBranches, SolidYield
from tissuec.forces.solid_point import LEAST, SolidKind, traced_point
from tissuec.forces.solid_strain import EnergySlopes, Prestretch, SolidFibres
from tissuec.geometry.elements import ElementShape, Measures
from tissuec.kernels.records import BoundaryConditions
from tissuec.laws.derivatives import DERIVATIVES, at_invariants, by_first, by_second
from tissuec.laws.solid import SolidLaw
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import springs_between

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

_ALIKE = 1e-12  # relative difference of gradients that is rounding
_SECONDS = 1.1e-8  # of one evaluation of a point, for each of its nodes
_MAKING = 85.0  # of the matrix, over one of them without tensors
_BRANCH_SECONDS = 85e-9  # and for each branch, or where it yields
_COLUMNS = ("nodes", "row", "shear", "bulk", "local", "viscosity", "law")
_PARTS = ("fibres", "prestretch", "limits", "branches", "yielding")


class SolidMaterial(NamedTuple):
    """The material of elements, element by element.

    Attributes:
        shear, bulk: Initial shear and bulk modulus [Pa], shape (element,).
        viscosity: [Pa s], shape (element,).
        law: Number of the law, shape (element,).
        laws: Members of ``laws.solid.SOLID_LAWS``.
        fibres: As drawn; None without any.
        prestretch, branches, yielding: None without any.
        limits: At which they break; None where nothing may break.
    """

    shear: Floats
    bulk: Floats
    viscosity: Floats
    law: Indices
    laws: tuple[SolidLaw, ...]
    fibres: SolidFibres | None = None
    prestretch: Prestretch | None = None
    limits: ElementLimits | None = None
    branches: SolidBranches | None = None
    yielding: SolidYield | None = None

    def some(self, items: Indices) -> "SolidMaterial":
        """Return the material of some elements, by indices of shape (n,)."""
        fibres, prestretch = self.fibres, self.prestretch
        limits, branches, yielding = self.limits, self.branches, self.yielding
        return SolidMaterial(
            self.shear[items], self.bulk[items], self.viscosity[items], self.law[items],
            self.laws, fibres and fibres.some(items), prestretch and prestretch.some(items),
            limits and limits.some(items), branches and branches.some(items),
            yielding and yielding.some(items),
        )  # fmt: skip


class SolidElements(MaterialField, frozen=True):
    """Solid elements of one shape.

    Attributes:
        shape: Of all elements.
        drawn: Gradients and volumes as drawn, one row for all elements that are alike;
            gradients by places without stress.
        row: Of each element in ``drawn``, shape (element,).
        shear, bulk, local: μ, K - K0 and K0 [Pa], shape (element,).
        viscosity: η [Pa s], shape (element,).
        law: Number of the law, shape (element,).
        fibres: Families of fibres, without stress; there may be none.
        prestretch: None without any.
        branches: That relax; None without any.
        yielding: Their yield stresses and flow; None where nothing yields.
        recalled: Velocities of all nodes, of which those of hidden ones tell what elements
            remember, shape (…, node, 3); energies, matrices and stresses include it. Without,
            they are those without branches and before any flow.
        span: The entry that asks for the elements.
    """

    at_once: ClassVar[int] = 2048
    shape: ElementShape
    drawn: Measures
    row: Indices
    shear: Floats
    bulk: Floats
    local: Floats
    viscosity: Floats
    law: Indices
    fibres: SolidFibres
    prestretch: Prestretch | None
    branches: SolidBranches | None
    yielding: SolidYield | None
    recalled: Floats | None
    span: Span

    @classmethod
    def of(
        cls,
        name: str,
        shape: ElementShape,
        nodes: Indices,
        position: Floats,
        material: SolidMaterial,
        ends: NDArray[np.int32],
        first_spring: int,
        span: Span,
    ) -> Self:
        """Return elements as they are drawn.

        Args:
            name: Of the body.
            shape: Of all of them.
            nodes: Shape (element, node).
            position: Of all nodes as drawn [m], shape (node, 3).
            material: What they are made of.
            ends: Nodes of the springs of the body, shape (spring, 2).
            first_spring: Number of the first of these.
            span: The entry that asks for them.

        Raises:
            ValueError: An element is flat or inside out as drawn.
        """
        drawn, row = _measured(shape, position[nodes])
        fibres, prestretch = material.fibres or SolidFibres.none(len(nodes)), None
        if material.prestretch is not None and (material.prestretch.stretch != 1.0).any():
            prestretch = material.prestretch
            drawn, row = prestretch.measures(drawn, row)
            fibres = replace(fibres, along=prestretch.unstressed(fibres.along))
        branches = material.branches
        if branches is not None and not branches.keeps.any():
            branches = None
        yielding = material.yielding
        if yielding is not None and not yielding.keeps.any():
            yielding = None
        is_flat = np.any(drawn.volume <= 0.0, axis=1)
        flat = np.flatnonzero(np.asarray(is_flat)[row])
        if len(flat):
            raise ValueError(f"{shape.name} {flat[0]} is flat or inside out")
        local = np.minimum(shape.local * material.shear, material.bulk)
        pairs = nodes[:, shape.edges].reshape(-1, 2)
        edges, which = springs_between(ends, pairs)
        walls, walled = first_spring + edges, which // len(shape.edges)
        if material.limits is not None:
            walls = np.append(walls, material.limits.marks)
            walled = np.append(walled, np.arange(len(nodes)))
        law, laws = numbered_laws(material.law, material.laws)
        return cls(
            walls, walled, nodes, name, material.limits, laws, shape, drawn, row,
            material.shear, material.bulk - local, local, material.viscosity, law,
            fibres, prestretch, branches, yielding, None, span,
        )  # fmt: skip

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(
            f"the {self.shape.name} elements of {self.name}", "elements", self, self.span
        )

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,), with the walls of all."""
        some = {name: getattr(self, name)[items] for name in _COLUMNS}
        parts = {
            name: part and part.some(items)
            for name, part in ((name, getattr(self, name)) for name in _PARTS)
        }
        return replace(self, **parts, **some)

    def items(self, place: Indices) -> Items:
        """Return the nodes of the elements."""
        count = self.nodes.shape[1]
        return Items(place[self.nodes].ravel(), count * np.arange(self.item_count + 1))

    @property
    def faces(self) -> Indices:
        """Return the triangles of the surface of each element, shape (element, triangle, 3)."""
        return self.nodes[:, self.shape.triangles]

    @property
    def volume(self) -> Floats:
        """Return the volumes as drawn [m³], shape (element,)."""
        return self.drawn.volume.sum(axis=1)[self.row]

    def whole_volume(self, position: Floats) -> Floats:
        """Return the present volume of all elements together [m³], shape (…).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        found = np.zeros(position.shape[:-2])
        for _, own in self.in_blocks():
            found += own.shape.volumes(position[..., own.nodes, :]).sum(axis=-1)
        return found

    @property
    def is_prestressed(self) -> bool:
        """Return whether any element has stress as drawn."""
        return self.prestretch is not None

    @property
    def bulk_modulus(self) -> Floats:
        """Return K [Pa], shape (element,)."""
        return self.bulk + self.local

    def deformations(self, position: Floats) -> Floats:
        """Return F, with prestretch, at all points, shape (…, element, point, 3, 3).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        places = position[..., self.nodes, :].swapaxes(-1, -2)[..., None, :, :]
        return np.asarray(places @ self.drawn.gradients[self.row])

    def invariants(self, position: Floats) -> tuple[Floats, Floats]:
        """Return both isochoric invariants, shape (element, point); see ``MaterialField``."""
        first, second = self._seen("invariants", position)
        return first, second

    def _seen(self, name: str, position: Floats) -> list[Floats]:
        """Return numbers that points have beside energies, shape (element, point) each."""
        numbers = traced_point(self._present).state.seen[name]
        return evaluate(numbers, self._values(position)) if numbers else []

    def stress_shares(self, position: Floats) -> tuple[Floats, Floats]:
        """Return stress times the volumes of nodes, and these; see ``MaterialField``."""
        piola = self._recorded("stress", position).reshape(-1, self.points, 3, 3)
        f = self.deformations(position)
        volume = np.maximum(np.linalg.det(f), LEAST)[..., None, None]
        share = self._shares
        stress = piola @ f.swapaxes(-1, -2) / volume
        return np.einsum("eqa,eqxy->eaxy", share, stress), share.sum(axis=1)

    def plastic_shares(self, velocity: Floats) -> tuple[Floats, Floats]:
        """Return plastic strains times volumes of nodes, and these; see ``MaterialField``."""
        volume = self.node_volumes
        if self.yielding is None:
            return np.zeros_like(volume), volume
        strain = self.yielding.equivalent(velocity, self.points)
        return np.einsum("eqa,eq->ea", self._shares, strain), volume

    @property
    def young(self) -> Floats:
        """Return Young's modulus at rest; see ``MaterialField``."""
        return young_of(self.shear, self.bulk_modulus)

    @property
    def fibre_lines(self) -> tuple[Floats, Floats]:
        """Return slopes and volumes along fibres; see ``MaterialField``."""
        steep, weight = self.drawn.gradients[self.row], self.drawn.volume[self.row]
        slopes = np.einsum("eqak,efk->eqfa", steep, self.fibres.along)
        count = self.fibres.along.shape[1]
        shape = (self.item_count, -1, self.shape.nodes)
        return slopes.reshape(shape), np.repeat(weight, count, axis=1)

    @property
    def node_volumes(self) -> Floats:
        """Return the drawn volumes of nodes; see ``MaterialField``."""
        return self._shares.sum(axis=1)

    @property
    def _shares(self) -> Floats:
        """Return the share of each node in each point [m³], shape (element, point, node)."""
        return np.asarray(self.drawn.volume[self.row][..., None] * self.shape.lumped)

    # --- energy and matrix --------------------------------------------------------------------

    def energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], shape (…, element).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        found = np.empty((*position.shape[:-2], self.item_count))
        for part, own in self.in_blocks():
            point, values = traced_point(own._present), own._values(position)
            weight = own.drawn.volume[own.row]
            stored, pooled = evaluate([point.state.energy, point.state.pooled], values)
            volume = weight.sum(axis=-1)
            values["mean"] = ((weight * pooled).sum(axis=-1) / volume)[..., None]
            of_mean = evaluate([point.of_mean], values)[0][..., 0]
            found[..., part] = (weight * stored).sum(axis=-1) + volume * of_mean
        return found

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size); see ``Effect``."""
        free = np.flatnonzero((number[self.nodes] >= 0).any(axis=1))
        if not exact or not len(free):
            return super().matrix(time, position, number, size, exact=exact)
        own = self if len(free) == self.item_count else self.only(free)
        pattern = BlockPattern.of(number[own.nodes], size)
        room, table = pattern.room, own._table(own._present, own.nodes, own._slots)
        kernel = _matrix_kernel(own._present, own.shape.nodes, own.points)
        own._run(kernel, position, room, MatrixTable(*table, pattern.places.reshape(-1)))
        return pattern.matrix(room)

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each element [N/m], shape (element, node, 3, node, 3).

        Without ``exact``, negative eigenvalues of ∂P/∂F at each point count as zero. (J. Teran,
        E. Sifakis, G. Irving, R. Fedkiw, Symp. Computer Animation 2005, p. 181.)
        """
        stiff = _whole(self._recorded("moduli", position))
        if not exact:
            stiff = without_negative(stiff)
        weight, slopes = self.drawn.volume[self.row], self.drawn.gradients[self.row]
        pooling = self._recorded("pooling", position).reshape(-1, self.points, 3, 3)
        swell = slopes @ pooling.swapaxes(-1, -2)
        swell = np.einsum("eq,eqax->eax", weight, swell)
        push = (self.bulk / weight.sum(axis=-1))[:, None, None] * swell
        return self._between_nodes(stiff) + np.einsum("eax,eby->eaxby", push, swell)

    def _between_nodes(self, moduli: Floats) -> Floats:
        """Return Σ w ∂N/∂X A ∂N/∂X of each element, shape (element, node, 3, node, 3).

        Args:
            moduli: A at the points, in any unit, shape (element, point, 9, 9).
        """
        weight, slopes = self.drawn.volume[self.row], self.drawn.gradients[self.row]
        elements, points, count, _ = slopes.shape
        # By component and node instead of component and direction: first of one end, then of
        # the other.
        moduli = (weight[..., None, None] * moduli).reshape(elements, points, 3, 3, 9)
        half = slopes[:, :, None] @ moduli
        half = half.reshape(elements, points, 9 * count, 3) @ slopes.swapaxes(-1, -2)
        values = half.sum(axis=1).reshape(elements, 3, count, 3, count)
        return values.transpose(0, 2, 1, 4, 3)

    @property
    def is_damped(self) -> bool:
        """Return whether any element is viscous."""
        return bool(self.viscosity.any())

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of viscous forces by velocities; see ``ElementField``."""
        return self._between_nodes(_whole(self._recorded("viscous_moduli", position)))

    # --- bounds -------------------------------------------------------------------------------

    @property
    def rigidity(self) -> Floats:
        """Return moduli times volumes [J], shape (element,)."""
        sudden = 0.0 if self.branches is None else self.branches.sudden
        every = self.shear + sudden + self.bulk + self.local + self.fibres.modulus
        return every * self.volume

    @property
    def steepest(self) -> Floats:
        """Return the largest gradient of a shape function [1/m], shape (element,)."""
        return np.abs(self.drawn.gradients).max(axis=(1, 2, 3))[self.row]

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        tensors = sum(len(each.exists) for each in self.stored_tensors)
        own = _SECONDS * self.item_count * self.shape.nodes
        return self.points * (own + _BRANCH_SECONDS * tensors)

    @property
    def matrix_seconds(self) -> float:
        """Return an estimate of the time of making their matrix [s]."""
        bare = replace(self, branches=None, yielding=None).seconds
        return _MAKING * bare + TANGENT_SECONDS * len(self.hidden)

    # --- memory -------------------------------------------------------------------------------

    @property
    def stored_tensors(self) -> tuple[StoredTensors, ...]:
        """Return the tensors of branches, and that of plastic strain."""
        return tuple(each for each in (self.branches, self.yielding) if each is not None)

    @property
    def yields(self) -> NDArray[np.bool_]:
        """Return which elements yield, shape (element,)."""
        return super().yields if self.yielding is None else self.yielding.keeps[0]

    @property
    def loss(self) -> str:
        """Return why energy is not conserved; see ``Effect``."""
        if self.branches is not None:
            return "there are elements that relax"
        return "" if self.yielding is None else "there are elements that yield"

    @property
    def relaxed(self) -> Self:
        """Return the elements without branches, which no longer flow; see ``Effect``."""
        yielding = self.yielding and self.yielding.stopped
        return replace(self, branches=None, yielding=yielding)

    def stored(self, first: int, fastest: float) -> Self:
        """Return the elements with hidden nodes for their internal variables.

        Args:
            first: Number of the first of these nodes.
            fastest: A bound of the angular frequencies of the net [1/s].
        """
        size, found = np.cbrt(self.volume), self
        if self.branches is not None:
            branches = self.branches.stored(3 * first, self.points, fastest, size)
            found = replace(found, branches=branches)
            first += len(branches.nodes(self.points))
        if self.yielding is not None:
            yielding = self.yielding.stored(3 * first, self.points, fastest, size)
            found = replace(found, yielding=yielding)
        return found

    def fastest(self, mass: Floats) -> float:
        """Return about the largest angular frequency of the elements [1/s].

        Args:
            mass: Of all nodes [kg], shape (node,).
        """
        steep = self.drawn.volume[..., None] * (self.drawn.gradients**2).sum(axis=-1)
        each = (self.rigidity / self.volume)[:, None] * steep.sum(axis=1)[self.row]
        joined = np.bincount(self.nodes.ravel(), each.ravel(), len(mass))
        return float(np.sqrt(2.0 * (joined / mass).max()))

    def recalling(self, velocity: Floats) -> Self:
        """Return the elements with the present internal variables; see ``Effect``."""
        return replace(self, recalled=velocity) if self.remembers else self

    def giving(self, position: Floats, velocity: Floats) -> float:
        """Return a bound of the rates at which elements relax and flow [1/s]; see ``Field``."""
        fastest = 0.0
        for _, own in self.recalling(velocity).in_blocks() if self.remembers else ():
            held, relaxing = own._seen("held", position), np.zeros(1)
            if (branches := own.branches) is not None:
                rates = np.array(held) * branches.pace[..., None] / 3.0
                fastest = max(fastest, float(rates.max()))
                relaxing = (branches.shear[..., None] * held).sum(axis=0)
            if own.yielding is not None:
                i1, i2 = own.invariants(position)
                slopes = EnergySlopes(*(own.shear[:, None] * own._slopes(i1, i2)))
                fastest = max(fastest, own.yielding.fastest(i1, i2, slopes, relaxing))
        return fastest

    def memory_tangents(self, position: Floats, velocity: Floats) -> MemoryTangents | None:
        """Return the derivatives of branches and plastic strain, by points; see ``Field``."""
        if not self.remembers:
            return None
        stored, points = self._stored, self.points
        flat = self.recalling(velocity)._recorded("tangents", position)
        six = SIX * sum(len(each.slot) for each in stored)
        by_tensors = flat[..., : six * (9 + six)].reshape(-1, points, six, 9 + six)
        by_strain = flat[..., six * (9 + six) :].reshape(-1, points, 3, 3, six)
        has = self._slots >= 0
        rate = np.where(has, np.concatenate([each.rate for each in stored]), 0.0)
        # Variables have the unit of velocities; those that do not exist take no part.
        to_own = np.repeat(rate.T, SIX, axis=1)[:, None]
        from_own = np.divide(1.0, to_own, where=to_own > 0.0, out=np.zeros_like(to_own))
        steep, weight = self.drawn.gradients[self.row], self.drawn.volume[self.row]
        pull = (from_own[..., None] * by_tensors[..., :9]).reshape(-1, points, six, 3, 3)
        giving = from_own[..., None] * by_tensors[..., 9:] * to_own[..., None, :]
        by_position = np.einsum(
            "eqxkv,eqak->eqvax", by_strain * to_own[:, :, None, None], steep
        )
        push = -np.einsum("eq,eqvxk,eqak->eqaxv", weight, pull, steep)
        places = np.concatenate([each.places(points) for each in stored])
        slots = np.moveaxis(np.where(has[..., None, None], places, -1), 0, 2)
        return MemoryTangents(
            slots=slots.reshape(-1, six),
            nodes=np.repeat(self.nodes, points, axis=0),
            giving=-giving.swapaxes(-1, -2).reshape(-1, six, six),
            by_position=by_position.reshape(-1, six, *by_position.shape[3:]),
            pull=push.reshape(-1, *push.shape[2:]),
        )

    def let_relax(self, velocity: Floats, position: Floats, moved: NDArray[np.bool_]) -> None:
        """Make branches give way for good; see ``Field``."""
        if self.branches is None:
            return
        for part, _ in self.in_blocks():
            items = part[moved[self.nodes[part]].any(axis=1)]
            six = np.stack(self.only(items)._seen("isochoric", position), axis=-1)
            self.branches.keep(velocity, _symmetric(six), items)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> GeneratedKernel:
        """Return the loop that adds forces, rates and powers."""
        return _force_kernel(self._kind, self.shape.nodes, self.points)

    @property
    def _kind(self) -> SolidKind:
        """Return what the points have."""
        laws = tuple(self.laws[int(k)] for k in np.unique(self.law).tolist())
        branches = 0 if self.branches is None else len(self.branches.slot)
        families = self.fibres.along.shape[1]
        return SolidKind(
            laws or self.laws[:1], families, branches, self.yielding is not None, self.is_damped
        )

    @property
    def _present(self) -> SolidKind:
        """Return what the points have that energies and matrices are of."""
        kind = self._kind
        if self.recalled is None:
            kind = kind._replace(branches=0, is_yielding=False)
        return kind

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> PointTable:
        """Return the record of the kernel, which is valid at any position."""
        kind, slots = self._kind, self._slots
        moved = np.where(slots >= 0, 3 * place[np.maximum(slots, 0) // 3], -1)
        return self._table(kind, place[self.nodes], moved)

    def _table(self, kind: SolidKind, nodes: Indices, slots: Indices) -> PointTable:
        used, row = np.unique(self.row, return_inverse=True)
        rows = [each.T for each in self._columns(kind).values()]
        return PointTable.of(
            nodes, np.concatenate(rows), row.reshape(-1), self.drawn.gradients[used],
            self.drawn.volume[used], slots[: kind.tensors],
        )  # fmt: skip

    @property
    def _slots(self) -> Indices:
        """Return where tensors are kept, shape (tensor, element); see ``StoredTensors``."""
        none = np.zeros((0, self.item_count), dtype=np.int64)
        return np.concatenate([none, *(each.slot for each in self._stored)])

    @property
    def _stored(self) -> list[StoredTensors]:
        """Return what a point remembers: plastic strain first, and then branches."""
        return [each for each in (self.yielding, self.branches) if each is not None]

    def _columns(self, kind: SolidKind) -> dict[str, Floats]:
        """Return the numbers of elements, shape (element, number) each."""
        found = {"shear": self.shear, "bulk": self.bulk, "local": self.local}
        if len(kind.laws) > 1:
            found["law"] = np.unique(self.law, return_inverse=True)[1].astype(float)
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
            found["yield_pace"] = 1.0 / self.yielding.viscosity
        if kind.tensors:
            rate = np.concatenate([each.rate for each in self._stored])
            inverse = np.where(self._slots >= 0, 1.0 / rate, 0.0)
            found |= {"rate": rate.T, "inverse_rate": inverse.T}
        shapes = {name: max(1, each[:1].size) for name, each in found.items()}
        return {name: np.reshape(each, (-1, shapes[name])) for name, each in found.items()}

    def _values(self, position: Floats) -> dict[str, Floats]:
        """Return all inputs of a point, by name, shape (…, element, point)."""
        kind, f = self._present, self.deformations(position)
        values = {f"f.{k}": f[..., k // 3, k % 3] for k in range(9)}
        for name, each in self._columns(kind).items():
            values |= {f"p.{name}.{k}": each[:, k, None] for k in range(each.shape[1])}
        if kind.tensors:
            assert self.recalled is not None
            parts = [each.told(self.recalled, self.points) for each in self._stored]
            every = np.concatenate(parts, axis=-4)
            for t, k in np.ndindex(kind.tensors, SIX):
                values[f"t.{t}.{k}"] = every[..., t, :, :, k]
        return values

    def _recorded(self, name: str, position: Floats) -> Floats:
        """Return numbers of each point in a state, shape (element, point, number)."""
        kind, count = self._present, self.item_count
        kernel, size = _record_kernel(kind, name, self.shape.nodes, self.points)
        room = room_for(size, self.points, count)
        self._run(kernel, position, room, self._table(self._present, self.nodes, self._slots))
        return recorded(room, count)

    def _run(
        self, kernel: GeneratedKernel, position: Floats, room: Floats, table: NamedTuple
    ) -> None:
        """Run a loop that writes numbers of elements in a state."""
        # Nodes may be numbered among some of all, unlike the hidden ones.
        velocity = np.zeros(position.shape) if self.recalled is None else self.recalled
        state = (np.ravel(each).astype(float) for each in (position, velocity))
        kernel(0.0, *state, room.reshape(-1), table)

    @property
    def crack_areas(self) -> Floats:
        """Return V^(2/3) [m²], shape (element,); see ``forces.element_limits``."""
        return np.asarray(self.volume ** (2.0 / 3.0))

    @property
    def limit_kernel(self) -> Callable[..., None]:
        """Return the scalar loops that set how near elements are to breaking."""
        return burden_elements

    def _limit_columns(self, place: Indices) -> ElementTable:
        """Return the elements as the loops of limits read them."""
        points, count = self.points, self.shape.nodes
        used, row = np.unique(self.row, return_inverse=True)
        gradients = self.drawn.gradients[used].reshape(len(used), points, 3 * count)
        is_curved = bool(self.law.any())
        first, second = (0, 0) if not is_curved else _addresses(self.laws)
        return ElementTable(
            nodes=np.ascontiguousarray(place[self.nodes]),
            row=row.astype(np.int64),
            gradients=np.ascontiguousarray(gradients),
            weight=np.ascontiguousarray(self.drawn.volume[used]),
            shear=self.shear, bulk=self.bulk, local=self.local,
            law=self.law,
            fibres=np.ascontiguousarray(self.fibres.along),
            fibre_stiffness=self.fibres.stiffness,
            fibre_stiffening=self.fibres.stiffening, dispersion=self.fibres.dispersion,
            is_curved=is_curved, by_first=first, by_second=second,
            points=np.zeros((points, STATE)), own=np.zeros((3, 3 * count)),
        )  # fmt: skip

    def limit_table(self, place: Indices, limits: LimitColumns) -> LimitTable:
        """Return the record of these loops; see ``MaterialField``."""
        solid = self._limit_columns(place)
        weight = solid.weight[:, :, None]
        mean = (weight * solid.gradients).sum(axis=1) / weight.sum(axis=1)
        return LimitTable(*limits, solid, np.ascontiguousarray(mean), np.zeros(STATE))

    # --- parts --------------------------------------------------------------------------------

    @property
    def points(self) -> int:
        """Return the number of points of an element."""
        return len(self.shape.weights)

    def _slopes(self, i1: Floats, i2: Floats) -> Floats:
        """Return derivatives of laws at points, shape (derivative, element, point).

        Args:
            i1, i2: Isochoric invariants there, dimensionless.
        """
        return at_invariants(self.laws, self.law, DERIVATIVES, i1, i2)


def _whole(halves: Floats) -> Floats:
    """Return symmetric matrices of nine rows from their lower halves, shape (…, 9, 9)."""
    rows, columns = np.tril_indices(9)
    found = np.empty((*halves.shape[:-1], 9, 9))
    found[..., rows, columns] = found[..., columns, rows] = halves
    return found


def _symmetric(six: Floats) -> Floats:
    """Return symmetric tensors from their six numbers, shape (…, 3, 3)."""
    found = np.empty((*six.shape[:-1], 3, 3))
    found[..., ROWS, COLUMNS] = found[..., COLUMNS, ROWS] = six
    return found


@cache
def _matrix_kernel(kind: SolidKind, nodes: int, points: int) -> GeneratedKernel:
    point = traced_point(kind)
    return GeneratedKernel(
        "elements_matrices", lambda own: matrix_loop(own, point, nodes, points)
    )


@cache
def _record_kernel(
    kind: SolidKind, name: str, nodes: int, points: int
) -> tuple[GeneratedKernel, int]:
    """Return what records a list of numbers of traced points, and how many these are."""
    point = traced_point(kind)
    outputs = getattr(point, name)
    return GeneratedKernel(
        f"elements_{name}", lambda own: record_loop(own, point, outputs, nodes, points)
    ), len(outputs)


@cache
def _force_kernel(kind: SolidKind, nodes: int, points: int) -> GeneratedKernel:
    return GeneratedKernel(
        "elements_forces", lambda name: force_loop(name, traced_point(kind), nodes, points)
    )


def _addresses(laws: Sequence[SolidLaw]) -> tuple[int, int]:
    """Return where the compiled slopes of laws by the first and second invariant are."""
    from tissuec.compiled.laws import slope_addresses

    first, second = slope_addresses(tuple((by_first(law), by_second(law)) for law in laws))
    return first, second


def _measured(shape: ElementShape, corners: Floats) -> tuple[Measures, Indices]:
    """Return the measures of elements, and the row of each: a single one if all are alike.

    Args:
        shape: Of all of them.
        corners: Positions of their nodes as drawn [m], shape (element, node, 3).
    """
    if not len(corners):
        return Measures.of(shape, corners), np.zeros(0, dtype=np.int64)
    own = corners - corners[:, :1]
    if np.abs(own - own[0]).max() <= _ALIKE * max(float(np.abs(corners).max()), 1e-300):
        return Measures.of(shape, corners[:1]), np.zeros(len(corners), dtype=np.int64)
    return Measures.of(shape, corners), np.arange(len(corners))
