"""Solid elements: finite elements that follow laws of solids at any strain.

An element has nodes at x_a, drawn at X_a, and points of quadrature of the volume w (see
``geometry.elements``). With F = Σ x_a ⊗ ∂N_a/∂X and J = det F at each point, it stores

    E = Σ w (μ ψ(g I1, g² I2) + K0 h(J)) + (K - K0) V h(M),    M = Σ w J / V,

where g = J^(-2/3), I1 = tr FᵀF, I2 = |cof F|², ψ is the law of the solid (``laws.solid``), and
K h what a change of volume costs (``laws.solid.volume``). This acts on the mean of an element,
so that nearly incompressible elements do not lock (J. C. Simo, R. L. Taylor, K. S. Pister,
Comput. Meth. Appl. Mech. Eng. 51:177, 1985). A mean alone would leave bending of tetrahedra
without resistance, so K0 is the smaller of K and 2 μ in tetrahedra. Points of hexahedra and
wedges are strained by ``solids.bent_cell``. Below J = 1/5, g and h are their parabolas
there, and the invariants are enlarged (``solids.solid_point``): elements that are turned inside
out have an energy and push back.

Forces on nodes are -∂E/∂x_a. Each family of fibres that is stretched along a, a unit vector as
drawn, adds

    E = Σ w k1/2k2 (exp(k2 e²) - 1),    e = κ (g I1 - 3) + (1 - 3 κ) (|F a|² - 1) > 0,

κ being the dispersion, from 0 where all fibres are parallel to 1/3 where they have no direction
(T. C. Gasser, R. W. Ogden, G. A. Holzapfel, J. R. Soc. Interface 3:15, 2006; |F a| includes the
change of volume: D. R. Nolan et al., J. Mech. Behav. Biomed. Mater. 39:48, 2014). Viscosity is
that of a liquid under the stress 2 η D, D being the rate of strain without its trace:

    P = 2 η/J' dev sym(Ḟ cof Fᵀ) cof F,    J' = max(J, 1/5).

In elements with prestretch F0 (``solids.solid_strain``), F is (Σ x_a ⊗ ∂N_a/∂X) F0, and P
acts on nodes by (∂N_a/∂X) F0; so F0 is part of the gradients that are kept. Branches that relax
and yielding are in ``solids.solid_point``.
"""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.points import TracedPoint
from tissuec.autodiff.tensors import PLACES
from tissuec.core.arrays import are_alike
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.element_fields import numbered_laws
from tissuec.forces.point_fields import PointField
from tissuec.forces.point_kernels import Tracing
from tissuec.forces.solids.element_limits import ElementLimits
from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.forces.solids.solid_point import traced_point
from tissuec.forces.solids.solid_strain import Prestretch, SolidFibres
from tissuec.geometry.elements import ElementShape, Measures
from tissuec.laws.solid import SolidLaw
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

_SECONDS = 4.5e-9  # of one evaluation of a point, for each of its nodes
_TENSOR_SECONDS = 6e-8  # and for each branch, or where it yields


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
    branches: Branches | None = None
    yielding: ElementYield | None = None

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


class SolidElements(PointField, frozen=True):
    """Solid elements of one shape.

    Attributes:
        shape: Of all elements.
        drawn: Gradients and volumes as drawn, one row for all elements that are alike;
            gradients by places without stress.
        row: Of each element in ``drawn``, shape (element,).
        bulk, local: K - K0 and K0 [Pa], shape (element,).
        prestretch: None without any.
        span: The entry that asks for the elements.
    """

    at_once: ClassVar[int] = 512
    columns: ClassVar[tuple[str, ...]] = (*PointField.columns, "row", "bulk", "local")
    parts: ClassVar[tuple[str, ...]] = (*PointField.parts, "prestretch")
    traced: ClassVar[Tracing] = staticmethod(traced_point)
    shape: ElementShape
    drawn: Measures
    row: Indices
    bulk: Floats
    local: Floats
    prestretch: Prestretch | None
    span: Span

    @property
    def drawn_fibres(self) -> Floats:
        """Return directions of families of fibres as drawn, shape (element, family, 3).

        They are unit vectors, or 0 where fibres have no stiffness.
        """
        along = self.fibres.along
        if self.prestretch is not None:
            along = np.einsum("exy,efy->efx", self.prestretch.deformation, along)
            along = along / np.linalg.norm(along, axis=2)[..., None]
        return np.where(self.fibres.stiffness[:, None, None] > 0.0, along, 0.0)

    @classmethod
    def of(
        cls,
        name: str,
        shape: ElementShape,
        nodes: Indices,
        position: Floats,
        material: SolidMaterial,
        first: int,
        span: Span,
    ) -> Self:
        """Return elements as they are drawn.

        Args:
            name: Of the body.
            shape: Of all of them.
            nodes: Shape (element, node).
            position: Of all nodes as drawn [m], shape (node, 3).
            material: What they are made of.
            first: The first of them as an entity of the network.
            span: The entry that asks for them.

        Raises:
            ValueError: An element is flat or inside out as drawn.
        """
        drawn, row = _measured(shape, position[nodes])
        fibres, prestretch = material.fibres or SolidFibres.none(len(nodes)), None
        if material.prestretch is not None and (material.prestretch.stretch != 1.0).any():
            prestretch = material.prestretch
            drawn, row = cls._stretched(prestretch, drawn, row)
            fibres = replace(fibres, along=prestretch.unstressed(fibres.along))
        branches, yielding = (
            each if each is not None and each.keeps.any() else None
            for each in (material.branches, material.yielding)
        )
        is_flat = np.any(drawn.volume <= 0.0, axis=1)
        flat = np.flatnonzero(np.asarray(is_flat)[row])
        if len(flat):
            raise ValueError(f"{shape.name} {flat[0]} is flat or inside out")
        local = np.minimum(shape.local * material.shear, material.bulk)
        limits = material.limits
        if limits is not None and limits.parting.any():
            size = np.cbrt(drawn.volume.sum(axis=1)[row])
            limits = limits.softening(material.shear, material.bulk, size)
        every = np.arange(len(nodes))
        law, laws = numbered_laws(material.law, material.laws)
        attributes = {
            "walls": first + every, "walled": every, "nodes": nodes, "name": name,
            "limits": limits, "laws": laws, "shear": material.shear,
            "viscosity": material.viscosity, "law": law, "fibres": fibres,
            "branches": branches, "yielding": yielding, "recalled": None,
            "constants": np.zeros((len(nodes), 0)), "shape": shape, "drawn": drawn, "row": row,
            "bulk": material.bulk - local, "local": local, "prestretch": prestretch,
            "span": span,
        }  # fmt: skip
        return cls._with(attributes, position[nodes])

    @staticmethod
    def _stretched(
        prestretch: Prestretch, drawn: Measures, row: Indices
    ) -> tuple[Measures, Indices]:
        """Return the measures of elements, with gradients by places without stress."""
        return prestretch.measures(drawn, row)

    @classmethod
    def _with(cls, attributes: Mapping[str, Any], corners: Floats) -> Self:
        """Return elements with what all shapes have.

        Args:
            attributes: By their names.
            corners: Nodes as drawn [m], shape (element, node, 3).
        """
        return cls(**attributes, stretches=np.zeros((len(corners), 0)))

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(
            f"the {self.shape.name} elements of {self.name}", "elements", self, self.span
        )

    @property
    def edges(self) -> Indices:
        """Return the nodes of the edges of each element, shape (element, edge, 2)."""
        return self.nodes[:, self.shape.edges]

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
        # State by state: the order of sums in an array depends on its shape.
        states = position.reshape(-1, *position.shape[-2:])
        found = np.zeros(len(states))
        for _, own in self.in_blocks():
            found += [own.shape.volumes(state[own.nodes]).sum() for state in states]
        return found.reshape(position.shape[:-2])

    @property
    def measures(self) -> tuple[Floats, Floats, Indices]:
        """Return ∂N/∂X and volumes of points, and rows; see ``PointField``."""
        return self.drawn.gradients, self.drawn.volume, self.row

    @property
    def cell_shape(self) -> str:
        """Return the name of their shape."""
        return self.shape.name

    @property
    def sizes(self) -> Floats:
        """Return the sizes of elements as drawn [m], shape (element,)."""
        return np.cbrt(self.volume)

    def volumetric(self) -> dict[str, Floats]:
        """Return the moduli of volume; see ``PointField``."""
        return {"bulk": self.bulk, "local": self.local}

    def _with_volumetric(self, numbers: Mapping[str, Floats]) -> dict[str, Any]:
        return {"bulk": numbers["bulk"], "local": numbers["local"]}

    @property
    def with_stretches(self) -> Self:
        """Return the elements with ``stretches``; see ``PointField``."""
        stretch = np.broadcast_to(np.eye(3), (self.item_count, 3, 3))
        if self.prestretch is not None:
            stretch = self.prestretch.deformation
        gradients = self.steepness @ np.linalg.inv(stretch)[:, None]
        drawn = Measures(gradients, self.weights)
        every, flat = np.arange(self.item_count), stretch.reshape(-1, 9).copy()
        return replace(self, drawn=drawn, row=every, stretches=flat)

    @property
    def is_prestressed(self) -> bool:
        """Return whether any element has stress as drawn."""
        return self.prestretch is not None

    @property
    def bulk_modulus(self) -> Floats:
        """Return K [Pa], shape (element,)."""
        return self.bulk + self.local

    def stresses(self, position: Floats) -> Floats:
        """Return the stress at points; see ``PointField``."""
        half = self._recorded("cauchy", position)
        stress = np.empty((*half.shape[:2], 3, 3))
        for k, (i, j) in enumerate(PLACES[3]):
            stress[..., i, j] = stress[..., j, i] = half[..., k]
        return stress

    @property
    def shares(self) -> Floats:
        """Return the share of each node in each point; see ``PointField``."""
        return np.asarray(self.drawn.volume[self.row][..., None] * self.shape.lumped)

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each element; see ``PointField``."""
        of_points = super().element_matrices(position, exact=exact)
        if not self.traced(self._present).is_pooled:
            return of_points
        return of_points + self._volumetric(position, exact=exact)

    def _volumetric(self, position: Floats, *, exact: bool) -> Floats:
        """Return the part of the matrices that changes of the pressure have [N/m]."""
        weight, functions = self.weights, self._functions.swapaxes(1, 2)
        pooling = self._recorded("pooling", position).reshape(-1, self.points, 3, 3)
        swell = weight[..., None, None] * (self.steepness @ pooling.swapaxes(-1, -2))
        flat = swell.reshape(*swell.shape[:2], 3 * swell.shape[2])
        rise = functions @ flat / weight.sum(axis=1)[:, None, None]
        point = self.traced(self._present)
        values = self._values(position, [point.pooled, point.bend_of_mean])
        (pooled,) = evaluate([point.pooled], values)
        values["mean"] = self._projected(pooled)
        (bend,) = evaluate([point.bend_of_mean], values)
        bend = bend if exact else np.maximum(bend, 0.0)
        between = (functions * (weight * bend)[:, None]) @ functions.swapaxes(1, 2)
        found = rise.swapaxes(1, 2) @ (between @ rise)
        count = self.nodes.shape[1]
        return found.reshape(-1, count, 3, count, 3)

    # --- means --------------------------------------------------------------------------------

    @property
    def _functions(self) -> Floats:
        """Return φ_k at points, on which the volume is projected: 1, which leaves its mean.

        The shape is (element, point, function).
        """
        return np.ones((*self.weights.shape, 1))

    def _projected(self, numbers: Floats) -> Floats:
        """Return projections of numbers of points, of the same shape (…, element, point)."""
        functions, weight = self._functions, self.weights
        share = weight / weight.sum(axis=-1, keepdims=True)
        moments = np.einsum("eqk,...eq->...ek", functions, share * numbers)
        return np.einsum("eqk,...ek->...eq", functions, moments)

    def _alone(
        self, point: TracedPoint, pooled: Floats, values: dict[str, Floats]
    ) -> Floats | float:  # fmt: skip
        """Return the energies of volumes [J]; see ``PointField``."""
        if not point.is_pooled:
            return 0.0
        values["mean"] = self._projected(pooled)
        return (self.weights * evaluate([point.of_mean], values)[0]).sum(axis=-1)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        tensors = sum(len(each.exists) for each in self.stored_tensors)
        return self.points * _TENSOR_SECONDS * tensors + self._bare_seconds

    @property
    def _bare_seconds(self) -> float:
        """Return ``seconds`` without what points remember; see ``PointField``."""
        return _SECONDS * self.item_count * self.shape.nodes * self.points

    @property
    def crack_areas(self) -> Floats:
        """Return V^(2/3) [m²], shape (element,); see ``solids.element_limits``."""
        return np.asarray(self.volume ** (2.0 / 3.0))


def _measured(shape: ElementShape, corners: Floats) -> tuple[Measures, Indices]:
    """Return the measures of elements, and the row of each: a single one if all are alike.

    Args:
        shape: Of all of them.
        corners: Positions of their nodes as drawn [m], shape (element, node, 3).
    """
    if not len(corners):
        return Measures.of(shape, corners), np.zeros(0, dtype=np.int64)
    if are_alike(corners):
        return Measures.of(shape, corners[:1]), np.zeros(len(corners), dtype=np.int64)
    return Measures.of(shape, corners), np.arange(len(corners))
