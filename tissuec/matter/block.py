"""Springs of a block of crystal cells, fitted on a block of a few cells.

Deep inside, springs repeat from cell to cell, or from every other cell to the next. So a block
is fitted that has no more than a few cells along a side, and each spring of the whole gets the
constant of the one in its place.

Cubes of edge a of which every other one has its body diagonals cannot pass the patch test:
where the block is sheared, nodes whose diagonals go up shift against those whose go down.
With edges of the constant k and diagonals of 3/2 k they have

    C11 = 2 k/a,    C12 = k/a,    C44 = k / (2 a)    (k/a, were it not for the shift),

so that they are isotropic with the shear modulus k / (2 a) and Poisson's ratio 1/3; derived
here from the energy of evenly strained cells.
"""

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.matter.fibres import Fibres
from tissuec.matter.patch import fitted
from tissuec.matter.solid import Solid
from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.model.network import Floats, Indices

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
        lattice: The lattice.
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
    site = _numbered(sample.position, low, steps / lattice.cell, kept * steps + 1)
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
