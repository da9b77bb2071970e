"""Springs of a block of crystal cells, of which a few cells along each side tell all.

Deep inside, every cell has the same springs. So a block is fitted that has no more than a few
cells along a side, and each spring of the whole gets the constant of the one in its place.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tissuec.matter.patch import fitted
from tissuec.matter.solid import Solid
from tissuec.meshes import Mesh
from tissuec.meshes.lattice import CRYSTALS, Lattice
from tissuec.network import Floats, Indices

BESIDE = 3  # cells at either end of a side that differ from those between them
SIDE = 2 * BESIDE + 1


def fitted_block(lattice: Lattice, mesh: Mesh) -> Floats:
    """Return the constants of a lattice's springs per shear modulus [m], shape (spring,)."""
    cells = np.array(lattice.cells())
    kept = np.minimum(cells, SIDE)
    low, _ = lattice.corners
    small = replace(lattice, box=(low, low + kept * lattice.cell))
    sample = small.build()
    constant = _fitted(sample)
    if (kept == cells).all():
        return constant
    steps = CRYSTALS[lattice.kind].divisions
    fine = np.rint((mesh.position - low) * (steps / lattice.cell)).astype(np.int64)
    first, last = BESIDE * steps, (cells - BESIDE - 1) * steps
    start = fine[mesh.ends[:, 0]]
    inside = first + (start - first) % steps
    # A spring is looked up by where it starts and how it goes on.
    place = np.where(
        start < first, start, np.where(start >= last, start - last + first, inside)
    )
    place = np.where(kept == cells, start, place)
    site = _numbered(sample.position, low, steps / lattice.cell, kept * steps + 1)
    ends = np.stack([place, place + fine[mesh.ends[:, 1]] - start])
    pairs = np.sort(site[tuple(np.moveaxis(ends, 2, 0))], axis=0)
    count = len(sample.position)
    keys = sample.ends.astype(np.int64) @ np.array([count, 1])
    return constant[np.searchsorted(keys, pairs[0] * count + pairs[1])]


def _fitted(mesh: Mesh) -> Floats:
    assert mesh.volume is not None
    return fitted(mesh.position, mesh.ends, Solid.of(mesh.position, mesh.volume, mesh.skin))


def _numbered(position: Floats, low: Floats, scale: float, shape: NDArray[np.int64]) -> Indices:
    """Return which node stands at each place of the fine grid, -1 for none."""
    number = np.full(tuple(shape.tolist()), -1, dtype=np.int64)
    number[tuple(np.rint((position - low) * scale).astype(np.int64).T)] = np.arange(
        len(position)
    )
    return number
