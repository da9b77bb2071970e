"""Contact as scalar loops; for the equations see ``tissuec.forces.contact``.

Each pair that touches has a row of ``met``. Rows of a node are in succession, those with one
surface, too. They are filled for each node by itself, in parts of the nodes if threads share
the loop, and then added to the forces in the order of nodes.

Shared arguments:
    k: Index of the node among those of the contact.
    i: Index of the node's first component in ``x``.
    pair: Index of the pair of node and shape.
    row: Index of the row of ``met``.
    start, stop: Rows of the node with one surface: from ``start`` up to before ``stop``.
    begin, end: All rows of the node: from ``begin`` up to before ``end``.
    factor: Pressure with damping divided by pressure without it, dimensionless.
    c0, c1, c2: Components of a couple [N m].
    t0, t1, t2: Components of a vector, in any unit.
    touches: Record of the contact; its fields give the shapes and units.
"""

from math import sqrt

from tissuec.geometry.nearest import CAPSULE, PLANE
from tissuec.kernels.records import ContactTable, Floats
from tissuec.kernels.thread_loops import UNDIVIDED

SHARPNESS = 8  # power of r with which a bristle slips
LARGEST = 2.0  # r that counts
LEAST = 1e-3  # part of the pressure at the depth of the layer, where contact begins
NEWTON = 100  # iterations for the length of a bristle; bisection alone needs about 50
FLAT = 1e-12  # part of its size to the sixth: a triangle that thin takes up no couples

# Columns of ``met``.
STEADY = 0  # pressure at rest, with the sign of the weight; with friction, then with damping
NORMAL = 1
WEIGHT = 4  # of the three points of a shape
LEVER = 7  # on a plane
GAP = 10  # distance of the node from the nearest point
RATE = 11  # velocity along the normal
SLIDE = 12  # velocity against the nearest point
BENDS = 15  # of the law that are passed, those of the depth times the weight
SHARE = 16  # of the couple of its surface
LOST = 17  # power that damping dissipates; in the first row, with that of friction
FORCE = 18  # on the node, and on the three points of the shape
COLUMNS = 30
# Columns of ``at``, behind the places of the coordinates of the node and of the three points.
PAIR, SURFACE, PLACES = 4, 5, 6

# Depth, normal, weights of the three points of a shape, and lever on a plane.
Meeting = tuple[float, float, float, float, float, float, float, float, float, float]
OUTSIDE = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def touch(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, touches: ContactTable
) -> None:
    """Add the forces of shapes to those on nodes, and the power of damping and friction.

    The rates of bristles are stored in ``touches.bent``. With a ``touches.lag``, velocities
    give bristles without their own rates in an implicit stage, and those are solved for.

    A table of a part of the nodes only fills their rows; the table after the last part adds all
    of them.
    """
    bends, row, part, parts = 0.0, 0, touches.part, touches.starts.size - 1
    start, stop = 0, touches.nodes.size
    if part == parts:
        for each in range(parts):
            begin = int(touches.first[touches.starts[each]])
            bends += add_up(begin, int(touches.stops[each]), f, power, touches)
        stop = 0
    elif part != UNDIVIDED:
        start, stop = int(touches.starts[part]), int(touches.starts[part + 1])
        row = int(touches.first[start])
    for k in range(start, stop):
        end = press_node(k, row, x, v, touches)
        if part == UNDIVIDED:
            bends += add_up(0, end, f, power, touches)
        else:
            row = end
    if 0 <= part < parts:
        touches.stops[part] = row
    else:
        count(round(bends), touches)


def add_up(begin: int, end: int, f: Floats, power: Floats, touches: ContactTable) -> float:
    """Add the forces and powers of rows; return the number of bends passed."""
    bends = 0.0
    for row in range(begin, end):
        met = touches.met[row]
        bends += met[BENDS]
        power[1] += met[LOST]
        for point in range(4):
            i, column = touches.at[row, point], FORCE + 3 * point
            f[i] += met[column]
            f[i + 1] += met[column + 1]
            f[i + 2] += met[column + 2]
    return bends


def count(bends: int, touches: ContactTable) -> None:
    """Add up the bends that are passed: points where the law of contact changes its formula.

    These are two depths, the speed of separation at which damping cancels the pressure, and the
    length from which on the force of a bristle no longer grows.
    """
    touches.bends[0] = bends
    touches.bends[1] = min(touches.bends[1], bends)
    touches.bends[2] = max(touches.bends[2], bends)


def press_node(k: int, begin: int, x: Floats, v: Floats, touches: ContactTable) -> int:
    """Fill the rows of a node, and set the rate of its bristle; return the end of the rows."""
    end = look(k, begin, x, v, touches)
    # Pressure with and without damping, its rate, and pressure times sliding velocity.
    total = rest = growth = u0 = u1 = u2 = 0.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        factor, (steady, closing, steeper) = 0.0, press_surface(k, start, stop, touches)
        if steady > 0.0:
            factor = max(1.0 + touches.damping * closing / steady, 0.0)
            touches.met[start, BENDS] += 1.0 if factor > 0.0 else 0.0
            total, rest, growth = total + factor * steady, rest + steady, growth + steeper
        else:
            for row in range(start, stop):
                touches.met[row, STEADY] = 0.0
        push_back(start, stop, factor, touches)
        if touches.memory.size:
            s0, s1, s2 = rub_past(start, stop, factor, x, v, touches)
            u0, u1, u2 = u0 + s0, u1 + s1, u2 + s2
        start = stop
    if touches.memory.size:
        rub(k, begin, end, total, rest, growth, u0, u1, u2, x, v, touches)
    return end


def end_of_surface(start: int, end: int, touches: ContactTable) -> int:
    """Return the index after the rows that have the same surface as the first of them."""
    stop, surface = start + 1, touches.at[start, SURFACE]
    while stop < end and touches.at[stop, SURFACE] == surface:
        stop += 1
    return stop


def shape_of(row: int, touches: ContactTable) -> int:
    """Return the index of the shape of a row."""
    return int(touches.shape[touches.at[row, PAIR]])


def look(k: int, begin: int, x: Floats, v: Floats, touches: ContactTable) -> int:
    """Set rows for the pairs of a node that touch, without forces; return their end."""
    row, i, stiffness = begin, 3 * touches.nodes[k], touches.stiffness[k]
    for pair in range(touches.first[k], touches.first[k + 1]):
        depth, n0, n1, n2, wa, wb, wc, l0, l1, l2 = meet(i, pair, x, touches)
        if depth <= 0.0:
            continue
        met, at, shape = touches.met[row], touches.at[row], touches.shape[pair]
        a, b, c = corners(shape, touches)
        at[0], at[1], at[2], at[3] = i, a, b, c
        at[PAIR], at[SURFACE] = pair, touches.surface[shape]
        met[BENDS] = touches.weight[pair] * (1.0 if depth < touches.layer else 2.0)
        met[STEADY] = touches.weight[pair] * press_at(depth, stiffness, touches.layer)
        met[NORMAL], met[NORMAL + 1], met[NORMAL + 2] = n0, n1, n2
        met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2] = wa, wb, wc
        met[LEVER], met[LEVER + 1], met[LEVER + 2] = l0, l1, l2
        met[GAP] = touches.radius[pair] - depth
        s0 = v[i] - wa * v[a] - wb * v[b] - wc * v[c]
        s1 = v[i + 1] - wa * v[a + 1] - wb * v[b + 1] - wc * v[c + 1]
        s2 = v[i + 2] - wa * v[a + 2] - wb * v[b + 2] - wc * v[c + 2]
        turning = l0 * (v[b] - v[a]) + l1 * (v[b + 1] - v[a + 1]) + l2 * (v[b + 2] - v[a + 2])
        s0, s1, s2 = s0 + turning * n0, s1 + turning * n1, s2 + turning * n2
        met[RATE] = s0 * n0 + s1 * n1 + s2 * n2
        met[SLIDE], met[SLIDE + 1], met[SLIDE + 2] = s0, s1, s2
        row += 1
    return row


def press_surface(
    k: int, start: int, stop: int, touches: ContactTable
) -> tuple[float, float, float]:
    """Return the pressure of a surface on a node, without damping.

    Returns:
        Its pressure [N], that times the rate of the depth [W], and its rate [N/s].
    """
    stiffness = touches.stiffness[k]
    steady = nearest_face = closing = steeper = 0.0
    for row in range(start, stop):
        met, pair = touches.met[row], touches.at[row, PAIR]
        depth = touches.radius[pair] - met[GAP]
        steep = stiffness * min(depth / touches.layer, 1.0)
        steady += met[STEADY]
        nearest_face = max(nearest_face, met[STEADY])
        closing -= met[STEADY] * met[RATE]
        steeper -= touches.weight[pair] * steep * met[RATE]
    return max(steady, nearest_face), closing, steeper


def push_back(start: int, stop: int, factor: float, touches: ContactTable) -> None:
    """Set the forces of the pressure of a surface, and the power that damping dissipates."""
    for row in range(start, stop):
        met = touches.met[row]
        pressure = factor * met[STEADY]
        met[LOST] = (met[STEADY] - pressure) * met[RATE]
        wa, wb, wc = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2]
        for axis in range(3):
            g, lever = pressure * met[NORMAL + axis], pressure * met[LEVER + axis]
            met[FORCE + axis] = g
            met[FORCE + 3 + axis] = -wa * g - lever
            met[FORCE + 6 + axis] = -wb * g + lever
            met[FORCE + 9 + axis] = -wc * g


def rub_past(
    start: int, stop: int, factor: float, x: Floats, v: Floats, touches: ContactTable
) -> tuple[float, float, float]:
    """Return the sum of pressures times velocities along a surface [W].

    Also sets how the faces of the surface share couples, and stores pressures with damping.
    """
    every = q0 = q1 = q2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        met[SHARE] = 0.0
        if met[STEADY] > 0.0:
            turns, o0, o1, o2 = spin(row, x, v, touches)
            if turns:
                met[SHARE] = met[STEADY]
                every += met[STEADY]
                q0, q1, q2 = q0 + met[STEADY] * o0, q1 + met[STEADY] * o1, q2 + met[STEADY] * o2
    if every > 0.0:
        q0, q1, q2 = q0 / every, q1 / every, q2 / every
    u0 = u1 = u2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        if every > 0.0:
            met[SHARE] /= every
        met[STEADY] *= factor
        n0, n1, n2, gap = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2], met[GAP]
        s0 = met[SLIDE] - gap * (q1 * n2 - q2 * n1)
        s1 = met[SLIDE + 1] - gap * (q2 * n0 - q0 * n2)
        s2 = met[SLIDE + 2] - gap * (q0 * n1 - q1 * n0)
        u0 += met[STEADY] * (s0 - met[RATE] * n0)
        u1 += met[STEADY] * (s1 - met[RATE] * n1)
        u2 += met[STEADY] * (s2 - met[RATE] * n2)
    return u0, u1, u2


def rub(
    k: int,
    begin: int,
    end: int,
    total: float,
    rest: float,
    growth: float,
    u0: float,
    u1: float,
    u2: float,
    x: Floats,
    v: Floats,
    touches: ContactTable,
) -> None:
    """Add friction to the forces and the power of the rows of a node.

    Args:
        total: Sum of the pressures on it [N].
        rest: The same without damping [N].
        growth: Rate of that [N/s].
        u0, u1, u2: Sum of pressures times velocities along the surfaces [W].
    """
    rate, memory, bent, lag = touches.rate, 3 * touches.memory[k], touches.bent, touches.lag[0]
    z0, z1, z2 = (
        float(v[memory] / rate), float(v[memory + 1] / rate), float(v[memory + 2] / rate)
    )  # fmt: skip
    if total <= 0.0:
        falls = -rate * rate / (1.0 + lag * rate)
        bent[k, 0], bent[k, 1], bent[k, 2] = falls * z0, falls * z1, falls * z2
        return
    u0, u1, u2 = u0 / total, u1 / total, u2 / total
    stiffness, half = touches.stiffness[k], 0.5 * touches.layer
    unbend = 0.5 * growth / (rest + LEAST * stiffness * half) * half / (rest / stiffness + half)
    reach = total / stiffness + half
    slips, slip = touches.friction * reach, 0.0
    if lag > 0.0:
        z0, z1, z2 = bristle_ahead(lag, z0, z1, z2, u0, u1, u2, unbend, slips)
    d0, d1, d2 = u0 - unbend * z0, u1 - unbend * z1, u2 - unbend * z2
    length = sqrt(z0 * z0 + z1 * z1 + z2 * z2)
    if length > 0.0:
        r = min(length / slips, LARGEST)
        slip = max(d0 * z0 + d1 * z1 + d2 * z2, 0.0) / (length * length) * r**SHARPNESS
    bent[k, 0] = rate * (d0 - slip * z0)
    bent[k, 1] = rate * (d1 - slip * z1)
    bent[k, 2] = rate * (d2 - slip * z2)
    bears = total / reach
    if length > slips:
        bears = touches.friction * total / length
        touches.met[begin, BENDS] += 1.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        drag_along(start, stop, bears / total, z0, z1, z2, x, touches)
        start = stop
    touches.met[begin, LOST] += bears * (z0 * u0 + z1 * u1 + z2 * u2)


def bristle_ahead(
    lag: float,
    b0: float,
    b1: float,
    b2: float,
    u0: float,
    u1: float,
    u2: float,
    unbend: float,
    slips: float,
) -> tuple[float, float, float]:
    """Return the bristle z = b + lag z' of an implicit stage [m].

    With the length L and the direction e of z, this is

        e (L (1 + lag g/2) + lag (L/l)^8 max(0, u·e - L g/2)) = b + lag u,

    so e is the direction of the right-hand side, and L is found by Newton's method within
    bounds that are halved where it leaves them. Without a solution, in a step much longer than
    the contact, the result is b, and the equations of the stage remain unsolved.

    Args:
        lag: Step size times coefficient of the implicit method [s].
        b0, b1, b2: b [m].
        u0, u1, u2: Sliding velocity u [m/s].
        unbend: g/2 [1/s].
        slips: Length l at which it slips [m].
    """
    w0, w1, w2, firm = b0 + lag * u0, b1 + lag * u1, b2 + lag * u2, 1.0 + lag * unbend
    size = sqrt(w0 * w0 + w1 * w1 + w2 * w2)
    if not (size > 0.0 and firm > 0.0):
        return b0, b1, b2
    pace = (u0 * w0 + u1 * w1 + u2 * w2) / size
    low, high = 0.0, size / firm
    length = min(high, slips)
    for _ in range(NEWTON):
        grip = min(length / slips, LARGEST) ** SHARPNESS
        slides = max(pace - unbend * length, 0.0)
        over = firm * length + lag * grip * slides - size
        low, high = (low, length) if over > 0.0 else (length, high)
        steep = firm
        if slides > 0.0:
            steep -= lag * grip * unbend
            if length < LARGEST * slips:
                steep += lag * SHARPNESS * grip / length * slides
        before = length
        length = length - over / steep if steep > 0.0 else high
        if not low < length < high:
            length = 0.5 * (low + high)
        if abs(length - before) <= 4e-16 * high:
            break
    part = length / size
    return part * w0, part * w1, part * w2


def drag_along(
    start: int,
    stop: int,
    bears: float,
    z0: float,
    z1: float,
    z2: float,
    x: Floats,
    touches: ContactTable,
) -> None:
    """Add the friction of a surface on a node: its force, its reaction and the couple of both.

    Args:
        bears: Force by pressure and length of the bristle [1/m].
        z0, z1, z2: The bristle [m].
    """
    c0 = c1 = c2 = 0.0
    for row in range(start, stop):
        met = touches.met[row]
        n0, n1, n2 = met[NORMAL], met[NORMAL + 1], met[NORMAL + 2]
        share, along = -bears * met[STEADY], z0 * n0 + z1 * n1 + z2 * n2
        r0, r1, r2 = (
            share * (z0 - along * n0),
            share * (z1 - along * n1),
            share * (z2 - along * n2),
        )
        wa, wb, wc, gap = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2], met[GAP]
        push(row, 0, r0, r1, r2, touches)
        push(row, 1, -wa * r0, -wa * r1, -wa * r2, touches)
        push(row, 2, -wb * r0, -wb * r1, -wb * r2, touches)
        push(row, 3, -wc * r0, -wc * r1, -wc * r2, touches)
        c0 -= gap * (n1 * r2 - n2 * r1)
        c1 -= gap * (n2 * r0 - n0 * r2)
        c2 -= gap * (n0 * r1 - n1 * r0)
    for row in range(start, stop):
        share = touches.met[row, SHARE]
        if share > 0.0:
            twist(row, share * c0, share * c1, share * c2, x, touches)


def arms(row: int, x: Floats, touches: ContactTable) -> tuple[float, ...]:
    """Return the vectors from the mean of the points of a face to each of them [m].

    The third one of a capsule is zero, because a capsule has two points.
    """
    a, b, c = points(row, touches)
    if touches.kind[shape_of(row, touches)] == CAPSULE:
        h0, h1, h2 = (
            0.5 * (x[b] - x[a]),
            0.5 * (x[b + 1] - x[a + 1]),
            0.5 * (x[b + 2] - x[a + 2]),
        )
        return -h0, -h1, -h2, h0, h1, h2, 0.0, 0.0, 0.0
    m0 = (x[a] + x[b] + x[c]) / 3.0
    m1 = (x[a + 1] + x[b + 1] + x[c + 1]) / 3.0
    m2 = (x[a + 2] + x[b + 2] + x[c + 2]) / 3.0
    return (
        x[a] - m0, x[a + 1] - m1, x[a + 2] - m2,
        x[b] - m0, x[b + 1] - m1, x[b + 2] - m2,
        x[c] - m0, x[c + 1] - m1, x[c + 2] - m2,
    )  # fmt: skip


def turned(
    row: int, t0: float, t1: float, t2: float, x: Floats, touches: ContactTable
) -> tuple[bool, float, float, float]:
    """Return whether a face can turn, and the inverse of its inertia times a vector.

    The inertia is that of unit masses on the corners [m²]. The inertia of a capsule about its
    own axis has no effect and is arbitrary.
    """
    kind = touches.kind[shape_of(row, touches)]
    if kind == PLANE:
        return False, 0.0, 0.0, 0.0
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = arms(row, x, touches)
    xx, yy, zz = (
        a0 * a0 + b0 * b0 + c0 * c0,
        a1 * a1 + b1 * b1 + c1 * c1,
        a2 * a2 + b2 * b2 + c2 * c2,
    )
    xy, xz, yz = (
        a0 * a1 + b0 * b1 + c0 * c1,
        a0 * a2 + b0 * b2 + c0 * c2,
        a1 * a2 + b1 * b2 + c1 * c2,
    )
    square = xx + yy + zz
    if kind == CAPSULE:
        if square <= 0.0:
            return False, 0.0, 0.0, 0.0
        # What is about the line adds nothing to a cross product with it.
        return True, t0 / square, t1 / square, t2 / square
    i00, i11, i22, i01, i02, i12 = yy + zz, xx + zz, xx + yy, -xy, -xz, -yz
    j00, j01, j02 = i11 * i22 - i12 * i12, i02 * i12 - i01 * i22, i01 * i12 - i02 * i11
    j11, j12, j22 = i00 * i22 - i02 * i02, i01 * i02 - i00 * i12, i00 * i11 - i01 * i01
    size = i00 * j00 + i01 * j01 + i02 * j02
    if size <= FLAT * square**3:
        return False, 0.0, 0.0, 0.0
    return (
        True,
        (j00 * t0 + j01 * t1 + j02 * t2) / size,
        (j01 * t0 + j11 * t1 + j12 * t2) / size,
        (j02 * t0 + j12 * t1 + j22 * t2) / size,
    )


def spin(
    row: int, x: Floats, v: Floats, touches: ContactTable
) -> tuple[bool, float, float, float]:
    """Return whether a face can turn, and the rotation that fits its points best [1/s].

    The fit is by least squares.
    """
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = arms(row, x, touches)
    a, b, c = points(row, touches)
    t0 = (
        a1 * v[a + 2]
        - a2 * v[a + 1]
        + b1 * v[b + 2]
        - b2 * v[b + 1]
        + c1 * v[c + 2]
        - c2 * v[c + 1]
    )
    t1 = a2 * v[a] - a0 * v[a + 2] + b2 * v[b] - b0 * v[b + 2] + c2 * v[c] - c0 * v[c + 2]
    t2 = a0 * v[a + 1] - a1 * v[a] + b0 * v[b + 1] - b1 * v[b] + c0 * v[c + 1] - c1 * v[c]
    return turned(row, t0, t1, t2, x, touches)


def twist(row: int, c0: float, c1: float, c2: float, x: Floats, touches: ContactTable) -> None:
    """Add the smallest forces on the points of a face that form a given couple [N]."""
    _, w0, w1, w2 = turned(row, c0, c1, c2, x, touches)
    a0, a1, a2, b0, b1, b2, g0, g1, g2 = arms(row, x, touches)
    push(row, 1, w1 * a2 - w2 * a1, w2 * a0 - w0 * a2, w0 * a1 - w1 * a0, touches)
    push(row, 2, w1 * b2 - w2 * b1, w2 * b0 - w0 * b2, w0 * b1 - w1 * b0, touches)
    push(row, 3, w1 * g2 - w2 * g1, w2 * g0 - w0 * g2, w0 * g1 - w1 * g0, touches)


def push(row: int, point: int, f0: float, f1: float, f2: float, touches: ContactTable) -> None:
    """Add a force to those of a row.

    Args:
        point: 0 for its node, 1 to 3 for a point of its shape.
        f0, f1, f2: Components of the force [N].
    """
    met, column = touches.met[row], FORCE + 3 * point
    met[column] += f0
    met[column + 1] += f1
    met[column + 2] += f2


def points(row: int, touches: ContactTable) -> tuple[int, int, int]:
    """Return where the coordinates of the points of the shape of a row begin."""
    return int(touches.at[row, 1]), int(touches.at[row, 2]), int(touches.at[row, 3])


def corners(shape: int, touches: ContactTable) -> tuple[int, int, int]:
    """Return where the coordinates of the points of a shape begin."""
    points = touches.points
    return 3 * points[shape, 0], 3 * points[shape, 1], 3 * points[shape, 2]


def press_at(depth: float, stiffness: float, layer: float) -> float:
    """Return the pressure at a depth, without damping [N].

    Args:
        depth: Depth of the node below the surface [m].
        stiffness: Stiffness of the contact [N/m].
        layer: Depth w below which the law is linear [m].
    """
    if depth < layer:
        return stiffness * depth * depth / (2.0 * layer)
    return stiffness * (depth - 0.5 * layer)


def meet(i: int, pair: int, x: Floats, touches: ContactTable) -> Meeting:
    """Return the place of a node in a shape; outside of it, only the depth is valid."""
    shape = touches.shape[pair]
    a, b, c = corners(shape, touches)
    d0, d1, d2 = float(x[b] - x[a]), float(x[b + 1] - x[a + 1]), float(x[b + 2] - x[a + 2])
    r0, r1, r2 = float(x[i] - x[a]), float(x[i + 1] - x[a + 1]), float(x[i + 2] - x[a + 2])
    square = d0 * d0 + d1 * d1 + d2 * d2
    along = r0 * d0 + r1 * d1 + r2 * d2
    kind = touches.kind[shape]
    if kind == PLANE:
        inverse = 1.0 / sqrt(square)
        n0, n1, n2 = d0 * inverse, d1 * inverse, d2 * inverse
        depth = -along * inverse
        l0, l1, l2 = r0 + depth * n0, r1 + depth * n1, r2 + depth * n2
        return depth, n0, n1, n2, 1.0, 0.0, 0.0, l0 * inverse, l1 * inverse, l2 * inverse
    wb, wc = 0.0, 0.0
    if kind == CAPSULE:
        wb = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
        r0, r1, r2 = r0 - wb * d0, r1 - wb * d1, r2 - wb * d2
    else:
        e0, e1, e2 = float(x[c] - x[a]), float(x[c + 1] - x[a + 1]), float(x[c + 2] - x[a + 2])
        mixed = d0 * e0 + d1 * e1 + d2 * e2
        wb, wc = nearest(
            square, mixed, e0 * e0 + e1 * e1 + e2 * e2, along, r0 * e0 + r1 * e1 + r2 * e2
        )
        r0 -= wb * d0 + wc * e0
        r1 -= wb * d1 + wc * e1
        r2 -= wb * d2 + wc * e2
    radius = float(touches.radius[pair])
    gap = r0 * r0 + r1 * r1 + r2 * r2
    if gap >= radius * radius:
        return OUTSIDE
    gap = sqrt(gap)
    inverse = 1.0 / gap if gap > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    return radius - gap, n0, n1, n2, 1.0 - wb - wc, wb, wc, 0.0, 0.0, 0.0


def nearest(bb: float, bc: float, cc: float, xb: float, xc: float) -> tuple[float, float]:
    """Return the weights of the second and third corner at the nearest point of a triangle.

    By the regions of C. Ericson, *Real-Time Collision Detection* (2005), 5.1.5. With b, c and x
    being the second corner, the third corner and the point as seen from the first corner:

    Args:
        bb: b·b [m²].
        bc: b·c [m²].
        cc: c·c [m²].
        xb: x·b [m²].
        xc: x·c [m²].
    """
    if xb <= 0.0 and xc <= 0.0:
        return 0.0, 0.0
    # The same as seen from the other two corners.
    xb_b, xc_b = xb - bb, xc - bc
    if xb_b >= 0.0 and xc_b <= xb_b:
        return 1.0, 0.0
    beside_c = xb * xc_b - xb_b * xc
    if beside_c <= 0.0 and xb >= 0.0 and xb_b <= 0.0:
        return xb / (xb - xb_b), 0.0
    xb_c, xc_c = xb - bc, xc - cc
    if xc_c >= 0.0 and xb_c <= xc_c:
        return 0.0, 1.0
    beside_b = xb_c * xc - xb * xc_c
    if beside_b <= 0.0 and xc >= 0.0 and xc_c <= 0.0:
        return 0.0, xc / (xc - xc_c)
    beside_a = xb_b * xc_c - xb_c * xc_b
    if beside_a <= 0.0 and xc_b - xb_b >= 0.0 and xb_c - xc_c >= 0.0:
        part = (xc_b - xb_b) / ((xc_b - xb_b) + (xb_c - xc_c))
        return 1.0 - part, part
    whole = 1.0 / (beside_a + beside_b + beside_c)
    return beside_b * whole, beside_c * whole
