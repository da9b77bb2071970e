"""Elements that relax and yield, for the reference: their own unknowns and formulas.

The unknowns are the inverses A of the tensors Ci of the inelastic strain of branches and those
of Cp (see ``solids.solid_point``), six numbers for each branch and point. With
B = det(A)^(-1/3) A and the unimodular C', a branch stores μk/2 (tr(C' B) - 3), and

    dA/dt = -(A C' A - tr(C' B)/3 A)/τ - (M A + A Mᵀ),    M = λ dev(S C),

S being the stress 2 ∂W/∂C of laws and branches. The rate of Cp⁻¹ is the last part alone, and
laws use the invariants of C B.

Shared arguments:
    right: C' of all elements, dimensionless, shape (element, point, 3, 3).
    carried: M of all elements [1/s], shape (element, point, 3, 3); None without any flow.
    velocity: Of all nodes [m/s], shape (node, 3).
    given: The unknowns, dimensionless, shape (count,).
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.forces.solids.element_memory import StoredTensors
    from tissuec.forces.solids.elements import SolidElements

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_UPPER = (np.array([0, 1, 2, 1, 0, 0]), np.array([0, 1, 2, 2, 2, 1]))


class KeptTensors:
    """Unknown tensors of the elements of one body.

    Args:
        elements: The elements.
        of: Where they are stored.

    Attributes:
        count: Number of unknowns.
    """

    def __init__(self, elements: "SolidElements", of: "StoredTensors"):
        self._row, self._element = np.nonzero(of.slot >= 0)
        self._rate = of.rate[self._row, self._element][:, None, None]
        self._elements, self._points = elements.item_count, len(elements.shape.weights)
        first = of.slot[self._row, self._element][:, None, None]
        self._place = first + np.arange(6 * self._points).reshape(self._points, 6)
        self.count = self._place.size
        self._size = np.cbrt(elements.volume[self._element])

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns from internal variables."""
        own = np.eye(3) + _full(velocity.ravel()[self._place] / self._rate)
        return _inverse(own)[:, :, *_UPPER].ravel()

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns as velocities."""
        own = _inverse(self._tensors(given)) - np.eye(3)
        velocity.reshape(-1)[self._place] = self._rate * own[:, :, *_UPPER]

    def _tensors(self, given: Floats) -> Floats:
        return _full(given.reshape(-1, self._points, 6))

    def _carrying(self, own: Floats, carried: Floats) -> Floats:
        """Return the part of flow in dA/dt [1/s], shape (tensor, point, 3, 3).

        Args:
            own: A, dimensionless, of that shape.
        """
        half = carried[self._element] @ own
        return -half - half.swapaxes(-1, -2)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions, shape (count,).

        Args:
            place: Error of positions [m].
        """
        return np.repeat(place / self._size, 6 * self._points)


class PlasticElements(KeptTensors):
    """The plastic strain of the elements of one body.

    Args:
        elements: Read for how they yield.
    """

    def __init__(self, elements: "SolidElements"):
        of = elements.yielding
        assert of is not None
        super().__init__(elements, of)
        self._limit, self._viscosity = of.limit[:, None], of.viscosity[:, None]
        self._stiff = elements.shear + (
            0.0 if elements.branches is None else elements.branches.shear.sum(axis=0)
        )

    def unimodular(self, velocity: Floats) -> Floats:
        """Return B of each element, 1 where nothing yields, dimensionless.

        The shape is (element, point, 3, 3).
        """
        found = np.broadcast_to(np.eye(3), (self._elements, self._points, 3, 3)).copy()
        found[self._element] = _unimodular(self._tensors(self.read(velocity)))
        return found

    @np.errstate(all="ignore")  # of steps that are far too large
    def flow(self, turned: Floats) -> Floats:
        """Return M [1/s], shape (element, point, 3, 3).

        Args:
            turned: S C of laws and branches [Pa], shape (element, point, 3, 3).
        """
        part = turned - np.trace(turned, axis1=-2, axis2=-1)[..., None, None] / 3.0 * np.eye(3)
        stress = np.sqrt(np.maximum(1.5 * np.einsum("eqkl,eqlk->eq", part, part), 0.0))
        over = stress - np.minimum(stress, self._limit)
        lengthening = over / self._viscosity
        pace = np.where(over > 0.0, 1.5 * lengthening / np.where(over > 0.0, stress, 1.0), 0.0)
        return pace[..., None, None] * part

    def rates(self, carried: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        own = self._tensors(self.read(velocity))
        return self._carrying(own, carried)[:, :, *_UPPER].ravel()

    @property
    def slowing(self) -> Floats:
        """Return half of the derivatives of the rates of flow [1/s], shape (count,).

        Newton's iteration converges with them whether or not an element flows.
        """
        slow = -1.5 * self._stiff[self._element] / self._viscosity[self._element, 0]
        return np.repeat(slow, 6 * self._points)


class RelaxingElements(KeptTensors):
    """Branches of the elements of one body.

    Args:
        elements: Read for their branches.

    Attributes:
        time: τ of each branch [s], shape (branch,).
    """

    def __init__(self, elements: "SolidElements"):
        of = elements.branches
        assert of is not None
        super().__init__(elements, of)
        self.time: Floats = of.time[self._row, self._element]
        self._shear: Floats = of.shear[self._row, self._element]

    def given_way(self, right: Floats, chosen: Any, velocity: Floats) -> None:
        """Store that the branches of some elements gave way for good.

        Args:
            chosen: Mask of the elements, shape (element,).
        """
        own = self._tensors(self.read(velocity))
        moved = chosen[self._element]
        own[moved] = _inverse(right[self._element[moved]])
        self.write(own[:, :, *_UPPER].ravel(), velocity)

    def weight(self, velocity: Floats) -> Floats:
        """Return Σ μk B of each element [Pa], shape (element, point, 3, 3)."""
        total = np.zeros((self._elements, self._points, 3, 3))
        own = _unimodular(self._tensors(self.read(velocity)))
        np.add.at(total, self._element, self._shear[:, None, None, None] * own)
        return total

    @property
    def sudden(self) -> Floats:
        """Return Σ μk of each element [Pa], shape (element,)."""
        return np.bincount(self._element, self._shear, self._elements).astype(float)

    def energy(self, right: Floats, velocity: Floats) -> Floats:
        """Return the energy per volume [Pa], shape (element, point)."""
        pulled = np.einsum("eqkl,eqkl->eq", right, self.weight(velocity))
        return 0.5 * (pulled - 3.0 * self.sudden[:, None])

    @np.errstate(all="ignore")  # of steps that are far too large
    def _changes(self, right: Floats, velocity: Floats) -> tuple[Floats, Floats]:
        """Return A and dA/dt, shape (branch, point, 3, 3)."""
        own, there = self._tensors(self.read(velocity)), right[self._element]
        third = np.einsum("bqkl,bqkl->bq", there, _unimodular(own)) / 3.0
        change = own @ there @ own - third[..., None, None] * own
        return own, -change / self.time[:, None, None, None]

    def rates(self, right: Floats, velocity: Floats, carried: Floats | None) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        own, change = self._changes(right, velocity)
        if carried is not None:
            change = change + self._carrying(own, carried)
        return change[:, :, *_UPPER].ravel()

    def lost(self, right: Floats, velocity: Floats) -> Floats:
        """Return the power lost per volume [W/m³], shape (element, point).

        It is -μk/2 tr(C' dB/dt).
        """
        own, change = self._changes(right, velocity)
        swelling = np.trace(_inverse(own) @ change, axis1=-2, axis2=-1)
        inner = change - swelling[..., None, None] / 3.0 * own
        inner = inner / np.cbrt(np.linalg.det(own))[..., None, None]
        total = np.zeros((self._elements, self._points))
        power = np.einsum("b,bqkl,bqkl->bq", -0.5 * self._shear, right[self._element], inner)
        np.add.at(total, self._element, power)
        return total

    @property
    def slowing(self) -> Floats:
        """Return about the derivatives of rates by their own unknowns [1/s], shape (count,)."""
        return np.repeat(-1.0 / self.time, 6 * self._points)


def _full(six: Floats) -> Floats:
    """Return symmetric tensors from their six numbers."""
    found = np.empty((*six.shape[:-1], 3, 3))
    found[..., _UPPER[0], _UPPER[1]] = found[..., _UPPER[1], _UPPER[0]] = six
    return found


def _inverse(tensors: Floats) -> Floats:
    """Return inverses by minors; NaN for singular matrices and those with NaN.

    Solvers try steps that are far too large, and take shorter ones if this happens.
    """
    a, b, c = (tensors[..., k, :] for k in range(3))
    with np.errstate(all="ignore"):
        minors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
        return np.asarray(minors / np.linalg.det(tensors)[..., None, None])


def _unimodular(tensors: Floats) -> Floats:
    return tensors / np.cbrt(np.linalg.det(tensors))[..., None, None]
