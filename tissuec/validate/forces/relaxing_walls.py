"""Walls that relax, for the reference: their own unknowns and formulas.

The unknowns are the inverses A of the plane tensors P of the inelastic strain of branches (see
``forces.membrane_branches``), three numbers for each branch of a triangle. Across, the inverse
is 1 / det A. With C' = g C and its component across the wall, c = g C33, a branch stores
μk/2 (tr(C' A) + c / det A - 3), and

    dA/dt = -(A C' A - T/3 A)/τ,    T = tr(C' A) + c / det A.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.forces.membranes import Membranes

Floats = NDArray[np.float64]
_UPPER = (np.array([0, 1, 0]), np.array([0, 1, 1]))


class Kept(NamedTuple):
    """The present state of branches.

    Attributes:
        inside: Σ μk A [Pa], shape (triangle, 2, 2).
        outside: Σ μk / det A [Pa], shape (triangle,).
    """

    inside: Floats
    outside: Floats


class RelaxingWall:
    """Branches of the triangles of one wall.

    Args:
        wall: Read for their branches.

    Attributes:
        count: Number of unknowns.

    Shared arguments:
        inside: C' of all triangles, dimensionless, shape (triangle, 2, 2).
        outside: c of all triangles, dimensionless, shape (triangle,).
        velocity: Of all nodes [m/s], shape (node, 3).
        given: The unknowns, dimensionless, shape (count,).
    """

    def __init__(self, wall: "Membranes"):
        of = wall.branches
        assert of is not None
        row, self._triangle = np.nonzero(of.slot >= 0)
        self._time: Floats = of.time[row, self._triangle]
        self._shear: Floats = of.shear[row, self._triangle]
        self._rate: Floats = of.rate[row, self._triangle][:, None]
        self._place = of.slot[row, self._triangle][:, None] + np.arange(3)
        self.count, self._triangles = self._place.size, wall.item_count
        self._size = np.sqrt(wall.area[self._triangle])

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns from the velocities of hidden nodes."""
        own = np.eye(2) + _full(velocity.ravel()[self._place] / self._rate)
        return _inverse(own)[:, *_UPPER].ravel()

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns as velocities."""
        own = _inverse(_full(given.reshape(-1, 3))) - np.eye(2)
        velocity.reshape(-1)[self._place] = self._rate * own[:, *_UPPER]

    def given_way(self, inside: Floats, chosen: Any, velocity: Floats) -> None:
        """Relax the branches of some triangles completely.

        Args:
            chosen: Mask of the triangles, shape (triangle,).
        """
        own = _full(self.read(velocity).reshape(-1, 3))
        moved = chosen[self._triangle]
        own[moved] = _inverse(inside[self._triangle[moved]])
        self.write(own[:, *_UPPER].ravel(), velocity)

    def kept(self, velocity: Floats) -> Kept:
        """Return the present state of the branches."""
        own = _full(self.read(velocity).reshape(-1, 3))
        inside, outside = np.zeros((self._triangles, 2, 2)), np.zeros(self._triangles)
        np.add.at(inside, self._triangle, self._shear[:, None, None] * own)
        with np.errstate(all="ignore"):  # of steps that are far too large
            np.add.at(outside, self._triangle, self._shear / np.linalg.det(own))
        return Kept(inside, outside)

    @property
    def sudden(self) -> Floats:
        """Return Σ μk of each triangle [Pa], shape (triangle,)."""
        return np.bincount(self._triangle, self._shear, self._triangles).astype(float)

    @np.errstate(all="ignore")
    def _changes(
        self, inside: Floats, outside: Floats, velocity: Floats
    ) -> tuple[Floats, Floats]:
        """Return A and dA/dt, shape (branch, 2, 2)."""
        own = _full(self.read(velocity).reshape(-1, 3))
        there, across = inside[self._triangle], outside[self._triangle]
        total = np.einsum("bkl,bkl->b", there, own) + across / np.linalg.det(own)
        change = own @ there @ own - total[:, None, None] / 3.0 * own
        return own, -change / self._time[:, None, None]

    def rates(self, inside: Floats, outside: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        return self._changes(inside, outside, velocity)[1][:, *_UPPER].ravel()

    def lost(self, inside: Floats, outside: Floats, velocity: Floats) -> Floats:
        """Return the power lost per volume [W/m³], shape (triangle,).

        It is -μk/2 (tr(C' dA/dt) + c d(1 / det A)/dt).
        """
        own, change = self._changes(inside, outside, velocity)
        there, across = inside[self._triangle], outside[self._triangle]
        swelling = np.einsum("bkl,blk->b", np.linalg.inv(own), change)
        each = np.einsum("bkl,bkl->b", there, change) - across * swelling / np.linalg.det(own)
        power = np.bincount(self._triangle, -0.5 * self._shear * each, self._triangles)
        return power.astype(float, copy=False)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions, shape (count,).

        Args:
            place: Error of positions [m].
        """
        return np.repeat(place / self._size, 3)

    @property
    def slowing(self) -> Floats:
        """Return about the derivatives of rates by their own unknowns [1/s], shape (count,)."""
        return np.repeat(-1.0 / self._time, 3)


def _full(three: Floats) -> Floats:
    """Return symmetric tensors from their three numbers."""
    found = np.empty((*three.shape[:-1], 2, 2))
    found[..., _UPPER[0], _UPPER[1]] = found[..., _UPPER[1], _UPPER[0]] = three
    return found


def _inverse(tensors: Floats) -> Floats:
    """Return inverses; not finite for matrices that are singular or not finite."""
    turned = np.trace(tensors, axis1=-2, axis2=-1)[..., None, None] * np.eye(2) - tensors
    with np.errstate(all="ignore"):
        return np.asarray(turned / np.linalg.det(tensors)[..., None, None])
