"""The bending of walls of triangles, by the moments of the folds at their edges.

A tip at the distance h from the edge, on a triangle with the unit normal n, is pushed by
M n / h. The edge bears the opposite, shared so that no moment is left across it. A triangle of
the area A counts as (1 + ε) A² / (A² + ε A0²), A0 being its drawn area, and stores less as it
collapses, which pulls at its corners too.

A triangle whose folds differ by Δ from the drawn ones stores Δᵀ K Δ/2 while these are small.
Beyond, K_ii Δ²/2 is K_ii (1 - cos Δ) as in a hinge, and Δ_i Δ_j is sin Δ_i sin Δ_j; a hinge
that counts w counts w (3 - w)/2 in the second.
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.arrays import cross
from tissuec.validate.forces import ForceFormula, assembled

if TYPE_CHECKING:
    from tissuec.forces.surfaces.plates import Plates

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
PART = 1e-2  # ε
STEP = 1e-30  # of complex steps, by which forces are differentiated


def turned_hinges(corners: Any, drawn: Floats, squares: Floats) -> tuple[Any, Any, Any, Any]:
    """Return by how much hinges are folded more than drawn [rad], and how much they count.

    And the slopes of both by the corners [1/m].

    Args:
        corners: Of each hinge [m], real or complex, shape (hinge, 4, 3).
        drawn: Drawn folds [rad], shape (hinge,).
        squares: Of twice the drawn areas [m⁴], shape (hinge, 2).
    """
    foot, along = corners[:, 0], corners[:, 1] - corners[:, 0]
    length = np.sqrt(_dot(along, along))
    axis = along / length[:, None]
    normals: list[Any] = []
    slopes = np.zeros_like(corners)
    counts, growing = np.ones_like(length), np.zeros_like(corners)
    for tip, sign, square in ((2, 1.0, squares[:, 0]), (3, -1.0, squares[:, 1])):
        reach = corners[:, tip] - foot
        part = _dot(reach, axis)
        away = reach - part[:, None] * axis
        height = np.sqrt(_dot(away, away))
        normal = sign * cross(axis, away) / height[:, None]
        normals.append(normal)
        lift, share = normal / height[:, None], (part / length)[:, None]
        slopes[:, tip] += lift
        slopes[:, 1] -= share * lift
        slopes[:, 0] -= (1.0 - share) * lift
        double = length * height
        whole = double**2 + PART * square
        counts = counts * (1.0 + PART) * double**2 / whole
        # d ln((1 + ε) a²/(a² + ε a0²)) = 2 ε a0² / (a (a² + ε a0²)) da
        rate = (2.0 * PART * square / (double * whole))[:, None]
        upwards = sign * normal
        growing[:, tip] += rate * cross(upwards, along)
        growing[:, 1] += rate * cross(reach, upwards)
        growing[:, 0] -= rate * cross(reach - along, upwards)
    upper, lower = normals
    sine: Any = _dot(cross(lower, upper), axis)
    cosine: Any = _dot(upper, lower)
    fold = np.arctan2(sine.real, cosine.real) - drawn
    # d atan2(s, c) = c ds - s dc, for s² + c² = 1
    turned = fold + 1j * (cosine.real * sine.imag - sine.real * cosine.imag)
    return turned, counts, slopes, counts[:, None, None] * growing


def _dot(one: Any, other: Any) -> Any:
    return np.einsum("hk,hk->h", one, other)


class PlateBending(ForceFormula):
    """The bending of one wall as a field of forces.

    Args:
        plates: Read for their nodes, drawn folds and areas, stiffness and delay.
        stiffness: K [N m], shape (triangle, 3, 3); that of the plates by default.
    """

    def __init__(self, plates: "Plates", stiffness: Floats | None = None):
        self._nodes, self._delay = plates.nodes, plates.delay
        self._matrix = plates.stiffness if stiffness is None else stiffness
        has = plates.nodes[:, 3:] != plates.nodes[:, :3]
        self._triangle, self._edge = np.nonzero(has)
        edge = self._edge[:, None]
        self._order = np.concatenate([(edge + 1) % 3, (edge + 2) % 3, edge, 3 + edge], axis=1)
        self._drawn, self._squares = plates.drawn[has], plates.squares[has]
        self._seen: tuple[Any, tuple[Any, Any, Any, Any]] | None = None

    def _hinges(self, corners: Any) -> tuple[Any, Any, Any, Any]:
        """Return Δ, w and their slopes by the corners of patches [1/m]; kept for a second call.

        Args:
            corners: Of each patch, real or complex, shape (triangle, 6, 3).
        """
        if self._seen is not None and np.array_equal(self._seen[0], corners):
            return self._seen[1]
        count = len(corners)
        more, counts = np.zeros((2, count, 3), dtype=corners.dtype)
        slopes, growing = np.zeros((2, count, 3, 6, 3), dtype=corners.dtype)
        each, edge, order = self._triangle, self._edge, self._order
        own = corners[each[:, None], order]
        found = turned_hinges(own, self._drawn, self._squares)
        more[each, edge], counts[each, edge] = found[0], found[1]
        slopes[each[:, None], edge[:, None], order] = found[2]
        growing[each[:, None], edge[:, None], order] = found[3]
        self._seen = corners, (more, counts, slopes, growing)
        return self._seen[1]

    def _pulled(self, corners: Any) -> Any:
        """Return ∂E/∂x of the corners of patches [N], shape (triangle, 6, 3)."""
        more, counts, slopes, growing = self._hinges(corners)
        by_fold, by_count = np.zeros_like(more), np.zeros_like(more)
        for i in range(3):
            for j in range(3):
                k = self._matrix[:, i, j]
                w, sine = counts[:, i], np.sin(more[:, i])
                if i == j:
                    by_fold[:, i] += k * w * sine
                    by_count[:, i] += k * (1.0 - np.cos(more[:, i]))
                    continue
                v = counts[:, j]
                other = k * v * (3.0 - v) / 2.0 * np.sin(more[:, j])
                by_fold[:, i] += other * w * (3.0 - w) / 2.0 * np.cos(more[:, i])
                by_count[:, i] += other * (3.0 - 2.0 * w) / 2.0 * sine
        pulled = np.einsum("ti,tiax->tax", by_fold, slopes)
        return pulled + np.einsum("ti,tiax->tax", by_count, growing)

    def _braked(self, position: Floats, velocity: Floats) -> tuple[Floats, Floats]:
        """Return forces that brake [N], shape (triangle, 6, 3), and the powers lost [W]."""
        more, counts, slopes, _ = (
            np.real(each) for each in self._hinges(position[self._nodes].astype(complex))
        )
        speed = np.einsum("tiax,tax->ti", slopes, velocity[self._nodes])
        turning = counts * (3.0 - counts) / 2.0 * np.cos(more)
        brake = np.einsum("ti,tij,tj,tj->ti", turning, self._matrix, turning, speed)
        own = np.einsum("tii->ti", self._matrix)
        brake += own * (counts - turning**2) * speed
        brake *= self._delay[:, None]
        return np.einsum("ti,tiax->tax", brake, slopes), (brake * speed).sum(axis=1)

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        pulled = self._pulled(position[self._nodes].astype(complex)).real
        if self._delay.any():
            pulled = pulled + self._braked(position, velocity)[0]
        np.subtract.at(to, self._nodes, pulled)

    def energy(self, time: float, position: Floats) -> float:
        more, counts, _, _ = self._hinges(position[self._nodes].astype(complex))
        more, counts = more.real, counts.real
        z = counts * (3.0 - counts) / 2.0 * np.sin(more)
        own = np.einsum("tii->ti", self._matrix)
        whole = 0.5 * np.einsum("ti,tij,tj->", z, self._matrix, z)
        return float(whole + (own * (counts * (1.0 - np.cos(more)) - 0.5 * z * z)).sum())

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        return float(self._braked(position, velocity)[1].sum()) if self._delay.any() else 0.0

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        blocks = np.zeros((len(self._nodes), 6, 3, 6, 3))
        for corner in range(6):
            for axis in range(3):
                moved = position[self._nodes].astype(complex)
                moved[:, corner, axis] += 1j * STEP
                blocks[:, :, :, corner, axis] = self._pulled(moved).imag / STEP
        return assembled(blocks, number[self._nodes], size)
