"""Derivatives of branches of solid elements, for the matrix of an implicit step."""

import numpy as np

from tissuec.forces.memory import MemoryTangents
from tissuec.forces.solid_branches import SolidBranches
from tissuec.forces.solid_strain import SolidStrain
from tissuec.forces.stored_tensors import COLUMNS, ROWS, SIX, unimodular_inverse
from tissuec.model.network import Floats, Indices


def branch_tangents(
    branches: SolidBranches,
    deformation: Floats,
    velocity: Floats,
    nodes: Indices,
    gradients: Floats,
    weight: Floats,
) -> MemoryTangents:
    """Return the derivatives of branches, one item for each branch at each point.

    Args:
        branches: Of the elements.
        deformation: F at the points, shape (element, point, 3, 3).
        velocity: Of all nodes [m/s], shape (node, 3).
        nodes: Of the elements, shape (element, node).
        gradients: Of the shape functions [1/m], shape (element, point, node, 3).
        weight: Volumes of the points [m³], shape (element, point).
    """
    points = deformation.shape[1]
    tensors, places = branches.tensors(velocity, points), branches.places(points)
    parts: list[MemoryTangents] = []
    for branch, slot in enumerate(branches.slot):
        items = np.flatnonzero(slot >= 0)
        strain = SolidStrain(deformation[items])
        pull, by_strain, giving = _derivatives(strain, tensors[branch, items])
        rate = branches.rate[branch, items, None, None, None, None]
        pace = 1.0 / branches.time[branch, items, None, None, None]
        strength = branches.shear[branch, items, None] * weight[items]
        steep = gradients[items]
        by_position = rate * np.einsum("eqvxk,eqak->eqvax", by_strain, steep)
        push = -np.einsum("eq,eqvxk,eqak->eqaxv", strength, pull, steep) / rate
        parts.append(
            MemoryTangents(
                slots=places[branch, items].reshape(-1, SIX),
                nodes=np.repeat(nodes[items], points, axis=0),
                giving=(pace * giving).reshape(-1, SIX, SIX),
                by_position=(pace[..., None] * by_position).reshape(-1, *by_position.shape[2:]),
                pull=push.reshape(-1, *push.shape[2:]),
            )
        )
    return MemoryTangents(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _derivatives(strain: SolidStrain, tensors: Floats) -> tuple[Floats, Floats, Floats]:
    """Return derivatives of P / μk and of τ dCi/dt, by the six numbers of Ci and by F.

    Args:
        strain: At some points.
        tensors: Ci there, dimensionless, shape (…, 3, 3).

    Returns:
        ∂P/∂Ci, shape (…, 6, 3, 3), ∂(dCi/dt)/∂F, shape (…, 6, 3, 3), and -∂(dCi/dt)/∂Ci, shape
        (…, 6, 6); all dimensionless.
    """
    f, g, by_j = strain.f, strain.g[..., None, None], strain.by_j[..., None, None]
    right = f.swapaxes(-1, -2) @ f
    inverse = unimodular_inverse(tensors)  # A
    determinant = np.linalg.det(tensors)[..., None, None]
    plain = inverse / np.cbrt(determinant)  # Ci⁻¹
    trace = np.einsum("...kl,...kl->...", right, inverse)  # of C A
    # Changes of Ci, one for each number, and of A by it.
    six = np.zeros((SIX, 3, 3))
    six[np.arange(SIX), ROWS, COLUMNS] = six[np.arange(SIX), COLUMNS, ROWS] = 1.0
    grown = np.einsum("...kl,vkl->...v", plain, six) / 3.0
    a = inverse[..., None, :, :]
    changed = grown[..., None, None] * a - a @ six @ plain[..., None, :, :]
    traces = np.einsum("...kl,...vkl->...v", right, changed)
    pull = g[..., None] * (f[..., None, :, :] @ changed)
    pull = pull + (0.5 * by_j)[..., None] * (
        traces[..., None, None] * strain.cofactors[..., None, :, :]
    )
    # d(dCi/dt) = -(tr(C' dA) Ci + tr(C' A) dCi)/3 at the same strain.
    flow = g[..., None] * (
        traces[..., None, None] * tensors[..., None, :, :] + trace[..., None, None, None] * six
    )
    giving = (flow / 3.0)[..., ROWS, COLUMNS].swapaxes(-1, -2)
    # By F: dC' = g (dFᵀ F + Fᵀ dF) + C dg, of which the trace with A is taken off.
    cofactors = by_j * strain.cofactors
    stretched = g * 2.0 * (f @ inverse) + trace[..., None, None] * cofactors  # of tr(C' A)
    moved = g[..., None, None] * _by_deformation(f)
    moved = moved + right[..., :, :, None, None] * cofactors[..., None, None, :, :]
    moved = moved - tensors[..., :, :, None, None] * stretched[..., None, None, :, :] / 3.0
    return pull, moved[..., ROWS, COLUMNS, :, :], giving


def _by_deformation(f: Floats) -> Floats:
    """Return ∂(FᵀF)_kl/∂F_xm = δ_km F_xl + F_xk δ_lm, shape (…, 3, 3, 3, 3) by k, l, x, m."""
    half = np.einsum("km,...xl->...klxm", np.eye(3), f)
    return half + half.swapaxes(-4, -3)
