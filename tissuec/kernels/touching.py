"""Shapes on nodes, as scalar loops; what they do stands in ``tissuec.contact``."""

from math import exp, sqrt

from tissuec.kernels.records import Floats, Touches

CAPSULE, PLANE = 0, 1
SHARPNESS = 8
LARGEST = 2.0
LEAST = 1e-3

# Depth, normal, weights of the three points of a shape, and lever on a plane.
Meeting = tuple[float, float, float, float, float, float, float, float, float, float]
OUTSIDE = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def touch(x: Floats, v: Floats, f: Floats, touches: Touches) -> float:
    """Add the forces of shapes to those on nodes, set the rates of bristles.

    Returns:
        The power that damping and friction take out [W].
    """
    lost, bends = 0.0, 0
    for k in range(touches.nodes.size):
        i = 3 * touches.nodes[k]
        total = u0 = u1 = u2 = 0.0
        for pair in range(touches.first[k], touches.first[k + 1]):
            shape = touches.shape[pair]
            depth, n0, n1, n2, wa, wb, wc, l0, l1, l2 = meet(i, shape, x, touches)
            if depth <= 0.0:
                continue
            bends += 1 if depth < touches.layer else 2
            s0, s1, s2, rate = slide(i, shape, v, n0, n1, n2, wa, wb, wc, l0, l1, l2, touches)
            steady = press_at(depth, touches)
            pressure = steady * max(1.0 - touches.damping * rate, 0.0)
            lost += (steady - pressure) * rate
            push(i, f, pressure * n0, pressure * n1, pressure * n2)
            g0, g1, g2 = -pressure * n0, -pressure * n1, -pressure * n2
            a, b, c = corners(shape, touches)
            l0, l1, l2 = pressure * l0, pressure * l1, pressure * l2
            push(a, f, wa * g0 - l0, wa * g1 - l1, wa * g2 - l2)
            push(b, f, wb * g0 + l0, wb * g1 + l1, wb * g2 + l2)
            push(c, f, wc * g0, wc * g1, wc * g2)
            total += pressure
            u0 += pressure * (s0 - rate * n0)
            u1 += pressure * (s1 - rate * n1)
            u2 += pressure * (s2 - rate * n2)
        if touches.memory.size:
            lost += rub(k, total, u0, u1, u2, x, v, f, touches)
    count(bends, touches)
    return lost


def rub(
    k: int,
    total: float,
    u0: float,
    u1: float,
    u2: float,
    x: Floats,
    v: Floats,
    f: Floats,
    touches: Touches,
) -> float:
    """Add the friction on a node and what answers it; return the power that it takes out [W].

    Args:
        k: Number of the node among those of the contact.
        total: Sum of the pressures on it [N].
        u0, u1, u2: Sum of pressures times velocities along the surfaces.
    """
    rate, stiffness, memory = touches.rate, touches.stiffness, 3 * touches.memory[k]
    z0, z1, z2 = float(v[memory]), float(v[memory + 1]), float(v[memory + 2])
    z0, z1, z2 = z0 / rate, z1 / rate, z2 / rate
    if total <= 0.0:
        bend(k, -rate * z0, -rate * z1, -rate * z2, touches)
        return 0.0
    w0, w1, w2 = u0 / total, u1 / total, u2 / total
    length = sqrt(z0 * z0 + z1 * z1 + z2 * z2)
    slip = 0.0
    if length > 0.0:
        least = LEAST * touches.friction * stiffness * touches.layer
        r = min(stiffness * length / (touches.friction * total + least), LARGEST)
        forward = max(w0 * z0 + w1 * z1 + w2 * z2, 0.0) / (length * length)
        slip = forward * r**SHARPNESS
    up = exp(-total / (LEAST * stiffness * touches.layer))
    fall = up * rate
    w0 = (1.0 - up) * (w0 - slip * z0) - fall * z0
    w1 = (1.0 - up) * (w1 - slip * z1) - fall * z1
    w2 = (1.0 - up) * (w2 - slip * z2) - fall * z2
    bend(k, w0, w1, w2, touches)
    wish, limit = stiffness * length, touches.friction * total
    bears: float = stiffness * limit / wish if wish > limit else stiffness
    i, lost = 3 * touches.nodes[k], 0.0
    for pair in range(touches.first[k], touches.first[k + 1]):
        shape = touches.shape[pair]
        depth, n0, n1, n2, wa, wb, wc, l0, l1, l2 = meet(i, shape, x, touches)
        if depth > 0.0:
            s0, s1, s2, closing = slide(
                i, shape, v, n0, n1, n2, wa, wb, wc, l0, l1, l2, touches
            )
            pressure = press_at(depth, touches) * max(1.0 - touches.damping * closing, 0.0)
            share, along = -bears * pressure / total, z0 * n0 + z1 * n1 + z2 * n2
            r0, r1, r2 = z0 - along * n0, z1 - along * n1, z2 - along * n2
            r0, r1, r2 = share * r0, share * r1, share * r2
            push(i, f, r0, r1, r2)
            a, b, c = corners(shape, touches)
            push(a, f, -wa * r0, -wa * r1, -wa * r2)
            push(b, f, -wb * r0, -wb * r1, -wb * r2)
            push(c, f, -wc * r0, -wc * r1, -wc * r2)
            lost -= r0 * s0 + r1 * s1 + r2 * s2
    return lost


def count(bends: int, touches: Touches) -> None:
    """Remember how many bends of their law all pressures together have passed."""
    touches.bends[0] = bends
    touches.bends[1] = min(touches.bends[1], bends)
    touches.bends[2] = max(touches.bends[2], bends)


def push(i: int, f: Floats, f0: float, f1: float, f2: float) -> None:
    """Add a force."""
    f[i] += f0
    f[i + 1] += f1
    f[i + 2] += f2


def corners(shape: int, touches: Touches) -> tuple[int, int, int]:
    """Return where the coordinates of the points of a shape begin."""
    points = touches.points
    return 3 * points[shape, 0], 3 * points[shape, 1], 3 * points[shape, 2]


def bend(k: int, z0: float, z1: float, z2: float, touches: Touches) -> None:
    """Remember how fast a bristle bends [m/s]."""
    touches.bent[k, 0] = touches.rate * z0
    touches.bent[k, 1] = touches.rate * z1
    touches.bent[k, 2] = touches.rate * z2


def press_at(depth: float, touches: Touches) -> float:
    """Return the pressure at a depth at rest [N]."""
    layer = touches.layer
    if depth < layer:
        return touches.stiffness * depth * depth / (2.0 * layer)
    return touches.stiffness * (depth - 0.5 * layer)


def meet(i: int, shape: int, x: Floats, touches: Touches) -> Meeting:
    """Return where a node is in a shape; outside, only the depth counts."""
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
    radius = float(touches.radius[shape])
    gap = r0 * r0 + r1 * r1 + r2 * r2
    if gap >= radius * radius:
        return OUTSIDE
    gap = sqrt(gap)
    inverse = 1.0 / gap if gap > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    return radius - gap, n0, n1, n2, 1.0 - wb - wc, wb, wc, 0.0, 0.0, 0.0


def nearest(bb: float, bc: float, cc: float, xb: float, xc: float) -> tuple[float, float]:
    """Return the weights of the second and third corner in the nearest point of a triangle.

    With the corners seen from the first one: b·b, b·c, c·c, x·b and x·c. By the regions of
    C. Ericson, Real-Time Collision Detection (2005), 5.1.5.
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


def slide(
    i: int,
    shape: int,
    v: Floats,
    n0: float,
    n1: float,
    n2: float,
    wa: float,
    wb: float,
    wc: float,
    l0: float,
    l1: float,
    l2: float,
    touches: Touches,
) -> tuple[float, float, float, float]:
    """Return the velocity against a surface, and its part along the normal [m/s]."""
    a, b, c = corners(shape, touches)
    s0 = float(v[i] - wa * v[a] - wb * v[b] - wc * v[c])
    s1 = float(v[i + 1] - wa * v[a + 1] - wb * v[b + 1] - wc * v[c + 1])
    s2 = float(v[i + 2] - wa * v[a + 2] - wb * v[b + 2] - wc * v[c + 2])
    turning = l0 * (v[b] - v[a]) + l1 * (v[b + 1] - v[a + 1]) + l2 * (v[b + 2] - v[a + 2])
    turning = float(turning)
    s0, s1, s2 = s0 + turning * n0, s1 + turning * n1, s2 + turning * n2
    return s0, s1, s2, s0 * n0 + s1 * n1 + s2 * n2
