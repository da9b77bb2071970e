"""Explicit Runge-Kutta steps for x'' = a(x, v), forwards, backwards and with many changes.

Stages are at x + c_i h v + h² Σ (A²)_ij a_j and v + h Σ A_ij a_j; the last row of the tables is
the result. Free nodes move so; driven ones go on from where they are by what is prescribed, and
others stay.
"""

from typing import NamedTuple

from tissuec.kernels.records import Floats, Rows, Stack
from tissuec.kernels.sensitivity import (
    Laws,
    Links,
    Seeds,
    Values,
    acceleration,
    pull_back,
    push_forward,
)


class Table(NamedTuple):
    """Coefficients; rows of all stages and of the result.

    Attributes:
        for_x, for_v: A² and A, shape (stage + 1, stage).
        nodes: c and 1, shape (stage + 1,).
    """

    for_x: Rows
    for_v: Rows
    nodes: Floats


class Prescribed(NamedTuple):
    """What is prescribed at the beginning of each step, at its stages and at its end.

    Attributes:
        place, speed: Of driven nodes, shape (step, stage + 2, 3 driven).
        load: Changing forces, shape (step, stage + 2, 3 loaded).
    """

    place: Stack
    speed: Stack
    load: Stack


def explicit_stages(
    laws: Laws,
    row: int,
    x: Floats,
    v: Floats,
    h: float,
    table: Table,
    given: Prescribed,
    links: Links,
    values: Values,
    at_x: Rows,
    at_v: Rows,
    a: Rows,
) -> None:
    """Set the states of all stages and of the result, and the accelerations of the stages.

    Args:
        row: Number of the step.
        at_x, at_v: Shape (stage + 1, 3 node).
        a: Shape (stage, 3 node).
    """
    stages = a.shape[0]
    for i in range(stages + 1):
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for k in range(3 * node, 3 * node + 3):
                at_x[i, k], at_v[i, k] = x[k], 0.0
                if free:
                    first, second = 0.0, 0.0
                    for j in range(i):
                        first += table.for_v[i, j] * a[j, k]
                        second += table.for_x[i, j] * a[j, k]
                    at_x[i, k] = x[k] + h * table.nodes[i] * v[k] + h * h * second
                    at_v[i, k] = v[k] + h * first
        for d in range(links.driven.size):
            for axis in range(3):
                k, m = 3 * links.driven[d] + axis, 3 * d + axis
                at_x[i, k] += given.place[row, i + 1, m] - given.place[row, 0, m]
                at_v[i, k] = given.speed[row, i + 1, m]
        if i < stages:
            acceleration(laws, at_x[i], at_v[i], given.load[row, i + 1], links, values, a[i])


def explicit_forward(
    laws: Laws,
    times: Floats,
    trail_x: Rows,
    trail_v: Rows,
    table: Table,
    given: Prescribed,
    links: Links,
    values: Values,
    at_x: Rows,
    at_v: Rows,
    a: Rows,
) -> None:
    """Fill the rows of a trail behind the first one."""
    last = a.shape[0]
    for row in range(times.size - 1):
        h = times[row + 1] - times[row]
        explicit_stages(
            laws, row, trail_x[row], trail_v[row], h, table, given, links, values, at_x, at_v, a
        )
        for k in range(trail_x.shape[1]):
            trail_x[row + 1, k], trail_v[row + 1, k] = at_x[last, k], at_v[last, k]


def explicit_back(
    laws: Laws,
    times: Floats,
    trail_x: Rows,
    trail_v: Rows,
    table: Table,
    given: Prescribed,
    links: Links,
    values: Values,
    enter_x: Rows,
    enter_v: Rows,
    lx: Floats,
    lv: Floats,
    at_x: Rows,
    at_v: Rows,
    a: Rows,
    by_x: Rows,
    by_v: Rows,
    weight: Floats,
    by: Values,
) -> None:
    """Carry derivatives by the last row of a trail back to its first row.

    Args:
        enter_x, enter_v: Derivatives that enter in each row, shape (row, 3 node); those of the
            first row are left for the caller.
        lx, lv: By the state of the last row, then of the first one, shape (3 node,).
        by_x, by_v: Room, shape (stage + 1, 3 node).
        by: What is added to the derivatives by numbers.
    """
    stages = a.shape[0]
    for row in range(times.size - 2, -1, -1):
        h = times[row + 1] - times[row]
        explicit_stages(
            laws, row, trail_x[row], trail_v[row], h, table, given, links, values, at_x, at_v, a
        )
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for k in range(3 * node, 3 * node + 3):
                by_x[stages, k] = lx[k] + enter_x[row + 1, k]
                by_v[stages, k] = lv[k] + enter_v[row + 1, k] if free else 0.0
        for i in range(stages - 1, -1, -1):
            for node in range(links.inverse.size):
                free = links.inverse[node] > 0.0
                for k in range(3 * node, 3 * node + 3):
                    total = 0.0
                    if free:
                        for j in range(i + 1, stages + 1):
                            total += h * h * table.for_x[j, i] * by_x[j, k]
                            total += h * table.for_v[j, i] * by_v[j, k]
                    weight[k], by_x[i, k], by_v[i, k] = total, 0.0, 0.0
            pull_back(laws, at_x[i], at_v[i], a[i], weight, links, values, by_x[i], by_v[i], by)
            for node in range(links.inverse.size):
                if links.inverse[node] == 0.0:
                    for k in range(3 * node, 3 * node + 3):
                        by_v[i, k] = 0.0
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for k in range(3 * node, 3 * node + 3):
                of_x, of_v = 0.0, 0.0
                for j in range(stages + 1):
                    of_x += by_x[j, k]
                    of_v += by_v[j, k] + h * table.nodes[j] * by_x[j, k]
                lx[k], lv[k] = of_x, of_v if free else 0.0


def explicit_change(
    first: int,
    last: int,
    laws: Laws,
    times: Floats,
    trail_x: Rows,
    trail_v: Rows,
    table: Table,
    given: Prescribed,
    links: Links,
    values: Values,
    seeds: Seeds,
    tx: Rows,
    tv: Rows,
    at_x: Rows,
    at_v: Rows,
    a: Rows,
    part: Floats,
    moved_x: Rows,
    moved_v: Rows,
    known: Stack,
) -> None:
    """Carry many changes of the state over the steps from one row of a trail to a later one.

    Args:
        first, last: The rows.
        tx, tv: Changes, shape (3 node, change); set anew.
        moved_x, moved_v: Room, shape (3 node, change).
        known: Room for the changes of accelerations, shape (stage, 3 node, change).
    """
    stages, count = a.shape[0], part.size
    for step in range(first, last):
        h, x, v = times[step + 1] - times[step], trail_x[step], trail_v[step]
        explicit_stages(laws, step, x, v, h, table, given, links, values, at_x, at_v, a)
        for i in range(stages + 1):
            for node in range(links.inverse.size):
                free = links.inverse[node] > 0.0
                for k in range(3 * node, 3 * node + 3):
                    for m in range(count):
                        moved_x[k, m], moved_v[k, m] = tx[k, m], 0.0
                    if free:
                        for m in range(count):
                            moved_x[k, m] += h * table.nodes[i] * tv[k, m]
                            moved_v[k, m] = tv[k, m]
                        for j in range(i):
                            of_x, of_v = h * h * table.for_x[i, j], h * table.for_v[i, j]
                            if of_x != 0.0 or of_v != 0.0:
                                for m in range(count):
                                    moved_x[k, m] += of_x * known[j, k, m]
                                    moved_v[k, m] += of_v * known[j, k, m]
            if i < stages:
                push_forward(
                    laws,
                    at_x[i],
                    at_v[i],
                    a[i],
                    moved_x,
                    moved_v,
                    links,
                    values,
                    seeds,
                    part,
                    known[i],
                )
        for k in range(tx.shape[0]):
            for m in range(count):
                tx[k, m], tv[k, m] = moved_x[k, m], moved_v[k, m]
