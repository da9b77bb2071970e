"""Plates: walls of triangles that resist bending at any Poisson's ratio.

The folds of a triangle at its edges say how it is curved (``matter.plate``). With the folds
θ_i - θ0_i = Δ_i and the weights w_i of hinges (``forces.bending``), a triangle stores

    E = Σ_i K_ii w_i (1 - cos Δ_i) + Σ_i<j K_ij z_i z_j,    z_i = p_i sin Δ_i,
    p_i = w_i (3 - w_i)/2,

which is Δᵀ K Δ/2 for small folds. It has no jump where faces are folded onto each other, lets
go of triangles that collapse, and is never negative, as K is positive, p² ≤ w, and
sin² Δ ≤ 2 (1 - cos Δ). A triangle with the retardation time τ brakes its folds by the moments
-τ C dθ/dt with C_ii = K_ii w_i and C_ij = K_ij p_i p_j cos Δ_i cos Δ_j.
"""

from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.forces import Items
from tissuec.forces.bending import Hinges, hinges_at
from tissuec.forces.element_fields import ElementField
from tissuec.forces.matrices import without_negative
from tissuec.forces.plates_kernel import PlateTable, bend_plates
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import springs_between

_SECONDS = 1.2e-7  # of one evaluation of a triangle
#: Places in a patch of the nodes of the hinge opposite to each corner, shape (3, 4).
HINGES = np.array([[1, 2, 0, 3], [2, 0, 1, 4], [0, 1, 2, 5]])
#: Pairs of places in a patch that springs join: all edges of its triangles.
EDGES = np.array([[0, 1], [1, 2], [2, 0], [1, 3], [2, 3], [2, 4], [0, 4], [0, 5], [1, 5]])
_OF_PATCH = np.zeros((3, 4, 6))
for _h in range(3):
    _OF_PATCH[_h, np.arange(4), HINGES[_h]] = 1.0


class Plates(ElementField, frozen=True):
    """Triangles of a wall that resist bending.

    One loses its stiffness if its patch loses an edge or a triangle.

    Attributes:
        nodes: Patches, see ``matter.plate``, shape (triangle, 6).
        stiffness: K [N m], shape (triangle, 3, 3).
        delay: τ [s], shape (triangle,).
        drawn: θ0 [rad], shape (triangle, 3).
        squares: Of drawn normals of the triangle and its neighbours [m⁴], shape
            (triangle, 3, 2).
        span: The entry that asks for it.
    """

    at_once: ClassVar[int] = 1024
    stiffness: Floats
    delay: Floats
    drawn: Floats
    squares: Floats
    span: Span

    @classmethod
    def of(
        cls,
        name: str,
        nodes: Indices,
        position: Floats,
        stiffness: Floats,
        delay: Floats,
        ends: NDArray[np.int32],
        first_spring: int,
        span: Span,
        marks: Indices | None = None,
    ) -> Self:
        """Return plates that are at rest as they are drawn.

        Args:
            name: Of the body.
            nodes: Patches, shape (triangle, 6).
            position: Of all nodes as drawn [m], shape (node, 3).
            stiffness: K [N m], shape (triangle, 3, 3).
            delay: τ [s], shape (triangle,).
            ends: Nodes of the springs of the body, shape (spring, 2).
            first_spring: Number of the first of these.
            span: The entry that asks for it.
            marks: The springs that mark the triangles of each patch, shape (triangle, n); None
                where these do not break.
        """
        none = np.zeros(0, dtype=np.int64)
        own = nodes[:, HINGES].reshape(-1, 4)
        is_hinge = (nodes[:, 3:] != nodes[:, :3]).ravel()
        drawn, squares = np.zeros(len(own)), np.ones((len(own), 2))
        zero = np.zeros(int(is_hinge.sum()))
        hinges = hinges_at(position, own[is_hinge], zero, zero, none, none)
        drawn[is_hinge], squares[is_hinge] = hinges.drawn, hinges.squares
        edges, which = springs_between(ends, nodes[:, EDGES].reshape(-1, 2))
        walls, walled = first_spring + edges, which // len(EDGES)
        count = len(nodes)
        if marks is not None:
            walls = np.append(walls, marks)
            walled = np.append(walled, np.repeat(np.arange(count), marks.shape[1]))
        return cls(
            walls, walled, name, nodes, stiffness, delay,
            drawn.reshape(count, 3), squares.reshape(count, 3, 2), span,
        )  # fmt: skip

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the bending of {self.name}", "plates", self, self.span)

    def only(self, items: Indices) -> Self:
        """Return some triangles, by indices of shape (n,), with the walls of all."""
        names = ("nodes", "stiffness", "delay", "drawn", "squares")
        return replace(self, **{name: getattr(self, name)[items] for name in names})

    def items(self, place: Indices) -> Items:
        """Return the nodes of the patches, each once."""
        places = np.sort(place[self.nodes], axis=1)
        is_new = np.diff(places, axis=1, prepend=-1) > 0
        return Items(places[is_new], np.concatenate([[0], np.cumsum(is_new.sum(axis=1))]))

    @property
    def is_hinge(self) -> NDArray[np.bool_]:
        """Return which edges have a neighbour, shape (triangle, 3)."""
        return self.nodes[:, 3:] != self.nodes[:, :3]

    # --- folds --------------------------------------------------------------------------------

    @property
    def hinges(self) -> Hinges:
        """Return the hinges of all triangles that have a neighbour, with K_ii."""
        has, none = self.is_hinge.ravel(), np.zeros(0, dtype=np.int64)
        own = np.einsum("tii->ti", self.stiffness).ravel()[has]
        return Hinges(
            none, none, self.nodes[:, HINGES].reshape(-1, 4)[has], own, 0.0 * own,
            self.drawn.ravel()[has], self.squares.reshape(-1, 2)[has],
        )  # fmt: skip

    def _spread_out(self, values: Floats) -> Floats:
        """Return numbers of hinges by triangle and edge, zero where there is no hinge.

        Args:
            values: In any unit, shape (…, hinge, n…) with the hinges on the first axis.
        """
        has = self.is_hinge.ravel()
        found = np.zeros((len(has), *values.shape[1:]))
        found[has] = values
        return found.reshape(self.item_count, 3, *values.shape[1:])

    def folded(self, position: Floats) -> Floats:
        """Return θ - θ0 [rad], shape (triangle, 3); zero where there is no hinge.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return self._spread_out(self.hinges.folded(position))

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        found = np.zeros(position.shape[:-2])
        for state in np.ndindex(found.shape):
            for _, own in self.in_blocks():
                more, weight, _, _ = own._first(position[state])
                z = _share(weight) * np.sin(more)
                stored = np.einsum("ti,tij,tj->t", z, own._beside, z) / 2.0
                stored += (own._own * weight * 2.0 * np.sin(0.5 * more) ** 2).sum(axis=1)
                found[state] += stored.sum()
        return found

    @property
    def _own(self) -> Floats:
        """Return K_ii [N m], shape (triangle, 3)."""
        return np.einsum("tii->ti", self.stiffness)

    @property
    def _beside(self) -> Floats:
        """Return K without its diagonal [N m], shape (triangle, 3, 3)."""
        return self.stiffness * (1.0 - np.eye(3))

    def _first(self, position: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return Δ, w and their derivatives by the nodes of patches.

        Shapes (triangle, 3) and (triangle, 3, 6, 3).
        """
        more, weight, slopes, swelling = self.hinges.first_derivatives(position)
        by_x, of_weight = (
            np.einsum("thpx,hpn->thnx", self._spread_out(each), _OF_PATCH)
            for each in (slopes, swelling)
        )
        return self._spread_out(more), self._spread_out(weight), by_x, of_weight

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each triangle [N/m], shape (triangle, 6, 3, 6, 3).

        Without ``exact``, that of the folds alone, whose negative eigenvalues count as zero.
        """
        return self._exact(position) if exact else self._positive(position)

    def _positive(self, position: Floats) -> Floats:
        """Return the positive part by folds, shape (triangle, 6, 3, 6, 3)."""
        more, weight, slopes, _ = self._first(position)
        inner = without_negative(self._by_folds(more, weight, np.cos(more)))
        return np.einsum("tij,tiax,tjby->taxby", inner, slopes, slopes, optimize=True)

    def _by_folds(self, more: Floats, weight: Floats, kept: Floats) -> Floats:
        """Return K_ii w_i times a number, and K_ij p_i p_j cos Δ_i cos Δ_j, (triangle, 3, 3).

        Args:
            more, weight: Δ and w, shape (triangle, 3).
            kept: The number, shape (triangle, 3).
        """
        turn = _share(weight) * np.cos(more)
        found = self._beside * turn[:, :, None] * turn[:, None, :]
        found[:, np.arange(3), np.arange(3)] = self._own * weight * kept
        return found

    def _exact(self, position: Floats) -> Floats:
        """Return ∂²E/∂x∂x of each triangle, shape (triangle, 6, 3, 6, 3)."""
        more, weight, slopes, swelling = self._first(position)
        sine, cosine = np.sin(more), np.cos(more)
        p, slope = _share(weight), 1.5 - weight
        moment = np.einsum("tij,tj->ti", self._beside, p * sine)
        by_z = (p * cosine)[..., None, None] * slopes
        by_z = by_z + (slope * sine)[..., None, None] * swelling
        found = np.einsum("tij,tiax,tjby->taxby", self._beside, by_z, by_z, optimize=True)
        twice = self._own * weight * cosine - moment * sine * p
        mixed = self._own * sine + moment * cosine * slope
        found += _products(twice, slopes, slopes)
        half = _products(mixed, slopes, swelling)
        found += half + half.transpose(0, 3, 4, 1, 2)
        found -= _products(moment * sine, swelling, swelling)
        bent, grown = map(self._spread_out, self.hinges.second_derivatives(position))
        turning = self._own * weight * sine + moment * cosine * p
        growing = self._own * (1.0 - cosine) + moment * sine * slope
        inner = turning[..., None, None, None, None] * bent
        inner += growing[..., None, None, None, None] * grown
        return found + np.einsum(
            "hpa,thpxqy,hqb->taxby", _OF_PATCH, inner, _OF_PATCH, optimize=True
        )

    @property
    def is_damped(self) -> bool:
        """Return whether any triangle is damped."""
        return bool(self.delay.any())

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of damping forces by velocities; see ``ElementField``."""
        more, weight, slopes, _ = self._first(position)
        inner = self._by_folds(more, weight, np.ones_like(more))
        inner *= self.delay[:, None, None]
        return np.einsum("tij,tiax,tjby->taxby", inner, slopes, slopes, optimize=True)

    # --- bounds -------------------------------------------------------------------------------

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        return self.hinges.spread(time, position)

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return self.hinges.noise(time, position)

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]."""
        return _SECONDS * self.item_count

    # --- for the engine -----------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return bend_plates

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> PlateTable:
        """Return the record of the kernel, which is valid at any position."""
        return PlateTable(
            nodes=np.ascontiguousarray(place[self.nodes]),
            stiffness=np.ascontiguousarray(self.stiffness),
            delay=self.delay,
            cosine=np.cos(self.drawn),
            sine=np.sin(self.drawn),
            upper=np.ascontiguousarray(self.squares[..., 0]),
            lower=np.ascontiguousarray(self.squares[..., 1]),
            room=np.zeros((3, 28)),
        )


def _products(factor: Floats, left: Floats, right: Floats) -> Floats:
    """Return Σ_i f_i a_i b_iᵀ, shape (triangle, 6, 3, 6, 3).

    Args:
        factor: f, shape (triangle, 3).
        left, right: a and b, shape (triangle, 3, 6, 3).
    """
    count = len(factor)
    first = (factor[..., None, None] * left).reshape(count, 3, 18)
    found = first.swapaxes(1, 2) @ right.reshape(count, 3, 18)
    return found.reshape(count, 6, 3, 6, 3)


def _share(weight: Floats) -> Floats:
    """Return p = w (3 - w)/2, shape (triangle, 3)."""
    return 0.5 * weight * (3.0 - weight)
