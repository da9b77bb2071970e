"""Spring constants that make a net an isotropic elastic solid: of any mesh, cells, calibrated.

Central springs of constants k, from node to node along unit vectors n, lengths L apart, stand
for a solid with Poisson's ratio 1/4, as the tensor of their stiffness is symmetric in all four
indices (Cauchy):

    C_ijkl = μ (δ_ij δ_kl + δ_ik δ_jl + δ_il δ_jk).

Stretched evenly by ε, they pull at a node with Σ k L n_i n_j n_k ε_jk. A solid that is
stretched evenly rests under the traction C_ijkl ε_jk N_l of its boundary, N being the outward
area that a node represents there, and without any inside. So a net passes the patch test of
finite elements (B. M. Irons and A. Razzaque, 1972) for every ε if

    Σ k L n_i n_j n_k = - μ (δ_ij N_k + δ_ik N_j + δ_jk N_i)    at every node.

Fibres along f that add β f f f f to C add -β f_i f_j f_k f_l N_l to the right-hand side. These
linear equations are solved for k ≥ 0 in the sense of least squares, drawn towards springs that
share the volume around their ends evenly.

Springs of a block of crystal cells, fitted on a block of a few cells.

Deep inside, springs repeat from cell to cell, or from every other cell to the next. So a block
is fitted that has no more than a few cells along a side, and each spring of the whole gets the
constant of the one in its place.

Cubes of edge a of which every other one has its body diagonals cannot pass the patch test:
where the block is sheared, nodes whose diagonals go up shift against those whose go down.
With edges of the constant k and diagonals of 3/2 k they have

    C11 = 2 k/a,    C12 = k/a,    C44 = k / (2 a)    (k/a, were it not for the shift),

so that they are isotropic with the shear modulus k / (2 a) and Poisson's ratio 1/3; derived
here from the energy of evenly strained cells.

Springs of an irregular net, changed as little as needed for a given stiffness.

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

from itertools import combinations_with_replacement, permutations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.matter.elasticity import of_solid
from tissuec.matter.linear import conjugate_gradients, elongations, solution, stiffness
from tissuec.matter.solid import Fibres, Solid
from tissuec.matter.traction import (
    BENT,
    POISSON,
    MeasuredStiffness,
    compliance,
    forces_of_bending,
    forces_of_stresses,
    measured,
)
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Pairs = NDArray[np.int32]

YOUNG = 2.0 * (1.0 + POISSON)  # of a solid of springs whose shear modulus is 1
#: Weight of the even share, beside the equations: of crystals, which nearly fulfil these, and
#: those to choose from elsewhere. With a small one, nets that are far from it keep too few
#: springs inside, and give way.
CRYSTAL, IRREGULAR = 1e-3, (0.03, 0.3, 1.0)
ROUNDS = 20  # of choosing the springs that are left out
ROUGH, FINE = 1e-4, 1e-9  # residuals of equations, first and at last
MOST = 5000  # iterations of solving them
#: The entries of a symmetric tensor of three indices, and how often each occurs in it.
TRIPLES = np.array(list(combinations_with_replacement(range(3), 3)))
TIMES = np.array([len(set(permutations(triple))) for triple in TRIPLES.tolist()])


def fitted(
    position: Floats,
    ends: Pairs,
    solid: Solid,
    fibres: Fibres | None = None,
    weight: float = CRYSTAL,
) -> Floats:
    """Return the constants of springs per shear modulus [m], shape (spring,).

    They pass the patch test as nearly as they can.

    Args:
        position: [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        solid: The solid that the nodes represent.
        fibres: In it, if there are any.
        weight: Of the even share.
    """
    along = position[ends[:, 1]] - position[ends[:, 0]]
    start = _even(along, ends, solid)
    matrix, wanted = _equations(along, ends, solid, start, fibres)
    return start * _not_negative(matrix, wanted, weight)


def _even(along: Floats, ends: Pairs, solid: Solid) -> Floats:
    """Return constants of springs that share the volume of their nodes evenly, (spring,).

    Of springs that have a volume V, Σ k L² / V is C_iijj = 15 μ.
    """
    degree = np.bincount(ends.ravel(), minlength=len(solid.volume))
    volume = (solid.volume / np.maximum(degree, 1))[ends].sum(axis=1)
    return np.asarray(15.0 * volume / np.einsum("si,si->s", along, along))


def _equations(
    along: Floats, ends: Pairs, solid: Solid, start: Floats, fibres: Fibres | None
) -> tuple["csr_matrix", Floats]:
    """Return the equations of the patch test for multiples of some spring constants.

    They are divided by the area that a node represents, and count by its volume.
    """
    from scipy.sparse import csr_matrix

    length = np.linalg.norm(along, axis=1)
    n = along / length[:, None]
    i, j, k = TRIPLES.T
    triple = (start * length)[:, None] * np.sqrt(TIMES) * n[:, i] * n[:, j] * n[:, k]
    size = solid.volume ** (-1.0 / 6.0)
    count = len(TRIPLES)
    rows = (ends.astype(np.int64)[:, :, None] * count + np.arange(count)).ravel()
    values = np.stack([triple * size[ends[:, :1]], -triple * size[ends[:, 1:]]], axis=1)
    columns = np.repeat(np.arange(len(ends)), 2 * count)
    shape = (len(size) * count, len(ends))
    matrix = csr_matrix((values.ravel(), (rows, columns)), shape=shape)
    unit, outward = np.eye(3), solid.outward
    traction = (
        unit[i, j] * outward[:, k] + unit[i, k] * outward[:, j] + unit[j, k] * outward[:, i]
    )
    if fibres is not None:  # μ is 1 here
        f = fibres.direction
        traction += YOUNG * fibres.added * (f[i] * f[j] * f[k]) * (outward @ f)[:, None]
    return matrix, (-traction * np.sqrt(TIMES) * size[:, None]).ravel()


def _not_negative(matrix: "csr_matrix", wanted: Floats, weight: float) -> Floats:
    """Return x ≥ 0 for which A x is next to b, drawn to 1, by pivoting in blocks.

    (L. F. Portugal, J. J. Júdice, L. N. Vicente, Math. Comp. 63:625, 1994.)
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import aslinearoperator

    squares = np.asarray(matrix.multiply(matrix).sum(axis=0), dtype=float).ravel()
    pull = weight**2 * squares
    diagonal = squares + pull
    right = matrix.T @ wanted + pull
    used, x = np.ones(len(squares), dtype=bool), np.ones(len(squares))
    # Which ones are left out is nearly clear long before their last digits are.
    for precise in ROUGH, FINE:
        for _ in range(ROUNDS):
            x[~used] = 0.0
            inner, own = aslinearoperator(matrix[:, used]), diags(pull[used])
            normal = inner.T @ inner + aslinearoperator(own)
            x[used] = conjugate_gradients(
                normal, diagonal[used], right[used], x[used], precise, MOST
            )
            slope = matrix.T @ (matrix @ x) + pull * x - right
            wrong = (used & (x < 0.0)) | (~used & (slope < -FINE * diagonal))
            if not wrong.any():
                break
            used ^= wrong
    return np.maximum(x, 0.0)


BESIDE = 3  # cells at either end of a side that differ from those between them
POISSON_OF_BRACED = 1.0 / 3.0


def sample_of(lattice: Lattice) -> Lattice:
    """Return the least block of which each spring of a lattice is a copy."""
    cells, period = np.array(lattice.cells()), CRYSTALS[lattice.kind].period
    least = 2 * BESIDE + period
    kept = np.where(cells > least, least + (cells - least) % period, cells)
    low, _ = lattice.corners
    return replace(lattice, box=(low, low + kept * lattice.cell))


def fitted_block(lattice: Lattice, mesh: Mesh, fibres: Fibres | None = None) -> Floats:
    """Return the constants of a lattice's springs per shear modulus [m], shape (spring,).

    Args:
        mesh: Its nodes and springs.
        fibres: Fibres that stiffen it, None if there are none.

    Raises:
        ValueError: There are fibres in braced cubes.
    """
    if lattice.is_braced:
        if fibres is not None:
            raise ValueError("springs of braced cubes run in too few directions for fibres")
        return _braced(lattice, mesh)
    small = sample_of(lattice)
    cells, kept = np.array(lattice.cells()), np.array(small.cells())
    sample = small.build()
    constant = _fitted(sample, fibres)
    if (kept == cells).all():
        return constant
    low, _ = lattice.corners
    steps, period = CRYSTALS[lattice.kind].divisions, CRYSTALS[lattice.kind].period
    fine = np.rint((mesh.position - low) * (steps / lattice.cell)).astype(np.int64)
    shift = (cells - kept) * steps
    first, last = BESIDE * steps, BESIDE * steps + shift
    start = fine[mesh.ends[:, 0]]
    inside = first + (start - first) % (steps * period)
    # A spring is looked up by its start and its direction.
    place = np.where(start < first, start, np.where(start >= last, start - shift, inside))
    place = np.where(kept == cells, start, place)
    site = _numbered(sample.position, low, steps / lattice.edges[0], kept * steps + 1)
    ends = np.stack([place, place + fine[mesh.ends[:, 1]] - start])
    pairs = np.sort(site[tuple(np.moveaxis(ends, 2, 0))], axis=0)
    count = len(sample.position)
    keys = sample.ends.astype(np.int64) @ np.array([count, 1])
    return constant[np.searchsorted(keys, pairs[0] * count + pairs[1])]


def _braced(lattice: Lattice, mesh: Mesh) -> Floats:
    """Return the constants of cubes with diagonals per shear modulus [m], shape (spring,)."""
    ends = mesh.position[mesh.ends]
    low, high = lattice.corners
    # Edges in a face of the block belong to half as many cells, along its edges to a quarter.
    in_face = (ends[:, 0] == ends[:, 1]) & ((ends[:, 0] == low) | (ends[:, 0] == high))
    share = np.prod(np.where(in_face, 0.5, 1.0), axis=1)
    is_edge = (ends[:, 0] == ends[:, 1]).any(axis=1)
    return lattice.cell * np.where(is_edge, 2.0 * share, 3.0)


def _fitted(mesh: Mesh, fibres: Fibres | None) -> Floats:
    assert mesh.volume is not None
    solid = Solid.of(mesh.position, mesh.volume, mesh.skin)
    return fitted(mesh.position, mesh.ends, solid, fibres)


def _numbered(position: Floats, low: Floats, scale: float, shape: NDArray[np.int64]) -> Indices:
    """Return the node at each place of the fine grid, -1 for none."""
    number = np.full(tuple(shape.tolist()), -1, dtype=np.int64)
    number[tuple(np.rint((position - low) * scale).astype(np.int64).T)] = np.arange(
        len(position)
    )
    return number


CALIBRATIONS = 3
BENDING = 0.75  # power of the ratio by which a net is too stiff in bending that is corrected
COARSE = 1.3  # ratio from which on it is not corrected
MOST_CALIBRATED = (
    5.0  # times as stiff or soft as before: larger corrections are reported, not made
)
#: Relative to the largest eigenvalue: mean stiffnesses that the springs hardly determine stay
#: unchanged, such as those that are not symmetric in all four indices.
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
    for _ in range(CALIBRATIONS):
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
        times = np.clip(times * (1.0 + more), 1.0 / MOST_CALIBRATED, MOST_CALIBRATED)
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
