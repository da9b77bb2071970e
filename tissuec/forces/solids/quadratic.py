"""Hexahedra with 27 nodes, whose volume is projected on four functions of the place.

With φ_k, linear functions of the natural coordinates that are orthogonal over the element and
of which the first is 1 (V δ_kl = Σ w φ_k φ_l), an element stores

    E = Σ w (μ ψ(g I1, g² I2) + K h(θ)),    θ = Σ_k φ_k Σ w φ_k J/V,

in the terms of ``solids.elements``. θ is the J of the mixed method whose dilatation and
pressure are discontinuous and linear, which are eliminated in each element: it neither locks
nor leaves a pressure undetermined as K/μ grows. (J. C. Simo, R. L. Taylor, K. S. Pister,
Comput. Meth. Appl. Mech. Eng. 51:177, 1985; T. Sussman, K.-J. Bathe, Computers & Structures
26:357, 1987, of 27 nodes and four pressures. Functions of the drawn place converge in any mesh,
D. Boffi, L. Gastaldi, Numer. Math. 92:411, 2002, but those of ξ are better in coarse ones.)
With ∂J/∂x summed up as b_k = Σ w φ_k ∂J/∂x/V, forces have the projection of K h'(θ) as
pressure, and the matrix has

    Σ_kl b_k (Σ w K h''(θ) φ_k φ_l) b_l

beside that of the points at this pressure.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from tissuec.compiled.loops.point_frame import PointTable
from tissuec.core.structs import replace
from tissuec.forces.element_fields import ElementField
from tissuec.forces.solids.elements import SolidElements
from tissuec.forces.solids.solid_point import SolidKind
from tissuec.geometry.elements import CUBE_27, ElementShape
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


class QuadraticHexahedra(SolidElements, frozen=True):
    """Hexahedra with 27 nodes.

    Attributes:
        linear: φ_k at the points, as ``drawn`` one row for all that are alike, dimensionless,
            shape (row, point, function).
    """

    at_once: ClassVar[int] = 64
    linear: Floats

    @classmethod
    def _with(cls, attributes: Mapping[str, Any], corners: Floats) -> Self:
        linear = linear_functions(attributes["shape"], attributes["drawn"].volume)
        return cls(**attributes, stretches=np.zeros((len(corners), 0)), linear=linear)

    @property
    def kind(self) -> SolidKind:
        """Return the kind of the points, of which forces are."""
        return super().kind._replace(functions=self.linear.shape[-1])

    @property
    def with_stretches(self) -> Self:
        """Return the elements with ``stretches``; see ``PointField``."""
        return replace(super().with_stretches, linear=self.linear[self.row])

    @property
    def derivatives(self) -> str:
        """Return why there are no exact derivatives for learning."""
        return "with 27 nodes have no exact derivatives"

    @property
    def steepest(self) -> Floats:
        """Return about the largest gradient of a shape function [1/m]; see ``PointField``.

        It is the root of the mean of squares, as points near a node have steep ones.
        """
        squares = np.einsum("rq,rqax->rax", self.drawn.volume, self.drawn.gradients**2)
        return np.sqrt((squares.max(axis=(1, 2)) / self.drawn.volume.sum(axis=1))[self.row])

    @property
    def _functions(self) -> Floats:
        """Return φ_k at points; see ``SolidElements``."""
        return self.linear[self.row]

    # --- matrices -----------------------------------------------------------------------------

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size); see ``Effect``."""
        return ElementField.matrix(self, time, position, number, size, exact=exact)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def seconds(self) -> float:
        """Return an estimate of the time of one evaluation [s]; few points wait for memory."""
        return 0.36 * super().seconds

    def _table(self, kind: SolidKind, nodes: Indices, slots: Indices) -> PointTable:
        used, row = np.unique(self.row, return_inverse=True)
        return PointTable.of(
            nodes, self._numbers(kind), row.reshape(-1), self.drawn.gradients[used],
            self.drawn.volume[used], slots[: kind.tensors],
            self.linear[used].reshape(len(used), self.points * self.linear.shape[2]),
        )  # fmt: skip


def linear_functions(shape: ElementShape, weight: Floats) -> Floats:
    """Return φ_k at points, dimensionless, shape (element, point, function).

    Args:
        shape: That with 27 nodes.
        weight: Volumes of their points [m³], shape (element, point).
    """
    places = shape.lumped @ CUBE_27
    functions = np.concatenate([np.ones((len(places), 1)), places], axis=1)
    # What is inside out is refused later.
    root = np.sqrt(np.abs(weight / weight.sum(axis=1, keepdims=True)))[..., None]
    orthogonal, triangle = np.linalg.qr(root * functions)
    signs = np.sign(np.diagonal(triangle, axis1=1, axis2=2))[:, None]
    found = np.zeros(orthogonal.shape)
    return np.divide(signs * orthogonal, root, out=found, where=root > 0.0)
