"""Walls that relax and yield, for the reference: their own unknowns and formulas.

The unknowns are the inverses A of the plane tensors P of the inelastic strain of branches and
those of the plastic strain (see ``surfaces.plane_point``), three numbers for each tensor
of a triangle. Across, the inverse is 1 / det A. With C' = g C and its component across the
wall, c = g C33, a branch stores μk/2 (tr(C' A) + c / det A - 3), and

    dA/dt = -(A C' A - T/3 A)/τ - (M A + A Mᵀ),    T = tr(C' A) + c / det A,

M being the flow in the plane, λ dev(S C). The rate of the plastic strain is the last part
alone.

Shared arguments:
    inside: C' of all triangles, dimensionless, shape (triangle, 2, 2).
    outside: c of all triangles, dimensionless, shape (triangle,).
    carried: M of all triangles [1/s], shape (triangle, 2, 2); None without any flow.
    velocity: Of all nodes [m/s], shape (node, 3).
    given: The unknowns, dimensionless, shape (count,).
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.forces.solids.element_memory import StoredTensors
    from tissuec.forces.surfaces.membranes import Membranes

Floats = NDArray[np.float64]
_UPPER = (np.array([0, 1, 0]), np.array([0, 1, 1]))


class PlaneSum(NamedTuple):
    """Weighted sums of inverses A over the internal variables of a triangle.

    Attributes:
        inside: Σ w A, shape (triangle, 2, 2).
        outside: Σ w / det A, shape (triangle,).
    """

    inside: Floats
    outside: Floats


class WallMemory(NamedTuple):
    """Internal variables of triangles.

    Attributes:
        branches: Sums over branches with their moduli [Pa]; None without any.
        flowed: A of the plastic strain alone, dimensionless; None where nothing yields.
    """

    branches: PlaneSum | None = None
    flowed: PlaneSum | None = None

    @property
    def key(self) -> Floats:
        """Return all numbers in their units, shape (n,)."""
        every = (one for one in self if one is not None)
        parts = [np.zeros(0), *(part.ravel() for one in every for part in one)]
        return np.concatenate(parts)


class KeptPlanes:
    """Unknown plane tensors of the triangles of one wall.

    Args:
        wall: The triangles.
        of: Their storage.

    Attributes:
        count: Number of unknowns.
    """

    def __init__(self, wall: "Membranes", of: "StoredTensors"):
        self._row, self._triangle = np.nonzero(of.slot >= 0)
        self._rate: Floats = of.rate[self._row, self._triangle][:, None]
        self._place = of.slot[self._row, self._triangle][:, None] + np.arange(3)
        self.count, self._triangles = self._place.size, wall.item_count
        self._size = np.sqrt(wall.area[self._triangle])

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns from internal variables."""
        own = np.eye(2) + _full(velocity.ravel()[self._place] / self._rate)
        return _inverse(own)[:, *_UPPER].ravel()

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns as velocities."""
        own = _inverse(_full(given.reshape(-1, 3))) - np.eye(2)
        velocity.reshape(-1)[self._place] = self._rate * own[:, *_UPPER]

    def _carrying(self, own: Floats, carried: Floats) -> Floats:
        """Return the part of flow in dA/dt [1/s], shape (tensor, 2, 2); ``own`` is A."""
        half = carried[self._triangle] @ own
        return -half - half.swapaxes(-1, -2)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions, shape (count,).

        Args:
            place: Error of positions [m].
        """
        return np.repeat(place / self._size, 3)


class PlasticWall(KeptPlanes):
    """The plastic strain of the triangles of one wall.

    Args:
        wall: Read for how they yield.
    """

    def __init__(self, wall: "Membranes"):
        of = wall.yielding
        assert of is not None
        super().__init__(wall, of)
        self._limit, self._viscosity = of.limit, of.viscosity
        self._stiff = wall.shear + (0.0 if wall.branches is None else wall.branches.sudden)

    def inverse(self, velocity: Floats) -> PlaneSum:
        """Return A of each triangle, 1 where nothing yields."""
        inside = np.broadcast_to(np.eye(2), (self._triangles, 2, 2)).copy()
        inside[self._triangle] = _full(self.read(velocity).reshape(-1, 3))
        with np.errstate(all="ignore"):  # of steps that are far too large
            return PlaneSum(inside, 1.0 / np.linalg.det(inside))

    @np.errstate(all="ignore")  # of steps that are far too large
    def flow(self, turned: Floats, across: Floats) -> tuple[Floats, Floats]:
        """Return M in the plane [1/s], shape (triangle, 2, 2), and what flow loses [W/m³].

        Args:
            turned: S C of laws and branches in the plane [Pa], shape (triangle, 2, 2).
            across: S33 C33 of them [Pa], shape (triangle,).
        """
        third = (turned[:, 0, 0] + turned[:, 1, 1] + across) / 3.0
        part, beside = turned - third[:, None, None] * np.eye(2), across - third
        square = np.einsum("ekl,elk->e", part, part) + beside**2
        stress = np.sqrt(np.maximum(1.5 * square, 0.0))
        over = stress - np.minimum(stress, self._limit)
        lengthening = over / self._viscosity
        pace = np.where(over > 0.0, 1.5 * lengthening / np.where(over > 0.0, stress, 1.0), 0.0)
        return pace[:, None, None] * part, stress * lengthening

    def rates(self, carried: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        own = _full(self.read(velocity).reshape(-1, 3))
        return self._carrying(own, carried)[:, *_UPPER].ravel()

    @property
    def slowing(self) -> Floats:
        """Return half of the derivatives of the rates of flow [1/s], shape (count,)."""
        slow = -1.5 * self._stiff[self._triangle] / self._viscosity[self._triangle]
        return np.repeat(slow, 3)


class RelaxingWall(KeptPlanes):
    """Branches of the triangles of one wall.

    Args:
        wall: Read for their branches.
    """

    def __init__(self, wall: "Membranes"):
        of = wall.branches
        assert of is not None
        super().__init__(wall, of)
        self._time: Floats = of.time[self._row, self._triangle]
        self._shear: Floats = of.shear[self._row, self._triangle]

    def given_way(self, inside: Floats, chosen: Any, velocity: Floats) -> None:
        """Relax the branches of some triangles completely.

        Args:
            chosen: Mask of the triangles, shape (triangle,).
        """
        own = _full(self.read(velocity).reshape(-1, 3))
        moved = chosen[self._triangle]
        own[moved] = _inverse(inside[self._triangle[moved]])
        self.write(own[:, *_UPPER].ravel(), velocity)

    def weight(self, velocity: Floats) -> PlaneSum:
        """Return the sums over the branches of each triangle, with their moduli [Pa]."""
        own = _full(self.read(velocity).reshape(-1, 3))
        inside, outside = np.zeros((self._triangles, 2, 2)), np.zeros(self._triangles)
        np.add.at(inside, self._triangle, self._shear[:, None, None] * own)
        with np.errstate(all="ignore"):  # of steps that are far too large
            np.add.at(outside, self._triangle, self._shear / np.linalg.det(own))
        return PlaneSum(inside, outside)

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

    def rates(
        self, inside: Floats, outside: Floats, velocity: Floats, carried: Floats | None
    ) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        own, change = self._changes(inside, outside, velocity)
        if carried is not None:
            change = change + self._carrying(own, carried)
        return change[:, *_UPPER].ravel()

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
