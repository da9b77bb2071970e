"""Instruments on nodes, as scalar loops; what they do stands in ``tissuec.contact``."""

from math import sqrt

from tissuec.kernels.records import Floats, Touches

SHARPNESS = 8
LARGEST = 2.0
LEAST = 1e-3


def touch(x: Floats, v: Floats, f: Floats, touches: Touches) -> float:
    """Add the forces of shapes to those on nodes, set the rates of bristles.

    Returns:
        The power that damping and friction take out [W].
    """
    lost = 0.0
    for k in range(touches.nodes.size):
        i = 3 * touches.nodes[k]
        total = u0 = u1 = u2 = 0.0
        for shape in range(touches.radius.size):
            depth, n0, n1, n2, near, l0, l1, l2 = meet(i, shape, x, touches)
            if depth <= 0.0:
                continue
            s0, s1, s2, rate = slide(i, shape, v, n0, n1, n2, near, l0, l1, l2, touches)
            steady = press_at(depth, touches)
            pressure = steady * max(1.0 - touches.damping * rate, 0.0)
            lost += (steady - pressure) * rate
            f[i] += pressure * n0
            f[i + 1] += pressure * n1
            f[i + 2] += pressure * n2
            p, q = 3 * touches.points[shape, 0], 3 * touches.points[shape, 1]
            far = 1.0 - near
            f[p] -= pressure * (near * n0 + l0)
            f[p + 1] -= pressure * (near * n1 + l1)
            f[p + 2] -= pressure * (near * n2 + l2)
            f[q] -= pressure * (far * n0 - l0)
            f[q + 1] -= pressure * (far * n1 - l1)
            f[q + 2] -= pressure * (far * n2 - l2)
            total += pressure
            u0 += pressure * (s0 - rate * n0)
            u1 += pressure * (s1 - rate * n1)
            u2 += pressure * (s2 - rate * n2)
        if touches.memory.size:
            lost += rub(k, total, u0, u1, u2, x, v, f, touches)
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
    bend(k, w0 - slip * z0, w1 - slip * z1, w2 - slip * z2, touches)
    wish, limit = stiffness * length, touches.friction * total
    bears: float = stiffness * limit / wish if wish > limit else stiffness
    i, lost = 3 * touches.nodes[k], 0.0
    for shape in range(touches.radius.size):
        depth, n0, n1, n2, near, l0, l1, l2 = meet(i, shape, x, touches)
        if depth > 0.0:
            s0, s1, s2, closing = slide(i, shape, v, n0, n1, n2, near, l0, l1, l2, touches)
            pressure = press_at(depth, touches) * max(1.0 - touches.damping * closing, 0.0)
            share, along = -bears * pressure / total, z0 * n0 + z1 * n1 + z2 * n2
            r0, r1, r2 = (
                share * (z0 - along * n0),
                share * (z1 - along * n1),
                share * (z2 - along * n2),
            )
            f[i] += r0
            f[i + 1] += r1
            f[i + 2] += r2
            p, q = 3 * touches.points[shape, 0], 3 * touches.points[shape, 1]
            for c, part in ((p, near), (q, 1.0 - near)):
                f[c] -= part * r0
                f[c + 1] -= part * r1
                f[c + 2] -= part * r2
            lost -= r0 * s0 + r1 * s1 + r2 * s2
    return lost


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


def meet(
    i: int, shape: int, x: Floats, touches: Touches
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return depth, normal, weight of the first point, and lever on a plane.

    Where a node is outside, only the depth counts.
    """
    radius = float(touches.radius[shape])
    p, q = 3 * touches.points[shape, 0], 3 * touches.points[shape, 1]
    d0, d1, d2 = float(x[q] - x[p]), float(x[q + 1] - x[p + 1]), float(x[q + 2] - x[p + 2])
    r0, r1, r2 = float(x[i] - x[p]), float(x[i + 1] - x[p + 1]), float(x[i + 2] - x[p + 2])
    square = d0 * d0 + d1 * d1 + d2 * d2
    along = r0 * d0 + r1 * d1 + r2 * d2
    if radius < 0.0:
        inverse = 1.0 / sqrt(square)
        n0, n1, n2 = d0 * inverse, d1 * inverse, d2 * inverse
        depth = -along * inverse
        l0, l1, l2 = r0 + depth * n0, r1 + depth * n1, r2 + depth * n2
        return depth, n0, n1, n2, 1.0, l0 * inverse, l1 * inverse, l2 * inverse
    far = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    r0, r1, r2 = r0 - far * d0, r1 - far * d1, r2 - far * d2
    gap = r0 * r0 + r1 * r1 + r2 * r2
    if gap >= radius * radius:
        return -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    gap = sqrt(gap)
    inverse = 1.0 / gap if gap > 0.0 else 0.0
    n0, n1, n2 = r0 * inverse, r1 * inverse, r2 * inverse
    return radius - gap, n0, n1, n2, 1.0 - far, 0.0, 0.0, 0.0


def slide(
    i: int,
    shape: int,
    v: Floats,
    n0: float,
    n1: float,
    n2: float,
    near: float,
    l0: float,
    l1: float,
    l2: float,
    touches: Touches,
) -> tuple[float, float, float, float]:
    """Return the velocity against a surface, and its part along the normal [m/s]."""
    p, q = 3 * touches.points[shape, 0], 3 * touches.points[shape, 1]
    far = 1.0 - near
    s0 = float(v[i] - near * v[p] - far * v[q])
    s1 = float(v[i + 1] - near * v[p + 1] - far * v[q + 1])
    s2 = float(v[i + 2] - near * v[p + 2] - far * v[q + 2])
    turning = l0 * (v[q] - v[p]) + l1 * (v[q + 1] - v[p + 1]) + l2 * (v[q + 2] - v[p + 2])
    turning = float(turning)
    s0, s1, s2 = s0 + turning * n0, s1 + turning * n1, s2 + turning * n2
    return s0, s1, s2, s0 * n0 + s1 * n1 + s2 * n2
