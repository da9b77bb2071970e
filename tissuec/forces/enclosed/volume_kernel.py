"""Enclosed volumes as scalar loops; for the equations see ``enclosed.volume``."""

from typing import NamedTuple

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, IntegerRows, Integers


class CellTable(NamedTuple):
    """The cells of a body, whose faces have four corners and face outwards."""

    acts: BoundaryConditions  # of its only one, the first component is the relative change
    corners: IntegerRows  # nodes of the faces, shape (face, 4)
    first: Integers  # faces of a cell are first[cell]:first[cell + 1], shape (cell + 1,)
    drawn: Floats  # volumes [m³], shape (cell,)
    modulus: Floats  # [Pa], shape (cell,)
    share: float  # see ``enclosed.volume.Enclosure``


def press(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, cells: CellTable
) -> None:
    """Add the forces of enclosed volumes to those on nodes, and the power of pumps.

    Args:
        cells: The enclosed volumes.
    """
    corners = cells.corners
    swell, _, _, rate, _, _ = total(0, time, cells.acts)
    for cell in range(cells.drawn.size):
        start, stop = cells.first[cell], cells.first[cell + 1]
        o, volume = 3 * corners[start, 0], 0.0
        for face in range(start, stop):
            i, j = 3 * corners[face, 0], 3 * corners[face, 1]
            k, m = 3 * corners[face, 2], 3 * corners[face, 3]
            s0, s1, s2, p0, p1, p2, q0, q1, q2 = spans(i, j, k, m, o, x)
            volume += s0 * (p1 * q2 - p2 * q1)
            volume += s1 * (p2 * q0 - p0 * q2)
            volume += s2 * (p0 * q1 - p1 * q0)
        drawn = cells.drawn[cell]
        due = drawn * (1.0 + swell)
        pressure = cells.modulus[cell] * (due - volume / 24.0) / drawn
        power[0] += pressure * drawn * rate
        share = pressure / 24.0
        for face in range(start, stop):
            i, j = 3 * corners[face, 0], 3 * corners[face, 1]
            k, m = 3 * corners[face, 2], 3 * corners[face, 3]
            s0, s1, s2, p0, p1, p2, q0, q1, q2 = spans(i, j, k, m, o, x)
            # By the sum of the corners, and by one diagonal and the other.
            a0, a1, a2 = p1 * q2 - p2 * q1, p2 * q0 - p0 * q2, p0 * q1 - p1 * q0
            b0, b1, b2 = q1 * s2 - q2 * s1, q2 * s0 - q0 * s2, q0 * s1 - q1 * s0
            c0, c1, c2 = s1 * p2 - s2 * p1, s2 * p0 - s0 * p2, s0 * p1 - s1 * p0
            f[i] += share * (a0 - b0)
            f[i + 1] += share * (a1 - b1)
            f[i + 2] += share * (a2 - b2)
            f[j] += share * (a0 - c0)
            f[j + 1] += share * (a1 - c1)
            f[j + 2] += share * (a2 - c2)
            f[k] += share * (a0 + b0)
            f[k + 1] += share * (a1 + b1)
            f[k + 2] += share * (a2 + b2)
            f[m] += share * (a0 + c0)
            f[m + 1] += share * (a1 + c1)
            f[m + 2] += share * (a2 + c2)


def spans(i: int, j: int, k: int, m: int, o: int, x: Floats) -> tuple[float, ...]:
    """Return s, p and q of a face relative to a node of its cell [m].

    Args:
        i, j, k, m: Indices of the first components of its corners in ``x``.
        o: The same of that node.
        x: Positions of all nodes [m], flat, shape (3 node,).
    """
    z0, z1, z2 = x[o], x[o + 1], x[o + 2]
    return (
        (x[i] - z0) + (x[j] - z0) + (x[k] - z0) + (x[m] - z0),
        (x[i + 1] - z1) + (x[j + 1] - z1) + (x[k + 1] - z1) + (x[m + 1] - z1),
        (x[i + 2] - z2) + (x[j + 2] - z2) + (x[k + 2] - z2) + (x[m + 2] - z2),
        x[k] - x[i], x[k + 1] - x[i + 1], x[k + 2] - x[i + 2],
        x[m] - x[j], x[m + 1] - x[j + 1], x[m + 2] - x[j + 2],
    )  # fmt: skip
