"""Forces within planes of symmetry as scalar loops; see ``acting.symmetry``."""

from typing import NamedTuple

from tissuec.kernels.records import Floats, Integers, Rows


class SymmetryTable(NamedTuple):
    """Nodes on planes of symmetry as the kernel reads them."""

    nodes: Integers  # shape (n,)
    within: Rows  # what stays of a force, row by row of the matrix, shape (n, 9)


def mirror(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, planes: SymmetryTable
) -> None:
    """Leave only the part within the planes of the forces that are there already.

    Args:
        planes: The nodes on planes.
    """
    for k in range(planes.nodes.size):
        i = 3 * planes.nodes[k]
        f0, f1, f2 = f[i], f[i + 1], f[i + 2]
        for axis in range(3):
            f[i + axis] = (
                planes.within[k, 3 * axis] * f0
                + planes.within[k, 3 * axis + 1] * f1
                + planes.within[k, 3 * axis + 2] * f2
            )
