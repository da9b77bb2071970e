"""Active fibres as scalar loops; for the equations see ``solids.activation``."""

from math import sqrt
from typing import NamedTuple

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, IntegerRows, Rows, Stack


class ActivationTable(NamedTuple):
    """Lines of active fibres; a line is a family of fibres at a point of an element."""

    acts: BoundaryConditions  # of its only one, the first component is the stress [Pa]
    nodes: IntegerRows  # shape (element, node)
    slopes: Stack  # of shape functions along lines [1/m], shape (element, line, node)
    weight: Rows  # volume of each line [m³], shape (element, line)
    low: float  # stretch up to which fibres are too short for any stress
    high: float  # stretch from which they are too long; below ``low`` where neither counts


def contract_fibres(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: ActivationTable
) -> None:
    """Add the forces of active fibres to those on nodes, and the power that they supply.

    Args:
        table: The fibres.
    """
    stress, _, _, _, _, _ = total(0, time, table.acts)
    for e in range(table.nodes.shape[0]):
        for line in range(table.weight.shape[1]):
            slopes = table.slopes[e, line]
            b0, b1, b2, r0, r1, r2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for a in range(slopes.size):
                i, slope = 3 * table.nodes[e, a], slopes[a]
                b0, b1, b2 = b0 + slope * x[i], b1 + slope * x[i + 1], b2 + slope * x[i + 2]
                r0, r1, r2 = r0 + slope * v[i], r1 + slope * v[i + 1], r2 + slope * v[i + 2]
            stretch = sqrt(b0 * b0 + b1 * b1 + b2 * b2)
            pull = stress * table.weight[e, line] * share_of(stretch, table.low, table.high)
            if pull == 0.0 or stretch == 0.0:
                continue
            pull /= stretch
            b0, b1, b2 = pull * b0, pull * b1, pull * b2
            power[0] -= b0 * r0 + b1 * r1 + b2 * r2
            for a in range(slopes.size):
                i, slope = 3 * table.nodes[e, a], slopes[a]
                f[i] -= slope * b0
                f[i + 1] -= slope * b1
                f[i + 2] -= slope * b2


def share_of(stretch: float, low: float, high: float) -> float:
    """Return the part of the stress that fibres have at a stretch.

    Args:
        stretch: Length over length without stress.
        low, high: See ``ActivationTable``.
    """
    if high <= low:
        return 1.0
    q = (2.0 * stretch - low - high) / (high - low)
    if q <= -1.0 or q >= 1.0:
        return 0.0
    return (1.0 - q * q) * (1.0 - q * q)
