"""Where a node is in a shape, as scalar loops: the same as ``tissuec.geometry.nearest``.

Shared arguments:
    i: Index of the node's first component in ``x``.
    pair: Index of the pair of node and shape.
    touches: Record of the contact; its fields give the shapes and units.
"""

from math import sqrt

from tissuec.geometry.nearest import CAPSULE, PLANE
from tissuec.kernels.records import ContactTable, Floats

# Depth, normal, weights of the three points of a shape, and lever on a plane.
Meeting = tuple[float, float, float, float, float, float, float, float, float, float]
OUTSIDE = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


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


def corners(shape: int, touches: ContactTable) -> tuple[int, int, int]:
    """Return where the coordinates of the points of a shape begin."""
    points = touches.points
    return 3 * points[shape, 0], 3 * points[shape, 1], 3 * points[shape, 2]


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
