"""The equations of motion of free nodes as y' = f(t, y), for other solvers."""

from typing import NamedTuple

from tissuec.forces.accelerations import force, place
from tissuec.kernels.records import Floats, Integers, Net


class Unknowns(NamedTuple):
    """Displacements and velocities of the free nodes, each coordinate next to its velocity."""

    y: Floats  # shape (6 free,)
    rate: Floats  # y', shape (6 free,)
    origin: Floats  # drawn positions [m], shape (3 node,)
    nodes: Integers  # places of the free nodes, in the order of the unknowns, shape (free,)
    x: Floats  # scratch, holds the nodes that do not move, shape (3 node,)
    v: Floats  # scratch, likewise
    a: Floats  # scratch, shape (3 node,)
    power: Floats  # scratch, shape (2,)


def rate(time: float, unknowns: Unknowns, net: Net) -> None:
    """Set y' at a time.

    Args:
        time: Time [s].
        unknowns: y, y' and scratch.
        net: What acts on the nodes.
    """
    y, out, origin, nodes = unknowns.y, unknowns.rate, unknowns.origin, unknowns.nodes
    x, v, a = unknowns.x, unknowns.v, unknowns.a
    for free in range(nodes.size):
        for k in range(3):
            i, j = 3 * nodes[free] + k, 6 * free + 2 * k
            x[i], v[i] = origin[i] + y[j], y[j + 1]
    place(time, x, v, net)
    force(time, x, v, a, unknowns.power, net)
    for free in range(nodes.size):
        for k in range(3):
            i, j = 3 * nodes[free] + k, 6 * free + 2 * k
            out[j], out[j + 1] = v[i], a[i]
