"""Membranes: walls as triangles that follow laws of solids in plane stress at any strain.

A triangle of the volume w has nodes at x_a, drawn at X_a in a plane with two directions. With
F = Σ x_a ⊗ ∂N_a/∂X, of three rows and two columns, C = FᵀF, A = tr C, D = det C, and the
stretch λ of its thickness, it stores

    E = w (μ ψ(g I1, g² I2) + K h(J)),    W_λ = 0,
    I1 = A + λ²,    I2 = D + λ² A,    J = λ √D,    g = J^(-2/3),

where ψ is the law of the solid (``laws.solid``), and K h what a change of volume costs
(``laws.solid.volume``). There is no stress across the triangle: λ minimises the energy, found
by Newton's iteration, so that its change does no work (J. Bonet, R. D. Wood, J. Mahaney, P.
Heywood, Comput. Meth. Appl. Mech. Eng. 190:579, 2000). Forces on nodes are -w P ∂N_a/∂X with

    P = F S,    S = 2 W_A 1 + 2 W_D cof C.

Fibres in the plane add their energy as in solids (``solids.elements``). Below D = 1/25, which
is a fifth of the area, √D in J is its parabola there: triangles that are pressed into a line
have finite forces, and open again.

A prestressed triangle is drawn stretched by F0 = λ0 1 in its plane, or along an axis a of it by
F0 = λ0 a ⊗ a + λ0^(-1/2) (1 - a ⊗ a), as solids are (``solids.solid_strain``); ∂N_a/∂X
includes F0. The volume w without stress is that of a triangle that has the given thickness as
drawn.

Viscosity is that of a liquid, as in solids, whose rate of strain across the plane is
-ν/(1 - ν) times that of the area, as in small strain of the elastic wall: with the rate Ė of
Green's strain and B = cof C Ė,

    S = 2 η J/D² (B cof C + k tr B cof C),    k = (3 ν² - (1 - 2 ν)²) / (3 (1 - ν)²).

Branches that relax and yielding are in ``surfaces.plane_point``.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from tissuec.core.arrays import cross
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.element_fields import numbered_laws
from tissuec.forces.point_fields import PointField
from tissuec.forces.point_kernels import Tracing
from tissuec.forces.solids.element_limits import ElementLimits
from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.forces.solids.solid_strain import SolidFibres
from tissuec.forces.surfaces.plane_point import LEAST_SQUARE, traced_point
from tissuec.laws.solid import SolidLaw
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

_SECONDS = 2.5e-8  # of one evaluation of a triangle
_TENSOR_SECONDS = 4e-9  # and for each tensor that it remembers
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
    branches: Branches | None = None
    yielding: ElementYield | None = None


class Membranes(PointField, frozen=True):
    """Triangles of a wall.

    Attributes:
        gradients: ∂N/∂X by lengths without stress [1/m], shape (triangle, 3, 2).
        weight: Volumes without stress [m³], shape (triangle,).
        area, thickness: As drawn [m²], [m], shape (triangle,).
        bulk: K [Pa], shape (triangle,).
        prestretch: F0, shape (triangle, 2, 2).
        span: The entry that asks for the triangles.
    """

    directions: ClassVar[int] = 2
    columns: ClassVar[tuple[str, ...]] = (
        *PointField.columns, "gradients", "weight", "area", "thickness", "bulk", "prestretch",
    )  # fmt: skip
    traced: ClassVar[Tracing] = staticmethod(traced_point)
    gradients: Floats
    weight: Floats
    area: Floats
    thickness: Floats
    bulk: Floats
    prestretch: Floats
    span: Span

    @classmethod
    def of(
        cls,
        name: str,
        nodes: Indices,
        position: Floats,
        material: MembraneMaterial,
        first: int,
        span: Span,
    ) -> Self:
        """Return triangles as they are drawn.

        Args:
            name: Of the body.
            nodes: Shape (triangle, 3).
            position: Of all nodes as drawn [m], shape (node, 3).
            material: What they are made of.
            first: The first of them as an entity of the network.
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
        every, none = np.arange(len(nodes)), np.zeros((len(nodes), 0))
        made = cls(
            first + every, every, nodes, name, material.limits, laws, material.shear,
            material.viscosity, law, fibres, material.branches, material.yielding, None,
            none, none, gradients @ longer, material.thickness * area, area,
            material.thickness, material.bulk, longer, span,
        )  # fmt: skip
        thinner = made.thinner(position)
        return replace(made, weight=made.weight / (np.linalg.det(longer) * thinner))

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the triangles of {self.name}", "membranes", self, self.span)

    @property
    def edges(self) -> Indices:
        """Return the nodes of the edges of each triangle, shape (triangle, 3, 2)."""
        return self.nodes[:, EDGES]

    @property
    def faces(self) -> Indices:
        """Return the triangles themselves, shape (triangle, 1, 3)."""
        return self.nodes[:, None]

    @property
    def bulk_modulus(self) -> Floats:
        """Return K [Pa], shape (triangle,)."""
        return self.bulk

    @property
    def is_prestressed(self) -> bool:
        """Return whether any triangle has stress as drawn."""
        return bool((self.prestretch != np.eye(2)).any())

    @property
    def cell_shape(self) -> str:
        """Return the name of their shape in ``cut_cells.roots.DIVISIONS``."""
        return "triangle"

    @property
    def volume(self) -> Floats:
        """Return volumes as drawn [m³], shape (triangle,)."""
        return self.thickness * self.area

    @property
    def with_stretches(self) -> Self:
        """Return the triangles with ``stretches``; see ``PointField``."""
        drawn = self.volume
        flat = np.column_stack([self.prestretch.reshape(-1, 4), self.weight / drawn])
        gradients = self.gradients @ np.linalg.inv(self.prestretch)
        return replace(self, gradients=gradients, weight=drawn, stretches=flat)

    @property
    def thinning(self) -> Floats:
        """Return -ν/(1 - ν), dimensionless, shape (triangle,).

        It is the relative change of thickness per one of area at small strain.
        """
        return -(self.bulk - 2.0 / 3.0 * self.shear) / (self.bulk + 4.0 / 3.0 * self.shear)

    @property
    def measures(self) -> tuple[Floats, Floats, Indices]:
        """Return ∂N/∂X and volumes of the only point; see ``PointField``."""
        every = np.arange(self.item_count)
        return self.gradients[:, None], self.weight[:, None], every

    @property
    def sizes(self) -> Floats:
        """Return the sizes of triangles as drawn [m], shape (triangle,)."""
        return np.sqrt(self.area)

    def volumetric(self) -> dict[str, Floats]:
        """Return the modulus of volume; see ``PointField``."""
        return {"local": self.bulk}

    def _with_volumetric(self, numbers: Mapping[str, Floats]) -> dict[str, Any]:
        return {"bulk": numbers["local"]}

    def thinner(self, position: Floats) -> Floats:
        """Return the stretch λ of the thickness, shape (…, triangle).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return self.seen("thickness", position)[0][..., 0]

    def stresses(self, position: Floats) -> Floats:
        """Return the stress at points; see ``PointField``."""
        f = self.deformations(position)
        right = f.swapaxes(-1, -2) @ f
        # The ratio of areas has a lower bound.
        area = np.sqrt(np.maximum(np.linalg.det(right), LEAST_SQUARE))
        volume = area * self.thinner(position)[:, None]
        return (self.piola(position) @ f.swapaxes(-1, -2)) / volume[..., None, None]

    @property
    def shares(self) -> Floats:
        """Return the share of each node in the only point; see ``PointField``."""
        return np.repeat(self.weight[:, None, None] / 3.0, 3, axis=2)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        tensors = sum(len(each.exists) for each in self.stored_tensors)
        return self._bare_seconds + _TENSOR_SECONDS * tensors

    @property
    def _bare_seconds(self) -> float:
        """Return ``seconds`` without what points remember; see ``PointField``."""
        return _SECONDS * self.item_count

    @property
    def crack_areas(self) -> Floats:
        """Return t √A [m²], shape (triangle,); see ``solids.element_limits``."""
        return self.thickness * np.sqrt(self.area)


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
