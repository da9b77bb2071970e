"""Membranes: walls as triangles that follow laws of solids in plane stress at any strain.

A triangle of the volume w has nodes at x_a, drawn at X_a in a plane with two directions. With
F = Σ x_a ⊗ ∂N_a/∂X, of three rows and two columns, C = FᵀF, A = tr C, D = det C, and the
stretch λ of its thickness, it stores

    E = w (μ ψ(g I1, g² I2) + K/2 (J - 1)²),    W_λ = 0,
    I1 = A + λ²,    I2 = D + λ² A,    J = λ √D,    g = J^(-2/3),

where ψ is the law of the solid (``laws.solid``). There is no stress across the triangle: λ
minimises the energy, found by Newton's iteration, so that its change does no work (J. Bonet, R.
D. Wood, J. Mahaney, P. Heywood, Comput. Meth. Appl. Mech. Eng. 190:579, 2000). Forces on nodes
are -w P ∂N_a/∂X with

    P = F S,    S = 2 W_A 1 + 2 W_D cof C.

Fibres in the plane add their energy as in solids (``forces.elements``). Below D = 1/25, which
is a fifth of the area, √D in J is its parabola there: triangles that are pressed into a line
have finite forces, and open again.

A prestressed triangle is drawn stretched by F0 = λ0 1 in its plane, or along an axis a of it by
F0 = λ0 a ⊗ a + λ0^(-1/2) (1 - a ⊗ a), as solids are (``forces.solid_strain``); ∂N_a/∂X
includes F0. The volume w without stress is that of a triangle that has the given thickness as
drawn.

Viscosity is that of a liquid, as in solids, whose rate of strain across the plane is
-ν/(1 - ν) times that of the area, as in small strain of the elastic wall: with the rate Ė of
Green's strain and B = cof C Ė,

    S = 2 η J/D² (B cof C + k tr B cof C),    k = (3 ν² - (1 - 2 ν)²) / (3 (1 - ν)²).

Branches that relax and yielding are in ``forces.membrane_memory``.
"""

from collections.abc import Callable
from typing import NamedTuple, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.core.arrays import cross
from tissuec.core.source import Span
from tissuec.forces import Items, acts_of
from tissuec.forces.element_fields import MaterialField, numbered_laws, young_of
from tissuec.forces.element_limits import ElementLimits, LimitColumns
from tissuec.forces.element_memory import StoredTensors, branch_columns, yield_columns
from tissuec.forces.matrices import without_negative
from tissuec.forces.membrane_limits_kernel import MembraneLimitTable, burden_membranes
from tissuec.forces.membrane_memory import (
    MembraneBranches,
    MembraneYield,
    PlasticPlane,
    RelaxingPlane,
)
from tissuec.forces.membrane_record_kernel import STATE, MembraneTable
from tissuec.forces.membrane_response import MembraneResponse
from tissuec.forces.membrane_strain import MembraneStrain
from tissuec.forces.membranes_kernel import relax_membranes, stretch_membranes
from tissuec.forces.memory import TANGENT_SECONDS, MemoryTangents, tangents_by_differences
from tissuec.forces.solid_strain import SolidFibres
from tissuec.kernels.records import BoundaryConditions
from tissuec.laws.derivatives import DERIVATIVES
from tissuec.laws.solid import SolidLaw
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import springs_between

_SECONDS = 1e-7  # of one evaluation of a triangle
_TENSOR_SECONDS = 2e-8  # and for each tensor that it remembers
_COLUMNS = (
    "nodes", "gradients", "weight", "area", "thickness", "shear", "bulk", "viscosity", "law",
)  # fmt: skip
_PARTS = ("fibres", "limits", "branches", "remembered", "yielding", "plastic")
EDGES = np.array([[0, 1], [1, 2], [2, 0]])  # of a triangle


class MembraneMaterial(NamedTuple):
    """The material of triangles, triangle by triangle.

    Attributes:
        shear, bulk: Initial shear and bulk modulus [Pa], shape (triangle,).
        viscosity: [Pa s], shape (triangle,).
        law: Number of the law, shape (triangle,).
        laws: Members of ``laws.solid.SOLID_LAWS``.
        thickness: As drawn [m], shape (triangle,).
        prestretch: λ0, shape (triangle,).
        axis: Of the prestretch, a vector in space, shape (3,); None in the whole plane.
        fibres: Directions as drawn in space, shape (triangle, family, 3); None without any.
        limits: At which they break; None where nothing may break.
        branches: That relax; None without any.
        yielding: Their yield stresses and flow; None where nothing yields.
    """

    shear: Floats
    bulk: Floats
    viscosity: Floats
    law: Indices
    laws: tuple[SolidLaw, ...]
    thickness: Floats
    prestretch: Floats
    axis: Floats | None = None
    fibres: SolidFibres | None = None
    limits: ElementLimits | None = None
    branches: MembraneBranches | None = None
    yielding: MembraneYield | None = None


class Membranes(MaterialField, frozen=True):
    """Triangles of a wall.

    Attributes:
        gradients: ∂N/∂X by lengths without stress [1/m], shape (triangle, 3, 2).
        weight: Volumes without stress [m³], shape (triangle,).
        area, thickness: As drawn [m²], [m], shape (triangle,).
        shear, bulk: μ and K [Pa], shape (triangle,).
        viscosity: η [Pa s], shape (triangle,).
        law: Number of the law, shape (triangle,).
        fibres: Families of fibres in the plane, whose directions have two components.
        branches: That relax; None without any.
        remembered: Effect of the branches in their present state, where it is known; energies,
            matrices and stresses include it. Otherwise they are those without branches.
        yielding: Their yield stresses and flow; None where nothing yields.
        plastic: Their plastic deformation, where it is known; energies, matrices and stresses
            are those of the elastic rest. Otherwise they are those before any flow.
        is_prestressed: Whether any triangle has stress as drawn.
        span: The entry that asks for the triangles.
    """

    gradients: Floats
    weight: Floats
    area: Floats
    thickness: Floats
    shear: Floats
    bulk: Floats
    viscosity: Floats
    law: Indices
    fibres: SolidFibres
    branches: MembraneBranches | None
    remembered: RelaxingPlane | None
    yielding: MembraneYield | None
    plastic: PlasticPlane | None
    is_prestressed: bool
    span: Span

    @classmethod
    def of(
        cls,
        name: str,
        nodes: Indices,
        position: Floats,
        material: MembraneMaterial,
        ends: NDArray[np.int32],
        first_spring: int,
        span: Span,
    ) -> Self:
        """Return triangles as they are drawn.

        Args:
            name: Of the body.
            nodes: Shape (triangle, 3).
            position: Of all nodes as drawn [m], shape (node, 3).
            material: What they are made of.
            ends: Nodes of the springs of the body, shape (spring, 2).
            first_spring: Number of the first of these.
            span: The entry that asks for them.

        Raises:
            ValueError: A triangle has no area.
        """
        axes, gradients, area = _measured(position[nodes])
        if len(flat := np.flatnonzero(~(area > 0.0))):
            raise ValueError(f"triangle {flat[0]} has no area")
        longer = _prestretch(axes, material.prestretch, material.axis)
        fibres = SolidFibres(np.zeros((len(nodes), 0, 2)), *np.zeros((3, len(nodes))))
        if material.fibres is not None:
            along = np.einsum("tik,tfk->tfi", axes, material.fibres.along)
            along = np.einsum("tij,tfj->tfi", np.linalg.inv(longer), along)
            along = along / np.linalg.norm(along, axis=2)[..., None]
            fibres = replace(material.fibres, along=along)
        law, laws = numbered_laws(material.law, material.laws)
        edges, which = springs_between(ends, nodes[:, EDGES].reshape(-1, 2))
        walls, walled = first_spring + edges, which // len(EDGES)
        if material.limits is not None:
            walls = np.append(walls, material.limits.marks)
            walled = np.append(walled, np.arange(len(nodes)))
        made = cls(
            walls, walled, nodes, name, material.limits, laws,
            gradients @ longer, material.thickness * area, area, material.thickness,
            material.shear, material.bulk, material.viscosity, law, fibres,
            material.branches, None, material.yielding, None,
            bool((material.prestretch != 1.0).any()), span,
        )  # fmt: skip
        drawn = MembraneStrain(made, made.deformations(position))
        return replace(made, weight=made.weight / (np.linalg.det(longer) * drawn.thickness))

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the triangles of {self.name}", "membranes", self, self.span)

    def only(self, items: Indices) -> Self:
        """Return some triangles, by indices of shape (n,), with the walls of all."""
        some = {name: getattr(self, name)[items] for name in _COLUMNS}
        parts = {
            name: part and part.some(items)
            for name, part in ((name, getattr(self, name)) for name in _PARTS)
        }
        return replace(self, **parts, **some)

    def items(self, place: Indices) -> Items:
        """Return the nodes of the triangles."""
        return Items(place[self.nodes].ravel(), 3 * np.arange(self.item_count + 1))

    @property
    def faces(self) -> Indices:
        """Return the triangles themselves, shape (triangle, 1, 3)."""
        return self.nodes[:, None]

    @property
    def bulk_modulus(self) -> Floats:
        """Return K [Pa], shape (triangle,)."""
        return self.bulk

    @property
    def thinning(self) -> Floats:
        """Return -ν/(1 - ν), dimensionless, shape (triangle,).

        It is the relative change of thickness per one of area at small strain.
        """
        return -(self.bulk - 2.0 / 3.0 * self.shear) / (self.bulk + 4.0 / 3.0 * self.shear)

    def deformations(self, position: Floats) -> Floats:
        """Return F, shape (…, triangle, 3, 2).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return np.asarray(position[..., self.nodes, :].swapaxes(-1, -2) @ self.gradients)

    def invariants(self, position: Floats) -> tuple[Floats, Floats]:
        """Return both isochoric invariants, shape (triangle,); see ``MaterialField``."""
        return MembraneStrain(self, self.deformations(position)).invariants

    def stress_shares(self, position: Floats) -> tuple[Floats, Floats]:
        """Return stress times the volumes of nodes, and these; see ``MaterialField``."""
        share = self.node_volumes
        stress = MembraneStrain(self, self.deformations(position)).cauchy()
        return share[..., None, None] * stress[:, None], share

    @property
    def young(self) -> Floats:
        """Return Young's modulus at rest; see ``MaterialField``."""
        return young_of(self.shear, self.bulk_modulus)

    @property
    def fibre_lines(self) -> tuple[Floats, Floats]:
        """Return slopes and volumes along fibres; see ``MaterialField``."""
        slopes = np.einsum("eak,efk->efa", self.gradients, self.fibres.along)
        return slopes, np.repeat(self.weight[:, None], slopes.shape[1], axis=1)

    @property
    def node_volumes(self) -> Floats:
        """Return the drawn volumes of nodes; see ``MaterialField``."""
        return np.repeat(self.weight[:, None] / 3.0, 3, axis=1)

    def plastic_shares(self, velocity: Floats) -> tuple[Floats, Floats]:
        """Return plastic strains times volumes of nodes, and these; see ``MaterialField``."""
        share = self.node_volumes
        if self.yielding is None:
            return np.zeros_like(share), share
        return self.yielding.equivalent(velocity)[:, None] * share, share

    # --- energy and matrix --------------------------------------------------------------------

    def energies(self, position: Floats) -> Floats:
        """Return the energy of each triangle [J], shape (…, triangle).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        found = np.empty((*position.shape[:-2], self.item_count))
        for part, own in self.in_blocks():
            stored = MembraneStrain(own, own.deformations(position)).energy()
            found[..., part] = own.weight * stored
        return found

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each triangle [N/m], shape (triangle, 3, 3, 3, 3).

        Without ``exact``, negative eigenvalues of ∂P/∂F of each triangle count as zero. (J.
        Teran, E. Sifakis, G. Irving, R. Fedkiw, Symp. Computer Animation 2005, p. 181.)
        """
        stiff = MembraneStrain(self, self.deformations(position)).second_derivatives()
        if not exact:
            stiff = without_negative(stiff)
        stiff = self.weight[:, None, None] * stiff
        stiff = stiff.reshape(-1, 3, 2, 3, 2)
        half = np.einsum("txiyj,tbj->txiyb", stiff, self.gradients)
        return np.einsum("txiyb,tai->taxby", half, self.gradients)

    @property
    def is_damped(self) -> bool:
        """Return whether any triangle is viscous."""
        return bool(self.viscosity.any())

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of viscous forces by velocities; see ``ElementField``."""
        strain = MembraneStrain(self, self.deformations(position))
        thick, part = self._thick(strain)
        turned, slopes = strain.f @ strain.cofactors, self.gradients
        # Ė = Σ v_ax (f_xi G_aj + f_xj G_ai)/2, and B = cof C Ė.
        inner = np.einsum("tai,tij,tbj->tab", slopes, strain.cofactors, slopes)
        along = np.einsum("txi,tij,tyj->txy", strain.f, strain.cofactors, strain.f)
        way = np.einsum("txi,tai->tax", turned, slopes)
        values = 0.5 * np.einsum("tab,txy->taxby", inner, along)
        values += 0.5 * np.einsum("tay,tbx->taxby", way, way)
        values += part[:, None, None, None, None] * np.einsum("tax,tby->taxby", way, way)
        values *= (self.weight * thick)[:, None, None, None, None]
        return values

    def _thick(self, strain: MembraneStrain) -> tuple[Floats, Floats]:
        """Return 2 η J/D² [Pa s] and k, shape (triangle,)."""
        thin = self.thinning
        thick = 2.0 * self.viscosity * strain.ratio / strain.square**2
        return thick, thin**2 - (1.0 + thin) ** 2 / 3.0

    # --- bounds -------------------------------------------------------------------------------

    @property
    def rigidity(self) -> Floats:
        """Return moduli times volumes [J], shape (triangle,)."""
        sudden = 0.0 if self.branches is None else self.branches.sudden
        return (self.shear + sudden + self.bulk + self.fibres.modulus) * self.weight

    @property
    def steepest(self) -> Floats:
        """Return the largest gradient of a shape function [1/m], shape (triangle,)."""
        return np.abs(self.gradients).max(axis=(1, 2))

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        tensors = sum(len(each.exists) for each in self.stored_tensors)
        return _SECONDS * self.item_count + _TENSOR_SECONDS * tensors

    @property
    def matrix_seconds(self) -> float:
        """Return an estimate of the time of making their matrix [s]."""
        return super().matrix_seconds + TANGENT_SECONDS * len(self.hidden)

    # --- memory -------------------------------------------------------------------------------

    @property
    def stored_tensors(self) -> tuple[StoredTensors, ...]:
        """Return the tensors of branches, and that of plastic strain."""
        return tuple(each for each in (self.branches, self.yielding) if each is not None)

    @property
    def points(self) -> int:
        """Return 1: strain is the same in the whole triangle."""
        return 1

    @property
    def yields(self) -> NDArray[np.bool_]:
        """Return which triangles yield, shape (triangle,)."""
        return super().yields if self.yielding is None else self.yielding.keeps[0]

    @property
    def loss(self) -> str:
        """Return why energy is not conserved; see ``Effect``."""
        if self.branches is not None:
            return "there are elements that relax"
        return "" if self.yielding is None else "there are elements that yield"

    def memory_tangents(self, position: Floats, velocity: Floats) -> MemoryTangents | None:
        """Return the derivatives of branches and plastic strain; see ``Field``."""
        if not len(self.hidden):
            return None
        stored = [each for each in (self.yielding, self.branches) if each is not None]
        return tangents_by_differences(
            stored, self.response, self.deformations(position)[:, None], velocity,
            self.nodes, self.gradients[:, None], self.weight[:, None],
        )  # fmt: skip

    @property
    def response(self) -> MembraneResponse:
        """Return stress and rates as a function of F and of the internal variables."""

        def recalling(branches: RelaxingPlane | None, plastic: PlasticPlane | None) -> Self:
            return replace(self, remembered=branches, plastic=plastic)

        return MembraneResponse(self.yielding, self.branches, recalling)

    @property
    def relaxed(self) -> Self:
        """Return the triangles without branches, which no longer flow; see ``Effect``."""
        yielding = self.yielding and self.yielding.stopped
        return replace(self, branches=None, remembered=None, yielding=yielding)

    def stored(self, first: int, fastest: float) -> Self:
        """Return the triangles with hidden nodes for their internal variables.

        Args:
            first: Number of the first of these nodes.
            fastest: A bound of the angular frequencies of the net [1/s].
        """
        size, found = np.sqrt(self.area), self
        if self.branches is not None:
            branches = self.branches.stored(3 * first, 1, fastest, size)
            found = replace(found, branches=branches)
            first += len(branches.nodes(1))
        if self.yielding is not None:
            yielding = self.yielding.stored(3 * first, 1, fastest, size)
            found = replace(found, yielding=yielding)
        return found

    def fastest(self, mass: Floats) -> float:
        """Return about the largest angular frequency of the triangles [1/s].

        Args:
            mass: Of all nodes [kg], shape (node,).
        """
        each = self.rigidity[:, None] * (self.gradients**2).sum(axis=2)
        joined = np.bincount(self.nodes.ravel(), each.ravel(), len(mass))
        return float(np.sqrt(2.0 * (joined / mass).max()))

    def recalling(self, velocity: Floats) -> Self:
        """Return the triangles with the present internal variables; see ``Effect``."""
        if not self.remembers:
            return self
        branches, yielding = self.branches, self.yielding
        return replace(
            self,
            remembered=branches and branches.remembered(velocity),
            plastic=yielding and yielding.plastic(velocity),
        )

    def giving(self, position: Floats, velocity: Floats) -> float:
        """Return a bound of the rates at which triangles relax and flow [1/s]."""
        fastest = 0.0
        for _, own in self.in_blocks() if self.remembers else ():
            strain = MembraneStrain(own.recalling(velocity), own.deformations(position))
            relaxing = np.zeros(1)
            if own.branches is not None:
                rate, relaxing = own.branches.fastest(*strain.isochoric, velocity)
                fastest = max(fastest, rate)
            if own.yielding is not None:
                rate = own.yielding.fastest(*strain.invariants, strain.of_laws, relaxing)
                fastest = max(fastest, rate)
        return fastest

    def let_relax(self, velocity: Floats, position: Floats, moved: NDArray[np.bool_]) -> None:
        """Make branches give way for good; see ``Field``."""
        if self.branches is None:
            return
        for part, _ in self.in_blocks():
            items = part[moved[self.nodes[part]].any(axis=1)]
            own = self.only(items).relaxed.recalling(velocity)
            right, _ = MembraneStrain(own, own.deformations(position)).isochoric
            self.branches.keep(velocity, right[:, None], items)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return relax_membranes if self.remembers else stretch_membranes

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> MembraneTable:
        """Return the record of the kernel, which is valid at any position."""
        is_curved = bool(self.law.any())
        addresses = (0,) * len(DERIVATIVES)
        if is_curved:
            from tissuec.compiled.laws import slope_addresses

            addresses = slope_addresses(
                tuple(tuple(each(law) for each in DERIVATIVES) for law in self.laws)
            )
        first, second, first_twice, both, second_twice = addresses
        return MembraneTable(
            nodes=np.ascontiguousarray(place[self.nodes]),
            gradients=np.ascontiguousarray(self.gradients.reshape(-1, 6)),
            weight=self.weight, shear=self.shear, bulk=self.bulk, viscosity=self.viscosity,
            thinning=self.thinning, law=self.law,
            fibres=np.ascontiguousarray(self.fibres.along),
            fibre_stiffness=self.fibres.stiffness,
            fibre_stiffening=self.fibres.stiffening, dispersion=self.fibres.dispersion,
            **branch_columns(self.branches, self.item_count, place),
            **yield_columns(self.yielding, self.item_count, place),
            is_curved=is_curved, is_viscous=self.is_damped,
            by_first=first, by_second=second, by_first_twice=first_twice, by_both=both,
            by_second_twice=second_twice, state=np.zeros(STATE),
        )  # fmt: skip

    @property
    def crack_areas(self) -> Floats:
        """Return t √A [m²], shape (triangle,); see ``forces.element_limits``."""
        return self.thickness * np.sqrt(self.area)

    @property
    def limit_kernel(self) -> Callable[..., None]:
        """Return the scalar loops that set how near triangles are to breaking."""
        return burden_membranes

    def limit_table(self, place: Indices, limits: LimitColumns) -> MembraneLimitTable:
        """Return the record of these loops; see ``MaterialField``."""
        wall = self.relaxed.table(place, acts_of((), 0.0, 0.0), np.zeros((0, 3)))
        return MembraneLimitTable(*limits, wall)


def _prestretch(axes: Floats, stretch: Floats, axis: Floats | None) -> Floats:
    """Return F0 of triangles, shape (triangle, 2, 2).

    Args:
        axes: Two unit vectors in the plane of each, shape (triangle, 2, 3).
        stretch: λ0, shape (triangle,).
        axis: As for ``MembraneMaterial``.
    """
    if axis is None:
        return stretch[:, None, None] * np.eye(2)
    along = axes @ axis
    along = along / np.linalg.norm(along, axis=1)[:, None]
    line = along[:, :, None] * along[:, None, :]
    across = (stretch**-0.5)[:, None, None] * (np.eye(2) - line)
    return stretch[:, None, None] * line + across


def _measured(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """Return two unit vectors in the plane of triangles, ∂N/∂X there, and areas.

    Args:
        corners: Positions of their nodes as drawn [m], shape (triangle, 3, 3).

    Returns:
        Shape (triangle, 2, 3); [1/m], shape (triangle, 3, 2); [m²], shape (triangle,).
    """
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = cross(side, other)
    twice = np.linalg.norm(normal, axis=1)
    with np.errstate(all="ignore"):  # those without an area are refused
        first = side / np.linalg.norm(side, axis=1)[:, None]
        second = cross(normal / twice[:, None], first)
        axes = np.stack([first, second], axis=1)
        flat = np.einsum("tik,tak->tai", axes, np.stack([side, other], axis=1))
        inner = np.linalg.inv(np.where(twice[:, None, None] > 0.0, flat, np.eye(2)))
    inner = inner.swapaxes(1, 2)
    gradients = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
    return axes, gradients, 0.5 * twice
