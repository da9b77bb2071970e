"""The forces of a foundation as scalar loops; for the equations see ``acting.foundation``."""

from typing import NamedTuple

from tissuec.kernels.records import Floats, Integers, Rows


class BedTable(NamedTuple):
    """A bed as the kernel reads it; see ``acting.foundation.Bed``."""

    nodes: Integers
    home: Rows
    stiffness: Floats
    damping: Floats


def hold(time: float, x: Floats, v: Floats, f: Floats, power: Floats, bed: BedTable) -> None:
    """Add the forces of a bed to those on nodes, and the power that its dashpots dissipate."""
    for k in range(bed.nodes.size):
        stiffness, damping = bed.stiffness[k], bed.damping[k]
        for axis in range(3):
            i = 3 * bed.nodes[k] + axis
            f[i] -= stiffness * (x[i] - bed.home[k, axis]) + damping * v[i]
            power[1] += damping * v[i] * v[i]
