"""Volumes that the nodes of parts stand for, of which their masses follow.

A part's volume is shared like that of a whole cell. Mass, momentum and kinetic energy then do
not change in a cut, and in linear simplices the stable step does not, either (T. Menouillard,
J. Réthoré, N. Moës, A. Combescure, H. Bung, Int. J. Numer. Meth. Eng. 74:447, 2008).

In a tetrahedron with ten nodes, the largest eigenvalue of a small part alone may be up to 16
times that of its cell, and in a hexahedron with 27 nodes several hundred times. It then takes
volume over from parts of the cell that can spare some, so that no excess is above ``MOST``, or,
if that cannot be, so that all are equal. Masses of places stay what they are.
"""

import numpy as np

from tissuec.core.arrays import distinct
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.geometry.cut_cells.quadrature import linear_functions
from tissuec.geometry.elements import SHAPES, Measures
from tissuec.model.network import Floats, Indices

#: Largest eigenvalue of a part over that of its whole cell. In hexahedra, 3 instead of 2 lets
#: less mass change sides; with 4, stable steps would be less than half at corners of a body.
MOST = {"tetrahedron": 2.0, "quadratic hexahedron": 3.0}


def node_volumes(parts: CellParts, corners: Floats, measured: Measures, bulk: Floats) -> Floats:
    """Return the volumes that the nodes of parts stand for [m³], shape (part, node).

    Args:
        parts: Of cells of one shape, all parts of each cell among them.
        corners: Drawn places of their nodes [m], shape (part, node, 3).
        measured: Of the parts; see ``quadrature.measures``.
        bulk: Bulk modulus over shear modulus, dimensionless, shape (part,).
    """
    shape = SHAPES[parts.shape]
    volume = measured.volume.sum(axis=1)
    share = shape.weights @ shape.lumped / shape.weights.sum()
    own = np.flatnonzero(~parts.are_whole)
    if shape.nodes > len(parts.division.corners) and len(own):
        volume = volume.copy()
        part = Measures(measured.gradients[own], measured.volume[own])
        cell = Measures.of(shape, corners[own])
        given = share, bulk[own], shape.local, linear_functions(parts.shape)
        excess = _largest(part, *given) / _largest(cell, *given)
        number = np.searchsorted(distinct(parts.cell[own]), parts.cell[own])
        volume[own] = _evened(volume[own], excess / MOST[parts.shape], number)
    return volume[:, None] * share


def _evened(volume: Floats, excess: Floats, cell: Indices) -> Floats:
    """Return volumes with what parts take over from others of their cells, (part,).

    ``excess`` is over what is allowed.
    """
    needed = volume * excess
    lack, slack = np.maximum(needed - volume, 0.0), np.maximum(volume - needed, 0.0)
    lacks, slacks = np.bincount(cell, lack)[cell], np.bincount(cell, slack)[cell]
    part = np.divide(lacks, slacks, out=np.zeros(len(lack)), where=slacks > 0.0)
    # Where there is too little for all of them, excesses become equal.
    scale = np.bincount(cell, volume) / np.bincount(cell, needed)
    return np.where(lacks > slacks, scale[cell] * needed, volume + lack - part * slack)


def _largest(
    measured: Measures, share: Floats, bulk: Floats, local: float, linear: Floats
) -> Floats:
    """Return the largest eigenvalues of parts of unit density and shear modulus, (part,)."""
    steep, weight = measured.gradients, measured.volume
    count = steep.shape[2]
    near = np.minimum(local, bulk)
    matrix = np.einsum("pq,pqax,pqbx->pab", weight, steep, steep, optimize=True)
    stiff = np.einsum("pab,xy->paxby", matrix, np.eye(3))
    stiff += np.einsum("pq,pqay,pqbx->paxby", weight, steep, steep, optimize=True)
    factor = weight * (near - 2.0 / 3.0)[:, None]
    stiff += np.einsum("pq,pqax,pqby->paxby", factor, steep, steep, optimize=True)
    swell = np.einsum("pq,qk,pqax->pkax", weight, linear, steep, optimize=True)
    far = (bulk - near) / weight.sum(axis=1)
    stiff += np.einsum("p,pkax,pkby->paxby", far, swell, swell, optimize=True)
    size = np.sqrt(weight.sum(axis=1)[:, None] * np.repeat(share, 3))
    scaled = stiff.reshape(-1, 3 * count, 3 * count) / size[:, :, None] / size[:, None, :]
    return np.asarray(np.linalg.eigvalsh(scaled)[:, -1], dtype=float)
