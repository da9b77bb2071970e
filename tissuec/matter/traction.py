"""Virtual tests of a solid net: the response to a uniform stress is compared with theory.

A uniform stress σ acts on the nodes of the boundary with forces σ N (see ``solid``). A body of
volume V, Young's modulus E and Poisson's ratio ν stores

    ½ V σ²/E  in tension,     ½ V σ²/G  in shear,     G = E / (2 (1 + ν)).

(S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, 1951.)
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.matter.elasticity import VOIGT
from tissuec.matter.solid import Fibres, Solid
from tissuec.model.network import Floats

if TYPE_CHECKING:
    pass
from tissuec.matter.linear import elongations, solution, stiffness

POISSON = 0.25  # of a solid of central springs
#: Axes along which stresses of bending act, and along which they grow.
BENT = [(one, other) for one in range(3) for other in range(3) if one != other]
_FLOPPY = 1e3  # times as soft as asked: a net that gives way


class Floppy(ValueError):
    """The net does not resist one of the stresses."""


class MeasuredStiffness(NamedTuple):
    """Stiffness of a net relative to the body that it represents.

    Attributes:
        tension: In x, y and z, shape (3,).
        shear: In yz, zx and xy, shape (3,).
    """

    tension: Floats
    shear: Floats

    @property
    def least(self) -> float:
        """Return the least of all."""
        return float(min(self.tension.min(), self.shear.min()))

    @property
    def largest(self) -> float:
        """Return the largest of all."""
        return float(max(self.tension.max(), self.shear.max()))

    def times(self, factor: float) -> "MeasuredStiffness":
        """Return the stiffness of springs whose constants are multiplied."""
        return MeasuredStiffness(factor * self.tension, factor * self.shear)


def measured(
    position: Floats,
    ends: NDArray[np.int32],
    constant: Floats,
    solid: Solid,
    poisson: float = POISSON,
    fibres: Fibres | None = None,
) -> MeasuredStiffness:
    """Return how stiff springs make a body whose Young's modulus should be 1 Pa.

    With fibres, that is its modulus without them, and each stiffness is compared with its own.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        constant: Of each spring per Young's modulus [m], shape (spring,).
        solid: The solid that the nodes represent.
        poisson: Poisson's ratio of the body.
        fibres: In it, if there are any.

    Raises:
        Floppy: Nothing resists one of the stresses.
    """
    matrix = stiffness(elongations(position, ends), constant)
    volume = float(solid.volume.sum())
    allowed = np.diag(compliance(poisson, fibres))
    found: list[float] = []
    forces = forces_of_stresses(solid)
    energies = 0.5 * np.einsum("ua,ua->a", forces, solution(matrix, forces))
    for stored, each, (one, other) in zip(energies.tolist(), allowed, VOIGT, strict=True):
        asked = 0.5 * volume * each
        if not 0.0 < stored < _FLOPPY * asked:
            raise Floppy("nothing resists " + ("tension" if one == other else "shear"))
        found.append(asked / stored)
    return MeasuredStiffness(np.array(found[:3]), np.array(found[3:]))


def forces_of_stresses(solid: Solid) -> Floats:
    """Return the forces of unit stresses in Voigt's order [N/Pa], shape (3 node, 6)."""
    found = np.zeros((*solid.outward.shape, 6))
    for number, (one, other) in enumerate(VOIGT):
        found[:, one, number] += solid.outward[:, other]
        if one != other:
            found[:, other, number] += solid.outward[:, one]
    return found.reshape(-1, 6)


def forces_of_bending(position: Floats, solid: Solid) -> tuple[Floats, Floats]:
    """Return the forces of stresses along one axis that grow along another, as in bending.

    σ_ii = x_j - c_j, of the centre c, is an exact solution whatever the shape of the body; it
    stores ½ S_ii J_j with J_j = ∫ (x_j - c_j)² dV.

    Returns:
        Forces [N m/Pa] in balance, shape (3 node, 6), and what twice the energy of a body of
        S_ii = 1 is under them [m⁵], shape (6,). As forces are those of a stress on points, the
        work L that they do is not quite J; that energy is L²/J.
    """
    x = position - solid.middle
    found = np.zeros((*x.shape, len(BENT)))
    stored: list[float] = []
    for number, (one, other) in enumerate(BENT):
        found[:, one, number] = solid.outward[:, one] * x[:, other]
        work = float(found[:, one, number] @ (x[:, one] * x[:, other]))
        stored.append(work * work / solid.second[other])
    turned = np.cross(np.eye(3)[:, None], x)
    rigid = np.concatenate([np.broadcast_to(np.eye(3)[:, None], turned.shape), turned])
    basis, _ = np.linalg.qr(rigid.reshape(6, -1).T)
    force = found.reshape(-1, len(BENT))
    return force - basis @ (basis.T @ force), np.array(stored)


def compliance(poisson: float, fibres: Fibres | None) -> Floats:
    """Return strains under unit stresses of a Young's modulus of 1 Pa [1/Pa], shape (6, 6)."""
    whole: Floats = np.diag([1.0] * 3 + [2.0 * (1.0 + poisson)] * 3)
    whole[:3, :3] -= poisson * (1.0 - np.eye(3))
    if fibres is not None:
        whole[:] = np.linalg.inv(np.linalg.inv(whole) + fibres.stiffness)
    return whole
