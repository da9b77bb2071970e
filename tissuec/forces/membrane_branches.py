"""Branches of walls: stress in the plane that relaxes.

A branch is that of a solid (``forces.solid_branches``) in plane stress. Its tensor Ci keeps the
volume 1, and has no shear across the wall: its part P in the plane determines it by three
numbers, as it is 1 / det P across. With C and the stretch λ of the thickness, it stores per
volume

    E = μk/2 (g (tr(C P⁻¹) + λ² det P) - 3),    g = J^(-2/3),

and gives way by

    dP/dt = (g C - T/3 P)/τ,    T = g (tr(C P⁻¹) + λ² det P).

The thickness minimises the energy of the wall with all of its branches, so that the stresses of
the branches and of the law across the wall always balance. The dissipation,

    -∂E/∂P : dP/dt = μk/2τ (tr X² - T²/3),    X = diag(g C P⁻¹, g λ² det P),

is never negative, as X has real eigenvalues with the sum T.

P - 1 is kept in the velocities of hidden nodes, one for each branch of a triangle, times a
``rate``, so that it is stepped, stored and resumed like all other motion.
"""

from typing import NamedTuple, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.forces.membranes_kernel import FLAT
from tissuec.model.network import Floats, Indices

#: Rows and columns of the three numbers of a symmetric tensor in the plane.
ROWS, COLUMNS = np.array([0, 1, 0]), np.array([0, 1, 1])


class RelaxingPlane(NamedTuple):
    """Branches in a fixed state: energy per volume (g (tr(C W) + λ² w) - 3 Σ μk)/2.

    Attributes:
        weight: W = Σ μk P⁻¹ [Pa], shape (…, triangle, 2, 2).
        across: w = Σ μk det P [Pa], shape (…, triangle).
        shear: Σ μk [Pa], shape (triangle,).
    """

    weight: Floats
    across: Floats
    shear: Floats

    def some(self, items: Indices) -> "RelaxingPlane":
        """Return those of some triangles, by indices of shape (n,)."""
        weight, across = self.weight[..., items, :, :], self.across[..., items]
        return RelaxingPlane(weight, across, self.shear[items])


class MembraneBranches(Struct, frozen=True, eq=False):
    """Branches of triangles.

    Attributes:
        shear: μk [Pa], shape (branch, triangle); zero where there is none.
        time: τ [s], shape (branch, triangle); infinite where there is none.
        slot: Place of the first number of P - 1 among the components of all velocities, shape
            (branch, triangle); -1 where there is none.
        rate: What P - 1 is multiplied by there [m/s], shape (branch, triangle).
    """

    shear: Floats
    time: Floats
    slot: Indices
    rate: Floats

    @classmethod
    def new(cls, shear: Floats, time: Floats) -> Self:
        """Return branches without storage.

        Args:
            shear, time: As the attributes [Pa], [s], shape (branch, triangle).
        """
        return cls(shear, time, np.full(shear.shape, -1), np.ones(shear.shape))

    def some(self, items: Indices) -> Self:
        """Return those of some triangles, by indices of shape (n,)."""
        shear, time = self.shear[:, items], self.time[:, items]
        return type(self)(shear, time, self.slot[:, items], self.rate[:, items])

    @property
    def sudden(self) -> Floats:
        """Return the instantaneous shear modulus of all branches [Pa], shape (triangle,)."""
        return self.shear.sum(axis=0)

    @property
    def exists(self) -> Indices:
        """Return triangle and branch of each existing branch, by triangles, shape (n, 2)."""
        return np.argwhere((self.shear > 0.0).T)

    def stored(self, first: int, fastest: float, size: Floats) -> Self:
        """Return the same with storage.

        Args:
            first: Place of the first number among the components of all velocities.
            fastest: A bound of the angular frequencies of the net [1/s].
            size: Of triangles [m], shape (triangle,).
        """
        triangle, branch = self.exists.T
        slot = np.full(self.shear.shape, -1)
        slot[branch, triangle] = first + 3 * np.arange(len(triangle))
        return replace(self, slot=slot, rate=size * np.maximum(1.0 / self.time, fastest))

    @property
    def nodes(self) -> Indices:
        """Return the hidden nodes that keep all P, ascending, shape (node,)."""
        triangle, branch = self.exists.T
        first = self.slot[branch, triangle]
        return first[first >= 0] // 3

    # --- variables ----------------------------------------------------------------------------

    def tensors(self, velocity: Floats) -> Floats:
        """Return P, dimensionless, shape (…, branch, triangle, 2, 2); 1 without storage.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        flat = velocity.reshape(*velocity.shape[:-2], -1)
        place, has = self.slot[..., None] + np.arange(3), (self.slot >= 0)[..., None]
        three = np.where(has, flat[..., np.where(has, place, 0)] / self.rate[..., None], 0.0)
        found = np.empty((*three.shape[:-1], 2, 2))
        found[..., ROWS, COLUMNS] = found[..., COLUMNS, ROWS] = three
        return found + np.eye(2)

    def keep(self, velocity: Floats, tensors: Floats, items: Indices) -> None:
        """Set P of some triangles, in the velocities of all nodes.

        Args:
            velocity: Changed in place [m/s], shape (node, 3).
            tensors: The same of all branches, dimensionless, shape (item, 2, 2).
            items: Indices of the triangles, shape (item,).
        """
        flat, three = velocity.reshape(-1), (tensors - np.eye(2))[..., ROWS, COLUMNS]
        for slot, rate in zip(self.slot[:, items], self.rate[:, items], strict=True):
            has = slot >= 0
            flat[slot[has, None] + np.arange(3)] = (rate[:, None] * three)[has]

    def remembered(self, velocity: Floats) -> RelaxingPlane:
        """Return the effect of the branches in their present state.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        inverse, across = _inverses(self.tensors(velocity))
        weight = (self.shear[..., None, None] * inverse).sum(axis=-4)
        return RelaxingPlane(weight, (self.shear * across).sum(axis=-2), self.sudden)

    def fastest(self, right: Floats, across: Floats, velocity: Floats) -> float:
        """Return the largest rate at which any branch gives way [1/s].

        Args:
            right: g C in the plane, dimensionless, shape (triangle, 2, 2).
            across: g λ², dimensionless, shape (triangle,).
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        inverse, part = _inverses(self.tensors(velocity))
        trace = np.einsum("tkl,btkl->bt", right, inverse) + across * part
        return float(np.where(self.shear > 0.0, trace / (3.0 * self.time), 0.0).max())


def _inverses(tensors: Floats) -> tuple[Floats, Floats]:
    """Return P⁻¹ and det P, which has the lower bound that kernels use."""
    a, b, c = tensors[..., 0, 0], tensors[..., 1, 1], tensors[..., 0, 1]
    square = np.maximum(a * b - c * c, FLAT)
    found = np.empty_like(tensors)
    found[..., 0, 0], found[..., 1, 1] = b / square, a / square
    found[..., 0, 1] = found[..., 1, 0] = -c / square
    return found, square
