"""Linear combinations of the stages of a step, as loops to be compiled.

The columns of a tableau are weights of rows. Row 0 is v / h and row 1 the acceleration, both at
the start of the step; row ``Work.end_row`` is the acceleration at its end. These three are not
copied but read from ``Work.v`` and ``Work.a``. ``Work.rows`` contains the other rows, under the
same numbers.

Memory bandwidth limits large nets. So positions and velocities are computed in one loop.

Shared arguments:
    part, parts: Index of this thread's share of the loop, and the number of shares.
    h: Size of the step [s].
    current: Half of ``work`` that contains the start of the step, 0 or 1; the end is in the
        other.
    weights, for_x, for_v: Weights of rows, dimensionless, shape (row,); those of zero weight
        are not read.
    base, base_x, base_v: Vectors that are added to, shape (3 node,).
    factor: Of all weights.
    blend: Scratch, shape (node,); its size is the number of nodes that count.
    begin: The first of them.
    start, stop: Range of components, ``stop`` excluded.
    work: State and scratch of the run; its fields give the shapes and units.
"""

from math import sqrt

from tissuec.kernels.records import Floats, Rows, Work
from tissuec.kernels.thread_loops import PIECE, part_of, share
from tissuec.kernels.vectors import TINY, greater, greatest

# Components that are combined at a time: what is set stays in the cache while all rows are
# added to it, and each row is long enough for the processor to read ahead.
STRETCH = 12 * PIECE


def combine(
    base_x: Floats,
    base_v: Floats,
    h: float,
    for_x: Floats,
    for_v: Floats,
    current: int,
    x: Floats,
    v: Floats,
    work: Work,
) -> None:
    """Set x = base_x + h² Σ for_x_j row_j and v = base_v + h Σ for_v_j row_j.

    Args:
        x, v: Vectors that are set, shape (3 node,).
    """
    share(work.team, combine_part, (base_x, base_v, h, for_x, for_v, current, x, v, work))


def combine_part(
    part: int,
    parts: int,
    base_x: Floats,
    base_v: Floats,
    h: float,
    for_x: Floats,
    for_v: Floats,
    current: int,
    x: Floats,
    v: Floats,
    work: Work,
) -> None:
    """Apply ``combine`` to a part of the nodes."""
    first, last = part_of(part, parts, x.size // 3)
    for start in range(3 * first, 3 * last, STRETCH):
        stop = min(start + STRETCH, 3 * last)
        own = slice(start, stop)
        add_rows(base_x[own], h * h, h, for_x, start, stop, current, x[own], work)
        add_rows(base_v[own], h, h, for_v, start, stop, current, v[own], work)


def add_rows(
    base: Floats,
    factor: float,
    h: float,
    weights: Floats,
    start: int,
    stop: int,
    current: int,
    out: Floats,
    work: Work,
) -> None:
    """Set out = base + factor Σ weights_j row_j.

    Args:
        out: Vector that is set, as long as the range of components.
    """
    last, end, part = weights.size - 1, work.end_row, slice(start, stop)
    # Views that are indexed from 0 let the compiler use vector instructions, and so does one
    # loop for each of both bases. What has no weight is not read: another vector is.
    one, a = work.a[current, part], factor * weights[1]
    two, b = work.v[current, part], factor / h * weights[0]
    three, c = work.a[1 - current, part], factor * weights[end]
    j = following(weights, 1, end)
    if b == 0.0:
        two, b = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
        j = following(weights, j, end)
    if c == 0.0:
        three, c = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
        j = following(weights, j, end)
    four, d = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
    for i in range(out.size):
        out[i] = base[i] + ((a * one[i] + b * two[i]) + (c * three[i] + d * four[i]))
    j = following(weights, j, end)
    while j <= last:
        # Four rows at a time, for less traffic; what is missing has no weight.
        one, a = work.rows[j, part], factor * weights[j]
        j = following(weights, j, end)
        two, b = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
        j = following(weights, j, end)
        three, c = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
        j = following(weights, j, end)
        four, d = (work.rows[j, part], factor * weights[j]) if j <= last else (one, 0.0)
        for i in range(out.size):
            out[i] += (a * one[i] + b * two[i]) + (c * three[i] + d * four[i])
        j = following(weights, j, end)


def following(weights: Floats, number: int, end: int) -> int:
    """Return the next row of ``Work.rows`` that has a weight, or the number of rows.

    Args:
        number: Of the row to begin after.
        end: That of the acceleration at the end of the step, which is elsewhere.
    """
    number += 1
    while number < weights.size and (weights[number] == 0.0 or number == end):
        number += 1
    return number


def blended_errors(h: float, current: int, blend: Floats, begin: int, work: Work) -> None:
    """Set ``work.errors`` to the largest e5² / √(e5² + 0.01 e3²) over nodes; NaN if one is NaN.

    e5 and e3 are the two estimates of ``work.tableau``, of positions and of velocities.
    """
    work.errors[0] = work.errors[1] = 0.0
    if blend.size:  # most nets have no internal variables
        share(work.team, blended_part, (h, current, blend, begin, work))
        work.errors[0] = greatest(work.team.found[0])
        work.errors[1] = greatest(work.team.found[1])


def blended_part(
    part: int, parts: int, h: float, current: int, blend: Floats, begin: int, work: Work
) -> None:
    """Find the largest blended errors of a part of the nodes."""
    first, last = part_of(part, parts, blend.size)
    in_x = in_v = 0.0
    for start in range(first, last, STRETCH // 3):
        size = min(STRETCH // 3, last - start)
        # The same scratch for all stretches stays in the cache, and so do rows from x to v.
        nodes, own = slice(first, first + size), slice(3 * first, 3 * (first + size))
        few, five, three = blend[nodes], work.trial_x[own], work.trial_v[own]
        low, of_x, of_v = 3 * (begin + start), work.tableau.error_x, work.tableau.error_v
        in_x = greater(in_x, blended(h * h, h, of_x, low, current, few, five, three, work))
        in_v = greater(in_v, blended(h, h, of_v, low, current, few, five, three, work))
    work.team.found[0, part], work.team.found[1, part] = in_x, in_v


def blended(
    factor: float,
    h: float,
    weights: Rows,
    start: int,
    current: int,
    blend: Floats,
    fifth: Floats,
    third: Floats,
    work: Work,
) -> float:
    """Return the largest blended error of successive nodes; NaN if one is NaN.

    Args:
        weights: Of both estimates, dimensionless, shape (2, row).
        start: Component that they begin with.
        fifth, third: Scratch of as many nodes, shape (3 node,).
    """
    stop, zero = start + fifth.size, work.zero[: fifth.size]
    add_rows(zero, factor, h, weights[0], start, stop, current, fifth, work)
    add_rows(zero, factor, h, weights[1], start, stop, current, third, work)
    for node in range(blend.size):
        i = 3 * node
        five = fifth[i] ** 2 + fifth[i + 1] ** 2 + fifth[i + 2] ** 2
        three = third[i] ** 2 + third[i + 1] ** 2 + third[i + 2] ** 2
        blend[node] = five / (sqrt(five + 0.01 * three) + TINY)
    return greatest(blend)
