"""Derivatives of the forces of a foundation; for the equations see ``acting.foundation``."""

from tissuec.forces.acting.foundation_kernel import BedTable
from tissuec.kernels.records import Floats


def pull_bed(
    time: float,
    x: Floats,
    v: Floats,
    weight: Floats,
    by_x: Floats,
    by_v: Floats,
    by: Floats,
    bed: BedTable,
) -> None:
    """Add the derivatives of Σ weight · f; see ``tissuec.forces.matrices``.

    Args:
        by: Derivatives by stiffness, damping and where nodes are drawn.
    """
    count = bed.nodes.size
    for k in range(count):
        stiffness, damping = bed.stiffness[k], bed.damping[k]
        for axis in range(3):
            i = 3 * bed.nodes[k] + axis
            by[k] -= weight[i] * (x[i] - bed.home[k, axis])
            by[count + k] -= weight[i] * v[i]
            by[2 * count + 3 * k + axis] += stiffness * weight[i]
            by_x[i] -= stiffness * weight[i]
            by_v[i] -= damping * weight[i]


def push_bed(
    time: float,
    x: Floats,
    v: Floats,
    dx: Floats,
    dv: Floats,
    dn: Floats,
    df: Floats,
    room: Floats,
    bed: BedTable,
) -> None:
    """Add the changes of the forces for many changes; see ``tissuec.forces.matrices``.

    Args:
        dn: Changes of stiffness, damping and where nodes are drawn.
    """
    count, own = bed.nodes.size, room.size
    for k in range(count):
        stiffness, damping = bed.stiffness[k], bed.damping[k]
        stiffer = dn[own * k : own * (k + 1)]
        thicker = dn[own * (count + k) : own * (count + k + 1)]
        for axis in range(3):
            i, home = 3 * bed.nodes[k] + axis, own * (2 * count + 3 * k + axis)
            away, part = x[i] - bed.home[k, axis], slice(own * i, own * (i + 1))
            place, speed, force, drawn = dx[part], dv[part], df[part], dn[home : home + own]
            for m in range(own):
                force[m] -= stiffness * (place[m] - drawn[m]) + damping * speed[m]
                force[m] -= stiffer[m] * away + thicker[m] * v[i]
