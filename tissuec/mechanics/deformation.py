"""Strain and stress at the nodes of a net, from the springs around each node.

The springs of a node lead along X as drawn and along x at present. Their deformation gradient
F minimises Σ |x - F X|², so that F = B A⁻¹ with A = Σ X Xᵀ and B = Σ x Xᵀ (M. L. Falk, J. S.
Langer, Phys. Rev. E 57:7192, 1998), and the strain is that of Green and Lagrange,
E = (FᵀF - 1)/2. In directions that no spring of the node leads along, F is not known: with the
eigenvectors of A that are kept as columns of Q, and G = F Q,

    E = ½ Q (GᵀG - 1) Qᵀ,    J = √det GᵀG

have no part in these directions.

The stress is Cauchy's, as the virial of half of each spring's tension t (A. P. Thompson, S. J.
Plimpton, W. Mattson, J. Chem. Phys. 131:154107, 2009): with the length l, the direction u and
the drawn volume V of the share of the node, S = Σ ½ t l u uᵀ and

    σ = Σ w S / Σ w J V

over the node, with w = 1, and nodes near it. In crystals of several sites, springs of one kind
of site can be stiffer than those of another, although the whole is even. As a hat function of
the width of a cell, w counts each kind alike (R. J. Hardy, J. Chem. Phys. 76:622, 1982).

Six components of a symmetric tensor are in the order of VTK: xx, yy, zz, xy, yz, xz.
"""

from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
_THIN = 1e-6
"""Eigenvalue of A over the largest one below which no spring leads along a direction."""


class Surroundings(Struct, frozen=True, eq=False):
    """The springs around nodes as drawn.

    Attributes:
        ends: Node pair of each spring, shape (spring, 2).
        along: From the first to the second node as drawn [m], shape (spring, 3).
        inverse: Q Λ⁻¹ of each node, zero for what is not kept [1/m²], shape (node, 3, 3).
        axes: The eigenvectors of A as columns, those first that are kept least, shape (node, 3,
            3).
        kept: Which of them are kept, shape (node, 3).
    """

    ends: Indices
    along: Floats
    inverse: Floats
    axes: Floats
    kept: NDArray[np.bool_]

    @classmethod
    def of(cls, drawn: Floats, ends: Indices, dimension: int) -> Self:
        """Return the surroundings of nodes.

        Args:
            drawn: Positions as drawn [m], shape (node, 3).
            ends: Node pair of each spring that counts, shape (spring, 2).
            dimension: In how many directions the net extends: 3 in solids, 2 in walls, 1 in
                bars. As many eigenvectors are kept at most.
        """
        along = drawn[ends[:, 1]] - drawn[ends[:, 0]]
        value, axes = np.linalg.eigh(symmetric(_sum(ends, _products(along, along), len(drawn))))
        kept = value > _THIN * value[:, 2:]
        kept[:, : 3 - dimension] = False
        inverse = axes * np.where(kept, 1.0 / np.where(kept, value, 1.0), 0.0)[:, None]
        return cls(ends, along, inverse, axes, kept)

    def repeated(self, count: int) -> Self:
        """Return the surroundings of several copies of the net, their nodes in sequence."""
        nodes = len(self.kept)
        ends = self.ends[None] + nodes * np.arange(count)[:, None, None]
        return type(self)(
            ends.reshape(-1, 2),
            np.tile(self.along, (count, 1)),
            np.tile(self.inverse, (count, 1, 1)),
            np.tile(self.axes, (count, 1, 1)),
            np.tile(self.kept, (count, 1)),
        )

    @property
    def directions(self) -> Indices:
        """Return in how many directions the strain of each node is known, shape (node,)."""
        return self.kept.sum(axis=1)

    def strain(self, position: Floats) -> tuple[Floats, Floats]:
        """Return the strain of each node, and its present over its drawn volume.

        Args:
            position: At present [m], shape (node, 3).

        Returns:
            Strain, shape (node, 6), and volume ratio J, shape (node,); 0 and 1 without springs.
        """
        count = len(position)
        present = position[self.ends[:, 1]] - position[self.ends[:, 0]]
        both = (present[:, :, None] * self.along[:, None, :]).reshape(-1, 9)
        stretched = _sum(self.ends, both, count).reshape(-1, 3, 3) @ self.inverse
        unit = np.eye(3) * self.kept[:, None, :]
        squared = stretched.transpose(0, 2, 1) @ stretched
        green = 0.5 * self.axes @ (squared - unit) @ self.axes.transpose(0, 2, 1)
        ratio = np.linalg.det(squared + np.eye(3) - unit)
        return six(green), np.sqrt(np.maximum(ratio, 0.0))

    def virial(self, position: Floats, tension: Floats) -> Floats:
        """Return S of each node [J], shape (node, 6).

        Args:
            position: At present [m], shape (node, 3).
            tension: Of each spring [N], shape (spring,).
        """
        present = position[self.ends[:, 1]] - position[self.ends[:, 0]]
        length = np.sqrt((present * present).sum(axis=1))
        # A spring whose ends meet has no direction, and no virial.
        per_length = np.divide(0.5 * tension, length, where=length > 0.0, out=0.0 * length)
        halves = per_length[:, None] * _products(present, present)
        return _sum(self.ends, halves, len(position))


def hats(drawn: Floats, cell: float) -> "csr_matrix":
    """Return w for the nodes near each node, shape (node, node).

    Along each axis, it falls evenly from 1 at the node to 0 at the distance of a cell.

    Args:
        drawn: Positions as drawn [m], shape (node, 3).
        cell: Width of a cell [m], by which the crystal repeats itself.
    """
    from scipy.sparse import csr_matrix, eye
    from scipy.spatial import KDTree

    pairs = KDTree(drawn).query_pairs(cell, p=np.inf, output_type="ndarray")
    apart = np.abs(drawn[pairs[:, 1]] - drawn[pairs[:, 0]])
    near = np.prod(np.maximum(1.0 - apart / cell, 0.0), axis=1)
    half = csr_matrix((near, (pairs[:, 0], pairs[:, 1])), shape=(len(drawn), len(drawn)))
    return csr_matrix(half + half.T + eye(len(drawn)))


def von_mises(stress: Floats) -> Floats:
    """Return the equivalent stress of von Mises [Pa], shape (…).

    Args:
        stress: [Pa], shape (…, 6).
    """
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.sqrt(0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz))


def mean_of_springs(ends: Indices, values: Floats, count: int) -> Floats:
    """Return the mean of the springs of each node, 0 without springs, shape (node,).

    Args:
        ends: Node pair of each spring, shape (spring, 2).
        values: Of each spring, in any unit, shape (spring,).
        count: Number of nodes.
    """
    springs = np.bincount(ends.ravel(), minlength=count)
    return _sum(ends, values[:, None], count)[:, 0] / np.maximum(springs, 1)


def _products(one: Floats, other: Floats) -> Floats:
    """Return the products of two vectors in the order of `COMPONENTS`, shape (…, 6)."""
    return np.stack([one[:, i] * other[:, j] for i, j in COMPONENTS], axis=-1)


def _sum(ends: Indices, values: Floats, count: int) -> Floats:
    """Return the sums of values of springs over both of their ends, shape (node, column)."""
    found = np.empty((count, values.shape[1]))
    for column, value in zip(found.T, values.T, strict=True):
        column[:] = np.bincount(ends[:, 0], value, count)
        column += np.bincount(ends[:, 1], value, count)
    return found


def symmetric(six: Floats) -> Floats:
    """Return symmetric matrices, shape (…, 3, 3), in the unit of their components.

    Args:
        six: Components in the order of `COMPONENTS`, shape (…, 6).
    """
    return six[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*six.shape[:-1], 3, 3)


def six(full: Floats) -> Floats:
    """Return symmetric tensors (…, 3, 3) by their components in the order of `COMPONENTS`.

    They are in the unit of ``full``, shape (…, 6).
    """
    return np.stack([full[..., i, j] for i, j in COMPONENTS], axis=-1)
