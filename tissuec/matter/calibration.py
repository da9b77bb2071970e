"""Springs of an irregular net, changed as little as needed for a given stiffness.

Where springs cannot pass the patch test (see ``patch``), nodes give way, and the net is softer
than the solid, by different parts in different directions. Under six uniform stresses a
on its boundary (see ``traction``) it is found to have the compliance S_ab = f_a · u_b / V,
hence the stiffness C = S⁻¹. Springs of constants k that are lengthened by e_a under the mean
strain a bear parts of it:

    C_ab = Σ k e_a e_b / V,    ∂C_ab/∂k = e_a e_b / V,

the first as energies add up, the second as displacements are in balance. So springs are
multiplied by those g with the least Σ k L² (g - 1)² for which Σ g k e_a e_b / V is the
required stiffness, repeatedly, since g changes e.

Nets of few cells are too stiff in bending, which stresses that grow across their direction
find. Its correction is a part of the same step, but not a full one: it makes springs inside
stiffer than those at the boundary, which changes Poisson's ratio and, in coarse nets, makes
moduli uneven.

An even stress finds the least stiffness of a coarse net, an even strain of its boundary the
largest (see ``elasticity``). Between plates, or held elsewhere, it has one about halfway. So at
last all springs are divided by the geometric mean of both. (C. Huet, J. Mech. Phys.
Solids 38:813, 1990, on both bounds; the step of the constants is derived here.)
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.matter.elasticity import of_solid
from tissuec.matter.fibres import Fibres
from tissuec.matter.linear import elongations, solution, stiffness
from tissuec.matter.patch import IRREGULAR, YOUNG, fitted
from tissuec.matter.solid import Solid
from tissuec.matter.traction import (
    BENT,
    POISSON,
    MeasuredStiffness,
    compliance,
    forces_of_bending,
    forces_of_stresses,
    measured,
)
from tissuec.model.network import Floats

ROUNDS = 3
BENDING = 0.75  # power of the ratio by which a net is too stiff in bending that is corrected
COARSE = 1.3  # ratio from which on it is not corrected
MOST = 5.0  # times as stiff or soft as before: larger corrections are reported, not made
#: Of the largest eigenvalue: a mean stiffness that springs determine less is left as it is,
#: such as one that is not symmetric in all four indices.
_WEAK = 1e-3
_ONE, _OTHER = np.triu_indices(6)
_TIMES = np.where(_ONE == _OTHER, 1.0, np.sqrt(2.0))  # how often each occurs in C, as a root


def calibrated(
    position: Floats, ends: NDArray[np.int32], solid: Solid, fibres: Fibres | None = None
) -> tuple[Floats, MeasuredStiffness]:
    """Return constants of springs per Young's modulus [m], and what even stresses find.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        solid: The solid that the nodes represent.
        fibres: In it, if there are any.

    Raises:
        Floppy: Nothing resists one of the stresses.
    """
    net = position, ends
    tried = [fitted(*net, solid, fibres, weight) / YOUNG for weight in IRREGULAR]
    tests = [measured(*net, constant, solid, fibres=fibres) for constant in tried]
    best = int(np.argmax([test.least for test in tests]))
    constant = tried[best] / tests[best].tension.mean()
    constant = constant * _factors(*net, constant, solid, fibres)
    found = measured(*net, constant, solid, fibres=fibres)
    return constant / np.sqrt(_of_even_strain(*net, constant, solid, fibres)), found


def _of_even_strain(
    position: Floats,
    ends: NDArray[np.int32],
    constant: Floats,
    solid: Solid,
    fibres: Fibres | None,
) -> float:
    """Return the mean stiffness in tension while an even strain holds the boundary."""
    boundary = np.flatnonzero(solid.outward.any(axis=1))
    volume = float(solid.volume.sum())
    found = of_solid(position, ends, constant, None, boundary, volume)
    asked = 1.0 / np.diag(compliance(POISSON, fibres))[:3]
    return float((found.young / asked).mean())


def _factors(
    position: Floats,
    ends: NDArray[np.int32],
    constant: Floats,
    solid: Solid,
    fibres: Fibres | None,
) -> Floats:
    """Return the factors of springs that give the right stiffness, shape (spring,)."""
    rows, force = elongations(position, ends), forces_of_stresses(solid)
    volume, soft = float(solid.volume.sum()), compliance(POISSON, fibres)
    asked = np.linalg.inv(soft)
    bending, stored = forces_of_bending(position, solid)
    stored *= [soft[one, one] for one, _ in BENT]
    along = position[ends[:, 1]] - position[ends[:, 0]]
    weight = constant * np.einsum("si,si->s", along, along)
    weight = np.maximum(weight, 1e-6 * weight.mean())
    times, aims = np.ones(len(ends)), None
    for _ in range(ROUNDS):
        matrix = stiffness(rows, times * constant)
        moved = solution(matrix, force)
        soft = force.T @ moved / volume
        has = np.linalg.inv(0.5 * (soft + soft.T))
        strained = (rows @ moved) @ has
        parts = strained[:, _ONE] * strained[:, _OTHER] * _TIMES
        parts *= (times * constant / volume)[:, None]
        bent = solution(matrix, bending)
        work = np.einsum("ub,ub->b", bending, bent)
        excess = stored / work
        if aims is None:  # none of coarse nets, whose bending is left as it is
            is_fine = (excess > 1.0 / COARSE).all() and (excess < COARSE).all()
            aims = excess ** (1.0 - BENDING) if is_fine else excess[:0]
        missing = (asked - has)[_ONE, _OTHER] * _TIMES
        if len(aims):
            turning = (times * constant)[:, None] * (rows @ bent) ** 2 * excess / work
            parts, missing = np.hstack([parts, turning]), np.append(missing, aims - excess)
        more = _least(parts, weight, missing)
        times = np.clip(times * (1.0 + more), 1.0 / MOST, MOST)
    return times


def _least(parts: Floats, weight: Floats, missing: Floats) -> Floats:
    """Return the x of least Σ w x² for which Σ x p is what is missing, as far as it can be.

    Args:
        parts: p, shape (spring, number).
        weight: w, shape (spring,).
        missing: Shape (number,).
    """
    weighted = parts / weight[:, None]
    values, vectors = np.linalg.eigh(parts.T @ weighted)
    strong = values > _WEAK * values[-1]
    vectors = vectors[:, strong]
    return np.asarray(weighted @ (vectors @ (vectors.T @ missing / values[strong])))
