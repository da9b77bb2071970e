"""Operations of step loops on vectors of all nodes, as scalar loops to be compiled.

Vectors have the shape (3 node,) unless another one is given, and may have any unit that makes
the formula consistent.

Shared arguments:
    factor: Scalar factor.
    vector, one, two: Vectors in any unit, shape (3 node,).
    out: Vector that is set, in any unit, shape (3 node,).
    squares: Scratch in any unit, shape (node,).
    values: In any unit, shape (n,).
"""

from math import sqrt

import numpy as np

from tissuec.kernels.records import Buffer, Floats, Rows, Team
from tissuec.kernels.thread_loops import PIECE, part_of, share

# Added to a length before dividing, which leaves any that is not squared to zero what it is.
TINY = 1e-200
UNSIGNED = 0x7FFF_FFFF_FFFF_FFFF  # all bits of a number but its sign


def is_passed(before: Rows, after: Rows) -> bool:
    """Return whether any spring has passed a corner between two states.

    Args:
        before, after: Sides of corners, dimensionless, shape (3, spring).
    """
    for row in range(3):
        for s in range(before.shape[1]):
            if before[row, s] != after[row, s]:
                return True
    return False


def scale(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = factor vector."""
    for i in range(out.size):
        out[i] = factor * vector[i]


def greater(one: float, two: float) -> float:
    """Return the larger of two numbers, and NaN if either is NaN."""
    return max(one, two) + 0.0 * (one + two)


def polynomials(table: Rows, part: float, out: Floats) -> None:
    """Set out_j = Σ_k table[k, j] part^(k + 1).

    Args:
        table: Coefficients, dimensionless, shape (power, row).
        part: Argument of the polynomials, dimensionless.
        out: Values, shape (row,).
    """
    for j in range(out.size):
        value = 0.0
        for k in range(table.shape[0] - 1, -1, -1):
            value = (value + table[k, j]) * part
        out[j] = value


def quadrature(base: Floats, factor: float, weights: Floats, power: Rows, out: Floats) -> None:
    """Set out = base + factor Σ weights_j power_j for the two columns of the ledger.

    Args:
        base: Energies [J], shape (2,).
        factor: Size of the step [s].
        weights: Dimensionless, shape (row,).
        power: Powers of the stages [W], shape (row, 2).
        out: Energies [J], shape (2,).
    """
    for k in range(2):
        total = 0.0
        for j in range(weights.size):
            total += weights[j] * power[j, k]
        out[k] = base[k] + factor * total


def drift(
    x: Floats, v: Floats, a: Floats, h: float, x_end: Floats, v_end: Floats, team: Team
) -> None:
    """Set x_end = x + h v + h²/2 a and v_end = v + h a."""
    share(team, drift_part, (x, v, a, h, x_end, v_end))


def drift_part(
    part: int,
    parts: int,
    x: Floats,
    v: Floats,
    a: Floats,
    h: float,
    x_end: Floats,
    v_end: Floats,
) -> None:
    """Apply ``drift`` to a part of the nodes."""
    first, last = part_of(part, parts, x.size // 3)
    own, half = slice(3 * first, 3 * last), 0.5 * h * h
    x, v, a, x_end, v_end = x[own], v[own], a[own], x_end[own], v_end[own]
    for i in range(x.size):
        x_end[i] = x[i] + h * v[i] + half * a[i]
        v_end[i] = v[i] + h * a[i]


def correct(
    a: Floats, a_end: Floats, h: float, v_end: Floats, squares: Floats, team: Team
) -> float:
    """Set v_end = v_end + h/2 (a_end - a), the velocities after those that ``drift`` predicts.

    Args:
        squares: Scratch, as for ``distance``.

    Returns:
        The largest |a_end - a| of a node; NaN if one is NaN.
    """
    if not squares.size:
        return 0.0  # most nets have no internal variables
    share(team, correct_part, (a, a_end, h, v_end, squares, team))
    return sqrt(greatest(team.found[0]))


def correct_part(
    part: int,
    parts: int,
    a: Floats,
    a_end: Floats,
    h: float,
    v_end: Floats,
    squares: Floats,
    team: Team,
) -> None:
    """Apply ``correct`` to a part of the nodes."""
    begin, end = part_of(part, parts, squares.size)
    most, half = 0.0, 0.5 * h
    for first in range(begin, end, PIECE):
        last = min(first + PIECE, end)
        own = slice(3 * first, 3 * last)
        before, after, v = a[own], a_end[own], v_end[own]
        piece = squares[begin : begin + last - first]
        for node in range(piece.size):
            i = 3 * node
            d0, d1, d2 = (
                after[i] - before[i],
                after[i + 1] - before[i + 1],
                after[i + 2] - before[i + 2],
            )
            v[i] += half * d0
            v[i + 1] += half * d1
            v[i + 2] += half * d2
            piece[node] = d0 * d0 + d1 * d1 + d2 * d2
        most = greater(most, greatest(piece))
    team.found[0, part] = most


def accumulate(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = out + factor vector."""
    for i in range(out.size):
        out[i] += factor * vector[i]


def subtract(one: Floats, two: Floats, out: Floats) -> None:
    """Set out = one - two."""
    for i in range(out.size):
        out[i] = one[i] - two[i]


def between(one: Floats, two: Floats, factor: float, out: Floats) -> None:
    """Set out = factor (two - one)."""
    for i in range(out.size):
        out[i] = factor * (two[i] - one[i])


def distance(one: Floats, two: Floats, squares: Floats, team: Team) -> float:
    """Return the largest distance between the nodes of two vectors; NaN if one is NaN.

    Args:
        one, two: In any unit, shape (3 node,), or longer.
        squares: Scratch, shape (node,); its size limits which nodes count.
    """
    if not squares.size:
        return 0.0  # most nets have no internal variables
    share(team, distance_part, (one, two, squares, team))
    return sqrt(greatest(team.found[0]))


def distance_part(
    part: int, parts: int, one: Floats, two: Floats, squares: Floats, team: Team
) -> None:
    """Find the square of the largest distance in a part of the nodes."""
    first, last = part_of(part, parts, squares.size)
    most = 0.0
    for start in range(first, last, PIECE):
        stop = min(start + PIECE, last)
        # The same scratch for all pieces stays in the cache.
        own, near, piece = (
            one[3 * start : 3 * stop],
            two[3 * start : 3 * stop],
            squares[first : first + stop - start],
        )
        for node in range(piece.size):
            i = 3 * node
            d0, d1, d2 = own[i] - near[i], own[i + 1] - near[i + 1], own[i + 2] - near[i + 2]
            piece[node] = d0 * d0 + d1 * d1 + d2 * d2
        most = greater(most, greatest(piece))
    team.found[0, part] = most


def length(vector: Floats, squares: Floats, team: Team) -> float:
    """Return the largest length of the parts of a vector for each node; NaN if one is NaN.

    Args:
        vector: In any unit, shape (3 node,), or longer.
        squares: Scratch, as for ``distance``.
    """
    if not squares.size:
        return 0.0  # most nets have no internal variables
    share(team, length_part, (vector, squares, team))
    return sqrt(greatest(team.found[0]))


def length_part(part: int, parts: int, vector: Floats, squares: Floats, team: Team) -> None:
    """Find the square of the largest length in a part of the nodes."""
    first, last = part_of(part, parts, squares.size)
    most = 0.0
    for start in range(first, last, PIECE):
        stop = min(start + PIECE, last)
        own, piece = vector[3 * start : 3 * stop], squares[first : first + stop - start]
        for node in range(piece.size):
            i = 3 * node
            piece[node] = own[i] * own[i] + own[i + 1] * own[i + 1] + own[i + 2] * own[i + 2]
        most = greater(most, greatest(piece))
    team.found[0, part] = most


def greatest(values: Floats) -> float:
    """Return the largest of non-negative values; NaN if one is NaN. Overwrites the first value.

    The order of non-negative floating-point numbers is that of their bits, followed by infinity
    and NaN; the maximum of integers is about four times as fast.
    """
    bits = values.view(np.int64)
    most = 0
    for i in range(bits.size):
        most = max(most, bits[i] & UNSIGNED)
    if bits.size:
        bits[0] = most
        return values[0]
    return 0.0


def copy_sample(
    x: Floats, v: Floats, ledger: Floats, error: float, index: int, buffer: Buffer
) -> None:
    """Copy a state into the buffer as sample ``index``.

    Args:
        ledger: Work and dissipated energy [J], shape (2,).
        error: Estimated error of positions [m].
        index: Row of the buffer.
    """
    for i in range(x.size):
        buffer.position[index, i] = x[i]
        buffer.velocity[index, i] = v[i]
    buffer.ledger[index, 0] = ledger[0]
    buffer.ledger[index, 1] = ledger[1]
    buffer.error[index] = error
