"""Contact of points between nodes, as scalar loops; see ``tissuec.forces.contact_points``.

Points stand behind the nodes in arrays of their own. There, contact acts on them as on nodes;
then their forces go to their corners.

Shared arguments:
    x, v: Positions [m] and velocities [m/s] of all nodes, flat, shape (3 node,).
    table: Record of the points and of the contact.
"""

from typing import NamedTuple

from tissuec.forces.contact_kernel import touch
from tissuec.kernels.records import ContactTable, Floats, IntegerRows, Integers, Rows
from tissuec.kernels.thread_loops import UNDIVIDED

PLACING = -2  # the part in which points are placed


class ContactPointTable(NamedTuple):
    """Points near shapes, and the contact in whose arrays they stand behind the nodes."""

    touches: ContactTable
    part: int  # of contact that is computed; PLACING to place the points first
    at: Integers  # where the coordinates of each point begin, shape (near,)
    corners: IntegerRows  # the same of its corners, shape (near, 3)
    shares: Rows  # N_a, shape (near, 3)
    x: Floats  # scratch, positions of nodes and points [m], shape (3 (node + point),)
    v: Floats  # scratch, their velocities [m/s], shape as ``x``
    f: Floats  # scratch, forces on them [N], shape as ``x``


def touch_points(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: ContactPointTable
) -> None:
    """Add the forces of contact to those on nodes, and its powers; see ``touch``.

    In parts, points are placed first, and forces are added behind the last part.
    """
    touches, part = table.touches, table.part
    if part in (PLACING, UNDIVIDED):
        place(x, table.x, table)
        place(v, table.v, table)
    if part == PLACING:
        return
    touch(time, table.x, table.v, table.f, power, touches)
    if part == UNDIVIDED or part == touches.starts.size - 1:
        hand_over(f, table)


def place(vector: Floats, to: Floats, table: ContactPointTable) -> None:
    """Set the vectors of nodes and points.

    Args:
        vector: Of nodes, in any unit, flat, shape (3 node,).
        to: Of nodes and points, in the same unit, flat.
    """
    for i in range(vector.size):
        to[i] = vector[i]
    for p in range(table.at.size):
        i, corners, shares = table.at[p], table.corners[p], table.shares[p]
        a, b, c = corners[0], corners[1], corners[2]
        for k in range(3):
            of_a, of_b, of_c = vector[a + k], vector[b + k], vector[c + k]
            to[i + k] = shares[0] * of_a + shares[1] * of_b + shares[2] * of_c


def hand_over(f: Floats, table: ContactPointTable) -> None:
    """Add the forces on nodes and points to those on nodes, and set them to zero.

    Args:
        f: Forces on nodes [N], flat, shape (3 node,).
    """
    own = table.f
    for i in range(f.size):
        f[i] += own[i]
        own[i] = 0.0
    for p in range(table.at.size):
        i, corners, shares = table.at[p], table.corners[p], table.shares[p]
        for a in range(3):
            j, share = corners[a], shares[a]
            for k in range(3):
                f[j + k] += share * own[i + k]
        for k in range(3):
            own[i + k] = 0.0
