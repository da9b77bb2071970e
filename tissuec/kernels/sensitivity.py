"""Forces of springs with their derivatives, and velocity Verlet forwards and backwards.

A spring from node i to node j has r = x_j - x_i, L = |r|, n = r/L, e = L - L0, w = n·(v_j -
v_i) and the tension T = f(e) + g(e, w); it acts with T n on i and with -T n on j. A change of
the state changes it by

    δT = T' (n·δr - δL0) + ∂g/∂w (n·δv + v·δn) + ∂f/∂c δc + ∂g/∂d δd,   δn = (δr - n n·δr) / L,

where T' = ∂(f + g)/∂e.

``pull_back`` is the transpose of that, ``push_forward`` does it for many changes at once. To be
translated, as ``scalar`` is; laws that are not linear are called by their addresses, with the
number of a law as the first argument, and of the constant as well for ``by_constant``.
"""

from math import sqrt
from typing import NamedTuple

from tissuec.kernels.records import Floats, Integers, Rows


def of_law(*values: object) -> float:
    """Stand for a law, which compiled code calls by its address."""
    raise TypeError("laws are called by compiled code only")


pull = pull_by_c = pull_by_rest = slope = of_law
brake = brake_by_d = brake_by_e = brake_by_rest = brake_slope = by_constant = of_law


class Laws(NamedTuple):
    """Laws of springs and their partial derivatives, as addresses of compiled functions.

    They are 0 where all springs are linear.
    """

    curved: bool  # some springs have laws that are not linear
    brake: int = 0
    brake_by_d: int = 0
    brake_by_e: int = 0
    brake_by_rest: int = 0
    brake_slope: int = 0
    by_constant: int = 0
    pull: int = 0
    pull_by_c: int = 0
    pull_by_rest: int = 0
    slope: int = 0


class Links(NamedTuple):
    """What acts between two events.

    Attributes:
        low, high: Nodes of the springs that act, shape (spring,).
        spring: Their numbers in the network, shape (spring,).
        law: Their laws, shape (spring,).
        inverse: 1/m of free nodes, 0 of held ones [1/kg], shape (node,).
        steady: Acceleration by gravity, 0 of held nodes [m/s²], shape (3 node,).
        drag: Ambient damping [N s/m], shape (node,).
        loaded: Nodes with loads that change in time, shape (loaded,).
        driven: Nodes that are moved, shape (driven,).
    """

    low: Integers
    high: Integers
    spring: Integers
    law: Integers
    inverse: Floats
    steady: Floats
    drag: Floats
    loaded: Integers
    driven: Integers


class Values(NamedTuple):
    """Numbers that can be learnt, or their derivatives, in the order of the network.

    Attributes:
        mass: [kg], shape (node,).
        stiffness, damping, rest: c [N/m], d [N s/m], L0 [m], shape (spring,).
        constants: Of laws, shape (constant,).
    """

    mass: Floats
    stiffness: Floats
    damping: Floats
    rest: Floats
    constants: Floats


class Seeds(NamedTuple):
    """How numbers change with parameters, one sparse matrix in rows for each array."""

    mass_rows: Integers
    mass_columns: Integers
    mass: Floats
    stiffness_rows: Integers
    stiffness_columns: Integers
    stiffness: Floats
    damping_rows: Integers
    damping_columns: Integers
    damping: Floats
    rest_rows: Integers
    rest_columns: Integers
    rest: Floats
    constants_rows: Integers
    constants_columns: Integers
    constants: Floats


def acceleration(
    laws: Laws, x: Floats, v: Floats, load: Floats, links: Links, values: Values, a: Floats
) -> None:
    """Set the accelerations of all nodes [m/s²], shape (3 node,)."""
    for i in range(a.size):
        a[i] = 0.0
    for s in range(links.low.size):
        i, j, k, law = 3 * links.low[s], 3 * links.high[s], links.spring[s], links.law[s]
        r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        inverse = 1.0 / length if length > 0.0 else 0.0
        w = r0 * (v[j] - v[i]) + r1 * (v[j + 1] - v[i + 1]) + r2 * (v[j + 2] - v[i + 2])
        w *= inverse
        c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
        tension = c * (length - rest) + d * w
        if laws.curved:
            tension = pull(law, length - rest, c, rest, laws, values)
            tension += brake(law, length - rest, w, d, rest, laws, values)
        tension *= inverse
        a[i] += tension * r0
        a[i + 1] += tension * r1
        a[i + 2] += tension * r2
        a[j] -= tension * r0
        a[j + 1] -= tension * r1
        a[j + 2] -= tension * r2
    for k in range(links.loaded.size):
        i = 3 * links.loaded[k]
        for axis in range(3):
            a[i + axis] += load[3 * k + axis]
    for node in range(links.inverse.size):
        inverse, drag = links.inverse[node], links.drag[node]
        for i in range(3 * node, 3 * node + 3):
            a[i] = links.steady[i] + inverse * (a[i] - drag * v[i])


def pull_back(
    laws: Laws,
    x: Floats,
    v: Floats,
    a: Floats,
    weight: Floats,
    links: Links,
    values: Values,
    by_x: Floats,
    by_v: Floats,
    by: Values,
) -> None:
    """Add to ``by_x``, ``by_v`` and ``by`` the derivatives of Σ weight · a.

    Args:
        a: The accelerations that ``acceleration`` gave, shape (3 node,).
        weight: Shape (3 node,).
    """
    for node in range(links.inverse.size):
        inverse, total = links.inverse[node], 0.0
        if inverse == 0.0:
            continue
        for i in range(3 * node, 3 * node + 3):
            total += weight[i] * (a[i] - links.steady[i])
            by_v[i] -= links.drag[node] * inverse * weight[i]
        by.mass[node] -= inverse * total
    for s in range(links.low.size):
        p, q = links.low[s], links.high[s]
        i, j, k, law = 3 * p, 3 * q, links.spring[s], links.law[s]
        mi, mj = links.inverse[p], links.inverse[q]
        if mi == 0.0 and mj == 0.0:
            continue
        r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        inverse = 1.0 / length if length > 0.0 else 0.0
        n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
        u0, u1, u2 = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
        w = n0 * u0 + n1 * u1 + n2 * u2
        g0 = mi * weight[i] - mj * weight[j]
        g1 = mi * weight[i + 1] - mj * weight[j + 1]
        g2 = mi * weight[i + 2] - mj * weight[j + 2]
        along = n0 * g0 + n1 * g1 + n2 * g2
        c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
        e = length - rest
        tension, steep, brisk = c * e + d * w, c, d
        if laws.curved:
            constants = values.constants
            tension = pull(law, e, c, rest, laws, values)
            tension += brake(law, e, w, d, rest, laws, values)
            steep = slope(law, e, c, rest, laws, values)
            steep += brake_by_e(law, e, w, d, rest, laws, values)
            brisk = brake_slope(law, e, w, d, rest, laws, values)
            by.stiffness[k] += along * pull_by_c(law, e, c, rest, laws, values)
            by.damping[k] += along * brake_by_d(law, e, w, d, rest, laws, values)
            by.rest[k] += along * pull_by_rest(law, e, c, rest, laws, values)
            by.rest[k] += along * brake_by_rest(law, e, w, d, rest, laws, values)
            for m in range(constants.size):
                by.constants[m] += along * by_constant(law, m, e, w, c, d, rest, laws, values)
        else:
            by.stiffness[k] += along * e
            by.damping[k] += along * w
        by.rest[k] -= along * steep
        one, two, three = along * steep, along * brisk * inverse, tension * inverse
        if length == 0.0 and rest == 0.0:
            three = steep  # in all directions alike
        h0 = one * n0 + two * (u0 - w * n0) + three * (g0 - along * n0)
        h1 = one * n1 + two * (u1 - w * n1) + three * (g1 - along * n1)
        h2 = one * n2 + two * (u2 - w * n2) + three * (g2 - along * n2)
        by_x[i] -= h0
        by_x[i + 1] -= h1
        by_x[i + 2] -= h2
        by_x[j] += h0
        by_x[j + 1] += h1
        by_x[j + 2] += h2
        four = along * brisk
        by_v[i] -= four * n0
        by_v[i + 1] -= four * n1
        by_v[i + 2] -= four * n2
        by_v[j] += four * n0
        by_v[j + 1] += four * n1
        by_v[j + 2] += four * n2


def push_forward(
    laws: Laws,
    x: Floats,
    v: Floats,
    a: Floats,
    tx: Rows,
    tv: Rows,
    links: Links,
    values: Values,
    seeds: Seeds,
    part: Floats,
    ta: Rows,
) -> None:
    """Set ``ta`` to the changes of the accelerations for many changes of state and numbers.

    Args:
        tx, tv: Changes of places and velocities, shape (3 node, change).
        part: Room for numbers, shape (change,).
        ta: Shape (3 node, change).
    """
    count = part.size
    for i in range(ta.shape[0]):
        for m in range(count):
            ta[i, m] = 0.0
    for s in range(links.low.size):
        p, q = links.low[s], links.high[s]
        i, j, k, law = 3 * p, 3 * q, links.spring[s], links.law[s]
        if links.inverse[p] == 0.0 and links.inverse[q] == 0.0:
            continue
        r0, r1, r2 = x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        inverse = 1.0 / length if length > 0.0 else 0.0
        n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
        u0, u1, u2 = v[j] - v[i], v[j + 1] - v[i + 1], v[j + 2] - v[i + 2]
        w = n0 * u0 + n1 * u1 + n2 * u2
        c, d, rest = values.stiffness[k], values.damping[k], values.rest[k]
        e, constants = length - rest, values.constants
        tension, steep, brisk, by_c, by_d = c * e + d * w, c, d, e, w
        by_rest = -steep
        if laws.curved:
            tension = pull(law, e, c, rest, laws, values)
            tension += brake(law, e, w, d, rest, laws, values)
            steep = slope(law, e, c, rest, laws, values)
            steep += brake_by_e(law, e, w, d, rest, laws, values)
            brisk = brake_slope(law, e, w, d, rest, laws, values)
            by_c = pull_by_c(law, e, c, rest, laws, values)
            by_d = brake_by_d(law, e, w, d, rest, laws, values)
            by_rest = pull_by_rest(law, e, c, rest, laws, values) - steep
            by_rest += brake_by_rest(law, e, w, d, rest, laws, values)
        # What the tension changes by for numbers alone.
        for m in range(count):
            part[m] = 0.0
        for z in range(seeds.stiffness_rows[k], seeds.stiffness_rows[k + 1]):
            part[seeds.stiffness_columns[z]] += by_c * seeds.stiffness[z]
        for z in range(seeds.damping_rows[k], seeds.damping_rows[k + 1]):
            part[seeds.damping_columns[z]] += by_d * seeds.damping[z]
        for z in range(seeds.rest_rows[k], seeds.rest_rows[k + 1]):
            part[seeds.rest_columns[z]] += by_rest * seeds.rest[z]
        if laws.curved:
            for b in range(constants.size):
                strength = by_constant(law, b, e, w, c, d, rest, laws, values)
                for z in range(seeds.constants_rows[b], seeds.constants_rows[b + 1]):
                    part[seeds.constants_columns[z]] += strength * seeds.constants[z]
        across = tension * inverse
        if length == 0.0 and rest == 0.0:
            across = steep  # in all directions alike
        # δT = (T' - g' w/L) n·δr + g'/L u·δr + g' n·δv with g' = ∂g/∂w
        l0 = steep * n0 + brisk * inverse * (u0 - w * n0)
        l1 = steep * n1 + brisk * inverse * (u1 - w * n1)
        l2 = steep * n2 + brisk * inverse * (u2 - w * n2)
        # One block of 3 x 3 for each of δr and δv.
        k00, k01, k02 = (
            n0 * l0 + across * (1.0 - n0 * n0),
            n0 * l1 - across * n0 * n1,
            n0 * l2 - across * n0 * n2,
        )
        k10, k11, k12 = (
            n1 * l0 - across * n1 * n0,
            n1 * l1 + across * (1.0 - n1 * n1),
            n1 * l2 - across * n1 * n2,
        )
        k20, k21, k22 = (
            n2 * l0 - across * n2 * n0,
            n2 * l1 - across * n2 * n1,
            n2 * l2 + across * (1.0 - n2 * n2),
        )
        b0, b1, b2 = brisk * n0, brisk * n1, brisk * n2
        for m in range(count):
            d0, d1, d2 = (
                tx[j, m] - tx[i, m],
                tx[j + 1, m] - tx[i + 1, m],
                tx[j + 2, m] - tx[i + 2, m],
            )
            more = part[m]
            more += b0 * (tv[j, m] - tv[i, m])
            more += b1 * (tv[j + 1, m] - tv[i + 1, m])
            more += b2 * (tv[j + 2, m] - tv[i + 2, m])
            f0 = k00 * d0 + k01 * d1 + k02 * d2 + n0 * more
            f1 = k10 * d0 + k11 * d1 + k12 * d2 + n1 * more
            f2 = k20 * d0 + k21 * d1 + k22 * d2 + n2 * more
            ta[i, m] += f0
            ta[i + 1, m] += f1
            ta[i + 2, m] += f2
            ta[j, m] -= f0
            ta[j + 1, m] -= f1
            ta[j + 2, m] -= f2
    for node in range(links.inverse.size):
        inverse = links.inverse[node]
        for i in range(3 * node, 3 * node + 3):
            for m in range(count):
                ta[i, m] = inverse * (ta[i, m] - links.drag[node] * tv[i, m])
            if inverse > 0.0:
                inner = inverse * (a[i] - links.steady[i])
                for z in range(seeds.mass_rows[node], seeds.mass_rows[node + 1]):
                    ta[i, seeds.mass_columns[z]] -= inner * seeds.mass[z]


def verlet_forward(
    laws: Laws,
    trail_x: Rows,
    trail_v: Rows,
    trail_a: Rows,
    h: float,
    way: Rows,
    speed: Rows,
    load: Rows,
    links: Links,
    values: Values,
) -> None:
    """Fill the rows of a trail behind the first one by velocity Verlet.

    Args:
        trail_x, trail_v, trail_a: States and accelerations, shape (row, 3 node).
        way: How far driven nodes go in each step [m], shape (row - 1, 3 driven).
        speed: Their velocities in each row [m/s], shape (row, 3 driven).
        load: Changing forces in each row [N], shape (row, 3 loaded).
    """
    half = 0.5 * h * h
    for row in range(trail_x.shape[0] - 1):
        x, v, a = trail_x[row], trail_v[row], trail_a[row]
        x_end, v_end, a_end = trail_x[row + 1], trail_v[row + 1], trail_a[row + 1]
        for node in range(links.inverse.size):
            for i in range(3 * node, 3 * node + 3):
                x_end[i], v_end[i] = x[i], 0.0
                if links.inverse[node] > 0.0:
                    x_end[i] = x[i] + h * v[i] + half * a[i]
                    v_end[i] = v[i] + h * a[i]
        for k in range(links.driven.size):
            i = 3 * links.driven[k]
            for axis in range(3):
                x_end[i + axis] = x[i + axis] + way[row, 3 * k + axis]
                v_end[i + axis] = speed[row + 1, 3 * k + axis]
        acceleration(laws, x_end, v_end, load[row + 1], links, values, a_end)
        for node in range(links.inverse.size):
            if links.inverse[node] > 0.0:
                for i in range(3 * node, 3 * node + 3):
                    v_end[i] = v[i] + 0.5 * h * (a[i] + a_end[i])


def verlet_back(
    laws: Laws,
    trail_x: Rows,
    trail_v: Rows,
    trail_a: Rows,
    h: float,
    links: Links,
    values: Values,
    at_x: Rows,
    at_v: Rows,
    lx: Floats,
    lv: Floats,
    la: Floats,
    guess: Floats,
    weight: Floats,
    by: Values,
) -> None:
    """Carry derivatives by the state of the last row of a trail back to its first row.

    Args:
        at_x, at_v: Derivatives that enter in each row, shape (row, 3 node); those of the first
            row are left for the caller.
        lx, lv, la: By the state and acceleration of the last row, then of the first one,
            shape (3 node,).
        guess, weight: Room, shape (3 node,).
        by: What is added to the derivatives by numbers.
    """
    half = 0.5 * h * h
    for row in range(trail_x.shape[0] - 2, -1, -1):
        v, a = trail_v[row], trail_a[row]
        x_end, v_end, a_end = trail_x[row + 1], trail_v[row + 1], trail_a[row + 1]
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for i in range(3 * node, 3 * node + 3):
                lx[i] += at_x[row + 1, i]
                lv[i] += at_v[row + 1, i]
                # What the force saw was the predicted velocity.
                guess[i] = v[i] + h * a[i] if free else v_end[i]
                if not free:
                    lv[i], la[i] = 0.0, 0.0
                weight[i] = la[i] + 0.5 * h * lv[i]
                # From here on, ``la`` holds what is due to the predicted velocity.
                la[i] = 0.0
        pull_back(laws, x_end, guess, a_end, weight, links, values, lx, la, by)
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for i in range(3 * node, 3 * node + 3):
                guessed = la[i]
                if free:
                    la[i] = half * lx[i] + h * guessed + 0.5 * h * lv[i]
                    lv[i] += h * lx[i] + guessed
                else:
                    la[i], lv[i] = 0.0, 0.0


def verlet_change(
    first: int,
    last: int,
    laws: Laws,
    trail_x: Rows,
    trail_v: Rows,
    trail_a: Rows,
    h: float,
    links: Links,
    values: Values,
    seeds: Seeds,
    guess: Floats,
    part: Floats,
    tx: Rows,
    tv: Rows,
    ta: Rows,
    predicted: Rows,
    ta_end: Rows,
) -> None:
    """Carry many changes of the state over the steps from one row of a trail to a later one.

    Args:
        first, last: The rows.
        guess: Room for the predicted velocity [m/s], shape (3 node,).
        tx, tv, ta: Changes, shape (3 node, change); set anew.
        predicted, ta_end: Room, shape (3 node, change).
    """
    count, half = part.size, 0.5 * h * h
    for row in range(first + 1, last + 1):
        x_end, a_end = trail_x[row], trail_a[row]
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for i in range(3 * node, 3 * node + 3):
                guess[i] = trail_v[row, i]
                if free:
                    guess[i] = trail_v[row - 1, i] + h * trail_a[row - 1, i]
                for m in range(count):
                    predicted[i, m] = 0.0
                    if free:
                        tx[i, m] += h * tv[i, m] + half * ta[i, m]
                        predicted[i, m] = tv[i, m] + h * ta[i, m]
        push_forward(
            laws, x_end, guess, a_end, tx, predicted, links, values, seeds, part, ta_end
        )
        for node in range(links.inverse.size):
            free = links.inverse[node] > 0.0
            for i in range(3 * node, 3 * node + 3):
                for m in range(count):
                    tv[i, m] = tv[i, m] + 0.5 * h * (ta[i, m] + ta_end[i, m]) if free else 0.0
                    ta[i, m] = ta_end[i, m]
