"""Operations of step loops on vectors of all nodes, as scalar loops to be compiled.

Vectors have the shape (3 node,) unless another one is given, and may have any unit that makes
the formula consistent.

Shared arguments:
    to, at, factor: Scalar factors.
    weights, further: Weights of the rows, shape (row,); rows of zero weight are not read.
    rows: Vectors, shape (row, 3 node).
    base, vector, one, two, less: Vectors in any unit, shape (3 node,).
    out, out_x, out_v: Vectors that are set, in any unit, shape (3 node,).
    start, stop: Range of components, ``stop`` excluded.
    squares, blend: Scratch in any unit, shape (node,).
    fifth, third: Error estimates e5 and e3 in any unit, shape (3 node,).
    zero: Zeros, shape (3 node,).
    values: In any unit, shape (n,).
"""

from math import sqrt

import numpy as np

from tissuec.kernels.records import Buffer, Floats, Rows, Team
from tissuec.kernels.thread_loops import PIECE, part_of, share

# Added to a length before dividing, which leaves any that is not squared to zero what it is.
TINY = 1e-200
# Components that are combined at a time: what is set stays in the cache while all rows are
# added to it, and each row is long enough for the processor to read ahead.
STRETCH = 12 * PIECE
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


def combine(
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Rows,
    out_x: Floats,
    out_v: Floats,
    team: Team,
) -> None:
    """Set out_x = x + to Σ weights_j rows_j and out_v = v + at Σ further_j rows_j.

    Both are set in one loop, because large nets are limited by memory bandwidth.
    """
    share(team, combine_part, (x, to, weights, v, at, further, rows, out_x, out_v))


def combine_part(
    part: int,
    parts: int,
    x: Floats,
    to: float,
    weights: Floats,
    v: Floats,
    at: float,
    further: Floats,
    rows: Rows,
    out_x: Floats,
    out_v: Floats,
) -> None:
    """Apply ``combine`` to a part of the nodes."""
    first, last = part_of(part, parts, out_x.size // 3)
    for start in range(3 * first, 3 * last, STRETCH):
        stop = min(start + STRETCH, 3 * last)
        piece = slice(start, stop)
        add_rows(x[piece], to, weights, rows, start, stop, out_x[piece])
        add_rows(v[piece], at, further, rows, start, stop, out_v[piece])


def add_rows(
    base: Floats,
    factor: float,
    weights: Floats,
    rows: Rows,
    start: int,
    stop: int,
    out: Floats,
) -> None:
    """Set out = base + factor Σ weights_j rows_j, both being as long as the range of rows."""
    count, last, part = rows.shape[0], rows.shape[0] - 1, slice(start, stop)
    j, begun = following(weights, -1), False
    while j < count or not begun:
        # Four rows at a time, for less traffic; those past the last have no weight.
        k = following(weights, j)
        m = following(weights, k)
        n = following(weights, m)
        a = factor * weights[j] if j < count else 0.0
        b = factor * weights[k] if k < count else 0.0
        c = factor * weights[m] if m < count else 0.0
        d = factor * weights[n] if n < count else 0.0
        # Views that are indexed from 0 let the compiler use vector instructions, and so does
        # one loop for each of both bases.
        one, two = rows[min(j, last), part], rows[min(k, last), part]
        three, four = rows[min(m, last), part], rows[min(n, last), part]
        if begun:
            for i in range(out.size):
                out[i] += (a * one[i] + b * two[i]) + (c * three[i] + d * four[i])
        else:
            for i in range(out.size):
                out[i] = base[i] + ((a * one[i] + b * two[i]) + (c * three[i] + d * four[i]))
        j, begun = following(weights, n), True


def following(weights: Floats, row: int) -> int:
    """Return the next row with a weight that is not zero, or the number of rows.

    Args:
        weights: Dimensionless or in any unit, shape (row,).
        row: Row to begin after.
    """
    row += 1
    while row < weights.size and weights[row] == 0.0:
        row += 1
    return row


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


def kick(v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats, team: Team) -> None:
    """Set v_end = v + h/2 (a + a_end)."""
    share(team, kick_part, (v, a, a_end, h, v_end))


def kick_part(
    part: int, parts: int, v: Floats, a: Floats, a_end: Floats, h: float, v_end: Floats
) -> None:
    """Apply ``kick`` to a part of the nodes."""
    first, last = part_of(part, parts, v.size // 3)
    own, half = slice(3 * first, 3 * last), 0.5 * h
    v, a, a_end, v_end = v[own], a[own], a_end[own], v_end[own]
    for i in range(v.size):
        v_end[i] = v[i] + half * (a[i] + a_end[i])


def accumulate(factor: float, vector: Floats, out: Floats) -> None:
    """Set out = out + factor vector."""
    for i in range(out.size):
        out[i] += factor * vector[i]


def subtract(one: Floats, two: Floats, out: Floats) -> None:
    """Set out = one - two."""
    for i in range(out.size):
        out[i] = one[i] - two[i]


def between(one: Floats, two: Floats, factor: float, less: Floats, out: Floats) -> None:
    """Set out = factor (two - one) - less."""
    for i in range(out.size):
        out[i] = factor * (two[i] - one[i]) - less[i]


def distance(one: Floats, two: Floats, squares: Floats, team: Team) -> float:
    """Return the largest distance between the nodes of two vectors; NaN if one is NaN.

    Args:
        one, two: In any unit, shape (3 node,), or longer.
        squares: Scratch, shape (node,); its size tells which nodes count.
    """
    if not squares.size:
        return 0.0  # most nets have no hidden nodes
    share(team, distance_part, (one, two, squares, team))
    return sqrt(greatest(team.found))


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
    team.found[part] = most


def length(vector: Floats, squares: Floats, team: Team) -> float:
    """Return the largest length of the parts of a vector for each node; NaN if one is NaN.

    Args:
        vector: In any unit, shape (3 node,), or longer.
        squares: Scratch, as for ``distance``.
    """
    if not squares.size:
        return 0.0  # most nets have no hidden nodes
    share(team, length_part, (vector, squares, team))
    return sqrt(greatest(team.found))


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
    team.found[part] = most


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


def blended_error(
    factor: float,
    weights: Floats,
    further: Floats,
    rows: Rows,
    zero: Floats,
    fifth: Floats,
    third: Floats,
    blend: Floats,
    begin: int,
    team: Team,
) -> float:
    """Return the largest e5² / √(e5² + 0.01 e3²) over nodes; NaN if one is NaN.

    e5 = factor Σ weights_j rows_j and e3 = factor Σ further_j rows_j are not left in memory,
    because large nets are limited by memory bandwidth.

    Args:
        fifth, third: Scratch.
        blend: Scratch; its size tells how many nodes count.
        begin: The first of them.
    """
    if not blend.size:
        return 0.0  # most nets have no hidden nodes
    scratch = zero, fifth, third, blend
    share(team, blended_part, (factor, weights, further, rows, *scratch, begin, team))
    return greatest(team.found)


def blended_part(
    part: int,
    parts: int,
    factor: float,
    weights: Floats,
    further: Floats,
    rows: Rows,
    zero: Floats,
    fifth: Floats,
    third: Floats,
    blend: Floats,
    begin: int,
    team: Team,
) -> None:
    """Find the largest blended error of a part of the nodes.

    Args:
        begin: The first of all nodes that count.
    """
    first, last = part_of(part, parts, blend.size)
    most = 0.0
    for start in range(first, last, STRETCH // 3):
        stop = min(start + STRETCH // 3, last)
        # The same scratch for all stretches stays in the cache.
        size, own = stop - start, slice(3 * first, 3 * (first + stop - start))
        five, three, piece = fifth[own], third[own], blend[first : first + size]
        low, high = 3 * (begin + start), 3 * (begin + stop)
        add_rows(zero[: 3 * size], factor, weights, rows, low, high, five)
        add_rows(zero[: 3 * size], factor, further, rows, low, high, three)
        blend_nodes(five, three, piece)
        most = greater(most, greatest(piece))
    team.found[part] = most


def blend_nodes(fifth: Floats, third: Floats, blend: Floats) -> None:
    """Set e5² / √(e5² + 0.01 e3²) of each node."""
    for node in range(blend.size):
        i = 3 * node
        five = fifth[i] ** 2 + fifth[i + 1] ** 2 + fifth[i + 2] ** 2
        three = third[i] ** 2 + third[i + 1] ** 2 + third[i + 2] ** 2
        blend[node] = five / (sqrt(five + 0.01 * three) + TINY)


def copy_sample(
    x: Floats, v: Floats, ledger: Floats, error: float, index: int, buffer: Buffer
) -> None:
    """Copy a state into the buffer as sample ``index``.

    Args:
        ledger: Work and dissipated energy [J], shape (2,).
        error: Estimated error of positions [m].
        index: Row of the buffer.
        buffer: The buffer.
    """
    for i in range(x.size):
        buffer.position[index, i] = x[i]
        buffer.velocity[index, i] = v[i]
    buffer.ledger[index, 0] = ledger[0]
    buffer.ledger[index, 1] = ledger[1]
    buffer.error[index] = error
